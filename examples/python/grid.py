"""Cuts a ball out of a block of fog made with NumPy, writes it as an OpenVDB file, and meshes where the fog is half as dense.

    PYTHONPATH=plugins/python python3 examples/python/grid.py FOLDER
"""

import sys
from pathlib import Path

import librelievo as rl
import numpy

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
context = rl.Context()
x, y, z = numpy.mgrid[-24:24, -24:24, -24:24] / 24
density = numpy.clip(8 * (numpy.sqrt(x**2 + y**2 + z**2) - 0.7), 0, 1).astype("f4")
fog = rl.Grid(context, "float", voxel=1 / 24)
fog.set_class("fog")
fog.set_name("density")
fog.set_block((-24, -24, -24), density)
fog.write(folder / "fog.vdb")
for about in rl.grid.info(context, folder / "fog.vdb"):
    print(f"{about.name}: {about.active_voxels} active voxels, at most {about.memory_bytes >> 20} MiB")
read = rl.Grid.read(context, folder / "fog.vdb", "density")
print("in the middle {:.1f}, at a corner {:.1f}".format(*read.sample([(0, 0, 0), (0.9, 0.9, 0.9)])))
mesh = read.mesh(value=0.5)
mesh.write(folder / "fog.ply")
print(f"{mesh.info.face_count} faces")
