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

from . import job, settings, state, stroke, view


def active_layer(made, kept):
    """The name of the layer that a stroke goes to."""
    kind = rl.abi.RlvLayerKind.COLOR if kept["options"]["action"] == "paint" else rl.abi.RlvLayerKind.DISPLACEMENT
    return next((layer.name for layer in made.detail.layers if layer.kind == kind and layer.is_active), None)


class RELIEVO_OT_prepare(job.Steps, bpy.types.Operator):
    """Make the detail of the active object ready for the brush"""

    bl_idname = "relievo.prepare"
    bl_label = "Prepare"
    bl_options = {"REGISTER", "UNDO"}

    failures = (state.Refused, rl.RelievoError, OSError)

    @classmethod
    def poll(cls, context):
        return state.is_editable(context)

    def steps(self, context):
        target = state.source_of(context.active_object)
        made = yield from state.opening(target)
        state.place(made, target, state.posed_points(target, context.evaluated_depsgraph_get()))
        yield from view.ensuring(target, made)
        yield 0.8, 1.0, lambda _progress: made.pick()
        made.record(target)
        self.warn(made.take_notes())


class RELIEVO_OT_stroke(job.Steps, bpy.types.Operator):
    """Draw a stroke on the active object"""

    bl_idname = "relievo.stroke"
    bl_label = "Relievo stroke"
    bl_options = {"REGISTER", "UNDO"}

    action: bpy.props.EnumProperty(name="Action", items=[("PAINT", "Paint", ""), ("SCULPT", "Sculpt", "")])
    points: bpy.props.StringProperty(
        name="Points", description="JSON list of points: x, y, z in the world, pressure, seconds", options={"SKIP_SAVE"}
    )

    failures = (state.Refused, rl.RelievoError, OSError)

    @classmethod
    def poll(cls, context):
        return state.is_editable(context)

    def begin(self, context, made, target):
        """What every stroke starts with. Returns the brush."""
        self.target, self.drawn = target, []
        points = state.posed_points(target, context.evaluated_depsgraph_get())
        state.place(made, target, points)
        self.kept, self.pixels = stroke.describe(context.scene, self.action)
        self.kept["matrix"] = state.world(target).tolist()
        self.kept["is_posed"] = not numpy.array_equal(points, made.rest)
        self.kept["layer"], self.kept["layers"] = active_layer(made, self.kept), state.layers_of(made.detail)
        if stroke.bends(self.kept):
            made.add_vectors()
        return stroke.brush(self.kept, self.pixels)

    def keep(self, made):
        # What the panel of the last operation makes the stroke again with.
        self.points = json.dumps(self.drawn)
        made.record(self.target)
        stroke.keep(self.target, self.kept, self.pixels, self.drawn, made.revision)

    def steps(self, context):
        """The whole stroke at once."""
        try:
            points = rl.stroke.points_of(json.loads(self.points))
        except (ValueError, rl.RelievoError) as failure:
            raise state.Refused(f"The points are not a list of x, y, z, pressure and time: {failure}") from None
        target = state.source_of(context.active_object)
        made = yield from state.opening(target)
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

    def invoke(self, context, event):
        if self.points or context.region_data is None:
            return super().invoke(context, event)
        if job.is_busy():
            return {"CANCELLED"}
        job.interrupt()
        target = state.source_of(context.active_object)
        if not state.is_ready(target) or not state.is_used(target.relievo.result):
            # On a large mesh this takes longer than a hand waits.
            if bpy.ops.relievo.prepare("INVOKE_DEFAULT") != {"FINISHED"}:
                self.report({"INFO"}, f"{target.name} is being prepared; draw when that is done")
                return {"CANCELLED"}
        try:
            made = state.of(target)
            brush = self.begin(context, made, target)
            view.ensure(target, made)
            made.document.begin(json.dumps(self.kept))
            self.state, self.start = made, time.perf_counter()
            self.caster = made.pick()
            self.world = state.world(self.target)
            self.inverse = numpy.linalg.inv(self.world)
            self.stroke = rl.Stroke(made.detail, brush)
        except (state.Refused, rl.RelievoError) as failure:
            self.report({"ERROR"}, str(failure))
            return {"CANCELLED"}
        self.times = []
        try:
            self.extend(context, event)
        except rl.RelievoError as failure:
            return self.cancelled(failure)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if self._timer is not None:
            return super().modal(context, event)
        if event.type in {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE"}:
            begun = time.perf_counter()
            try:
                self.extend(context, event)
            except rl.RelievoError as failure:
                return self.cancelled(failure)
            self.times.append(time.perf_counter() - begun)
            context.area.tag_redraw()
            return {"RUNNING_MODAL"}
        if event.type == "LEFTMOUSE" and event.value == "RELEASE":
            try:
                if self.drawn:
                    self.stroke.end()
                self.stroke.release()
                if not self.drawn:
                    return self.cancelled(None)
                self.state.end()
            except rl.RelievoError as failure:
                return self.cancelled(failure)
            self.keep(self.state)
            view.refresh(self.target, self.state)
            # The next press meets the surface as it is now.
            threading.Thread(target=self.state.try_pick, daemon=True).start()
            return {"FINISHED"}
        if event.type == "ESC":
            return self.cancelled(None)
        return {"RUNNING_MODAL"}

    def cancel(self, context):
        if self._timer is not None:
            super().cancel(context)
        else:
            self.cancelled(None)

    def cancelled(self, failure):
        self.stroke.release()
        self.state.abandon()
        view.refresh(self.target, self.state)
        if failure is not None:
            self.report({"ERROR"}, str(failure))
        return {"CANCELLED"}

    def extend(self, context, event):
        """Goes on to where the pointer is, if that is on the surface."""
        place = (event.mouse_region_x, event.mouse_region_y)
        region, view3d = context.region, context.region_data
        origin = view3d_utils.region_2d_to_origin_3d(region, view3d, place)
        direction = view3d_utils.region_2d_to_vector_3d(region, view3d, place)
        point = self.meet(origin, direction)
        if point is None:
            return
        pressure = event.pressure if event.is_tablet else 1.0
        row = [*point, pressure, time.perf_counter() - self.start]
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


class RELIEVO_OT_replay(job.Steps, bpy.types.Operator):
    """Make the strokes that the object keeps again, on a new document. Imprints are not kept as strokes. This cannot be
    undone"""

    bl_idname = "relievo.replay"
    bl_label = "Make strokes again"
    bl_options = {"REGISTER"}

    failures = (state.Refused, rl.RelievoError, OSError)

    @classmethod
    def poll(cls, context):
        active = state.source_of(context.active_object)
        return state.is_editable(context) and len(active.relievo.strokes) > 0

    def steps(self, context):
        target = state.source_of(context.active_object)
        state.check(target)
        state.forget(target)
        made = yield from state.opening(target)
        made.record(target)
        state.place(made, target, state.posed_points(target, context.evaluated_depsgraph_get()))
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


class PaintTool(bpy.types.WorkSpaceTool):
    """Paint colours on the tiles of the active object"""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = "relievo.paint_tool"
    bl_label = "Relievo paint"
    bl_description = "Paint on the tiles of the active object"
    bl_icon = "brush.sculpt.paint"
    bl_keymap = (("relievo.stroke", {"type": "LEFTMOUSE", "value": "PRESS"}, {"properties": [("action", "PAINT")]}),)

    def draw_settings(context, layout, _tool):
        draw_header(context, layout, "paint_mode")


class SculptTool(bpy.types.WorkSpaceTool):
    """Sculpt displacement on the tiles of the active object"""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = "relievo.sculpt_tool"
    bl_label = "Relievo sculpt"
    bl_description = "Sculpt the tiles of the active object"
    bl_icon = "brush.sculpt.draw" if bpy.app.version < (4, 3) else "brush.generic"
    bl_keymap = (("relievo.stroke", {"type": "LEFTMOUSE", "value": "PRESS"}, {"properties": [("action", "SCULPT")]}),)

    def draw_settings(context, layout, _tool):
        draw_header(context, layout, "sculpt_mode")


def draw_header(context, layout, mode):
    """The settings that are wanted most, beside the tool."""
    group = context.scene.relievo.brush
    layout.prop(group, mode, text="")
    layout.prop(group, "color" if mode == "paint_mode" else "height")
    layout.prop(group.settings, "radius")
    layout.prop(group.settings, "strength")


CLASSES = [RELIEVO_OT_prepare, RELIEVO_OT_stroke, RELIEVO_OT_replay, RELIEVO_OT_curves]


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    if not bpy.app.background:
        bpy.utils.register_tool(PaintTool, separator=True, group=True)
        bpy.utils.register_tool(SculptTool, after={PaintTool.bl_idname})


def unregister():
    if not bpy.app.background:
        bpy.utils.unregister_tool(SculptTool)
        bpy.utils.unregister_tool(PaintTool)
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
