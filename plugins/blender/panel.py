# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels in the sidebar, made from the library's tables of parameters."""

import textwrap

import bpy
import librelievo as rl
from librelievo import abi

from . import fluid, preview, progressive, settings, state


class Panel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Relievo"

    @classmethod
    def poll(cls, context):
        active = state.source_of(context.active_object)
        return active is not None and active.type == "MESH"

    def column(self):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout.column()


def draw_table(layout, group):
    """Every parameter of a group that was made from a table."""
    for parameter in group.table:
        layout.prop(group, parameter.name)


class RELIEVO_PT_levels(Panel, bpy.types.Panel):
    bl_label = "Levels"

    @classmethod
    def poll(cls, context):
        return context.active_object is not None

    def draw(self, context):
        target, column = context.active_object, self.column()
        if not progressive.is_there(target):
            column.operator("relievo.levels_build")
            column.operator("relievo.levels_read")
            return
        options = target.relievo.progressive
        column.row().prop(options, "measure", expand=True)
        column.prop(options, options.measure.lower(), slider=options.measure == "RATIO")
        column.label(text=f"{len(target.data.polygons):,} of {options.finest:,} triangles")
        column.label(text=f"{len(options.edits)} edits")
        for line in textwrap.wrap(progressive.trouble(target), 40):
            column.label(text=line, icon="ERROR")
        for name in ("radius", "falloff"):
            column.prop(context.scene.relievo.handle, name)
        column.operator("relievo.levels_edit")
        column.operator("relievo.levels_sculpt")
        row = column.row(align=True)
        row.operator("relievo.levels_hook")
        if len(options.hooks):
            row.operator_menu_enum("relievo.levels_unhook", "keep")
            column.label(text=f"{len(options.hooks)} hooks")
        column.operator("relievo.levels_write")
        column.operator_menu_enum("relievo.levels_clear", "keep")


class RELIEVO_PT_surface(Panel, bpy.types.Panel):
    bl_label = "Relievo"
    bl_idname = "RELIEVO_PT_surface"

    def draw(self, context):
        target, column = state.source_of(context.active_object), self.column()
        options = target.relievo
        column.label(text=target.name, icon="MESH_DATA")
        fixed = column.column()
        fixed.enabled = not options.uid
        fixed.prop(options, "kind")
        fixed.prop(options, "tile_size" if options.kind == "CATMULL_CLARK" else "segments")
        fixed.prop(context.scene.relievo, "traces")
        if options.kind == "CATMULL_CLARK":
            column.prop(options, "cells")
        made = state.existing(target)
        if made is not None:
            info = made.detail.info
            column.label(text=f"{info.allocated_count} of {info.tile_count} tiles, {info.bytes / 2**20:.1f} MiB")
        if options.uid:
            column.operator("relievo.clear")
        if len(options.strokes):
            column.operator("relievo.replay")


class RELIEVO_PT_brush(Panel, bpy.types.Panel):
    bl_label = "Brush"
    bl_parent_id = "RELIEVO_PT_surface"

    def draw(self, context):
        group, column = context.scene.relievo.brush, self.column()
        for name in ("paint_mode", "color", "sculpt_mode", "height", "falloff"):
            column.prop(group, name)
            if name == "height" and group.sculpt_mode == "DRAW":
                column.prop(group, "accumulate")
        draw_table(column, group.settings)


class RELIEVO_PT_pressure(Panel, bpy.types.Panel):
    bl_label = "Pressure"
    bl_parent_id = "RELIEVO_PT_brush"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column = self.column()
        nodes = settings.curve_nodes(context.scene.relievo.brush)
        if len(nodes) < len(settings.CURVES):
            column.operator("relievo.curves")
        for name, node in nodes.items():
            column.label(text=name.capitalize())
            column.template_curve_mapping(node, "mapping")


class RELIEVO_PT_stamp(Panel, bpy.types.Panel):
    bl_label = "Stamp"
    bl_parent_id = "RELIEVO_PT_brush"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        group, column = context.scene.relievo.brush, self.column()
        column.template_ID(group, "stamp", open="image.open")
        draw_table(column, group.stamp_settings)


class RELIEVO_PT_layers(Panel, bpy.types.Panel):
    bl_label = "Layers"
    bl_parent_id = "RELIEVO_PT_surface"

    def draw(self, context):
        column = self.column()
        made = state.existing(state.source_of(context.active_object))
        try:
            layers = list(made.detail.layers) if made else []
        except rl.Busy:
            column.label(text="At work")
            return
        for layer in reversed(layers):
            row = column.row(align=True)
            icon = "BRUSH_DATA" if layer.kind == abi.RlvLayerKind.COLOR else "MOD_DISPLACE"
            active = row.operator("relievo.layer_change", text=layer.name, icon=icon, depress=bool(layer.is_active))
            active.layer, active.action = layer.id, "ACTIVATE"
            row.operator("relievo.layer_edit", text=f"{layer.opacity:.2f}").layer = layer.id
            for action, icon in (("UP", "TRIA_UP"), ("DOWN", "TRIA_DOWN"), ("MERGE", "FULLSCREEN_EXIT"), ("REMOVE", "X")):
                change = row.operator("relievo.layer_change", text="", icon=icon)
                change.layer, change.action = layer.id, action
        row = column.row(align=True)
        for kind, label in (("DISPLACEMENT", "Add displacement"), ("COLOR", "Add colour")):
            added = row.operator("relievo.layer_add", text=label)
            added.kind, added.name = kind, "Relief" if kind == "DISPLACEMENT" else "Paint"


class RELIEVO_PT_imprint(Panel, bpy.types.Panel):
    bl_label = "Imprint"
    bl_parent_id = "RELIEVO_PT_surface"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column = self.column()
        draw_table(column, context.scene.relievo.imprint)
        shown = preview.current()
        column.operator("relievo.preview", depress=shown is not None)
        if shown is not None and shown.message:
            column.label(text=shown.message, icon="ERROR")
        for text, cached, pictured in (("Imprint", False, False), ("Bake to cache", True, False), ("Bake images", False, True)):
            bake = column.operator("relievo.imprint", text=text)
            bake.cache, bake.images, bake.image_size = cached, pictured, context.scene.relievo.image_size
        options = state.source_of(context.active_object).relievo
        column.prop(options, "playback")
        column.operator("relievo.cache_clean")
        if options.playback == "HANDLER" and not context.scene.render.use_lock_interface:
            column.label(text="Renders need Render > Lock Interface", icon="INFO")


class RELIEVO_PT_result(Panel, bpy.types.Panel):
    bl_label = "Result"
    bl_parent_id = "RELIEVO_PT_surface"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column = self.column()
        column.operator("relievo.result_mesh")
        column.prop(context.scene.relievo, "image_size")
        column.operator("relievo.result_image", text="Displacement image").quantity = "DISPLACEMENT"
        column.operator("relievo.result_image", text="Colour image").quantity = "COLOR"
        for name in ("result_color", "result_ptex", "result_document", "export_scene"):
            column.operator(f"relievo.{name}")


class RELIEVO_PT_fluid(Panel, bpy.types.Panel):
    bl_label = "Fluid"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.type in fluid.TYPES

    def draw(self, context):
        target, column = context.active_object, self.column()
        options = target.relievo.fluid
        column.prop(options, "role")
        if options.role in ("FILL", "EMITTER"):
            column.prop(options, "velocity")
        elif options.role == "COLLIDER":
            column.prop(options, "contact")
            if options.contact == "FRICTION":
                column.prop(options, "slide")
        if options.role != "DOMAIN":
            return
        for name in ("spacing", "viscosity", "friction", "cohesion", "tension"):
            column.prop(options, name)
        column.prop(options, "place")
        if options.place == "FARM":
            for name in ("farm", "farm_folder", "farm_make", "farm_chunk"):
                column.prop(options, name)
            column.operator("relievo.fluid_farm")
        else:
            column.operator("relievo.fluid_simulate")
        if not options.cache:
            return
        column.label(text=f"Frames {options.first} to {options.last}")
        column.row().prop(options, "show", expand=True)
        if options.show == "SURFACE":
            for name in ("function", "cell", "smoothing"):
                column.prop(options, name)
        column.operator("relievo.fluid_mesh")
        column.operator("relievo.fluid_clear")
        column.operator("relievo.cache_clean")


class RELIEVO_PT_repair(Panel, bpy.types.Panel):
    bl_label = "Repair"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.type == "MESH"

    def draw(self, context):
        column = self.column()
        draw_table(column, context.scene.relievo.repair)
        column.operator("relievo.repair")
        for line in context.active_object.relievo.repair_report.splitlines():
            column.label(text=line)


CLASSES = [
    RELIEVO_PT_levels,
    RELIEVO_PT_fluid,
    RELIEVO_PT_repair,
    RELIEVO_PT_surface,
    RELIEVO_PT_brush,
    RELIEVO_PT_pressure,
    RELIEVO_PT_stamp,
    RELIEVO_PT_layers,
    RELIEVO_PT_imprint,
    RELIEVO_PT_result,
]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
