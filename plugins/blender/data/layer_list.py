# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of the layers of an object, the topmost first: a copy of what the detail has, since Blender's lists show
properties. What is changed in a row is changed in the detail, as one edit; what the detail cannot do goes back in the row."""

import bpy
import librelievo as rl
from bpy.app.handlers import persistent
from librelievo import abi

from ..core import job, settings
from ..core.error import Refused, said
from . import state, view

FAILURES = (Refused, rl.RelievoError, OSError)

# Whether rows are being written, so that their callbacks do nothing.
_is_filling = False


def _renamed(row, _context):
    if not _is_filling:
        change(row.id_data, row, lambda layers, number, name=row.name: layers.rename(number, name))


def _hidden(row, _context):
    if not _is_filling:
        change(row.id_data, row, lambda layers, number, shown=row.is_visible: layers.set(number, is_visible=int(shown)))


def _activated(group, _context):
    if not _is_filling and 0 <= group.active < len(group.rows):
        change(group.id_data, group.rows[group.active], lambda layers, number: layers.set_active(number))


class RelievoLayerRow(bpy.types.PropertyGroup):
    """A layer as the list shows it."""

    name: bpy.props.StringProperty(name="Name", description="The name of the layer; double click to change it", update=_renamed)
    known: bpy.props.StringProperty(description="The name that the layer has in the detail")
    number: bpy.props.IntProperty(description="The number of the layer in the detail, -1 where it is known by its name alone")
    kind: bpy.props.EnumProperty(
        name="Kind", description="What the layer has", items=settings.choices(abi.RlvLayerKind)
    )
    is_visible: bpy.props.BoolProperty(name="Visible", description="Whether the layer is seen", update=_hidden)
    is_active: bpy.props.BoolProperty(description="Whether strokes of its kind go to it")
    opacity: bpy.props.FloatProperty(description="How much of the layer is seen, 0 to 1")


class RelievoLayers(bpy.types.PropertyGroup):
    """The layers of an object as the list shows them."""

    rows: bpy.props.CollectionProperty(type=RelievoLayerRow)
    active: bpy.props.IntProperty(
        name="Active layer", description="The layer that was chosen last; strokes of its kind go to it", update=_activated
    )


def number_of(layers, row):
    """Returns the number of a row's layer. Raises Refused where it is gone."""
    found = [layer.id for layer in layers if layer.id == row.number]
    found = found or [layer.id for layer in layers if layer.name == row.known]
    if not found:
        raise Refused(f"The layer {row.known} is not there any more")
    return found[0]


def change(target, row, function):
    """Changes a layer of an object by a function of its layers and its number, and shows it."""
    try:
        if job.is_busy():
            raise Refused("Relievo is at work; wait for it, or cancel it with Esc")
        job.interrupt()
        made = state.of(target)
        number = number_of(made.detail.layers, row)
        with made.edit("layer"):
            function(made.detail.layers, number)
        made.record(target)
        job.run(view.refreshing(target, made))
    except FAILURES as failure:
        print(f"Relievo: {said(failure)}")
        made = state.existing(target)
        if made is not None and made.is_built:
            fill(target, made)


def fill(target, made):
    """Has the rows of an object be the layers of its state. Rows stay where they can: one may be being renamed."""
    layers = [
        {
            "name": layer.name,
            "known": layer.name,
            "number": layer.id,
            "kind": abi.RlvLayerKind(layer.kind).name,
            "is_visible": bool(layer.is_visible),
            "is_active": bool(layer.is_active),
            "opacity": layer.opacity,
        }
        for layer in reversed(list(made.detail.layers))
    ]
    put(target, layers)


def put(target, layers):
    """Writes rows. The one of a layer that became the active one of its kind is chosen, or else the one that was."""
    global _is_filling
    group, before = target.relievo_layers, chosen(target)
    before = None if before is None else before.number
    active = {row.number for row in group.rows if row.is_active}
    _is_filling = True
    try:
        while len(group.rows) > len(layers):
            group.rows.remove(len(group.rows) - 1)
        while len(group.rows) < len(layers):
            group.rows.add()
        for row, layer in zip(group.rows, layers):
            for name, value in layer.items():
                if getattr(row, name) != value:
                    setattr(row, name, value)
        shown = [(row.number not in active, row.number == before, -place) for place, row in enumerate(group.rows) if row.is_active]
        place = -max(shown)[2] if shown else 0
        if group.active != place:
            group.active = place
    finally:
        _is_filling = False


def chosen(target):
    """Returns the row that was chosen last, or None."""
    group = target.relievo_layers
    return group.rows[group.active] if 0 <= group.active < len(group.rows) else None


@persistent
def after_load(*_):
    """Rows of files from before there was a list, by what objects keep for strokes that are made again."""
    for target in bpy.data.objects:
        if target.library is None and target.relievo.layers and not len(target.relievo_layers.rows):
            kept = state.kept_layers(target)
            put(target, [{**_row(layer), "number": -1} for layer in reversed(kept)])


def _row(layer):
    """A layer that was kept, as a row."""
    flags = {name: bool(layer[name]) for name in ("is_visible", "is_active")}
    names = {"name": layer["name"], "known": layer["name"]}
    return {**names, **flags, "opacity": layer["opacity"], "kind": layer["kind"].upper()}


CLASSES = [RelievoLayerRow, RelievoLayers]


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Object.relievo_layers = bpy.props.PointerProperty(type=RelievoLayers)
    settings.listeners["recorded"].append(fill)
    bpy.app.handlers.load_post.append(after_load)


def unregister():
    bpy.app.handlers.load_post.remove(after_load)
    settings.listeners["recorded"].remove(fill)
    del bpy.types.Object.relievo_layers
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
