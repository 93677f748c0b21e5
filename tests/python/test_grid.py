"""Grids of OpenVDB from Python: NumPy arrays in and out, files both ways with bpy's own OpenVDB, and both in one process.

RELIEVO_OPENVDB names the module. What needs bpy is skipped where there is none."""

import importlib.util
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy

import librelievo as rl

HAS_BPY = importlib.util.find_spec("bpy") is not None
KINDS = {
    "float": "FloatGrid",
    "double": "DoubleGrid",
    "bool": "BoolGrid",
    "int32": "Int32Grid",
    "int64": "Int64Grid",
    "vec3s": "Vec3SGrid",
    "vec3d": "Vec3DGrid",
    "vec3i": "Vec3IGrid",
}


def box(context, low=(0, 0, 0), high=(1, 1, 1)):
    points = [[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)]
    corners = [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6]
    return rl.Mesh(context, points, corners, 4)


def values_of(kind, shape=(7, 6, 5)):
    random = numpy.random.default_rng(1)
    if kind.startswith("vec3"):
        shape = (*shape, 3)
    values = random.integers(-1000, 1000, shape)
    values[0] = 0
    types = {"float": "f4", "double": "f8", "bool": "?", "int32": "i4", "int64": "i8", "vec3s": "f4", "vec3d": "f8", "vec3i": "i4"}
    if kind == "bool":
        return values > 0
    return (values * (0.25 if types[kind][0] == "f" else 1)).astype(types[kind])


def alone(code, *arguments):
    """Runs code in a process of its own and returns what it prints."""
    done = subprocess.run([sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


class Grids(unittest.TestCase):
    def setUp(self):
        self.context = rl.Context(threads=1, memory_limit=1 << 28)
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = Path(self.folder.name) / "grid.vdb"

    def test_blocks_come_back_from_files(self):
        for kind in KINDS:
            values, low = values_of(kind), (-3, 2, 100)
            grid = rl.Grid(self.context, kind, voxel=0.5)
            grid.set_name("values")
            grid.set_block(low, values)
            grid.set_metadata("frame", 7)
            for pack in ("blosc", "zip", None):
                grid.write(self.path, pack=pack, stream=pack is None)
                about = rl.grid.info(self.context, self.path)[0]
                self.assertEqual((about.name, about.kind, about.active_voxels), ("values", grid.info.kind, grid.info.active_voxels))
                read = rl.Grid.read(self.context, self.path, "values")
                numpy.testing.assert_array_equal(read.block(low, values.shape[:3]), values)
                self.assertEqual(read.metadata("frame"), "7")
                self.assertEqual(read.metadata_types["frame"], "int64")
            written = rl.job.write_grids(self.path, [grid], pack="zip")
            written.wait()
            self.assertIsNone(written.result())
            self.assertEqual(rl.grid.info(self.context, self.path)[0].active_voxels, grid.info.active_voxels)
            found = read.sample([(-1.0, 1.5, 51.0)], linear=False)
            numpy.testing.assert_array_equal(found[0], values[1, 1, 2])

    def test_a_frustum_survives_a_file(self):
        grid = rl.Grid(self.context, "float", voxel=1.0)
        grid.set_block((0, 0, 0), numpy.ones((8, 8, 8), numpy.float32))
        grid.set_frustum([(0, 0, 0), (7, 7, 7)], 0.5, 2.0)
        grid.write(self.path)
        read = rl.Grid.read(self.context, self.path)
        self.assertEqual((read.info.is_linear, grid.info.is_linear), (0, 0))
        self.assertEqual(list(read.info.voxel_size), list(grid.info.voxel_size))
        with self.assertRaises(rl.Invalid):
            grid.set_frustum([(0, 0, 0), (0, 7, 7)], 0.5, 2.0)

    def test_a_mesh_becomes_a_level_set_and_a_mesh(self):
        reports = []
        grid = rl.Grid.from_mesh(box(self.context), lambda *report: reports.append(report), voxel=0.05)
        self.assertTrue(reports and grid.info.grid_class == rl.abi.RlvGridClass.LEVEL_SET)
        moved = grid.change("offset", distance=0.2)
        self.assertAlmostEqual(moved.sample([(0.5, 0.5, 1.2)])[0], 0, places=3)
        other = rl.Grid.from_mesh(box(self.context, (0.5, 0, 0), (1.5, 1, 1)), voxel=0.05)
        cut = grid.combine(other, "difference")
        self.assertLess(cut.sample([(0.25, 0.5, 0.5)])[0], 0)
        self.assertGreater(cut.sample([(0.75, 0.5, 0.5)])[0], 0)
        mesh = grid.mesh(adaptivity=0.2)
        self.assertTrue(10 < mesh.info.face_count < grid.mesh().info.face_count)
        labels = rl.grid.labels([grid, other], [4, 6])
        numpy.testing.assert_array_equal(labels.sample([(0.2, 0.5, 0.5), (1.2, 0.5, 0.5), (3, 3, 3)], linear=False), [4, 6, 0])
        self.assertEqual(labels.label_mask(6).convert("float").sample([(1.2, 0.5, 0.5)])[0], 1)
        job = rl.job.grid_from_mesh(box(self.context), voxel=0.05)
        job.wait()
        self.assertEqual(job.result().info.active_voxels, grid.info.active_voxels)

    def test_what_cannot_be_is_refused(self):
        grid = rl.Grid(self.context)
        for call, kind in (
            (lambda: grid.sample([(numpy.nan, 0, 0)]), rl.Invalid),
            (lambda: grid.set_block((0, 0, 0), numpy.full((2, 2, 2), numpy.inf)), rl.Invalid),
            (lambda: grid.change("melt"), rl.Invalid),
            (lambda: grid.mesh(), rl.Invalid),
            (lambda: rl.Grid.read(self.context, "none.vdb"), rl.NotFound),
            (lambda: rl.Grid.from_mesh(box(self.context), voxel=1e-4), rl.MemoryLimit),
        ):
            with self.assertRaises(kind):
                call()

    def test_without_the_module_the_package_is_named(self):
        code = "import librelievo as rl\ntry: rl.grid.is_available()\nexcept rl.NotFound as error: print(error)"
        kept = os.environ.get("RELIEVO_OPENVDB")
        os.environ["RELIEVO_OPENVDB"] = "/nowhere.so"
        try:
            self.assertIn("relievo-openvdb", alone(code))
        finally:
            del os.environ["RELIEVO_OPENVDB"]
            if kept is not None:
                os.environ["RELIEVO_OPENVDB"] = kept


# The OpenVDB of bpy lies beside Blender's own Python.
PROLOGUE = r"""
import glob, os, sys, bpy, numpy
sys.path += glob.glob(os.path.join(bpy.utils.resource_path("LOCAL"), "python/lib/python3*/site-packages"))
import openvdb
"""

WRITE = PROLOGUE + r"""
for kind, name, values, low, path in numpy.load(sys.argv[1], allow_pickle=True):
    grid = getattr(openvdb, name)()
    grid.name = "values"
    grid.copyFromArray(values, ijk=low)
    grid.transform = openvdb.createLinearTransform(voxelSize=0.25)
    openvdb.write(path, grids=[grid], metadata={"by": "bpy"})
"""

READ = PROLOGUE + r"""
for kind, name, values, low, path in numpy.load(sys.argv[1], allow_pickle=True):
    grid = openvdb.read(path, "values")
    found = numpy.zeros_like(values)
    grid.copyToArray(found, ijk=low)
    assert type(grid).__name__ == name and (found == values).all(), kind
print("read")
"""

BOTH = r"""
import os, sys
import numpy
threads = lambda: len(os.listdir("/proc/self/task"))
loaded = lambda: "librelievo_openvdb" in open("/proc/self/maps").read()
first = sys.argv[1]
if first == "host":
    import bpy
import librelievo as rl
sys.path.append(sys.argv[2])
import test_grid
context = rl.Context(threads=1)
mesh = test_grid.box(context)
def module():
    before = threads()
    grid = rl.Grid.from_mesh(mesh, voxel=0.05)
    assert abs(grid.sample([(0.5, 0.5, 1.1)])[0] - 0.1) < 1e-5
    assert loaded() and threads() == before, "threads"
    return grid.info.active_voxels, grid.change("mean").mesh().info.face_count
def host():
    import bpy
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_cube_add(size=1)
    cube = bpy.context.object
    cube.data.remesh_voxel_size = 0.05
    bpy.ops.object.voxel_remesh()
    return len(cube.data.vertices)
assert not loaded(), "the module is there before it is needed"
found = []
for _ in range(5):
    found.append((module(), host()) if first == "module" else tuple(reversed((host(), module()))))
assert len(set(found)) == 1, found
print(found[0])
"""

BLENDER = PROLOGUE + r"""
bpy.ops.wm.read_factory_settings(use_empty=True)
grid = openvdb.read(sys.argv[1], "density")
assert isinstance(grid, openvdb.FloatGrid) and grid.gridClass == openvdb.GridClass.FOG_VOLUME, grid.gridClass
bpy.ops.object.volume_import(filepath=sys.argv[1])
volume = bpy.context.object
volume.data.grids.load()
assert [grid.name for grid in volume.data.grids] == ["density"]
target = bpy.data.objects.new("mesh", bpy.data.meshes.new("mesh"))
bpy.context.collection.objects.link(target)
modifier = target.modifiers.new("mesh", "VOLUME_TO_MESH")
modifier.object, modifier.threshold = volume, 0.5
made = target.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
size = numpy.ptp(numpy.array([vertex.co for vertex in made.vertices]), axis=0)
print(len(made.polygons), *size)
"""

FOG = PROLOGUE + r"""
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_uv_sphere_add(radius=1)
ball = bpy.context.object
volume = bpy.data.objects.new("volume", bpy.data.volumes.new("volume"))
bpy.context.collection.objects.link(volume)
modifier = volume.modifiers.new("volume", "MESH_TO_VOLUME")
modifier.object, modifier.resolution_mode, modifier.voxel_size = ball, "VOXEL_SIZE", 0.05
made = volume.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
made.grids.save(sys.argv[1]) if hasattr(made.grids, "save") else made.save(filepath=sys.argv[1])
"""


@unittest.skipUnless(HAS_BPY, "there is no bpy")
class Blender(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def cases(self, suffix):
        rows = []
        for kind, name in KINDS.items():
            path = f"{self.folder.name}/{kind}_{suffix}.vdb"
            rows.append((kind, name, values_of(kind), (-3, 2, 100), path))
        table = numpy.empty((len(rows), 5), object)
        for row, entry in enumerate(rows):
            for column, cell in enumerate(entry):
                table[row, column] = cell
        file = f"{self.folder.name}/{suffix}.npy"
        numpy.save(file, table, allow_pickle=True)
        return rows, file

    def test_files_of_its_openvdb_have_the_same_values(self):
        context = rl.Context()
        rows, file = self.cases("theirs")
        alone(WRITE, file)
        for kind, _, values, low, path in rows:
            grid = rl.Grid.read(context, path, "values")
            self.assertEqual(rl.abi.RlvGridKind(grid.info.kind).name.lower(), kind)
            self.assertEqual(rl.grid.file_metadata(context, path, "by"), "bpy")
            self.assertAlmostEqual(grid.info.voxel_size[0], 0.25)
            numpy.testing.assert_array_equal(grid.block(low, values.shape[:3]), values)
        rows, file = self.cases("ours")
        for kind, _, values, low, path in rows:
            grid = rl.Grid(context, kind)
            grid.set_name("values")
            grid.set_block(low, values)
            grid.write(path)
        self.assertIn("read", alone(READ, file))

    def test_both_work_in_one_process_in_either_order(self):
        here = str(Path(__file__).resolve().parent)
        results = {alone(BOTH, first, here).splitlines()[-1] for first in ("host", "module")}
        self.assertEqual(len(results), 1, results)

    def test_a_fog_volume_goes_from_it_through_here_and_back(self):
        context = rl.Context()
        path, back = Path(self.folder.name) / "fog.vdb", Path(self.folder.name) / "back.vdb"
        alone(FOG, path)
        about = rl.grid.info(context, path)[0]
        self.assertEqual((about.name, about.kind), ("density", rl.abi.RlvGridKind.FLOAT))
        command = os.environ.get("RELIEVO_COMMAND")
        if command:
            arguments = ["grid", "convert", str(path), "-o", str(back), "--to", "level-set", "--value", "0.5"]
            subprocess.run([command, *arguments], check=True, capture_output=True)
            level_set = rl.Grid.read(context, back)
        else:
            level_set = rl.Grid.read(context, path).change("to_level_set", value=0.5)
        fog = level_set.change("offset", distance=0.1).change("to_fog")
        fog.set_name("density")
        fog.write(back)
        count, *size = map(float, alone(BLENDER, back).split())
        self.assertGreater(count, 1000)
        for edge in size:
            self.assertTrue(1.8 < edge < 2.3, size)


if __name__ == "__main__":
    unittest.main()
