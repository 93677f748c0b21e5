// A narrow-band level set of a triangle mesh, made by openvdb::tools::meshToVolume and read by value.

#include <openvdb/Grid.h>
#include <openvdb/tools/MeshToVolume.h>

#include <cstdint>
#include <cstdio>
#include <exception>

namespace {

void tell(char* message, std::size_t size, const char* what) {
    std::snprintf(message, size, "%s", what);
}

}  // namespace

extern "C" {

// Returns a level set, or null and a message. Distances are in voxels, negative inside.
void* relievo_level_set_new(const float* points, std::size_t point_count, const std::uint32_t* triangles,
                            std::size_t triangle_count, float band, char* message, std::size_t message_size) {
    try {
        // These types are instantiated in the library, which keeps this file quick to compile; both are plain triples.
        const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> mesh(
            reinterpret_cast<const openvdb::Vec3s*>(points), point_count,
            reinterpret_cast<const openvdb::Vec3I*>(triangles), triangle_count);
        const auto transform = openvdb::math::Transform::createLinearTransform(1.0);
        openvdb::util::NullInterrupter interrupter;
        auto grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(interrupter, mesh, *transform, band, band);
        return new openvdb::FloatGrid::Ptr(std::move(grid));
    } catch (const std::exception& error) {
        tell(message, message_size, error.what());
    } catch (...) {
        tell(message, message_size, "unknown exception");
    }
    return nullptr;
}

// Reads the value at `count` voxels (x, y, z). Returns 0, or 1 and a message.
int relievo_level_set_values(const void* level_set, const std::int32_t* voxels, std::size_t count, float* values,
                             char* message, std::size_t message_size) {
    try {
        const auto& grid = *static_cast<const openvdb::FloatGrid::Ptr*>(level_set);
        auto accessor = grid->getConstAccessor();
        for (std::size_t index = 0; index < count; ++index) {
            const std::int32_t* voxel = voxels + 3 * index;
            values[index] = accessor.getValue(openvdb::Coord(voxel[0], voxel[1], voxel[2]));
        }
        return 0;
    } catch (const std::exception& error) {
        tell(message, message_size, error.what());
    } catch (...) {
        tell(message, message_size, "unknown exception");
    }
    return 1;
}

void relievo_level_set_free(void* level_set) {
    try {
        delete static_cast<openvdb::FloatGrid::Ptr*>(level_set);
    } catch (...) {
    }
}

}
