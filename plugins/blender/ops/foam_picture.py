# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of a scene with foam over it. Cycles or EEVEE renders the picture, and the depths of all objects and of all
but fluids, by a material that shines with the depth; the library does the rest (Akinci et al. 2013)."""

import os
import tempfile

import bpy
import librelievo as rl
import numpy

from ..core import native
from ..core.error import Refused

NAME = "Relievo depth"


class View:
    """The camera of a scene as the library takes it."""

    def __init__(self, scene):
        camera, render = scene.camera, scene.render
        if camera is None or camera.type != "CAMERA" or camera.data.type not in {"PERSP", "ORTHO"}:
            raise Refused("Give the scene a perspective or orthographic camera")
        share = render.resolution_percentage / 100
        self.size = int(render.resolution_x * share), int(render.resolution_y * share)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        placed = camera.evaluated_get(depsgraph)
        aspect = {"scale_x": render.pixel_aspect_x, "scale_y": render.pixel_aspect_y}
        matrix = placed.calc_matrix_camera(depsgraph, x=self.size[0], y=self.size[1], **aspect)
        is_parallel = camera.data.type == "ORTHO"
        # Of a lens that is shifted the middle of the picture is not along the direction of view.
        shift = (matrix[0][3], matrix[1][3]) if is_parallel else (matrix[0][2], matrix[1][2])
        if max(map(abs, shift)) > 1e-5 or abs(render.pixel_aspect_x / render.pixel_aspect_y - 1) > 1e-5:
            raise Refused("Foam is composited with square pixels and a camera without shift")
        x, y, z = (numpy.array(column[:3], float) for column in placed.matrix_world.transposed()[:3])
        eye = numpy.array(placed.matrix_world.translation, float)
        self.options = {"eye": eye, "target": eye - z / numpy.linalg.norm(z), "up": y / numpy.linalg.norm(y)}
        if is_parallel:
            self.options["orthographic"] = 2 / matrix[1][1]
        else:
            self.options["fov"] = 2 * numpy.arctan(1 / matrix[1][1])


def depth_material():
    """Returns a material that shines with the depth along the direction of view."""
    made = bpy.data.materials.new(NAME)
    if made.node_tree is None:
        made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    camera, shine, output = (nodes.new(f"ShaderNode{kind}") for kind in ("CameraData", "Emission", "OutputMaterial"))
    links.new(camera.outputs["View Z Depth"], shine.inputs["Color"])
    links.new(shine.outputs[0], output.inputs["Surface"])
    return made


class Hidden:
    """Keeps objects out of renders while a block runs."""

    def __init__(self, objects):
        self.before = [(one, one.hide_render) for one in objects]

    def __enter__(self):
        for one, _was in self.before:
            one.hide_render = True

    def __exit__(self, *_failure):
        for one, was in self.before:
            one.hide_render = was


def rendered(scene, folder, name):
    """Renders a scene. Returns the pixels (height, width, 4), scene-linear, rows from the top."""
    path = os.path.join(folder, f"{name}.exr")
    scene.render.filepath = path
    bpy.ops.render.render(scene=scene.name, write_still=True)
    image = bpy.data.images.load(path)
    try:
        image.colorspace_settings.name = "Non-Color"
        width, height = image.size
        pixels = numpy.empty(width * height * image.channels, numpy.float32)
        image.pixels.foreach_get(pixels)
        pixels = pixels.reshape(height, width, image.channels)[::-1]
    finally:
        bpy.data.images.remove(image)
    return numpy.ascontiguousarray(pixels)


def plain(scene):
    """Changes a scene to one whose pictures have one sample a pixel, at its middle, and no background."""
    scene.world = None
    scene.render.film_transparent = False
    scene.render.use_motion_blur = False
    scene.render.filter_size = 0.01
    cycles, eevee = getattr(scene, "cycles", None), scene.eevee
    if cycles is not None:
        cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = 1, False, False
        cycles.pixel_filter_type, cycles.filter_width = "BOX", 0.01
    eevee.taa_render_samples = 1


class Picture:
    """A picture of the present frame of a scene, and the depths about its foam."""

    def __init__(self, scene, fluids, foams):
        """Renders a scene, of which some objects are fluids and some show foam."""
        self.scene, self.view, self.pixels = scene, View(scene), None
        copied, override = scene.copy(), depth_material()
        try:
            settings = copied.render.image_settings
            settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGBA", "32"
            copied.render.use_border = copied.render.use_compositing = copied.render.use_sequencer = False
            with tempfile.TemporaryDirectory() as folder, Hidden(foams):
                self.background = rendered(copied, folder, "picture")
                plain(copied)
                for layer in copied.view_layers:
                    layer.material_override = override
                every = rendered(copied, folder, "every")[..., 0]
                with Hidden(fluids):
                    self.solids = rendered(copied, folder, "solids")[..., 0]
        finally:
            bpy.data.scenes.remove(copied)
            bpy.data.materials.remove(override)
        # Where a fluid is nearest, the depths differ.
        is_fluid = (every > 0) & ((self.solids <= 0) | (every < self.solids * (1 - 1e-5)))
        self.fluid = numpy.where(is_fluid, every, 0).astype(numpy.float32)

    def composite(self, found, look, light, progress):
        """Lays particles over the picture; without Blender's data."""
        options = {**self.view.options, "solids": self.solids, "fluid": self.fluid, **look}
        with rl.Foam(native.context(), self.view.size, **options) as foam:
            foam.add(*(found[name] for name in ("positions", "ids", "kinds", "lives", "velocities")))
            foam.shade(numpy.broadcast_to(numpy.float32(light), (1, 2, 3)), progress=progress)
            self.pixels = foam.composite(self.background)

    def write(self, path):
        """Writes the picture: .exr scene-linear, .png as the scene shows colours."""
        height, width = self.pixels.shape[:2]
        image = bpy.data.images.new("Relievo foam", width, height, alpha=True, float_buffer=True)
        try:
            image.colorspace_settings.name = "Non-Color"
            image.pixels.foreach_set(numpy.ascontiguousarray(self.pixels[::-1]).ravel())
            settings = self.scene.render.image_settings
            before = settings.file_format, settings.color_mode, settings.color_depth
            is_exr = path.lower().endswith(".exr")
            try:
                settings.file_format = "OPEN_EXR" if is_exr else "PNG"
                settings.color_mode, settings.color_depth = "RGBA", "32" if is_exr else "8"
                image.save_render(path, scene=self.scene)
            finally:
                settings.file_format, settings.color_mode, settings.color_depth = before
        finally:
            bpy.data.images.remove(image)
