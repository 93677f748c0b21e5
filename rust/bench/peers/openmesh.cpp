// Simplification by OpenMesh's quadrics, for the bench: MESH RESULT FACES; tells seconds.

#include <chrono>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

#include "mesh.h"

using Surface = OpenMesh::TriMesh_ArrayKernelT<>;
using Decimater = OpenMesh::Decimater::DecimaterT<Surface>;

int main(int count, char **arguments) {
    if (count != 4) fail("MESH RESULT FACES");
    Mesh mesh = read_mesh(arguments[1]);
    Surface surface;
    for (const auto &p : mesh.points) surface.add_vertex({p[0], p[1], p[2]});
    for (const auto &t : mesh.triangles) {
        const auto corner = [&](int side) { return Surface::VertexHandle(int(t[side])); };
        if (!surface.add_face(corner(0), corner(1), corner(2)).is_valid()) fail("it takes manifolds only");
    }
    const std::size_t faces = std::strtoull(arguments[3], nullptr, 10);
    const auto start = std::chrono::steady_clock::now();
    Decimater decimater(surface);
    OpenMesh::Decimater::ModQuadricT<Surface>::Handle quadrics;
    decimater.add(quadrics);
    decimater.module(quadrics).unset_max_err();
    decimater.initialize();
    decimater.decimate_to_faces(0, faces);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    surface.garbage_collection();
    Mesh made;
    for (const auto vertex : surface.vertices()) {
        const auto &p = surface.point(vertex);
        made.points.push_back({p[0], p[1], p[2]});
    }
    for (const auto face : surface.faces()) {
        std::array<std::uint32_t, 3> corners;
        std::size_t side = 0;
        for (const auto vertex : surface.fv_range(face)) corners[side++] = std::uint32_t(vertex.idx());
        made.triangles.push_back(corners);
    }
    write_mesh(arguments[2], made);
    std::printf("%.9f\n", time.count());
}
