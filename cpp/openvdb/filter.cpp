// Grids offset and filtered.

#include "guard.h"

#include <openvdb/tools/Filter.h>
#include <openvdb/tools/LevelSetFilter.h>

namespace {

using namespace openvdb;
using relievo::bounded, relievo::dispatch, relievo::give, relievo::refuse;
using Watch = util::NullInterrupter;

// Throws unless the grid is a level set that its tracker can follow.
template <typename Grid>
void demand_level_set(const Grid& grid) {
    if (grid.getGridClass() != GRID_LEVEL_SET || !grid.hasUniformVoxels()) {
        refuse("the grid is not a level set with cubic voxels; make one of it first");
    }
}

template <typename Grid>
void smooth_level_set(Grid& grid, std::int32_t filter, int width, std::uint32_t iterations, relievo::Interrupter& interrupter) {
    tools::LevelSetFilter<Grid, Grid, Watch> filters(grid, &interrupter);
    for (std::uint32_t step = 0; step < iterations; ++step) {
        interrupter.check(static_cast<int>(100 * std::uint64_t(step) / iterations));
        switch (filter) {
            case RLVDB_MEAN: filters.mean(width); break;
            case RLVDB_GAUSSIAN: filters.gaussian(width); break;
            case RLVDB_MEDIAN: filters.median(width); break;
            case RLVDB_LAPLACIAN: filters.laplacian(); break;
            case RLVDB_MEAN_CURVATURE: filters.meanCurvature(); break;
            default: refuse("a filter does not exist");
        }
    }
}

template <typename Grid>
void smooth_values(Grid& grid, std::int32_t filter, int width, int iterations, relievo::Interrupter& interrupter) {
    tools::Filter<Grid, Grid, Watch> filters(grid, &interrupter);
    switch (filter) {
        case RLVDB_MEAN: filters.mean(width, iterations); break;
        case RLVDB_GAUSSIAN: filters.gaussian(width, iterations); break;
        case RLVDB_MEDIAN: filters.median(width, iterations); break;
        default: refuse("this filter is for level sets alone");
    }
}

}  // namespace

extern "C" {

std::int32_t rlvdb_offset(const RlvdbGrid* handle, double distance, const RlvdbCall* call, RlvdbGrid** out,
                          RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter& interrupter) {
        dispatch<relievo::Scalars>(*handle->grid, "offset", [&](const auto& grid) {
            using Grid = std::decay_t<decltype(grid)>;
            demand_level_set(grid);
            auto made = grid.deepCopy();
            tools::LevelSetFilter<Grid, Grid, Watch> filter(*made, &interrupter);
            // OpenVDB adds the number to the values, which moves the surface inwards.
            filter.offset(static_cast<typename Grid::ValueType>(-distance));
            interrupter.check();
            give(out, made);
        });
    });
}

std::int32_t rlvdb_filter(const RlvdbGrid* handle, std::int32_t filter, std::uint32_t width, std::uint32_t iterations,
                          const RlvdbCall* call, RlvdbGrid** out, RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter& interrupter) {
        dispatch<relievo::Scalars>(*handle->grid, "filtered", [&](const auto& grid) {
            auto made = grid.deepCopy();
            const int radius = static_cast<int>(std::min<std::uint32_t>(width, 1 << 10));
            if (grid.getGridClass() == GRID_LEVEL_SET) {
                demand_level_set(grid);
                smooth_level_set(*made, filter, radius, iterations, interrupter);
            } else {
                smooth_values(*made, filter, radius, static_cast<int>(std::min<std::uint32_t>(iterations, 1 << 10)), interrupter);
            }
            interrupter.check();
            give(out, made);
        });
    });
}

}
