"""Scenes that the add-on exports, run by `relievo scene run`: the displacement is that of the add-on."""

import os
import subprocess
import sys
import unittest
from pathlib import Path

import bpy
import mathutils
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host

COMMAND = os.environ.get("RELIEVO_COMMAND")


@unittest.skipUnless(COMMAND, "skipped: RELIEVO_COMMAND names no `relievo`")
class Scenes(unittest.TestCase):
    def setUp(self):
        self.relievo = host.empty()
        bpy.context.scene.relievo.imprint.voxels = 2**18
        bpy.context.scene.frame_start = bpy.context.scene.frame_end = 1

    def export(self, folder, field, *pressers, start="STROKES"):
        """Exports, checks and runs the scene; returns its text."""
        host.select(field, *pressers)
        path = os.path.join(folder, "scene.toml")
        self.assertEqual(bpy.ops.relievo.export_scene(filepath=path, start=start), {"FINISHED"})
        with open(path, encoding="utf-8") as file:
            text = file.read()
        with open(path, "a", encoding="utf-8") as file:
            file.write('pictures = []\nmesh = "none"\ndocuments = "last"\n')
        for arguments in (["scene", "check", path], ["scene", "run", path, "--out", os.path.join(folder, "out")]):
            ran = subprocess.run([COMMAND, *arguments], capture_output=True, text=True)
            self.assertEqual(ran.returncode, 0, ran.stderr + text)
        return text

    def displacement(self, detail):
        tiles = numpy.repeat(numpy.arange(detail.info.tile_count), 49)
        grid = numpy.linspace(0.05, 0.95, 7)
        uvs = numpy.tile([[u, v] for u in grid for v in grid], (len(tiles) // 49, 1)).astype(numpy.float32)
        found = detail.evaluate(tiles, uvs, ["displacements", "colors", "positions"])
        return found["displacements"], found["colors"], found["positions"]

    def compare(self, folder, field, atol):
        """What the add-on has against the document that the run wrote."""
        import librelievo as rl

        made = self.relievo.data.state.of(field)
        made.set_pose(made.rest)
        made.detail.commit()
        documents = list(Path(folder, "out").rglob("*.relievo"))
        self.assertEqual(len(documents), 1, documents)
        with self.relievo.data.mesh.to_native(field.data) as cage:
            surface = rl.Surface(self.relievo.core.native.context(), cage, kind=made.kind.lower())
        other = rl.Detail(surface, tile_size=made.tile_size)
        other.add_paint(color=(0.8, 0.8, 0.8, 1.0), tile_size=made.tile_size)
        kept = rl.Document.open(other, str(documents[0]))
        other.commit()
        ours, theirs = self.displacement(made.detail), self.displacement(other)
        self.assertGreater(numpy.abs(ours[0]).max(), 0.02)
        for name, one, two, tolerance in zip(("heights", "colours", "positions"), ours, theirs, (atol, 0.025, 2 * atol)):
            away = numpy.abs(one - two)
            self.assertLess(float(away.max()), tolerance, name)
        kept.release()
        return theirs[0]

    def test_strokes_with_stamps_curves_layers_and_pinches(self):
        with host.folder() as folder:
            field = host.field()
            field.relievo.tile_size = "32"
            group = bpy.context.scene.relievo.brush
            host.draw(field, [[-0.5, 0.25, 0, 1.0], [0.5, 0.25, 0, 0.4]], radius=0.3, height=0.2)
            host.draw(field, [[-0.5, 0.3, 0, 1.0], [0.5, 0.25, 0, 0.4]], "PAINT", color=(1, 0.1, 0, 1))
            bpy.ops.relievo.layer_add(name="Relief", kind="DISPLACEMENT")
            bpy.ops.relievo.layer_set(layer=self.layer(field, "Relief"), opacity=0.5, blend="ADD", visible=True)
            image = bpy.data.images.new("bumps", 16, 8, float_buffer=True, is_data=True)
            values = numpy.random.default_rng(5).random((8, 16, 1)).astype(numpy.float32)
            pixels = numpy.concatenate([values, values, values, numpy.ones_like(values)], axis=2)
            image.pixels.foreach_set(pixels.ravel())
            group.stamp = image
            group.stamp_settings.scale, group.stamp_settings.angle = 1.5, 0.4
            bpy.ops.relievo.curves()
            curve = self.relievo.core.settings.curve_nodes(group)["size"].mapping
            curve.curves[0].points[0].location = (0.0, 0.5)
            curve.update()
            group.settings.size_pressure = 1.0
            host.draw(field, [[-0.4, -0.4, 0, 0.2], [0.4, -0.5, 0, 0.9]], radius=0.25, height=0.1, sculpt_mode="DRAW")
            group.stamp, group.settings.size_pressure = None, 0.0
            host.draw(field, [[-0.2, 0.6, 0], [0.2, 0.6, 0]], radius=0.3, height=0.3, sculpt_mode="PINCH")
            # Strokes lie where the object is now.
            field.location, field.rotation_euler.z = (2, 1, 0.5), 0.7
            bpy.context.view_layer.update()
            text = self.export(folder, field)
            for wanted in ("[stamps.stamp_0]", "size_curve = [[0.0, 0.5]", 'layer = "Relief"', 'sculpt = "pinch"'):
                self.assertIn(wanted, text)
            self.compare(folder, field, 2e-3)

    def layer(self, field, name):
        return next(layer.id for layer in self.relievo.data.state.of(field).detail.layers if layer.name == name)

    def test_a_sheared_surface_and_a_sheared_collider_that_turns(self):
        with host.folder() as folder:
            field, ball = host.field(), host.ball(0.3)
            field.relievo.tile_size = "32"
            turned = mathutils.Matrix.Rotation(0.6, 4, "Y") @ mathutils.Matrix.Diagonal((1, 2, 1, 1))
            field.matrix_world = mathutils.Matrix.Translation((1, 0, 0)) @ turned @ mathutils.Matrix.Rotation(0.5, 4, "Z")
            bpy.context.view_layer.update()
            parent = bpy.data.objects.new("parent", None)
            bpy.context.scene.collection.objects.link(parent)
            parent.scale = (1, 1, 0.7)
            ball.parent = parent
            for frame, x, turn in ((1, 0.7, 0.3), (4, 1.3, 1.2)):
                parent.location = (x, 0, -0.6 * (x - 1) + 0.25)
                ball.rotation_euler.x = turn
                parent.keyframe_insert("location", frame=frame)
                ball.keyframe_insert("rotation_euler", frame=frame)
            # A parent that is scaled and turned shears what is turned below it; an object alone cannot be.
            above = bpy.data.objects.new("above", None)
            bpy.context.scene.collection.objects.link(above)
            above.matrix_world = mathutils.Matrix.Translation((1, 0, 0)) @ turned
            field.parent, field.matrix_parent_inverse = above, mathutils.Matrix()
            field.location, field.scale, field.rotation_euler = (0, 0, 0), (1, 1, 1), (0, 0, 0.5)
            bpy.context.scene.frame_end = 4
            bpy.context.view_layer.update()
            host.select(field, ball)
            self.assertEqual(bpy.ops.relievo.imprint(), {"FINISHED"})
            text = self.export(folder, field, ball)
            self.assertEqual(text.count("shear = "), 1 + 1 + 4)
            self.compare(folder, field, 0.03)

    def test_deforming_colliders_are_written_frame_by_frame(self):
        with host.folder() as folder:
            field, ball = host.field(), host.ball(0.3)
            field.relievo.tile_size = "32"
            ball.location = (-0.5, 0.25, 0.25)
            ball.shape_key_add(name="rest")
            away = ball.shape_key_add(name="away")
            for point in away.data:
                point.co.x += 1.0
                point.co.z -= 0.05
            for frame, value in ((1, 0.0), (4, 1.0)):
                away.value = value
                away.keyframe_insert("value", frame=frame)
            bpy.context.scene.frame_end = 4
            host.select(field, ball)
            self.assertEqual(bpy.ops.relievo.imprint(), {"FINISHED"})
            text = self.export(folder, field, ball)
            self.assertIn('sequence = "scene_ball_####.obj"\ncount = 4', text)
            self.compare(folder, field, 0.03)

    def test_a_document_brings_everything(self):
        with host.folder() as folder:
            field = host.field()
            field.relievo.tile_size = "32"
            host.draw(field, [[-0.5, 0.25, 0], [0.5, 0.25, 0]], radius=0.3, height=0.2)
            host.draw(field, [[-0.5, -0.25, 0], [0.5, -0.25, 0]], "PAINT", color=(1, 0, 0, 1))
            self.export(folder, field, start="DOCUMENT")
            self.compare(folder, field, 1e-6)

    def test_what_scene_files_cannot_have_is_said(self):
        with host.folder() as folder:
            field, ball = host.field(), host.ball(0.3)
            host.draw(field, [[0, 0, 0], [0.1, 0, 0]])
            decimate = ball.modifiers.new("fewer", "DECIMATE")
            for frame, ratio in ((1, 1.0), (2, 0.5)):
                decimate.ratio = ratio
                decimate.keyframe_insert("ratio", frame=frame)
            bpy.context.scene.frame_end = 2
            host.select(field, ball)
            path = os.path.join(folder, "scene.toml")
            with self.assertRaisesRegex(RuntimeError, "other faces on the way"):
                bpy.ops.relievo.export_scene(filepath=path)
            self.assertFalse(os.path.exists(path))


if __name__ == "__main__":
    host.main()
