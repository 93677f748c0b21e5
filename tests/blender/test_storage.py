"""Where details and baked frames are stored: documents in every copy that Blender makes of an object, what is lost and
what is then refused, what is cleared and comes back by undo."""

import os
import shutil
import sys
import types
import unittest
from pathlib import Path
from unittest import mock

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host


class Case(unittest.TestCase):
    def setUp(self):
        self.relievo = host.empty()
        folder = host.folder()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 2
        bpy.context.scene.relievo.imprint.voxels = 2**16

    def digest(self, target):
        return host.digest(self.relievo, target)

    def path(self, name):
        return os.path.join(self.folder, name)

    def save(self, name):
        bpy.ops.wm.save_as_mainfile(filepath=self.path(name))

    def open(self, name):
        bpy.ops.wm.open_mainfile(filepath=self.path(name))
        return bpy.data.objects["field"]

    def pressing(self, depth=0.1):
        ball = bpy.data.objects.get("ball") or host.ball(0.3)
        ball.location = (0, 0.25, 0.3 - depth)
        return ball

    def imprint(self, field, depth=0.1, **options):
        host.select(field, self.pressing(depth))
        self.assertEqual(bpy.ops.relievo.imprint(**options), {"FINISHED"})

    def dented(self):
        """A sheet with a stroke and the dent of a ball, 0.1 deep."""
        field = host.field()
        host.draw(field, [[-0.5, -0.5, 0], [0.5, -0.5, 0]], radius=0.2)
        self.imprint(field)
        return field

    def check_dent(self, field, depth=0.1):
        """Draws a stroke beside the dent, which stays."""
        host.draw(field, [[-0.5, -0.7, 0], [0.5, -0.7, 0]], radius=0.1)
        low = float(host.positions(field.relievo.result)[:, 2].min())
        self.assertAlmostEqual(low, -depth, delta=0.015)

    def asked(self, kind, target):
        """What an operator asks before it begins; it has done nothing yet."""
        asked = []
        manager = types.SimpleNamespace(invoke_confirm=lambda *told, **shown: asked.append(shown) or {"RUNNING_MODAL"})
        question = types.SimpleNamespace(
            question=kind.question, bl_label=kind.bl_label, is_confirmed=False, dialog=getattr(kind, "dialog", None)
        )
        context = types.SimpleNamespace(window_manager=manager, active_object=target)
        self.assertEqual(kind.invoke(question, context, None), {"RUNNING_MODAL"})
        self.assertEqual(len(asked), 1)
        return asked[0]


class Documents(Case):
    def test_autosave_has_the_detail(self):
        """Autosave and quit.blend call no handler of saving."""
        field = self.dented()
        self.save("field.blend")
        self.imprint(field, 0.2)
        before = self.digest(field)
        handlers = list(bpy.app.handlers.save_pre)
        bpy.app.handlers.save_pre.clear()
        bpy.ops.wm.save_as_mainfile(filepath=self.path("autosave.blend"), copy=True)
        bpy.app.handlers.save_pre.extend(handlers)
        field = self.open("autosave.blend")
        self.assertEqual(self.digest(field), before)
        self.check_dent(field, 0.2)

    def test_the_addon_is_switched_off_and_on(self):
        bpy.context.preferences.edit.undo_steps = 32
        field = host.field()
        bpy.ops.ed.undo_push(message="start")
        host.draw(field, [[-0.5, -0.5, 0], [0.5, -0.5, 0]], radius=0.2)
        bpy.ops.ed.undo_push(message="stroke")
        first = self.digest(field)
        self.imprint(field)
        bpy.ops.ed.undo_push(message="imprint")
        before = self.digest(field)
        bpy.ops.preferences.addon_disable(module="relievo")
        self.relievo = host.enable()
        field = bpy.data.objects["field"]
        self.assertEqual(self.digest(field), before)
        self.check_dent(field)
        bpy.ops.ed.undo_push(message="beside")
        # Steps of before are those of before.
        bpy.ops.ed.undo()
        self.assertEqual(self.digest(bpy.data.objects["field"]), before)
        bpy.ops.ed.undo()
        self.assertEqual(self.digest(bpy.data.objects["field"]), first)
        bpy.ops.ed.redo()
        self.assertEqual(self.digest(bpy.data.objects["field"]), before)

    def test_steps_of_undo_have_documents_of_their_own(self):
        """As after the add-on was off: every step is found although no document is open."""
        bpy.context.preferences.edit.undo_steps = 32
        field, steps = host.field(), []
        bpy.ops.ed.undo_push(message="start")
        for y in (-0.6, -0.2, 0.2, 0.6):
            host.draw(field, [[-0.5, y, 0], [0.5, y, 0]], radius=0.2)
            bpy.ops.ed.undo_push(message="stroke")
            steps.append(self.digest(field))
        for place in (2, 1, 0):
            bpy.ops.ed.undo()
            self.relievo.data.state.forget_all()
            self.assertEqual(self.digest(bpy.data.objects["field"]), steps[place])
        for place in (1, 2):
            bpy.ops.ed.redo()
            self.assertEqual(self.digest(bpy.data.objects["field"]), steps[place])

    def test_copy_and_paste_into_another_file(self):
        def in_view(operator):
            window = bpy.context.window_manager.windows[0]
            area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
            region = next(region for region in area.regions if region.type == "WINDOW")
            with bpy.context.temp_override(window=window, area=area, region=region):
                self.assertEqual(operator(), {"FINISHED"})

        bpy.ops.wm.read_factory_settings()
        self.relievo = host.enable()
        field = self.dented()
        before = self.digest(field)
        host.select(field, field.relievo.result)
        in_view(bpy.ops.view3d.copybuffer)
        bpy.ops.wm.read_factory_settings()
        self.relievo = host.enable()
        in_view(bpy.ops.view3d.pastebuffer)
        field = bpy.data.objects["field"]
        self.assertEqual(self.digest(field), before)
        self.check_dent(field)

    def test_what_is_written_to_a_library_has_the_detail(self):
        field = self.dented()
        before = self.digest(field)
        bpy.data.libraries.write(self.path("library.blend"), {field})
        self.relievo = host.empty()
        with bpy.data.libraries.load(self.path("library.blend")) as (_there, wanted):
            wanted.objects = ["field"]
        field = wanted.objects[0]
        bpy.context.scene.collection.objects.link(field)
        self.assertEqual(self.digest(field), before)
        self.check_dent(field)

    def test_an_edit_adds_what_it_changed(self):
        """Pieces are the file of the document, and those before the last stay."""
        document = self.relievo.data.document
        field = host.field()
        with mock.patch.object(document, "GROWING", 2000):
            seen = {}
            for step in range(12):
                y = -0.6 + 0.1 * step
                host.draw(field, [[-0.5, y, 0], [0.5, y, 0]], radius=0.1)
                names = sorted(name for name in field.keys() if name.startswith(document.PIECES))
                pieces = {name: bytes(field[name]) for name in names}
                changed = [name for name, data in seen.items() if pieces.get(name) != data]
                self.assertLessEqual(len(changed), 1)
                self.assertTrue(all(len(seen[name]) < 2000 for name in changed))
                seen = pieces
                made = self.relievo.data.state.of(field)
                self.assertEqual(b"".join(pieces.values()), Path(made.path).read_bytes())
            self.assertGreater(len(seen), 3)
        before = self.digest(field)
        self.relievo.data.state.forget_all()
        self.assertEqual(self.digest(field), before)
        self.assertEqual(self.relievo.data.state.of(field).document.info.undo_count, 12)

    def test_a_crash_leaves_a_document_in_the_temporary_folder(self):
        field = self.dented()
        before = self.digest(field)
        made = self.relievo.data.state.of(field)
        crashed = os.path.join(os.path.dirname(os.path.normpath(self.relievo.data.document.folder())), f"blender_{made.uid[:8]}")
        os.mkdir(crashed)
        self.addCleanup(shutil.rmtree, crashed)
        for name in (made.path, f"{made.path}.json"):
            shutil.copy(name, crashed)
        self.relievo.data.document.clear(field)
        self.save("crashed.blend")
        self.assertEqual(self.digest(self.open("crashed.blend")), before)
        self.check_dent(bpy.data.objects["field"])
        # One of another revision is not taken for it, nor one that is damaged.
        for text in ('{"revisions": [0, 1], "position": 1}', "[]", "nonsense"):
            Path(crashed, f"{made.uid}.relievo.json").write_text(text)
            self.open("crashed.blend")
            with self.assertRaisesRegex(self.relievo.core.error.Refused, "is gone"):
                self.digest(bpy.data.objects["field"])

    def test_what_is_shown_is_not_replaced_by_less(self):
        field = self.dented()
        self.relievo.data.document.clear(field)
        self.save("lost.blend")
        field = self.open("lost.blend")
        shown = host.positions(field.relievo.result)
        host.select(field)
        for operator in (bpy.ops.relievo.result_mesh, bpy.ops.relievo.layer_add, bpy.ops.relievo.result_color):
            with self.assertRaisesRegex(RuntimeError, "is gone"):
                operator()
        with self.assertRaisesRegex(RuntimeError, "is gone"):
            host.draw(field, [[0, 0, 0], [0.2, 0, 0]])
        numpy.testing.assert_array_equal(host.positions(field.relievo.result), shown)
        self.assertEqual(len(field.relievo.strokes), 1)
        # Asked for, strokes are made again, and that can be undone.
        from relievo.tools import brush

        self.asked(brush.RELIEVO_OT_replay, field)
        numpy.testing.assert_array_equal(host.positions(field.relievo.result), shown)
        bpy.ops.ed.undo_push(message="lost")
        self.assertEqual(bpy.ops.relievo.replay(), {"FINISHED"})
        bpy.ops.ed.undo_push(message="replay")
        self.assertGreater(host.positions(field.relievo.result)[:, 2].min(), -0.02)
        bpy.ops.ed.undo()
        numpy.testing.assert_array_equal(host.positions(bpy.data.objects["field"].relievo.result), shown)

    def test_strokes_that_are_made_again_are_undone(self):
        field = self.dented()
        before = self.digest(field)
        bpy.ops.ed.undo_push(message="dented")
        host.select(field)
        self.assertEqual(bpy.ops.relievo.replay(), {"FINISHED"})
        bpy.ops.ed.undo_push(message="replay")
        again = self.digest(field)
        self.assertNotEqual(again, before)
        bpy.ops.ed.undo()
        self.assertEqual(self.digest(bpy.data.objects["field"]), before)
        bpy.ops.ed.redo()
        self.assertEqual(self.digest(bpy.data.objects["field"]), again)

    def test_an_edit_that_cannot_be_stored_is_taken_back(self):
        from relievo.tools import brush

        field = self.dented()
        before, shown = self.digest(field), host.positions(field.relievo.result)
        full = mock.patch.object(self.relievo.data.document, "write", side_effect=OSError("no space is left"))
        with full:
            with self.assertRaisesRegex(RuntimeError, "no space is left"):
                host.draw(field, [[0, -0.5, 0], [0.2, -0.5, 0]])
            # The same where the pointer draws.
            made, said = self.relievo.data.state.of(field), []
            stroke = types.SimpleNamespace(
                drawn=[[0, -0.5, 0, 1, 0]],
                stroke=mock.Mock(),
                state=made,
                target=field,
                keep=lambda made: made.record(field),
                report=lambda _kinds, text: said.append(text),
            )
            with made.edit("stroke"):
                made.detail.layers.add("More", kind="displacement")
            made.document.begin("stroke")
            self.assertEqual(brush.RELIEVO_OT_stroke.release(stroke), {"CANCELLED"})
            self.assertEqual(said, ["no space is left"])
        self.assertEqual((self.digest(field), len(field.relievo.strokes)), (before, 1))
        numpy.testing.assert_array_equal(host.positions(field.relievo.result), shown)
        self.check_dent(field)

    def test_two_files_that_went_on_apart_meet(self):
        """Both objects have one uid and one revision."""
        field = self.dented()
        self.save("one.blend")
        self.imprint(field, 0.2)
        deep = self.digest(field)
        self.save("two.blend")
        field = self.open("one.blend")
        self.imprint(field, 0.15)
        revision, uid = field.relievo.revision, field.relievo.uid
        bpy.data.objects.remove(field)
        with bpy.data.libraries.load(self.path("two.blend")) as (_there, wanted):
            wanted.objects = ["field"]
        field = wanted.objects[0]
        bpy.context.scene.collection.objects.link(field)
        self.assertEqual((field.name, field.relievo.revision, field.relievo.uid), ("field", revision, uid))
        self.assertEqual(self.digest(field), deep)
        self.check_dent(field, 0.2)

    def test_a_uid_is_no_path(self):
        field = self.dented()
        self.relievo.data.state.forget_all()
        field.relievo.uid = "../../outside"
        with self.assertRaisesRegex(RuntimeError, "damaged"):
            host.draw(field, [[0, 0, 0], [0.2, 0, 0]])


class Clearing(Case):
    def test_clear_detail_asks(self):
        from relievo.ops import result

        field = self.dented()
        before = self.digest(field)
        asked = self.asked(result.RELIEVO_OT_clear, field)
        if bpy.app.version >= (4, 1):
            self.assertIn("Undo", asked["message"])
        self.assertEqual(self.digest(field), before)

    def test_clear_detail_is_undone(self):
        bpy.context.preferences.edit.undo_steps = 32
        field = self.dented()
        before, shown = self.digest(field), host.positions(field.relievo.result)
        bpy.ops.ed.undo_push(message="dented")
        host.select(field)
        self.assertEqual(bpy.ops.relievo.clear(), {"FINISHED"})
        bpy.ops.ed.undo_push(message="clear")
        self.assertEqual((field.relievo.uid, field.relievo.result, len(field.relievo.strokes)), ("", None, 0))
        kept = [name for name in field.keys() if name.startswith("relievo_") and name not in field.bl_rna.properties]
        self.assertEqual(kept, [])
        bpy.ops.ed.undo()
        field = bpy.data.objects["field"]
        numpy.testing.assert_array_equal(host.positions(field.relievo.result), shown)
        self.assertEqual(self.digest(field), before)
        self.assertEqual(self.relievo.data.state.of(field).document.info.undo_count, 2)
        self.check_dent(field)
        bpy.ops.ed.undo_push(message="stroke")
        # From there on it goes as if it had never been cleared.
        self.save("cleared.blend")
        self.check_dent(self.open("cleared.blend"))


if __name__ == "__main__":
    host.main()
