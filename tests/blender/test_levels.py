"""Levels of progressive meshes: what is built and shown, what undo brings back, what files keep, and what is refused."""

import json
import os
import random
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


def places(target):
    """The points of an object in an order of their own, for comparison where the last bit depends on the way: what is
    summed over neighbours has their order."""
    return numpy.sort(host.positions(target), 0)


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

    def test_levels_have_texture_coordinates_colors_and_materials(self):
        field = host.field(32, "field")
        data = field.data
        for name in ("red", "green"):
            data.materials.append(bpy.data.materials.new(name))
        data.polygons.foreach_set("material_index", [int(face.center.x > 0) for face in data.polygons])
        colors = numpy.ones((len(data.vertices), 4), numpy.float32)
        colors[:, :2] = host.positions(field)[:, :2]
        data.color_attributes.new("paint", "FLOAT_COLOR", "POINT").data.foreach_set("color", colors.reshape(-1))
        data.uv_layers.new(name="second")
        data.uv_layers.active_index = 0
        active, counts = data.uv_layers.active.name, {}

        def uv_of(mesh):
            return {
                (tuple(round(x, 4) for x in mesh.vertices[loop.vertex_index].co), tuple(round(x, 4) for x in uv.uv))
                for loop, uv in zip(mesh.loops, mesh.uv_layers[active].data)
            }

        before, low = uv_of(data), host.positions(field)[:, :2].min(0)
        extent = host.positions(field)[:, :2].max(0) - low
        self.built(field)
        for ratio in (1.0, 0.2, 1.0):
            field.relievo.progressive.ratio = ratio
            data = field.data
            counts[ratio] = triangles(field)
            self.assertEqual({layer.name for layer in data.uv_layers}, {active, "second"})
            for face in data.polygons:
                if abs(face.center.x) > 0.1:
                    self.assertEqual(face.material_index, int(face.center.x > 0))
            places = host.positions(field)
            found = numpy.empty(4 * len(data.vertices), numpy.float32)
            data.color_attributes["paint"].data.foreach_get("color", found)
            numpy.testing.assert_allclose(found.reshape(-1, 4)[:, :2], places[:, :2], atol=0.05 * extent.max())
        self.assertLess(counts[0.2], 0.3 * counts[1.0])
        self.assertEqual(uv_of(field.data), before)
        self.assertFalse(field.data.validate())

    def test_custom_normals_stay_and_turn_with_edits(self):
        ball, mesh = host.ball(1.0, rings=24), self.relievo.data.mesh

        def tilted(points):
            found = points + numpy.float32((0.0, 0.0, 0.5))
            return found / numpy.linalg.norm(found, axis=1, keepdims=True)

        def at_corners():
            corners = numpy.empty(len(ball.data.loops), numpy.int32)
            ball.data.loops.foreach_get("vertex_index", corners)
            return host.positions(ball)[corners]

        ball.data.polygons.foreach_set("use_smooth", numpy.ones(triangles(ball), bool))
        mesh.set_normals(ball.data, tilted(at_corners()))
        self.built(ball)
        for ratio in (0.3, 1.0):
            ball.relievo.progressive.ratio = ratio
            self.assertTrue(ball.data.has_custom_normals)
            numpy.testing.assert_allclose(mesh.get_normals(ball.data), tilted(at_corners()), atol=0.05)
        # A quarter turn of everything: x goes to z, and z to -x.
        turn = {"move": (0, 0, 0), "axis": (0, -1, 0), "angle": numpy.pi / 2, "falloff": "CONSTANT"}
        self.assertEqual(bpy.ops.relievo.levels_edit(point=(0, 0, 0), radius=9.0, **turn), {"FINISHED"})
        x, y, z = at_corners().T
        expected = tilted(numpy.stack((z, y, -x), 1))
        numpy.testing.assert_allclose(mesh.get_normals(ball.data).T, (-expected[:, 2], expected[:, 1], expected[:, 0]), atol=0.05)

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
        textured.vertex_groups.new(name="group")
        self.assertEqual(self.relievo.data.progressive.left_out(textured), ["vertex groups"])
        self.built(textured)
        # Its levels are written no more once there is detail.
        host.draw(textured, [[0, 0, 0], [0.2, 0, 0]])
        count = triangles(textured)
        textured.relievo.progressive.ratio = 0.2
        self.assertEqual(triangles(textured), count)
        self.assertIn("detail", self.relievo.data.progressive.trouble(textured))
        host.select(textured)
        self.refused(bpy.ops.relievo.levels_clear, "has detail", keep="ORIGINAL")
        self.assertEqual(bpy.ops.relievo.levels_clear(keep="LEVEL"), {"FINISHED"})

    def test_a_cancelled_build_leaves_nothing(self):
        import librelievo as rl

        ball = host.ball(1.0, rings=64)
        host.select(ball)
        before, count = shape(ball), len(bpy.data.meshes)
        kind, fractions = self.relievo.ops.levels.RELIEVO_OT_levels_build, []

        def progress(fraction, _stage):
            fractions.append(fraction)
            return fraction < 0.3

        steps = host.operator(kind, base_triangles=100)
        _first, _last, work = next(steps)
        with self.assertRaises(rl.Cancelled):
            work(progress)
        steps.close()
        self.assertEqual(fractions, sorted(fractions))
        self.assertGreater(len(fractions), 1)
        numpy.testing.assert_array_equal(shape(ball), before)
        self.assertEqual((ball.relievo.progressive.uid, len(bpy.data.meshes)), ("", count))
        self.built(ball)

    def test_what_no_object_has_is_released(self):
        ball = self.built()
        first = ball.relievo.progressive.uid
        bpy.ops.relievo.levels_clear(keep="ORIGINAL")
        self.built(ball)
        other = self.built(host.ball(1.0, "other"))
        ball.name = "renamed"
        ball.relievo.progressive.ratio = 0.5
        progressive = self.relievo.data.progressive
        uids = [target.relievo.progressive.uid for target in (ball, other)]
        self.assertNotIn(first, uids)
        self.assertEqual(set(progressive._wholes), set(uids))
        self.assertEqual(set(progressive._shown), {(uids[0], "renamed"), (uids[1], "other")})

    def test_clearing_keeps_the_level_or_brings_the_original_back(self):
        ball = self.built()
        before = shape(ball)
        ball.relievo.progressive.ratio = 0.1
        count = triangles(ball)
        self.settle("coarse")
        self.assertEqual(bpy.ops.relievo.levels_clear(keep="LEVEL"), {"FINISHED"})
        self.assertEqual((triangles(ball), self.relievo.data.progressive.is_there(ball)), (count, False))
        self.settle("clear")
        bpy.ops.ed.undo()
        ball = bpy.data.objects["ball"]
        self.assertEqual(bpy.ops.relievo.levels_clear(keep="ORIGINAL"), {"FINISHED"})
        numpy.testing.assert_array_equal(shape(ball), before)
        self.assertNotIn(self.relievo.data.progressive.PACKED, ball)


class Edits(Case):
    def pull(self, target, **options):
        host.select(target)
        options = {"point": (0, 0, 1), "radius": 0.8, "move": (0, 0, 0.5), **options}
        return bpy.ops.relievo.levels_edit(**options)

    def test_edits_at_a_coarse_level_are_seen_at_all(self):
        import librelievo as rl

        ball = self.built()
        options = ball.relievo.progressive
        options.ratio = 0.1
        anchors = [[1.0, 0.0, 0.0, 0.5]]
        turn = {"axis": (0, 2, 0), "angle": 0.6, "falloff": "LINEAR", "anchors": json.dumps(anchors)}
        self.assertEqual(self.pull(ball, **turn), {"FINISHED"})
        # The library itself, edited at the same level.
        level = rl.Level(rl.Progressive(self.relievo.data.mesh.Triangles(options.original).build()))
        level.set_triangles(round(0.1 * options.finest))
        made = rl.Grip(rl.Region((0, 0, 1), numpy.float32(0.8), "linear"), (0, 0, 0.5), (0, 1, 0), numpy.float32(0.6))
        level.edit([made], [rl.Region((1, 0, 0), 0.5)])
        for ratio in (0.1, 1.0, 0.3, 0.05):
            options.ratio = ratio
            level.set_triangles(round(ratio * options.finest))
            level.update()
            numpy.testing.assert_allclose(places(ball), numpy.sort(level.points, 0), atol=1e-5)
            self.assertGreater(host.positions(ball)[:, 2].max(), 1.3)
        # What is outside the region has not moved, and nothing is torn.
        options.ratio = 1.0
        low = host.positions(ball)[host.positions(ball)[:, 2] < -0.2]
        numpy.testing.assert_allclose(numpy.linalg.norm(low, axis=1), 1, atol=1e-3)

    def test_edits_follow_undo_and_redo_at_random(self):
        """The level, its edits and its mesh are always those of that step, and so is every other level."""
        ball = self.built(host.ball(1.0, rings=12))
        chance = random.Random(3)
        self.settle("levels")

        def states():
            target = bpy.data.objects["ball"]
            options = target.relievo.progressive
            # Another level shows that the native edits are those of the list.
            edits, seen, ratio = [entry.text for entry in options.edits], places(target), options.ratio
            options.ratio = 0.7
            other = places(target)
            options.ratio = ratio
            numpy.testing.assert_allclose(places(target), seen, atol=1e-5)
            return edits, ratio, seen, other

        def compare(found, wanted):
            self.assertEqual(found[:2], wanted[:2])
            for one, other in zip(found[2:], wanted[2:]):
                numpy.testing.assert_allclose(one, other, atol=1e-5)

        steps, place, done = [states()], 0, {"edit": 0, "undo": 0, "redo": 0}
        while sum(done.values()) < 60:
            choice = chance.random()
            if choice < 0.4 and place > 0:
                bpy.ops.ed.undo()
                place, what = place - 1, "undo"
            elif choice < 0.7 and place + 1 < len(steps):
                bpy.ops.ed.redo()
                place, what = place + 1, "redo"
            else:
                target, what = bpy.data.objects["ball"], "edit"
                target.relievo.progressive.ratio = chance.uniform(0.1, 1.0)
                point = numpy.array([chance.gauss(0, 1) for _ in range(3)])
                move = [chance.uniform(-0.2, 0.2) for _ in range(3)]
                self.pull(target, point=point / numpy.linalg.norm(point), move=move, angle=chance.uniform(-0.5, 0.5))
                self.settle("edit")
                place += 1
                steps[place:] = [states()]
            done[what] += 1
            compare(states(), steps[place])
        self.assertGreater(min(done.values()), 8)

    def test_files_keep_edits_and_written_levels_have_them(self):
        with host.folder() as folder:
            path, written = os.path.join(folder, "edited.blend"), os.path.join(folder, "edited.rlvpm")
            ball = self.built()
            for ratio, point in ((0.1, (0, 0, 1)), (0.5, (1, 0, 0))):
                ball.relievo.progressive.ratio = ratio
                self.pull(ball, point=point, angle=0.3)
            ball.relievo.progressive.ratio = 1.0
            finest = places(ball)
            ball.relievo.progressive.ratio = 0.2
            coarse = shape(ball)
            self.assertEqual(bpy.ops.relievo.levels_write(filepath=written), {"FINISHED"})
            numpy.testing.assert_array_equal(shape(ball), coarse)
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
            ball = bpy.data.objects["ball"]
            numpy.testing.assert_array_equal(shape(ball), coarse)
            self.assertEqual(len(ball.relievo.progressive.edits), 2)
            ball.relievo.progressive.ratio = 1.0
            numpy.testing.assert_allclose(places(ball), finest, atol=1e-5)
            bpy.ops.relievo.levels_read(filepath=written)
            read = bpy.context.active_object
            self.assertEqual(len(read.relievo.progressive.edits), 0)
            # Files have places on a lattice.
            numpy.testing.assert_allclose(places(read), finest, atol=1e-5)
            # Duplicates go on apart.
            copy = ball.copy()
            copy.data = ball.data.copy()
            bpy.context.scene.collection.objects.link(copy)
            self.pull(copy, point=(-1, 0, 0))
            self.assertEqual(len(ball.relievo.progressive.edits), 2)
            ball.relievo.progressive.ratio = 0.99
            ball.relievo.progressive.ratio = 1.0
            numpy.testing.assert_allclose(places(ball), finest, atol=1e-5)

    def test_edits_that_cannot_be_made_are_told_and_change_nothing(self):
        ball = self.built()
        ball.relievo.progressive.ratio = 0.3
        before = shape(ball)
        for options, text in (
            ({"point": (9, 9, 9)}, "region"),
            ({"radius": float("nan")}, "radius|finite"),
            ({"axis": (0, 0, 0), "angle": 1.0}, "axis"),
            ({"anchors": "nonsense"}, "anchors"),
            ({"anchors": "[[1, 2, 3]]"}, "anchors"),
            ({"anchors": "[" * 100000}, "anchors"),
            ({"anchors": "[[0, 0, 0, -1]]"}, "radius"),
        ):
            self.refused(lambda **more: self.pull(ball, **more), text, **options)
            self.assertEqual(len(ball.relievo.progressive.edits), 0)
            numpy.testing.assert_array_equal(shape(ball), before)
        self.pull(ball)
        kept = ball.relievo.progressive.edits[0].text
        far = json.dumps({**json.loads(kept), "level": {"triangles": 0.5}})
        deep, large = "[" * 100000, kept.replace("0.5", "1" + "0" * 400)
        for text in ("nonsense", "[]", "{}", far, deep, large, kept.replace("smooth", "steep"), kept.replace("center", "middle")):
            ball.relievo.progressive.edits[0].text = text
            self.refused(lambda: self.pull(ball), "Edit 1 cannot be made again")
        ball.relievo.progressive.edits[0].text = kept
        ball.relievo.progressive.ratio = 0.31
        ball.relievo.progressive.ratio = 0.3
        self.assertGreater(host.positions(ball)[:, 2].max(), 1.3)

    def test_a_cancelled_edit_leaves_nothing(self):
        ball = self.built(host.ball(1.0, rings=64))
        before = shape(ball)
        kind = self.relievo.tools.grip.RELIEVO_OT_levels_edit
        named = {"point": (0, 0, 1), "radius": 0.8, "falloff": "SMOOTH", "move": (0, 0, 1), "axis": (0, 0, 1)}
        steps = host.operator(kind, angle=0.0, anchors="", **named)
        next(steps)[2](None)
        next(steps)[2](None)
        steps.close()
        numpy.testing.assert_array_equal(shape(ball), before)
        ball.relievo.progressive.ratio = 0.5
        ball.relievo.progressive.ratio = 1.0
        numpy.testing.assert_array_equal(shape(ball), before)


class Strokes(Case):
    def draw(self, target, points, **settings):
        host.select(target)
        group = bpy.context.scene.relievo.brush
        for name, value in settings.items():
            setattr(group if hasattr(group, name) else group.settings, name, value)
        return bpy.ops.relievo.levels_sculpt(points=json.dumps(points))

    def test_strokes_at_a_coarse_level_are_seen_at_all(self):
        """They are those of the library, in the space of the object."""
        import librelievo as rl

        ball = self.built()
        ball.location, ball.scale = (1, 2, 3), (2, 2, 2)
        bpy.context.view_layer.update()
        options = ball.relievo.progressive
        options.ratio = 0.1
        world = [[1, 2, 5, 1.0, 0.0], [1.5, 2, 4.9, 0.5, 0.1]]
        settings = {"sculpt_mode": "DRAW", "height": 0.3, "radius": 1.2, "size_pressure": 1.0, "spacing": 0.5}
        self.assertEqual(self.draw(ball, world, **settings), {"FINISHED"})
        kept = self.relievo.core.settings.values(bpy.context.scene.relievo.brush.settings)
        level = rl.Level(rl.Progressive(self.relievo.data.mesh.Triangles(options.original).build()))
        level.set_triangles(round(0.1 * options.finest))
        made = rl.Brush(self.relievo.core.native.context(), {**kept, "radius": kept["radius"] / 2}, action="sculpt", height=numpy.float32(0.3))
        level.sculpt(made, [[0, 0, 1, 1.0, 0.0], [0.25, 0, 0.95, 0.5, 0.1]])
        for ratio in (0.1, 1.0, 0.3):
            options.ratio = ratio
            level.set_triangles(round(ratio * options.finest))
            level.update()
            numpy.testing.assert_allclose(places(ball), numpy.sort(level.points, 0), atol=1e-5)
            self.assertGreater(host.positions(ball)[:, 2].max(), 1.1)
        self.assertEqual(len(options.edits), 1)

    def test_strokes_and_handles_are_undone_in_turn(self):
        ball = self.built()
        self.settle("levels")
        seen = [places(ball)]
        for ratio, points in ((0.2, [[0, 0, 1]]), (0.6, [[1, 0, 0], [0.9, 0.3, 0]])):
            ball.relievo.progressive.ratio = ratio
            self.draw(ball, points, height=0.2, radius=0.5)
            bpy.ops.relievo.levels_edit(point=points[0], radius=0.8, move=(0.1, 0, 0.1))
            ball.relievo.progressive.ratio = 1.0
            seen.append(places(ball))
            self.settle("edits")
        for wanted in (seen[1], seen[0]):
            bpy.ops.ed.undo()
            numpy.testing.assert_allclose(places(bpy.data.objects["ball"]), wanted, atol=1e-5)
        for wanted in seen[1:]:
            bpy.ops.ed.redo()
            numpy.testing.assert_allclose(places(bpy.data.objects["ball"]), wanted, atol=1e-5)

    def test_files_keep_strokes_with_their_stamps(self):
        with host.folder() as folder:
            path = os.path.join(folder, "stamped.blend")
            ball = self.built()
            image = bpy.data.images.new("dots", 4, 4, float_buffer=True)
            image.pixels.foreach_set(numpy.tile([1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5, 1.0], 8).astype(numpy.float32))
            bpy.context.scene.relievo.brush.stamp = image
            ball.relievo.progressive.ratio = 0.5
            for points in ([[0, 0, 1]], [[0, 0, -1]]):
                self.assertEqual(self.draw(ball, points, height=0.3, radius=0.6), {"FINISHED"})
            kept = [name for name in ball.keys() if name.startswith(self.relievo.data.progressive.STAMPS)]
            self.assertEqual(len(kept), 1)
            coarse = places(ball)
            ball.relievo.progressive.ratio = 1.0
            finest = places(ball)
            ball.relievo.progressive.ratio = 0.5
            bpy.context.scene.relievo.brush.stamp = None
            bpy.data.images.remove(image)
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
            ball = bpy.data.objects["ball"]
            numpy.testing.assert_array_equal(places(ball), coarse)
            ball.relievo.progressive.ratio = 1.0
            numpy.testing.assert_allclose(places(ball), finest, atol=1e-5)
            # Without it the strokes are not made as something else.
            bpy.ops.wm.open_mainfile(filepath=path)
            ball = bpy.data.objects["ball"]
            del ball[kept[0]]
            ball.relievo.progressive.ratio = 1.0
            self.assertIn("its stamp dots is gone", self.relievo.data.progressive.trouble(ball))
            host.select(ball)
            bpy.ops.relievo.levels_clear(keep="LEVEL")
            self.assertFalse([name for name in ball.keys() if name.startswith("relievo_")])

    def test_strokes_that_cannot_be_made_are_told_and_change_nothing(self):
        ball = self.built()
        ball.relievo.progressive.ratio = 0.3
        before = shape(ball)
        for points, settings, text in (
            ([], {}, "points"),
            ([[9, 9, 9]], {}, "no vertex is in the brush"),
            ([[0, 0]], {}, "points"),
            ("nonsense", {}, "points"),
            ([[0, 0, 1]], {"jitter_position": 1.0}, "jitter_position"),
        ):
            self.refused(lambda: self.draw(ball, points, **settings), text)
            self.assertEqual(len(ball.relievo.progressive.edits), 0)
            numpy.testing.assert_array_equal(shape(ball), before)
        self.draw(ball, [[0, 0, 1]], jitter_position=0.0)
        kept = ball.relievo.progressive.edits[0].text
        for old, new in (("layer", "carve"), ("sculpt", "paint"), ('"points": [[', '"points": [[7, '), ('"curves": {}', '"curves": 3')):
            self.assertIn(old, kept)
            ball.relievo.progressive.edits[0].text = kept.replace(old, new, 1)
            self.refused(lambda: self.draw(ball, [[0, 0, 1]]), "Edit 1 cannot be made again")


class Hooks(Case):
    def hooked(self, *places, ratio=0.1, **options):
        """A ball with levels, and empties at places that are hooks of it, at a coarse level; the finest is shown."""
        ball = self.built()
        ball.relievo.progressive.ratio = ratio
        empties = []
        for place in places:
            empty = bpy.data.objects.new("hook", None)
            empty.location = place
            bpy.context.scene.collection.objects.link(empty)
            empties.append(empty)
        bpy.context.view_layer.update()
        host.select(ball, *empties)
        options = {"radius": 0.8, **options}
        self.assertEqual(bpy.ops.relievo.levels_hook(**options), {"FINISHED"})
        ball.relievo.progressive.ratio = 1.0
        return ball, empties

    def at(self, frame):
        bpy.context.scene.frame_set(frame)

    def key(self, empty, frame, **values):
        for name, value in values.items():
            setattr(empty, name, value)
            empty.keyframe_insert(name, frame=frame)

    def test_keyframes_of_several_hooks_animate_all_levels(self):
        ball, (top, side) = self.hooked((0, 0, 1), (1, 0, 0))
        rest = places(ball)
        self.key(top, 1, location=(0, 0, 1), rotation_euler=(0, 0, 0))
        self.key(top, 11, location=(0, 0, 1.5), rotation_euler=(0.0, 0.0, 0.5))
        self.key(side, 1, location=(1, 0, 0))
        self.key(side, 11, location=(1.25, 0, 0))
        self.at(11)
        moved = places(ball)
        # The same by handles of the library.
        import librelievo as rl

        options = ball.relievo.progressive
        level = rl.Level(rl.Progressive(self.relievo.data.mesh.Triangles(options.original).build()))
        level.set_triangles(round(0.1 * options.finest))
        radius = numpy.float32(0.8)
        grips = [
            rl.Grip(rl.Region((0, 0, 1), radius, "smooth"), (0, 0, 0.5), (0, 0, 1), 0.5),
            rl.Grip(rl.Region((1, 0, 0), radius, "smooth"), (0.25, 0, 0), (0, 0, 1), 0.0),
        ]
        level.edit(grips, [])
        level.set_triangles(options.finest)
        level.update()
        numpy.testing.assert_allclose(moved, numpy.sort(level.points, 0), atol=1e-5)
        self.assertEqual(len(options.edits), 0)
        # Other frames and levels follow, and at rest it is as it was.
        self.at(6)
        self.assertTrue(rest[:, 2].max() + 0.1 < places(ball)[:, 2].max() < moved[:, 2].max() - 0.1)
        options.ratio = 0.2
        self.assertGreater(places(ball)[:, 2].max(), 1.1)
        options.ratio = 1.0
        self.at(1)
        numpy.testing.assert_allclose(places(ball), rest, atol=1e-5)
        # So they are in files.
        with host.folder() as folder:
            path = os.path.join(folder, "hooked.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
            self.at(11)
            numpy.testing.assert_allclose(places(bpy.data.objects["ball"]), moved, atol=1e-5)

    def test_what_is_held_stays_and_what_is_gone_rests(self):
        ball, (top, side) = self.hooked((0, 0, 1), (0.6, 0, 0.8))
        top.location = (0, 0, 1.5)
        bpy.context.view_layer.update()
        free = places(ball)
        self.assertGreater(free[:, 2].max(), 1.25)
        ball.relievo.progressive.hooks[1].is_held = True
        top.location = (0, 0, 1.49)
        bpy.context.view_layer.update()
        # Where it is held, the surface is still on the ball.
        near = numpy.linalg.norm(host.positions(ball) - (0.6, 0, 0.8), axis=1).argmin()
        held = numpy.linalg.norm(host.positions(ball)[near] - (0.6, 0, 0.8))
        self.assertLess(held, 0.08)
        self.assertGreater(places(ball)[:, 2].max(), 1.1)
        bpy.data.objects.remove(top)
        self.at(2)
        self.assertLess(places(ball)[:, 2].max(), 1.01)

    def test_edits_are_made_at_rest_and_come_before_hooks(self):
        ball, (top,) = self.hooked((0, 0, 1))
        top.location = (0, 0, 1.5)
        bpy.context.view_layer.update()
        self.assertGreater(places(ball)[:, 2].max(), 1.25)
        host.select(ball)
        bpy.ops.relievo.levels_edit(point=(0, 0, -1), radius=0.5, move=(0, 0, -0.5))
        found = places(ball)
        self.assertGreater(found[:, 2].max(), 1.25)
        self.assertLess(found[:, 2].min(), -1.4)
        self.assertEqual(len(ball.relievo.progressive.edits), 1)
        self.assertFalse(self.relievo.data.progressive.trouble(ball))

    def test_hooks_are_released_with_the_shape_or_without(self):
        for keep, highest in (("SHAPE", 1.3), ("REST", 1.0)):
            self.setUp()
            ball, (top,) = self.hooked((0, 0, 1))
            top.location = (0, 0, 1.5)
            bpy.context.view_layer.update()
            moved = places(ball)
            host.select(ball)
            self.assertEqual(bpy.ops.relievo.levels_unhook(keep=keep), {"FINISHED"})
            self.assertEqual(len(ball.relievo.progressive.edits), keep == "SHAPE")
            if keep == "SHAPE":
                numpy.testing.assert_allclose(places(ball), moved, atol=1e-5)
            self.assertAlmostEqual(places(ball)[:, 2].max(), highest, delta=0.05)
            top.location = (0, 0, 3)
            bpy.context.view_layer.update()
            self.assertAlmostEqual(places(ball)[:, 2].max(), highest, delta=0.05)
            self.refused(bpy.ops.relievo.levels_unhook, "poll")

    def test_what_cannot_be_hooked_is_said(self):
        ball = self.built()
        self.refused(bpy.ops.relievo.levels_hook, "Select the objects")
        other = bpy.data.objects.new("hook", None)
        bpy.context.scene.collection.objects.link(other)
        ball.scale = (1, 1, 0)
        bpy.context.view_layer.update()
        host.select(ball, other)
        self.refused(bpy.ops.relievo.levels_hook, "no size")
        ball.scale = (1, 1, 1)
        bpy.context.view_layer.update()
        bpy.ops.relievo.levels_hook()
        ball.relievo.progressive.hooked_at = "nonsense"
        other.location = (0.5, 0, 0)
        bpy.context.view_layer.update()
        self.assertIn("release them", self.relievo.data.progressive.trouble(ball))


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
            name = self.relievo.data.progressive.PACKED
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
                self.assertTrue(self.relievo.data.progressive.trouble(ball))
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
        self.assertFalse(self.relievo.data.progressive.is_there(bpy.data.objects["ball"]))
        for wanted in seen[1:]:
            bpy.ops.ed.redo()
            numpy.testing.assert_array_equal(shape(bpy.data.objects["ball"]), wanted)
        bpy.ops.ed.undo()
        ball = bpy.data.objects["ball"]
        ball.relievo.progressive.ratio = 1.0
        numpy.testing.assert_array_equal(shape(ball), original)


if __name__ == "__main__":
    host.main()
