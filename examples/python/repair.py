"""Tears a ball into triangles of random sense, with a hole, and repairs it.

    python repair.py OUT.ply
"""

import sys

import numpy

import librelievo
from librelievo import repair

RINGS, SEGMENTS = 24, 48

polar = numpy.linspace(0.0, numpy.pi, RINGS + 1)[:, None]
turn = numpy.linspace(0.0, 2.0 * numpy.pi, SEGMENTS, endpoint=False)[None, :]
sines = numpy.sin(polar)
sines[-1] = 0.0
points = numpy.stack(numpy.broadcast_arrays(sines * numpy.cos(turn), sines * numpy.sin(turn), numpy.cos(polar)), -1)
points = points.reshape(-1, 3).astype(numpy.float32)
ring, segment = numpy.divmod(numpy.arange(RINGS * SEGMENTS), SEGMENTS)
after = (segment + 1) % SEGMENTS
a, b = ring * SEGMENTS + segment, (ring + 1) * SEGMENTS + segment
c, d = (ring + 1) * SEGMENTS + after, ring * SEGMENTS + after
triangles = numpy.concatenate([numpy.stack([a, b, c], 1), numpy.stack([a, c, d], 1)])
triangles = triangles[numpy.tile(ring >= 4, 2)]

random = numpy.random.default_rng(1)
turned = random.random(len(triangles)) < 0.3
triangles[turned] = triangles[turned][:, ::-1]
soup = points[triangles].reshape(-1, 3)

context = librelievo.Context()
mesh, report = repair.arrays(context, soup, numpy.arange(len(soup)), 3)
mesh.write(sys.argv[1])
print(f"{report.turned_faces} faces turned over, {report.filled_holes} hole filled with {report.filling_points} points")
print(f"volume {report.after.volume:.3f}, {4.0 / 3.0 * numpy.pi:.3f} of a ball")
