"""Levels of progressive meshes: what is built and shown, what undo brings back, what files keep, and what is refused."""

import os
import shutil
import sys
import unittest
from pathlib import Path

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host


def triangles(target):
    return len(target.data.polygons)


def shape(target):
    """The triangles of an object by their corners' places, in an order of their own."""
    corners = numpy.empty(len(target.data.loops), numpy.int32)
    target.data.loops.foreach_get("vertex_index", corners)
    found = host.positions(target)[corners].reshape(-1, 9)
    return found[numpy.lexsort(found.T)]


class Case(unittest.TestCase):
    def setUp(self):
        self.relievo = host.empty()

    def built(self, target=None, **options):
        target = target or host.ball(1.0, rings=24)
        host.select(target)
        self.assertEqual(bpy.ops.relievo.levels_build(**options), {"FINISHED"})
        return target

    def refused(self, operator, text, **options):
        with self.assertRaisesRegex(RuntimeError, text) as caught:
            operator(**options)
        self.assertNotIn("Traceback", str(caught.exception))

    def settle(self, text):
        """A step of Blender's undo; returns the object, of which undo makes another."""
        bpy.ops.ed.undo_push(message=text)


class Building(Case):
    def test_the_finest_level_is_the_mesh_and_coarser_ones_are_near_it(self):
        ball = host.ball(1.0, rings=24)
        before, original = shape(ball), ball.data
        self.built(ball)
        numpy.testing.assert_array_equal(shape(ball), before)
        self.assertEqual(ball.relievo.progressive.original, original)
        options, finest = ball.relievo.progressive, triangles(ball)
        self.assertEqual(options.finest, finest)
        for ratio in (0.5, 0.1):
            options.ratio = ratio
            self.assertLessEqual(triangles(ball), ratio * finest)
            self.assertGreater(triangles(ball), ratio * finest - 3)
            numpy.testing.assert_allclose(numpy.linalg.norm(host.positions(ball), axis=1), 1, atol=0.1)
        options.measure, options.triangles = "TRIANGLES", 300
        self.assertIn(triangles(ball), (298, 299, 300))
        options.measure, options.error = "ERROR", 0.0
        numpy.testing.assert_array_equal(shape(ball), before)
        counts = []
        for error in (0.001, 0.01, 0.1):
            options.error = error
            counts.append(triangles(ball))
        self.assertEqual(counts, sorted(counts, reverse=True))
        self.assertLess(counts[-1], 0.1 * finest)
        self.assertFalse(ball.data.validate())

    def test_materials_and_shading_stay(self):
        for is_smooth in (True, False):
            self.setUp()
            ball = host.ball(1.0)
            for name in ("red", "green"):
                ball.data.materials.append(bpy.data.materials.new(name))
            ball.data.polygons.foreach_set("material_index", numpy.ones(triangles(ball), numpy.int32))
            ball.data.polygons.foreach_set("use_smooth", numpy.full(triangles(ball), is_smooth))
            self.built(ball)
            ball.relievo.progressive.ratio = 0.2
            self.assertEqual([material.name for material in ball.data.materials], ["red", "green"])
            self.assertEqual({face.material_index for face in ball.data.polygons}, {1})
            self.assertEqual({face.use_smooth for face in ball.data.polygons}, {is_smooth})

    def test_polygons_are_cut_as_blender_cuts_them(self):
        """A face that is not convex keeps its outline."""
        points = numpy.array([(0, 0, 0), (2, 0, 0), (2, 2, 0), (1, 0.5, 0), (0, 2, 0)], numpy.float32)
        arrow = self.built(host.add("arrow", points, range(5), 5))
        self.assertAlmostEqual(sum(face.area for face in arrow.data.polygons), 2.5, places=5)
        self.assertEqual({round(face.normal.z) for face in arrow.data.polygons}, {1})

    def test_linked_duplicates_have_levels_of_their_own(self):
        ball = self.built()
        bpy.ops.object.duplicate(linked=True)
        copy = bpy.data.objects["ball.001"]
        self.assertEqual(copy.data, ball.data)
        finest = triangles(ball)
        copy.relievo.progressive.ratio = 0.1
        self.assertEqual(triangles(ball), finest)
        self.assertLess(triangles(copy), finest)

    def test_what_cannot_have_levels_is_said(self):
        build = bpy.ops.relievo.levels_build
        host.select(host.add("points", numpy.zeros((3, 3), numpy.float32), [], 3))
        self.refused(build, "no faces")
        broken = host.ball(1.0, "broken")
        broken.data.vertices[3].co.x = float("nan")
        host.select(broken)
        self.refused(build, "not finite|NaN|finite")
        self.assertEqual(broken.relievo.progressive.uid, "")
        keyed = host.ball(1.0, "keyed")
        host.select(keyed)
        keyed.shape_key_add(name="Basis")
        self.refused(build, "shape keys")
        field = host.field()
        host.draw(field, [[0, 0, 0], [0.2, 0, 0]])
        self.refused(build, "has detail")
        host.select(field.relievo.result)
        self.refused(build, "is the result of")
        textured = host.field(name="textured")
        self.built(textured)
        self.assertEqual(self.relievo.progressive.left_out(textured.relievo.progressive.original), ["texture coordinates"])
        # Its levels are written no more once there is detail.
        host.draw(textured, [[0, 0, 0], [0.2, 0, 0]])
        count = triangles(textured)
        textured.relievo.progressive.ratio = 0.2
        self.assertEqual(triangles(textured), count)
        self.assertIn("detail", self.relievo.progressive.trouble(textured))

    def test_a_cancelled_build_leaves_nothing(self):
        ball = host.ball(1.0, rings=64)
        host.select(ball)
        before, count = shape(ball), len(bpy.data.meshes)
        kind = self.relievo.levels.RELIEVO_OT_levels_build
        work = self.relievo.job.Worker(host.operator(kind, base_triangles=100))
        self.assertFalse(work.advance())
        work.stop()
        self.assertTrue(work.is_done)
        numpy.testing.assert_array_equal(shape(ball), before)
        self.assertEqual((ball.relievo.progressive.uid, len(bpy.data.meshes)), ("", count))
        self.built(ball)

    def test_clearing_keeps_the_level_or_brings_the_original_back(self):
        ball = self.built()
        before = shape(ball)
        ball.relievo.progressive.ratio = 0.1
        count = triangles(ball)
        self.settle("coarse")
        self.assertEqual(bpy.ops.relievo.levels_clear(keep="LEVEL"), {"FINISHED"})
        self.assertEqual((triangles(ball), self.relievo.progressive.is_there(ball)), (count, False))
        self.settle("clear")
        bpy.ops.ed.undo()
        ball = bpy.data.objects["ball"]
        self.assertEqual(bpy.ops.relievo.levels_clear(keep="ORIGINAL"), {"FINISHED"})
        numpy.testing.assert_array_equal(shape(ball), before)
        self.assertNotIn(self.relievo.progressive.PACKED, ball)


class Files(Case):
    def test_blend_files_keep_levels(self):
        with host.folder() as folder:
            path = os.path.join(folder, "levels.blend")
            ball = self.built()
            before = shape(ball)
            ball.relievo.progressive.ratio = 0.2
            coarse = shape(ball)
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
            ball = bpy.data.objects["ball"]
            numpy.testing.assert_array_equal(shape(ball), coarse)
            ball.relievo.progressive.ratio = 1.0
            numpy.testing.assert_array_equal(shape(ball), before)
            # Objects of files that are appended bring theirs.
            with bpy.data.libraries.load(shutil.copy(path, os.path.join(folder, "other.blend"))) as (_there, wanted):
                wanted.objects = ["ball"]
            bpy.context.scene.collection.objects.link(wanted.objects[0])
            wanted.objects[0].relievo.progressive.ratio = 1.0
            numpy.testing.assert_array_equal(shape(wanted.objects[0]), before)

    def test_levels_are_written_and_read(self):
        with host.folder() as folder:
            path = os.path.join(folder, "ball.rlvpm")
            ball = self.built()
            before = shape(ball)
            self.assertEqual(bpy.ops.relievo.levels_write(filepath=path), {"FINISHED"})
            self.assertEqual(bpy.ops.relievo.levels_read(filepath=path), {"FINISHED"})
            read = bpy.context.active_object
            self.assertNotEqual(read, ball)
            numpy.testing.assert_array_equal(shape(read), before)
            read.relievo.progressive.ratio = 0.1
            self.assertLess(triangles(read), 0.1 * triangles(ball) + 1)
            self.refused(bpy.ops.relievo.levels_clear, "no original", keep="ORIGINAL")

    def test_files_that_cannot_be_read_are_told_and_leave_nothing(self):
        with host.folder() as folder:
            path, count = os.path.join(folder, "ball.rlvpm"), len(bpy.data.objects)
            self.refused(bpy.ops.relievo.levels_read, "ball.rlvpm", filepath=path)
            self.refused(bpy.ops.relievo.levels_read, "", filepath=folder)
            for text in (b"", b"no progressive mesh", bytes(4096)):
                Path(path).write_bytes(text)
                self.refused(bpy.ops.relievo.levels_read, "ball.rlvpm", filepath=path)
            self.built()
            self.refused(bpy.ops.relievo.levels_write, "nowhere", filepath=os.path.join(folder, "nowhere", "ball.rlvpm"))
            bpy.ops.relievo.levels_write(filepath=path)
            whole = Path(path).read_bytes()
            for length in (30, len(whole) // 2, len(whole) - 1):
                Path(path).write_bytes(whole[:length])
                self.refused(bpy.ops.relievo.levels_read, "ball.rlvpm", filepath=path)
            self.assertEqual(len(bpy.data.objects), count + 1)

    def test_what_the_file_keeps_may_be_damaged_or_newer(self):
        with host.folder() as folder:
            path = os.path.join(folder, "levels.blend")
            ball = self.built()
            bpy.ops.wm.save_as_mainfile(filepath=path)
            name = self.relievo.progressive.PACKED
            whole = bytes(ball[name])
            for packed in (None, 7, whole[:100], whole[:-1]):
                bpy.ops.wm.open_mainfile(filepath=path)
                ball = bpy.data.objects["ball"]
                del ball[name]
                if packed is not None:
                    ball[name] = packed
                count = triangles(ball)
                ball.relievo.progressive.ratio = 0.1
                self.assertEqual(triangles(ball), count)
                self.assertTrue(self.relievo.progressive.trouble(ball))
                host.select(ball)
                self.refused(bpy.ops.relievo.levels_write, "the file keeps|The file keeps", filepath=os.path.join(folder, "ball.rlvpm"))
            ball.relievo.progressive.format += 1
            self.refused(bpy.ops.relievo.levels_write, "newer", filepath=os.path.join(folder, "ball.rlvpm"))


class Undo(Case):
    def test_undo_brings_levels_back(self):
        ball = host.ball(1.0, rings=24)
        original = shape(ball)
        self.settle("ball")
        self.built(ball)
        self.settle("levels")
        seen = [original, shape(ball)]
        for ratio in (0.3, 0.1):
            ball.relievo.progressive.ratio = ratio
            seen.append(shape(ball))
            self.settle("ratio")
        for wanted in reversed(seen[:-1]):
            bpy.ops.ed.undo()
            numpy.testing.assert_array_equal(shape(bpy.data.objects["ball"]), wanted)
        self.assertFalse(self.relievo.progressive.is_there(bpy.data.objects["ball"]))
        for wanted in seen[1:]:
            bpy.ops.ed.redo()
            numpy.testing.assert_array_equal(shape(bpy.data.objects["ball"]), wanted)
        bpy.ops.ed.undo()
        ball = bpy.data.objects["ball"]
        ball.relievo.progressive.ratio = 1.0
        numpy.testing.assert_array_equal(shape(ball), original)


if __name__ == "__main__":
    host.main()
