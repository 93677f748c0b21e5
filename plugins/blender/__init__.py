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

from . import native, preferences

# In the order in which they are registered.
MODULES = [
    "settings", "handler", "playback", "presser", "imprint", "rebake", "preview", "brush_size", "brush", "preset",
    "layer_list", "layer", "compact", "result", "scene", "progressive", "levels", "hook", "grip", "carve", "frames", "fluid",
    "fluid_add", "estimate", "farm", "unused", "repair", "crowd", "panel", "foam", "server", "tissue", "decal", "pin_tool",
    "manual", "menu",
]
_registered = []


def register():
    import importlib

    preferences.register()
    _registered.append(preferences)
    names = MODULES if native.problem() is None else ["missing", "manual"]
    for name in names:
        module = importlib.import_module(f".{name}", __package__)
        module.register()
        _registered.append(module)


def unregister():
    while _registered:
        _registered.pop().unregister()
    native.forget()
