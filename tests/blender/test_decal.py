"""Decals of the active object: meshes, layers, pins that are dragged, undo, and what is refused."""

import sys
import unittest
from pathlib import Path

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host

SIZE = 40


class Decals(unittest.TestCase):
    def setUp(self):
        self.relievo = host.empty()
        bpy.context.preferences.edit.undo_steps = 32

    def field(self):
        """A field from -1 to 1 with an image that is red on its left and blue on its right, and three pins."""
        field = host.field(8)
        image = bpy.data.images.new("label", SIZE, SIZE, alpha=True)
        pixels = numpy.zeros((SIZE, SIZE, 4), numpy.float32)
        pixels[:, : SIZE // 2, 0] = pixels[:, SIZE // 2 :, 2] = pixels[..., 3] = 1.0
        image.pixels.foreach_set(pixels.ravel())
        field.relievo.decal.image = image
        host.select(field)
        points = host.positions(field)
        self.middle, self.extent = 0.5 * (points.min(0) + points.max(0)), numpy.ptp(points[:, 0])
        for x, y in ((10, 10), (30, 12), (20, 30)):
            self.assertEqual(bpy.ops.relievo.decal_pin_add(image=(x, y), position=self.place(x, y)), {"FINISHED"})
        return field

    def place(self, x, y):
        """Where a point of the image is on the field, half as wide as the field."""
        return self.middle + 0.5 * self.extent * numpy.array([x / SIZE - 0.5, y / SIZE - 0.5, 0.0])

    def uv_at(self, field, x, y):
        """The texture coordinates of the decal's mesh nearest to a place."""
        shown = field.relievo.decal.mesh
        data = shown.data
        away = numpy.linalg.norm(host.positions(shown)[:, :2] - self.place(x, y)[:2], axis=1)
        point = int(away.argmin())
        self.assertLess(away[point], 1e-5)
        corner = next(loop.index for loop in data.loops if loop.vertex_index == point)
        return numpy.array(data.uv_layers[0].data[corner].uv)

    def look_at(self, field):
        """Looks whether the result is red under the left half of the image and blue under the right one."""
        result = field.relievo.result
        colors = numpy.empty((len(result.data.vertices), 4), numpy.float32)
        result.data.attributes["Relievo"].data.foreach_get("color", colors.ravel())
        points = host.positions(result)
        away = (points - self.middle)[:, :2] / self.extent
        is_under = (numpy.abs(away) < 0.22).all(1)
        left, right = colors[is_under & (away[:, 0] < -0.05)], colors[is_under & (away[:, 0] > 0.05)]
        self.assertTrue(len(left) > 20 and (left[:, 0] > 0.9).all() and (left[:, 2] < 0.1).all())
        self.assertTrue(len(right) > 20 and (right[:, 2] > 0.9).all() and (right[:, 0] < 0.1).all())

    def test_a_mesh_has_the_pins_where_they_were_set(self):
        field = self.field()
        self.assertEqual(bpy.ops.relievo.decal_mesh(), {"FINISHED"})
        shown = field.relievo.decal.mesh
        self.assertEqual(shown.parent, field)
        self.assertFalse(shown.data.validate(verbose=True))
        self.assertEqual(shown.data.materials[0].node_tree.nodes["Image Texture"].image.name, "label")
        for x, y in ((10, 10), (30, 12), (20, 30)):
            numpy.testing.assert_allclose(self.uv_at(field, x, y), [x / SIZE, y / SIZE], atol=1e-5)
        # From the mesh too the operators mean the decal of its object.
        host.select(shown)
        self.assertEqual(bpy.ops.relievo.decal_mesh(), {"FINISHED"})
        self.assertEqual(len([one for one in bpy.data.objects if one.relievo.decal.owner]), 1)

    def test_a_dragged_pin_is_followed_and_undone(self):
        field = self.field()
        bpy.ops.relievo.decal_mesh()
        bpy.ops.ed.undo_push(message="mesh")
        self.assertEqual(bpy.ops.relievo.decal_pin_drag(pin=2, position=self.place(21, 31)), {"FINISHED"})
        numpy.testing.assert_allclose(field.relievo.decal.pins[2].position, self.place(21, 31), atol=1e-5)
        numpy.testing.assert_allclose(self.uv_at(field, 21, 31), [20 / SIZE, 30 / SIZE], atol=1e-5)
        bpy.ops.ed.undo_push(message="drag")
        bpy.ops.ed.undo()
        field = bpy.data.objects["field"]
        numpy.testing.assert_allclose(field.relievo.decal.pins[2].position, self.place(20, 30), atol=1e-5)
        numpy.testing.assert_allclose(self.uv_at(field, 20, 30), [20 / SIZE, 30 / SIZE], atol=1e-5)

    def test_a_decal_is_painted_and_embossed_into_layers(self):
        field = self.field()
        self.assertEqual(bpy.ops.relievo.decal_apply(), {"FINISHED"})
        self.look_at(field)
        result = field.relievo.result
        painted = host.digest(self.relievo, field)
        bpy.ops.ed.undo_push(message="painted")
        field.relievo.decal.kind, field.relievo.decal.height = "RELIEF", 0.3
        self.assertEqual(bpy.ops.relievo.decal_apply(), {"FINISHED"})
        self.assertGreater(numpy.ptp(host.positions(result)[:, 2]), 0.01)
        bpy.ops.ed.undo_push(message="embossed")
        bpy.ops.ed.undo()
        field = bpy.data.objects["field"]
        self.assertEqual(host.digest(self.relievo, field), painted)

    def test_a_decal_is_painted_into_a_layer_of_triangles(self):
        field = self.field()
        field.relievo.kind = "TRIANGLES"
        self.assertEqual(bpy.ops.relievo.decal_apply(), {"FINISHED"})
        self.look_at(field)
        field.relievo.decal.kind, field.relievo.decal.height = "RELIEF", 0.3
        self.assertEqual(bpy.ops.relievo.decal_apply(), {"FINISHED"})
        self.assertGreater(numpy.ptp(host.positions(field.relievo.result)[:, 2]), 0.01)

    def test_what_cannot_be_laid_is_refused_and_changes_nothing(self):
        field = self.field()
        bpy.ops.relievo.decal_mesh()
        before = host.positions(field.relievo.decal.mesh)

        def refused(operator, expected, **options):
            with self.assertRaisesRegex(RuntimeError, expected):
                operator(**options)

        refused(bpy.ops.relievo.decal_pin_drag, "There is no pin 7", pin=7)
        pin = field.relievo.decal.pins[1]
        kept, pin.image = tuple(pin.image), (SIZE + 5, 3)
        refused(bpy.ops.relievo.decal_mesh, "outside")
        pin.image = kept
        image, field.relievo.decal.image = field.relievo.decal.image, None
        refused(bpy.ops.relievo.decal_mesh, "Choose the image")
        field.relievo.decal.image = image
        while len(field.relievo.decal.pins):
            self.assertEqual(bpy.ops.relievo.decal_pin_remove(), {"FINISHED"})
        refused(bpy.ops.relievo.decal_mesh, "Add a pin")
        numpy.testing.assert_array_equal(host.positions(field.relievo.decal.mesh), before)


if __name__ == "__main__":
    host.main()
