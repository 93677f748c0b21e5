# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel of crowds."""

import bpy

from .panel import Panel


class RELIEVO_PT_crowd(Panel, bpy.types.Panel):
    bl_label = "Crowd"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.type == "ARMATURE"

    def draw(self, context):
        options, column = context.active_object.relievo_crowd, self.column()
        column.operator("relievo.crowd_build")
        if not options.path:
            return
        column.operator("relievo.crowd_refit")
        column.label(text=options.report)
        column.prop(options, "pixels")
        column.operator("relievo.crowd_show")
        if options.is_shown:
            column.operator("relievo.crowd_clear")


CLASSES = [RELIEVO_PT_crowd]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
