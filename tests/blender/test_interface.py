"""What artists find: menus that have every operator, names and tooltips, presets, keys of the brush, and the manual."""

import re
import sys
import unittest
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host


class Case(unittest.TestCase):
    def setUp(self):
        self.relievo = host.empty()


class Recorder:
    """A layout that notes what is drawn in it."""

    def __init__(self):
        self.operators, self.menus, self.texts, self.properties = [], [], [], []

    def operator(self, name, text=None, **_):
        self.operators.append(name)
        self.texts.append(text)
        return self

    def operator_menu_enum(self, name, choice, **_):
        # The choice must be one of the operator's.
        assert choice in operator_of(name).properties, (name, choice)
        self.operators.append(name)

    operator_enum = operator_menu_enum

    def menu(self, name, **_):
        self.menus.append(name)

    def prop(self, group, name, **_):
        self.properties.append((group, name))

    def separator(self, **_):
        pass

    def column(self, **_):
        return self

    row = column

    def label(self, text="", **_):
        self.texts.append(text)

    def box(self):
        return self

    def __getattr__(self, name):
        if name.startswith("template"):
            return lambda *_arguments, **_keywords: None
        raise AttributeError(name)


def operator_of(name):
    """The description of an operator."""
    group, short = name.split(".")
    return getattr(getattr(bpy.ops, group), short).get_rna_type()


def operators():
    """The names and classes of our operators."""
    return {kind.bl_idname.replace("_OT_", ".").lower(): kind for kind in ours("OT")}


def drawn(kind, context=None):
    """What a menu or panel draws."""
    layout = Recorder()
    made = type("Drawn", (), {"layout": layout, "column": lambda self: layout})
    for name in ("kind", "preset_subdir", "preset_operator"):
        if hasattr(kind, name):
            setattr(made, name, getattr(kind, name))
    kind.draw(made(), context or bpy.context)
    return layout


def ours(part):
    """Our registered classes whose names have a part."""
    return [getattr(bpy.types, name) for name in dir(bpy.types) if name.startswith(f"RELIEVO_{part}_")]


class Menus(Case):
    def test_every_operator_is_in_a_menu(self):
        """The search by F3 finds what menus have. Internal ones are of tools and lists."""
        found, left, seen = set(), ["RELIEVO_MT_object", "RELIEVO_MT_add"], set()
        while left:
            name = left.pop()
            seen.add(name)
            layout = drawn(getattr(bpy.types, name))
            found |= set(layout.operators)
            left += [other for other in layout.menus if other not in seen]
        from relievo.ui import menu

        image = Recorder()
        menu.draw_image(type("Drawn", (), {"layout": image})(), bpy.context)
        found |= set(image.operators)
        wanted = {name for name, kind in operators().items() if "INTERNAL" not in getattr(kind, "bl_options", ())}
        self.assertEqual(wanted - found, set())
        self.assertEqual({name for name in found if name.startswith("relievo.")} - wanted, set())
        # Blender's own menus have ours, until the add-on is disabled.
        places = ("VIEW3D_MT_object", "VIEW3D_MT_object_context_menu", "VIEW3D_MT_add", "IMAGE_MT_image")
        functions = lambda: [one for name in places for one in getattr(bpy.types, name)._dyn_ui_initialize()]
        self.assertEqual(len([one for one in functions() if one.__module__ == "relievo.ui.menu"]), 4)
        bpy.ops.preferences.addon_disable(module="relievo")
        self.assertEqual([one for one in functions() if one.__module__ == "relievo.ui.menu"], [])
        host.enable()

    def test_operators_and_settings_have_tooltips(self):
        """Tooltips are sentences; what has a unit says it; labels of a panel differ."""
        for name in operators():
            self.assertGreater(len(operator_of(name).description), 15, name)
        field = host.field()
        host.select(field)
        field.relievo.fluid.role = "DOMAIN"
        for kind in ours("PT"):
            if kind.bl_space_type != "VIEW_3D" or not kind.poll(bpy.context):
                continue
            labels = []
            for group, name in drawn(kind).properties:
                found = group.bl_rna.properties[name]
                labels.append(found.name)
                self.assertTrue(found.description, (kind.__name__, name))
                self.assertNotRegex(found.name, r"_|Culling|Mode$", kind.__name__)
            self.assertEqual(len(labels), len(set(labels)), (kind.__name__, labels))

    def test_tooltips_say_units(self):
        scene, field = bpy.context.scene.relievo, host.field()
        foam = field.relievo_foam
        for group in (scene.brush.settings, scene.brush.stamp_settings, scene.imprint, scene.repair, foam.settings, foam.look):
            for parameter in group.table:
                if parameter.unit:
                    self.assertIn(f"({parameter.unit})", group.bl_rna.properties[parameter.name].description, parameter.name)
        lengths = ("spacing", "viscosity", "tension", "velocity"), ("voxel", "dermis", "damping"), ("young", "density", "strength")
        own = (field.relievo.fluid, bpy.context.scene.collection.relievo_tissue, field.relievo_tissue)
        for group, names in zip(own, lengths):
            for name in names:
                self.assertRegex(group.bl_rna.properties[name].description, r"\b(metres|m²/s|N/m|m/s|1/s|Pa|kg/m³)", name)

    def test_every_system_has_its_panel(self):
        field = host.field()
        field.relievo.fluid.role, field.relievo.fluid.place = "DOMAIN", "SERVER"
        field.relievo_tissue.role = "VOLUME"
        rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
        bpy.context.scene.collection.objects.link(rig)
        systems = {"fluid": "fluid_simulate", "foam": "foam_bake", "server": "server_check", "tissue": "tissue_bake"}
        systems |= {"decal": "decal_apply", "levels": "levels_build", "repair": "repair", "imprint": "imprint", "crowd": "crowd_build"}
        for name, operator in systems.items():
            host.select(rig if name == "crowd" else field)
            panel = getattr(bpy.types, f"RELIEVO_PT_{name}")
            self.assertTrue(panel.poll(bpy.context), name)
            layout = Recorder()
            if name == "decal":
                panel.draw(SimpleNamespace(layout=layout), bpy.context)
            else:
                layout = drawn(panel)
            self.assertIn(f"relievo.{operator}", layout.operators)

    def test_the_redo_panel_has_no_json(self):
        for name in operators():
            for found in operator_of(name).properties:
                if "JSON" in found.description:
                    self.assertTrue(found.is_hidden, (name, found.identifier))

    def test_advanced_settings_are_folded(self):
        """What a panel shows unfolded is short, and all settings of a table are in some panel."""
        field = host.field()
        host.select(field)
        field.relievo.fluid.role = "DOMAIN"
        shown = {}
        for kind in ours("PT"):
            if kind.bl_space_type == "VIEW_3D" and kind.poll(bpy.context):
                names = [(type(group).__name__, name) for group, name in drawn(kind).properties]
                shown.setdefault("all", set()).update(names)
                if "DEFAULT_CLOSED" not in getattr(kind, "bl_options", ()):
                    self.assertLessEqual(len(names), 14, kind.__name__)
        scene = bpy.context.scene.relievo
        groups = (scene.brush.settings, scene.brush.stamp_settings, scene.imprint, scene.repair, field.relievo_foam.settings)
        for group in groups:
            names = {(type(group).__name__, parameter.name) for parameter in group.table}
            self.assertEqual(names - shown["all"], set())


class Presets(Case):
    def test_presets_set_what_they_say_and_no_lengths(self):
        from relievo.ui import preset

        field = host.field()
        host.select(field)
        for kind, presets in preset.GIVEN.items():
            if kind == "fluid":
                self.assertFalse(bpy.ops.relievo.preset_fluid.poll())
                field.relievo.fluid.role = "DOMAIN"
            group = preset.group_of(bpy.context, kind)
            for name, values in presets.items():
                getattr(bpy.ops.relievo, f"preset_{kind}")(preset=name.upper().replace(" ", "_"))
                for path, value in values.items():
                    found = group
                    for part in path.split("."):
                        found = getattr(found, part)
                    if isinstance(value, float):
                        self.assertAlmostEqual(found, value, delta=1e-6 * abs(value), msg=f"{name} {path}")
                    else:
                        self.assertEqual(found, value, f"{name} {path}")
        self.assertFalse(bpy.context.scene.relievo.brush.settings.is_property_set("radius"))

    def test_brushes_of_presets_are_round(self):
        """Paint with a hard border stays in the circle that the tool shows."""
        field = host.field(16)
        host.select(field)
        bpy.ops.relievo.preset_brush(preset="HARD_PAINT")
        host.draw(field, [[0.02, 0.01, 0.0]], action="PAINT", radius=0.3, color=(1, 0, 0, 1))
        far = numpy.linalg.norm(host.positions(field.relievo.result)[:, :2] - (0.02, 0.01), axis=1)
        red = host_colors(field)[:, 1] < 0.4
        self.assertLess(far[red].max(), 0.31)
        self.assertGreater(far[~red].min(), 0.2)

    def test_sand_rises_around_a_print_and_snow_hardly(self):
        highest = {}
        for name in ("SNOW", "SAND"):
            self.setUp()
            field, ball = host.field(), host.ball(0.3)
            ball.location = (0, 0, 0.15)
            bpy.context.view_layer.update()
            bpy.context.scene.relievo.imprint.voxels = 2**18
            bpy.ops.relievo.preset_imprint(preset=name)
            bpy.context.scene.relievo.imprint.rim_width = 0.3
            host.select(field, ball)
            bpy.ops.relievo.imprint(frame_start=1, frame_end=1)
            heights = host.positions(field.relievo.result)[:, 2]
            self.assertLess(heights.min(), -0.08)
            highest[name] = float(heights.max())
        self.assertGreater(highest["SAND"], 3 * max(highest["SNOW"], 1e-3))

    def test_presets_of_users_are_saved_and_read(self):
        with host.folder() as folder:
            original = bpy.utils.user_resource
            import os

            bpy.utils.user_resource = lambda _kind, path="", create=False: os.path.join(folder, path)
            try:
                host.select(host.field())
                group = bpy.context.scene.relievo.brush
                group.settings.strength, group.sculpt_mode = 0.25, "CLAY"
                saved = next(kind for kind in ours("OT") if kind.__name__ == "RELIEVO_OT_preset_save_brush")
                made = type("Saving", (), {"kind": "brush", "preset_subdir": saved.preset_subdir})()
                values = type(saved).preset_values if hasattr(type(saved), "preset_values") else saved.preset_values
                lines = values.fget(made)
                self.assertIn("group.settings.strength", lines)
                self.assertIn("group.sculpt_mode", lines)
                self.assertNotIn("group.settings.radius", lines)
                self.assertEqual(saved.preset_defines.fget(made), ["group = bpy.context.scene.relievo.brush"])
            finally:
                bpy.utils.user_resource = original


class Brush(Case):
    def test_ctrl_sinks_and_shift_smooths(self):
        field = host.field()
        line = [[-0.5, 0.25, 0], [0.5, 0.25, 0]]
        host.draw(field, line, radius=0.3, height=0.1)
        raised = host.positions(field.relievo.result)[:, 2]
        import json

        points = json.dumps(line)
        bpy.ops.relievo.stroke(action="SCULPT", effect="SMOOTH", points=points)
        smooth = host.positions(field.relievo.result)[:, 2]
        self.assertLess(smooth.max(), raised.max() - 1e-4)
        self.assertGreater(smooth.max(), 0.5 * raised.max())
        bpy.ops.relievo.stroke(action="SCULPT", effect="INVERT", points=points)
        sunk = host.positions(field.relievo.result)[:, 2]
        self.assertAlmostEqual(float((smooth - sunk).max()), 0.1, delta=5e-3)
        # Ctrl of the paint tool takes paint away.
        host.draw(field, line, "PAINT", color=(1, 0, 0, 1), falloff="CONSTANT")
        paint = lambda: host_colors(field)[:, 1].min()
        self.assertLess(paint(), 0.1)
        bpy.ops.relievo.stroke(action="PAINT", effect="INVERT", points=points)
        self.assertGreater(paint(), 0.7)
        # Strokes are kept as they were made.
        kept = [json.loads(one.text)["options"] for one in field.relievo.strokes]
        self.assertEqual([one["mode"] for one in kept], ["layer", "smooth", "layer", "mix", "erase"])
        self.assertLess(kept[2]["height"], 0)

    def test_the_circle_lies_on_the_surface(self):
        from relievo.tools import ring

        normal = numpy.array([0.6, 0.0, 0.8])
        points = ring.circle(numpy.array([1.0, 2.0, 3.0]), normal, 0.5)
        away = points - [1.0, 2.0, 3.0]
        numpy.testing.assert_allclose(numpy.linalg.norm(away, axis=1), 0.5, atol=1e-12)
        numpy.testing.assert_allclose(away @ normal, 0, atol=1e-12)


class Pressing(Case):
    """Who presses is kept in the file; imprints say what they did and are made again."""

    def pressed(self):
        field, ball = host.field(), host.ball(0.3)
        ball.location = (-0.5, 0.25, 0.2)
        bpy.context.view_layer.update()
        bpy.context.scene.relievo.imprint.voxels = 2**18
        host.select(field, ball)
        bpy.ops.relievo.press_add()
        host.select(field)
        return field, ball

    def imprint(self, **options):
        options = {"frame_start": 1, "frame_end": 1, **options}
        return bpy.ops.relievo.imprint(**options)

    def test_the_list_presses_without_a_selection_and_is_kept(self):
        field, ball = self.pressed()
        other = host.ball(0.3, "other")
        other.location = (0.5, 0.25, 0.2)
        bpy.context.view_layer.update()
        # What is selected beside the list does not press.
        host.select(field, other)
        self.imprint()
        row = lambda: host.positions(field.relievo.result)
        near = lambda x: float(row()[numpy.abs(row()[:, 0] - x) < 0.1, 2].min())
        self.assertAlmostEqual(near(-0.5), -0.1, delta=0.015)
        self.assertGreater(near(0.5), -0.01)
        self.assertRegex(field.relievo_press.report, r"^\d+ tiles, deepest 0\.\d+$")
        with host.folder() as folder:
            path = f"{folder}/list.blend"
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
            field = bpy.data.objects["field"]
            self.assertEqual([entry.target.name for entry in field.relievo_press.pressers], ["ball"])
            # An entry that is off does not press; the collection does.
            collection = bpy.data.collections.new("Balls")
            bpy.context.scene.collection.children.link(collection)
            collection.objects.link(bpy.data.objects["other"])
            field.relievo_press.pressers[0].is_on, field.relievo_press.collection = False, collection
            host.select(field)
            self.imprint()
            self.assertAlmostEqual(near(0.5), -0.1, delta=0.015)
            field.relievo_press.collection = None
            with self.assertRaisesRegex(RuntimeError, "Nothing in the list of field presses"):
                self.imprint()

    def test_the_panel_says_what_was_done_and_what_a_frame_shows(self):
        field, _ball = self.pressed()
        self.imprint()
        self.assertRegex(field.relievo_press.report, r"^\d+ tiles, deepest 0\.09\d*$")
        texts = lambda: " ".join(filter(None, drawn(bpy.types.RELIEVO_PT_imprint).texts))
        self.assertIn(field.relievo_press.report, texts())
        self.assertNotIn("Shows frame", texts())
        bpy.context.scene.frame_set(7)
        self.assertIn("Shows frame 1: without a cache, all do", texts())

    def test_a_presser_may_have_settings_of_its_own(self):
        field, ball = self.pressed()
        entry = field.relievo_press.pressers[0]
        entry.has_own, entry.settings.voxels, entry.settings.max_displacement = True, 2**18, 0.04
        self.imprint()
        self.assertAlmostEqual(float(host.positions(field.relievo.result)[:, 2].min()), -0.04, delta=0.01)

    def test_what_touches_nothing_is_warned_of(self):
        from relievo.ops import imprint

        field, ball = self.pressed()
        ball.location.z = 5
        bpy.context.view_layer.update()
        options = {"frame_start": 1, "frame_end": 1, "cache": False, "images": False, "image_size": 64}
        steps = host.operator(imprint.RELIEVO_OT_imprint, **options)
        told = steps.gi_frame.f_locals["self"].told
        self.relievo.core.job.run(steps)
        self.assertEqual(len(told), 1)
        self.assertIn("ball touched field nowhere in frames 1 to 1", told[0])
        self.assertFalse(field.relievo_press.is_there)

    def test_an_imprint_is_made_again_from_its_start(self):
        field, ball = self.pressed()
        host.draw(field, [[-0.5, -0.5, 0], [0.5, -0.5, 0]], radius=0.2, height=0.1)
        start = host.positions(field.relievo.result)
        self.assertFalse(bpy.ops.relievo.imprint_again.poll())
        self.imprint()
        first = host.positions(field.relievo.result)
        host.draw(field, [[-0.5, -0.5, 0], [0.5, -0.5, 0]])
        ball.location.x = 0.5
        bpy.context.view_layer.update()
        host.select(field)
        bpy.ops.relievo.imprint_again(frame_start=1, frame_end=1)
        again = host.positions(field.relievo.result)
        # The first dent is not there any more, nor the stroke after it; the earlier stroke is.
        at = lambda points, x: float(points[numpy.abs(points[:, :2] - (x, 0.25)).max(1) < 0.1, 2].min())
        self.assertLess(at(first, -0.5), -0.08)
        self.assertGreater(at(again, -0.5), -0.01)
        self.assertLess(at(again, 0.5), -0.08)
        low = again[:, 1] < -0.2
        numpy.testing.assert_allclose(again[low, 2], start[low, 2], atol=1e-6)
        self.assertEqual(len(field.relievo.strokes), 1)
        # Back to before it, to the bit.
        bpy.ops.relievo.imprint_reset()
        numpy.testing.assert_array_equal(host.positions(field.relievo.result), start)
        self.assertFalse(field.relievo_press.is_there)
        self.assertFalse(bpy.ops.relievo.imprint_reset.poll())

    def test_an_imprint_again_that_fails_leaves_what_was(self):
        field, ball = self.pressed()
        self.imprint()
        before, revision = host.positions(field.relievo.result), field.relievo.revision
        from relievo.ops import rebake

        options = {"frame_start": 1, "frame_end": 30, "cache": False, "images": False, "image_size": 64}
        for turns in (3, 9, 14):
            steps = host.operator(rebake.RELIEVO_OT_imprint_again, **options)
            for _ in range(turns):
                next(steps)[2](None)
            steps.close()
            numpy.testing.assert_array_equal(host.positions(field.relievo.result), before)
            self.assertEqual(self.relievo.data.state.of(field).revision, revision)


class Layers(Case):
    def names(self, field):
        return [layer.name for layer in self.relievo.data.state.of(field).detail.layers]

    def test_the_list_renames_hides_and_chooses(self):
        field = host.field()
        host.draw(field, [[-0.5, 0.25, 0], [0.5, 0.25, 0]], radius=0.3, height=0.1)
        bpy.ops.relievo.layer_add(kind="DISPLACEMENT", name="Scratches")
        rows = field.relievo_layers.rows
        self.assertEqual([row.name for row in rows], list(reversed(self.names(field))))
        self.assertEqual(rows[field.relievo_layers.active].name, "Scratches")
        place = [row.name for row in rows].index("Scratches")
        revision = field.relievo.revision
        rows[place].name = "Scars"
        self.assertIn("Scars", self.names(field))
        self.assertNotIn("Scratches", self.names(field))
        self.assertGreater(field.relievo.revision, revision)
        # The layer below has the relief; the eye hides it.
        relief = next(number for number, row in enumerate(rows) if row.kind == "DISPLACEMENT" and number != place)
        rows[relief].is_visible = False
        self.assertLess(host.positions(field.relievo.result)[:, 2].max(), 1e-6)
        rows[relief].is_visible = True
        self.assertGreater(host.positions(field.relievo.result)[:, 2].max(), 0.08)
        # Strokes go to what was chosen.
        field.relievo_layers.active = relief
        active = [layer.name for layer in self.relievo.data.state.of(field).detail.layers if layer.is_active]
        self.assertIn(rows[relief].name, active)
        # Buttons are about the row that was chosen, and move it in both lists.
        bpy.ops.relievo.layer_change(action="UP")
        self.assertEqual([row.name for row in rows], list(reversed(self.names(field))))
        count = len(rows)
        bpy.ops.relievo.layer_change(action="REMOVE")
        self.assertEqual(len(rows), count - 1)
        self.assertEqual([row.name for row in rows], list(reversed(self.names(field))))

    def test_files_from_before_the_list_get_one(self):
        field = host.field()
        host.draw(field, [[-0.5, 0.25, 0], [0.5, 0.25, 0]], radius=0.3, height=0.1)
        names = [row.name for row in field.relievo_layers.rows]
        field.relievo_layers.rows.clear()
        with host.folder() as folder:
            path = f"{folder}/old.blend"
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
        field = bpy.data.objects["field"]
        self.assertEqual([row.name for row in field.relievo_layers.rows], names)
        field.relievo_layers.rows[0].name = "First"
        self.assertIn("First", self.names(field))


def host_colors(field):
    data = field.relievo.result.data
    found = numpy.empty((len(data.vertices), 4), numpy.float32)
    data.attributes["Relievo"].data.foreach_get("color", found.ravel())
    return found


class Work(Case):
    def test_the_view_turns_while_something_is_at_work(self):
        from types import SimpleNamespace

        from relievo.core import job

        at_work = SimpleNamespace(work=SimpleNamespace(is_cancelled=False))
        event = lambda kind: SimpleNamespace(type=kind, value="PRESS")
        for kind, answer in (("MIDDLEMOUSE", "PASS_THROUGH"), ("WHEELUPMOUSE", "PASS_THROUGH"), ("X", "RUNNING_MODAL")):
            self.assertEqual(job.Steps.modal(at_work, bpy.context, event(kind)), {answer})
        self.assertFalse(at_work.work.is_cancelled)

    def test_a_compacted_history_is_short_and_undo_brings_it_back(self):
        bpy.context.preferences.edit.undo_steps = 32
        field = host.field()
        for y in (-0.5, 0.0, 0.5):
            host.draw(field, [[-0.5, y, 0], [0.5, y, 0]], radius=0.2)
        before, shown = host.digest(self.relievo, field), host.positions(field.relievo.result)
        bpy.ops.ed.undo_push(message="strokes")
        size = lambda: len(self.relievo.data.state.of(field).data().data)
        whole, uid = size(), field.relievo.uid
        host.select(field)
        self.assertEqual(bpy.ops.relievo.compact(), {"FINISHED"})
        self.assertLess(size(), 0.8 * whole)
        self.assertEqual(self.relievo.data.state.of(field).document.info.undo_count, 0)
        self.assertEqual(host.digest(self.relievo, field), before)
        numpy.testing.assert_array_equal(host.positions(field.relievo.result), shown)
        bpy.ops.ed.undo_push(message="compact")
        host.draw(field, [[0, -0.5, 0], [0, 0.5, 0]], radius=0.2)
        bpy.ops.ed.undo_push(message="stroke")
        for _ in range(2):
            bpy.ops.ed.undo()
        field = bpy.data.objects["field"]
        self.assertEqual(field.relievo.uid, uid)
        self.assertEqual(host.digest(self.relievo, field), before)
        self.assertEqual(self.relievo.data.state.of(field).document.info.undo_count, 3)


class Tools(Case):
    def test_tools_have_icons_of_their_own_that_are_there(self):
        from relievo.tools import brush, carve, grip, pin_tool

        tools = [brush.PaintTool, brush.SculptTool, grip.HandleTool, carve.LevelSculptTool, pin_tool.PinTool]
        folder = Path(bpy.utils.system_resource("DATAFILES", path="icons"))
        for tool in tools:
            self.assertTrue((folder / f"{tool.bl_icon}.dat").exists(), tool.bl_icon)
            for name, _event, properties in tool.bl_keymap:
                found = operator_of(name).properties
                for key, _value in properties["properties"]:
                    self.assertIn(key, found, name)
        self.assertEqual(len({tool.bl_icon for tool in tools}), len(tools))


class Added(Case):
    def test_objects_for_fluids_make_a_simulation(self):
        for role in ("DOMAIN", "FILL"):
            bpy.ops.relievo.fluid_add(role=role, size=1.0)
        bpy.ops.relievo.fluid_add(role="EMITTER", size=1.0)
        found = {one.relievo.fluid.role: one for one in bpy.data.objects}
        self.assertEqual(set(found), {"DOMAIN", "FILL", "EMITTER"})
        domain, fill = found["DOMAIN"], found["FILL"]
        corners = lambda one: numpy.array([vertex.co for vertex in one.data.vertices])
        for one in (fill, found["EMITTER"]):
            self.assertTrue((corners(one).min(0) > corners(domain).min(0)).all())
            self.assertTrue((corners(one).max(0) < corners(domain).max(0)).all())
        # Its faces look outwards, so that it is a volume.
        import bmesh

        made = bmesh.new()
        made.from_mesh(fill.data)
        self.assertGreater(made.calc_volume(signed=True), 0)
        made.free()


class Manual(Case):
    def test_the_page_has_a_part_for_every_operator(self):
        from relievo.ui import manual

        text = manual.SOURCE.read_text(encoding="utf-8")
        page = manual.page(text)
        anchors = set(re.findall(r'id="([^"]+)"', page))
        for pattern, part in manual.PARTS:
            self.assertIn(part, anchors, pattern)
        for name in operators():
            whole = f"bpy.ops.{name}"
            self.assertTrue(any(re.match(pattern.replace("*", ".*"), whole) for pattern, _part in manual.PARTS), name)
        # Code stays as it is, and every picture is there.
        self.assertIn("bpy.ops.relievo.imprint(cache=True, images=True, image_size=2048)", page)
        pictures = re.findall(r'src="([^"]+)"', page)
        self.assertGreater(len(pictures), 2)
        for picture in pictures:
            self.assertTrue((manual.SOURCE.parent / picture).exists(), picture)
        # Each system has a picture.
        for part in re.split(r"(?m)^## ", text)[1:]:
            if not part.startswith("Files"):
                self.assertIn("](images/", part, part[:20])
        layout = Recorder()
        preferences = bpy.context.preferences.addons["relievo"].preferences
        type(preferences).draw(SimpleNamespace(layout=layout), bpy.context)
        self.assertLessEqual({"relievo.manual", "relievo.report"}, set(layout.operators))
        self.assertEqual(bpy.ops.relievo.manual(), {"FINISHED"})
        address, parts = manual.places()
        self.assertTrue(address.startswith("file:///") and address.endswith(".html#"), address)
        self.assertEqual(parts, tuple(manual.PARTS))

    def test_a_report_says_the_versions(self):
        self.assertEqual(bpy.ops.relievo.report(), {"FINISHED"})
        said = bpy.data.texts["Relievo report"].as_string()
        self.assertIn(f"Blender {bpy.app.version_string}", said)
        self.assertRegex(said, r"Relievo \d+\.\d+\.\d+")


if __name__ == "__main__":
    host.main()
