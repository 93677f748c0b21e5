// Resampling of grids, which is compiled by itself.
#pragma once

#include "guard.h"

namespace relievo {

// Resamples a grid to a transform: order 0 takes the closest voxel, 1 is trilinear, 2 is quadratic, as far as its kind allows.
openvdb::GridBase::Ptr resampled(const openvdb::GridBase& grid, const openvdb::math::Transform::Ptr& transform, std::uint32_t order,
                                 Interrupter& interrupter);

}  // namespace relievo
