# SPDX-License-Identifier: GPL-3.0-or-later
"""Handlers: documents follow Blender's undo; baked frames and previews follow the frame."""

import bpy
from bpy.app.handlers import persistent

from ..core import job
from ..data import cache, playback, progressive, state, view
from . import preview


@persistent
def after_undo(*_):
    job.interrupt()
    state.follow_all()
    preview.undone()


@persistent
def before_save(*_):
    preview.pause()
    cache.attach_all()


@persistent
def after_save(*_):
    preview.resume()


@persistent
def before_load(*_):
    preview.end()


@persistent
def after_load(*_):
    state.forget_all()
    progressive.forget_all()
    preview.undone()
    newer = [target.name for target in bpy.data.objects if target.relievo.format > state.FORMAT]
    if newer:
        print(f"Relievo: {', '.join(newer)}: edited with a newer add-on; update it to edit them")


@persistent
def graph_updated(scene, depsgraph):
    """Results follow the materials of their objects, and objects that lost their result are seen again."""
    if not playback.may_write(scene):
        return
    if depsgraph.id_type_updated("SCENE"):
        view.show_lost(scene.objects)
    if not depsgraph.id_type_updated("OBJECT"):
        return
    for update in depsgraph.updates:
        changed = update.id.original
        if isinstance(changed, bpy.types.Object) and changed.type == "MESH" and changed.relievo.result is not None:
            view.follow_materials(changed)


PLACES = [
    ("undo_post", after_undo),
    ("redo_post", after_undo),
    ("save_pre", before_save),
    ("save_post", after_save),
    ("load_pre", before_load),
    ("load_post", after_load),
    ("frame_change_post", playback.frame_changed),
    ("frame_change_post", preview.frame_changed),
    ("depsgraph_update_post", preview.graph_updated),
    ("depsgraph_update_post", graph_updated),
    ("render_init", playback.render_begins),
    ("render_complete", playback.render_ends),
    ("render_cancel", playback.render_ends),
]


def register():
    for name, function in PLACES:
        getattr(bpy.app.handlers, name).append(function)


def unregister():
    preview.end()
    for name, function in PLACES:
        getattr(bpy.app.handlers, name).remove(function)
    state.forget_all()
    progressive.forget_all()
