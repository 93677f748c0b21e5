// A host with a TBB at work before the library is opened: rays cast from its tasks hit, and its limits stay what they
// were, though the library's Embree has tasks of its own.
#include "../../c/check.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <atomic>

int main() {
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
            RlvHit hit;
            RlvRayArrays rays = RLV_RAY_ARRAYS_INIT;
            rays.count = 1;
            rays.origins = origin;
            rays.directions = direction;
            rays.hits = &hit;
            CHECK_OK(rlv_caster_cast(caster, &rays));
            hits += hit.face == uint32_t(k);
            CHECK_OK(rlv_caster_release(caster));
            CHECK_OK(rlv_mesh_release(plane));
        });
    });
    CHECK(hits == 24 && allowed() == 3 && arena.max_concurrency() == 3);
    CHECK_OK(rlv_context_release(context));
    arena.execute([&] { tbb::parallel_for(0, 1000, [&](int) { ++tasks; }); });
    CHECK(tasks == 2000);
    return 0;
}
