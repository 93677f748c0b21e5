"""Makes spray and foam where two blocks of water meet, frame by frame: python spray.py

Needs the package librelievo and NumPy, and prints how many particles of each kind there are after every frame."""

import numpy

import librelievo

SPACING, FPS = 0.02, 24
grid = SPACING * numpy.stack(numpy.meshgrid(*[numpy.arange(16)] * 3, indexing="ij"), -1).reshape(-1, 3)
points = numpy.vstack([grid - (16 * SPACING, 0, 0), grid])
velocities = numpy.repeat([(3.0, 0, 0), (-3.0, 0, 0)], len(grid), 0)

context = librelievo.Context()
with librelievo.Fluid(context, spacing=SPACING) as fluid, librelievo.Diffuse(context, SPACING, energy_min=2, air_min=2) as foam:
    fluid.add(points, velocities)
    for frame in range(1, 7):
        fluid.advance(1 / FPS)
        found = fluid.get("points", "velocities")
        foam.advance(found["points"], found["velocities"], 1 / FPS)
        counts = numpy.bincount(foam.get("kinds")["kinds"], minlength=3)
        print(f"frame {frame}: {counts[0]} of spray, {counts[1]} of foam, {counts[2]} bubbles")
