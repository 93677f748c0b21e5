/* Threads: calls that do not change an object run at the same time; calls that do find it free or get
 * RLV_ERROR_BUSY; readers of surfaces and details always see one whole pose and never wait. */
#include "check.h"

#include <pthread.h>

enum { READERS = 3, ROUNDS = 300, SIDE = 12, POINTS = (SIDE + 1) * (SIDE + 1) };

static RlvSurface surface;
static RlvMesh mesh;
static RlvDetail detail;

static void *read_poses(void *unused) {
    static const uint32_t tiles[2] = {0, SIDE * SIDE - 1};
    static const float uvs[4] = {0.5f, 0.5f, 0.5f, 0.5f};
    (void)unused;
    for (int round = 0; round < ROUNDS; ++round) {
        float out[2][3];
        RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
        arrays.count = 2;
        arrays.tiles = tiles;
        arrays.uvs = uvs;
        arrays.positions = out[0];
        CHECK_OK(rlv_evaluate_surface(surface, &arrays));
        CHECK(out[0][2] == out[1][2]);
        CHECK_OK(rlv_evaluate_detail(detail, &arrays));
        CHECK(out[0][2] == out[1][2]);
        RlvMeshInfo info = RLV_MESH_INFO_INIT;
        RlvResult result = rlv_mesh_info(mesh, &info);
        CHECK(result == RLV_OK || result == RLV_ERROR_BUSY);
        CHECK(result != RLV_OK || info.low[2] == info.high[2]);
    }
    return NULL;
}

/* Two of these at once: each call is made or refused as busy. */
typedef struct Poser {
    float height;
    size_t made;
} Poser;

static void *pose(void *user) {
    float points[POINTS][3];
    Poser *poser = user;
    for (int round = 0; round < ROUNDS; ++round) {
        for (int point = 0; point < POINTS; ++point) {
            points[point][0] = (float)(point % (SIDE + 1));
            points[point][1] = (float)(point / (SIDE + 1));
            points[point][2] = poser->height + (float)round;
        }
        RlvResult result = rlv_surface_set_points(surface, points[0], POINTS, 0);
        CHECK(result == RLV_OK || result == RLV_ERROR_BUSY);
        poser->made += result == RLV_OK;
        result = rlv_detail_set_points(detail, points[0], POINTS, 0);
        CHECK(result == RLV_OK || result == RLV_ERROR_BUSY);
        result = rlv_detail_commit(detail, NULL);
        CHECK(result == RLV_OK || result == RLV_ERROR_BUSY);
        result = rlv_mesh_set_points(mesh, points[0], POINTS, 0);
        CHECK(result == RLV_OK || result == RLV_ERROR_BUSY);
    }
    return NULL;
}

int main(void) {
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    mesh = check_plane(context, SIDE, SIDE);
    CHECK_OK(rlv_surface_create(context, mesh, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    pthread_t threads[READERS + 2];
    Poser posers[2] = {{1.0f, 0}, {1000.0f, 0}};
    for (int index = 0; index < READERS; ++index) {
        CHECK(pthread_create(&threads[index], NULL, read_poses, NULL) == 0);
    }
    for (int index = 0; index < 2; ++index) {
        CHECK(pthread_create(&threads[READERS + index], NULL, pose, &posers[index]) == 0);
    }
    for (int index = 0; index < READERS + 2; ++index) {
        CHECK(pthread_join(threads[index], NULL) == 0);
    }
    CHECK(posers[0].made + posers[1].made > 0);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
