"""Repair of the active mesh: what it becomes, what stays on its faces, what is reported, undone and refused."""

import sys
import unittest
from pathlib import Path

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host

# A box of 2 x 2 x 2 whose faces look outwards.
CORNERS = numpy.array([[x, y, z] for z in (0, 2) for y in (0, 2) for x in (0, 2)], float)
FACES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]


def edges_of(data):
    """How many faces every edge has, and whether each is passed once in each direction."""
    passed = {}
    for face in data.polygons:
        ring = list(face.vertices)
        for a, b in zip(ring, ring[1:] + ring[:1]):
            passed.setdefault((min(a, b), max(a, b)), []).append(a < b)
    return [len(ways) for ways in passed.values()], all(sorted(ways) == [False, True] for ways in passed.values())


def volume_of(target):
    """The signed volume of an object with a closed mesh."""
    points, total = host.positions(target).astype(float), 0.0
    for face in target.data.polygons:
        ring = [points[index] for index in face.vertices]
        total += sum(numpy.dot(ring[0], numpy.cross(b, c)) for b, c in zip(ring[1:], ring[2:])) / 6
    return total


class Repairs(unittest.TestCase):
    def setUp(self):
        self.relievo = host.empty()
        bpy.context.preferences.edit.undo_steps = 32

    def soup(self):
        """A box whose faces share no points, one of which looks inwards, one is there twice and one is not there; with
        two layers of texture coordinates, colours, materials and one smooth face."""
        faces = [FACES[0][::-1], *FACES[1:5], FACES[4]]
        points = numpy.concatenate([CORNERS[face] for face in faces])
        soup = host.add("soup", points, numpy.arange(len(points)), 4)
        data = soup.data
        for layer, factor in (("first", 1.0), ("second", 0.5)):
            uvs = factor * (points[:, :2] + 0.25 * points[:, 2:]) / 2.5
            data.uv_layers.new(name=layer).data.foreach_set("uv", uvs.astype(numpy.float32).ravel())
        data.uv_layers.active = data.uv_layers["second"]
        colors = numpy.column_stack([points / 2, numpy.ones(len(points))])
        data.color_attributes.new("Tint", "FLOAT_COLOR", "POINT").data.foreach_set("color", colors.ravel())
        for number in range(3):
            data.materials.append(bpy.data.materials.new(f"material {number}"))
        data.polygons.foreach_set("material_index", [0, 1, 2, 2, 1, 0])
        data.polygons.foreach_set("use_smooth", [False, True, False, False, False, False])
        return soup

    def repair(self, target, **options):
        for name, value in options.items():
            setattr(bpy.context.scene.relievo.repair, name, value)
        host.select(target)
        self.assertEqual(bpy.ops.relievo.repair(), {"FINISHED"})
        self.assertFalse(target.data.validate(verbose=True))
        return target.relievo.repair_report.splitlines()

    def test_a_soup_becomes_a_closed_box(self):
        soup = self.soup()
        report = self.repair(soup, hole_area=10.0, refine=False, fair=False)
        counts, is_oriented = edges_of(soup.data)
        self.assertEqual((set(counts), is_oriented, len(soup.data.vertices)), ({2}, True, 8))
        self.assertAlmostEqual(volume_of(soup), 8.0, places=5)
        self.assertIn("Doubled faces: 1", report)
        self.assertIn("Holes filled: 1", report)
        self.assertIn("Faces turned over: 1", report)
        self.assertEqual(report[-1], "Closed: 8 points, 7 faces, 1 part")

    def test_faces_keep_what_is_on_them(self):
        soup = self.soup()
        self.repair(soup, fill=False)
        data = soup.data
        points, corners = host.positions(soup), self.relievo.data.mesh.get_corners(soup.data)
        self.assertEqual(data.uv_layers.active.name, "second")
        for layer, factor in (("first", 1.0), ("second", 0.5)):
            uvs = numpy.empty((len(corners), 2), numpy.float32)
            data.uv_layers[layer].data.foreach_get("uv", uvs.ravel())
            at = points[corners]
            numpy.testing.assert_allclose(uvs, factor * (at[:, :2] + 0.25 * at[:, 2:]) / 2.5, atol=1e-6)
        tint = data.color_attributes["Tint"]
        colors = numpy.empty((len(tint.data), 4), numpy.float32)
        tint.data.foreach_get("color", colors.ravel())
        numpy.testing.assert_allclose(colors[:, :3], points / 2 if tint.domain == "POINT" else points[corners] / 2, atol=1e-6)
        self.assertEqual(len(data.materials), 3)
        # The faces by their centres: below, above, before, right, behind.
        wanted = {(1, 1, 0): (0, False), (1, 1, 2): (1, True), (1, 0, 1): (2, False), (2, 1, 1): (2, False), (1, 2, 1): (1, False)}
        found = {tuple(round(x) for x in face.center): (face.material_index, face.use_smooth) for face in data.polygons}
        self.assertEqual(found, wanted)

    def test_a_sound_mesh_stays_and_a_repair_is_undone(self):
        ball = host.ball(1.0)
        points, count = host.positions(ball), len(ball.data.polygons)
        self.assertEqual(self.repair(ball)[0], "No defects")
        numpy.testing.assert_array_equal(host.positions(ball), points)
        self.assertEqual(len(ball.data.polygons), count)
        soup = self.soup()
        before = host.positions(soup)
        bpy.ops.ed.undo_push(message="soup")
        self.repair(soup)
        bpy.ops.ed.undo_push(message="repair")
        bpy.ops.ed.undo()
        soup = bpy.data.objects["soup"]
        numpy.testing.assert_array_equal(host.positions(soup), before)
        self.assertEqual(([*soup.data.uv_layers.keys()], soup.relievo.repair_report), (["first", "second"], ""))
        bpy.ops.ed.redo()
        self.assertIn("Doubled faces: 1", bpy.data.objects["soup"].relievo.repair_report)

    def test_linked_duplicates_stay(self):
        soup = self.soup()
        other = bpy.data.objects.new("other", soup.data)
        bpy.context.scene.collection.objects.link(other)
        self.repair(soup)
        self.assertEqual(len(other.data.polygons), 6)
        self.assertNotEqual(other.data, soup.data)

    def test_a_cancelled_repair_changes_nothing(self):
        from relievo.core import job
        from relievo.ops import repair

        soup = self.soup()
        host.select(soup)
        before = host.positions(soup)
        worker = job.Worker(host.operator(repair.RELIEVO_OT_repair))
        worker.is_cancelled = True
        while not worker.advance(1.0):
            pass
        numpy.testing.assert_array_equal(host.positions(soup), before)

    def test_what_must_keep_its_faces_is_refused(self):
        field = host.field()
        host.draw(field, [[0, 0, 0], [0.2, 0, 0]])
        leveled = host.ball(1.0, "leveled")
        host.select(leveled)
        bpy.ops.relievo.levels_build()
        keyed = host.ball(1.0, "keyed")
        keyed.shape_key_add(name="rest")
        empty = host.add("empty", numpy.zeros((0, 3)), numpy.zeros(0, int), 3)
        refused = {field: "clear the detail", field.relievo.result: "is the result of", leveled: "clear the levels"}
        for target, text in {**refused, keyed: "shape keys", empty: "no faces"}.items():
            count = len(target.data.polygons)
            host.select(target)
            with self.assertRaisesRegex(RuntimeError, text) as caught:
                bpy.ops.relievo.repair()
            self.assertNotIn("Traceback", str(caught.exception))
            self.assertEqual(len(target.data.polygons), count)


if __name__ == "__main__":
    host.main()
