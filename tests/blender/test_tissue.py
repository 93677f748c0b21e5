"""Soft tissue: collections that are simulated, skins that are baked and play without the add-on, and what is refused."""

import sys
import tempfile
import unittest
from pathlib import Path

import bpy
import numpy
from mathutils import Matrix

sys.path.append(str(Path(__file__).resolve().parent))

import host
from test_fluid import box


class Tissue(unittest.TestCase):
    """A block of gel whose lower side is held by that of a large box."""

    def setUp(self):
        self.relievo = host.empty()
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.set_folder()
        scene = bpy.context.scene
        scene.frame_start, scene.frame_end = 1, 4
        self.block = self.part("VOLUME", "block", (0, 0, 0), (0.1, 0.1, 0.1))
        self.skin = self.part("SKIN", "skin", (0, 0, 0), (0.1, 0.1, 0.1))
        self.part("HOLD", "bone", (-1, -1, 0), (1, 1, 1))
        self.model = scene.collection.relievo_tissue
        self.model.voxel = 0.025

    def set_folder(self):
        bpy.context.preferences.addons["relievo"].preferences.cache_folder = self.folder.name

    def part(self, role, name, low, high, **options):
        made = box(name, low, high)
        made.relievo_tissue.role = role
        for option, value in options.items():
            setattr(made.relievo_tissue, option, value)
        return made

    def bake(self):
        host.select(self.block)
        self.assertEqual(bpy.ops.relievo.tissue_bake(), {"FINISHED"})

    def at(self, frame):
        bpy.context.scene.frame_set(frame)
        return host.evaluated(self.skin)

    def refused(self, text):
        host.select(self.block)
        with self.assertRaisesRegex(RuntimeError, text) as caught:
            bpy.ops.relievo.tissue_bake()
        self.assertNotIn("Traceback", str(caught.exception))

    def test_a_block_sags_and_plays_without_the_addon(self):
        self.skin.location.x = 1.0
        self.skin.data.transform(Matrix.Translation((-1.0, 0.0, 0.0)))
        bpy.context.view_layer.update()
        rest = numpy.array([vertex.co for vertex in self.skin.data.vertices])
        self.bake()
        numpy.testing.assert_allclose(self.at(1), rest, atol=1e-5)
        sagged = self.at(4)
        top = rest[:, 2] > 0.05
        self.assertLess((sagged[top, 2] - rest[top, 2]).max(), -1e-4)
        numpy.testing.assert_allclose(sagged[~top], rest[~top], atol=1e-5)
        # Blender's own modifier has the frames.
        bpy.ops.preferences.addon_disable(module="relievo")
        numpy.testing.assert_array_equal(self.at(4), sagged)
        host.enable()
        self.set_folder()
        host.select(self.block)
        self.assertEqual(bpy.ops.relievo.tissue_clear(), {"FINISHED"})
        self.assertEqual(list(Path(self.folder.name).iterdir()), [])
        numpy.testing.assert_allclose(self.at(4), rest, atol=1e-6)

    def test_a_muscle_contracts_by_its_keyframes(self):
        bpy.context.scene.use_gravity = False
        muscle = self.part("MUSCLE", "biceps", (0.01, 0.02, 0.04), (0.09, 0.08, 0.08), material="MUSCLE", strength=2e5)
        options = muscle.relievo_tissue
        options.keyframe_insert("activation", frame=1)
        options.activation = 0.5
        options.keyframe_insert("activation", frame=3)
        self.model.mass_scaling = 200
        self.bake()
        rest, pulled = self.at(1), self.at(4)
        top = rest[:, 2] > 0.05
        width = lambda points: numpy.ptp(points[top, 0])
        self.assertLess(width(pulled), 0.98 * width(rest))

    def test_a_body_presses(self):
        wheel = self.part("COLLIDER", "stamp", (0.02, 0.02, 0.11), (0.08, 0.08, 0.15))
        wheel.keyframe_insert("location", frame=1)
        wheel.location.z = -0.03
        wheel.keyframe_insert("location", frame=4)
        bpy.context.scene.use_gravity = False
        self.skin.data.clear_geometry()
        xs = numpy.linspace(0.0, 0.1, 5)
        points = [(x, y, 0.1) for x in xs for y in xs]
        faces = [(5 * i + j, 5 * i + j + 5, 5 * i + j + 6, 5 * i + j + 1) for i in range(4) for j in range(4)]
        self.skin.data.from_pydata(points, [], faces)
        self.bake()
        pressed = self.at(4)
        self.assertLess(pressed[12, 2], 0.0825)

    def test_the_estimate_is_near_what_it_takes(self):
        self.model.relaxes = True
        host.select(self.block)
        self.assertEqual(bpy.ops.relievo.tissue_estimate(), {"FINISHED"})
        said = self.model.estimate.split()
        self.assertEqual(said[:3], ["About", "64", "elements,"])
        self.bake()
        size = sum(path.stat().st_size for path in Path(self.folder.name).glob("*.pc2")) / 2**20
        self.assertAlmostEqual(float(said[3]) / size, 1, delta=0.1)
        # Minutes go by the last bake, and half the size of elements has eight times as many, in twice as many steps.
        self.model.relaxes, self.model.pace = False, 1e-3
        bpy.ops.relievo.tissue_estimate()
        coarse = self.model.estimate.split()
        self.model.voxel /= 2
        bpy.ops.relievo.tissue_estimate()
        fine = self.model.estimate.split()
        self.assertEqual(fine[1], "512")
        self.assertAlmostEqual(float(fine[5]) / float(coarse[5]), 16, delta=0.5)

    def test_what_cannot_be_simulated_is_refused(self):
        self.model.voxel = 1.0
        self.refused("Element size: no element has enough of a volume inside; make it smaller")
        self.model.voxel = 0.025
        self.skin.modifiers.new("finer", "SUBSURF")
        self.refused("finer")
        self.skin.modifiers.clear()
        self.skin.relievo_tissue.role = "NONE"
        self.refused("is a skin")
        self.assertEqual(list(Path(self.folder.name).iterdir()), [])


if __name__ == "__main__":
    host.main()
