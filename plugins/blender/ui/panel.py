# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels in the sidebar, made from the library's tables of parameters."""

import textwrap

import bpy

from ..core import settings
from ..data import progressive, state
from ..ops import fluid, presser, preview
from . import preset


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


def draw_rest(layout, group, *others):
    """The parameters of a group that was made from a table, but parameters that panels have elsewhere."""
    for parameter in group.table:
        if parameter.name not in others:
            layout.prop(group, parameter.name)


# Settings that are seen at once; the rest is folded away in panels called Advanced.
BRUSH = ("radius", "strength")
SYMMETRY = ("symmetry_x", "symmetry_y", "symmetry_z")
PRESSURE = ("strength_pressure", "size_pressure", "angle_pressure")
JITTER = ("jitter_position", "jitter_size", "jitter_strength", "jitter_angle")
IMPRINT = ("max_displacement", "share", "smoothing", "rim", "rim_width", "repose")
REPAIR = ("tolerance", "fill")


class Advanced(Panel):
    """A folded panel of the settings that are seldom changed."""

    bl_label = "Advanced"
    bl_options = {"DEFAULT_CLOSED"}


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
        if options.kind == "CATMULL_CLARK":
            column.prop(options, "cells")
        made = state.existing(target)
        if made is not None:
            info = made.detail.info
            column.label(text=f"{info.allocated_count} of {info.tile_count} tiles, {info.bytes / 2**20:.1f} MiB")


class RELIEVO_PT_history(Advanced, bpy.types.Panel):
    bl_label = "History"
    bl_parent_id = "RELIEVO_PT_surface"

    def draw(self, context):
        options, column = state.source_of(context.active_object).relievo, self.column()
        column.label(text=f"{len(options.strokes)} strokes")
        for name in ("compact", "replay", "clear"):
            column.operator(f"relievo.{name}")


class RELIEVO_PT_brush(Panel, bpy.types.Panel):
    bl_label = "Brush"
    bl_parent_id = "RELIEVO_PT_surface"

    def draw_header_preset(self, _context):
        preset.draw_menu(self.layout, "brush")

    def draw(self, context):
        group, column = context.scene.relievo.brush, self.column()
        for name in ("paint_mode", "color", "sculpt_mode", "height"):
            column.prop(group, name)
        if group.sculpt_mode == "DRAW":
            column.prop(group, "accumulate")
        for name in BRUSH:
            column.prop(group.settings, name)
        column.prop(group, "falloff")
        draw_symmetry(column, group.settings)


def draw_symmetry(layout, group):
    """The axes at which strokes are mirrored, as buttons beside each other."""
    row = layout.row(align=True, heading="Symmetry")
    for name in SYMMETRY:
        row.prop(group, name, toggle=True)


class RELIEVO_PT_pressure(Advanced, bpy.types.Panel):
    bl_label = "Pressure"
    bl_parent_id = "RELIEVO_PT_brush"

    def draw(self, context):
        group, column = context.scene.relievo.brush, self.column()
        for name in PRESSURE:
            column.prop(group.settings, name)
        nodes = settings.curve_nodes(group)
        if len(nodes) < len(settings.CURVES):
            column.operator("relievo.curves")
        for name, node in nodes.items():
            column.label(text=f"{name.capitalize()} by pressure")
            column.template_curve_mapping(node, "mapping")


class RELIEVO_PT_jitter(Advanced, bpy.types.Panel):
    bl_label = "Jitter"
    bl_parent_id = "RELIEVO_PT_brush"

    def draw(self, context):
        group, column = context.scene.relievo.brush.settings, self.column()
        for name in (*JITTER, "seed"):
            column.prop(group, name)


class RELIEVO_PT_brush_advanced(Advanced, bpy.types.Panel):
    bl_parent_id = "RELIEVO_PT_brush"

    def draw(self, context):
        draw_rest(
            self.column(), context.scene.relievo.brush.settings, *BRUSH, *SYMMETRY, *PRESSURE, *JITTER, "seed"
        )


class RELIEVO_PT_stamp(Advanced, bpy.types.Panel):
    bl_label = "Stamp"
    bl_parent_id = "RELIEVO_PT_brush"

    def draw(self, context):
        group, column = context.scene.relievo.brush, self.column()
        column.template_ID(group, "stamp", open="image.open")
        draw_rest(column, group.stamp_settings)


class RELIEVO_PT_layers(Panel, bpy.types.Panel):
    bl_label = "Layers"
    bl_parent_id = "RELIEVO_PT_surface"

    def draw(self, context):
        target, column = state.source_of(context.active_object), self.column()
        group = target.relievo_layers
        row = column.row()
        row.template_list("RELIEVO_UL_layers", "", group, "rows", group, "active", rows=3)
        buttons = row.column(align=True)
        buttons.operator_menu_enum("relievo.layer_add", "kind", text="", icon="ADD")
        for action, icon in (("REMOVE", "REMOVE"), ("UP", "TRIA_UP"), ("DOWN", "TRIA_DOWN"), ("MERGE", "FULLSCREEN_EXIT")):
            buttons.operator("relievo.layer_change", text="", icon=icon).action = action
        if len(group.rows):
            column.operator("relievo.layer_edit", text="Opacity and Blending")
        else:
            column.label(text="Paint or sculpt, and layers are here", icon="INFO")


class RELIEVO_PT_imprint(Panel, bpy.types.Panel):
    bl_label = "Imprint"
    bl_parent_id = "RELIEVO_PT_surface"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header_preset(self, _context):
        preset.draw_menu(self.layout, "imprint")

    def draw(self, context):
        target, column = state.source_of(context.active_object), self.column()
        draw_pressers(column, target.relievo_press)
        for name in IMPRINT:
            column.prop(context.scene.relievo.imprint, name)
        shown = preview.current()
        column.operator("relievo.preview", depress=shown is not None)
        if shown is not None and shown.message:
            column.label(text=shown.message, icon="ERROR")
        for text, cached, pictured in (("Imprint", False, False), ("Bake to cache", True, False), ("Bake images", False, True)):
            bake = column.operator("relievo.imprint", text=text)
            bake.cache, bake.images, bake.image_size = cached, pictured, context.scene.relievo.image_size
        result = target.relievo.result
        if state.is_used(result):
            frames = max(context.scene.frame_end - context.scene.frame_start + 1, 0)
            size = 12 * len(result.data.vertices) * frames / 2**20
            column.label(text=f"A cache of {frames} frames has {size:.3g} MiB")
        draw_imprint(column, context.scene, target)


def draw_pressers(layout, options):
    """The list of what presses, and the settings of the active entry if it has its own."""
    row = layout.row()
    row.template_list("RELIEVO_UL_pressers", "", options, "pressers", options, "active", rows=2)
    buttons = row.column(align=True)
    buttons.operator("relievo.press_add", text="", icon="ADD")
    buttons.operator("relievo.press_remove", text="", icon="REMOVE")
    layout.prop(options, "collection")
    if not presser.is_listed(options):
        layout.label(text="Without a list, selected objects press", icon="INFO")
    elif 0 <= options.active < len(options.pressers) and options.pressers[options.active].has_own:
        own = layout.box().column()
        for name in IMPRINT:
            own.prop(options.pressers[options.active].settings, name)


def draw_imprint(layout, scene, target):
    """What the last imprint did, what this frame shows of it, and how it is made again."""
    options = target.relievo_press
    if options.is_there:
        layout.label(text=options.report, icon="CHECKMARK")
        if not target.relievo.cache and scene.frame_current != options.last:
            layout.label(text=f"Shows frame {options.last}: without a cache, all do", icon="INFO")
        row = layout.row(align=True)
        row.operator("relievo.imprint_again")
        row.operator("relievo.imprint_reset", text="Reset")
    if target.relievo.cache:
        layout.prop(target.relievo, "playback")
        if target.relievo.playback == "HANDLER" and not scene.render.use_lock_interface:
            layout.label(text="Renders need Render > Lock Interface", icon="INFO")


class RELIEVO_PT_imprint_advanced(Advanced, bpy.types.Panel):
    bl_parent_id = "RELIEVO_PT_imprint"

    def draw(self, context):
        column = self.column()
        draw_rest(column, context.scene.relievo.imprint, *IMPRINT)
        column.prop(context.scene.relievo, "traces")
        column.operator("relievo.cache_clean")


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

    def draw_header_preset(self, _context):
        preset.draw_menu(self.layout, "fluid")

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
        for name in ("spacing", "viscosity"):
            column.prop(options, name)
        column.prop(options, "place")
        if options.place == "FARM":
            for name in ("farm", "farm_folder", "farm_make", "farm_chunk"):
                column.prop(options, name)
            column.operator("relievo.fluid_farm")
        else:
            column.operator("relievo.fluid_estimate")
            if options.estimate:
                column.label(text=options.estimate)
            column.operator("relievo.fluid_simulate")
        if not options.cache:
            return
        column.label(text=f"Frames {options.first} to {options.last}")
        if options.last < context.scene.frame_end and options.place == "HERE":
            column.operator("relievo.fluid_resume", text=f"Resume at frame {options.last + 1}")
        column.row().prop(options, "show", expand=True)
        column.operator("relievo.fluid_mesh")
        column.operator("relievo.fluid_clear")
        column.operator("relievo.cache_clean")


class RELIEVO_PT_fluid_advanced(Advanced, bpy.types.Panel):
    bl_parent_id = "RELIEVO_PT_fluid"

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.relievo.fluid.role == "DOMAIN"

    def draw(self, context):
        options, column = context.active_object.relievo.fluid, self.column()
        for name in ("friction", "cohesion", "tension"):
            column.prop(options, name)
        column.separator()
        for name in ("function", "cell", "smoothing"):
            column.prop(options, name)


class RELIEVO_PT_repair(Panel, bpy.types.Panel):
    bl_label = "Repair"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.type == "MESH"

    def draw(self, context):
        column = self.column()
        for name in REPAIR:
            column.prop(context.scene.relievo.repair, name)
        column.operator("relievo.repair")
        for line in context.active_object.relievo.repair_report.splitlines():
            column.label(text=line)


class RELIEVO_PT_repair_advanced(Advanced, bpy.types.Panel):
    bl_parent_id = "RELIEVO_PT_repair"

    @classmethod
    def poll(cls, context):
        return RELIEVO_PT_repair.poll(context)

    def draw(self, context):
        draw_rest(self.column(), context.scene.relievo.repair, *REPAIR)


CLASSES = [
    RELIEVO_PT_levels,
    RELIEVO_PT_fluid,
    RELIEVO_PT_fluid_advanced,
    RELIEVO_PT_repair,
    RELIEVO_PT_repair_advanced,
    RELIEVO_PT_surface,
    RELIEVO_PT_brush,
    RELIEVO_PT_pressure,
    RELIEVO_PT_jitter,
    RELIEVO_PT_stamp,
    RELIEVO_PT_brush_advanced,
    RELIEVO_PT_layers,
    RELIEVO_PT_imprint,
    RELIEVO_PT_imprint_advanced,
    RELIEVO_PT_result,
    RELIEVO_PT_history,
]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
