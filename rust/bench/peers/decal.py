"""Maps of patches by peers in Python, for the bench: PEER MESH RESULT PINS; prints seconds on the last line. PINS has a pin a
line: the number of a vertex and its point in the plane. The result has the points of the plane, at no height."""

import sys
import time

import numpy as np

from simplify import read, write


def slim(points, triangles, pins):
    """libigl's SLIM with soft pins: 20 iterations from a Tutte map into a circle that is moved, turned and scaled towards the pins.
    Without that, pins are still 0.7 widths off after them."""
    import igl

    points, triangles = points.astype(np.float64), triangles.astype(np.int64)
    start = time.perf_counter()
    border = igl.boundary_loop(triangles)
    uv = igl.harmonic(points, triangles, border, igl.map_vertices_to_circle(points, border), 1)
    vertices = pins[:, 0].astype(np.int64)
    circle, target = uv[vertices] @ [1, 1j], pins[:, 1:] @ [1, 1j]
    apart = circle - circle.mean()
    turn = np.vdot(apart, target - target.mean()) / np.vdot(apart, apart)
    moved = (uv @ [1, 1j] - circle.mean()) * turn + target.mean()
    uv = np.ascontiguousarray(np.column_stack([moved.real, moved.imag]))
    solver = igl.SLIM(
        points, triangles, uv, vertices[:, None], pins[:, 1:], igl.SLIM_ENERGY_TYPE_SYMMETRIC_DIRICHLET, 1e5
    )
    solver.solve(20)
    return solver.vertices(), time.perf_counter() - start


def lscm(points, triangles, pins):
    """libigl's least squares conformal map with hard pins."""
    import igl

    points, triangles = points.astype(np.float64), triangles.astype(np.int64)
    start = time.perf_counter()
    found = igl.lscm(points, triangles, pins[:, 0].astype(np.int64), np.ascontiguousarray(pins[:, 1:]))
    plane = next(part for part in found if np.ndim(part) == 2 and np.shape(part) == (len(points), 2))
    return np.asarray(plane), time.perf_counter() - start


def log_map(points, triangles, pins):
    """potpourri3d's logarithmic map around the first pin."""
    import potpourri3d

    start = time.perf_counter()
    solver = potpourri3d.MeshVectorHeatSolver(points.astype(np.float64), triangles)
    return solver.compute_log_map(int(pins[0, 0])), time.perf_counter() - start


def geodesics(points, triangles, pins):
    """Lengths of potpourri3d's geodesics by edge flips from the first pin to the others: x of their points."""
    import potpourri3d

    start = time.perf_counter()
    solver = potpourri3d.EdgeFlipGeodesicSolver(points.astype(np.float64), triangles)
    vertices = pins[:, 0].astype(np.int64)
    plane = np.zeros((len(points), 2))
    for vertex in vertices[1:]:
        path = solver.find_geodesic_path(int(vertices[0]), int(vertex))
        plane[vertex, 0] = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    return plane, time.perf_counter() - start


def flips(points, triangles, pins):
    """libigl's count of flipped triangles of a map that has all vertices as pins: x of the first point."""
    import igl

    start = time.perf_counter()
    found = igl.flipped_triangles(np.ascontiguousarray(pins[:, 1:]), triangles.astype(np.int64))
    plane = np.zeros((len(points), 2))
    plane[0, 0] = np.size(found)
    return plane, time.perf_counter() - start


name, given, made, pins = sys.argv[1:5]
points, triangles = read(given)
plane, seconds = globals()[name](points, triangles, np.loadtxt(pins, ndmin=2))
write(made, np.column_stack([plane, np.zeros(len(plane))]), triangles)
print(seconds)
