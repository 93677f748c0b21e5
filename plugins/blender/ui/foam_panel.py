# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels of foam."""

import bpy

from ..ops import foam
from .panel import Advanced, Panel, draw_rest


class RELIEVO_PT_foam(Panel, bpy.types.Panel):
    bl_label = "Foam"
    bl_parent_id = "RELIEVO_PT_fluid"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.relievo.fluid.role == "DOMAIN"

    def draw(self, context):
        domain, column = context.active_object, self.column()
        options = domain.relievo_foam
        for name in foam.SETTINGS:
            column.prop(options.settings, name)
        column.operator("relievo.foam_estimate")
        if options.estimate:
            column.label(text=options.estimate)
        column.operator("relievo.foam_bake")
        if not foam.shows(domain):
            return
        column.prop(options, "radius")
        column.row().prop(options, "show", expand=True)
        column.prop(options, "light")
        column.operator("relievo.foam_composite")


class RELIEVO_PT_foam_advanced(Advanced, bpy.types.Panel):
    bl_parent_id = "RELIEVO_PT_foam"

    @classmethod
    def poll(cls, context):
        return context.active_object is not None

    def draw(self, context):
        draw_rest(self.column(), context.active_object.relievo_foam.settings, *foam.SETTINGS)


class RELIEVO_PT_foam_look(Advanced, bpy.types.Panel):
    bl_label = "Composited look"
    bl_parent_id = "RELIEVO_PT_foam"

    @classmethod
    def poll(cls, context):
        return context.active_object is not None

    def draw(self, context):
        # The panel of the foam has its radius, which follows the spacing.
        draw_rest(self.column(), context.active_object.relievo_foam.look, "radius")


CLASSES = [RELIEVO_PT_foam, RELIEVO_PT_foam_advanced, RELIEVO_PT_foam_look]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
