// A narrow-band level set, made of a triangle mesh by openvdb::tools::meshToVolume or read from a file, and read by value.

#include "guard.h"

#include <openvdb/Grid.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/MeshToVolume.h>

using relievo::guarded, relievo::store, relievo::tell;

extern "C" {

// Returns a level set, or null and a message. Distances are in voxels, negative inside.
void* relievo_level_set_new(const float* points, std::size_t point_count, const std::uint32_t* triangles,
                            std::size_t triangle_count, float band, char* message, std::size_t message_size) {
    return guarded<void*>(nullptr, message, message_size, [&]() -> void* {
        // These types are instantiated in the library, which keeps this file quick to compile; both are plain triples.
        const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> mesh(
            reinterpret_cast<const openvdb::Vec3s*>(points), point_count,
            reinterpret_cast<const openvdb::Vec3I*>(triangles), triangle_count);
        const auto transform = openvdb::math::Transform::createLinearTransform(1.0);
        openvdb::util::NullInterrupter interrupter;
        auto grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(interrupter, mesh, *transform, band, band);
        return new openvdb::FloatGrid::Ptr(std::move(grid));
    });
}

// Returns the only grid of a file, of floats, or null and a message.
void* relievo_level_set_read(const char* path, char* message, std::size_t message_size) {
    return guarded<void*>(nullptr, message, message_size, [&]() -> void* {
        openvdb::initialize();
        openvdb::io::File file(path);
        file.open();
        const auto grids = file.getGrids();
        auto grid = grids->size() == 1 ? openvdb::gridPtrCast<openvdb::FloatGrid>(grids->front()) : nullptr;
        if (grid) {
            return new openvdb::FloatGrid::Ptr(std::move(grid));
        }
        tell(message, message_size, "the file has not one grid of floats");
        return nullptr;
    });
}

// Writes the size of a voxel, the value where nothing is said, how many voxels are active, and 1 if the grid is said to be
// a level set. Returns 0, or 1 and a message.
int relievo_level_set_facts(const void* level_set, double* facts, char* message, std::size_t message_size) {
    return guarded(1, message, message_size, [&] {
        const auto& grid = *static_cast<const openvdb::FloatGrid::Ptr*>(level_set);
        facts[0] = grid->voxelSize()[0];
        facts[1] = grid->background();
        facts[2] = static_cast<double>(grid->activeVoxelCount());
        facts[3] = grid->getGridClass() == openvdb::GRID_LEVEL_SET && grid->hasUniformVoxels() ? 1.0 : 0.0;
        return 0;
    });
}

// Reads the value at `count` voxels (x, y, z). Returns 0, or 1 and a message.
int relievo_level_set_values(const void* level_set, const std::int32_t* voxels, std::size_t count, float* values,
                             char* message, std::size_t message_size) {
    return guarded(1, message, message_size, [&] {
        const auto& grid = *static_cast<const openvdb::FloatGrid::Ptr*>(level_set);
        auto accessor = grid->getConstAccessor();
        for (std::size_t index = 0; index < count; ++index) {
            const std::int32_t* voxel = voxels + 3 * index;
            values[index] = accessor.getValue(openvdb::Coord(voxel[0], voxel[1], voxel[2]));
        }
        return 0;
    });
}

// Writes a grid of a voxel size and an origin, packed as OpenVDB is told to, maybe in half floats, and as fog if asked for. Returns 0, or
// 1 and a message.
int relievo_level_set_write(const void* level_set, const char* path, double voxel, const double* origin, std::uint32_t packing,
                            int is_half, int is_fog, char* message, std::size_t message_size) {
    return guarded(1, message, message_size, [&] {
        openvdb::initialize();
        const auto& source = *static_cast<const openvdb::FloatGrid::Ptr*>(level_set);
        const auto grid = source->deepCopy();
        if (is_fog) {
            openvdb::tools::sdfToFogVolume(*grid);
        }
        const auto transform = openvdb::math::Transform::createLinearTransform(voxel);
        transform->postTranslate(openvdb::Vec3d(origin));
        grid->setTransform(transform);
        grid->setSaveFloatAsHalf(is_half != 0);
        grid->setName("cloud");
        store(path, grid, packing);
        return 0;
    });
}

void relievo_level_set_free(void* level_set) {
    try {
        delete static_cast<openvdb::FloatGrid::Ptr*>(level_set);
    } catch (...) {
    }
}

}
