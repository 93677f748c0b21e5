"""Foam of fluids: baked from cached frames, shown by kinds, rendered as points, composited over Cycles' picture, and what is
refused."""

import os
import sys
import unittest
from pathlib import Path

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host
from test_fluid import Case

SIZE = (64, 48)


class Foaming(Case):
    def setUp(self):
        super().setUp()
        self.part("FILL", "water", (0, 0, 0), (0.3, 0.4, 0.4), velocity=(2, 0, 0))
        settings = self.domain.relievo_foam.settings
        settings.energy_min, settings.energy_max, settings.air_min, settings.air_max = 0.5, 5, 0.5, 5
        settings.air_rate = settings.crest_rate = 300

    def bake(self):
        host.select(self.domain)
        self.assertEqual(bpy.ops.relievo.foam_bake(), {"FINISHED"})
        return self.domain.relievo_foam.result

    def column(self, result, name, field="value", width=1, kind=numpy.float32):
        values = numpy.empty(len(result.data.vertices) * width, kind)
        result.data.attributes[name].data.foreach_get(field, values)
        return values.reshape(-1, width) if width > 1 else values

    def test_foam_is_baked_from_the_cache_and_shown_by_kinds(self):
        self.refused(bpy.ops.relievo.foam_bake, "simulate it first")
        self.simulate()
        result = self.bake()
        scene, options = bpy.context.scene, self.domain.relievo_foam
        counts = []
        for frame in range(1, 7):
            scene.frame_set(frame)
            counts.append(len(result.data.vertices))
        self.assertEqual(counts[0], 0)
        self.assertGreater(counts[-1], 200)
        kinds, radii = self.column(result, "kind", kind=numpy.int32), self.column(result, "radius")
        self.assertTrue(((kinds >= 0) & (kinds <= 2)).all())
        self.assertTrue((radii <= 0.025 + 1e-6).all() and radii.max() > 0.02)
        self.assertEqual(self.column(result, "velocity", "vector", 3).shape, (counts[-1], 3))
        shown = 0
        for kind in ("SPRAY", "FOAM", "BUBBLE"):
            options.show = {kind}
            shown += len(result.data.vertices)
        self.assertEqual(shown, counts[-1])
        options.show = {"SPRAY", "FOAM", "BUBBLE"}
        # The same again is the same; another seed is not, and no frame of the fluid was made again.
        first = host.positions(result)
        fluid = {path: path.stat().st_mtime_ns for path in Path(self.folder.name).rglob("particles_*")}
        self.bake()
        numpy.testing.assert_array_equal(host.positions(result), first)
        options.settings.seed = 2
        self.assertEqual(self.bake(), result)
        self.assertFalse(numpy.array_equal(host.positions(result), first))
        self.assertEqual(fluid, {path: path.stat().st_mtime_ns for path in Path(self.folder.name).rglob("particles_*")})
        # A new simulation has no foam yet, and frames are cleared with theirs.
        self.simulate()
        scene.frame_set(6)
        self.assertEqual(len(result.data.vertices), 0)
        bpy.ops.relievo.fluid_clear()
        options.settings.air_max = 0.1
        self.refused(bpy.ops.relievo.foam_bake, "simulate it first")

    def test_the_estimate_is_near_what_it_takes(self):
        self.refused(bpy.ops.relievo.foam_estimate, "simulate it first")
        bpy.context.scene.frame_end = 16
        self.simulate()
        host.select(self.domain)
        files = set(Path(self.folder.name).rglob("*"))
        self.assertEqual(bpy.ops.relievo.foam_estimate(), {"FINISHED"})
        self.assertEqual(set(Path(self.folder.name).rglob("*")), files)
        said = self.domain.relievo_foam.estimate
        self.assertRegex(said, r"^About [\d,]+ particles, [\d.]+ MiB, [\d.e-]+ min$")
        words = said.split()
        result = self.bake()
        bpy.context.scene.frame_set(16)
        self.assertAlmostEqual(int(words[1].replace(",", "")) / len(result.data.vertices), 1, delta=0.5)
        size = sum(path.stat().st_size for path in Path(self.folder.name).rglob("foam_*")) / 2**20
        self.assertAlmostEqual(float(words[3]) / size, 1, delta=0.5)
        # More is born at a higher rate, and no more is kept than the settings allow.
        self.domain.relievo_foam.settings.most = 100
        bpy.ops.relievo.foam_estimate()
        self.assertIn("About 100 particles", self.domain.relievo_foam.estimate)

    def test_a_damaged_frame_and_limits_that_contradict_are_told(self):
        self.simulate()
        self.bake()
        from relievo.ops import foam

        path = Path(foam.path_at(self.domain, 6))
        path.write_bytes(path.read_bytes()[:-1])
        self.assertRegex(foam.show(self.domain, 6), "damaged")
        self.domain.relievo_foam.settings.air_max = 0.1
        self.refused(bpy.ops.relievo.foam_bake, "Trapped air to: ")

    def camera(self, kind):
        scene, camera = bpy.context.scene, bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.collection.objects.link(camera)
        camera.data.type, camera.data.ortho_scale = kind, 1.6
        camera.location, camera.rotation_euler = (0.6, -1.6, 1.2), (1.0, 0, 0)
        scene.camera = camera
        scene.render.resolution_x, scene.render.resolution_y = SIZE
        scene.render.resolution_percentage = 100
        sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
        sun.rotation_euler = (0.5, 0, 0.4)
        scene.collection.objects.link(sun)

    def left(self):
        """What renders might leave behind."""
        images = [image for image in bpy.data.images if image.type != "RENDER_RESULT"]
        return [len(kind) for kind in (bpy.data.scenes, images)]

    def composited(self, name):
        path = os.path.join(self.folder.name, name)
        host.select(self.domain)
        self.assertEqual(bpy.ops.relievo.foam_composite(filepath=path), {"FINISHED"})
        image = bpy.data.images.load(path)
        pixels = numpy.empty(SIZE[0] * SIZE[1] * image.channels, numpy.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
        return pixels.reshape(SIZE[1], SIZE[0], -1)[::-1]

    @unittest.skipUnless(hasattr(bpy.types.Scene, "cycles") or "cycles" in bpy.context.preferences.addons, "skipped: no Cycles")
    def test_foam_is_composited_over_pictures_of_cycles(self):
        self.simulate()
        self.domain.relievo.fluid.show = "SURFACE"
        scene, options = bpy.context.scene, self.domain.relievo_foam
        scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 2, False
        scene.frame_set(6)
        self.refused(lambda: bpy.ops.relievo.foam_composite(filepath="a.exr"), "camera|no foam")
        result = self.bake()
        self.refused(lambda: bpy.ops.relievo.foam_composite(filepath="a.exr"), "camera")
        before = self.left()
        for kind in ("PERSP", "ORTHO"):
            self.camera(kind)
            options.radius = 1.0
            foamy = self.composited(f"{kind}.exr")
            options.radius = 0.001
            bare = self.composited("bare.exr")
            changed = (numpy.abs(foamy - bare)[..., :3] > 1e-3).any(-1)
            self.assertTrue(numpy.isfinite(foamy).all())
            self.assertGreater(changed.mean(), 0.01)
            self.assertLess(changed.mean(), 0.9)
            # A wall before everything hides all foam.
            wall = host.add("wall", numpy.array([(-9, -1, -9), (9, -1, -9), (9, -1, 9), (-9, -1, 9.0)]), [[0, 1, 2, 3]], 4)
            options.radius = 1.0
            hidden = self.composited("hidden.exr")
            options.radius = 0.001
            numpy.testing.assert_allclose(hidden, self.composited("bare.exr"), atol=1e-4)
            bpy.data.objects.remove(wall)
        self.assertEqual(before, self.left())
        self.assertFalse(result.hide_render)
        options.radius = 1.0
        self.composited("picture.png")
        self.refused(lambda: bpy.ops.relievo.foam_composite(filepath="a.bmp"), "ending")
        self.refused(lambda: bpy.ops.relievo.foam_composite(filepath="a.exr", use_animation=True), "####")
        scene.camera.data.shift_x = 0.2
        self.refused(lambda: bpy.ops.relievo.foam_composite(filepath="a.exr"), "shift")

    @unittest.skipUnless(hasattr(bpy.types.Scene, "cycles") or "cycles" in bpy.context.preferences.addons, "skipped: no Cycles")
    def test_particles_are_rendered_as_points(self):
        self.simulate()
        result = self.bake()
        bpy.context.scene.frame_set(6)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        points = [one.object.data for one in depsgraph.object_instances if isinstance(one.object.data, bpy.types.PointCloud)]
        self.assertEqual(sum(len(cloud.points) for cloud in points), len(result.data.vertices))
        self.assertAlmostEqual(points[0].points[0].radius, self.column(result, "radius")[0], places=5)


if __name__ == "__main__":
    host.main()
