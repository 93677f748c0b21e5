"""Builds a progressive mesh of a ball with ripples, bends it at a coarse level, and writes three of its levels.

    PYTHONPATH=plugins/python python3 examples/python/levels.py FOLDER
"""

import sys
from pathlib import Path

import librelievo as rl
import numpy


def rippled(rings=96):
    """Points and corners of a ball of triangles without its poles."""
    around = 2 * rings
    theta, phi = numpy.meshgrid(numpy.linspace(0.1, numpy.pi - 0.1, rings), numpy.arange(around) * numpy.pi / rings, indexing="ij")
    radius = 1 + 0.02 * numpy.sin(40 * theta) * numpy.sin(20 * phi)
    points = numpy.stack([radius * numpy.sin(theta) * numpy.cos(phi), radius * numpy.sin(theta) * numpy.sin(phi), radius * numpy.cos(theta)], 2)
    a = numpy.arange((rings - 1) * around)
    b = a // around * around + (a + 1) % around
    corners = numpy.stack([a, a + around, b + around, a, b + around, b], 1)
    return points.reshape(-1, 3), corners.ravel()


folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
context = rl.Context()
mesh = rl.Mesh(context, *rippled(), 3)
fewer, deviation = mesh.simplify(triangles=4000)
print(f"simplified to {fewer.info.face_count} triangles, at most {deviation:.4f} away")
whole = rl.Progressive(mesh)
level = rl.Level(whole)
level.set_triangles(400)
bend = rl.Grip(rl.Region((0, 0, 1), 1.2), translation=(0.4, 0, 0.3), axis=(0, 1, 0), angle=0.8)
reached = level.edit([bend], anchors=[rl.Region((0, 0, -1), 0.5)])
print(f"moved {reached} of {level.info.vertex_count} vertices")
for triangles in (400, 4000, None):
    level.set_triangles(triangles)
    update = level.update()
    print(f"{update.triangle_count} triangles, {update.changed_triangle_count} of them in the range that changed")
    level.mesh().write(folder / f"level_{update.triangle_count}.obj")
