# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of brushes, of what is dented and of fluids: some that the add-on has, and presets that users save as
Blender's own. Presets have no lengths, which follow the object."""

import bpy
from bl_operators.presets import AddPresetBase

from ..core import settings

# Values by the kind of preset and its name, each by its path in the group.
GIVEN = {
    "brush": {
        "Draw": {"sculpt_mode": "DRAW", "falloff": "SMOOTH", "accumulate": False, "settings.strength": 1.0},
        "Clay": {"sculpt_mode": "CLAY", "falloff": "SPHERE", "settings.strength": 0.5},
        "Scrape": {"sculpt_mode": "SCRAPE", "falloff": "SPHERE", "settings.strength": 0.5},
        "Smooth": {"sculpt_mode": "SMOOTH", "falloff": "SMOOTH", "settings.strength": 0.5},
        "Inflate": {"sculpt_mode": "INFLATE", "falloff": "SMOOTH", "settings.strength": 0.3},
        "Pinch": {"sculpt_mode": "PINCH", "falloff": "SMOOTH", "settings.strength": 0.3},
        "Hard paint": {"paint_mode": "MIX", "falloff": "SPHERE", "settings.strength": 1.0, "settings.rate": 0.0},
        "Soft paint": {"paint_mode": "MIX", "falloff": "GAUSSIAN", "settings.strength": 0.5, "settings.rate": 0.0},
        "Airbrush": {"paint_mode": "MIX", "falloff": "GAUSSIAN", "settings.strength": 0.1, "settings.rate": 60.0},
        "Smear": {"paint_mode": "SMEAR", "falloff": "SMOOTH", "settings.strength": 0.8, "settings.rate": 0.0},
    },
    # Slopes are angles of repose: of dry sand 34 degrees.
    "imprint": {
        "Snow": {"share": 1.0, "smoothing": 0.2, "smoothing_passes": 1, "rim": 0.1, "repose": 0.9},
        "Sand": {"share": 1.0, "smoothing": 0.3, "smoothing_passes": 2, "rim": 0.8, "repose": 0.59},
        "Mud": {"share": 1.0, "smoothing": 0.5, "smoothing_passes": 4, "rim": 1.0, "repose": 0.35},
        "Clay": {"share": 1.0, "smoothing": 0.1, "smoothing_passes": 1, "rim": 0.5, "repose": 1.0},
        "Skin": {"share": 0.6, "smoothing": 1.0, "smoothing_passes": 8, "rim": 0.2, "repose": 0.3},
    },
    # Of olive oil and of honey at room temperature.
    "fluid": {
        "Water": {"viscosity": 1e-6, "friction": 1e-6, "cohesion": 0.0, "tension": 0.072},
        "Honey": {"viscosity": 7e-3, "friction": 7e-3, "cohesion": 0.0, "tension": 0.05},
        "Oil": {"viscosity": 9e-5, "friction": 9e-5, "cohesion": 0.0, "tension": 0.032},
    },
}
TIPS = {
    "Snow": "Packs below what presses, with hardly a rim",
    "Sand": "Rises around the print at its angle of repose",
    "Mud": "All that is pushed away rises around the print, low and wide",
    "Clay": "Keeps a sharp print and half of its rim",
    "Skin": "Gives way in part, and smoothly",
    "Water": "Thin, with the surface tension of water",
    "Honey": "Some thousand times as viscous as water; sticks to walls",
    "Oil": "A hundred times as viscous as water",
}
# Where the settings of a kind are, as Python.
PLACES = {
    "brush": "bpy.context.scene.relievo.brush",
    "imprint": "bpy.context.scene.relievo.imprint",
    "fluid": "bpy.context.object.relievo.fluid",
}
# What presets of a kind that users save have.
SAVED = {
    "brush": ["paint_mode", "sculpt_mode", "falloff", "accumulate", "color"]
    + [f"settings.{one.name}" for one in settings.RelievoBrushSettings.table if one.unit not in ("world units",)],
    "imprint": [one.name for one in settings.RelievoImprintSettings.table if one.unit != "object units"],
    "fluid": list(GIVEN["fluid"]["Water"]),
}


def group_of(context, kind):
    """Returns the settings of a kind, or None where the kind has no settings."""
    if kind != "fluid":
        return getattr(context.scene.relievo, kind)
    active = context.active_object
    return active.relievo.fluid if active is not None and active.relievo.fluid.role == "DOMAIN" else None


def put(group, path, value):
    """Sets what is at a path of names below a group."""
    *parts, name = path.split(".")
    for part in parts:
        group = getattr(group, part)
    setattr(group, name, value)


def _items(kind):
    return [(name.upper().replace(" ", "_"), name, TIPS.get(name, "")) for name in GIVEN[kind]]


class Preset:
    """An operator that sets what a preset of its kind says."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return group_of(context, cls.kind) is not None

    def execute(self, context):
        name = next(label for number, label, _tip in _items(self.kind) if number == self.preset)
        for path, value in GIVEN[self.kind][name].items():
            put(group_of(context, self.kind), path, value)
        return {"FINISHED"}


class RELIEVO_OT_preset_brush(Preset, bpy.types.Operator):
    """Have the brush be one of the add-on's; radius and height stay"""

    bl_idname = "relievo.preset_brush"
    bl_label = "Brush preset"
    kind = "brush"
    preset: bpy.props.EnumProperty(name="Brush", items=_items("brush"))


class RELIEVO_OT_preset_imprint(Preset, bpy.types.Operator):
    """Have what is dented be of a material; lengths stay"""

    bl_idname = "relievo.preset_imprint"
    bl_label = "Material of imprints"
    kind = "imprint"
    preset: bpy.props.EnumProperty(name="Material", items=_items("imprint"))


class RELIEVO_OT_preset_fluid(Preset, bpy.types.Operator):
    """Have the active domain be full of a fluid; the spacing stays"""

    bl_idname = "relievo.preset_fluid"
    bl_label = "Fluid preset"
    kind = "fluid"
    preset: bpy.props.EnumProperty(name="Fluid", items=_items("fluid"))


class Save(AddPresetBase):
    """Save the settings as a preset of your own, or remove one"""

    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        return group_of(context, cls.kind) is not None

    @property
    def preset_defines(self):
        return [f"group = {PLACES[self.kind]}"]

    @property
    def preset_values(self):
        return [f"group.{path}" for path in SAVED[self.kind]]


class Presets:
    """A menu of the presets of its kind."""

    bl_label = "Presets"
    preset_operator = "script.execute_preset"

    def draw(self, context):
        self.layout.operator_enum(f"relievo.preset_{self.kind}", "preset")
        self.layout.separator()
        if bpy.utils.preset_paths(self.preset_subdir):
            bpy.types.Menu.draw_preset(self, context)
        self.layout.operator(f"relievo.preset_save_{self.kind}", icon="ADD")
        self.layout.operator("relievo.assets_add", icon="ASSET_MANAGER")


def _saving(kind):
    """The operator and the menu of a kind of presets."""
    menu = f"RELIEVO_MT_presets_{kind}"
    common = {"kind": kind, "preset_subdir": f"relievo/{kind}"}
    saved = {"bl_idname": f"relievo.preset_save_{kind}", "bl_label": f"Save {kind} preset", "preset_menu": menu, **common}
    saved["__doc__"] = Save.__doc__
    return [
        type(f"RELIEVO_OT_preset_save_{kind}", (Save, bpy.types.Operator), saved),
        type(menu, (Presets, bpy.types.Menu), {"bl_idname": menu, **common}),
    ]


def draw_menu(layout, kind):
    """Draws the button of the presets of a kind, for the header of a panel."""
    layout.menu(f"RELIEVO_MT_presets_{kind}", text="", icon="PRESET")


CLASSES = [
    RELIEVO_OT_preset_brush,
    RELIEVO_OT_preset_imprint,
    RELIEVO_OT_preset_fluid,
    *(made for kind in GIVEN for made in _saving(kind)),
]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
