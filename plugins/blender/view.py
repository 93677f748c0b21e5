# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of an object in Blender: a mesh object, child of the first, whose points follow the detail's commits.

Its triangles are the same for good on subdivision surfaces, so that only positions and colours are written anew; those
of triangle meshes are made anew where they have become finer.
"""

import bpy
import librelievo as rl
import numpy

from . import job, mesh, settings, state as states


def ensuring(target, state):
    """Steps that make the result object, or bring it up to date; they return it."""
    result = target.relievo.result
    if not states.is_used(result):
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
    cells = settings.cells_of(target, state.detail.info.tile_count)
    yield 0.0, 1.0, lambda _progress: follow(state, cells)
    write(target.relievo.result, state)


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
        with state.tessellation.mesh() as made:
            state.filling = mesh.Filling.of(made)
    if state.detail.info.painted_count or state.colors is not None:
        count = len(state.positions)
        if state.colors is None or len(state.colors) != count:
            state.colors = numpy.ones((count, 4), numpy.float32)
        state.tessellation.colors(out=state.colors[:, :3])
    state.seen = state.now()


# Points between two ranges that are copied with them: as quick as another call.
GAP = 4096


def _spans(ranges):
    """The ends of few spans that hold all ranges."""
    if not len(ranges):
        return []
    firsts, ends = ranges[:, 0].astype(numpy.int64), ranges.sum(1, dtype=numpy.int64)
    cuts = numpy.flatnonzero(firsts[1:] - ends[:-1] > GAP)
    return zip(firsts[[0, *(cuts + 1)]].tolist(), ends[[*cuts, -1]].tolist())


def write(result, state):
    """Writes the points and colours of a state to a result."""
    data = result.data
    if state.filling is not None or len(data.vertices) != len(state.positions):
        if state.filling is None:
            with state.tessellation.mesh() as made:
                state.filling = mesh.Filling.of(made)
        data.clear_geometry()
        state.filling.fill(data)
        state.filling = None
    mesh.set_points(data, state.positions)
    if state.colors is None and data.attributes.get("Relievo") is not None:
        state.colors = numpy.ones((len(state.positions), 4), numpy.float32)
        state.tessellation.colors(out=state.colors[:, :3])
    if state.colors is not None:
        mesh.color_attribute(data).data.foreach_set("color", state.colors.reshape(-1))
