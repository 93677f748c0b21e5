// Grids resampled.

#include "resample.h"

#include <openvdb/tools/GridTransformer.h>

namespace {

using namespace openvdb;
using relievo::bounded, relievo::dispatch, relievo::give;
using Watch = util::NullInterrupter;

// An empty grid with the background, the class and the metadata of another, and a transform.
template <typename Grid>
typename Grid::Ptr like(const Grid& grid, const math::Transform::Ptr& transform) {
    auto made = grid.copyWithNewTree();
    made->setTransform(transform);
    return made;
}

// Resamples a grid; masks go by way of bools, which the sampler knows.
template <typename Grid>
typename Grid::Ptr resampled(const Grid& grid, const math::Transform::Ptr& transform, std::uint32_t order,
                             relievo::Interrupter& interrupter) {
    if constexpr (std::is_same_v<Grid, MaskGrid>) {
        BoolGrid bools(BoolTree::Ptr(new BoolTree(grid.tree(), false, true, TopologyCopy())));
        bools.setTransform(grid.transform().copy());
        const auto made = resampled(bools, transform, 0, interrupter);
        auto mask = like(grid, transform);
        mask->tree().topologyUnion(made->tree());
        return mask;
    } else {
        using Value = typename Grid::ValueType;
        constexpr bool is_smooth = std::is_floating_point_v<Value> || std::is_same_v<Grid, Vec3SGrid> || std::is_same_v<Grid, Vec3DGrid>;
        auto made = like(grid, transform);
        Watch& watch = interrupter;
        if constexpr (is_smooth) {
            if (order == 1) {
                tools::resampleToMatch<tools::BoxSampler>(grid, *made, watch);
                return made;
            }
        }
        if constexpr (std::is_floating_point_v<Value>) {
            if (order == 2) {
                tools::resampleToMatch<tools::QuadraticSampler>(grid, *made, watch);
                return made;
            }
        }
        tools::resampleToMatch<tools::PointSampler>(grid, *made, watch);
        return made;
    }
}

}  // namespace

namespace relievo {

openvdb::GridBase::Ptr resampled(const openvdb::GridBase& grid, const openvdb::math::Transform::Ptr& transform, std::uint32_t order,
                                 Interrupter& interrupter) {
    openvdb::GridBase::Ptr made;
    dispatch<Kinds>(grid, "resampled", [&](const auto& typed) { made = ::resampled(typed, transform, order, interrupter); });
    return made;
}

}  // namespace relievo

extern "C" {

std::int32_t rlvdb_resample(const RlvdbGrid* handle, const double* matrix, std::uint32_t order, const RlvdbCall* call,
                            RlvdbGrid** out, RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter& interrupter) {
        auto made = relievo::resampled(*handle->grid, relievo::transform_of(matrix), order, interrupter);
        interrupter.check();
        give(out, made);
    });
}

}
