"""The wheels by themselves: nothing outside them is loaded but the C and C++ run-time libraries, beside bpy too, which brings
another Embree, OpenSubdiv and TBB. What every part needs is used: a limit surface, paint, an imprint and rays."""

import os
import re
import subprocess
import sys
import sysconfig
import unittest
from pathlib import Path

CODE = r"""
import sys
if {bpy}:
    import bpy
import numpy
import librelievo as rl
from librelievo import imprint, stroke
sys.path.append({tests!r})
import shapes
context = rl.Context()
points, corners, _ = shapes.grid(4)
detail = rl.Detail(rl.Surface(context, rl.Mesh(context, points, corners, 4)), tile_size=32)
detail.add_paint()
place = numpy.eye(4)
place[2, 3] = 0.4
ball = rl.Collider(context, rl.Mesh(context, *shapes.ball(), 3), place)
imprint.run(detail, ball, {{"voxels": 1 << 18}})
stroke.run(detail, rl.Brush(context, {{"radius": 0.3}}, color=(1, 0, 0, 1)), [(-0.5, 0.5, 0), (0.5, 0.5, 0)])
detail.commit()
hit = rl.Caster.of_detail(detail).cast([[0.01, 0.02, 1]], [[0, 0, -1]])
print("depth", hit["position"][0, 2], file=sys.stderr)
colors = detail.evaluate([5], [[0.5, 1.0]], ["colors"])["colors"]
print("painted", detail.info.painted_count, file=sys.stderr)
print(open("/proc/self/maps").read())
"""

# What every Linux has that the tag of the wheel allows.
SYSTEM = r"(ld-linux-x86-64|libc|libm|libdl|libpthread|librt|libutil|libstdc\+\+|libgcc_s|libz|libbz2|liblzma|libffi|libpython3[\w.]*|libcrypto|libssl)[-.]"


def run(bpy, **variables):
    code = CODE.format(bpy=bpy, tests=str(Path(__file__).resolve().parent))
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=os.environ | variables)


class Wheel(unittest.TestCase):
    def setUp(self):
        import librelievo

        self.folder = Path(librelievo.__file__).resolve().parents[1]
        if not list(self.folder.glob("librelievo/librelievo.so.*")):
            self.skipTest("skipped: librelievo is not installed from the wheel")

    def loaded(self, outcome):
        self.assertEqual(outcome.returncode, 0, outcome.stderr)
        depth = float(re.search(r"depth (\S+)", outcome.stderr)[1])
        self.assertAlmostEqual(depth, -0.1, delta=0.02)
        self.assertGreater(int(re.search(r"painted (\d+)", outcome.stderr)[1]), 0)
        return set(re.findall(r"(/\S+\.so[\w.]*)$", outcome.stdout, flags=re.M))

    def test_nothing_of_the_system_is_needed(self):
        outcome = run(False)
        loaded = self.loaded(outcome)
        own = {path for path in loaded if path.startswith(str(self.folder))}
        names = " ".join(own)
        for part in ("librelievo.so", "libembree3-relievo.so", "libtbb-"):
            self.assertIn(part, names)
        # OpenSubdiv is part of the library and is opened from memory.
        self.assertIn("/memfd:relievo-opensubdiv", outcome.stdout)
        # It is opened when a hole is filled.
        self.assertTrue((self.folder / "librelievo/libOpenMeshCore-relievo.so").is_file())
        python = (sys.prefix, sys.base_prefix)
        foreign = [path for path in loaded - own if not path.startswith(python)]
        foreign = [path for path in foreign if not re.match(SYSTEM, Path(path).name)]
        self.assertEqual(foreign, [])

    def test_bpy_keeps_its_libraries_and_we_keep_ours(self):
        try:
            import bpy  # noqa: F401
        except ImportError:
            self.skipTest("skipped: there is no bpy")
        loaded = self.loaded(run(True))
        for part in ("embree", "tbb"):
            folders = {Path(path).parent for path in loaded if part in Path(path).name}
            self.assertEqual(len(folders), 2, (part, folders))
            self.assertFalse([folder for folder in folders if str(folder).startswith(("/lib", "/usr/lib"))])

    def test_the_embree_that_bpy_carries_is_enough(self):
        """As in Blender's extension, which brings none."""
        try:
            import bpy  # noqa: F401
        except ImportError:
            self.skipTest("skipped: there is no bpy")
        loaded = self.loaded(run(True, RELIEVO_EMBREE="libembree4.so.4"))
        carried = Path(sysconfig.get_path("platlib")).resolve() / "bpy/lib"
        for part in ("embree", "tbb"):
            files = [Path(path).resolve() for path in loaded if part in Path(path).name]
            self.assertTrue(files)
            self.assertTrue(all(file.is_relative_to(carried) for file in files), files)

    def test_type_checkers_find_the_hints(self):
        self.assertTrue((self.folder / "librelievo" / "py.typed").exists())

    def test_licences_are_there(self):
        found = {path.name for path in self.folder.glob("librelievo*.dist-info/**/*")}
        for name in ("LICENSE-MIT", "LICENSE-APACHE", "libosdcpu3.5.0", "libembree3-3", "libopenmesh1", "libtbb12"):
            self.assertIn(name, found)


if __name__ == "__main__":
    unittest.main()
