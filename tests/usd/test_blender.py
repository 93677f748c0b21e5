"""USD in Blender without the add-on: what is written is imported and played back, what Blender exports is read."""

import sys
import tempfile
import unittest
from pathlib import Path

import bpy
import numpy

ROOT = Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "plugins" / "python"), str(ROOT / "tests" / "python"), str(Path(__file__).resolve().parent)]

import librelievo as rl
import shapes
import stages


def empty():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def positions(shown):
    """The points of an object as it is rendered, in the world."""
    evaluated = shown.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    points = numpy.empty((len(mesh.vertices), 3), numpy.float32)
    mesh.attributes["position"].data.foreach_get("vector", points.ravel())
    evaluated.to_mesh_clear()
    place = numpy.array(evaluated.matrix_world)
    return points @ place[:3, :3].T + place[:3, 3]


class Case(unittest.TestCase):
    def setUp(self):
        empty()
        self.context = rl.Context(threads=1)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def same(self, found, wanted, tolerance):
        numpy.testing.assert_allclose(numpy.array(found, float), numpy.array(wanted, float), rtol=0, atol=tolerance)

    def test_a_mesh_is_imported_with_its_attributes(self):
        points, corners = shapes.cube()
        mesh = rl.Mesh(self.context, points, corners, 4, creases=(numpy.array([[0, 1]]), [5.0]))
        mesh.add_attribute("uv", numpy.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]), "corner", indices=numpy.tile(range(4), 6))
        mesh.add_attribute("material", numpy.array([0, 0, 1, 1, 1, 0]), "face")
        for suffix in ("usda", "usd"):
            empty()
            path = self.folder / f"cube.{suffix}"
            mesh.write(path)
            self.assertEqual(bpy.ops.wm.usd_import(filepath=str(path)), {"FINISHED"})
            (made,) = [found for found in bpy.data.objects if found.type == "MESH"]
            # Blender has z up.
            self.same(positions(made), numpy.column_stack([points[:, 0], -points[:, 2], points[:, 1]]), 1e-6)
            self.assertEqual([len(face.vertices) for face in made.data.polygons], [4] * 6)
            self.assertEqual(len(made.data.uv_layers), 1)
            self.assertEqual([face.material_index for face in made.data.polygons], [0, 0, 1, 1, 1, 0])
            self.assertEqual(len(made.data.materials), 2)
            crease = made.data.attributes["crease_edge"].data
            self.assertEqual(sum(edge.value > 0 for edge in crease), 1)

    def test_a_baked_scene_plays_through_the_mesh_sequence_cache(self):
        out = stages.run(self.folder)
        path = out / "mesh-000000-000005.usda"
        bpy.context.scene.render.fps = 25
        self.assertEqual(bpy.ops.wm.usd_import(filepath=str(path)), {"FINISHED"})
        plate, ball = bpy.data.objects["plate"], bpy.data.objects["ball"]
        self.assertIn("MESH_SEQUENCE_CACHE", [modifier.type for modifier in plate.modifiers])
        moved = []
        for frame in range(stages.FRAMES):
            bpy.context.scene.frame_set(frame)
            for shown in (plate, ball):
                wanted = stages.ply_points(out / f"mesh-{frame:06}-{shown.name}.ply")
                self.assertLess(stages.farthest(wanted, positions(shown)), 1e-5)
            moved.append(positions(plate)[:, 2].min())
        self.assertLess(moved[-1], -0.05)

    def test_a_modifier_on_an_object_of_ones_own_plays_the_stage(self):
        points, corners, _ = shapes.grid(4)
        heights = [0.0, 0.5, 2.0]
        frames = "".join(
            f"        {frame}: {[tuple(map(float, point + [0, 0, height])) for point in points]},\n"
            for frame, height in enumerate(heights)
        )
        text = (
            "#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = \"Z\"\n    timeCodesPerSecond = 24\n)\n"
            'def Mesh "wave"\n{\n'
            f"    int[] faceVertexCounts = {[4] * 16}\n    int[] faceVertexIndices = {corners.tolist()}\n"
            f"    point3f[] points.timeSamples = {{\n{frames}    }}\n}}\n"
        )
        (self.folder / "wave.usda").write_text(text)
        (self.folder / "scene.toml").write_text(
            'version = 1\nup = "z"\nfps = 24\n[meshes.wave]\nfile = "wave.usda"\nanimation = "stage"\n'
            '[objects.wave]\nmesh = "wave"\n'
            '[output]\nframes = 3\npictures = []\nmesh = "every"\nmesh_formats = ["usda"]\n'
        )
        stages.command("scene", "run", self.folder / "scene.toml", "--out", self.folder / "out")
        mesh = bpy.data.meshes.new("wave")
        mesh.from_pydata(points.tolist(), [], corners.reshape(-1, 4).tolist())
        made = bpy.data.objects.new("wave", mesh)
        bpy.context.scene.collection.objects.link(made)
        bpy.ops.cachefile.open(filepath=str(self.folder / "out" / "mesh-000000-000002.usda"))
        modifier = made.modifiers.new("cache", "MESH_SEQUENCE_CACHE")
        modifier.cache_file = bpy.data.cache_files[0]
        modifier.object_path = "/scene/wave"
        bpy.context.scene.render.fps = 24
        for frame, height in enumerate(heights):
            bpy.context.scene.frame_set(frame)
            self.same(positions(made), points + numpy.array([0, 0, height]), 1e-6)

    def test_what_blender_exports_is_read(self):
        points, corners, uvs = shapes.grid(4)
        mesh = bpy.data.meshes.new("cage")
        mesh.from_pydata(points.tolist(), [], corners.reshape(-1, 4).tolist())
        layer = mesh.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", uvs[corners].ravel())
        crease = mesh.attributes.new("crease_edge", "FLOAT", "EDGE")
        crease.data[3].value = 1.0
        weight = mesh.attributes.new("weight", "FLOAT", "POINT")
        weight.data.foreach_set("value", numpy.arange(25, dtype=numpy.float32))
        for name in ("stone", "moss"):
            mesh.materials.append(bpy.data.materials.new(name))
        for index in (1, 5, 6):
            mesh.polygons[index].material_index = 1
        made = bpy.data.objects.new("cage", mesh)
        bpy.context.scene.collection.objects.link(made)
        made.location, made.rotation_euler, made.scale = (1, 2, 3), (0.1, 0.2, 0.3), (1, 2, 1)
        made.modifiers.new("smooth", "SUBSURF")
        made.keyframe_insert("location", frame=1)
        made.location = (4, 2, 3)
        made.keyframe_insert("location", frame=11)
        bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 11
        bpy.context.scene.frame_set(1)
        world = numpy.array(made.matrix_world)
        wanted = points @ world[:3, :3].T + world[:3, 3]
        for suffix in ("usda", "usdc"):
            path = self.folder / f"cage.{suffix}"
            options = {"export_animation": True, "export_subdivision": "BEST_MATCH"}
            self.assertEqual(bpy.ops.wm.usd_export(filepath=str(path), **options), {"FINISHED"})
            found = rl.Mesh.read(self.context, path)
            self.same(found.points(), numpy.column_stack([wanted[:, 0], wanted[:, 2], -wanted[:, 1]]), 1e-5)
            self.same(found.faces()[1], corners, 0)
            self.assertEqual(found.info.crease_count, 1)
            uv = found.attribute("uv")
            self.same(uv.values if uv.indices is None else uv.values[uv.indices], uvs[corners], 1e-6)
            self.same(found.attribute("weight").values.ravel(), numpy.arange(25), 0)
            slots = found.attribute("material").values.ravel()
            self.assertEqual([index for index, slot in enumerate(slots) if slot == slots[1]], [1, 5, 6])
            (self.folder / "scene.toml").write_text(
                f'version = 1\nup = "z"\nfps = 24\n[meshes.cage]\nfile = "cage.{suffix}"\nanimation = "stage"\n'
                '[objects.cage]\nmesh = "cage"\n'
                '[output]\nframes = 11\npictures = []\nmesh = "every"\nmesh_formats = ["ply"]\n'
            )
            stages.command("scene", "run", self.folder / "scene.toml", "--out", self.folder / suffix)
            for frame in (0, 4, 10):
                bpy.context.scene.frame_set(frame + 1)
                world = numpy.array(made.matrix_world)
                placed = points @ world[:3, :3].T + world[:3, 3]
                self.same(stages.ply_points(self.folder / suffix / f"mesh-{frame:06}-cage.ply"), placed, 1e-5)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
