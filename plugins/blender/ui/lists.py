# SPDX-License-Identifier: GPL-3.0-or-later
"""The lists of layers and of what presses."""

import bpy

ICONS = {"COLOR": "BRUSH_DATA", "DISPLACEMENT": "MOD_DISPLACE"}


class RELIEVO_UL_layers(bpy.types.UIList):
    """The layers: kind, name, how they are seen, and the eye."""

    def draw_item(self, _context, layout, _data, item, _icon, _active, _name):
        layout.use_property_split = False
        row = layout.row(align=True)
        row.prop(item, "name", text="", emboss=False, icon=ICONS.get(item.kind, "RENDERLAYERS"))
        if item.opacity < 0.995:
            row.label(text=f"{100 * item.opacity:.0f} %")
        row.label(text="", icon="GREASEPENCIL" if item.is_active else "BLANK1")
        row.prop(item, "is_visible", text="", emboss=False, icon="HIDE_OFF" if item.is_visible else "HIDE_ON")


class RELIEVO_UL_pressers(bpy.types.UIList):
    """The list of what presses: on or off, the object, and whether it has settings of its own."""

    def draw_item(self, _context, layout, _data, item, _icon, _active, _name):
        layout.use_property_split = False
        row = layout.row(align=True)
        row.prop(item, "is_on", text="")
        row.prop(item, "target", text="", emboss=False)
        row.prop(item, "has_own", text="", icon="PREFERENCES")


CLASSES = [RELIEVO_UL_layers, RELIEVO_UL_pressers]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
