"""Baked frames and the files that they are in: whose they are, what undo plays, and where they are found after the file
was saved elsewhere."""

import os
import sys
import types
import unittest
from pathlib import Path

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host
from test_fluid import box


class Case(unittest.TestCase):
    def setUp(self):
        self.relievo = host.empty()
        folder = host.folder()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        bpy.context.preferences.edit.undo_steps = 32
        scene = bpy.context.scene
        scene.frame_start, scene.frame_end = 1, 3
        scene.relievo.imprint.voxels = 2**16

    def save(self, *name):
        path = os.path.join(self.folder, *name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        bpy.ops.wm.save_as_mainfile(filepath=path)

    def open(self, *name):
        bpy.ops.wm.open_mainfile(filepath=os.path.join(self.folder, *name))

    def append(self, *name):
        """Appends the objects of a file to an empty one in another folder."""
        self.relievo = host.empty()
        self.save("b", "c", "appended.blend")
        with bpy.data.libraries.load(os.path.join(self.folder, *name)) as (there, wanted):
            wanted.objects = there.objects
        for appended in wanted.objects:
            bpy.context.scene.collection.objects.link(appended)

    def files(self, ending):
        return sorted(path.name for path in Path(self.folder).rglob(f"*{ending}"))


class Imprints(Case):
    def bake(self, field, depth=0.1, **options):
        """Bakes the dent of a ball that sinks in. Returns the points of the last frame."""
        ball = bpy.data.objects.get("ball") or host.ball(0.3)
        ball.animation_data_clear()
        for frame, share in ((1, 0.0), (3, 1.0)):
            ball.location = (*field.location[:2], field.location[2] + 0.31 - share * (depth + 0.01))
            ball.keyframe_insert("location", frame=frame)
        host.select(field, ball)
        self.assertEqual(bpy.ops.relievo.imprint(cache=True, **options), {"FINISHED"})
        return self.played(field)

    def played(self, field, frame=3):
        bpy.context.scene.frame_set(frame)
        return host.evaluated(field.relievo.result)

    def test_files_of_one_folder_have_bakes_of_their_own(self):
        self.save("one.blend")
        first = self.bake(host.field(), 0.1)
        self.save("one.blend")
        self.relievo = host.empty()
        bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 3
        self.save("two.blend")
        second = self.bake(host.field(), 0.2)
        self.save("two.blend")
        self.assertEqual(len(self.files(".pc2")), 2)
        self.open("one.blend")
        numpy.testing.assert_array_equal(self.played(bpy.data.objects["field"]), first)
        self.open("two.blend")
        numpy.testing.assert_array_equal(self.played(bpy.data.objects["field"]), second)
        # So do a file and one that it was saved as.
        self.save("three.blend")
        third = self.bake(bpy.data.objects["field"], 0.25)
        self.assertFalse(numpy.array_equal(third, second))
        self.open("two.blend")
        numpy.testing.assert_array_equal(self.played(bpy.data.objects["field"]), second)

    def test_names_that_look_alike_as_files(self):
        self.save("names.blend")
        fields = [host.field(name=name) for name in ("A b", "A_b", "A/b", "\u00e4" * 31)]
        baked = []
        for number, field in enumerate(fields):
            field.location.x = 4 * number
            bpy.context.view_layer.update()
            baked.append(self.bake(field, 0.04 * (number + 1)))
        self.assertEqual(len(self.files(".pc2")), 4)
        for field, points in zip(fields, baked):
            numpy.testing.assert_array_equal(self.played(field), points)

    def test_undo_of_a_second_bake_plays_the_first(self):
        for playback in ("MODIFIER", "HANDLER"):
            self.setUp()
            self.save("undo.blend")
            field = host.field()
            field.relievo.playback = playback
            first = self.bake(field, 0.1, images=True, image_size=16)
            bpy.ops.ed.undo_push(message="first")
            images = {name: Path(self.folder, "relievo_cache", name).read_bytes() for name in self.files(".exr")}
            second = self.bake(field, 0.2, images=True, image_size=16)
            bpy.ops.ed.undo_push(message="second")
            self.assertFalse(numpy.array_equal(first, second))
            bpy.ops.ed.undo()
            numpy.testing.assert_array_equal(self.played(bpy.data.objects["field"]), first)
            for name, data in images.items():
                self.assertEqual(Path(self.folder, "relievo_cache", name).read_bytes(), data)
            bpy.ops.ed.redo()
            numpy.testing.assert_array_equal(self.played(bpy.data.objects["field"]), second)

    def test_duplicates_bake_into_files_of_their_own(self):
        self.save("copies.blend")
        field = host.field()
        first = self.bake(field, 0.1)
        host.select(field, field.relievo.result)
        bpy.ops.object.duplicate()
        copy = bpy.data.objects["field.001"]
        second = self.bake(copy, 0.2)
        self.assertNotEqual(copy.relievo.cache_id, field.relievo.cache_id)
        numpy.testing.assert_array_equal(self.played(field), first)
        self.bake(field, 0.05)
        numpy.testing.assert_array_equal(self.played(copy), second)

    def test_saving_elsewhere_brings_paths_along(self):
        for playback in ("MODIFIER", "HANDLER"):
            self.setUp()
            self.save("a", "field.blend")
            field = host.field()
            field.relievo.playback = playback
            baked = self.bake(field)
            self.save("a", "field.blend")
            self.save("b", "c", "other.blend")
            numpy.testing.assert_array_equal(self.played(field), baked)
            self.open("b", "c", "other.blend")
            field = bpy.data.objects["field"]
            self.assertTrue(self.relievo.data.playback.path_of(field).startswith("//../../a"))
            self.assertFalse(numpy.array_equal(self.played(field, 1), baked))
            numpy.testing.assert_array_equal(self.played(field), baked)
            # The add-on goes over to another way of playing it there.
            field.relievo.playback = "HANDLER" if playback == "MODIFIER" else "MODIFIER"
            self.assertFalse(numpy.array_equal(self.played(field, 1), baked))
            numpy.testing.assert_array_equal(self.played(field), baked)
            # Another bake is this file's own.
            self.bake(field, 0.2)
            self.open("a", "field.blend")
            numpy.testing.assert_array_equal(self.played(bpy.data.objects["field"]), baked)

    def test_appended_objects_play_their_bakes(self):
        for playback in ("MODIFIER", "HANDLER"):
            self.setUp()
            self.save("a", "field.blend")
            field = host.field()
            field.relievo.playback = playback
            baked = self.bake(field)
            self.save("a", "field.blend")
            self.append("a", "field.blend")
            field = bpy.data.objects["field"]
            self.assertFalse(numpy.array_equal(self.played(field, 1), baked))
            numpy.testing.assert_array_equal(self.played(field), baked)

    def test_bakes_that_nothing_plays_are_removed(self):
        self.save("clean.blend")
        field = host.field()
        self.bake(field, 0.1, images=True, image_size=16)
        self.bake(field, 0.2)
        self.save("other.blend")
        self.bake(field, 0.05)
        self.save("clean.blend")
        Path(self.folder, "relievo_cache", "clean.pc2").write_bytes(b"mine")
        self.assertEqual(len(self.files(".pc2")), 4)
        self.open("clean.blend")
        field = bpy.data.objects["field"]
        last = self.bake(field, 0.25)
        self.assertEqual(bpy.ops.relievo.cache_clean(), {"FINISHED"})
        # The bake of the other file, one that has another name, and what is played and shown are there.
        kept = [name for name in self.files(".pc2") if name.startswith("clean.field")]
        self.assertEqual(kept, [os.path.basename(field.relievo.cache)])
        self.assertEqual(len(self.files(".pc2")), 3)
        self.assertEqual(len(self.files(".exr")), 3)
        numpy.testing.assert_array_equal(self.played(field), last)
        self.relievo = host.empty()
        with self.assertRaisesRegex(RuntimeError, "Save the .blend file first"):
            bpy.ops.relievo.cache_clean()


class Fluids(Case):
    def tank(self, height=0.3):
        tank = box("tank", (0, 0, 0), (0.8, 0.4, 0.6))
        tank.relievo.fluid.role, tank.relievo.fluid.spacing = "DOMAIN", 0.1
        water = box("water", (0, 0, 0), (0.3, 0.4, height))
        water.relievo.fluid.role = "FILL"
        return tank

    def simulate(self, tank):
        host.select(tank)
        self.assertEqual(bpy.ops.relievo.fluid_simulate(), {"FINISHED"})
        return self.at(tank)

    def at(self, tank, frame=3):
        bpy.context.scene.frame_set(frame)
        return host.positions(tank.relievo.fluid.result)

    def duplicate(self, tank, *others):
        host.select(tank, *others)
        bpy.ops.object.duplicate()
        return bpy.data.objects["tank.001"]

    def test_a_duplicate_has_frames_and_a_result_of_its_own(self):
        self.save("tanks.blend")
        tank = self.tank()
        first = self.simulate(tank)
        copy = self.duplicate(tank)
        bpy.data.objects["water"].scale.z = 0.5
        second = self.simulate(copy)
        self.assertNotEqual(len(second), len(first))
        self.assertNotEqual(copy.relievo.fluid.result, tank.relievo.fluid.result)
        numpy.testing.assert_array_equal(self.at(tank), first)
        numpy.testing.assert_array_equal(self.at(copy), second)

    def test_clear_frames_leaves_those_of_others(self):
        for with_result in (False, True):
            self.setUp()
            self.save("tanks.blend")
            tank = self.tank()
            first = self.simulate(tank)
            copy = self.duplicate(tank, *([tank.relievo.fluid.result] if with_result else []))
            host.select(copy)
            self.assertEqual(bpy.ops.relievo.fluid_clear(), {"FINISHED"})
            self.assertEqual(copy.relievo.fluid.cache, "")
            self.at(tank, 1)
            numpy.testing.assert_array_equal(self.at(tank), first)
            # Nor does a file that was saved elsewhere remove those of the first.
            self.save("tanks.blend")
            self.save("others.blend")
            host.select(tank)
            self.assertEqual(bpy.ops.relievo.fluid_clear(), {"FINISHED"})
            self.assertEqual(len(self.files(".rlvfluid")), 3)
            self.open("tanks.blend")
            tank = bpy.data.objects["tank"]
            self.at(tank, 1)
            numpy.testing.assert_array_equal(self.at(tank), first)
            # The file that simulated them does, once nobody else plays them.
            host.select(tank)
            self.assertEqual(bpy.ops.relievo.fluid_clear(), {"FINISHED"})
            self.assertEqual(self.files(".rlvfluid"), [])

    def test_clear_frames_asks(self):
        from relievo.ops import fluid

        kind, asked = fluid.RELIEVO_OT_fluid_clear, []
        manager = types.SimpleNamespace(invoke_confirm=lambda *_, **shown: asked.append(shown) or {"RUNNING_MODAL"})
        question = types.SimpleNamespace(question=kind.question, bl_label=kind.bl_label)
        kind.invoke(question, types.SimpleNamespace(window_manager=manager), None)
        self.assertEqual(len(asked), 1)

    def test_undo_of_a_second_simulation_plays_the_first(self):
        self.save("undo.blend")
        tank = self.tank()
        first = self.simulate(tank)
        bpy.ops.ed.undo_push(message="first")
        bpy.data.objects["water"].scale.z = 0.5
        second = self.simulate(tank)
        bpy.ops.ed.undo_push(message="second")
        self.assertNotEqual(len(second), len(first))
        bpy.ops.ed.undo()
        self.at(bpy.data.objects["tank"], 1)
        numpy.testing.assert_array_equal(self.at(bpy.data.objects["tank"]), first)

    def test_frames_are_meshed_beside_those_that_others_play(self):
        self.save("meshed.blend")
        tank = self.tank()
        self.simulate(tank)
        host.select(tank)
        self.assertEqual(bpy.ops.relievo.fluid_mesh(), {"FINISHED"})
        first = self.at(tank)
        bpy.ops.ed.undo_push(message="first")
        tank.relievo.fluid.cell = 2.0
        self.assertEqual(bpy.ops.relievo.fluid_mesh(), {"FINISHED"})
        bpy.ops.ed.undo_push(message="second")
        self.assertNotEqual(len(self.at(tank)), len(first))
        self.assertEqual(len(self.files(".npz")), 6)
        bpy.ops.ed.undo()
        tank = bpy.data.objects["tank"]
        self.at(tank, 1)
        numpy.testing.assert_array_equal(self.at(tank), first)
        # Particles of the second are those of the first.
        self.assertEqual(len(self.files(".rlvfluid")), 6)

    def test_saving_elsewhere_brings_paths_along(self):
        self.save("a", "tank.blend")
        baked = self.simulate(self.tank())
        self.save("a", "tank.blend")
        self.save("b", "c", "tank.blend")
        tank = bpy.data.objects["tank"]
        self.assertFalse(numpy.array_equal(self.at(tank, 1), baked))
        numpy.testing.assert_array_equal(self.at(tank), baked)
        self.open("b", "c", "tank.blend")
        tank = bpy.data.objects["tank"]
        self.assertFalse(numpy.array_equal(self.at(tank, 1), baked))
        numpy.testing.assert_array_equal(self.at(tank), baked)

    def test_appended_domains_play_their_frames(self):
        self.save("a", "tank.blend")
        baked = self.simulate(self.tank())
        self.save("a", "tank.blend")
        self.append("a", "tank.blend")
        tank = bpy.data.objects["tank"]
        self.assertFalse(numpy.array_equal(self.at(tank, 1), baked))
        numpy.testing.assert_array_equal(self.at(tank), baked)
        # They are the other file's, and stay.
        host.select(tank)
        self.assertEqual(bpy.ops.relievo.fluid_clear(), {"FINISHED"})
        self.assertEqual(len(self.files(".rlvfluid")), 3)

    def test_a_failure_before_the_first_frame_leaves_nothing(self):
        self.save("failed.blend")
        tank = self.tank()
        first = self.simulate(tank)
        tank.relievo.fluid.spacing = 1e-4
        host.select(tank)
        with self.assertRaises(RuntimeError):
            bpy.ops.relievo.fluid_simulate()
        self.assertEqual(len(os.listdir(os.path.join(self.folder, "relievo_cache"))), 1)
        self.at(tank, 1)
        numpy.testing.assert_array_equal(self.at(tank), first)


if __name__ == "__main__":
    host.main()
