"""Lays a ring of foam over a picture: python foam.py

Needs the package librelievo and NumPy, and prints how bright the picture is before and after."""

import numpy

import librelievo

generator = numpy.random.default_rng(1)
angles = generator.uniform(0, 2 * numpy.pi, 200_000)
radii = 0.5 + 0.1 * generator.standard_normal(len(angles))
positions = numpy.column_stack([radii * numpy.cos(angles), radii * numpy.sin(angles), 0.02 * generator.random(len(angles))])

context = librelievo.Context()
water = numpy.full((180, 320, 3), (0.01, 0.05, 0.12), numpy.float32)
foam = librelievo.Foam(context, size=(320, 180), eye=(0, -1.6, 1.2), target=(0, 0, 0), radius=0.008)
foam.add(positions, ids=numpy.arange(len(positions), dtype=numpy.uint32))
foam.shade()
picture = foam.composite(water)
print(f"{len(positions)} particles, mean radiance {water.mean():.3f} before and {picture.mean():.3f} after")
