"""A muscle in a block of gel contracts; writes a mesh of the surface of each frame.

    PYTHONPATH=plugins/python python3 examples/python/tissue.py FOLDER
"""

import sys
from pathlib import Path

import librelievo as rl
import numpy

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
context = rl.Context()
size = (0.16, 0.08, 0.08)
points = [[size[axis] * (corner >> axis & 1) for axis in range(3)] for corner in range(8)]
faces = [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6]
block = rl.Mesh(context, points, faces, 4)

# Rings of control points along the muscle, which is thick in the middle.
angles = numpy.linspace(0, 2 * numpy.pi, 12, endpoint=False)
along = numpy.linspace(0.02, 0.14, 5)
radii = 0.008 + 0.016 * numpy.sin(numpy.linspace(0, numpy.pi, 5))
circle = numpy.stack([numpy.cos(angles), numpy.sin(angles)], 1)
rings = [numpy.column_stack([numpy.full(12, x), 0.04 + radius * circle]) for x, radius in zip(along, radii)]

tissue = rl.Tissue(
    context,
    cell=0.005,
    materials=[{"name": "gel", "young": 8000, "poisson": 0.45}, {"name": "flesh", "library": "muscle"}],
    volumes=[
        {"name": "block", "mesh": block},
        {"name": "biceps", "level": 1, "material": "flesh", "is_muscle": True, "strength": 3e5, "rings": rings},
    ],
)
skin = tissue.bind("skin", block.split(0.003))
tissue.hold(tissue.set("x-"))
print(f"{tissue.info.element_count} elements")

simulation = tissue.simulate(gravity=(0, 0, 0), damping=20, halvings=4)
simulation.activate(tissue.find_muscle("biceps"), [(0, 0.0), (0.05, 0.8)])
for frame in range(1, 6):
    simulation.advance(0.02)
    stretches = simulation.get("fibre_stretches")["fibre_stretches"]
    simulation.mesh(skin).write(folder / f"biceps_{frame:02}.ply")
    print(f"frame {frame}: the muscle is as short as {stretches.min():.2f} of its length")
