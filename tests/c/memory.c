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

static int released;

static void hear_released(void *user) {
    ++*(int *)user;
}

/* Arrays of the host are read where they lie: the monitor hears of nothing, results are those of a copy, and the host hears when
 * they are used no more. */
static void borrow(RlvContext context, Taken *taken) {
    enum { SIDE = 40, POINTS = (SIDE + 1) * (SIDE + 1), FACES = SIDE * SIDE };
    float *points = malloc(POINTS * 3 * sizeof *points), *moved = malloc(POINTS * 3 * sizeof *moved);
    uint32_t *corners = malloc(FACES * 4 * sizeof *corners), *sizes = malloc(FACES * sizeof *sizes);
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    RlvMesh mesh = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvJob job = RLV_NULL;
    CHECK(points != NULL && moved != NULL && corners != NULL && sizes != NULL);
    for (uint32_t at = 0; at < POINTS; ++at) {
        points[3 * at] = (float)(at % (SIDE + 1)), points[3 * at + 1] = (float)(at / (SIDE + 1)), points[3 * at + 2] = 0.5f;
    }
    for (uint32_t face = 0; face < FACES; ++face) {
        const uint32_t first = face / SIDE * (SIDE + 1) + face % SIDE;
        const uint32_t own[4] = {first, first + 1, first + SIDE + 2, first + SIDE + 1};
        memcpy(corners + 4 * face, own, sizeof own);
        sizes[face] = 4;
    }
    arrays.points = points;
    arrays.point_count = POINTS;
    arrays.corners = corners;
    arrays.corner_count = 4 * FACES;
    arrays.face_sizes = sizes;
    arrays.face_count = FACES;
    const long long before = taken->bytes;
    CHECK_OK(rlv_mesh_create_borrowed(context, &arrays, hear_released, &released, &mesh));
    CHECK(taken->bytes == before); /* no byte is copied */
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK(info.point_count == POINTS && info.face_count == FACES && info.high[0] == SIDE && info.low[2] == 0.5f);
    CHECK_OK(rlv_mesh_get_points(mesh, moved, POINTS, 0));
    CHECK(memcmp(points, moved, POINTS * 3 * sizeof *points) == 0);
    /* What is made of it has arrays of its own, and a job keeps it. */
    CHECK_OK(rlv_surface_create(context, mesh, NULL, &surface));
    CHECK_OK(rlv_job_caster_create_mesh(context, mesh, &job));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_result(job));
    CHECK(released == 1);
    CHECK_OK(rlv_job_release(job));
    memset(points, 0, POINTS * 3 * sizeof *points);
    RlvSurfaceInfo about = RLV_SURFACE_INFO_INIT;
    CHECK_OK(rlv_surface_info(surface, &about));
    CHECK(about.high[0] == SIDE);
    CHECK_OK(rlv_surface_release(surface));

    /* Moved, it has points of its own and still borrows the rest; the host's are not written to. */
    memcpy(points, moved, POINTS * 3 * sizeof *points);
    arrays.face_sizes = NULL;
    arrays.face_size = 4;
    arrays.point_stride = 12;
    CHECK_OK(rlv_mesh_create_borrowed(context, &arrays, hear_released, &released, &mesh));
    CHECK(taken->bytes == before + 4 * FACES); /* sizes that nobody gave */
    moved[2] = 7.0f;
    CHECK_OK(rlv_mesh_set_points(mesh, moved, POINTS, 0));
    CHECK(points[2] == 0.5f && released == 1);
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK(info.high[2] == 7.0f);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK(released == 2 && taken->bytes == before);

    /* What cannot be borrowed is refused, and nobody is called. */
    mesh.id = 77;
    arrays.point_stride = 16;
    arrays.point_count = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_create_borrowed(context, &arrays, hear_released, &released, &mesh), "cannot be borrowed");
    arrays.point_stride = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_create_borrowed(context, &arrays, hear_released, &released, &mesh), "face");
    arrays.point_count = POINTS;
    arrays.points = (const float *)(const void *)((const char *)points + 1);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_create_borrowed(context, &arrays, hear_released, &released, &mesh), "multiple of 4");
    arrays.points = points;
    arrays.face_size = 5;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_create_borrowed(context, &arrays, hear_released, &released, &mesh), "face_size");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_create_borrowed(context, NULL, NULL, NULL, &mesh), "");
    CHECK(released == 2 && mesh.id == 77 && taken->bytes == before);
    free(points);
    free(moved);
    free(corners);
    free(sizes);
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
    RlvMeshArrays arrays = check_faces(points, 3, 3, 1, corners);
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
    borrow(context, &taken);
    CHECK_OK(rlv_caster_create_mesh(context, plane, &caster));
    CHECK_OK(rlv_caster_release(caster));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK(taken.bytes == 0);
    CHECK_OK(rlv_context_set_memory_monitor(context, NULL, NULL));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
