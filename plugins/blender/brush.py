# SPDX-License-Identifier: GPL-3.0-or-later
"""Painting and sculpting: a stroke per press of the button, with pressure and symmetry; each is one edit, one step of
undo, and kept in the file with its points."""

import json
import time

import bpy
import librelievo as rl
import numpy
from bpy_extras import view3d_utils
from librelievo import stroke

from . import native, settings, state, view


def brush_of(scene, action):
    """The brush that the scene's settings say, and those settings as they are kept with a stroke."""
    group = scene.relievo.brush
    mode = group.paint_mode if action == "PAINT" else group.sculpt_mode
    options = {
        "action": action.lower(),
        "mode": mode.lower(),
        "falloff": group.falloff.lower(),
        "color": list(group.color),
        "height": group.height,
    }
    values = settings.values(group.settings)
    made = rl.Brush(native.context(), values, **options)
    image = group.stamp
    if image is not None and image.size[0]:
        width, height = image.size
        pixels = numpy.empty(width * height * image.channels, numpy.float32)
        image.pixels.foreach_get(pixels)
        # Blender has the lowest row first.
        pixels = pixels.reshape(height, width, image.channels)[::-1]
        made.set_stamp(pixels, settings.values(group.stamp_settings))
    return made, {"options": options, "settings": values, "stamp": image.name if image else None}


def keep(target, kept, points):
    """Keeps a stroke in the object."""
    entry = target.relievo.strokes.add()
    rows = [[round(float(number), 6) for number in row] for row in points]
    entry.text = json.dumps({**kept, "points": rows})


class RELIEVO_OT_stroke(bpy.types.Operator):
    """Draw a stroke on the active object"""

    bl_idname = "relievo.stroke"
    bl_label = "Relievo stroke"
    bl_options = {"REGISTER", "UNDO"}

    action: bpy.props.EnumProperty(name="Action", items=[("PAINT", "Paint", ""), ("SCULPT", "Sculpt", "")])
    points: bpy.props.StringProperty(
        name="Points", description="JSON list of points: x, y, z in the world, pressure, seconds", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context):
        return state.is_editable(context)

    def begin(self, context):
        """What every stroke starts with; an error is reported."""
        self.target = state.source_of(context.active_object)
        try:
            made = state.of(self.target)
            state.place(made, self.target)
            self.brush, self.kept = brush_of(context.scene, self.action)
            view.ensure(self.target, made)
            made.document.begin(json.dumps(self.kept))
        except (state.Refused, rl.RelievoError) as failure:
            self.report({"ERROR"}, str(failure))
            return None
        self.drawn = []
        return made

    def finish(self, made):
        # What the panel of the last operation makes the stroke again with.
        self.points = json.dumps(self.drawn)
        made.end(self.target)
        keep(self.target, self.kept, self.drawn)
        view.refresh(self.target, made)

    def abandon(self, made):
        made.document.abandon()
        made.detail.commit()
        view.refresh(self.target, made)

    def execute(self, context):
        try:
            points = stroke.points_of(json.loads(self.points))
        except (ValueError, rl.RelievoError) as failure:
            self.report({"ERROR"}, f"The points are not a list of x, y, z, pressure and time: {failure}")
            return {"CANCELLED"}
        made = self.begin(context)
        if made is None:
            return {"CANCELLED"}
        try:
            stroke.run(made.detail, self.brush, points)
        except rl.RelievoError as failure:
            self.abandon(made)
            self.report({"ERROR"}, str(failure))
            return {"CANCELLED"}
        self.drawn = points.tolist()
        self.finish(made)
        return {"FINISHED"}

    def invoke(self, context, event):
        if self.points or context.region_data is None:
            return self.execute(context)
        made = self.begin(context)
        if made is None:
            return {"CANCELLED"}
        self.state, self.start = made, time.perf_counter()
        self.caster = made.pick()
        self.world = state.world(self.target)
        self.inverse = state.inverse(self.world)
        self.stroke = rl.Stroke(made.detail, self.brush)
        self.times = []
        self.extend(context, event)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
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
            except rl.RelievoError as failure:
                return self.cancelled(failure)
            self.stroke.release()
            self.finish(self.state)
            return {"FINISHED"}
        if event.type == "ESC":
            return self.cancelled(None)
        return {"RUNNING_MODAL"}

    def cancelled(self, failure):
        self.stroke.release()
        self.abandon(self.state)
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


def register():
    bpy.utils.register_class(RELIEVO_OT_stroke)
    if not bpy.app.background:
        bpy.utils.register_tool(PaintTool, separator=True, group=True)
        bpy.utils.register_tool(SculptTool, after={PaintTool.bl_idname})


def unregister():
    if not bpy.app.background:
        bpy.utils.unregister_tool(SculptTool)
        bpy.utils.unregister_tool(PaintTool)
    bpy.utils.unregister_class(RELIEVO_OT_stroke)
