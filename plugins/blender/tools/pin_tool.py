# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool for the pins of decals: pins are drawn over the view, a press near one drags it, and Ctrl adds one."""

import bpy
import gpu
import numpy
from bpy_extras import view3d_utils
from gpu_extras.batch import batch_for_shader
from mathutils import Vector

from ..ops import decal
from . import ring

# Pixels from the middle of a pin to its border, and its colours.
SIZE = 7.0
COLORS = {False: (0.9, 0.9, 0.9, 1.0), True: (1.0, 0.5, 0.1, 1.0)}


def spots(context):
    """Returns where the pins of the active object are in the window, pixels, and whether each is the active one."""
    target, found = decal.owner_of(context.active_object), []
    options = target.relievo.decal if target is not None else None
    for number, pin in enumerate(options.pins if options is not None else ()):
        world = target.matrix_world @ Vector(pin.position)
        at = view3d_utils.location_3d_to_region_2d(context.region, context.region_data, world)
        if at is not None:
            found.append((at[0] + context.region.x, at[1] + context.region.y, number == options.active))
    return found


def draw(context):
    """Draws the pins."""
    if context.region_data is None:
        return
    for x, y, is_active in spots(context):
        around = numpy.stack([numpy.cos(ring.ANGLES), numpy.sin(ring.ANGLES)], 1)
        ring.draw_line([x, y] + SIZE * around, COLORS[is_active])
        shader = gpu.shader.from_builtin(ring.SHADER)
        batch = batch_for_shader(shader, "TRI_FAN", {"pos": ([x, y] + 0.4 * SIZE * around).astype(numpy.float32)})
        shader.bind()
        shader.uniform_float("color", COLORS[is_active])
        batch.draw(shader)


class PinTool(bpy.types.WorkSpaceTool):
    """Drag the pins of the decal of the active object"""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = "relievo.pin_tool"
    bl_label = "Relievo pins"
    bl_description = "Drag the pins of the decal of the active object.\n\u2022 Ctrl adds a pin, X removes the active one"
    bl_icon = "ops.generic.cursor"
    bl_keymap = (
        ("relievo.decal_pin_drag", {"type": "LEFTMOUSE", "value": "PRESS"}, {"properties": []}),
        ("relievo.decal_pin_add", {"type": "LEFTMOUSE", "value": "PRESS", "ctrl": True}, {"properties": []}),
        ("relievo.decal_pin_remove", {"type": "X", "value": "PRESS"}, {"properties": []}),
    )

    def draw_cursor(context, _tool, _place):
        draw(context)

    def draw_settings(context, layout, _tool):
        target = decal.owner_of(context.active_object)
        if target is not None and target.type == "MESH":
            layout.template_ID(target.relievo.decal, "image", open="image.open")
            layout.operator("relievo.decal_mesh")
            layout.operator("relievo.decal_apply")


def register():
    if not bpy.app.background:
        bpy.utils.register_tool(PinTool)


def unregister():
    if not bpy.app.background:
        bpy.utils.unregister_tool(PinTool)
