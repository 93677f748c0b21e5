# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of an object in Blender: a mesh object, child of the first, whose points follow the detail's commits.

Its triangles are the same for good on subdivision surfaces, so that only positions and colours are written anew; those
of triangle meshes are made anew where they have become finer.
"""

import json
import zlib

import bpy
import librelievo as rl
import numpy

from ..core import job, settings
from . import attribute, material, mesh, state as states


def ensuring(target, state):
    """Steps that make the result object, or bring it up to date; they return it."""
    result = target.relievo.result
    if not states.is_used(result):
        result = bpy.data.objects.new(f"{target.name} Relievo", bpy.data.meshes.new(f"{target.name} Relievo"))
        result.relievo.source = target
        result.parent = target
        for collection in target.users_collection or [bpy.context.scene.collection]:
            collection.objects.link(result)
        target.relievo.result = result
        target.display_type = "BOUNDS"
        target.hide_render = True
    if result.data.users > 1:
        # Linked duplicates share their mesh; what is written here is this object's own.
        result.data = result.data.copy()
    yield from refreshing(target, state)
    return result


def ensure(target, state):
    """The result object, made or brought up to date."""
    return job.run(ensuring(target, state))


def refreshing(target, state):
    """Steps that write what changed since the last refresh to the result object, if there is one."""
    if target.relievo.result is None:
        return
    follow_materials(target)
    cells = settings.cells_of(target, state.detail.info.tile_count)
    yield 0.0, 1.0, lambda _progress: follow(state, cells)
    write(target, state)


def refresh(target, state):
    """Writes what changed since the last refresh to the result object, if there is one."""
    job.run(refreshing(target, state))


def follow(state, cells):
    """Brings the points of a state to its detail's commit, without Blender's data."""
    rebuilt = state.tessellation is None or state.cells != cells
    if rebuilt:
        options = {} if state.kind == "TRIANGLES" else {"coarse": cells, "fine": cells, "smooth_uvs": 1}
        state.tessellation, state.cells = rl.Tessellation(state.detail, **options), cells
    else:
        rebuilt = bool(state.tessellation.update().rebuilt)
    if rebuilt or state.positions is None:
        state.positions, state.colors = state.tessellation.positions(), None
    else:
        for first, end in _spans(state.tessellation.changed_ranges()):
            state.tessellation.positions(first, end - first, state.positions[first:end])
    if rebuilt:
        state.filling = _filling(state)
    if state.detail.info.painted_count or state.colors is not None:
        count = len(state.positions)
        if state.colors is None or len(state.colors) != count:
            state.colors = numpy.ones((count, 4), numpy.float32)
        state.tessellation.colors(out=state.colors[:, :3])
    state.seen = state.now()


def _filling(state):
    """Returns the triangles of a state with what its cage carries to them, without Blender's data."""
    with state.tessellation.mesh() as made:
        filling = mesh.Filling.of(made)
        filling.uvs, filling.carried = None, attribute.values_of(made, state.carried)
        state.faces = made.attribute(states.FACE).values.reshape(-1)
    return filling


def follow_materials(target):
    """Gives the result of an object the materials that the object has, slot by slot and face by face, where these have
    changed since the last time: what was assigned to the result itself stays until then."""
    result = target.relievo.result
    if not states.is_used(result):
        return
    slots, faces = [slot.material for slot in target.material_slots], mesh.get_materials(target.data)
    names = json.dumps([material and material.name_full for material in slots])
    if result.relievo.materials != names:
        _set_slots(result.data.materials, slots)
        result.relievo.materials = names
        if result.relievo.shows_paint:
            material.show_paint(result, target.relievo.ground, f"{target.name} paint")
    checksum = "" if faces is None else f"{zlib.crc32(faces):08x}"
    state = states.existing(target)
    if result.relievo.faces != checksum and state is not None and state.faces is not None:
        _set_faces(target, result, state)
        result.relievo.faces = checksum


def _show_paint(target, state):
    """Has the materials of a result show its paint; what the user should know goes to the notes of the state."""
    result = target.relievo.result
    result.relievo.shows_paint = True
    left = material.show_paint(result, target.relievo.ground, f"{target.name} paint")
    if left:
        state.notes.append(
            f"Paint is not seen in {', '.join(left)}, whose base colour has nodes or differs from the first material's: put the "
            f"attribute {mesh.PAINT} into its nodes"
        )


def reveal_paint(context):
    """Has a solid view show colour attributes in place of materials."""
    space = context.space_data
    if space is not None and space.type == "VIEW_3D" and space.shading.color_type == "MATERIAL":
        space.shading.color_type = "VERTEX"


def show_lost(targets):
    """Shows objects again whose result was deleted, or that are copies without a result of their own: they would be wires
    that do not render. The next edit makes them a result."""
    for target in targets:
        options = target.relievo
        if not options.uid or options.result is None or target.library is not None:
            continue
        if not states.is_used(options.result) or options.result.relievo.source != target:
            options.result = None
            target.display_type, target.hide_render = "TEXTURED", False


def _set_slots(materials, slots):
    while len(materials) > len(slots):
        materials.pop()
    for number, material in enumerate(slots):
        if number < len(materials):
            materials[number] = material
        else:
            materials.append(material)


def _set_faces(target, result, state):
    """Gives the triangles of a result the materials of the faces of the cage."""
    faces = mesh.get_materials(target.data)
    if len(state.faces) == len(result.data.polygons) and (faces is None or len(faces) > state.faces.max(initial=0)):
        mesh.set_materials(result.data, 0 if faces is None else faces[state.faces])
        result.data.update()


# Points between two ranges that are copied with them: as quick as another call.
GAP = 4096


def _spans(ranges):
    """The ends of few spans that hold all ranges."""
    if not len(ranges):
        return []
    firsts, ends = ranges[:, 0].astype(numpy.int64), ranges.sum(1, dtype=numpy.int64)
    cuts = numpy.flatnonzero(firsts[1:] - ends[:-1] > GAP)
    return zip(firsts[[0, *(cuts + 1)]].tolist(), ends[[*cuts, -1]].tolist())


def write(target, state):
    """Writes the points and colours of a state to the result of an object."""
    result = target.relievo.result
    data = result.data
    if state.filling is not None or len(data.vertices) != len(state.positions):
        filling, state.filling = state.filling or _filling(state), None
        data.clear_geometry()
        filling.fill(data)
        attribute.put_carried(result, filling.carried)
        _set_faces(target, result, state)
    mesh.set_points(data, state.positions)
    if state.colors is None and data.attributes.get(mesh.PAINT) is not None:
        state.colors = numpy.ones((len(state.positions), 4), numpy.float32)
        state.tessellation.colors(out=state.colors[:, :3])
    if state.colors is not None:
        if not result.relievo.shows_paint:
            _show_paint(target, state)
        mesh.color_attribute(data).data.foreach_set("color", state.colors.reshape(-1))
