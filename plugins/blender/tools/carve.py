# SPDX-License-Identifier: GPL-3.0-or-later
"""Strokes that sculpt levels: the brush of the Brush panel moves the vertices of the level that is shown, and all other
levels follow. Every stroke is an edit and a step of undo."""

import json
import time

import bpy
import librelievo as rl
import numpy

from ..core import job
from ..core.error import Refused, said
from ..data import pose, progressive, stroke
from . import brush, pointer, ring

HINT = "Draw on the level; release to keep it, Esc: cancel"


class RELIEVO_OT_levels_sculpt(pointer.Edit, bpy.types.Operator):
    """Sculpt the active object at the level that is shown; all other levels follow"""

    bl_idname = "relievo.levels_sculpt"
    bl_label = "Sculpt level"

    points: bpy.props.StringProperty(
        name="Points",
        description="JSON list of points: x, y, z in the world, pressure, seconds",
        options={"HIDDEN", "SKIP_SAVE"},
    )

    def prepare(self, context, target, shown):
        """Has the brush as it is in the space of the object, of whose size its lengths are."""
        inverse = pose.inverse_of(target)
        self.kept, pixels = stroke.describe(context.scene, "SCULPT")
        size = abs(numpy.linalg.det(inverse)) ** (1 / 3)
        for name in ("radius", "string"):
            self.kept["settings"][name] *= size
        self.stamp = None
        if pixels is not None:
            self.stamp = stroke.pack_array(pixels, progressive.STAMPS)
            shown.stamps[self.stamp[0]] = pixels
        self.kept["stamp_key"] = None if self.stamp is None else self.stamp[0]
        if not self.is_drawn:
            self.drawn = self.given(inverse)

    def given(self, inverse):
        """The points of the property in the space of the object."""
        try:
            points = rl.stroke.points_of(json.loads(self.points))
        except (ValueError, rl.RelievoError):
            raise Refused("The points are not a list of x, y, z, pressure and time") from None
        points[:, :3] = points[:, :3] @ inverse[:3, :3].T + inverse[:3, 3]
        return points.tolist()

    def text(self, measure):
        """The edit as the object keeps it."""
        return progressive.text_of(measure, stroke={**self.kept, "points": self.drawn})

    def invoke(self, context, event):
        if self.points or not pointer.is_in_view(context):
            return super().invoke(context, event)
        if job.is_busy():
            return {"CANCELLED"}
        job.interrupt()
        self.is_drawn, self.drawn = True, []
        self.start = self.next = time.perf_counter()
        try:
            self.begin(context)
        except self.failures as failure:
            self.report({"ERROR"}, said(failure))
            return {"CANCELLED"}
        # The button of the panel waits for a press in the view.
        self.is_held = event.type == "LEFTMOUSE" and event.value == "PRESS" and context.region == self.region
        context.workspace.status_text_set(HINT)
        context.window_manager.modal_handler_add(self)
        try:
            if self.is_held:
                self.extend(context, event)
        except self.failures as failure:
            self.report({"ERROR"}, said(failure))
            return self.cancelled(context)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if not self.is_drawn:
            return super().modal(context, event)
        try:
            if event.type in {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE"}:
                if self.is_held:
                    self.extend(context, event)
            elif event.type == "LEFTMOUSE" and event.value == "PRESS":
                self.is_held = True
                self.extend(context, event)
            elif event.type == "LEFTMOUSE" and event.value == "RELEASE" and self.is_held:
                return self.release(context)
            elif event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
                return self.cancelled(context)
        except self.failures as failure:
            self.report({"ERROR"}, said(failure))
            return self.cancelled(context)
        except BaseException:
            self.cancelled(context)
            raise
        return {"RUNNING_MODAL"}

    def extend(self, context, event):
        """Goes on to where the pointer is, if that is on the surface. What a long stroke has to make anew is made at half
        the time at most."""
        place = self.meet(context, event)
        if place is None:
            return
        now = time.perf_counter()
        self.drawn.append([*place, event.pressure if event.is_tablet else 1.0, now - self.start])
        if now >= self.next:
            self.attempt()
            done = time.perf_counter()
            self.next = done + (done - now)
            context.area.tag_redraw()

    def release(self, context):
        if self.drawn:
            self.attempt()
            # What the panel of the last operation makes the stroke again with.
            points = numpy.array(self.drawn)
            points[:, :3] = points[:, :3] @ self.world[:3, :3].T + self.world[:3, 3]
            self.points = json.dumps(points.tolist())
        return super().release(context)


class LevelSculptTool(bpy.types.WorkSpaceTool):
    """Sculpt the level that the active object shows"""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = "relievo.level_sculpt_tool"
    bl_label = "Relievo level sculpt"
    bl_description = f"Sculpt the level that the active object shows.\n{brush.SIZE_HINT}"
    bl_icon = "brush.sculpt.displacement_smear"
    bl_keymap = (
        ("relievo.levels_sculpt", {"type": "LEFTMOUSE", "value": "PRESS"}, {"properties": []}),
        *brush.SIZE_KEYS,
    )

    def draw_cursor(context, _tool, place):
        ring.draw(context, place, "SCULPT")

    def draw_settings(context, layout, _tool):
        brush.draw_header(context, layout, "sculpt_mode")


def register():
    bpy.utils.register_class(RELIEVO_OT_levels_sculpt)
    if not bpy.app.background:
        bpy.utils.register_tool(LevelSculptTool)


def unregister():
    if not bpy.app.background:
        bpy.utils.unregister_tool(LevelSculptTool)
    bpy.utils.unregister_class(RELIEVO_OT_levels_sculpt)
