"""Simplification by peers in Python, for the bench: PEER MESH RESULT FACES; tells seconds on the last line."""

import sys
import time

import numpy as np


def read(path):
    """Points and triangles of a file as mesh.h says."""
    with open(path, "rb") as file:
        points, triangles = np.fromfile(file, np.uint32, 2)
        return (np.fromfile(file, np.float32, 3 * points).reshape(-1, 3),
                np.fromfile(file, np.uint32, 3 * triangles).reshape(-1, 3))


def write(path, points, triangles):
    """As `read` reads it."""
    with open(path, "wb") as file:
        np.array([len(points), len(triangles)], np.uint32).tofile(file)
        np.ascontiguousarray(points, np.float32).tofile(file)
        np.ascontiguousarray(triangles, np.uint32).tofile(file)


def fast_simplification(points, triangles, faces):
    """Fast-Quadric-Mesh-Simplification."""
    from fast_simplification import simplify

    start = time.perf_counter()
    made = simplify(points, triangles.astype(np.int32), target_count=faces)
    return made, time.perf_counter() - start


def blender(points, triangles, faces):
    """The Decimate modifier."""
    import bpy

    mesh = bpy.data.meshes.new("mesh")
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", points.ravel())
    mesh.loops.add(triangles.size)
    mesh.loops.foreach_set("vertex_index", triangles.ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    shape = bpy.data.objects.new("mesh", mesh)
    bpy.context.scene.collection.objects.link(shape)
    bpy.context.view_layer.update()
    decimate = shape.modifiers.new("decimate", "DECIMATE")
    decimate.ratio = faces / len(triangles)
    start = time.perf_counter()
    bpy.context.view_layer.update()
    made = shape.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    seconds = time.perf_counter() - start
    made.calc_loop_triangles()
    places = np.empty(3 * len(made.vertices), np.float32)
    made.vertices.foreach_get("co", places)
    corners = np.empty(3 * len(made.loop_triangles), np.int32)
    made.loop_triangles.foreach_get("vertices", corners)
    return (places.reshape(-1, 3), corners.reshape(-1, 3)), seconds


def main():
    peer, source, result, faces = sys.argv[1:]
    (points, triangles), seconds = globals()[peer](*read(source), int(faces))
    write(result, points, triangles)
    print(f"\n{seconds:.9f}")


if __name__ == "__main__":
    main()
