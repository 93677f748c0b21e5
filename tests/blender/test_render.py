"""Baked results in renders without the add-on: what is wired into a material and what the Mesh Cache plays look the same
in Cycles whether the add-on is there or not."""

import json
import os
import subprocess
import sys
import unittest
from pathlib import Path

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host

RENDER = r"""
import json, sys
import bpy
for line in sys.stdin:
    path, out, frame = json.loads(line)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert not hasattr(bpy.types.Object, "relievo") and "relievo" not in sys.modules
    bpy.context.scene.frame_set(frame)
    bpy.context.scene.render.filepath = out
    bpy.ops.render.render(write_still=True)
    print("rendered", out, flush=True)
"""
SIZE = 48


@unittest.skipUnless("cycles" in bpy.context.preferences.addons or hasattr(bpy.types.Scene, "cycles"), "skipped: no Cycles")
class Renders(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        # A process of this host where the add-on was never enabled.
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        cls.bare = subprocess.Popen(host.command(RENDER), text=True, **pipes)

    @classmethod
    def tearDownClass(cls):
        cls.bare.communicate()

    def setUp(self):
        self.relievo = host.empty()
        scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        scene.cycles.device, scene.cycles.samples, scene.cycles.seed = "CPU", 4, 0
        scene.cycles.use_denoising = False
        scene.render.resolution_x = scene.render.resolution_y = SIZE
        scene.render.resolution_percentage = 100
        scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
        # The picture is the height and the colour themselves: the camera looks down along z.
        scene.view_layers[0].use_pass_z = False
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        camera.data.type, camera.data.ortho_scale = "ORTHO", 2.0
        camera.location.z = 3
        scene.collection.objects.link(camera)
        scene.camera = camera
        sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
        sun.rotation_euler, sun.data.energy = (0.9, 0, 0.4), 3.0
        scene.collection.objects.link(sun)

    def bare_render(self, path, frame):
        """Returns a picture of a frame of a file as the process without the add-on renders it."""
        out = f"{path}.{frame}.bare"
        self.bare.stdin.write(json.dumps([path, out, frame]) + "\n")
        self.bare.stdin.flush()
        said = []
        while not said or said[-1] != f"rendered {out}\n":
            line = self.bare.stdout.readline()
            self.assertTrue(line, "".join(said))
            said.append(line)
        return self.picture(out)

    def render(self, path, frame):
        """Renders a frame of a file in this process, with the add-on, and returns the picture."""
        bpy.ops.wm.open_mainfile(filepath=path)
        self.assertIn("relievo", bpy.context.preferences.addons)
        scene, out = bpy.context.scene, f"{path}.{frame}.addon"
        scene.frame_set(frame)
        scene.render.filepath = out
        bpy.ops.render.render(write_still=True)
        return self.picture(out)

    def picture(self, out):
        """Returns the pixels of a picture: rows from the top, linear."""
        image = bpy.data.images.load(f"{out}.exr" if os.path.exists(f"{out}.exr") else out)
        pixels = numpy.empty(SIZE * SIZE * image.channels, numpy.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
        return pixels.reshape(SIZE, SIZE, -1)[::-1, :, :3]

    def baked(self, folder, **options):
        field, ball = host.field(), host.ball(0.3)
        for frame, x in ((1, -0.6), (3, 0.6)):
            ball.location = (x, 0.25, 0.2)
            ball.keyframe_insert("location", frame=frame)
        ball.hide_render = True
        scene = bpy.context.scene
        scene.frame_start, scene.frame_end = 1, 3
        scene.relievo.imprint.voxels = 2**18
        path = os.path.join(folder, "baked.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        host.select(field, ball)
        self.assertEqual(bpy.ops.relievo.imprint(**options), {"FINISHED"})
        return path, field

    def test_the_mesh_cache_renders_without_the_addon(self):
        with host.folder() as folder:
            path, _field = self.baked(folder, cache=True)
            bpy.ops.wm.save_mainfile()
            without = {frame: self.bare_render(path, frame) for frame in (1, 3)}
            numpy.testing.assert_allclose(self.render(path, 3), without[3], atol=1e-5)
            self.assertGreater(float(numpy.abs(without[3] - without[1]).max()), 0.1)

    def test_hooks_of_levels_are_rendered_where_they_are(self):
        """The camera looks from above on a ball; a hook draws its side out."""
        ball, hook = host.ball(0.4, rings=24), bpy.data.objects.new("hook", None)
        host.select(ball)
        bpy.ops.relievo.levels_build()
        ball.relievo.progressive.ratio = 0.1
        scene = bpy.context.scene
        scene.collection.objects.link(hook)
        for frame, x in ((1, 0.4), (3, 0.8)):
            hook.location = (x, 0, 0)
            hook.keyframe_insert("location", frame=frame)
        scene.frame_set(1)
        host.select(ball, hook)
        self.assertEqual(bpy.ops.relievo.levels_hook(radius=0.4), {"FINISHED"})
        ball.relievo.progressive.ratio = 1.0
        scene.render.film_transparent, scene.frame_start, scene.frame_end = True, 1, 3
        reached = []
        with host.folder() as folder:
            scene.render.filepath = os.path.join(folder, "hooked")
            bpy.ops.render.render(animation=True)
            for frame in (1, 2, 3):
                image = bpy.data.images.load(os.path.join(folder, f"hooked{frame:04}.exr"))
                pixels = numpy.array(image.pixels[:]).reshape(SIZE, SIZE, -1)
                reached.append(2.0 * numpy.flatnonzero((pixels[..., 3] > 0.5).any(0)).max() / SIZE - 1.0)
        self.assertAlmostEqual(reached[0], 0.4, delta=0.05)
        self.assertTrue(reached[0] + 0.05 < reached[1] < reached[2] - 0.05, reached)

    def test_images_in_the_material_render_without_the_addon(self):
        with host.folder() as folder:
            path, field = self.baked(folder, images=True, image_size=128)
            field.relievo.result.hide_render, field.hide_render = True, False
            bpy.ops.wm.save_mainfile()
            without = {frame: self.bare_render(path, frame) for frame in (1, 3)}
            self.assertGreater(float(numpy.abs(without[3] - without[1]).max()), 0.1)
            # The track of the ball is where it went: x from -0.6 to 0.6 at y = 0.25, and nowhere else.
            flat = numpy.median(without[3].reshape(-1, 3), axis=0)
            touched = numpy.abs(without[3] - flat).max(2) > 0.05
            # The outline of the sheet is not looked at.
            rows = 3 + numpy.flatnonzero(touched[3:-3, 3:-3].any(1))
            height = 1.0 - 2.0 * (rows + 0.5) / SIZE
            self.assertLess(numpy.abs(height - 0.25).max(), 0.4)
            first = numpy.abs(without[1] - flat).max(2) > 0.05
            self.assertGreater(touched.sum(), 1.5 * first.sum())
            # It is the displaced mesh that the result is.
            field.hide_render, field.relievo.result.hide_render = True, False
            bpy.context.scene.frame_set(3)
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "mesh.blend"))
            mesh = self.bare_render(os.path.join(folder, "mesh.blend"), 3)
            self.assertLess(float(numpy.abs(mesh - without[3]).mean()), 0.06)
            numpy.testing.assert_allclose(self.render(path, 3), without[3], atol=1e-5)

    def test_paint_renders_from_the_first_stroke(self):
        """Beside a mesh of the same material without paint, which stays as it was."""
        scene = bpy.context.scene
        scene.render.resolution_x = scene.render.resolution_y = 8
        scene.cycles.samples = 1
        with host.folder() as folder:
            for material in (None, bpy.data.materials.new("blue")):
                field, other = host.field(), host.field(1, "other")
                field.location.x, other.location.x = -1, 1
                if material is not None:
                    material.use_nodes = True
                    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.05, 0.05, 0.6, 1)
                    for one in (field, other):
                        one.data.materials.append(material)
                bpy.context.view_layer.update()
                host.draw(field, [[-1, 0.5, 0], [-0.8, 0.5, 0]], "PAINT", radius=0.8, color=(1, 0, 0, 1), falloff="CONSTANT")
                scene.camera.data.ortho_scale = 4.0
                scene.render.filepath = os.path.join(folder, "paint.exr")
                bpy.ops.render.render(write_still=True)
                image = bpy.data.images.load(scene.render.filepath, check_existing=False)
                pixels = numpy.array(image.pixels[:]).reshape(8, 8, -1)[::-1]
                painted, plain, beside = pixels[2, 1], pixels[5, 1], pixels[3, 6]
                self.assertGreater(painted[0], 3 * max(painted[1:3]))
                for pixel in (plain, beside):
                    if material is None:
                        self.assertLess(pixel[:3].max(), 1.3 * pixel[:3].min())
                    else:
                        self.assertGreater(pixel[2], 3 * max(pixel[:2]))
                for one in (field.relievo.result, field, other):
                    bpy.data.objects.remove(one)

    def test_colours_in_the_material_render_without_the_addon(self):
        with host.folder() as folder:
            field = host.field()
            path = os.path.join(folder, "colours.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            host.draw(field, [[-0.5, 0.25, 0], [0.5, 0.25, 0]], "PAINT", radius=0.3, color=(1, 0, 0, 1))
            bpy.context.scene.relievo.image_size = 64
            self.assertEqual(bpy.ops.relievo.result_image(quantity="COLOR"), {"FINISHED"})
            field.relievo.result.hide_render = True
            bpy.ops.wm.save_mainfile()
            without = self.bare_render(path, 1)
            numpy.testing.assert_allclose(self.render(path, 1), without, atol=1e-5)
            painted = without[int(SIZE * 0.375), SIZE // 2]
            self.assertGreater(painted[0], 3 * painted[1])
            plain = without[int(SIZE * 0.85), SIZE // 2]
            self.assertLess(plain[0], 1.3 * plain[1])


if __name__ == "__main__":
    host.main()
