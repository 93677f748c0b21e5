"""USD against OpenUSD itself: what is written is valid and says what it should, what OpenUSD writes is read."""

import json
import sys
import tempfile
import unittest
from pathlib import Path

import numpy
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdValidation, Vt

ROOT = Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "plugins" / "python"), str(ROOT / "tests" / "python"), str(Path(__file__).resolve().parent)]

import librelievo as rl
import shapes
import stages

# Both of OpenUSD's formats are read; text is written.
FORMATS = ("usda", "usdc")


def problems(path):
    """What OpenUSD's own validators find."""
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    found = UsdValidation.ValidationContext(validators).Validate(Usd.Stage.Open(str(path)))
    return [error.GetErrorAsString() for error in found]


def floats(attribute, time=Usd.TimeCode.Default()):
    return numpy.array(attribute.Get(time), numpy.float32)


class Case(unittest.TestCase):
    def setUp(self):
        self.context = rl.Context(threads=1)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def same(self, found, wanted, tolerance=0):
        numpy.testing.assert_allclose(numpy.array(found, float), numpy.array(wanted, float), rtol=0, atol=tolerance)


class Written(Case):
    def test_a_mesh_with_everything(self):
        points, corners = shapes.cube()
        creases = (numpy.array([[0, 1], [1, 3]]), [2.5, 10.0])
        mesh = rl.Mesh(self.context, points, corners, 4, creases=creases, sharp_points=([7], [3.5]), holes=[2])
        uvs = numpy.array([[0, 0], [1, 0], [1, 1], [0, 1]], numpy.float32)
        choice = numpy.tile([0, 1, 2, 3], 6)
        colors = numpy.linspace(0, 1, 32, dtype=numpy.float32).reshape(8, 4)
        forces = numpy.arange(18, dtype=numpy.float32).reshape(6, 3)
        velocity = numpy.arange(24, dtype=numpy.float32).reshape(8, 3)
        mesh.add_attribute("uv", uvs, "corner", indices=choice)
        mesh.add_attribute("color", colors, "point")
        mesh.add_attribute("force", forces, "face")
        mesh.add_attribute("velocity", velocity, "point")
        mesh.add_attribute("material", numpy.array([0, 0, 1, 1, 1, 0]), "face")
        mesh.add_attribute("tag no. 1", numpy.arange(24), "corner")
        for suffix in ("usda", "usd"):
            path = self.folder / f"cube.{suffix}"
            mesh.write(path)
            self.assertEqual(problems(path), [])
            stage = Usd.Stage.Open(str(path))
            self.assertEqual(UsdGeom.GetStageMetersPerUnit(stage), 1)
            self.assertEqual(UsdGeom.GetStageUpAxis(stage), "Y")
            self.assertFalse(stage.HasAuthoredTimeCodeRange())
            made = UsdGeom.Mesh(stage.GetDefaultPrim().GetChild("mesh"))
            self.same(floats(made.GetPointsAttr()), points)
            self.same(made.GetFaceVertexCountsAttr().Get(), [4] * 6)
            self.same(made.GetFaceVertexIndicesAttr().Get(), corners)
            self.same(made.GetExtentAttr().Get(), [[-1] * 3, [1] * 3])
            self.assertEqual(made.GetSubdivisionSchemeAttr().Get(), "catmullClark")
            self.same(made.GetCreaseIndicesAttr().Get(), [0, 1, 1, 3])
            self.same(made.GetCreaseLengthsAttr().Get(), [2, 2])
            self.same(made.GetCreaseSharpnessesAttr().Get(), [2.5, 10])
            self.same(made.GetCornerIndicesAttr().Get(), [7])
            self.same(made.GetCornerSharpnessesAttr().Get(), [3.5])
            self.same(made.GetHoleIndicesAttr().Get(), [2])
            self.same(floats(made.GetVelocitiesAttr()), velocity)
            values = UsdGeom.PrimvarsAPI(made)
            st = values.GetPrimvar("st")
            self.assertEqual((st.GetTypeName(), st.GetInterpolation()), ("texCoord2f[]", "faceVarying"))
            self.same(st.GetIndices(), choice)
            self.same(floats(st), uvs)
            color, alpha = values.GetPrimvar("displayColor"), values.GetPrimvar("displayOpacity")
            self.assertEqual((color.GetTypeName(), color.GetInterpolation()), ("color3f[]", "vertex"))
            self.same(numpy.column_stack([floats(color), floats(alpha)]), colors)
            force = values.GetPrimvar("force")
            self.assertEqual((force.GetTypeName(), force.GetInterpolation()), ("float3[]", "uniform"))
            self.same(floats(force), forces)
            self.same(values.GetPrimvar("tag_no__1").Get(), numpy.arange(24))
            subsets = UsdShade.MaterialBindingAPI(made).GetMaterialBindSubsets()
            self.assertEqual([list(subset.GetIndicesAttr().Get()) for subset in subsets], [[0, 1, 5], [2, 3, 4]])
            self.assertEqual(UsdGeom.Subset.ValidateFamily(made, "face", "materialBind"), (True, ""))
            bound, _ = UsdShade.MaterialBindingAPI(subsets[0]).ComputeBoundMaterial()
            self.assertEqual(bound.GetPath(), "/scene/materials/material_0")

    def test_all_frames_of_a_scene_are_one_stage(self):
        for up, units, metres in (("z", "cm", 0.01), ("y", "m", 1.0)):
            (self.folder / up).mkdir()
            out = stages.run(self.folder / up, up, units)
            for path in [out / "mesh-000000-000005.usda"]:
                self.assertEqual(problems(path), [])
                stage = Usd.Stage.Open(str(path))
                self.assertEqual(UsdGeom.GetStageMetersPerUnit(stage), metres)
                self.assertEqual(UsdGeom.GetStageUpAxis(stage), up.upper())
                self.assertEqual((stage.GetStartTimeCode(), stage.GetEndTimeCode()), (0, 5))
                self.assertEqual((stage.GetTimeCodesPerSecond(), stage.GetFramesPerSecond()), (25, 25))
                for name in ("plate", "ball"):
                    mesh = UsdGeom.Mesh(stage.GetDefaultPrim().GetChild(name))
                    for frame in range(stages.FRAMES):
                        place = numpy.array(mesh.ComputeLocalToWorldTransform(frame))
                        local = floats(mesh.GetPointsAttr(), frame).astype(float)
                        world = numpy.column_stack([local, numpy.ones(len(local))]) @ place
                        # Faces are the same in all frames; files of a frame have those that it needs.
                        wanted = stages.ply_points(out / f"mesh-{frame:06}-{name}.ply")
                        self.assertLess(stages.farthest(wanted, world[:, :3]), 2e-6)
                        low, high = mesh.GetExtentAttr().Get(frame)
                        self.same([low, high], [local.min(0), local.max(0)], 1e-6)
                    if name == "plate":
                        velocities = mesh.GetVelocitiesAttr()
                        self.assertEqual(velocities.GetNumTimeSamples(), stages.FRAMES)
                        before, after = (floats(mesh.GetPointsAttr(), frame) for frame in (1, 3))
                        self.same(floats(velocities, 2), (after - before) * 25 / 2, 1e-4)
                        self.assertLess(floats(mesh.GetPointsAttr(), 5)[:, "xyz".index(up)].min(), -0.05)

    def test_velocities_are_those_of_the_points(self):
        # Faces of a mesh that is read from a stage stay, so the points over time become velocities again.
        stage = Usd.Stage.CreateNew(str(self.folder / "wave.usdc"))
        UsdGeom.SetStageMetersPerUnit(stage, 1)
        UsdGeom.SetStageUpAxis(stage, "Z")
        stage.SetTimeCodesPerSecond(25)
        mesh = UsdGeom.Mesh.Define(stage, "/wave")
        points, corners, _ = shapes.grid(4)
        mesh.CreateFaceVertexCountsAttr([4] * 16)
        mesh.CreateFaceVertexIndicesAttr(corners.tolist())
        heights = [0.0, 0.1, 0.4, 0.9, 1.6, 2.5]
        for frame, height in enumerate(heights):
            moved = points + numpy.array([0, 0, height], numpy.float32)
            mesh.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy(moved), frame)
        stage.Save()
        (self.folder / "scene.toml").write_text(
            'version = 1\nup = "z"\nfps = 25\n[meshes.wave]\nfile = "wave.usdc"\nanimation = "stage"\n'
            '[objects.wave]\nmesh = "wave"\n'
            '[output]\nframes = 6\npictures = []\nmesh = "every"\nmesh_formats = ["usda"]\n'
        )
        stages.command("scene", "run", self.folder / "scene.toml", "--out", self.folder / "out")
        path = self.folder / "out" / "mesh-000000-000005.usda"
        self.assertEqual(problems(path), [])
        opened = Usd.Stage.Open(str(path))
        made = UsdGeom.Mesh(opened.GetPrimAtPath("/scene/wave"))
        for frame, height in enumerate(heights):
            self.same(floats(made.GetPointsAttr(), frame), points + numpy.array([0, 0, height]), 1e-6)
            before, after = max(frame - 1, 0), min(frame + 1, 5)
            speed = (heights[after] - heights[before]) / (after - before) * 25
            self.same(floats(made.GetVelocitiesAttr(), frame), [[0, 0, speed]] * len(points), 1e-4)


class Read(Case):
    """OpenUSD makes stages with varied features and says what their meshes are."""

    def shown(self, stage, time=Usd.TimeCode.Default()):
        """The points of all meshes in metres with y up, one after the other."""
        scale = UsdGeom.GetStageMetersPerUnit(stage)
        found = []
        for prim in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()):
            if prim.IsA(UsdGeom.Mesh) and UsdGeom.Imageable(prim).ComputePurpose() in ("default", "render"):
                mesh = UsdGeom.Mesh(prim)
                points = numpy.array(mesh.GetPointsAttr().Get(time), float)
                place = numpy.array(mesh.ComputeLocalToWorldTransform(time))
                found.append((numpy.column_stack([points, numpy.ones(len(points))]) @ place)[:, :3])
        points = numpy.concatenate(found) * scale
        if UsdGeom.GetStageUpAxis(stage) == "Z":
            points = numpy.column_stack([points[:, 0], points[:, 2], -points[:, 1]])
        return points

    def tetrahedron(self, stage, path):
        mesh = UsdGeom.Mesh.Define(stage, path)
        mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
        mesh.CreateFaceVertexCountsAttr([3, 3, 3, 3])
        mesh.CreateFaceVertexIndicesAttr([0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2])
        return mesh

    def test_primvars_of_every_precision_and_interpolation(self):
        for suffix in FORMATS:
            path = self.folder / f"values.{suffix}"
            stage = Usd.Stage.CreateNew(str(path))
            UsdGeom.SetStageMetersPerUnit(stage, 0.1)
            UsdGeom.SetStageUpAxis(stage, "Z")
            points, corners, _ = shapes.grid(8)
            mesh = UsdGeom.Mesh.Define(stage, "/grid")
            mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
            mesh.CreateFaceVertexCountsAttr([4] * 64)
            mesh.CreateFaceVertexIndicesAttr(corners.tolist())
            mesh.CreateSubdivisionSchemeAttr("catmullClark")
            mesh.CreateCreaseIndicesAttr([0, 1, 2, 9, 10])
            mesh.CreateCreaseLengthsAttr([3, 2])
            mesh.CreateCreaseSharpnessesAttr([1.5, 2.5, 10])
            values = UsdGeom.PrimvarsAPI(mesh)
            types = Sdf.ValueTypeNames
            random = numpy.random.default_rng(5)
            wanted = {}

            def add(name, kind, interpolation, count, width, numbers=None, exact=True):
                numbers = random.random((count, width)) if numbers is None else numbers
                if not exact:
                    numbers = numbers.astype(numpy.float16).astype(float)
                made = values.CreatePrimvar(name, kind, interpolation)
                made.Set([tuple(row) if width > 1 else row[0] for row in numbers.tolist()])
                wanted[name] = (numbers.astype(numpy.float32), made)
                return made

            add("half", types.HalfArray, "vertex", 81, 1, exact=False)
            add("half3", types.Half3Array, "vertex", 81, 3, exact=False)
            add("double2", types.Double2Array, "faceVarying", 256, 2)
            add("vec4", types.Float4Array, "uniform", 64, 4)
            add("point", types.Point3fArray, "varying", 81, 3)
            # Binary files pack whole numbers, and few that repeat.
            add("whole", types.FloatArray, "vertex", 81, 1, numpy.arange(81.0).reshape(81, 1))
            add("few", types.DoubleArray, "vertex", 81, 1, numpy.array([[0.25, 1.75, 3.5][i % 3] for i in range(81)])[:, None])
            add("counts", types.IntArray, "vertex", 81, 1, numpy.arange(81).reshape(81, 1) * 1000)
            add("long", types.Int64Array, "uniform", 64, 1, numpy.arange(64).reshape(64, 1))
            st = add("st", types.TexCoord2fArray, "faceVarying", 256, 2, numpy.repeat(random.random((64, 2)), 4, 0))
            st.SetIndices(Vt.IntArray(list(reversed(range(256)))))
            color = values.CreatePrimvar("displayColor", types.Color3fArray, "constant")
            color.Set([(0.5, 0.25, 0.75)])
            values.CreatePrimvar("label", types.StringArray, "constant").Set(["text", "more"])
            values.CreatePrimvar("flags", types.BoolArray, "uniform").Set([True] * 64)
            mesh.GetPrim().SetCustomData({"a": {"b": [1, 2], "c": "text"}, "d": 1.5})
            stage.Save()

            found = rl.Mesh.read(self.context, path)
            self.same(found.points(), self.shown(stage), 1e-7)
            self.same(found.faces()[1], corners)
            self.assertEqual(found.info.crease_count, 3)
            for name, (numbers, made) in wanted.items():
                attribute = found.attribute({"st": "uv"}.get(name, name))
                flat = attribute.values
                if attribute.indices is not None:
                    flat = flat[attribute.indices]
                given = numpy.array(made.ComputeFlattened(), numpy.float32).reshape(len(flat), -1)
                self.same(flat, given, 1e-7)
            self.same(found.attribute("color").values, [[0.5, 0.25, 0.75]] * 81)
            information = json.loads(stages.command("info", path, "--json"))
            self.assertTrue(any("label" in note for note in information["notes"]), information["notes"])

    def test_composed_stages_with_every_transform(self):
        for suffix in FORMATS:
            folder = self.folder / suffix
            folder.mkdir()
            part = Usd.Stage.CreateNew(str(folder / f"part.{suffix}"))
            top = UsdGeom.Xform.Define(part, "/part")
            part.SetDefaultPrim(top.GetPrim())
            self.tetrahedron(part, "/part/low")
            sizes = top.GetPrim().GetVariantSets().AddVariantSet("size")
            for name, factor in (("small", 1), ("large", 3)):
                sizes.AddVariant(name)
                sizes.SetVariantSelection(name)
                with sizes.GetVariantEditContext():
                    self.tetrahedron(part, f"/part/{name}").AddScaleOp().Set((factor, factor, factor))
            sizes.SetVariantSelection("small")
            part.Save()

            path = folder / f"whole.{suffix}"
            stage = Usd.Stage.CreateNew(str(path))
            UsdGeom.SetStageMetersPerUnit(stage, 0.01)
            UsdGeom.SetStageUpAxis(stage, "Z")
            stage.SetStartTimeCode(1)
            stage.SetEndTimeCode(25)
            stage.SetTimeCodesPerSecond(24)
            world = UsdGeom.Xform.Define(stage, "/world")
            move = world.AddTranslateOp()
            move.Set((1, 2, 3), 1)
            move.Set((25, 2, 3), 25)
            world.AddRotateXYZOp().Set((10, 20, 30))
            pivot = world.AddTranslateOp(opSuffix="pivot")
            pivot.Set((5, 0, 0))
            world.AddScaleOp().Set((1, -2, 1))
            world.AddTranslateOp(opSuffix="pivot", isInverseOp=True)
            turned = self.tetrahedron(stage, "/world/turned")
            turned.AddOrientOp().Set(Gf.Quatf(0.5, 0.5, 0.5, 0.5))
            turned.AddRotateYOp().Set(12.5)
            turned.AddTransformOp().Set(Gf.Matrix4d(2, 0, 0, 0, 0, 1, 0.5, 0, 0, 0, 1, 0, 4, 5, 6, 1))
            turned.AddRotateZYXOp(UsdGeom.XformOp.PrecisionHalf).Set(Gf.Vec3h(15, 25, 35))
            alone = self.tetrahedron(stage, "/world/alone")
            alone.AddTranslateOp().Set((7, 8, 9))
            alone.SetResetXformStack(True)
            moving = self.tetrahedron(stage, "/world/moving")
            for code in (1, 13, 25):
                moved = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1 + code * code)]
                moving.GetPointsAttr().Set(moved, code)
            moving.GetPointsAttr().ClearDefault()
            for index, variant in enumerate((None, "large")):
                prim = stage.DefinePrim(f"/world/part_{index}")
                prim.GetReferences().AddReference(f"part.{suffix}", layerOffset=Sdf.LayerOffset(2, 1))
                if variant:
                    prim.GetVariantSet("size").SetVariantSelection(variant)
            instance = stage.DefinePrim("/world/instance")
            instance.GetPayloads().AddPayload(f"part.{suffix}", "/part")
            instance.SetInstanceable(True)
            stage.CreateClassPrim("/base").GetReferences().AddReference(f"part.{suffix}")
            stage.DefinePrim("/world/derived").GetInherits().AddInherit("/base")
            stage.DefinePrim("/world/special").GetSpecializes().AddSpecialize("/base")
            self.tetrahedron(stage, "/world/guide").CreatePurposeAttr("guide")
            off = self.tetrahedron(stage, "/world/off")
            off.GetPrim().SetActive(False)
            stage.Save()
            self.same(rl.Mesh.read(self.context, path).points(), self.shown(stage, 1), 1e-6)

            (folder / "scene.toml").write_text(
                f'version = 1\nup = "y"\nfps = 24\n[meshes.a]\nfile = "whole.{suffix}"\nanimation = "stage"\n'
                '[objects.a]\nmesh = "a"\n'
                '[output]\nframes = 25\npictures = []\nmesh = "every"\nmesh_formats = ["ply"]\n'
            )
            stages.command("scene", "run", folder / "scene.toml", "--out", folder / "out")
            for frame in (0, 1, 7, 12, 24):
                points = stages.ply_points(folder / "out" / f"mesh-{frame:06}-a.ply")
                self.same(points, self.shown(stage, frame + 1), 1e-5)

    def test_damaged_files_of_openusd_are_refused_or_read(self):
        path = self.folder / "part.usdc"
        stage = Usd.Stage.CreateNew(str(path))
        mesh = self.tetrahedron(stage, "/part")
        for code in range(4):
            mesh.GetPointsAttr().Set([(0, 0, code)] * 4, code)
        mesh.GetPrim().SetCustomData({"a": {"b": [1, 2]}})
        stage.Save()
        data = path.read_bytes()
        random = numpy.random.default_rng(3)
        refused = 0
        for _ in range(2000):
            spoiled = bytearray(data)
            for at in random.integers(0, len(data), random.integers(1, 4)):
                spoiled[at] = random.integers(0, 256)
            if random.random() < 0.1:
                del spoiled[random.integers(0, len(data)) :]
            path.write_bytes(spoiled)
            try:
                rl.Mesh.read(self.context, path)
            except rl.RelievoError:
                refused += 1
        self.assertGreater(refused, 500)


if __name__ == "__main__":
    unittest.main()
