# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles on levels: a region of the active object is moved and turned, at the level that is shown, and all other levels
follow. By the pointer it is an operator from press to release; every edit is a step of undo."""

import json
import math

import bpy
import librelievo as rl
import mathutils
import numpy
from bpy_extras import view3d_utils

from ..core import job, settings
from ..core.error import Refused, said
from ..data import progressive
from . import overlay, pointer

# What a notch of the wheel multiplies the radius by.
NOTCH = 1.1
HINT = "Drag a region; wheel: radius, A: hold the region under the pointer, Esc: cancel"
HELD_HINT = "Release to keep it; R: turn, G: move, wheel: radius, Esc: cancel"


def anchors_of(text):
    """Anchors as an edit keeps them, from a JSON list of x, y, z and radius."""
    try:
        rows = [[float(number) for number in row] for row in json.loads(text or "[]")]
        if any(len(row) != 4 for row in rows):
            raise ValueError("each has four numbers")
    except (ValueError, *progressive.STRANGE) as failure:
        raise Refused(f"The anchors are not a list of x, y, z and radius: {failure}") from None
    return [{"center": row[:3], "radius": row[3]} for row in rows]


class RELIEVO_OT_levels_edit(pointer.Edit, bpy.types.Operator):
    """Move and turn a region of the active object at the level that is shown; all other levels follow"""

    bl_idname = "relievo.levels_edit"
    bl_label = "Grab region"

    point: bpy.props.FloatVectorProperty(name="Point", description="Middle of the region, object units", precision=4)
    radius: bpy.props.FloatProperty(
        name="Radius", description="How far the region reaches, object units", min=1e-6, default=0.5, precision=4
    )
    falloff: bpy.props.EnumProperty(
        name="Falloff",
        description="How the influence falls to the border of the region",
        items=settings.choices(rl.abi.RlvFalloff),
        default="SMOOTH",
    )
    move: bpy.props.FloatVectorProperty(name="Move", description="How far it moves, object units", precision=4)
    axis: bpy.props.FloatVectorProperty(name="Axis", description="What it turns about", default=(0, 0, 1), precision=4)
    angle: bpy.props.FloatProperty(name="Turn", description="How far it turns about its middle", subtype="ANGLE")
    anchors: bpy.props.StringProperty(
        name="Anchors", description="Regions that are held, as a JSON list of x, y, z and radius", options={"HIDDEN"}
    )

    def text(self, measure):
        """The edit as the object keeps it."""
        length = math.sqrt(sum(value * value for value in self.axis))
        if self.angle and not length:
            raise Refused("The axis has no direction")
        handle = {
            "center": list(self.point),
            "radius": self.radius,
            "falloff": self.falloff.lower(),
            "translation": list(self.move),
            "axis": [value / length for value in self.axis] if length else [0.0, 0.0, 1.0],
            "angle": self.angle,
        }
        return progressive.text_of(measure, [handle], anchors_of(self.anchors))

    def invoke(self, context, event):
        if not pointer.is_in_view(context):
            return super().invoke(context, event)
        if job.is_busy():
            self.report({"ERROR"}, "Relievo is at work; wait for it, or cancel it with Esc")
            return {"CANCELLED"}
        job.interrupt()
        try:
            self.begin(context)
        except self.failures as failure:
            self.report({"ERROR"}, said(failure))
            return {"CANCELLED"}
        self.is_held, self.is_turning, self.place = False, False, None
        handle = context.scene.relievo.handle
        self.radius, self.falloff, self.anchors = handle.radius, handle.falloff, ""
        self.move, self.angle = (0, 0, 0), 0.0
        self.overlay = overlay.Overlay(self.target.matrix_world)
        self.hover(context, event)
        if event.type == "LEFTMOUSE" and event.value == "PRESS" and context.region == self.region:
            if self.place is None:
                return self.done_drawing(context, {"CANCELLED"})
            self.hold(context, event)
        else:
            context.workspace.status_text_set(HINT)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if not self.is_drawn:
            return super().modal(context, event)
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            return self.cancelled(context)
        try:
            if event.type in {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE"}:
                (self.drag if self.is_held else self.hover)(context, event)
            elif event.type in {"WHEELUPMOUSE", "WHEELDOWNMOUSE"}:
                self.resize(context, NOTCH if event.type == "WHEELUPMOUSE" else 1 / NOTCH)
            elif event.type == "LEFTMOUSE" and event.value == "PRESS" and not self.is_held:
                self.hover(context, event)
                if self.place is None:
                    return {"RUNNING_MODAL"}
                self.hold(context, event)
            elif event.type == "LEFTMOUSE" and event.value == "RELEASE" and self.is_held:
                return self.release(context)
            elif event.type in {"R", "G"} and event.value == "PRESS" and self.is_held:
                self.is_turning, self.before = event.type == "R", self.mouse(event)
            elif event.type == "A" and event.value == "PRESS" and not self.is_held and self.place is not None:
                rows = json.loads(self.anchors or "[]")
                self.anchors = json.dumps([*rows, [*self.place, self.radius]])
                self.show_balls()
            elif not self.is_held and event.type in {"MIDDLEMOUSE", "NDOF_MOTION"}:
                # The view may be turned before something is held.
                return {"PASS_THROUGH"}
        except self.failures as failure:
            # Nothing was changed; another radius or place may do.
            self.report({"WARNING"}, said(failure))
        except BaseException:
            self.cancelled(context)
            raise
        context.area.tag_redraw()
        return {"RUNNING_MODAL"}

    def hover(self, context, event):
        """Finds where the pointer is on the surface, in the space of the object."""
        self.place = self.meet(context, event)
        self.show_balls()

    def hold(self, context, event):
        """Takes hold of the region under the pointer."""
        self.point, self.is_held, self.before = self.place, True, self.mouse(event)
        context.workspace.status_text_set(HELD_HINT)

    def drag(self, context, event):
        """Moves what is held, or turns it, as the pointer went since the last event."""
        now, view = self.mouse(event), context.region_data
        middle = mathutils.Vector((self.world @ [*(numpy.array(self.point) + self.move), 1.0])[:3])
        if self.is_turning:
            on_screen = view3d_utils.location_3d_to_region_2d(self.region, view, middle)
            if on_screen is not None:
                angles = [math.atan2(y - on_screen[1], x - on_screen[0]) for x, y in (self.before, now)]
                self.angle += math.remainder(angles[1] - angles[0], 2 * math.pi)
                # Seen against the axis it turns counter-clockwise; in a mirrored object that is the other way round.
                axis = self.inverse[:3, :3] @ (view.view_rotation @ mathutils.Vector((0, 0, 1)))
                self.axis = axis * (numpy.sign(numpy.linalg.det(self.world)) / numpy.linalg.norm(axis))
        else:
            start, end = (
                view3d_utils.region_2d_to_location_3d(self.region, view, place, middle) for place in (self.before, now)
            )
            self.move = numpy.array(self.move) + self.inverse[:3, :3] @ (end - start)
        self.before = now
        self.attempt()

    def resize(self, context, factor):
        self.radius *= factor
        context.scene.relievo.handle.radius = self.radius
        if self.is_held:
            self.attempt()
        self.show_balls()

    def attempt(self):
        super().attempt()
        self.show_balls()

    def show_balls(self):
        """Says what the overlay shows."""
        held = [(row[:3], row[3], overlay.HELD) for row in json.loads(self.anchors or "[]")]
        middle = numpy.array(self.point) + self.move if self.is_held else self.place
        self.overlay.balls = held + ([(middle, self.radius, overlay.GRABBED)] if middle is not None else [])

    def done_drawing(self, context, answer):
        self.overlay.remove()
        return super().done_drawing(context, answer)


class HandleTool(bpy.types.WorkSpaceTool):
    """Grab regions of the level that the active object shows"""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = "relievo.handle_tool"
    bl_label = "Relievo handle"
    bl_description = "Grab and turn regions of the level that the active object shows"
    bl_icon = "brush.uv_sculpt.grab"
    bl_keymap = (("relievo.levels_edit", {"type": "LEFTMOUSE", "value": "PRESS"}, {"properties": []}),)

    def draw_settings(context, layout, _tool):
        group = context.scene.relievo.handle
        layout.prop(group, "radius")
        layout.prop(group, "falloff", text="")


def register():
    bpy.utils.register_class(RELIEVO_OT_levels_edit)
    if not bpy.app.background:
        bpy.utils.register_tool(HandleTool)


def unregister():
    if not bpy.app.background:
        bpy.utils.unregister_tool(HandleTool)
    bpy.utils.unregister_class(RELIEVO_OT_levels_edit)
