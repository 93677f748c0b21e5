// Grids in memory: making, copying, facts, transforms and metadata.

#include "guard.h"

#include <openvdb/math/Maps.h>
#include <openvdb/math/Transform.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>

// Present where OpenVDB was built with log4cplus, as Debian's is; its headers need not be installed.
namespace log4cplus {
__attribute__((weak)) void deinitialize();
}

namespace {

using namespace openvdb;
using relievo::alone, relievo::guarded, relievo::refuse;


GridClass class_of(std::int32_t number) {
    switch (number) {
        case RLVDB_UNKNOWN: return GRID_UNKNOWN;
        case RLVDB_LEVEL_SET: return GRID_LEVEL_SET;
        case RLVDB_FOG: return GRID_FOG_VOLUME;
        case RLVDB_STAGGERED: return GRID_STAGGERED;
        default: refuse("a class of grids does not exist");
    }
}

template <typename Grid>
typename Grid::Ptr empty(const double* background) {
    using Value = typename Grid::ValueType;
    if constexpr (relievo::components<Value> == 3) {
        using Number = typename Value::ValueType;
        return Grid::create(Value(static_cast<Number>(background[0]), static_cast<Number>(background[1]),
                                  static_cast<Number>(background[2])));
    } else {
        return Grid::create(static_cast<Value>(background[0]));
    }
}

GridBase::Ptr empty(std::int32_t kind, const double* background) {
    switch (kind) {
        case RLVDB_FLOAT: return empty<FloatGrid>(background);
        case RLVDB_DOUBLE: return empty<DoubleGrid>(background);
        case RLVDB_BOOL: return empty<BoolGrid>(background);
        case RLVDB_MASK: return MaskGrid::create();
        case RLVDB_INT32: return empty<Int32Grid>(background);
        case RLVDB_INT64: return empty<Int64Grid>(background);
        case RLVDB_VEC3S: return empty<Vec3SGrid>(background);
        case RLVDB_VEC3D: return empty<Vec3DGrid>(background);
        case RLVDB_VEC3I: return empty<Vec3IGrid>(background);
        default: refuse("a kind of grids does not exist");
    }
}

template <typename Grid>
constexpr std::int32_t kind = -1;
template <> constexpr std::int32_t kind<FloatGrid> = RLVDB_FLOAT;
template <> constexpr std::int32_t kind<DoubleGrid> = RLVDB_DOUBLE;
template <> constexpr std::int32_t kind<BoolGrid> = RLVDB_BOOL;
template <> constexpr std::int32_t kind<MaskGrid> = RLVDB_MASK;
template <> constexpr std::int32_t kind<Int32Grid> = RLVDB_INT32;
template <> constexpr std::int32_t kind<Int64Grid> = RLVDB_INT64;
template <> constexpr std::int32_t kind<Vec3SGrid> = RLVDB_VEC3S;
template <> constexpr std::int32_t kind<Vec3DGrid> = RLVDB_VEC3D;
template <> constexpr std::int32_t kind<Vec3IGrid> = RLVDB_VEC3I;

void copy(const std::string& text, char* out, std::size_t size) {
    if (size > 0) {
        const std::size_t length = std::min(size - 1, text.size());
        std::memcpy(out, text.data(), length);
        out[length] = 0;
    }
}

}  // namespace

extern "C" {

std::uint32_t rlvdb_version(void) { return RLVDB_VERSION; }

std::uint32_t rlvdb_library_version(void) { return OPENVDB_LIBRARY_VERSION_NUMBER >> 8; }

std::int32_t rlvdb_initialize(std::int32_t ends_logging, RlvdbError* error) {
    return guarded(error, [&] {
        if (ends_logging && log4cplus::deinitialize) {
            log4cplus::deinitialize();
        }
        openvdb::initialize();
    });
}

std::int32_t rlvdb_grid_new(std::int32_t kind, const double* background, double voxel, RlvdbGrid** out,
                            RlvdbError* error) {
    return guarded(error, [&] {
        auto grid = empty(kind, background);
        if (!(voxel > 0.0 && voxel < std::numeric_limits<double>::infinity())) {
            refuse("the size of a voxel is not positive");
        }
        grid->setTransform(math::Transform::createLinearTransform(voxel));
        relievo::give(out, grid);
    });
}

std::int32_t rlvdb_grid_copy(const RlvdbGrid* grid, RlvdbGrid** out, RlvdbError* error) {
    return alone(error, [&] { relievo::give(out, grid->grid->deepCopyGrid()); });
}

void rlvdb_grid_free(RlvdbGrid* grid) {
    RlvdbError ignored;
    alone(&ignored, [&] { delete grid; });
}

std::int32_t rlvdb_grid_info(const RlvdbGrid* handle, RlvdbInfo* out, RlvdbError* error) {
    return alone(error, [&] {
        const GridBase& base = *handle->grid;
        RlvdbInfo info{};
        relievo::dispatch<relievo::Kinds>(base, "described", [&](const auto& grid) {
            info.kind = kind<std::decay_t<decltype(grid)>>;
            relievo::put(grid.background(), info.background);
            info.leaf_count = grid.tree().leafCount();
        });
        info.grid_class = RLVDB_UNKNOWN;
        for (const std::int32_t number : {RLVDB_LEVEL_SET, RLVDB_FOG, RLVDB_STAGGERED}) {
            if (base.getGridClass() == class_of(number)) {
                info.grid_class = number;
            }
        }
        info.is_half = base.saveFloatAsHalf();
        info.is_linear = base.transform().isLinear();
        if (info.is_linear) {
            // What the map does to the axes: an AffineMap of very small voxels cannot be made.
            const Vec3d origin = base.transform().indexToWorld(Vec3d(0.0));
            for (int row = 0; row < 4; ++row) {
                Vec3d axis(0.0);
                if (row < 3) {
                    axis[row] = 1.0;
                }
                const Vec3d place = row < 3 ? base.transform().baseMap()->applyJacobian(axis) : origin;
                std::copy_n(place.asPointer(), 3, info.matrix + 4 * row);
            }
            info.matrix[15] = 1.0;
        } else {
            const auto frustum = base.transform().constMap<math::NonlinearFrustumMap>();
            std::copy_n(frustum->secondMap().getMat4().asPointer(), 16, info.matrix);
        }
        const Vec3d size = base.voxelSize();
        const CoordBBox box = base.evalActiveVoxelBoundingBox();
        for (int axis = 0; axis < 3; ++axis) {
            info.voxel_size[axis] = size[axis];
            info.low[axis] = box.min()[axis];
            info.high[axis] = box.max()[axis];
        }
        info.active_voxels = base.activeVoxelCount();
        info.memory_bytes = base.memUsage();
        *out = info;
    });
}

std::int32_t rlvdb_set_class(RlvdbGrid* grid, std::int32_t grid_class, RlvdbError* error) {
    return guarded(error, [&] { grid->grid->setGridClass(class_of(grid_class)); });
}

std::int32_t rlvdb_set_half(RlvdbGrid* grid, std::int32_t is_half, RlvdbError* error) {
    return guarded(error, [&] { grid->grid->setSaveFloatAsHalf(is_half != 0); });
}

std::int32_t rlvdb_set_matrix(RlvdbGrid* grid, const double* matrix, RlvdbError* error) {
    return guarded(error, [&] { grid->grid->setTransform(relievo::transform_of(matrix)); });
}

std::int32_t rlvdb_set_frustum(RlvdbGrid* grid, const double* box, double taper, double depth, const double* matrix,
                               RlvdbError* error) {
    return guarded(error, [&] {
        const BBoxd bounds(Vec3d(box[0], box[1], box[2]), Vec3d(box[3], box[4], box[5]));
        const auto second = relievo::transform_of(matrix)->baseMap()->getAffineMap();
        grid->grid->setTransform(std::make_shared<math::Transform>(
            math::MapBase::Ptr(new math::NonlinearFrustumMap(bounds, taper, depth, second))));
    });
}

std::int32_t rlvdb_metadata_count(const RlvdbGrid* grid, std::size_t* out, RlvdbError* error) {
    return guarded(error, [&] { *out = grid->grid->metaCount(); });
}

std::int32_t rlvdb_metadata_get(const RlvdbGrid* grid, std::size_t index, char* name, std::size_t name_size, char* type,
                                std::size_t type_size, char* value, std::size_t value_size, RlvdbError* error) {
    return guarded(error, [&] {
        if (index >= grid->grid->metaCount()) {
            refuse("an entry of metadata does not exist");
        }
        const auto entry = std::next(grid->grid->beginMeta(), static_cast<std::ptrdiff_t>(index));
        copy(entry->first, name, name_size);
        copy(entry->second->typeName(), type, type_size);
        copy(entry->second->str(), value, value_size);
    });
}

std::int32_t rlvdb_metadata_set(RlvdbGrid* grid, const char* name, const char* type, const char* value,
                                RlvdbError* error) {
    return guarded(error, [&] {
        if (!value) {
            grid->grid->removeMeta(name);
            return;
        }
        grid->grid->insertMeta(name, *relievo::metadata_of(type, value));
    });
}

}
