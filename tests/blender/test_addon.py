"""The add-on in Blender, without a window: what operators make, what undo brings back, what files keep."""

import ast
import json
import os
import random
import shutil
import subprocess
import sys
import threading
import unittest
from pathlib import Path

import bpy
import mathutils
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host


class Case(unittest.TestCase):
    def setUp(self):
        self.relievo = host.empty()


class Modules(Case):
    def test_modules_import_each_other_in_no_circle(self):
        """Imports inside functions count: they are how circles hide."""
        folder = Path(self.relievo.__file__).parent
        names = {path.stem for path in folder.glob("*.py")}
        imports = {}
        for name in names:
            found = set()
            for node in ast.walk(ast.parse((folder / f"{name}.py").read_text())):
                if isinstance(node, ast.ImportFrom) and node.level == 1:
                    found |= {node.module.split(".")[0]} if node.module else {alias.name for alias in node.names}
            imports[name] = (found & names) - {name}
        # Modules without imports of the rest are taken away until none is left.
        while done := {name for name, found in imports.items() if not found}:
            imports = {name: found - done for name, found in imports.items() if name not in done}
        self.assertEqual(imports, {})


class Strokes(Case):
    def test_a_stroke_raises_the_result_and_paint_colours_it(self):
        field = host.field()
        self.assertEqual(host.draw(field, [[-0.5, 0.25, 0], [0.5, 0.25, 0]], radius=0.3, height=0.2), {"FINISHED"})
        result = field.relievo.result
        self.assertEqual(result.parent, field)
        heights = host.positions(result)[:, 2]
        self.assertGreater(heights.max(), 0.15)
        self.assertEqual(len(heights), (4 * 16 + 1) ** 2)
        host.draw(field, [[-0.5, -0.25, 0], [0.5, -0.25, 0]], "PAINT", color=(1, 0, 0, 1))
        colors = numpy.empty((len(heights), 4), numpy.float32)
        result.data.attributes["Relievo"].data.foreach_get("color", colors.ravel())
        numpy.testing.assert_allclose(colors.min(0)[1:3], 0, atol=0.05)
        self.assertEqual(len(field.relievo.strokes), 2)
        self.assertEqual(len(json.loads(field.relievo.strokes[0].text)["points"]), 2)

    def test_a_stroke_raises_its_height_at_most(self):
        field, group = host.field(), bpy.context.scene.relievo.brush
        self.assertEqual((group.sculpt_mode, group.accumulate), ("DRAW", False))
        there_and_back = [[-0.5, 0.25, 0], [0.5, 0.25, 0], [-0.5, 0.25, 0]]
        # Every stroke raises once more. Its ridge is straight, without a trace of the dabs.
        for number in (1, 2):
            host.draw(field, there_and_back, radius=0.3, height=0.1)
            points = host.positions(field.relievo.result)
            self.assertAlmostEqual(float(points[:, 2].max()), 0.1 * number, delta=4e-3)
            ridge = points[(abs(points[:, 0]) < 0.4) & (abs(points[:, 1] - 0.25) < 1e-3), 2]
            self.assertGreater(float(ridge.min()), 0.98 * float(ridge.max()))
        other = host.field(name="other")
        host.draw(other, there_and_back, radius=0.3, height=-0.1)
        self.assertAlmostEqual(float(host.positions(other.relievo.result)[:, 2].min()), -0.1, delta=2e-3)
        host.draw(field, there_and_back, radius=0.3, height=0.1, accumulate=True)
        self.assertGreater(float(host.positions(field.relievo.result)[:, 2].max()), 0.5)

    def test_symmetry_and_pressure(self):
        field = host.field()
        field.relievo.cells = "32"
        host.draw(field, [[0.5, 0.2, 0, 1.0], [0.5, 0.3, 0, 0.5]], radius=0.2, symmetry_x=True)
        points = host.positions(field.relievo.result)
        left, right = points[points[:, 0] < -0.01], points[points[:, 0] > 0.01]
        self.assertGreater(left[:, 2].max(), 0.05)
        self.assertAlmostEqual(float(left[:, 2].max()), float(right[:, 2].max()), delta=2e-3)

    def test_triangles_and_the_active_result(self):
        ball = host.ball(1.0)
        ball.relievo.kind = "TRIANGLES"
        host.draw(ball, [[0, -1, 0], [0.3, -0.95, 0]], radius=0.2)
        result = ball.relievo.result
        self.assertGreater(numpy.linalg.norm(host.positions(result), axis=1).max(), 1.05)
        before = host.digest(self.relievo, ball)
        host.draw(result, [[0, 1, 0], [0.3, 0.95, 0]], radius=0.2)
        self.assertNotEqual(host.digest(self.relievo, ball), before)

    def test_what_cannot_be_done_is_said(self):
        field = host.field()
        for points in ("nonsense", "[]", "[[1]]", '[[0, 0, 0, 7]]', '[["a", 0, 0]]', "[[NaN, 0, 0]]"):
            host.select(field)
            with self.assertRaises(RuntimeError) as caught:
                bpy.ops.relievo.stroke(action="SCULPT", points=points)
            self.assertNotIn("Traceback", str(caught.exception))
        self.assertEqual(len(field.relievo.strokes), 0)
        host.draw(field, [[0, 0, 0], [0.1, 0, 0]])
        field.data.from_pydata([], [], [])
        other = bpy.data.meshes.new("other")
        other.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
        field.data = other
        with self.assertRaisesRegex(RuntimeError, "other faces"):
            host.draw(field, [[0, 0, 0], [0.1, 0, 0]])


class Carried(Case):
    """What a cage has reaches its result: slots and faces of materials, texture coordinates, colours, vertex groups."""

    def dressed(self, kind="CATMULL_CLARK"):
        """A sheet of 16 faces, its right half of another material."""
        field = host.field()
        field.relievo.kind, field.relievo.segments, field.relievo.cells = kind, "8", "2"
        data, points = field.data, host.positions(field)
        second = data.uv_layers.new(name="Lightmap")
        at = points[self.relievo.data.mesh.get_corners(data)]
        second.data.foreach_set("uv", (at[:, :2] / 4 + 0.25).astype(numpy.float32).ravel())
        for name in ("left", "right"):
            data.materials.append(bpy.data.materials.new(name))
        centres = numpy.array([face.center for face in data.polygons])
        data.polygons.foreach_set("material_index", (centres[:, 0] > 0).astype(numpy.int32))
        tint = data.color_attributes.new("Tint", "FLOAT_COLOR", "POINT")
        tint.data.foreach_set("color", numpy.column_stack([points / 2 + 0.5, numpy.ones(len(points))]).ravel())
        group = field.vertex_groups.new(name="Slope")
        for number, point in enumerate(points):
            group.add([number], float(point[0] / 2 + 0.5), "REPLACE")
        return field

    def check(self, field):
        result = field.relievo.result
        data, points = result.data, host.positions(result)
        corners = self.relievo.data.mesh.get_corners(data)
        self.assertEqual([layer.name for layer in data.uv_layers], ["UVMap", "Lightmap"])
        self.assertEqual(data.uv_layers.active.name, field.data.uv_layers.active.name)
        uvs = self.relievo.data.mesh.get_uvs(data, data.uv_layers["Lightmap"])
        flat = self.relievo.data.mesh.get_uvs(data, data.uv_layers["UVMap"])
        # Both maps are straight, so that one tells the place on the other.
        numpy.testing.assert_allclose(uvs, flat / 2, atol=1e-5)
        places = numpy.empty((len(points), 2))
        places[corners] = flat * 2 - 1
        centres = numpy.array([places[face.vertices].mean(0) for face in data.polygons])
        self.assertEqual([face.material_index for face in data.polygons], (centres[:, 0] > 0).astype(int).tolist())
        tint = numpy.empty((len(points), 4), numpy.float32)
        data.color_attributes["Tint"].data.foreach_get("color", tint.ravel())
        numpy.testing.assert_allclose(tint[:, :2], places / 2 + 0.5, atol=1e-5)
        group = result.vertex_groups["Slope"]
        weights = [group.weight(number) if vertex.groups else 0.0 for number, vertex in enumerate(data.vertices)]
        numpy.testing.assert_allclose(weights, places[:, 0] / 2 + 0.5, atol=1e-3)

    def test_a_result_has_what_its_cage_has(self):
        for kind in ("CATMULL_CLARK", "TRIANGLES"):
            field = self.dressed(kind)
            host.draw(field, [[-0.5, 0.25, 0], [0.5, 0.25, 0]], radius=0.3, height=0.2)
            self.check(field)
            # The triangles are made anew.
            field.relievo.cells = "4"
            host.draw(field, [[-0.5, -0.25, 0], [0.5, -0.25, 0]], radius=0.3, height=0.2)
            self.check(field)
            self.setUp()

    def test_materials_that_change_later_reach_the_result(self):
        field = self.dressed()
        host.draw(field, [[-0.5, 0.25, 0], [0.5, 0.25, 0]])
        result = field.relievo.result
        self.assertEqual([slot.name for slot in result.material_slots], ["left", "right"])
        other = bpy.data.materials.new("other")
        field.data.materials[0] = other
        field.data.materials.append(bpy.data.materials.new("third"))
        field.data.polygons.foreach_set("material_index", [2] * 16)
        field.data.update()
        bpy.context.view_layer.update()
        self.assertEqual([slot.name for slot in result.material_slots], ["other", "right", "third"])
        self.assertEqual({face.material_index for face in result.data.polygons}, {2})
        # What was assigned to the result stays until the object has others.
        result.data.materials[1] = other
        bpy.context.view_layer.update()
        host.draw(field, [[-0.5, -0.25, 0], [0.5, -0.25, 0]])
        self.assertEqual([slot.name for slot in result.material_slots], ["other", "other", "third"])

    def test_paint_is_in_the_materials_that_can_show_it(self):
        field = self.dressed()
        left, right = field.data.materials
        for made in (left, right):
            made.use_nodes = True
        surface = right.node_tree.nodes["Principled BSDF"]
        surface.inputs["Base Color"].default_value = (0, 0, 1, 1)
        host.draw(field, [[-0.5, 0.25, 0], [0.5, 0.25, 0]])
        self.assertNotIn("Relievo paint", left.node_tree.nodes)
        from relievo.tools import brush

        points = json.dumps([[-0.5, 0.25, 0], [0.5, 0.25, 0]])
        host.select(field)
        steps = host.operator(brush.RELIEVO_OT_stroke, action="PAINT", points=points)
        told = steps.gi_frame.f_locals["self"].told
        self.relievo.core.job.run(steps)
        self.assertEqual(len(told), 1)
        self.assertIn("Paint is not seen in right, whose base colour", told[0])
        self.assertIn("Relievo paint", left.node_tree.nodes)
        self.assertEqual(len(right.node_tree.nodes), 2)
        self.assertEqual(field.relievo.result.data.color_attributes.active_color.name, "Relievo")

    def test_modifiers_that_make_faces_are_refused(self):
        for kind in ("MIRROR", "ARRAY"):
            field = host.field(name=kind)
            modifier = field.modifiers.new("Half", kind)
            with self.assertRaisesRegex(RuntimeError, "modifier Half, whose faces would vanish: apply it"):
                host.draw(field, [[0, 0, 0], [0.1, 0, 0]])
            self.assertEqual((field.relievo.uid, field.relievo.result, field.hide_render), ("", None, False))
            host.select(field)
            bpy.ops.object.modifier_apply(modifier=modifier.name)
            self.assertEqual(host.draw(field, [[0, 0, 0], [0.1, 0, 0]]), {"FINISHED"})
            self.assertGreater(len(field.data.polygons), 16)


class VisibleResults(Case):
    """What is seen is moved, copied and deleted like any object."""

    def stroked(self):
        field = host.field()
        field.relievo.cells = "8"
        host.draw(field, [[-0.5, 0.25, 0], [0.5, 0.25, 0]], radius=0.2)
        return field, field.relievo.result

    def test_a_moved_result_takes_its_object_along(self):
        field, result = self.stroked()
        result.location, result.rotation_euler.z = (3, 0, 1), 0.5
        bpy.context.view_layer.update()
        place = numpy.array(result.matrix_world)
        at = place @ [[-0.3, 0.3], [-0.5, -0.5], [0, 0], [1, 1]]
        before = host.positions(result)
        self.assertEqual(host.draw(result, at[:3].T.tolist(), radius=0.2), {"FINISHED"})
        bpy.context.view_layer.update()
        for one in (field, result):
            numpy.testing.assert_allclose(numpy.array(one.matrix_world), place, atol=1e-6)
        raised = host.positions(result)[:, 2] - before[:, 2]
        self.assertAlmostEqual(float(raised.max()), 0.1, delta=5e-3)
        self.assertLess(numpy.abs(before[raised.argmax(), :2] - (0, -0.5)).max(), 0.35)
        # An animated object goes back to its place, so that it is the user's to choose.
        field.keyframe_insert("location", frame=1)
        result.location.x += 1
        bpy.context.view_layer.update()
        with self.assertRaisesRegex(RuntimeError, "field Relievo was moved away from field, which is animated"):
            host.draw(result, [[0, 0, 0], [0.1, 0, 0]])

    def test_a_copy_of_a_result_is_an_object_of_its_own(self):
        field, result = self.stroked()
        host.select(result)
        bpy.ops.object.duplicate()
        copy = bpy.context.active_object
        copy.location.x += 3
        bpy.context.view_layer.update()
        before = self.relievo.data.state.of(field).detail.info.revision
        copy.relievo.kind, copy.relievo.segments = "TRIANGLES", "8"
        host.draw(copy, [[2.5, -0.25, 0], [3.5, -0.25, 0]], radius=0.2)
        self.assertEqual(self.relievo.data.state.of(field).detail.info.revision, before)
        self.assertNotIn(copy.relievo.result, (None, result))
        self.assertEqual(len(copy.relievo.strokes), 1)

    def test_an_object_whose_result_is_deleted_is_seen(self):
        field, result = self.stroked()
        self.assertEqual((field.display_type, field.hide_render), ("BOUNDS", True))
        host.select(result)
        bpy.ops.object.delete()
        bpy.context.view_layer.update()
        self.assertEqual((field.display_type, field.hide_render), ("TEXTURED", False))
        host.draw(field, [[-0.5, -0.25, 0], [0.5, -0.25, 0]], radius=0.2)
        result = field.relievo.result
        self.assertEqual((field.display_type, field.hide_render), ("BOUNDS", True))
        # Both strokes are there.
        points = host.positions(result)
        self.assertGreater(points[points[:, 1] > 0, 2].max(), 0.08)
        self.assertGreater(points[points[:, 1] < 0, 2].max(), 0.08)


class Lengths(Case):
    """Defaults follow the size of the object; what was set stays; what is clipped is said."""

    def scaled(self, size):
        field = host.field()
        field.data.transform(mathutils.Matrix.Scale(size / 2, 4))
        bpy.context.view_layer.update()
        return field

    def test_defaults_follow_the_object(self):
        field, scene = self.scaled(4000), bpy.context.scene.relievo
        host.draw(field, [[-500, 500, 0], [500, 500, 0]])
        self.assertEqual([scene.brush.settings.radius, scene.brush.height], [200, 200])
        self.assertGreater(host.positions(field.relievo.result)[:, 2].max(), 150)
        self.assertEqual([scene.imprint.max_displacement, scene.handle.radius], [2000, 1000])
        small = host.field(name="small")
        host.draw(small, [[-0.5, 0.5, 0], [0.5, 0.5, 0]])
        self.assertEqual(round(scene.brush.settings.radius, 6), 0.1)
        # In the world it is 4 long, in its own space 2.
        large = host.field(name="large")
        large.scale = (2, 2, 2)
        bpy.context.view_layer.update()
        host.draw(large, [[-0.5, 0.5, 0], [0.5, 0.5, 0]])
        self.assertEqual([round(scene.brush.settings.radius, 6), round(scene.brush.height, 6)], [0.2, 0.1])

    def test_lengths_that_were_set_stay(self):
        field, scene = self.scaled(40), bpy.context.scene.relievo
        host.draw(field, [[-5, 5, 0], [5, 5, 0]], radius=0.1, height=0.5)
        self.assertEqual([round(scene.brush.settings.radius, 6), scene.brush.height], [0.1, 0.5])
        self.assertEqual(scene.handle.radius, 10)
        scene.handle.radius = 3
        host.draw(host.field(name="small"), [[-0.5, 0.5, 0], [0.5, 0.5, 0]])
        self.assertEqual([round(scene.brush.settings.radius, 6), scene.brush.height, scene.handle.radius], [0.1, 0.5, 3])

    def test_a_clipped_dent_is_said(self):
        from relievo.ops import imprint

        field, scene = self.scaled(4000), bpy.context.scene
        scene.frame_end, scene.relievo.imprint.voxels = 1, 2**16
        ball = host.ball(300)
        ball.location = (0, 500, 200)
        for limit, wanted in ((1, 1), (2000, 100)):
            if limit == 1:
                scene.relievo.imprint.max_displacement = limit
            else:
                scene.relievo.imprint.property_unset("max_displacement")
            host.select(field, ball)
            made = host.operator(imprint.RELIEVO_OT_imprint, frame_start=-1, frame_end=-1, cache=False, images=False, image_size=64)
            told = made.gi_frame.f_locals["self"].told
            self.relievo.core.job.run(made)
            self.assertAlmostEqual(-float(host.positions(field.relievo.result)[:, 2].min()), wanted, delta=0.05 * wanted)
            self.assertEqual(any("clipped" in text for text in told), limit == 1)

    def test_failures_do_not_name_functions(self):
        with self.assertRaises(RuntimeError) as caught:
            host.draw(host.field(), [[0, 0, 0, 7]])
        self.assertIn("the pressure of point 0 is 7; use 0 to 1", str(caught.exception))
        self.assertNotIn("rlv_", str(caught.exception))


class Undo(Case):
    def edit(self, chance, target, ball):
        """Something at random by an operator; says whether anything was done."""
        x, y = chance.uniform(-0.8, 0.8) + target.location.x, chance.uniform(-0.8, 0.8)
        host.select(target)
        layers = list(self.relievo.data.state.of(target).detail.layers)
        layer, choice = chance.choice(layers), chance.random()
        try:
            if choice < 0.1:
                bpy.ops.relievo.layer_add(name="Layer", kind=chance.choice(["DISPLACEMENT", "COLOR"]))
            elif choice < 0.2:
                actions = ["ACTIVATE", "REMOVE", "UP", "DOWN", "MERGE"]
                bpy.ops.relievo.layer_change(layer=layer.id, action=chance.choice(actions))
            elif choice < 0.3:
                bpy.ops.relievo.layer_set(layer=layer.id, opacity=chance.uniform(0.2, 1), visible=chance.random() < 0.8)
            elif choice < 0.4:
                ball.location = (x, y, 0.2)
                bpy.context.view_layer.update()
                host.select(target, ball)
                bpy.ops.relievo.imprint(frame_start=1, frame_end=1)
            elif choice < 0.45:
                bpy.ops.relievo.result_color()
            elif choice < 0.5:
                bpy.ops.relievo.result_mesh()
            else:
                mode = {"sculpt_mode": chance.choice(["DRAW", "SMOOTH", "PINCH", "ERASE"])}
                host.draw(target, [[x, y, 0], [x + 0.1, y, 0]], chance.choice(["SCULPT", "PAINT"]), radius=0.25, **mode)
        except RuntimeError:
            # What cannot be done, such as removing the only layer, is said, and is no step.
            return False
        return True

    def test_two_hundred_random_steps(self):
        """Strokes, imprints, layers and results on two objects, undone and made again at random: the details, their
        layers and what was written to the mesh are always what they were at that step."""
        bpy.context.preferences.edit.undo_steps = 256
        bpy.context.scene.relievo.imprint.voxels = 2**14
        fields = [host.field(name="a"), host.field(name="b")]
        for field in fields:
            field.relievo.tile_size = "16"
        fields[1].location.x = 4
        host.ball(0.3, rings=8)
        chance = random.Random(7)
        bpy.ops.ed.undo_push(message="start")

        def objects():
            return [bpy.data.objects["a"], bpy.data.objects["b"]]

        def states():
            found = []
            for target in objects():
                layers = [layer._replace(is_active=0) for layer in self.relievo.data.state.of(target).detail.layers]
                colors = target.data.attributes.get("Relievo colour")
                values = numpy.empty((len(target.data.loops), 4), numpy.float32)
                if colors is not None:
                    colors.data.foreach_get("color", values.ravel())
                layers = [(layer.name, layer.kind, layer.blend, layer.opacity, layer.is_visible) for layer in layers]
                found.append((host.digest(self.relievo, target), layers, colors is not None and values.tobytes()))
            return found

        steps, place = [states()], 0
        bpy.ops.ed.undo_push(message="states")
        edits = undone = redone = refused = 0
        while edits + undone + redone < 200:
            choice = chance.random()
            if choice < 0.4 and place > 0:
                bpy.ops.ed.undo()
                place, undone = place - 1, undone + 1
            elif choice < 0.75 and place + 1 < len(steps):
                bpy.ops.ed.redo()
                place, redone = place + 1, redone + 1
            elif self.edit(chance, chance.choice(objects()), bpy.data.objects["ball"]):
                bpy.ops.ed.undo_push(message="edit")
                place, edits = place + 1, edits + 1
                steps[place:] = [states()]
            else:
                refused += 1
            self.assertEqual(states(), steps[place])
        self.assertGreater(min(edits, undone, redone), 20)
        self.assertLess(refused, 40)


class Documents(Case):
    def test_duplicates_get_their_own(self):
        field = host.field()
        host.draw(field, [[0, 0, 0], [0.2, 0, 0]])
        copy = field.copy()
        bpy.context.scene.collection.objects.link(copy)
        self.assertEqual(copy.relievo.uid, field.relievo.uid)
        before = host.digest(self.relievo, field)
        self.assertEqual(host.digest(self.relievo, copy), before)
        self.assertNotEqual(copy.relievo.uid, field.relievo.uid)
        host.draw(copy, [[0.5, 0.5, 0], [0.7, 0.5, 0]])
        self.assertEqual(host.digest(self.relievo, field), before)
        self.assertNotEqual(host.digest(self.relievo, copy), before)

    def test_files_keep_documents_strokes_and_history(self):
        with host.folder() as folder:
            path = os.path.join(folder, "scene.blend")
            field = host.field()
            host.draw(field, [[0, 0, 0], [0.2, 0, 0]])
            host.draw(field, [[0, 0.5, 0], [0.2, 0.5, 0]], "PAINT")
            before = host.digest(self.relievo, field)
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.read_factory_settings(use_empty=True)
            self.relievo = host.enable()
            bpy.ops.wm.open_mainfile(filepath=path)
            field = bpy.data.objects["field"]
            self.assertEqual(host.digest(self.relievo, field), before)
            self.assertEqual(len(field.relievo.strokes), 2)
            self.assertEqual(self.relievo.data.state.of(field).document.info.undo_count, 2)
            # An object that is appended beside it gets a document of its own.
            other_path = shutil.copy(path, os.path.join(folder, "other.blend"))
            with bpy.data.libraries.load(other_path) as (_there, wanted):
                wanted.objects = ["field"]
            other = wanted.objects[0]
            bpy.context.scene.collection.objects.link(other)
            host.draw(other, [[-0.5, -0.5, 0], [-0.3, -0.5, 0]])
            self.assertNotEqual(other.relievo.uid, field.relievo.uid)
            self.assertEqual(host.digest(self.relievo, field), before)
            self.assertNotEqual(host.digest(self.relievo, other), before)


class Imprints(Case):
    def moving_ball(self, deforming=False):
        ball = host.ball(0.3)
        for frame, x in ((1, -0.6), (5, 0.6)):
            ball.location = (x, 0.25, 0.2)
            ball.keyframe_insert("location", frame=frame)
        bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 5
        bpy.context.scene.relievo.imprint.voxels = 2**18
        return ball

    def test_a_moving_ball_leaves_a_track_of_its_depth(self):
        field, ball = host.field(), self.moving_ball()
        field.relievo.cells = "32"
        host.select(field, ball)
        self.assertEqual(bpy.ops.relievo.imprint(), {"FINISHED"})
        points = host.positions(field.relievo.result)
        row = points[numpy.abs(points[:, 1] - 0.25) < 1e-4]
        inside = row[numpy.abs(row[:, 0]) < 0.5]
        numpy.testing.assert_allclose(inside[:, 2], -0.1, atol=0.015)
        self.assertLess(numpy.abs(row[numpy.abs(row[:, 0]) > 0.95][:, 2]).max(), 0.01)
        state = self.relievo.data.state.of(field)
        self.assertEqual(state.document.info.undo_count, 1)

    def test_a_deforming_presser_follows_its_armature_and_shape_keys(self):
        field = host.field()
        ball = host.ball(0.3)
        ball.location = (0, 0.25, 0.5)
        ball.shape_key_add(name="rest")
        low = ball.shape_key_add(name="low")
        for point in low.data:
            point.co.z -= 0.3
        low.value = 0.0
        low.keyframe_insert("value", frame=1)
        low.value = 1.0
        low.keyframe_insert("value", frame=3)
        bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 3
        bpy.context.scene.relievo.imprint.voxels = 2**18
        host.select(field, ball)
        bpy.ops.relievo.imprint()
        self.assertAlmostEqual(float(host.positions(field.relievo.result)[:, 2].min()), -0.1, delta=0.015)

    def test_an_active_object_that_is_skinned_keeps_its_pose(self):
        field, ball = host.field(), self.moving_ball()
        field.modifiers.new("lift", "SIMPLE_DEFORM").angle = 0.0
        lift = field.modifiers.new("displace", "DISPLACE")
        lift.strength, lift.mid_level, lift.direction = 0.05, 0.0, "Z"
        host.select(field, ball)
        bpy.ops.relievo.imprint()
        heights = host.positions(field.relievo.result)[:, 2]
        self.assertAlmostEqual(float(heights.max()), 0.05, delta=0.01)
        self.assertAlmostEqual(float(heights.min()), -0.1, delta=0.03)

    def test_a_bake_plays_without_the_addon_from_a_relative_path(self):
        with host.folder() as folder:
            field, ball = host.field(), self.moving_ball()
            path = os.path.join(folder, "baked.blend")
            host.select(field, ball)
            with self.assertRaisesRegex(RuntimeError, "Save the .blend file first"):
                bpy.ops.relievo.imprint(cache=True)
            bpy.ops.wm.save_as_mainfile(filepath=path)
            self.assertEqual(bpy.ops.relievo.imprint(cache=True, images=True, image_size=64), {"FINISHED"})
            last = host.positions(field.relievo.result)
            bpy.ops.wm.save_as_mainfile(filepath=path)
            moved = os.path.join(folder, "moved")
            os.mkdir(moved)
            for name in ("baked.blend", "relievo_cache"):
                os.rename(os.path.join(folder, name), os.path.join(moved, name))
            bpy.ops.preferences.addon_disable(module="relievo")
            bpy.ops.wm.open_mainfile(filepath=os.path.join(moved, "baked.blend"))
            self.assertFalse(hasattr(bpy.types.Object, "relievo"))
            result = bpy.data.objects["field Relievo"]
            self.assertTrue(result.modifiers[0].filepath.startswith("//relievo_cache"))
            lowest = {}
            for frame in range(1, 6):
                bpy.context.scene.frame_set(frame)
                played = result.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
                points = numpy.empty((len(played.vertices), 3), numpy.float32)
                played.vertices.foreach_get("co", points.ravel())
                lowest[frame] = points
            numpy.testing.assert_allclose(lowest[5], last, atol=1e-6)
            dented = [int((points[:, 2] < -0.02).sum()) for points in lowest.values()]
            self.assertEqual(dented, sorted(dented))
            self.assertGreater(dented[-1], 2 * dented[0])
            image = bpy.data.objects["field"].active_material.node_tree.nodes["Relievo displacement"].image
            self.assertEqual(image.source, "SEQUENCE")
            self.assertTrue(image.filepath.startswith("//relievo_cache"))
            self.assertEqual(len(list(Path(moved, "relievo_cache").glob("baked.field.*_000?.exr"))), 5)

    def test_nothing_that_presses(self):
        field = host.field()
        host.select(field)
        with self.assertRaisesRegex(RuntimeError, "Select the objects that press"):
            bpy.ops.relievo.imprint()


class Threads(Case):
    def test_what_takes_long_is_done_on_a_thread(self):
        """Operators that run in a window as steps call of the library on the main thread only what is short."""
        import librelievo as rl
        from relievo.core import job
        from relievo.ops import imprint, layer, preview, repair, result, scene
        from relievo.tools import brush

        slow = ("surface_create", "detail_create", "document_", "tessellation_create", "tessellation_update", "imprint_run")
        slow += ("imprint_sweep", "stroke_", "caster_create", "bake_", "ptex_", "layer_add", "layer_set", "evaluate", "surface_set")
        slow += ("mesh_create", "collider_create", "detail_set_points", "layer_merge", "mesh_write", "layer_remove", "repair_", "mesh_get")
        allowed = {"rlv_document_begin", "rlv_document_info", "rlv_document_release", "rlv_imprint_params", "rlv_stroke_release"}
        main, called = threading.main_thread(), []
        original = rl.library.call

        def call(name, *arguments):
            if threading.current_thread() is main:
                called.append(name)
            return original(name, *arguments)

        with host.folder() as folder:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "threads.blend"))
            field, ball = host.field(), host.ball(0.3)
            host.select(field, ball)
            points = json.dumps([[0, 0, 0], [0.2, 0, 0]])
            options = {"frame_start": 1, "frame_end": 2, "cache": True, "images": True, "image_size": 16}
            path = os.path.join(folder, "file")

            def pinch():
                bpy.context.scene.relievo.brush.sculpt_mode = "PINCH"
                return host.operator(brush.RELIEVO_OT_stroke, action="SCULPT", points=points)

            def mend():
                host.select(ball)
                return host.operator(repair.RELIEVO_OT_repair)

            work = [
                lambda: brush.preparing(bpy.context, field, "PAINT"),
                lambda: host.operator(brush.RELIEVO_OT_stroke, action="PAINT", points=points),
                pinch,
                lambda: host.operator(layer.RELIEVO_OT_layer_add, name="Layer", kind="DISPLACEMENT"),
                lambda: host.operator(result.RELIEVO_OT_result_image, quantity="DISPLACEMENT", wire=True),
                lambda: host.operator(result.RELIEVO_OT_result_color),
                lambda: host.operator(result.RELIEVO_OT_result_ptex, channel="COLOR", filepath=path),
                lambda: host.operator(result.RELIEVO_OT_result_document, filepath=path),
                lambda: host.operator(imprint.RELIEVO_OT_imprint, **options),
                lambda: preview.Preview(field, [ball]).steps(bpy.context),
                lambda: host.operator(brush.RELIEVO_OT_replay),
                lambda: host.operator(scene.RELIEVO_OT_export_scene, filepath=path, start="STROKES"),
                mend,
            ]
            rl.library.call = call
            try:
                for begin in work:
                    worker = job.Worker(begin())
                    while not worker.advance(1.0):
                        pass
            finally:
                rl.library.call = original
        found = {name for name in called if name not in allowed and any(part in name for part in slow)}
        self.assertEqual(found, set())
        self.assertGreater(len(called), 20)


class Results(Case):
    def painted(self):
        field = host.field()
        host.draw(field, [[-0.5, 0.25, 0], [0.5, 0.25, 0]], radius=0.3, height=0.2, falloff="CONSTANT")
        host.draw(field, [[-0.5, 0.25, 0], [0.5, 0.25, 0]], "PAINT", radius=0.3, color=(1, 0, 0, 1))
        return field

    def test_images_are_wired_relative_and_hold_the_displacement(self):
        with host.folder() as folder:
            field = self.painted()
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "images.blend"))
            bpy.context.scene.relievo.image_size = 64
            self.assertEqual(bpy.ops.relievo.result_image(quantity="DISPLACEMENT"), {"FINISHED"})
            self.assertEqual(bpy.ops.relievo.result_image(quantity="COLOR"), {"FINISHED"})
            nodes = field.active_material.node_tree.nodes
            image = nodes["Relievo displacement"].image
            self.assertTrue(image.filepath.startswith("//relievo_cache"), image.filepath)
            self.assertEqual(tuple(image.size), (64, 64))
            pixels = numpy.empty(64 * 64 * image.channels, numpy.float32)
            image.pixels.foreach_get(pixels)
            pixels = pixels.reshape(64, 64, image.channels)[:, :, 0]
            # v is 0 in Blender's lowest row, as in ours.
            top = host.positions(field.relievo.result)[:, 2].max()
            self.assertAlmostEqual(float(pixels[40, 32]), float(top), delta=0.02)
            self.assertAlmostEqual(float(pixels[10, 32]), 0.0, delta=0.01)

    def test_colours_ptex_and_documents(self):
        with host.folder() as folder:
            field = self.painted()
            self.assertEqual(bpy.ops.relievo.result_color(), {"FINISHED"})
            colors = numpy.empty((len(field.data.loops), 4), numpy.float32)
            field.data.attributes["Relievo colour"].data.foreach_get("color", colors.ravel())
            heights = host.positions(field)
            self.assertEqual(heights.shape[0], 25)
            corners = self.relievo.data.mesh.get_corners(field.data)
            near = numpy.abs(heights[corners][:, 1] - 0.0) < 0.3
            self.assertEqual(bpy.ops.relievo.result_ptex(filepath=os.path.join(folder, "a.ptx")), {"FINISHED"})
            path = os.path.join(folder, "a.relievo")
            self.assertEqual(bpy.ops.relievo.result_document(filepath=path), {"FINISHED"})
            import librelievo as rl

            made = rl.document.mesh(self.relievo.core.native.context(), path)
            self.assertEqual(made.info.face_count, 16)
            self.assertTrue(near.any() and (colors[:, 3] > 0.99).all())

    def test_every_parameter_of_the_library_is_a_property(self):
        import librelievo as rl

        scene = bpy.context.scene.relievo
        for group, table in (
            (scene.brush.settings, rl.brush.params()),
            (scene.brush.stamp_settings, rl.brush.stamp_params()),
            (scene.imprint, rl.imprint.params()),
        ):
            for parameter in table:
                found = group.bl_rna.properties[parameter.name]
                self.assertIn(parameter.help, found.description)
                self.assertAlmostEqual(float(getattr(group, parameter.name)), float(parameter.value), places=5)

    def test_a_scene_file_runs_without_blender(self):
        command = os.environ.get("RELIEVO_COMMAND")
        if not command:
            self.skipTest("skipped: RELIEVO_COMMAND names no `relievo`")
        with host.folder() as folder:
            field = self.painted()
            ball = Imprints.moving_ball(self)
            host.select(field, ball)
            path = os.path.join(folder, "scene.toml")
            for start in ("STROKES", "DOCUMENT"):
                self.assertEqual(bpy.ops.relievo.export_scene(filepath=path, start=start), {"FINISHED"})
                checked = subprocess.run([command, "scene", "check", path], capture_output=True, text=True)
                self.assertEqual(checked.returncode, 0, checked.stderr)


if __name__ == "__main__":
    host.main()
