// A host with a TBB at work before the library is used, Debian's or another version: rays cast and imprints made in its
// tasks are what they are elsewhere, and its limits stay what they were, though the library's Embree has tasks of its own.
#include "../../c/check.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/version.h>

#include <atomic>
#include <vector>

namespace {

/// The block of the tile in the middle after a brush went over it and a box was pressed into it.
std::vector<unsigned char> dented(RlvContext context) {
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvCollider collider = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    const RlvMesh plane = check_plane(context, 3, 3), box = check_box(context, 1.2f, 1.8f, -0.2f, 1.0f);
    options.tile_size = 32;
    CHECK_OK(rlv_surface_create(context, plane, nullptr, &surface));
    CHECK_OK(rlv_detail_create(surface, &options, nullptr, &detail));
    CHECK_OK(rlv_collider_create_mesh(context, box, nullptr, &collider));
    CHECK_OK(rlv_imprint_run(detail, collider, nullptr, nullptr, nullptr));
    CHECK_OK(rlv_detail_commit(detail, nullptr));
    std::vector<unsigned char> block(2 * 34 * 34);
    size_t size = 0;
    CHECK_OK(rlv_detail_read_block(detail, RLV_CHANNEL_DISPLACEMENT, 4, block.data(), block.size(), &size));
    CHECK(size == block.size());
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_mesh_release(box));
    return block;
}

} // namespace

int main() {
#ifdef RELIEVO_HOST_OTHER_TBB
    // The library's own needs of TBB are met by the host's.
    CHECK(TBB_runtime_interface_version() > TBB_INTERFACE_VERSION);
#endif
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 3);
    const auto allowed = [] { return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism); };
    tbb::task_arena arena(3);
    std::atomic<int> hits{0}, tasks{0};
    arena.execute([&] { tbb::parallel_for(0, 1000, [&](int) { ++tasks; }); });
    CHECK(tasks == 1000 && allowed() == 3);

    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(nullptr, &context));
    arena.execute([&] {
        tbb::parallel_for(0, 24, [&](int k) {
            // Hierarchies are built and rays cast in tasks of the host, several at once.
            const RlvMesh plane = check_plane(context, 40, 40);
            RlvCaster caster = RLV_NULL;
            CHECK_OK(rlv_caster_create_mesh(context, plane, &caster));
            const float origin[3] = {0.3f + float(k), 0.2f, 1}, direction[3] = {0, 0, -1};
            hits += check_cast(caster, origin, direction).face == uint32_t(k);
            CHECK_OK(rlv_caster_release(caster));
            CHECK_OK(rlv_mesh_release(plane));
        });
    });
    CHECK(hits == 24 && allowed() == 3 && arena.max_concurrency() == 3);
    const auto alone = dented(context);
    std::atomic<int> same{0};
    arena.execute([&] { tbb::parallel_for(0, 8, [&](int) { same += dented(context) == alone; }); });
    CHECK(same == 8 && allowed() == 3);
    CHECK_OK(rlv_context_release(context));
    arena.execute([&] { tbb::parallel_for(0, 1000, [&](int) { ++tasks; }); });
    CHECK(tasks == 2000);
    return 0;
}
