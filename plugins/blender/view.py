# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of an object in Blender: a mesh object, child of the first, whose points follow the detail's commits.

Its triangles are the same for good on subdivision surfaces, so that only positions and colours are written anew; those
of triangle meshes are made anew where they have become finer.
"""

import bpy
import librelievo as rl
import numpy

from . import mesh


def ensure(target, state):
    """The result object, made or brought up to date."""
    result = target.relievo.result
    if result is None or result.name not in bpy.data.objects:
        result = bpy.data.objects.new(f"{target.name} Relievo", bpy.data.meshes.new(f"{target.name} Relievo"))
        result.relievo.source = target
        result.parent = target
        for collection in target.users_collection or [bpy.context.scene.collection]:
            collection.objects.link(result)
        for material in target.data.materials:
            result.data.materials.append(material)
        target.relievo.result = result
        target.display_type = "WIRE"
        target.hide_render = True
    refresh(target, state)
    return result


def refresh(target, state):
    """Writes what changed since the last refresh to the result object, if there is one."""
    result = target.relievo.result
    if result is None:
        return
    cells = int(target.relievo.cells)
    options = {"coarse": cells, "fine": cells, "smooth_uvs": 1} if target.relievo.kind == "CATMULL_CLARK" else {}
    rebuilt = state.tessellation is None or state.cells != cells
    if rebuilt:
        state.tessellation, state.cells = rl.Tessellation(state.detail, **options), cells
    else:
        rebuilt = bool(state.tessellation.update().rebuilt)
    count = state.tessellation.info.point_count
    if rebuilt or state.positions is None:
        state.positions, state.colors = state.tessellation.positions(), None
    else:
        for first, length in state.tessellation.changed_ranges().tolist():
            state.tessellation.positions(first, length, state.positions[first : first + length])
    data = result.data
    if rebuilt or len(data.vertices) != count:
        data.clear_geometry()
        with state.tessellation.mesh() as made:
            mesh.fill(data, made)
    else:
        mesh.set_points(data, state.positions)
    _color(data, state, count)


def _color(data, state, count):
    """Colours, once something was painted."""
    if not state.detail.info.painted_count and data.attributes.get("Relievo") is None:
        return
    if state.colors is None or len(state.colors) != count:
        state.colors = numpy.ones((count, 4), numpy.float32)
    state.tessellation.colors(out=state.colors[:, :3])
    mesh.color_attribute(data).data.foreach_set("color", state.colors.reshape(-1))
