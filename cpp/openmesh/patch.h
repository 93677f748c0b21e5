// Triangle patches on OpenMesh's half-edge structure. Vertices and faces keep their numbers until a patch is compacted;
// edges are given by the numbers of their two vertices. Every call works on a batch.
#pragma once

#include <cstdint>
#include <memory>

#include <rust/cxx.h>

#include "../exceptions.h"

namespace relievo::openmesh {

class Patch {
public:
    Patch();
    Patch(const Patch &other);
    ~Patch();

    std::size_t vertex_count() const;
    std::size_t face_count() const;
    std::unique_ptr<Patch> copy() const;
    void add_vertices(rust::Slice<const float> points);
    void add_faces(rust::Slice<const std::uint32_t> triangles, rust::Vec<std::uint32_t> &made);
    void points(rust::Slice<const std::uint32_t> vertices, rust::Slice<float> out) const;
    void set_points(rust::Slice<const std::uint32_t> vertices, rust::Slice<const float> points);
    std::size_t edges(rust::Slice<std::uint32_t> out) const;
    std::size_t edge_slots() const noexcept;
    void split_edges(rust::Slice<const std::uint32_t> edges, rust::Slice<const float> points,
                     rust::Vec<std::uint32_t> &made);
    void split_faces(rust::Slice<const std::uint32_t> faces, rust::Slice<const float> points,
                     rust::Vec<std::uint32_t> &made);
    void flip_edges(rust::Slice<const std::uint32_t> edges, rust::Slice<std::uint8_t> done);
    void collapse_edges(rust::Slice<const std::uint32_t> edges, rust::Slice<std::uint8_t> done);
    void remove_faces(rust::Slice<const std::uint32_t> faces);
    void boundary_loops(rust::Vec<std::uint32_t> &sizes, rust::Vec<std::uint32_t> &vertices) const;
    std::size_t components() const;
    std::int64_t euler_number() const;
    void read(rust::Vec<float> &points, rust::Vec<std::uint32_t> &triangles, rust::Vec<std::uint32_t> &old_vertices,
              rust::Vec<std::uint32_t> &old_faces) const;

private:
    struct Data;
    std::unique_ptr<Data> data;
};

std::unique_ptr<Patch> new_patch();

} // namespace relievo::openmesh
