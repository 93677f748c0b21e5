"""A block of water falls into a basin; writes a mesh of the surface of some frames, with velocities for motion blur.

    PYTHONPATH=plugins/python python3 examples/python/dam.py FOLDER
"""

import sys
from pathlib import Path

import librelievo as rl
import numpy

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
fluid = rl.Fluid(rl.Context(), spacing=0.04)
fluid.set_basin((0, 0, 0), (1.2, 0.24, 0.8))
fluid.add_box((0, 0, 0), (0.4, 0.24, 0.48))
for frame in range(1, 13):
    report = fluid.advance(1 / 24)
    points = fluid.get("points")["points"]
    print(f"frame {frame}: {report.steps} steps, the front is at {points[:, 0].max():.2f} m")
    if frame % 4 == 0:
        surface = fluid.isosurface(function="zhu_bridson", radius=0.02)
        mesh = surface.mesh(iterations=4)
        mesh.write(folder / f"dam_{frame:02}.ply")
        speed = numpy.linalg.norm(mesh.attribute("velocity").values, axis=1).max()
        print(f"{mesh.info.triangle_count} triangles, the fastest at {speed:.2f} m/s")
hits = surface.cast([(0.1, 0.12, 2.0), (1.1, 0.12, 2.0)], [(0, 0, -1)] * 2)
print("the water is {:.2f} m high on the left and {:.2f} m on the right".format(*hits["position"][:, 2]))
