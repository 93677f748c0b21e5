# SPDX-License-Identifier: GPL-3.0-or-later
"""Relievo in Blender: imprints of moving objects, painting and sculpting on tiles, levels of progressive
meshes, fluids, and their results.

An extension for Blender 4.2 and later, and an add-on for 3.4. Where the native library cannot be used, the add-on is
there all the same and its panel says what is missing.
"""

bl_info = {
    "name": "Relievo",
    "author": "The Relievo developers",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "View3D > Sidebar > Relievo",
    "description": "Surfaces that take imprints, paint and sculpting",
    "category": "Mesh",
}

from .core import native, preferences

# In the order in which they are registered.
MODULES = [
    "core.settings", "ops.handler", "data.playback", "ops.presser", "ops.imprint", "ops.rebake", "ops.preview",
    "tools.brush_size", "tools.brush", "ui.preset", "ui.asset", "data.layer_list", "ops.layer", "ops.compact", "ops.result", "ops.scene",
    "data.progressive", "ops.levels", "ops.hook", "tools.grip", "tools.carve", "data.frames", "ops.fluid", "ops.fluid_add",
    "ops.estimate", "ops.farm", "ops.unused", "ops.repair", "ops.crowd", "ops.foam", "ops.server", "ops.tissue", "ops.decal",
    "ui.lists", "ui.panel", "ui.foam_panel", "ui.server_panel", "ui.tissue_panel", "ui.decal_panel", "ui.crowd_panel",
    "tools.pin_tool", "ui.manual", "ui.menu",
]
_registered = []


def register():
    import importlib

    preferences.register()
    _registered.append(preferences)
    names = MODULES if native.problem() is None else ["ui.missing", "ui.manual"]
    for name in names:
        module = importlib.import_module(f".{name}", __package__)
        module.register()
        _registered.append(module)


def unregister():
    while _registered:
        _registered.pop().unregister()
    native.forget()
