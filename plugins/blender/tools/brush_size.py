# SPDX-License-Identifier: GPL-3.0-or-later
"""Radius and strength of the brush by F and Shift+F: the pointer goes to the right for more, the circle stays where it was."""

import bpy
from bpy_extras import view3d_utils

from . import ring

# Pixels to the right that raise the strength from 0 to 1.
WHOLE = 200.0
# Share by which the pointer counts while Shift is held.
FINE = 0.1
LABELS = {"radius": "Radius", "strength": "Strength"}


class RELIEVO_OT_brush_size(bpy.types.Operator):
    """Change the radius or the strength of the brush: move the pointer, or type a number"""

    bl_idname = "relievo.brush_size"
    bl_label = "Brush Size"
    bl_options = {"INTERNAL"}

    what: bpy.props.EnumProperty(
        name="What",
        items=[("radius", "Radius", "Radius of the brush"), ("strength", "Strength", "How much of the edit each dab makes")],
    )

    @classmethod
    def poll(cls, context):
        return context.region_data is not None

    def invoke(self, context, event):
        place = event.mouse_region_x, event.mouse_region_y
        ring.held = ring.meet(context, place)
        self.before = getattr(context.scene.relievo.brush.settings, self.what)
        self.moved, self.last, self.typed = 0.0, event.mouse_x, ""
        self.unit = 1.0 / WHOLE if self.what == "strength" else self.length(context, place)
        self.tell(context)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def length(self, context, place):
        """The length in the world of a pixel at the surface, or at the object where the pointer is beside it."""
        point = ring.held[0] if ring.held else context.active_object.matrix_world.translation
        ends = [
            view3d_utils.region_2d_to_location_3d(context.region, context.region_data, (place[0] + step, place[1]), point)
            for step in (0, 1)
        ]
        return (ends[1] - ends[0]).length

    def modal(self, context, event):
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            setattr(context.scene.relievo.brush.settings, self.what, self.before)
            return self.ended(context, {"CANCELLED"})
        if event.type in {"LEFTMOUSE", "RET", "NUMPAD_ENTER"} and event.value == "PRESS":
            return self.ended(context, {"FINISHED"})
        if event.type == "MOUSEMOVE":
            self.moved += (event.mouse_x - self.last) * (FINE if event.shift else 1.0)
            self.last = event.mouse_x
        elif event.value == "PRESS" and event.type == "BACK_SPACE":
            self.typed = self.typed[:-1]
        elif event.value == "PRESS" and event.ascii and event.ascii in "0123456789.":
            self.typed += event.ascii
        else:
            return {"RUNNING_MODAL"}
        setattr(context.scene.relievo.brush.settings, self.what, self.value())
        self.tell(context)
        return {"RUNNING_MODAL"}

    def value(self):
        """What it is now; the property itself keeps it in its range."""
        try:
            return float(self.typed)
        except ValueError:
            return max(self.before + self.moved * self.unit, 0.0)

    def tell(self, context):
        value = getattr(context.scene.relievo.brush.settings, self.what)
        context.workspace.status_text_set(f"{LABELS[self.what]} {value:.3g}; click: keep, right click: cancel, Shift: finely")
        context.area.tag_redraw()

    def ended(self, context, answer):
        ring.held = None
        context.workspace.status_text_set(None)
        context.area.tag_redraw()
        return answer

    def cancel(self, context):
        """Blender ends it, say because the window closes."""
        ring.held = None


def register():
    bpy.utils.register_class(RELIEVO_OT_brush_size)


def unregister():
    bpy.utils.unregister_class(RELIEVO_OT_brush_size)
