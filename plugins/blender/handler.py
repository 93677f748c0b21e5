# SPDX-License-Identifier: GPL-3.0-or-later
"""Handlers: documents follow Blender's undo and are put into the file when it is saved."""

import bpy
from bpy.app.handlers import persistent

from . import state


@persistent
def after_undo(*_):
    state.follow_all()


@persistent
def before_save(*_):
    state.pack_all()


@persistent
def after_load(*_):
    state.forget_all()
    newer = [target.name for target in bpy.data.objects if target.relievo.format > state.FORMAT]
    if newer:
        print(f"Relievo: {', '.join(newer)}: edited with a newer add-on; update it to edit them")


PLACES = [
    ("undo_post", after_undo),
    ("redo_post", after_undo),
    ("save_pre", before_save),
    ("load_post", after_load),
]


def register():
    for name, function in PLACES:
        getattr(bpy.app.handlers, name).append(function)


def unregister():
    for name, function in PLACES:
        getattr(bpy.app.handlers, name).remove(function)
    state.forget_all()
