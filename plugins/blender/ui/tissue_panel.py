# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels of soft tissue."""

import bpy

from ..ops import fluid, tissue
from .panel import Advanced, Panel


class RELIEVO_PT_tissue(Panel, bpy.types.Panel):
    bl_label = "Soft tissue"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.type in fluid.TYPES

    def draw(self, context):
        column, options = self.column(), context.active_object.relievo_tissue
        column.prop(options, "role")
        if options.role in ("VOLUME", "MUSCLE"):
            column.prop(options, "material")
            if options.material == "CUSTOM":
                for name in ("young", "poisson", "density"):
                    column.prop(options, name)
            column.prop(options, "level")
        if options.role == "MUSCLE":
            for name in ("strength", "stiffness", "activation"):
                column.prop(options, name)
        if options.role == "COLLIDER":
            column.prop(options, "friction")
        collection = tissue.collection_of(context)
        if collection is None:
            return
        column.separator()
        column.label(text=collection.name, icon="OUTLINER_COLLECTION")
        for name in tissue.SETTINGS:
            column.prop(collection.relievo_tissue, name)
        column.operator("relievo.tissue_estimate")
        if collection.relievo_tissue.estimate:
            column.label(text=collection.relievo_tissue.estimate)
        column.operator("relievo.tissue_bake")
        column.operator("relievo.tissue_clear")
        column.operator("relievo.cache_clean")


class RELIEVO_PT_tissue_advanced(Advanced, bpy.types.Panel):
    bl_parent_id = "RELIEVO_PT_tissue"

    @classmethod
    def poll(cls, context):
        return tissue.collection_of(context) is not None

    def draw(self, context):
        column, model = self.column(), tissue.collection_of(context).relievo_tissue
        for name in tissue.RelievoTissueModel.__annotations__:
            if name not in (*tissue.SETTINGS, "pace", "estimate"):
                column.prop(model, name)


CLASSES = [RELIEVO_PT_tissue, RELIEVO_PT_tissue_advanced]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
