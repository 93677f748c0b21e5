# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of the active object: displaced mesh, images on its texture coordinates, colours of its corners, Ptex and
.relievo files."""

import os
import shutil

import bpy
import numpy
from librelievo import abi, bake, ptex

from ..core import job
from ..core.error import Refused
from ..data import cache, material, mesh, playback, state, view
from .editing import Editing


def corner_places(corners, sizes, is_triangles):
    """The tile and its u and v of every corner of a mesh with faces of these sizes."""
    sizes = sizes.astype(numpy.int64)
    first = numpy.cumsum(sizes) - sizes
    if is_triangles:
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


class ResultOperator(Editing):
    """An operator on the state of the active object, in the pose of this frame."""

    def edit(self, context, target, made):
        yield from state.placing(made, target, context.evaluated_depsgraph_get())
        made.record(target)
        yield from self.make(context, target, made)


class RELIEVO_OT_result_mesh(ResultOperator, bpy.types.Operator):
    """Make the displaced mesh, or bring it up to date"""

    bl_idname = "relievo.result_mesh"
    bl_label = "Displaced mesh"

    def make(self, _context, target, made):
        yield from view.ensuring(target, made)
        playback.pause(target)


class RELIEVO_OT_result_image(ResultOperator, bpy.types.Operator):
    """Bake an image on the texture coordinates of the object, which renders without the add-on"""

    bl_idname = "relievo.result_image"
    bl_label = "Bake image"

    quantity: bpy.props.EnumProperty(
        name="Quantity",
        items=[(value.name, value.name.capitalize(), "") for value in list(abi.RlvBakeQuantity)[:5]],
        default="DISPLACEMENT",
    )
    wire: bpy.props.BoolProperty(name="Material", description="Put it into the material", default=True)

    def make(self, context, target, made):
        if mesh.get_uvs(target.data) is None:
            raise Refused(f"{target.name} has no texture coordinates; unwrap it first")
        path = f"{cache.new(target)}_{self.quantity.lower()}.exr"
        size = context.scene.relievo.image_size
        options = {"quantity": self.quantity.lower(), "width": size, "height": size}
        yield 0.0, 1.0, lambda progress: bake.write(made.detail, path, progress, **options)
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
    bl_label = "Bake colour attribute"

    def make(self, _context, target, made):
        corners, sizes = mesh.get_corners(target.data), mesh.get_sizes(target.data)
        found = []

        def work(_progress):
            tiles, uvs = corner_places(corners, sizes, made.kind == "TRIANGLES")
            found.append(made.detail.evaluate(tiles, uvs, ["colors"])["colors"])

        yield 0.0, 1.0, work
        name = "Relievo colour"
        attribute = target.data.attributes.get(name)
        if attribute is None:
            attribute = target.data.attributes.new(name, "FLOAT_COLOR", "CORNER")
        attribute.data.foreach_set("color", found[0].reshape(-1))
        target.data.update()


class FileOperator(job.FileSteps, ResultOperator):
    """An operator that asks for a file and writes it."""

    bl_options = {"REGISTER"}


class RELIEVO_OT_result_ptex(FileOperator, bpy.types.Operator):
    """Write displacement or colours as a Ptex file"""

    bl_idname = "relievo.result_ptex"
    bl_label = "Write Ptex file"
    filename_ext = ".ptx"

    channel: bpy.props.EnumProperty(
        name="Channel", items=[("DISPLACEMENT", "Displacement", ""), ("COLOR", "Colour", "")]
    )

    def make(self, _context, _target, made):
        channel, path = self.channel.lower(), bpy.path.abspath(self.filepath)
        yield 0.0, 1.0, lambda progress: ptex.write(made.detail, channel, path, progress)


class RELIEVO_OT_result_document(FileOperator, bpy.types.Operator):
    """Write the detail with its layers and history as a .relievo document"""

    bl_idname = "relievo.result_document"
    bl_label = "Write document"
    filename_ext = ".relievo"

    def make(self, _context, _target, made):
        path = bpy.path.abspath(self.filepath)

        def work(_progress):
            made.document.sync()
            shutil.copyfile(made.path, f"{path}.part")
            os.replace(f"{path}.part", path)

        yield 0.0, 1.0, work


class RELIEVO_OT_clear(bpy.types.Operator):
    """Remove the detail of the active object: displacement, colours, layers and strokes"""

    bl_idname = "relievo.clear"
    bl_label = "Clear detail"
    bl_options = {"REGISTER", "UNDO"}
    question = "Displacement, colours, layers and strokes of the active object are removed. Undo brings them back."

    @classmethod
    def poll(cls, context):
        return state.is_editable(context)

    def invoke(self, context, event):
        return job.ask(self, context, event, self.question)

    def execute(self, context):
        job.interrupt()
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
