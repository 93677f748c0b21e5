# SPDX-License-Identifier: GPL-3.0-or-later
"""A live preview of the imprint of this frame: whenever settings or what presses change, the dent is made on a copy of
the detail and shown in the result. The document, the object and Blender's undo know nothing of it; what is worked on is
cancelled by the next change.
"""

import uuid

import bpy
import librelievo as rl
from bpy.app.handlers import persistent

from ..core import job, lengths, settings
from ..core.error import Refused, said
from ..data import mesh, state, view
from . import imprint, presser

# How often the main thread looks after the preview, seconds.
PERIOD = 0.02

_preview = None


class Preview:
    """What is previewed, and how far that is."""

    def __init__(self, target, pressers):
        self.target, self.pressers = target.name, [other.name for other in pressers]
        self.clone = self.revision = self.worker = self.message = None
        self.is_wanted, self.is_paused = True, False
        # Results that were shown since the start.
        self.shown = 0

    def steps(self, context):
        """Makes the dent and shows it."""
        target = bpy.data.objects.get(self.target)
        pressers = [bpy.data.objects[name] for name in self.pressers if name in bpy.data.objects]
        if not state.is_used(target) or not pressers:
            raise Refused("What the preview is of was deleted")
        made = yield from state.opening(target)
        if self.clone is None or self.revision != made.revision:
            box = []
            yield 0.0, 0.1, lambda _progress: box.append(made.data())
            self.release()
            clone = state.State(target, f"preview-{uuid.uuid4().hex}", box[0])
            try:
                yield 0.1, 0.5, clone.build
            except BaseException:
                clone.release()
                raise
            self.clone, self.revision = clone, made.revision
        clone = self.clone
        depsgraph = context.evaluated_depsgraph_get()
        colliders = [imprint.Presser(other, depsgraph) for other in pressers]
        options = [presser.settings_of(context, target, other) for other in pressers]
        frame = max(context.scene.frame_current, 0)
        place = mesh.matrix_of(target.evaluated_get(depsgraph).matrix_world)
        pose = state.posed_points(target, depsgraph)
        cells = settings.cells_of(target, clone.detail.info.tile_count)

        def work(progress):
            clone.detail.set_transform(place)
            clone.set_pose(pose)
            clone.document.begin("preview")
            try:
                for index, collider in enumerate(colliders):
                    collider.press(clone.detail, options[index], {"pair": index, "frame": frame}, progress)
                clone.detail.commit()
                view.follow(clone, cells)
            finally:
                clone.abandon()

        yield 0.5, 1.0, work
        result = target.relievo.result
        if state.is_used(result):
            result.relievo.is_preview = True
            view.write(target, clone)
            self.shown += 1

    def turn(self, context, patience=0.0):
        """Goes on; says whether there is more to do."""
        if self.is_paused or job.is_busy() or (self.worker is None and self.is_edited()):
            return True
        try:
            if self.worker is None:
                if not self.is_wanted:
                    return False
                self.is_wanted, self.message = False, None
                self.worker = job.Worker(self.steps(context))
            if self.worker.advance(patience):
                self.worker = None
        except (Refused, rl.RelievoError, OSError) as failure:
            cancelled, self.worker = self.worker.is_cancelled, None
            if not cancelled:
                self.message = said(failure)
        return self.worker is not None or self.is_wanted

    def is_edited(self):
        """Whether a stroke is being drawn."""
        target = bpy.data.objects.get(self.target)
        made = state.existing(target) if target is not None else None
        return made is not None and bool(made.document.info.is_open)

    def touch(self):
        """Something changed: what is worked on is not wanted any more."""
        self.is_wanted = True
        if self.worker is not None:
            self.worker.is_cancelled = True
        if not bpy.app.background and not bpy.app.timers.is_registered(_tick):
            bpy.app.timers.register(_tick, first_interval=PERIOD)

    def release(self):
        if self.clone is not None:
            self.clone.release()
            self.clone = None

    def end(self):
        if self.worker is not None:
            self.worker.stop()
            self.worker = None
        self.release()


def _tick():
    """What Blender's timer calls."""
    if _preview is None:
        return None
    going_on = _preview.turn(bpy.context)
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
    return PERIOD if going_on else None


def current():
    """The preview that runs, or None."""
    return _preview


def restore(target):
    """Shows what is there again."""
    result = target.relievo.result
    if state.is_used(result) and result.relievo.is_preview:
        result.relievo.is_preview = False
        made = state.existing(target)
        if made is not None and made.positions is not None:
            view.refresh(target, made)


def interrupt():
    """Stops what is worked on; it begins anew when there is time."""
    if _preview is not None and _preview.worker is not None:
        _preview.worker.stop()
        _preview.worker, _preview.is_wanted = None, True


def end():
    """Ends the preview and shows what is there."""
    global _preview
    ended, _preview = _preview, None
    if ended is not None:
        ended.end()
        target = bpy.data.objects.get(ended.target)
        if target is not None:
            restore(target)


def pause():
    """Before a file is saved, which must hold what is there."""
    if _preview is not None:
        interrupt()
        _preview.is_paused = True
        target = bpy.data.objects.get(_preview.target)
        if target is not None:
            restore(target)


def resume():
    if _preview is not None:
        _preview.is_paused = False
        _preview.touch()


def undone():
    """After undo, redo and loading: a step of undo may hold what was shown by a preview."""
    if _preview is not None:
        _preview.touch()
        return
    for target in bpy.data.objects:
        restore(target)


@persistent
def frame_changed(*_):
    if _preview is not None:
        _preview.touch()


@persistent
def graph_updated(_scene, depsgraph):
    if _preview is None or _preview.is_paused:
        return
    watched = {_preview.target, *_preview.pressers}
    for update in depsgraph.updates:
        found = update.id
        if isinstance(found, bpy.types.Object) and found.name in watched:
            _preview.touch()
            return


def settings_changed(_group, _context):
    if _preview is not None:
        _preview.touch()


class RELIEVO_OT_preview(job.Steps, bpy.types.Operator):
    """Show what the selected objects would dent into the active one at this frame, while they are moved and settings are
    changed; press again to end"""

    bl_idname = "relievo.preview"
    bl_label = "Live preview"
    bl_options = {"REGISTER", "UNDO"}

    failures = (Refused, rl.RelievoError, OSError)

    @classmethod
    def poll(cls, context):
        return _preview is not None or state.is_editable(context)

    def steps(self, context):
        global _preview
        if _preview is not None:
            end()
            return
        target = state.source_of(context.active_object)
        pressers = presser.check(context, target)
        made = yield from state.opening(target)
        self.warn(made.take_notes())
        lengths.follow(context.scene, target)
        yield from state.placing(made, target, context.evaluated_depsgraph_get())
        yield from view.ensuring(target, made)
        made.record(target)
        _preview = Preview(target, pressers)
        _preview.touch()


def register():
    bpy.utils.register_class(RELIEVO_OT_preview)
    job.interrupts.append(interrupt)
    settings.listeners["imprint"].append(settings_changed)


def unregister():
    end()
    settings.listeners["imprint"].remove(settings_changed)
    job.interrupts.remove(interrupt)
    bpy.utils.unregister_class(RELIEVO_OT_preview)
