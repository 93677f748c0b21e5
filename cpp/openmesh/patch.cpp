#include "patch.h"

#include <stdexcept>
#include <string>
#include <vector>

#include "openmesh.h"

namespace relievo::openmesh {

namespace {

struct Traits : OpenMesh::DefaultTraits {
    VertexAttributes(OpenMesh::Attributes::Status);
    HalfedgeAttributes(OpenMesh::Attributes::PrevHalfedge);
    EdgeAttributes(OpenMesh::Attributes::Status);
    FaceAttributes(OpenMesh::Attributes::Status);
};

using Mesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;
using Vertex = OpenMesh::VertexHandle;
using Face = OpenMesh::FaceHandle;
using Edge = OpenMesh::EdgeHandle;
using Halfedge = OpenMesh::HalfedgeHandle;

constexpr std::uint32_t none = 0xffffffffu;

[[noreturn]] void fail(const std::string &what) { throw std::invalid_argument(what); }

std::string name(Vertex from, Vertex to) {
    return "edge " + std::to_string(from.idx()) + "-" + std::to_string(to.idx());
}

Mesh::Point point(rust::Slice<const float> points, std::size_t index) {
    return {points[3 * index], points[3 * index + 1], points[3 * index + 2]};
}

} // namespace

struct Patch::Data {
    Mesh mesh;

    Vertex vertex(std::uint32_t number) const {
        const Vertex found(static_cast<int>(number));
        if (number >= mesh.n_vertices() || mesh.status(found).deleted()) {
            fail("there is no vertex " + std::to_string(number));
        }
        return found;
    }

    Face face(std::uint32_t number) const {
        const Face found(static_cast<int>(number));
        if (number >= mesh.n_faces() || mesh.status(found).deleted()) {
            fail("there is no face " + std::to_string(number));
        }
        return found;
    }

    // The half-edge from one vertex to another; invalid where there is none.
    Halfedge halfedge(rust::Slice<const std::uint32_t> edges, std::size_t index) const {
        return mesh.find_halfedge(vertex(edges[2 * index]), vertex(edges[2 * index + 1]));
    }

    // Whether an edge belongs to a tetrahedron, which OpenMesh would collapse to a face that is there twice.
    bool is_of_tetrahedron(Halfedge half) const {
        const Halfedge other = mesh.opposite_halfedge_handle(half);
        const std::uint32_t left = opposite(half), right = opposite(other);
        if (left == none || right == none) {
            return false;
        }
        const Halfedge across =
            mesh.find_halfedge(Vertex(static_cast<int>(left)), Vertex(static_cast<int>(right)));
        if (!across.is_valid()) {
            return false;
        }
        const auto from = static_cast<std::uint32_t>(mesh.from_vertex_handle(half).idx());
        const auto to = static_cast<std::uint32_t>(mesh.to_vertex_handle(half).idx());
        const std::uint32_t one = opposite(across), two = opposite(mesh.opposite_halfedge_handle(across));
        return (one == from && two == to) || (one == to && two == from);
    }

    // The vertex opposite to a half-edge in its triangle; `none` at the boundary.
    std::uint32_t opposite(Halfedge half) const {
        if (mesh.is_boundary(half)) {
            return none;
        }
        return static_cast<std::uint32_t>(mesh.to_vertex_handle(mesh.next_halfedge_handle(half)).idx());
    }
};

Patch::Patch() : data(std::make_unique<Data>()) {}
Patch::Patch(const Patch &other) : data(std::make_unique<Data>(*other.data)) {}
Patch::~Patch() = default;

std::unique_ptr<Patch> new_patch() { return std::make_unique<Patch>(); }

std::unique_ptr<Patch> Patch::copy() const { return std::make_unique<Patch>(*this); }

std::size_t Patch::vertex_count() const { return data->mesh.n_vertices(); }

std::size_t Patch::face_count() const { return data->mesh.n_faces(); }

void Patch::add_vertices(rust::Slice<const float> points) {
    const std::size_t count = points.size() / 3, before = data->mesh.n_vertices();
    data->mesh.reserve(before + count, 3 * (before + count), 2 * (before + count));
    for (std::size_t index = 0; index < count; ++index) {
        data->mesh.add_vertex(point(points, index));
    }
}

void Patch::add_faces(rust::Slice<const std::uint32_t> triangles, rust::Vec<std::uint32_t> &made) {
    auto &mesh = data->mesh;
    for (std::size_t index = 0; index < triangles.size() / 3; ++index) {
        Vertex corners[3];
        for (int corner = 0; corner < 3; ++corner) {
            corners[corner] = data->vertex(triangles[3 * index + corner]);
        }
        // Where OpenMesh would refuse with a line on stderr, it is not asked.
        for (int corner = 0; corner < 3; ++corner) {
            const Vertex from = corners[corner], to = corners[(corner + 1) % 3];
            const Halfedge half = mesh.find_halfedge(from, to);
            if (from == to || !mesh.is_boundary(from) || (half.is_valid() && !mesh.is_boundary(half))) {
                fail("triangle " + std::to_string(index) + " does not fit at " + name(from, to));
            }
        }
        const Face face = mesh.add_face(corners, 3);
        if (!face.is_valid()) {
            fail("triangle " + std::to_string(index) + " does not fit its neighbours");
        }
        made.push_back(static_cast<std::uint32_t>(face.idx()));
    }
}

void Patch::points(rust::Slice<const std::uint32_t> vertices, rust::Slice<float> out) const {
    for (std::size_t index = 0; index < vertices.size(); ++index) {
        const auto place = data->mesh.point(data->vertex(vertices[index]));
        for (int axis = 0; axis < 3; ++axis) {
            out[3 * index + axis] = place[axis];
        }
    }
}

void Patch::set_points(rust::Slice<const std::uint32_t> vertices, rust::Slice<const float> points) {
    for (std::size_t index = 0; index < vertices.size(); ++index) {
        data->mesh.set_point(data->vertex(vertices[index]), point(points, index));
    }
}

std::size_t Patch::edges(rust::Slice<std::uint32_t> out) const {
    const auto &mesh = data->mesh;
    std::size_t count = 0;
    for (std::size_t index = 0; index < mesh.n_edges(); ++index) {
        const Edge edge(static_cast<int>(index));
        if (mesh.status(edge).deleted()) {
            continue;
        }
        if (out.size() < 4 * (count + 1)) {
            fail("there is no room for all edges");
        }
        const Halfedge half = mesh.halfedge_handle(edge, 0);
        std::uint32_t *numbers = out.data() + 4 * count++;
        numbers[0] = static_cast<std::uint32_t>(mesh.from_vertex_handle(half).idx());
        numbers[1] = static_cast<std::uint32_t>(mesh.to_vertex_handle(half).idx());
        numbers[2] = data->opposite(half);
        numbers[3] = data->opposite(mesh.opposite_halfedge_handle(half));
    }
    return count;
}

std::size_t Patch::edge_slots() const noexcept { return data->mesh.n_edges(); }

void Patch::split_edges(rust::Slice<const std::uint32_t> edges, rust::Slice<const float> points,
                        rust::Vec<std::uint32_t> &made) {
    auto &mesh = data->mesh;
    for (std::size_t index = 0; index < edges.size() / 2; ++index) {
        const Halfedge half = data->halfedge(edges, index);
        if (!half.is_valid()) {
            fail("there is no " + name(data->vertex(edges[2 * index]), data->vertex(edges[2 * index + 1])));
        }
        const Vertex vertex = mesh.add_vertex(point(points, index));
        mesh.split(mesh.edge_handle(half), vertex);
        made.push_back(static_cast<std::uint32_t>(vertex.idx()));
    }
}

void Patch::split_faces(rust::Slice<const std::uint32_t> faces, rust::Slice<const float> points,
                        rust::Vec<std::uint32_t> &made) {
    auto &mesh = data->mesh;
    for (std::size_t index = 0; index < faces.size(); ++index) {
        const Face face = data->face(faces[index]);
        const Vertex vertex = mesh.add_vertex(point(points, index));
        mesh.split(face, vertex);
        made.push_back(static_cast<std::uint32_t>(vertex.idx()));
    }
}

void Patch::flip_edges(rust::Slice<const std::uint32_t> edges, rust::Slice<std::uint8_t> done) {
    auto &mesh = data->mesh;
    for (std::size_t index = 0; index < done.size(); ++index) {
        const Halfedge half = data->halfedge(edges, index);
        const bool may = half.is_valid() && mesh.is_flip_ok(mesh.edge_handle(half));
        if (may) {
            mesh.flip(mesh.edge_handle(half));
        }
        done[index] = may ? 1 : 0;
    }
}

void Patch::collapse_edges(rust::Slice<const std::uint32_t> edges, rust::Slice<std::uint8_t> done) {
    auto &mesh = data->mesh;
    for (std::size_t index = 0; index < done.size(); ++index) {
        const std::uint32_t from = edges[2 * index], to = edges[2 * index + 1];
        // An earlier collapse of the batch may have taken the edge or a vertex of it.
        const bool is_left = from < mesh.n_vertices() && to < mesh.n_vertices() &&
                             !mesh.status(Vertex(static_cast<int>(from))).deleted() &&
                             !mesh.status(Vertex(static_cast<int>(to))).deleted();
        const Halfedge half = is_left ? data->halfedge(edges, index) : Halfedge();
        const bool may = half.is_valid() && mesh.is_collapse_ok(half) && !data->is_of_tetrahedron(half);
        if (may) {
            mesh.collapse(half);
        }
        done[index] = may ? 1 : 0;
    }
}

void Patch::remove_faces(rust::Slice<const std::uint32_t> faces) {
    for (const std::uint32_t number : faces) {
        data->mesh.delete_face(data->face(number), false);
    }
}

void Patch::boundary_loops(rust::Vec<std::uint32_t> &sizes, rust::Vec<std::uint32_t> &vertices) const {
    const auto &mesh = data->mesh;
    std::vector<bool> seen(mesh.n_halfedges(), false);
    for (std::size_t index = 0; index < mesh.n_halfedges(); ++index) {
        const Halfedge first(static_cast<int>(index));
        if (seen[index] || mesh.status(mesh.edge_handle(first)).deleted() || !mesh.is_boundary(first)) {
            continue;
        }
        std::uint32_t size = 0;
        Halfedge half = first;
        do {
            seen[static_cast<std::size_t>(half.idx())] = true;
            vertices.push_back(static_cast<std::uint32_t>(mesh.from_vertex_handle(half).idx()));
            ++size;
            half = mesh.next_halfedge_handle(half);
        } while (half != first);
        sizes.push_back(size);
    }
}

std::size_t Patch::components() const {
    const auto &mesh = data->mesh;
    std::vector<bool> seen(mesh.n_faces(), false);
    std::vector<Face> open;
    std::size_t count = 0;
    for (std::size_t index = 0; index < mesh.n_faces(); ++index) {
        const Face first(static_cast<int>(index));
        if (seen[index] || mesh.status(first).deleted()) {
            continue;
        }
        ++count;
        seen[index] = true;
        open.push_back(first);
        while (!open.empty()) {
            Halfedge half = mesh.halfedge_handle(open.back());
            open.pop_back();
            for (int side = 0; side < 3; ++side, half = mesh.next_halfedge_handle(half)) {
                const Face other = mesh.face_handle(mesh.opposite_halfedge_handle(half));
                if (other.is_valid() && !seen[static_cast<std::size_t>(other.idx())]) {
                    seen[static_cast<std::size_t>(other.idx())] = true;
                    open.push_back(other);
                }
            }
        }
    }
    return count;
}

std::int64_t Patch::euler_number() const {
    const auto &mesh = data->mesh;
    std::int64_t number = 0;
    for (std::size_t index = 0; index < mesh.n_vertices(); ++index) {
        const Vertex vertex(static_cast<int>(index));
        number += !mesh.status(vertex).deleted() && !mesh.is_isolated(vertex);
    }
    for (std::size_t index = 0; index < mesh.n_edges(); ++index) {
        number -= !mesh.status(Edge(static_cast<int>(index))).deleted();
    }
    for (std::size_t index = 0; index < mesh.n_faces(); ++index) {
        number += !mesh.status(Face(static_cast<int>(index))).deleted();
    }
    return number;
}

void Patch::read(rust::Vec<float> &points, rust::Vec<std::uint32_t> &triangles, rust::Vec<std::uint32_t> &old_vertices,
                 rust::Vec<std::uint32_t> &old_faces) const {
    const auto &mesh = data->mesh;
    std::vector<std::uint32_t> numbers(mesh.n_vertices(), none);
    for (std::size_t index = 0; index < mesh.n_vertices(); ++index) {
        const Vertex vertex(static_cast<int>(index));
        if (mesh.status(vertex).deleted() || mesh.is_isolated(vertex)) {
            continue;
        }
        numbers[index] = static_cast<std::uint32_t>(old_vertices.size());
        old_vertices.push_back(static_cast<std::uint32_t>(index));
        for (int axis = 0; axis < 3; ++axis) {
            points.push_back(mesh.point(vertex)[axis]);
        }
    }
    for (std::size_t index = 0; index < mesh.n_faces(); ++index) {
        const Face face(static_cast<int>(index));
        if (mesh.status(face).deleted()) {
            continue;
        }
        old_faces.push_back(static_cast<std::uint32_t>(index));
        Halfedge half = mesh.halfedge_handle(face);
        for (int corner = 0; corner < 3; ++corner, half = mesh.next_halfedge_handle(half)) {
            const auto vertex = static_cast<std::size_t>(mesh.from_vertex_handle(half).idx());
            triangles.push_back(numbers[vertex]);
        }
    }
}

} // namespace relievo::openmesh
