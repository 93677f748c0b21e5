// Entries for tests: grids of points, and grids that share a tree.

#include "guard.h"

#include <openvdb/io/File.h>
#include <openvdb/points/AttributeArray.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/points/PointCount.h>
#include <openvdb/points/PointDataGrid.h>

#include <string>
#include <vector>

namespace {

using openvdb::Vec3f;
using openvdb::points::AttributeHandle;
using openvdb::points::PointDataGrid;
using relievo::alone;

// Calls `add` for each point of all leaves with the handle of an attribute.
template <typename Value, typename Add>
void collect(const PointDataGrid& grid, const std::string& name, const Add& add) {
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        const AttributeHandle<Value> handle(leaf->constAttributeArray(name));
        for (auto index = leaf->beginIndexOn(); index; ++index) {
            add(handle, *index, index.getCoord());
        }
    }
}

template <typename Codec>
PointDataGrid::Ptr made(const std::vector<Vec3f>& points, const std::vector<Vec3f>& velocities, const openvdb::math::Transform& transform) {
    const openvdb::points::PointAttributeVector<Vec3f> places(points);
    const auto indices = openvdb::tools::createPointIndexGrid<openvdb::tools::PointIndexGrid>(places, transform);
    auto grid = openvdb::points::createPointDataGrid<Codec, PointDataGrid>(*indices, places, transform);
    openvdb::points::appendAttribute<Vec3f, openvdb::points::TruncateCodec>(grid->tree(), "v");
    const openvdb::points::PointAttributeVector<Vec3f> values(velocities);
    openvdb::points::populateAttribute<openvdb::points::PointDataTree, openvdb::tools::PointIndexTree,
                                       openvdb::points::PointAttributeVector<Vec3f>>(grid->tree(), indices->tree(), "v", values);
    openvdb::points::appendAttribute<float>(grid->tree(), "pscale", 0.25f);
    return grid;
}

void store(const char* path, const openvdb::GridCPtrVec& grids, std::uint32_t packing) {
    openvdb::io::File file(path);
    file.setCompression(packing);
    file.write(grids);
    file.close();
}

}  // namespace

extern "C" {

std::int32_t rlvdb_test_points_read(const char* path, const char* name, float* values, std::size_t capacity,
                                    std::size_t* count, RlvdbError* error) {
    return alone(error, [&] {
        openvdb::io::File file(path);
        file.open();
        const auto grids = file.getGrids();
        const auto grid = grids->size() == 1 ? openvdb::gridPtrCast<PointDataGrid>(grids->front()) : nullptr;
        if (!grid) {
            relievo::refuse("the file has not one grid of points");
        }
        std::size_t next = 0;
        const auto put = [&](float value) {
            if (next < capacity) {
                values[next] = value;
            }
            ++next;
        };
        const auto first = grid->tree().cbeginLeaf();
        const std::string type = first ? first->constAttributeArray(name).valueType() : "";
        if (type == "vec3s") {
            const bool is_place = std::string(name) == "P";
            collect<Vec3f>(*grid, name, [&](const auto& handle, openvdb::Index index, const openvdb::Coord& voxel) {
                openvdb::Vec3d value(handle.get(index));
                if (is_place) {
                    value = grid->indexToWorld(value + voxel.asVec3d());
                }
                for (int axis = 0; axis < 3; ++axis) {
                    put(static_cast<float>(value[axis]));
                }
            });
        } else if (type == "float") {
            collect<float>(*grid, name, [&](const auto& handle, openvdb::Index index, const openvdb::Coord&) {
                for (openvdb::Index part = 0; part < handle.stride(); ++part) {
                    put(handle.get(index, part));
                }
            });
        } else if (type == "int32") {
            collect<std::int32_t>(*grid, name, [&](const auto& handle, openvdb::Index index, const openvdb::Coord&) {
                put(static_cast<float>(handle.get(index)));
            });
        }
        *count = next;
    });
}

std::int32_t rlvdb_test_points_write(const char* path, const float* points, const float* velocities, std::size_t count,
                                     double voxel, std::int32_t is_fixed, std::uint32_t packing, RlvdbError* error) {
    return alone(error, [&] {
        std::vector<Vec3f> places, moves;
        for (std::size_t index = 0; index < count; ++index) {
            places.emplace_back(points + 3 * index);
            moves.emplace_back(velocities + 3 * index);
        }
        const auto transform = openvdb::math::Transform::createLinearTransform(voxel);
        const auto grid = is_fixed ? made<openvdb::points::FixedPointCodec<false>>(places, moves, *transform)
                                   : made<openvdb::points::NullCodec>(places, moves, *transform);
        store(path, {grid}, packing);
    });
}

std::int32_t rlvdb_test_instances_write(const char* path, const RlvdbGrid* handle, RlvdbError* error) {
    return alone(error, [&] {
        const auto first = handle->grid->copyGrid();
        const auto second = handle->grid->copyGrid();
        first->setName("first");
        second->setName("second");
        second->transform().postTranslate(openvdb::Vec3d(100.0, 0.0, 0.0));
        store(path, {first, second}, openvdb::io::COMPRESS_ZIP);
    });
}

}
