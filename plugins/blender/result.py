# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of the active object: displaced mesh, images on its texture coordinates, colours of its corners, Ptex and
.relievo files."""

import os
import shutil

import bpy
import librelievo as rl
import numpy
from librelievo import abi, bake, ptex
from bpy_extras.io_utils import ExportHelper

from . import cache, job, material, mesh, state, view


def corner_places(target, surface):
    """The tile and its u and v of every corner of an object's mesh."""
    corners = mesh.get_corners(target.data)
    sizes = mesh.get_sizes(target.data).astype(numpy.int64)
    first = numpy.cumsum(sizes) - sizes
    if target.relievo.kind == "TRIANGLES":
        # Polygons are fanned from their first corner, a tile per triangle.
        tiles_before = numpy.cumsum(sizes - 2) - (sizes - 2)
        face = numpy.repeat(numpy.arange(len(sizes)), sizes)
        number = numpy.arange(len(corners)) - first[face]
        triangle = numpy.clip(number - 1, 0, sizes[face] - 3)
        uvs = numpy.array([[0, 0], [1, 0], [0, 1]], numpy.float32)[numpy.where(number == 0, 0, number - triangle)]
        return (tiles_before[face] + triangle).astype(numpy.uint32), uvs
    counts = numpy.where(sizes == 4, 1, sizes)
    tiles_before = numpy.cumsum(counts) - counts
    face = numpy.repeat(numpy.arange(len(sizes)), sizes)
    number = numpy.arange(len(corners)) - first[face]
    quad = sizes[face] == 4
    tiles = tiles_before[face] + numpy.where(quad, 0, number)
    uvs = numpy.array([[0, 0], [1, 0], [1, 1], [0, 1]], numpy.float32)[numpy.where(quad, number, 0)]
    return tiles.astype(numpy.uint32), uvs


class ResultOperator:
    """An operator on the state of the active object."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return state.is_editable(context)

    def execute(self, context):
        target = state.source_of(context.active_object)
        try:
            made = state.of(target)
            state.place(made, target, state.posed_points(target, context.evaluated_depsgraph_get()))
            self.make(context, target, made)
        except (state.Refused, rl.RelievoError, OSError) as failure:
            self.report({"ERROR"}, str(failure))
            return {"CANCELLED"}
        return {"FINISHED"}


class RELIEVO_OT_result_mesh(ResultOperator, bpy.types.Operator):
    """Make the displaced mesh, or bring it up to date"""

    bl_idname = "relievo.result_mesh"
    bl_label = "Displaced mesh"

    def make(self, _context, target, made):
        result = view.ensure(target, made)
        cache.stop(result)


class RELIEVO_OT_result_image(job.Steps, bpy.types.Operator):
    """Bake an image on the texture coordinates of the object, which renders without the add-on"""

    bl_idname = "relievo.result_image"
    bl_label = "Image"
    bl_options = {"REGISTER", "UNDO"}

    quantity: bpy.props.EnumProperty(
        name="Quantity",
        items=[(value.name, value.name.capitalize(), "") for value in list(abi.RlvBakeQuantity)[:5]],
        default="DISPLACEMENT",
    )
    wire: bpy.props.BoolProperty(name="Material", description="Put it into the material", default=True)

    failures = (state.Refused, rl.RelievoError, OSError)
    poll = ResultOperator.poll

    def steps(self, context):
        target = state.source_of(context.active_object)
        made = state.of(target)
        if mesh.get_uvs(target.data) is None:
            raise state.Refused(f"{target.name} has no texture coordinates; unwrap it first")
        path = cache.path_of(target, f"_{self.quantity.lower()}.exr")
        size, quantity = context.scene.relievo.image_size, self.quantity.lower()
        state.place(made, target, state.posed_points(target, context.evaluated_depsgraph_get()))
        yield 0.0, lambda: bake.write(made.detail, path, quantity=quantity, width=size, height=size)
        if self.wire and self.quantity == "DISPLACEMENT":
            material.displace(target, path)
            target.hide_render = False
        elif self.wire and self.quantity == "COLOR":
            material.color(target, path)
            target.hide_render = False
        else:
            image = bpy.data.images.load(path, check_existing=True)
            image.filepath = cache.relative(path)
            image.reload()


class RELIEVO_OT_result_color(ResultOperator, bpy.types.Operator):
    """Write the colours at the corners of the object's own mesh as a colour attribute"""

    bl_idname = "relievo.result_color"
    bl_label = "Colour attribute"

    def make(self, _context, target, made):
        tiles, uvs = corner_places(target, made.surface)
        colors = made.detail.evaluate(tiles, uvs, ["colors"])["colors"]
        name = "Relievo colour"
        found = target.data.attributes.get(name)
        if found is None:
            found = target.data.attributes.new(name, "FLOAT_COLOR", "CORNER")
        found.data.foreach_set("color", colors.reshape(-1))
        target.data.update()


class FileOperator(ResultOperator, ExportHelper):
    """An operator that writes a file."""

    bl_options = {"REGISTER"}


class RELIEVO_OT_result_ptex(FileOperator, bpy.types.Operator):
    """Write displacement or colours as a Ptex file"""

    bl_idname = "relievo.result_ptex"
    bl_label = "Ptex"
    filename_ext = ".ptx"

    channel: bpy.props.EnumProperty(
        name="Channel", items=[("DISPLACEMENT", "Displacement", ""), ("COLOR", "Colour", "")]
    )

    def make(self, _context, _target, made):
        ptex.write(made.detail, self.channel.lower(), bpy.path.abspath(self.filepath))


class RELIEVO_OT_result_document(FileOperator, bpy.types.Operator):
    """Write the detail with its layers and history as a .relievo document"""

    bl_idname = "relievo.result_document"
    bl_label = "Document"
    filename_ext = ".relievo"

    def make(self, _context, _target, made):
        made.document.sync()
        path = bpy.path.abspath(self.filepath)
        shutil.copyfile(made.path, f"{path}.part")
        os.replace(f"{path}.part", path)


class RELIEVO_OT_clear(ResultOperator, bpy.types.Operator):
    """Forget the detail of the active object: displacement, colours, layers and strokes. This cannot be undone"""

    bl_idname = "relievo.clear"
    bl_label = "Clear detail"
    bl_options = {"REGISTER"}

    def execute(self, context):
        target = state.source_of(context.active_object)
        result = target.relievo.result
        state.clear(target)
        if result is not None:
            bpy.data.objects.remove(result)
        target.display_type, target.hide_render = "TEXTURED", False
        return {"FINISHED"}


CLASSES = [
    RELIEVO_OT_result_mesh,
    RELIEVO_OT_result_image,
    RELIEVO_OT_result_color,
    RELIEVO_OT_result_ptex,
    RELIEVO_OT_result_document,
    RELIEVO_OT_clear,
]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
