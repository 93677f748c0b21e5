"""The file that `examples/blender/demo.py` makes: every part is there after it is opened, and works on."""

import importlib.util
import sys
import unittest
from pathlib import Path

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host


class Demo(unittest.TestCase):
    def test_every_part_is_there_and_works_on(self):
        relievo = host.empty()
        place = importlib.util.spec_from_file_location("demo", host.ROOT / "examples/blender/demo.py")
        demo = importlib.util.module_from_spec(place)
        place.loader.exec_module(demo)
        with host.folder() as folder:
            path = f"{folder}/demo.blend"
            demo.build(path)
            bpy.ops.wm.open_mainfile(filepath=path)
            scene, found = bpy.context.scene, bpy.data.objects
            # The track plays from the cache, and is made again without a selection.
            snow = found["Snow"]
            depths = []
            for frame in (1, 12):
                scene.frame_set(frame)
                depths.append(int((host.evaluated(snow.relievo.result)[:, 2] < -0.05).sum()))
            self.assertGreater(depths[1], 2 * depths[0])
            self.assertRegex(snow.relievo_press.report, r"^\d+ tiles, deepest 0\.1\d*$")
            host.select(snow)
            bpy.ops.relievo.imprint_again(frame_start=1, frame_end=2)
            shell = found["Shell"]
            self.assertIn("Stripe", [row.name for row in shell.relievo_layers.rows])
            away = numpy.linalg.norm(host.positions(shell.relievo.result), axis=1)
            self.assertGreater(away.max(), 0.95)
            decal = host.positions(found["Bottle decal"])
            numpy.testing.assert_allclose(numpy.hypot(decal[:, 0], decal[:, 1]), 0.4, atol=0.02)
            water = found["Fluid domain fluid"]
            scene.frame_set(12)
            self.assertGreater(len(water.data.polygons), 500)
            self.assertLess(len(found["Hill"].data.polygons), 0.06 * 2 * 48 * 48)
            self.assertEqual(relievo.data.state.of(shell).document.info.undo_count, 3)


if __name__ == "__main__":
    host.main()
