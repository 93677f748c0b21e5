# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels of decals, in the view and beside the image."""

import bpy

from ..ops import decal


class DecalPanel:
    """What the panels of an object's decal share."""

    bl_label = "Decal"
    bl_region_type = "UI"
    bl_category = "Relievo"

    @classmethod
    def poll(cls, context):
        target = decal.owner_of(context.active_object)
        return target is not None and target.type == "MESH"


class RELIEVO_PT_decal(DecalPanel, bpy.types.Panel):
    bl_space_type = "VIEW_3D"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        draw_decal(self.layout, decal.owner_of(context.active_object), "relievo.decal_pin_add")


class RELIEVO_PT_decal_image(DecalPanel, bpy.types.Panel):
    bl_space_type = "IMAGE_EDITOR"

    def draw(self, context):
        draw_decal(self.layout, decal.owner_of(context.active_object), "relievo.decal_pin_image")


def draw_decal(layout, target, pick):
    """The panel of an object's decal, with the operator that picks points in its editor."""
    options = target.relievo.decal
    layout.template_ID(options, "image", open="image.open")
    layout.template_list("UI_UL_list", "relievo_pins", options, "pins", options, "active", rows=3)
    row = layout.row(align=True)
    row.operator(pick)
    row.operator("relievo.decal_pin_drag")
    row.operator("relievo.decal_pin_remove", text="", icon="X")
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    if 0 <= options.active < len(options.pins):
        for name in ("image", "position", "depth"):
            column.prop(options.pins[options.active], name)
    if len(options.pins) == 1:
        column.prop(options, "width")
        column.prop(options, "up")
    column.prop(options, "overlap")
    column.row().prop(options, "kind", expand=True)
    column.prop(options, "height" if options.kind == "RELIEF" else "opacity")
    column.operator("relievo.decal_apply")
    column.prop(options, "offset")
    column.operator("relievo.decal_mesh")


CLASSES = [RELIEVO_PT_decal, RELIEVO_PT_decal_image]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
