# SPDX-License-Identifier: GPL-3.0-or-later
"""Texture coordinates, colours, normals and materials between meshes of Blender and those of the library.

The library knows layers by names: that of the active one is "uv" or "color", others have their own names after that.
"""

import math
from collections import namedtuple

import librelievo as rl
import numpy

from . import mesh as meshes

# What a cage has beside its active texture coordinates: the name that the library knows it by, its kind ("uv", "color" or
# "groups"), its names in Blender, the type and domain there, and the values, None once the library has them.
Carried = namedtuple("Carried", ["key", "kind", "names", "type", "domain", "values"])
# Steps of the weights of vertex groups on a result: Blender sets one weight for many points at once.
WEIGHTS = 1024

# Numbers on points and corners that a progressive mesh keeps, and bytes of a name in the library.
NUMBERS, NAME = 16, 47
# What active layers are called where no mesh tells their names.
NAMES = {"uv": "UVMap", "color": "Color"}


def _layers(data):
    """Layers with their kinds, the active ones first."""
    active = {"uv": data.uv_layers.active, "color": data.color_attributes.active_color}
    for kind, layers in (("uv", data.uv_layers), ("color", data.color_attributes)):
        chosen = active[kind]
        if chosen is not None:
            yield kind, kind, chosen
        for layer in layers:
            if chosen is None or layer.name != chosen.name:
                yield kind, f"{kind} {layer.name}", layer


def active_names(data):
    """The names of active layers by their kinds."""
    return {kind: layer.name for kind, name, layer in _layers(data) if kind == name}


def of_triangles(data):
    """What a mesh has on its triangles: names, values and domains as the library takes them, and the names of layers that
    it has no room for."""
    count = len(data.loop_triangles)
    loops, faces = numpy.empty(3 * count, numpy.int32), numpy.empty(count, numpy.int32)
    data.loop_triangles.foreach_get("loops", loops)
    data.loop_triangles.foreach_get("polygon_index", faces)
    found, missing, room = _of_corners(data, loops, NUMBERS)
    if data.has_custom_normals:
        if room < 3:
            missing.append("custom normals")
        else:
            found.append(("normal", meshes.get_normals(data)[loops], "corner"))
    materials = meshes.get_materials(data)
    if materials is not None and len(materials) and (materials != materials[0]).any():
        found.append(("material", materials[faces].astype(numpy.uint32), "face"))
    return found, missing


def of_faces(data):
    """Returns the attributes of a mesh on its own faces, shading included, and the names of what is left out. Custom
    normals are, since faces may be turned over."""
    found, missing, _room = _of_corners(data, slice(None), math.inf)
    if data.has_custom_normals:
        missing.append("custom normals")
    materials, smooth = meshes.get_materials(data), numpy.empty(len(data.polygons), bool)
    if materials is not None and len(materials):
        found.append(("material", materials.astype(numpy.uint32), "face"))
    data.polygons.foreach_get("use_smooth", smooth)
    found.append(("smooth", smooth.astype(numpy.uint32), "face"))
    return found, missing


def _of_corners(data, loops, room):
    """Returns the layers of texture coordinates and colours at some corners of a mesh, the names of layers that have no
    room, and the room that is left, in numbers."""
    found, missing = [], []
    for kind, name, layer in _layers(data):
        width = 2 if kind == "uv" else 4
        if width > room or len(name.encode()) > NAME:
            missing.append(layer.name)
            continue
        room -= width
        if kind == "uv":
            found.append((name, meshes.get_uvs(data, layer)[loops], "corner"))
            continue
        colors = numpy.empty((len(layer.data), 4), numpy.float32)
        layer.data.foreach_get("color", colors.reshape(-1))
        is_point = layer.domain == "POINT"
        found.append((name, colors if is_point else colors[loops], "point" if is_point else "corner"))
    return found, missing, room


def put_faces(data, corners, attributes, names):
    """Gives a mesh, whose faces have these points at their corners, attributes that `of_faces` has found. `names` are
    those of active layers."""
    for found in attributes:
        values = found.values if found.indices is None else found.values[found.indices]
        kind, _, name = found.name.partition(" ")
        name = name or names.get(kind)
        if kind == "uv":
            at_corners = values[corners] if found.domain == rl.abi.RlvDomain.POINT else values
            meshes.set_uvs(data, data.uv_layers.new(name=name), numpy.ascontiguousarray(at_corners))
        elif kind == "color":
            domain = "POINT" if found.domain == rl.abi.RlvDomain.POINT else "CORNER"
            data.color_attributes.new(name, "FLOAT_COLOR", domain).data.foreach_set("color", values.reshape(-1))
        elif kind == "material":
            meshes.set_materials(data, values.reshape(-1))
        elif kind == "smooth":
            data.polygons.foreach_set("use_smooth", values.reshape(-1).astype(bool))


def put(data, level, attributes, names):
    """Gives a mesh, whose triangles are those of a level, the level's attributes. `names` are those of active layers.
    Returns whether it has materials of its own."""
    first, has_materials = {False: 0, True: 0}, False
    for info in attributes:
        is_face = info.domain == rl.abi.RlvDomain.FACE
        columns = slice(first[is_face], first[is_face] + info.width)
        first[is_face] = columns.stop
        kind, _, name = info.name.partition(" ")
        name = name or names.get(kind) or NAMES.get(kind)
        if is_face:
            if info.name == "material" and info.width == 1:
                meshes.set_materials(data, level.face_values[:, columns.start])
                has_materials = True
            continue
        values = level.wedge_values[:, columns]
        if kind == "uv" and info.width == 2:
            layer = data.uv_layers.get(name) or data.uv_layers.new(name=name)
            # There may be no more layers than eight.
            if layer is not None:
                meshes.set_uvs(data, layer, values[level.wedges.reshape(-1)])
        elif kind == "color" and info.width >= 3:
            _put_colors(data, level, name, values, info.domain == rl.abi.RlvDomain.POINT)
    return has_materials


def put_normals(data, level, attributes):
    """Gives a mesh whose points are those of a level the level's normals, if it has any beside those of its triangles."""
    first = 0
    for info in attributes:
        if info.domain != rl.abi.RlvDomain.FACE:
            if info.name == "normal" and info.width == 3:
                meshes.set_normals(data, level.wedge_values[:, first : first + 3][level.wedges.reshape(-1)])
            first += info.width


def _put_colors(data, level, name, values, is_point):
    domain = "POINT" if is_point else "CORNER"
    layer = data.color_attributes.get(name)
    if layer is None or layer.domain != domain:
        layer = data.color_attributes.new(name, "FLOAT_COLOR", domain)
    colors = numpy.ones((len(level.points if is_point else level.wedges.reshape(-1)), 4), numpy.float32)
    at_corners = values[level.wedges.reshape(-1)]
    if is_point:
        colors[level.triangles.reshape(-1), : values.shape[1]] = at_corners
    else:
        colors[:, : values.shape[1]] = at_corners
    layer.data.foreach_set("color", colors.reshape(-1))


def of_cage(target):
    """Returns what the mesh of an object carries to its result beside materials: all layers of texture coordinates in
    their order, colours, and the weights of vertex groups, four to an attribute."""
    data, found = target.data, []
    active = data.uv_layers.active
    for layer in data.uv_layers if len(data.loops) else ():
        is_active = layer.name == active.name
        values = None if is_active else meshes.get_uvs(data, layer)
        found.append(Carried("uv" if is_active else f"carried {len(found)}", "uv", [layer.name], "", "corner", values))
    for layer in data.color_attributes:
        # That of the paint's name would be in its way.
        if layer.name != meshes.PAINT and len(layer.data):
            values = numpy.empty((len(layer.data), 4), numpy.float32)
            layer.data.foreach_get("color", values.reshape(-1))
            domain = "point" if layer.domain == "POINT" else "corner"
            found.append(Carried(f"carried {len(found)}", "color", [layer.name], layer.data_type, domain, values))
    names = [group.name for group in target.vertex_groups]
    if names:
        weights = numpy.zeros((len(data.vertices), len(names)), numpy.float32)
        for number, vertex in enumerate(data.vertices):
            for element in vertex.groups:
                if element.group < len(names):
                    weights[number, element.group] = element.weight
        for first in range(0, len(names), 4):
            part = numpy.ascontiguousarray(weights[:, first : first + 4])
            found.append(Carried(f"carried {len(found)}", "groups", names[first : first + 4], "", "point", part))
    return found


def values_of(made, carried):
    """Returns what a tessellation's mesh has of attributes of its cage: pairs of what is carried and its values, at
    corners or points; without Blender's data."""
    found = []
    for entry in carried:
        attribute = made.attribute(entry.key)
        values = attribute.values if attribute.indices is None else attribute.values[attribute.indices]
        found.append((entry, numpy.ascontiguousarray(values, numpy.float32)))
    return found


def put_carried(result, found):
    """Gives a result what `values_of` has found."""
    data = result.data
    for entry, values in found:
        if entry.kind == "uv":
            layer = data.uv_layers.get(entry.names[0]) or data.uv_layers.new(name=entry.names[0], do_init=False)
            meshes.set_uvs(data, layer, values)
            if entry.key == "uv":
                data.uv_layers.active = layer
                layer.active_render = True
        elif entry.kind == "color":
            layer = data.color_attributes.get(entry.names[0])
            if layer is None:
                domain = "POINT" if entry.domain == "point" else "CORNER"
                layer = data.color_attributes.new(entry.names[0], entry.type, domain)
            layer.data.foreach_set("color", values.reshape(-1))
        else:
            for column, name in enumerate(entry.names):
                _put_weights(result, name, values[:, column])


def _put_weights(result, name, weights):
    """Gives the points of a result their weights in a group, in steps of 1/1024."""
    group = result.vertex_groups.get(name) or result.vertex_groups.new(name=name)
    steps = numpy.rint(numpy.clip(weights, 0.0, 1.0) * WEIGHTS).astype(numpy.int32)
    order = numpy.argsort(steps, kind="stable")
    levels, first = numpy.unique(steps[order], return_index=True)
    for level, points in zip(levels.tolist(), numpy.split(order, first[1:])):
        if level:
            group.add(points.tolist(), level / WEIGHTS, "REPLACE")
