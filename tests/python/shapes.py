"""Meshes that tests are made with, as arrays."""

import numpy


def grid(cells, size=2.0, z=0.0):
    """A flat square of quads around the origin: points, corners and texture coordinates of the points."""
    steps = numpy.linspace(0.0, 1.0, cells + 1)
    u, v = (axis.ravel() for axis in numpy.meshgrid(steps, steps))
    points = numpy.stack([(u - 0.5) * size, (v - 0.5) * size, numpy.full(u.shape, z)], 1).astype(numpy.float32)
    first = (numpy.arange(cells)[:, None] * (cells + 1) + numpy.arange(cells)).ravel()
    corners = numpy.stack([first, first + 1, first + cells + 2, first + cells + 1], 1).astype(numpy.uint32)
    return points, corners.ravel(), numpy.stack([u, v], 1).astype(numpy.float32)


def ball(radius=0.5, center=(0, 0, 0), rings=24):
    """A closed ball of triangles: points and corners."""
    around = 2 * rings
    theta = numpy.linspace(0, numpy.pi, rings + 1)[1:-1]
    phi = numpy.arange(around) * (2 * numpy.pi / around)
    ring = numpy.stack([numpy.cos(phi), numpy.sin(phi), numpy.zeros(around)], 1)
    points = [[0, 0, 1]]
    for angle in theta:
        points.extend(ring * numpy.sin(angle) + [0, 0, numpy.cos(angle)])
    points.append([0, 0, -1])
    faces = []
    for k in range(around):
        n = (k + 1) % around
        faces.append((0, 1 + k, 1 + n))
        for r in range(rings - 2):
            a, b = 1 + r * around, 1 + (r + 1) * around
            faces += [(a + k, b + k, b + n), (a + k, b + n, a + n)]
        last = 1 + (rings - 2) * around
        faces.append((last + k, len(points) - 1, last + n))
    points = numpy.array(points, numpy.float32) * radius + numpy.array(center, numpy.float32)
    return points.astype(numpy.float32), numpy.array(faces, numpy.uint32).ravel()


def cube():
    """A cube of six quads from -1 to 1."""
    points = numpy.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], numpy.float32)
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return points, numpy.array(faces, numpy.uint32).ravel()
