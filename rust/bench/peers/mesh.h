// Meshes as the bench hands them to programs of peers: numbers of vertices and of triangles in 32 bits, places in f32,
// corners in 32 bits.
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

struct Mesh {
    std::vector<std::array<float, 3>> points;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

[[noreturn]] inline void fail(const char *reason) {
    std::fprintf(stderr, "%s\n", reason);
    std::exit(1);
}

inline Mesh read_mesh(const char *path) {
    std::FILE *file = std::fopen(path, "rb");
    std::uint32_t counts[2];
    if (!file || std::fread(counts, sizeof counts, 1, file) != 1) fail("the mesh cannot be read");
    Mesh mesh{std::vector<std::array<float, 3>>(counts[0]), std::vector<std::array<std::uint32_t, 3>>(counts[1])};
    if (std::fread(mesh.points.data(), 12, counts[0], file) != counts[0] ||
        std::fread(mesh.triangles.data(), 12, counts[1], file) != counts[1])
        fail("the mesh ends too early");
    std::fclose(file);
    return mesh;
}

inline void write_mesh(const char *path, const Mesh &mesh) {
    std::FILE *file = std::fopen(path, "wb");
    const std::uint32_t counts[2] = {std::uint32_t(mesh.points.size()), std::uint32_t(mesh.triangles.size())};
    if (!file || std::fwrite(counts, sizeof counts, 1, file) != 1 ||
        std::fwrite(mesh.points.data(), 12, counts[0], file) != counts[0] ||
        std::fwrite(mesh.triangles.data(), 12, counts[1], file) != counts[1] || std::fclose(file) != 0)
        fail("the mesh cannot be written");
}
