# SPDX-License-Identifier: GPL-3.0-or-later
"""Menus: all operators in Object > Relievo, which the context menu has too, and what makes objects in Add > Relievo. The
search (F3) finds what menus have."""

import bpy


class Entry:
    """An operator in a menu: its name, what it is called there, the choice that is a menu of its own, and properties."""

    def __init__(self, operator, text=None, choice=None, **properties):
        self.name = operator if "." in operator else f"relievo.{operator}"
        self.text, self.choice, self.properties = text, choice, properties

    def draw(self, layout):
        shown = {} if self.text is None else {"text": self.text}
        if self.choice is not None:
            layout.operator_menu_enum(self.name, self.choice, **shown)
            return
        drawn = layout.operator(self.name, **shown)
        for name, value in self.properties.items():
            setattr(drawn, name, value)


# What the menu of each system has; None is a line between.
MENUS = {
    "detail": (
        "Relief and Paint",
        [
            Entry("wm.tool_set_by_id", "Paint Tool", name="relievo.paint_tool"),
            Entry("wm.tool_set_by_id", "Sculpt Tool", name="relievo.sculpt_tool"),
            None,
            Entry("preset_brush", choice="preset"),
            Entry("preset_save_brush"),
            Entry("assets_add"),
            Entry("curves"),
            None,
            Entry("compact"),
            Entry("replay"),
            Entry("clear"),
        ],
    ),
    "layer": (
        "Layers",
        [
            Entry("layer_add", "Add Layer of Relief", kind="DISPLACEMENT", name="Relief"),
            Entry("layer_add", "Add Layer of Paint", kind="COLOR", name="Paint"),
            Entry("layer_change", choice="action"),
            Entry("layer_edit"),
        ],
    ),
    "imprint": (
        "Imprint",
        [
            Entry("imprint"),
            Entry("imprint", "Bake Imprint to Cache", cache=True),
            Entry("imprint", "Bake Imprint to Images", images=True),
            Entry("preview"),
            None,
            Entry("press_add"),
            Entry("press_remove"),
            Entry("imprint_again"),
            Entry("imprint_reset"),
            None,
            Entry("preset_imprint", choice="preset"),
            Entry("preset_save_imprint"),
        ],
    ),
    "result": (
        "Result",
        [
            Entry("result_mesh"),
            Entry("result_image", choice="quantity"),
            Entry("result_color"),
            Entry("result_ptex"),
            Entry("result_document"),
            Entry("export_scene"),
        ],
    ),
    "level": (
        "Levels",
        [
            Entry("levels_build"),
            Entry("wm.tool_set_by_id", "Handle Tool", name="relievo.handle_tool"),
            Entry("wm.tool_set_by_id", "Level Sculpt Tool", name="relievo.level_sculpt_tool"),
            Entry("levels_edit"),
            Entry("levels_sculpt"),
            Entry("levels_hook"),
            Entry("levels_unhook", choice="keep"),
            Entry("levels_write"),
            Entry("levels_clear", choice="keep"),
        ],
    ),
    "fluid": (
        "Fluid",
        [
            Entry("preset_fluid", choice="preset"),
            Entry("preset_save_fluid"),
            Entry("fluid_estimate"),
            Entry("fluid_simulate"),
            Entry("fluid_resume"),
            Entry("fluid_farm"),
            Entry("server_check"),
            Entry("fluid_mesh"),
            Entry("fluid_clear"),
            None,
            Entry("foam_estimate", "Estimate Foam"),
            Entry("foam_bake"),
            Entry("foam_composite"),
        ],
    ),
    "tissue": ("Soft Tissue", [Entry("tissue_estimate"), Entry("tissue_bake"), Entry("tissue_clear")]),
    "crowd": ("Crowd", [Entry("crowd_build"), Entry("crowd_refit"), Entry("crowd_show"), Entry("crowd_clear")]),
    "decal": (
        "Decal",
        [
            Entry("wm.tool_set_by_id", "Pin Tool", name="relievo.pin_tool"),
            Entry("decal_pin_add"),
            Entry("decal_pin_drag"),
            Entry("decal_pin_remove"),
            None,
            Entry("decal_mesh"),
            Entry("decal_apply"),
        ],
    ),
}
# What the menu of all systems has beside theirs.
OTHERS = [Entry("repair"), Entry("cache_clean"), None, Entry("manual"), Entry("report")]
ADDED = [
    Entry("fluid_add", "Fluid Domain", role="DOMAIN"),
    Entry("fluid_add", "Fluid Fill", role="FILL"),
    Entry("fluid_add", "Fluid Emitter", role="EMITTER"),
    Entry("levels_read"),
]


def draw_entries(layout, entries):
    """Draws entries of a menu."""
    # What operators ask for, such as a file, is asked for from menus too.
    layout.operator_context = "INVOKE_DEFAULT"
    for entry in entries:
        if entry is None:
            layout.separator()
        else:
            entry.draw(layout)


def _menu(name, label, entries):
    """The class of a menu."""

    def draw(self, _context):
        draw_entries(self.layout, entries)

    made = {"bl_label": label, "bl_idname": f"RELIEVO_MT_{name}", "draw": draw}
    return type(made["bl_idname"], (bpy.types.Menu,), made)


class RELIEVO_MT_object(bpy.types.Menu):
    bl_label = "Relievo"
    bl_idname = "RELIEVO_MT_object"

    def draw(self, _context):
        for name in MENUS:
            self.layout.menu(f"RELIEVO_MT_{name}")
        self.layout.separator()
        draw_entries(self.layout, OTHERS)


def draw_object(self, _context):
    """What the Object menu and the context menu of objects have at their end."""
    self.layout.separator()
    self.layout.menu(RELIEVO_MT_object.bl_idname)


def draw_add(self, _context):
    """What the Add menu has at its end."""
    self.layout.menu("RELIEVO_MT_add", icon="MOD_FLUIDSIM")


def draw_image(self, _context):
    """What the Image menu of the image editor has at its end."""
    self.layout.separator()
    self.layout.operator("relievo.decal_pin_image", text="Place Relievo Pin")


CLASSES = [
    *(_menu(name, label, entries) for name, (label, entries) in MENUS.items()),
    _menu("add", "Relievo", ADDED),
    RELIEVO_MT_object,
]
PLACES = [
    ("VIEW3D_MT_object", draw_object),
    ("VIEW3D_MT_object_context_menu", draw_object),
    ("VIEW3D_MT_add", draw_add),
    ("IMAGE_MT_image", draw_image),
]


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    for name, draw in PLACES:
        getattr(bpy.types, name).append(draw)


def unregister():
    for name, draw in PLACES:
        getattr(bpy.types, name).remove(draw)
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
