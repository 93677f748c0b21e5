// Triangles that a host keeps a copy of and brings up to date by what changed.
#ifndef FOLLOWER_H
#define FOLLOWER_H

#include "../../c/check.h"

#include <vector>

/// Triangles that follow a detail, and where a host has its own copy of them.
struct Follower {
    RlvTessellation handle = RLV_NULL;
    std::vector<uint32_t> ranges;
    std::vector<float> positions, normals, colors;

    Follower(RlvDetail detail, uint32_t cells) {
        RlvTessellateOptions options = RLV_TESSELLATE_OPTIONS_INIT;
        RlvTessellationInfo info = RLV_TESSELLATION_INFO_INIT;
        options.coarse = options.fine = cells;
        CHECK_OK(rlv_tessellation_create(detail, &options, &handle));
        CHECK_OK(rlv_tessellation_info(handle, &info));
        positions.resize(3 * info.point_count);
        normals = colors = positions;
        ranges.resize(2 * info.point_count);
    }

    ~Follower() { CHECK_OK(rlv_tessellation_release(handle)); }

    void update() {
        RlvTessellationChanges changes = RLV_TESSELLATION_CHANGES_INIT;
        CHECK_OK(rlv_tessellation_update(handle, &changes));
        CHECK(changes.rebuilt == 0);
    }

    /// Copies what the update wrote.
    void fetch() {
        size_t count = 0;
        CHECK_OK(rlv_tessellation_changed_ranges(handle, ranges.data(), ranges.size() / 2, &count));
        for (size_t k = 0; k < count; ++k) {
            const size_t first = ranges[2 * k], points = ranges[2 * k + 1];
            float *to = positions.data() + 3 * first, *facing = normals.data() + 3 * first;
            CHECK_OK(rlv_tessellation_get_points(handle, first, points, to, 0, facing, 0));
            CHECK_OK(rlv_tessellation_get_colors(handle, first, points, colors.data() + 3 * first, 0));
        }
    }
};

#endif
