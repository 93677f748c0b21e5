"""Repair by peers in Python, for the bench: PEER MESH RESULT; prints seconds on the last line."""

import sys
import time

import numpy as np

from simplify import read, write


def meshlib(points, triangles):
    """Equal points are welded by NumPy, since MeshLib takes indexed triangles; it leaves out the faces that do not fit, and
    fills holes."""
    from meshlib import mrmeshnumpy, mrmeshpy

    start = time.perf_counter()
    welded, inverse = np.unique(points, axis=0, return_inverse=True)
    mesh = mrmeshnumpy.meshFromFacesVerts(inverse.reshape(-1)[triangles].astype(np.int32), welded)
    settings = mrmeshpy.FillHoleParams()
    settings.metric = mrmeshpy.getUniversalMetric(mesh)
    mrmeshpy.fillHoles(mesh, mesh.topology.findHoleRepresentiveEdges(), settings)
    seconds = time.perf_counter() - start
    return (mrmeshnumpy.getNumpyVerts(mesh), mrmeshnumpy.getNumpyFaces(mesh.topology)), seconds


def pymeshlab(points, triangles):
    """MeshLab's filters in the order of ours."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points.astype(np.float64), triangles.astype(np.int32)))
    start = time.perf_counter()
    meshes.meshing_merge_close_vertices(threshold=pymeshlab.PureValue(0.0))
    meshes.meshing_remove_duplicate_faces()
    meshes.meshing_repair_non_manifold_edges()
    meshes.meshing_repair_non_manifold_vertices()
    meshes.meshing_re_orient_faces_coherently()
    meshes.meshing_close_holes(maxholesize=1000)
    seconds = time.perf_counter() - start
    made = meshes.current_mesh()
    return (made.vertex_matrix(), made.face_matrix()), seconds


name, given, made = sys.argv[1:4]
(points, faces), seconds = globals()[name](*read(given))
write(made, points, faces)
print(seconds)
