# SPDX-License-Identifier: GPL-3.0-or-later
"""Painting and sculpting: a stroke per press of the button, with pressure and symmetry; each is one edit, one step of
undo, and kept in the file with its points."""

import json
import threading
import time

import bpy
import librelievo as rl
import numpy
from bpy_extras import view3d_utils

from ..core import job, lengths, settings
from ..core.error import Refused, said
from ..data import state, stroke, view
from . import ring


def brush_of(scene, action, effect):
    """The brush that the scene's settings say, and what a stroke keeps of it with the pixels of its stamp."""
    kept, pixels = stroke.describe(scene, action, effect)
    return stroke.brush(kept, pixels), (kept, pixels)


def active_layer(made, kept):
    """The name of the layer that a stroke goes to; vector displacement has none."""
    if stroke.bends(kept):
        return None
    kind = rl.abi.RlvLayerKind.COLOR if kept["options"]["action"] == "paint" else rl.abi.RlvLayerKind.DISPLACEMENT
    return next((layer.name for layer in made.detail.layers if layer.kind == kind and layer.is_active), None)


def opening(context, target, action, effect="NORMAL"):
    """Steps that make the state of an object, in its place and pose, with what the brush needs; they return it."""
    made = yield from state.opening(target)
    lengths.follow(context.scene, target)
    yield from state.placing(made, target, context.evaluated_depsgraph_get())
    if action == "SCULPT" and stroke.mode_of(context.scene, action, effect) in stroke.BENDING:
        yield 0.0, 0.0, lambda _progress: made.add_vectors()
    return made


def preparing(context, target, action, effect="NORMAL"):
    """The same with all that a pointer needs to draw."""
    made = yield from opening(context, target, action, effect)
    yield from view.ensuring(target, made)
    yield 0.8, 1.0, lambda _progress: made.pick()
    made.record(target)
    return made


class Pointer:
    """Where the pointer was at an event, and how hard it was pressed."""

    def __init__(self, event, start):
        self.place = event.mouse_region_x, event.mouse_region_y
        self.pressure = event.pressure if event.is_tablet else 1.0
        self.time = time.perf_counter() - start


class RELIEVO_OT_stroke(job.Steps, bpy.types.Operator):
    """Draw a stroke on the active object"""

    bl_idname = "relievo.stroke"
    bl_label = "Relievo stroke"
    # The tools draw it.
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    action: bpy.props.EnumProperty(
        name="Action",
        description="What the stroke does",
        items=[("PAINT", "Paint", "Paint colours"), ("SCULPT", "Sculpt", "Sculpt relief")],
    )
    effect: bpy.props.EnumProperty(
        name="Effect", description="What Ctrl and Shift make of the brush", items=stroke.EFFECTS, options={"SKIP_SAVE"}
    )
    points: bpy.props.StringProperty(
        name="Points",
        description="JSON list of points: x, y, z in the world, pressure, seconds",
        options={"HIDDEN", "SKIP_SAVE"},
    )

    failures = (Refused, rl.RelievoError, OSError)
    # Whether the pointer draws it.
    is_drawn = False

    @classmethod
    def poll(cls, context):
        return state.is_editable(context)

    def begin(self, context, made, target):
        """What every stroke starts with. Returns the brush."""
        self.target, self.drawn = target, []
        if self.action == "PAINT":
            view.reveal_paint(context)
        brush, (self.kept, self.pixels) = brush_of(context.scene, self.action, self.effect)
        self.kept["matrix"] = state.world(target).tolist()
        self.kept["layer"], self.kept["layers"] = active_layer(made, self.kept), state.layers_of(made.detail)
        return brush

    def keep(self, made):
        # What the panel of the last operation makes the stroke again with.
        self.points = json.dumps(self.drawn)
        made.record(self.target)
        pose = None if numpy.array_equal(made.pose, made.rest) else made.pose
        stroke.keep(self.target, self.kept, self.pixels, pose, self.drawn, made.revision)

    def steps(self, context):
        """The whole stroke at once."""
        try:
            points = rl.stroke.points_of(json.loads(self.points))
        except (ValueError, rl.RelievoError):
            raise Refused("The points are not a list of x, y, z, pressure and time") from None
        target = state.source_of(context.active_object)
        made = yield from opening(context, target, self.action, self.effect)
        self.warn(made.take_notes())
        brush = self.begin(context, made, target)
        text = json.dumps(self.kept)

        def draw(_progress):
            with made.edit(text):
                rl.stroke.run(made.detail, brush, points)

        yield 0.3, 0.8, draw
        self.drawn = points.tolist()
        self.keep(made)
        yield from view.ensuring(target, made)
        self.warn(made.take_notes())

    def invoke(self, context, event):
        if self.points or context.region_data is None:
            return super().invoke(context, event)
        if job.is_busy():
            return {"CANCELLED"}
        job.interrupt()
        self.is_drawn = True
        self.target, self.stroke, self.is_released = state.source_of(context.active_object), None, False
        self.start = time.perf_counter()
        self.pending = [Pointer(event, self.start)]
        self.work = job.Worker(preparing(context, self.target, self.action, self.effect))
        # A large mesh is prepared on a thread; the pointer goes on meanwhile.
        answer = self.wait(context, job.FRAME)
        if answer == {"RUNNING_MODAL"}:
            if self.stroke is None:
                job.working.append(self.work)
                self._timer = context.window_manager.event_timer_add(0.02, window=context.window)
            context.window_manager.modal_handler_add(self)
        return answer

    def wait(self, context, patience=0.0):
        """Goes on with what is prepared, and begins the stroke when that is done."""
        try:
            if not self.work.advance(patience):
                return {"RUNNING_MODAL"}
            self.end_wait(context)
            if self.work.is_cancelled:
                return {"CANCELLED"}
            made = self.work.value
            self.warn(made.take_notes())
            brush = self.begin(context, made, self.target)
            made.document.begin(json.dumps(self.kept))
            self.state, self.caster = made, made.pick()
            self.world = state.world(self.target)
            self.inverse = numpy.linalg.inv(self.world)
            self.stroke = rl.Stroke(made.detail, brush)
        except self.failures as failure:
            self.end_wait(context)
            self.report({"ERROR"}, said(failure))
            return {"CANCELLED"}
        try:
            for pointer in self.pending:
                self.extend(context, pointer)
        except rl.RelievoError as failure:
            return self.cancelled(failure)
        return self.release() if self.is_released else {"RUNNING_MODAL"}

    def end_wait(self, context):
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        if self.work in job.working:
            job.working.remove(self.work)

    def modal(self, context, event):
        if not self.is_drawn:
            return super().modal(context, event)
        is_release = event.type == "LEFTMOUSE" and event.value == "RELEASE"
        is_move = event.type in {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE"}
        if self.stroke is None:
            if event.type in {"ESC", "RIGHTMOUSE"}:
                self.work.is_cancelled = True
            elif is_move and not self.is_released:
                self.pending.append(Pointer(event, self.start))
            self.is_released = self.is_released or is_release
            return self.wait(context) if event.type == "TIMER" else {"RUNNING_MODAL"}
        if is_move:
            try:
                self.extend(context, Pointer(event, self.start))
            except rl.RelievoError as failure:
                return self.cancelled(failure)
            context.area.tag_redraw()
            return {"RUNNING_MODAL"}
        if is_release:
            return self.release()
        if event.type in {"ESC", "RIGHTMOUSE"}:
            return self.cancelled(None)
        return {"RUNNING_MODAL"}

    def release(self):
        """Ends the stroke."""
        try:
            if not self.drawn:
                return self.cancelled(None)
            self.stroke.end()
            self.stroke.release()
            self.state.end()
        except rl.RelievoError as failure:
            return self.cancelled(failure)
        try:
            self.keep(self.state)
        except OSError as failure:
            # The object has not got the stroke, and the detail follows the object.
            self.state.follow(self.target.relievo.revision)
            view.refresh(self.target, self.state)
            self.report({"ERROR"}, said(failure))
            return {"CANCELLED"}
        view.refresh(self.target, self.state)
        self.warn(self.state.take_notes())
        # The next press meets the surface as it is now.
        threading.Thread(target=self.state.try_pick, daemon=True).start()
        return {"FINISHED"}

    def cancel(self, context):
        """Blender ends it, say because the window closes."""
        if not self.is_drawn:
            super().cancel(context)
        elif self.stroke is None:
            self.work.stop()
            self.end_wait(context)
        else:
            self.cancelled(None)

    def cancelled(self, failure):
        self.stroke.release()
        self.state.abandon()
        view.refresh(self.target, self.state)
        if failure is not None:
            self.report({"ERROR"}, said(failure))
        return {"CANCELLED"}

    def extend(self, context, pointer):
        """Goes on to where the pointer is, if that is on the surface."""
        region, view3d = context.region, context.region_data
        origin = view3d_utils.region_2d_to_origin_3d(region, view3d, pointer.place)
        direction = view3d_utils.region_2d_to_vector_3d(region, view3d, pointer.place)
        point = self.meet(origin, direction)
        if point is None:
            return
        row = [*point, pointer.pressure, pointer.time]
        self.stroke.extend([row])
        self.drawn.append(row)
        self.state.detail.commit()
        view.refresh(self.target, self.state)

    def meet(self, origin, direction):
        """Where a ray of the world meets the surface, in the world, or None."""
        start = (self.inverse @ [*origin, 1.0])[:3]
        along = self.inverse[:3, :3] @ direction
        hit = self.caster.cast([start], [along])[0]
        if not numpy.isfinite(hit["distance"]):
            return None
        return (self.world @ [*hit["position"].astype(float), 1.0])[:3].tolist()


class RELIEVO_OT_replay(job.ConfirmedSteps, bpy.types.Operator):
    """Make the strokes that the object keeps again, on a new document. Imprints are not kept as strokes and go"""

    bl_idname = "relievo.replay"
    bl_label = "Make strokes again"
    bl_options = {"REGISTER", "UNDO"}
    question = "What is shown now gives way to the strokes alone, without imprints. Undo brings it back."

    failures = (Refused, rl.RelievoError, OSError)

    @classmethod
    def poll(cls, context):
        active = state.source_of(context.active_object)
        return state.is_editable(context) and len(active.relievo.strokes) > 0

    def steps(self, context):
        target = state.source_of(context.active_object)
        made = yield from state.replaying(target)
        made.record(target)
        yield from state.placing(made, target, context.evaluated_depsgraph_get())
        yield from view.ensuring(target, made)
        self.warn(made.take_notes())


class RELIEVO_OT_curves(bpy.types.Operator):
    """Give the brush curves of what pressure is taken as"""

    bl_idname = "relievo.curves"
    bl_label = "Pressure curves"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        group = context.scene.relievo.brush
        if group.curves is None:
            group.curves = bpy.data.node_groups.new("Relievo pressure", "ShaderNodeTree")
        for name in settings.CURVES:
            if name not in settings.curve_nodes(group):
                node = group.curves.nodes.new("ShaderNodeFloatCurve")
                node.name = node.label = name
        return {"FINISHED"}


SIZE_HINT = "\u2022 F changes the radius, Shift+F the strength"
# Keys of all tools with a brush.
SIZE_KEYS = tuple(
    ("relievo.brush_size", {"type": "F", "value": "PRESS", **held}, {"properties": [("what", what)]})
    for what, held in (("radius", {}), ("strength", {"shift": True}))
)


def keys_of(action):
    """The keys of a tool: a stroke, with Ctrl inverted, with Shift smoothing; F and Shift+F for radius and strength."""
    press = {"type": "LEFTMOUSE", "value": "PRESS"}
    held = {"NORMAL": {}, "INVERT": {"ctrl": True}, "SMOOTH": {"shift": True}}
    strokes = [
        ("relievo.stroke", {**press, **keys}, {"properties": [("action", action), ("effect", effect)]})
        for effect, keys in held.items()
    ]
    return (*strokes, *SIZE_KEYS)


class PaintTool(bpy.types.WorkSpaceTool):
    """Paint colours on the tiles of the active object"""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = "relievo.paint_tool"
    bl_label = "Relievo paint"
    bl_description = f"Paint on the active object.\n\u2022 Ctrl takes paint away, Shift blends.\n{SIZE_HINT}"
    bl_icon = "brush.sculpt.paint"
    bl_keymap = keys_of("PAINT")

    def draw_cursor(context, _tool, place):
        ring.draw(context, place, "PAINT")

    def draw_settings(context, layout, _tool):
        draw_header(context, layout, "paint_mode")


class SculptTool(bpy.types.WorkSpaceTool):
    """Sculpt displacement on the tiles of the active object"""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = "relievo.sculpt_tool"
    bl_label = "Relievo sculpt"
    bl_description = f"Sculpt the active object.\n\u2022 Ctrl inverts, Shift smooths.\n{SIZE_HINT}"
    bl_icon = "brush.sculpt.draw" if bpy.app.version < (4, 3) else "brush.generic"
    bl_keymap = keys_of("SCULPT")

    def draw_cursor(context, _tool, place):
        ring.draw(context, place, "SCULPT")

    def draw_settings(context, layout, _tool):
        draw_header(context, layout, "sculpt_mode")


def draw_header(context, layout, mode):
    """The settings that are wanted most, beside the tool."""
    group = context.scene.relievo.brush
    layout.prop(group, mode, text="")
    layout.prop(group, "color" if mode == "paint_mode" else "height")
    if mode == "sculpt_mode" and group.sculpt_mode == "DRAW":
        layout.prop(group, "accumulate")
    layout.prop(group.settings, "radius")
    layout.prop(group.settings, "strength")
    row = layout.row(align=True)
    row.label(text="Symmetry")
    for axis in "xyz":
        row.prop(group.settings, f"symmetry_{axis}", toggle=True)
    layout.menu("RELIEVO_MT_presets_brush", text="", icon="PRESET")


CLASSES = [RELIEVO_OT_stroke, RELIEVO_OT_replay, RELIEVO_OT_curves]


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    if not bpy.app.background:
        bpy.utils.register_tool(PaintTool, separator=True)
        bpy.utils.register_tool(SculptTool, after={PaintTool.bl_idname})


def unregister():
    if not bpy.app.background:
        bpy.utils.unregister_tool(SculptTool)
        bpy.utils.unregister_tool(PaintTool)
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
