# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes between Blender and the library, as whole arrays of 32-bit numbers.

Blender keeps positions as an attribute since 3.5; `foreach_get` copies it as it lies, some hundred times faster than
vertex by vertex, which 3.4 has to do.
"""

import bpy
import librelievo as rl
import numpy

from ..core import native


def get_points(mesh, out=None):
    """Positions (n, 3)."""
    count = len(mesh.vertices)
    if out is None or len(out) != count:
        out = numpy.empty((count, 3), numpy.float32)
    positions = mesh.attributes.get("position")
    if positions is not None:
        positions.data.foreach_get("vector", out.reshape(-1))
    else:
        mesh.vertices.foreach_get("co", out.reshape(-1))
    return out


def set_points(mesh, points):
    """Moves all points."""
    positions = mesh.attributes.get("position")
    if positions is not None:
        positions.data.foreach_set("vector", points.reshape(-1))
    else:
        mesh.vertices.foreach_set("co", points.reshape(-1))
    mesh.update()


def get_corners(mesh):
    """The point of every corner."""
    corners = numpy.empty(len(mesh.loops), numpy.int32)
    attribute = mesh.attributes.get(".corner_vert")
    if attribute is not None:
        attribute.data.foreach_get("value", corners)
    else:
        mesh.loops.foreach_get("vertex_index", corners)
    return corners.view(numpy.uint32)


def get_sizes(mesh):
    """The corners of every face."""
    sizes = numpy.empty(len(mesh.polygons), numpy.int32)
    mesh.polygons.foreach_get("loop_total", sizes)
    return sizes.view(numpy.uint32)


def get_materials(mesh):
    """The material of every face, or None where all have the first."""
    attribute = mesh.attributes.get("material_index")
    if attribute is None:
        return None
    materials = numpy.empty(len(mesh.polygons), numpy.int32)
    attribute.data.foreach_get("value", materials)
    return materials


def set_materials(mesh, materials):
    """Gives faces their materials, or all of them one. A damaged file may have numbers of materials that are not there."""
    there = numpy.clip(materials, 0, max(len(mesh.materials) - 1, 0)).astype(numpy.int32)
    attribute = mesh.attributes.get("material_index") or mesh.attributes.new("material_index", "INT", "FACE")
    attribute.data.foreach_set("value", numpy.broadcast_to(there, len(mesh.polygons)).copy())


def is_smooth(mesh):
    """Whether at least half of the faces are shaded smooth."""
    if bpy.app.version < (4, 1):
        smooth = numpy.ones(len(mesh.polygons), bool)
        mesh.polygons.foreach_get("use_smooth", smooth)
        return not len(smooth) or bool(smooth.mean() >= 0.5)
    attribute = mesh.attributes.get("sharp_face")
    sharp = numpy.zeros(len(mesh.polygons) if attribute is not None else 0, bool)
    if len(sharp):
        attribute.data.foreach_get("value", sharp)
    return not len(sharp) or bool(sharp.mean() <= 0.5)


def get_normals(mesh):
    """Normals of corners, (n, 3)."""
    normals = numpy.empty((len(mesh.loops), 3), numpy.float32)
    if bpy.app.version < (4, 1):
        mesh.calc_normals_split()
        mesh.loops.foreach_get("normal", normals.reshape(-1))
        mesh.free_normals_split()
    else:
        mesh.corner_normals.foreach_get("vector", normals.reshape(-1))
    return normals


def set_normals(mesh, normals):
    """Gives corners normals of their own, as near as Blender keeps them; it keeps them relative to the points, which have
    to be set."""
    if bpy.app.version < (4, 1):
        mesh.use_auto_smooth = True
    mesh.normals_split_custom_set(normals)


def get_creases(mesh):
    """Sharp edges with their sharpness, and sharp points with theirs, as Blender's subdivision takes them: 0 to 10 by
    the square of the crease."""
    edges = _numbers(mesh, "crease_edge", mesh.edges, "crease")
    layers = getattr(mesh, "vertex_creases", None) or ()
    points = _numbers(mesh, "crease_vert", layers[0].data if len(layers) else (), "value")
    pairs = numpy.empty((0, 2), numpy.uint32)
    strong = numpy.flatnonzero(edges > 0)
    if len(strong):
        ends = numpy.empty(2 * len(mesh.edges), numpy.int32)
        mesh.edges.foreach_get("vertices", ends)
        pairs = ends.reshape(-1, 2)[strong].astype(numpy.uint32)
    tips = numpy.flatnonzero(points > 0)
    return (pairs, edges[strong] ** 2 * 10), (tips.astype(numpy.uint32), points[tips] ** 2 * 10)


def _numbers(mesh, name, elements, field):
    """A float attribute, or the field that Blender 3.4 has instead."""
    attribute = mesh.attributes.get(name)
    if attribute is not None:
        values = numpy.empty(len(attribute.data), numpy.float32)
        attribute.data.foreach_get("value", values)
        return values
    if len(elements) and hasattr(elements[0], field):
        values = numpy.empty(len(elements), numpy.float32)
        elements.foreach_get(field, values)
        return values
    return numpy.zeros(0, numpy.float32)


def get_uvs(mesh, layer=None):
    """Texture coordinates of every corner of a layer, or of the active one, or None."""
    layer = layer or mesh.uv_layers.active
    if layer is None or not len(mesh.loops):
        return None
    uvs = numpy.empty((len(mesh.loops), 2), numpy.float32)
    attribute = mesh.attributes.get(layer.name)
    if attribute is not None and attribute.data_type == "FLOAT2":
        attribute.data.foreach_get("vector", uvs.reshape(-1))
    else:
        layer.data.foreach_get("uv", uvs.reshape(-1))
    return uvs


def set_uvs(mesh, layer, uvs):
    """Gives the corners of a layer texture coordinates."""
    attribute = mesh.attributes.get(layer.name)
    if attribute is not None and attribute.data_type == "FLOAT2":
        attribute.data.foreach_set("vector", uvs.reshape(-1))
    else:
        layer.data.foreach_set("uv", uvs.reshape(-1))


class Source:
    """What a mesh of Blender has for the library, as arrays: faces, creases and texture coordinates."""

    def __init__(self, mesh, attributes=True):
        self.points, self.corners, self.sizes = get_points(mesh), get_corners(mesh), get_sizes(mesh)
        self.creases, self.tips = get_creases(mesh) if attributes else (None, None)
        self.uvs = get_uvs(mesh) if attributes else None
        # Further attributes: names, values and domains.
        self.attributes = []

    def build(self):
        """A mesh of the library, without Blender's data."""
        creases, tips = ((pair if pair and len(pair[0]) else None) for pair in (self.creases, self.tips))
        arrays = self.points, self.corners, self.sizes
        made = rl.Mesh(native.context(), *arrays, creases=creases, sharp_points=tips)
        if self.uvs is not None:
            # Corners of a point with the same coordinates share them, so that they are subdivided as one.
            values, indices = _welded(self.corners, self.uvs)
            made.add_attribute("uv", values, "corner", indices=indices)
        for attribute in self.attributes:
            made.add_attribute(*attribute)
        return made


class Triangles:
    """The triangles of a mesh of Blender, as Blender cuts its faces, with attributes as the library takes them: names,
    values and domains."""

    def __init__(self, mesh):
        self.attributes = []
        mesh.calc_loop_triangles()
        self.points = get_points(mesh)
        self.corners = numpy.empty(3 * len(mesh.loop_triangles), numpy.int32)
        mesh.loop_triangles.foreach_get("vertices", self.corners)

    def build(self):
        """A mesh of the library, without Blender's data."""
        made = rl.Mesh(native.context(), self.points, self.corners.view(numpy.uint32), 3)
        for attribute in self.attributes:
            made.add_attribute(*attribute)
        return made


def to_native(mesh, attributes=True):
    """A mesh of the library, with creases and texture coordinates."""
    return Source(mesh, attributes).build()


def _welded(corners, uvs):
    keys = numpy.empty(len(corners), [("point", numpy.uint32), ("u", numpy.float32), ("v", numpy.float32)])
    keys["point"], keys["u"], keys["v"] = corners, uvs[:, 0], uvs[:, 1]
    _, first, indices = numpy.unique(keys, return_index=True, return_inverse=True)
    return uvs[first], indices.reshape(-1).astype(numpy.uint32)


class Filling:
    """Faces as arrays that need only be written, with texture coordinates of their corners or None: triangles, or faces
    of the sizes that are given."""

    def __init__(self, corners, count, uvs=None, sizes=None):
        self.corners, self.count, self.uvs = corners, count, uvs
        self.sizes = numpy.full(len(corners) // 3, 3, numpy.int32) if sizes is None else sizes.astype(numpy.int32)

    @classmethod
    def of(cls, made):
        """The triangles of a library's mesh."""
        uvs = None
        if "uv" in made.attribute_names():
            uv = made.attribute("uv")
            values = uv.values if uv.indices is None else uv.values[uv.indices]
            uvs = numpy.ascontiguousarray(values, numpy.float32)
        return cls(made.triangles().reshape(-1).astype(numpy.int32), made.info.point_count, uvs)

    def fill(self, mesh, is_smooth=True):
        """Puts the faces into an empty mesh of Blender; its points are still to be set."""
        count = len(self.sizes)
        mesh.vertices.add(self.count)
        mesh.loops.add(len(self.corners))
        mesh.polygons.add(count)
        mesh.polygons.foreach_set("loop_start", numpy.cumsum(self.sizes, dtype=numpy.int32) - self.sizes)
        if bpy.app.version < (4, 0):
            mesh.polygons.foreach_set("loop_total", self.sizes)
        corners = mesh.attributes.get(".corner_vert")
        if corners is not None:
            corners.data.foreach_set("value", self.corners)
        else:
            mesh.loops.foreach_set("vertex_index", self.corners)
        if bpy.app.version < (4, 1):
            mesh.polygons.foreach_set("use_smooth", numpy.full(count, is_smooth))
        elif not is_smooth:
            # Later ones are smooth unless they say that they are not.
            mesh.shade_flat()
        mesh.update(calc_edges=True)
        if self.uvs is not None:
            set_uvs(mesh, mesh.uv_layers.new(name="UVMap"), self.uvs)


# The name of the attribute that paint goes to.
PAINT = "Relievo"


def color_attribute(mesh):
    """The attribute that paint goes to, made if it is missing: then it is the one that the view shows."""
    found = mesh.attributes.get(PAINT)
    if found is None:
        found = mesh.attributes.new(PAINT, "FLOAT_COLOR", "POINT")
        mesh.color_attributes.active_color = mesh.color_attributes[PAINT]
        mesh.color_attributes.render_color_index = mesh.color_attributes.active_color_index
        # Making it the active one may move the attributes.
        found = mesh.attributes[PAINT]
    return found


def matrix_of(matrix):
    """A matrix of Blender as rows of doubles."""
    return numpy.array([list(row) for row in matrix])
