// Simplification by CGAL's memoryless edge collapses (Lindstrom, Turk 1998), for the bench: MESH RESULT FACES; tells
// seconds. CGAL is under the GPL: this program stands alone, is compiled where it is measured and never shipped.

#include <chrono>

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include "mesh.h"

namespace simplification = CGAL::Surface_mesh_simplification;
using Point = CGAL::Simple_cartesian<double>::Point_3;
using Surface = CGAL::Surface_mesh<Point>;

// Ends at a number of triangles; CGAL's own counts edges, or faces by an estimate.
struct Enough {
    const Surface &surface;
    std::size_t faces;

    template <typename Cost, typename Profile>
    bool operator()(const Cost &, const Profile &, std::size_t, std::size_t) const {
        return surface.number_of_faces() <= faces;
    }
};

int main(int count, char **arguments) {
    if (count != 4) fail("MESH RESULT FACES");
    Mesh mesh = read_mesh(arguments[1]);
    Surface surface;
    for (const auto &p : mesh.points) surface.add_vertex(Point(p[0], p[1], p[2]));
    for (const auto &t : mesh.triangles) {
        const auto corner = [&](int side) { return Surface::Vertex_index(t[side]); };
        if (surface.add_face(corner(0), corner(1), corner(2)) == Surface::null_face()) fail("it takes manifolds only");
    }
    const std::size_t faces = std::strtoull(arguments[3], nullptr, 10);
    const auto start = std::chrono::steady_clock::now();
    simplification::edge_collapse(surface, Enough{surface, faces},
                                  CGAL::parameters::get_cost(simplification::LindstromTurk_cost<Surface>())
                                      .get_placement(simplification::LindstromTurk_placement<Surface>()));
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    surface.collect_garbage();
    Mesh made;
    for (const auto vertex : surface.vertices()) {
        const Point &p = surface.point(vertex);
        made.points.push_back({float(p.x()), float(p.y()), float(p.z())});
    }
    for (const auto face : surface.faces()) {
        std::array<std::uint32_t, 3> corners;
        std::size_t side = 0;
        for (const auto vertex : surface.vertices_around_face(surface.halfedge(face))) corners[side++] = vertex;
        made.triangles.push_back(corners);
    }
    write_mesh(arguments[2], made);
    std::printf("%.9f\n", time.count());
}
