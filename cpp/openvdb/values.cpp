// Values of grids at points, of voxels, and of dense blocks.

#include "guard.h"

#include <openvdb/tools/Dense.h>

#include <limits>

namespace {

using namespace openvdb;
using relievo::bounded, relievo::components, relievo::dispatch, relievo::guarded, relievo::put;

// Voxels that far from 0 are background in any sound grid.
constexpr double FARTHEST = 1 << 30;

CoordBBox block(const std::int32_t* low, const std::uint32_t* size, std::size_t bytes, std::size_t value) {
    Coord high;
    std::size_t left = bytes / value;
    for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t last = std::int64_t(low[axis]) + size[axis] - 1;
        if (size[axis] == 0 || last > (1 << 30) || low[axis] < -(1 << 30)) {
            relievo::refuse("a block of voxels is empty, or more than 2^30 voxels from 0");
        }
        high[axis] = static_cast<std::int32_t>(last);
        if (left % size[axis] != 0) {
            relievo::refuse("the array does not have the size of the block");
        }
        left /= size[axis];
    }
    if (left != 1 || bytes % value != 0) {
        relievo::refuse("the array does not have the size of the block");
    }
    return CoordBBox(Coord(low[0], low[1], low[2]), high);
}

}  // namespace

extern "C" {

std::int32_t rlvdb_sample(const RlvdbGrid* handle, const double* points, std::size_t count, std::int32_t is_linear,
                          double* values, RlvdbError* error) {
    return guarded(error, [&] {
        dispatch<relievo::Kinds>(*handle->grid, "sampled", [&](const auto& grid) {
            using Value = typename std::decay_t<decltype(grid)>::ValueType;
            constexpr int width = components<Value>;
            const auto accessor = grid.getConstAccessor();
            for (std::size_t index = 0; index < count; ++index) {
                Vec3d place = grid.worldToIndex(Vec3d(points + 3 * index));
                for (int axis = 0; axis < 3; ++axis) {
                    // A point behind a frustum's eye has no place.
                    place[axis] = std::isfinite(place[axis]) ? std::clamp(place[axis], -FARTHEST, FARTHEST) : FARTHEST;
                }
                double* out = values + width * index;
                if (!is_linear) {
                    put(accessor.getValue(Coord::round(place)), out);
                    continue;
                }
                const Coord first = Coord::floor(place);
                const Vec3d share = place - first.asVec3d();
                std::fill_n(out, width, 0.0);
                for (int corner = 0; corner < 8; ++corner) {
                    double weight = 1.0;
                    Coord at = first;
                    for (int axis = 0; axis < 3; ++axis) {
                        const int step = corner >> axis & 1;
                        weight *= step ? share[axis] : 1.0 - share[axis];
                        at[axis] += step;
                    }
                    double value[3];
                    put(accessor.getValue(at), value);
                    for (int part = 0; part < width; ++part) {
                        out[part] += weight * value[part];
                    }
                }
            }
        });
    });
}

std::int32_t rlvdb_voxels(const RlvdbGrid* handle, const std::int32_t* voxels, std::size_t count, double* values,
                          RlvdbError* error) {
    return guarded(error, [&] {
        dispatch<relievo::Kinds>(*handle->grid, "read", [&](const auto& grid) {
            constexpr int width = components<typename std::decay_t<decltype(grid)>::ValueType>;
            const auto accessor = grid.getConstAccessor();
            for (std::size_t index = 0; index < count; ++index) {
                const std::int32_t* voxel = voxels + 3 * index;
                put(accessor.getValue(Coord(voxel[0], voxel[1], voxel[2])), values + width * index);
            }
        });
    });
}

std::int32_t rlvdb_dense_get(const RlvdbGrid* handle, const std::int32_t* low, const std::uint32_t* size, void* values,
                             std::size_t byte_count, const RlvdbCall* call, RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter&) {
        dispatch<relievo::Kinds>(*handle->grid, "copied to an array", [&](const auto& grid) {
            using Value = typename std::decay_t<decltype(grid)>::ValueType;
            const CoordBBox box = block(low, size, byte_count, sizeof(Value));
            tools::Dense<Value, tools::LayoutZYX> dense(box, static_cast<Value*>(values));
            tools::copyToDense(grid, dense);
        });
    });
}

std::int32_t rlvdb_dense_set(RlvdbGrid* handle, const std::int32_t* low, const std::uint32_t* size, const void* values,
                             std::size_t byte_count, double tolerance, const RlvdbCall* call, RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter&) {
        dispatch<relievo::Kinds>(*handle->grid, "set from an array", [&](const auto& grid_) {
            using Grid = std::decay_t<decltype(grid_)>;
            using Value = typename Grid::ValueType;
            auto& grid = const_cast<Grid&>(grid_);
            const CoordBBox box = block(low, size, byte_count, sizeof(Value));
            // The array is only read.
            const tools::Dense<Value, tools::LayoutZYX> dense(box, static_cast<Value*>(const_cast<void*>(values)));
            if constexpr (std::is_same_v<Grid, MaskGrid>) {
                auto accessor = grid.getAccessor();
                for (auto at = box.begin(); at; ++at) {
                    accessor.setActiveState(*at, dense.getValue(*at));
                }
            } else if constexpr (components<Value> == 3) {
                using Number = typename Value::ValueType;
                tools::copyFromDense(dense, grid, Value(static_cast<Number>(tolerance)));
            } else {
                tools::copyFromDense(dense, grid, static_cast<Value>(tolerance));
            }
        });
    });
}

}
