# SPDX-License-Identifier: GPL-3.0-or-later
"""Hooks: other objects, mostly empties, that move regions of a level as they move and turn themselves. However many there
are, they are one edit, which comes after all others, at the level that was shown when the first was made; where they are
keyframed, rigged or simulated all levels are animated. A hook that holds keeps its region where it is.

Levels follow at every change of the frame, and where a hook is moved in between. As with playback, a render from a window
needs its interface locked.
"""

import json

import bpy
from bpy.app.handlers import persistent

from ..core import job
from ..core.error import Refused, said
from ..data import playback, pose, progressive
from . import levels


def _hooked(scene):
    """Objects whose levels have hooks."""
    return [
        target
        for target in scene.objects
        if target.type == "MESH" and target.library is None and len(target.relievo.progressive.hooks)
    ]


def follow(target, graph=None, is_sure=False):
    """Brings the mesh of an object to where its hooks are, if they have moved; with `is_sure` even if they have not."""
    if not progressive.is_there(target):
        return
    try:
        if is_sure or not progressive.is_shown(target, graph):
            job.run(progressive.showing(target, graph))
            progressive.tell(target, "")
    except progressive.FAILURES as failure:
        progressive.tell(target, said(failure))


@persistent
def frame_changed(scene, graph=None):
    if playback.may_write(scene):
        for target in _hooked(scene):
            follow(target, graph)


@persistent
def graph_updated(scene, graph=None):
    """Follows hooks that are moved by hand."""
    if graph is None or job.is_busy() or not playback.may_write(scene):
        return
    moved = {update.id.original for update in graph.updates if update.is_updated_transform}
    # Most updates move nothing, and scenes may have many objects.
    for target in _hooked(scene) if moved else ():
        if any(hook.target in moved for hook in target.relievo.progressive.hooks):
            follow(target, graph)


@persistent
def undone(*_):
    # Undo brings back places of hooks and the mesh, but not always those of one time.
    for target in _hooked(bpy.context.scene):
        follow(target, is_sure=True)


class RELIEVO_OT_levels_hook(levels.OnLevels, bpy.types.Operator):
    """Let the other selected objects move the regions around them, as they move and turn themselves; where they are
    keyframed, all levels of the active object are animated"""

    bl_idname = "relievo.levels_hook"
    bl_label = "Hook to selected"

    radius: bpy.props.FloatProperty(
        name="Radius",
        description="How far the regions reach, object units; 0 for the radius of the handle",
        min=0,
        default=0,
        precision=4,
    )
    is_held: bpy.props.BoolProperty(name="Hold", description="Keep the regions where they are")

    def execute(self, context):
        target = context.active_object
        options, handle = target.relievo.progressive, context.scene.relievo.handle
        try:
            progressive.check(target)
            others = [other for other in context.selected_objects if other != target]
            if not others:
                raise Refused("Select the objects that are to be hooks as well, and the object with levels last")
            places = [pose.placed(target, other) for other in others]
        except progressive.FAILURES as failure:
            self.report({"ERROR"}, said(failure))
            return {"CANCELLED"}
        if not len(options.hooks):
            options.hooked_at = json.dumps(progressive.measure_of(options))
        for other, place in zip(others, places):
            hook = options.hooks.add()
            hook.target, hook.is_held = other, self.is_held
            hook.radius, hook.falloff = self.radius or handle.radius, handle.falloff
            hook.rest = [value for row in place for value in row]
        options.format = progressive.FORMAT
        return {"FINISHED"}


class RELIEVO_OT_levels_unhook(levels.OnLevels, job.Steps, bpy.types.Operator):
    """Release all hooks of the active object"""

    bl_idname = "relievo.levels_unhook"
    bl_label = "Release hooks"

    keep: bpy.props.EnumProperty(
        name="Keep",
        items=[
            ("SHAPE", "Shape", "What hooks have moved stays there, as an edit"),
            ("REST", "Rest", "What hooks have moved goes back"),
        ],
    )

    @classmethod
    def poll(cls, context):
        return super().poll(context) and len(context.active_object.relievo.progressive.hooks) > 0

    def steps(self, context):
        target = context.active_object
        progressive.check(target)
        made = progressive.posed(target)
        if self.keep == "SHAPE" and made is not None:
            progressive.keep(target, made)
        target.relievo.progressive.hooks.clear()
        yield from progressive.showing(target)


CLASSES = [RELIEVO_OT_levels_hook, RELIEVO_OT_levels_unhook]
PLACES = [
    ("undo_post", undone),
    ("redo_post", undone),
    ("frame_change_post", frame_changed),
    ("depsgraph_update_post", graph_updated),
]


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    for name, function in PLACES:
        getattr(bpy.app.handlers, name).append(function)


def unregister():
    for name, function in PLACES:
        getattr(bpy.app.handlers, name).remove(function)
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
