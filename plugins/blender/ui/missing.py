# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel of an add-on that cannot work: it says what is missing."""

import textwrap

import bpy

from ..core import native


class RELIEVO_PT_missing(bpy.types.Panel):
    bl_label = "Relievo"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Relievo"

    def draw(self, _context):
        column = self.layout.column(align=True)
        column.label(text="Relievo cannot be used:", icon="ERROR")
        for line in textwrap.wrap(native.problem() or "Restart Blender", 40):
            column.label(text=line)


def register():
    print(f"Relievo cannot be used: {native.problem()}")
    bpy.utils.register_class(RELIEVO_PT_missing)


def unregister():
    bpy.utils.unregister_class(RELIEVO_PT_missing)
