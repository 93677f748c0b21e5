/* The monitor of memory of a context. Not run under Valgrind: buffers of Embree 3.13 count a reference to its device before
 * they ask the monitor, and do not give it back when they are refused. */
#include "check.h"

/* What objects take, and from which sum on it is refused. */
typedef struct Taken {
    long long bytes, most;
} Taken;

static uint32_t watch_memory(void *user, int64_t bytes) {
    Taken *taken = user;
    if (bytes > 0 && taken->bytes + bytes > taken->most) {
        return RLV_PROGRESS_CANCEL;
    }
    taken->bytes += bytes;
    return RLV_PROGRESS_CONTINUE;
}

/* Meshes take what their arrays do, casters what Embree does; what is refused fails, and all of it comes back. */
int main(void) {
    enum { CELLS = 60, ARRAYS = 12 * (CELLS + 1) * (CELLS + 1) + 20 * CELLS * CELLS };
    Taken taken = {0, 1 << 30};
    RlvContext context = RLV_NULL;
    RlvCaster caster = RLV_NULL;
    RlvMesh mesh = RLV_NULL;
    const float points[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const uint32_t corners[3] = {0, 1, 2};
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    arrays.points = points;
    arrays.point_count = 3;
    arrays.face_size = 3;
    arrays.face_count = 1;
    arrays.corners = corners;
    arrays.corner_count = 3;
    CHECK_OK(rlv_context_create(NULL, &context));
    CHECK_OK(rlv_context_set_memory_monitor(context, watch_memory, &taken));
    RlvMesh plane = check_plane(context, CELLS, CELLS);
    CHECK(taken.bytes == ARRAYS);
    CHECK_OK(rlv_caster_create_mesh(context, plane, &caster));
    const long long built = taken.bytes - ARRAYS;
    CHECK(built > 12 * (CELLS + 1) * (CELLS + 1));
    CHECK_OK(rlv_caster_release(caster));
    CHECK(taken.bytes == ARRAYS);

    /* At every third of what it needs Embree is refused, which changes nothing. */
    for (int third = 0; third < 3; ++third) {
        taken.most = ARRAYS + built * third / 3;
        CHECK_FAILS(RLV_ERROR_MEMORY, rlv_caster_create_mesh(context, plane, &caster), "memory");
        CHECK(taken.bytes == ARRAYS);
    }
    CHECK_FAILS(RLV_ERROR_MEMORY, (taken.most = ARRAYS + 51, rlv_mesh_create(context, &arrays, &mesh)), "52 bytes");
    CHECK(taken.bytes == ARRAYS && mesh.id == 0);
    taken.most = 1 << 30;
    CHECK_OK(rlv_caster_create_mesh(context, plane, &caster));
    CHECK_OK(rlv_caster_release(caster));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK(taken.bytes == 0);
    CHECK_OK(rlv_context_set_memory_monitor(context, NULL, NULL));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
