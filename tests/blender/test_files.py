"""What files keep: documents of duplicates, appended, linked and deleted objects; strokes that are made again where the
document is gone; files of older and newer add-ons."""

import json
import os
import shutil
import sys
import unittest
from pathlib import Path

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host

# The first piece of a document.
PIECE = "relievo_document_000000"
GOLDEN = Path(__file__).resolve().parent / "golden"


class Case(unittest.TestCase):
    def setUp(self):
        self.relievo = host.empty()

    def digest(self, target):
        return host.digest(self.relievo, target)

    def save(self, path):
        bpy.ops.wm.save_as_mainfile(filepath=path)

    def open(self, path):
        bpy.ops.wm.open_mainfile(filepath=path)
        return bpy.data.objects["field"]

    def refused(self, target, text):
        with self.assertRaisesRegex(RuntimeError, text) as caught:
            host.draw(target, [[0, 0, 0], [0.2, 0, 0]])
        self.assertNotIn("Traceback", str(caught.exception))


class Owners(Case):
    def drawn(self):
        field = host.field()
        host.draw(field, [[0, 0, 0], [0.2, 0, 0]])
        return field

    def test_duplicates_linked_ones_too_have_documents_and_results_of_their_own(self):
        for linked in (False, True):
            self.setUp()
            field = self.drawn()
            before = self.digest(field)
            host.select(field, field.relievo.result)
            bpy.ops.object.duplicate(linked=linked)
            copy = bpy.data.objects["field.001"]
            self.assertEqual(copy.data == field.data, linked)
            shape = host.positions(field.relievo.result)
            host.draw(copy, [[0.5, 0.5, 0], [0.7, 0.5, 0]])
            self.assertNotEqual(copy.relievo.uid, field.relievo.uid)
            self.assertNotEqual(copy.relievo.result, field.relievo.result)
            numpy.testing.assert_array_equal(host.positions(field.relievo.result), shape)
            self.assertNotEqual(self.digest(copy), before)
            self.assertEqual(self.digest(field), before)

    def test_a_renamed_object_keeps_its_document_in_the_file(self):
        with host.folder() as folder:
            field = self.drawn()
            before = self.digest(field)
            field.name = "meadow"
            path = os.path.join(folder, "renamed.blend")
            self.save(path)
            bpy.ops.wm.open_mainfile(filepath=path)
            self.assertEqual(self.digest(bpy.data.objects["meadow"]), before)

    def test_deleted_results_are_made_anew_and_deleted_objects_do_no_harm(self):
        with host.folder() as folder:
            field = self.drawn()
            gone = field.relievo.result
            host.select(gone)
            bpy.ops.object.delete()
            host.draw(field, [[0, 0.5, 0], [0.2, 0.5, 0]])
            self.assertGreater(host.positions(field.relievo.result)[:, 2].max(), 0.05)
            self.assertEqual(len(field.relievo.result.users_scene), 1)
            result = field.relievo.result
            host.select(field)
            bpy.ops.object.delete()
            self.assertEqual(self.relievo.data.state.source_of(result), result)
            self.save(os.path.join(folder, "deleted.blend"))
            bpy.ops.wm.open_mainfile(filepath=os.path.join(folder, "deleted.blend"))

    def test_a_file_that_is_saved_again_and_again_keeps_its_document(self):
        with host.folder() as folder:
            path = os.path.join(folder, "again.blend")
            field = self.drawn()
            for y in (0.2, 0.5, 0.7):
                host.draw(field, [[0, y, 0], [0.2, y, 0]])
                before = self.digest(field)
                self.save(path)
                field = self.open(path)
                self.assertEqual(self.digest(field), before)
            self.assertEqual(self.relievo.data.state.of(field).document.info.undo_count, 4)

    def test_save_as_and_copies_of_files_go_on_apart(self):
        with host.folder() as folder:
            field = self.drawn()
            one, two, three = (os.path.join(folder, name) for name in ("one.blend", "two.blend", "three.blend"))
            self.save(one)
            shutil.copy(one, three)
            host.draw(field, [[0, 0.5, 0], [0.2, 0.5, 0]])
            second = self.digest(field)
            self.save(two)
            host.draw(field, [[0, -0.5, 0], [0.2, -0.5, 0]])
            self.assertEqual(self.digest(self.open(two)), second)
            first = self.digest(self.open(one))
            self.assertNotEqual(first, second)
            self.assertEqual(self.digest(self.open(three)), first)

    def test_linked_objects_and_overrides_are_refused_with_what_to_do(self):
        with host.folder() as folder:
            field = self.drawn()
            before = self.digest(field)
            path = os.path.join(folder, "library.blend")
            self.save(path)
            bpy.ops.wm.read_factory_settings(use_empty=True)
            self.relievo = host.enable()
            with bpy.data.libraries.load(path, link=True) as (_there, wanted):
                wanted.objects = ["field"]
            linked = wanted.objects[0]
            bpy.context.scene.collection.objects.link(linked)
            self.save(os.path.join(folder, "linking.blend"))
            with self.assertRaisesRegex(self.relievo.core.error.Refused, "Make Local"):
                self.relievo.data.state.of(linked)
            over = linked.override_create()
            bpy.context.scene.collection.objects.link(over)
            with self.assertRaisesRegex(self.relievo.core.error.Refused, "Make Local"):
                self.relievo.data.state.of(over)
            self.save(os.path.join(folder, "linking.blend"))
            local = linked.copy()
            bpy.context.scene.collection.objects.link(local)
            self.assertIsNone(local.library)
            self.assertEqual(self.digest(local), before)


class Strokes(Case):
    def drawn(self):
        """Strokes of many kinds, on layers, on an object that is moved between them."""
        field = host.field()
        group = bpy.context.scene.relievo.brush
        host.draw(field, [[-0.5, 0.25, 0, 1.0, 0.0], [0.5, 0.251234567, 0, 0.4, 0.3]], radius=0.3, height=0.2)
        bpy.ops.relievo.layer_add(name="Relief", kind="DISPLACEMENT")
        group.settings.symmetry_x = True
        host.draw(field, [[0.3, -0.4, 0], [0.6, -0.5, 0]], sculpt_mode="CLAY")
        group.settings.symmetry_x = False
        bpy.ops.relievo.layer_set(layer=self.layer(field, "Relief"), opacity=0.5, blend="ADD", visible=True)
        field.location = (3, 1, 0)
        field.rotation_euler.z = 0.5
        bpy.context.view_layer.update()
        host.draw(field, [[3.1, 1, 0], [3.4, 1.2, 0]], "PAINT", color=(0.9, 0.1, 0.2, 1))
        image = bpy.data.images.new("stamp", 8, 8, float_buffer=True)
        image.pixels.foreach_set(numpy.tile(numpy.linspace(0, 1, 8 * 8, dtype=numpy.float32)[:, None], 4).ravel())
        group.stamp = image
        bpy.ops.relievo.curves()
        curve = self.relievo.core.settings.curve_nodes(group)["strength"].mapping
        curve.curves[0].points[0].location = (0.0, 0.8)
        curve.update()
        group.settings.strength_pressure = 1.0
        host.draw(field, [[2.6, 1, 0, 0.2], [2.9, 1.2, 0, 0.3]], sculpt_mode="DRAW")
        group.stamp = None
        host.draw(field, [[2.9, 0.6, 0], [3.1, 0.6, 0]], sculpt_mode="PINCH", radius=0.3, height=0.3)
        return field

    def layer(self, field, name):
        return next(layer.id for layer in self.relievo.data.state.of(field).detail.layers if layer.name == name)

    def test_vectors_and_pinches_are_undone_and_saved(self):
        with host.folder() as folder:
            bpy.ops.ed.undo_push(message="start")
            field = host.field()
            host.draw(field, [[-0.5, 0, 0], [0.5, 0, 0]], radius=0.3, height=0.2)
            bpy.ops.ed.undo_push(message="draw")
            before = self.digest(field)
            shape = host.positions(field.relievo.result)
            for mode in ("PINCH", "VECTOR"):
                host.draw(field, [[-0.4, 0.1, 0], [0.4, 0.1, 0]], sculpt_mode=mode, height=0.4)
                bpy.ops.ed.undo_push(message=mode)
            moved = host.positions(field.relievo.result) - shape
            self.assertGreater(numpy.abs(moved[:, :2]).max(), 0.01)
            after = self.digest(field)
            for _ in range(2):
                bpy.ops.ed.undo()
            self.assertEqual(self.digest(bpy.data.objects["field"]), before)
            for _ in range(2):
                bpy.ops.ed.redo()
            self.assertEqual(self.digest(bpy.data.objects["field"]), after)
            path = os.path.join(folder, "vectors.blend")
            self.save(path)
            self.assertEqual(self.digest(self.open(path)), after)

    def test_strokes_are_made_again_where_the_document_is_gone(self):
        with host.folder() as folder:
            path = os.path.join(folder, "lost.blend")
            field = self.drawn()
            before = self.digest(field)
            count = len(field.relievo.strokes)
            self.assertEqual(count, 5)
            self.save(path)
            field = self.open(path)
            self.relievo.data.document.clear(field)
            # Nothing is replaced unasked.
            shown = host.positions(field.relievo.result)
            self.refused(field, "The document of field is gone.*make its strokes again")
            numpy.testing.assert_array_equal(host.positions(field.relievo.result), shown)
            host.select(field)
            self.assertEqual(bpy.ops.relievo.replay(), {"FINISHED"})
            self.assertEqual(host.digest(self.relievo, field), before)
            made = self.relievo.data.state.of(field)
            self.assertEqual(made.revision, field.relievo.revision)
            names = {layer.name: layer.opacity for layer in made.detail.layers}
            self.assertEqual(names["Relief"], 0.5)
            # What is done from here on can be undone, to the state that was found again.
            bpy.ops.ed.undo_push(message="found")
            host.draw(field, [[3, 1, 0], [3.1, 1, 0]])
            bpy.ops.ed.undo_push(message="stroke")
            self.assertNotEqual(self.digest(field), before)
            bpy.ops.ed.undo()
            self.assertEqual(self.digest(bpy.data.objects["field"]), before)
            # And it is saved as any other.
            self.save(path)
            self.assertEqual(self.digest(self.open(path)), before)

    def test_strokes_on_a_pose_are_made_again_on_it(self):
        field = host.field()
        lift = field.modifiers.new("lift", "DISPLACE")
        lift.strength, lift.mid_level, lift.direction = 0.3, 0.0, "Z"
        bpy.context.view_layer.update()
        host.draw(field, [[-0.5, 0, 0.3], [0.5, 0, 0.3]], radius=0.2)
        before = self.digest(field)
        lift.strength = 0.0
        bpy.context.view_layer.update()
        self.assertEqual(bpy.ops.relievo.replay(), {"FINISHED"})
        lift.strength = 0.3
        bpy.context.view_layer.update()
        bpy.ops.relievo.result_mesh()
        self.assertEqual(self.digest(field), before)

    def test_the_operator_tells_what_it_made_again_and_what_it_cannot(self):
        field = self.drawn()
        before = self.digest(field)
        self.assertEqual(bpy.ops.relievo.replay(), {"FINISHED"})
        self.assertEqual(self.digest(field), before)
        self.relievo.data.state.forget_all()
        cut = bytes(field[PIECE])[:100]
        del field[PIECE]
        field[PIECE] = cut
        self.refused(field, "damaged: bytes are missing")
        # The stamp is kept with the strokes, whatever becomes of the image.
        bpy.data.images.remove(bpy.data.images["stamp"])
        self.assertEqual(bpy.ops.relievo.replay(), {"FINISHED"})
        self.assertEqual(self.digest(field), before)
        # A stroke whose stamp is damaged and one that is damaged itself are left out; the others are made.
        name = next(name for name in field.keys() if name.startswith("relievo_array_"))
        cut = bytes(field[name])[:20]
        del field[name]
        field[name] = cut
        field.relievo.strokes[1].text = '{"points": 7}'
        self.assertEqual(bpy.ops.relievo.replay(), {"FINISHED"})
        # Three strokes, and the layers.
        self.assertEqual(self.relievo.data.state.of(field).document.info.undo_count, 3 + 1)
        field.relievo.layers = "nonsense"
        self.assertEqual(bpy.ops.relievo.replay(), {"FINISHED"})

    def test_drawing_point_by_point_is_the_same_as_at_once(self):
        """What a stroke keeps makes the same again although it was drawn event by event."""
        import librelievo as rl

        relievo, points = self.relievo, [[-0.5 + 0.07 * step, 0.2 * (step % 3), 0, 0.5 + 0.03 * step, 0.02 * step] for step in range(15)]
        for action in ("SCULPT", "PAINT"):
            found = []
            for by_events in (True, False):
                self.setUp()
                field = host.field()
                made = relievo.data.state.of(field)
                kept, pixels = relievo.data.stroke.describe(bpy.context.scene, action)
                brush = relievo.data.stroke.brush(kept, pixels)
                if by_events:
                    drawn = rl.Stroke(made.detail, brush)
                    for point in points:
                        drawn.extend([point])
                        made.detail.commit()
                    drawn.end()
                else:
                    rl.stroke.run(made.detail, brush, points)
                made.detail.commit()
                found.append(self.digest(field))
            self.assertEqual(found[0], found[1])


class Versions(Case):
    def test_a_file_of_the_first_format_opens_and_goes_on(self):
        with host.folder() as folder:
            path = shutil.copy(GOLDEN / "format-1.blend", os.path.join(folder, "old.blend"))
            field = self.open(path)
            self.assertEqual(field.relievo.format, 1)
            heights = host.positions(field.relievo.result)
            self.assertEqual(len(heights), (4 * 8 + 1) ** 2)
            made = self.relievo.data.state.of(field)
            self.assertEqual(made.document.info.undo_count, 2)
            host.draw(field, [[0, 0.7, 0], [0.2, 0.7, 0]])
            after = self.digest(field)
            self.assertEqual(field.relievo.format, self.relievo.data.state.FORMAT)
            self.save(path)
            self.assertEqual(self.digest(self.open(path)), after)
            # Its strokes, which have fewer digits and no place, make nearly the same.
            field = self.open(shutil.copy(GOLDEN / "format-1.blend", path))
            kept = host.positions(field.relievo.result)
            bpy.context.view_layer.objects.active = field
            self.assertEqual(bpy.ops.relievo.replay(), {"FINISHED"})
            numpy.testing.assert_allclose(host.positions(field.relievo.result), kept, atol=1e-3)

    def test_what_a_newer_addon_may_have_written_is_told(self):
        field = host.field()
        host.draw(field, [[0, 0, 0], [0.2, 0, 0]])
        field.relievo.format = self.relievo.data.state.FORMAT + 1
        self.refused(field, "newer Relievo add-on")
        for operator in (bpy.ops.relievo.result_mesh, bpy.ops.relievo.layer_add, bpy.ops.relievo.replay):
            with self.assertRaisesRegex(RuntimeError, "newer Relievo add-on"):
                operator()
        field.relievo.format = self.relievo.data.state.FORMAT
        # A stroke with what is not known is made as far as it is understood; one that cannot be is left out.
        entry = field.relievo.strokes[0]
        kept = json.loads(entry.text)
        entry.text = json.dumps({**kept, "future": {"a": 1}})
        self.assertEqual(bpy.ops.relievo.replay(), {"FINISHED"})
        self.assertEqual(self.relievo.data.state.of(field).document.info.undo_count, 1)
        entry.text = json.dumps({**kept, "options": {**kept["options"], "mode": "unheard of"}})
        self.assertEqual(bpy.ops.relievo.replay(), {"FINISHED"})
        self.assertEqual(self.relievo.data.state.of(field).document.info.undo_count, 0)

    def test_a_damaged_document_is_refused(self):
        field = host.field()
        host.draw(field, [[0, 0, 0], [0.2, 0, 0]])
        self.relievo.data.state.forget_all()
        packed, history = bytes(field[PIECE]), field["relievo_history"]
        flipped = bytearray(packed)
        flipped[len(packed) // 2] ^= 1
        for damaged in (b"", packed[:20], packed[: len(packed) // 8], packed[:-1], bytes(flipped), packed + b"\0"):
            del field[PIECE]
            field[PIECE] = damaged
            self.refused(field, "damaged")
        del field[PIECE]
        field[PIECE] = packed
        for text in ("no JSON", "7", "{}", '{"revisions": [0], "position": 1}', history.replace("checksum", "sum")):
            field["relievo_history"] = text
            self.refused(field, "damaged")
        # What formats 1 and 2 have is one property without a checksum; the library refuses what is cut.
        del field[PIECE]
        field["relievo_history"] = json.dumps({"revisions": [0, 1], "position": 1})
        field["relievo_document"] = packed[:-1]
        self.refused(field, "")


if __name__ == "__main__":
    host.main()
