/* Settings of floating-point arithmetic: a host that lets exceptions trap, rounds towards zero and flushes small numbers to
 * zero gets the results of any other, and has its settings back after each call. */
#define _GNU_SOURCE
#include <fenv.h>
#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

#include "ball.h"

enum { TILES = 16, SIDE = 8, PLACES = TILES * SIDE * SIDE, AGENTS = 20, DRAWS = 1000 };

/* What calls of several kinds result in. */
typedef struct Results {
    float displacements[PLACES];
    float points[3 * 200];
    size_t count;
    float error;
    RlvCrowdModelInfo model;
    RlvCrowdFrame frame;
    RlvCrowdDraw draws[DRAWS];
    float blends[DRAWS];
} Results;

/* A crowd of balls from near to far, by a file of one. */
static void fill_crowd(RlvContext context, const char *path, Results *results) {
    RlvCrowdModel model = RLV_NULL;
    RlvCrowd crowd = RLV_NULL;
    RlvCrowdAgent agents[AGENTS];
    RlvCrowdView view = RLV_CROWD_VIEW_INIT;
    RlvCrowdBuffers buffers = RLV_CROWD_BUFFERS_INIT;
    const RlvCrowdModelInfo info = RLV_CROWD_MODEL_INFO_INIT;
    const RlvCrowdFrame frame = RLV_CROWD_FRAME_INIT;
    CHECK_OK(rlv_crowd_model_build(context, path, NULL, 0, NULL, NULL, NULL, &model));
    results->model = info;
    CHECK_OK(rlv_crowd_model_info(model, &results->model));
    CHECK_OK(rlv_crowd_create(context, &model, 1, &crowd));
    for (int agent = 0; agent < AGENTS; ++agent) {
        const RlvCrowdAgent it = {0, 0, 0.0, {1, 0, 0, 0, 1, 0, 0, 0, 1, agent % 2 ? 1 : -1, 0, -3 * agent - 4}};
        agents[agent] = it;
    }
    CHECK_OK(rlv_crowd_add(crowd, agents, AGENTS, 0, NULL));
    view.width = view.height = 300;
    view.geomorph = view.occlusion = 1;
    view.tolerance = 1.5f;
    results->frame = frame;
    CHECK_OK(rlv_crowd_cut(crowd, &view, &results->frame));
    CHECK(results->frame.draw_count <= DRAWS);
    buffers.draws = results->draws;
    buffers.blends = results->blends;
    buffers.draw_capacity = DRAWS;
    CHECK_OK(rlv_crowd_get(crowd, &buffers));
    CHECK_OK(rlv_crowd_release(crowd));
    CHECK_OK(rlv_crowd_model_release(model));
}

/* The meshes are made before settings change: their points are the host's own arithmetic. */
static void fill(RlvContext context, RlvMesh sheet, RlvMesh ball, Results *results) {
    static uint32_t tiles[PLACES];
    static float uvs[2 * PLACES];
    const double at[12] = CHECK_MOVED(2.3, 1.7, 0.85);
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvCollider collider = RLV_NULL;
    RlvMesh made = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    RlvSimplifyOptions simplify = RLV_SIMPLIFY_OPTIONS_INIT;
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    CHECK_OK(rlv_surface_create(context, sheet, NULL, &surface));
    options.tile_size = 32;
    settings.voxels = 1 << 16;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_collider_create_mesh(context, ball, at, &collider));
    CHECK_OK(rlv_imprint_run(detail, collider, &settings, NULL, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    for (uint32_t place = 0; place < PLACES; ++place) {
        tiles[place] = place / (SIDE * SIDE);
        uvs[2 * place] = (float)(place % SIDE) / SIDE;
        uvs[2 * place + 1] = (float)(place / SIDE % SIDE) / SIDE;
    }
    arrays.count = PLACES;
    arrays.tiles = tiles;
    arrays.uvs = uvs;
    arrays.displacements = results->displacements;
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
    simplify.triangles = 100;
    CHECK_OK(rlv_simplify_mesh(ball, &simplify, NULL, NULL, &results->error, &made));
    CHECK_OK(rlv_mesh_info(made, &info));
    results->count = info.point_count;
    CHECK(info.point_count <= 200);
    CHECK_OK(rlv_mesh_get_points(made, results->points, info.point_count, 0));
    CHECK_OK(rlv_mesh_release(made));
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
}

int main(void) {
    static Results plain, strict;
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh sheet = check_plane(context, 4, 4), ball = check_ball(context, 1.0);
    RlvMesh small = check_ball_of(context, 1.0, 20, 30);
    CHECK_OK(rlv_mesh_write(small, "arithmetic_ball.obj"));
    CHECK_OK(rlv_mesh_release(small));
    fill(context, sheet, ball, &plain);
    fill_crowd(context, "arithmetic_ball.obj", &plain);
    CHECK(plain.frame.draw_count > AGENTS && plain.blends[0] > 0.0f && plain.blends[0] < 1.0f);
    float deepest = 0.0f;
    for (int place = 0; place < PLACES; ++place) {
        deepest = fminf(deepest, plain.displacements[place]);
    }
    CHECK(deepest < -0.1f);

    CHECK(fesetround(FE_TOWARDZERO) == 0);
    const int traps = FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW | FE_UNDERFLOW;
    const int are_trapping = feenableexcept(traps) != -1 && fegetexcept() == traps;
#if defined(__x86_64__)
    _mm_setcsr(_mm_getcsr() | _MM_FLUSH_ZERO_ON);
    const unsigned settings = _mm_getcsr() & ~0x3fu;
    CHECK(are_trapping);
#endif
    fill(context, sheet, ball, &strict);
    fill_crowd(context, "arithmetic_ball.obj", &strict);
    CHECK(fegetround() == FE_TOWARDZERO);
    CHECK(!are_trapping || fegetexcept() == traps);
#if defined(__x86_64__)
    CHECK((_mm_getcsr() & ~0x3fu) == settings);
#endif
    fedisableexcept(traps);
    CHECK(memcmp(&plain, &strict, sizeof plain) == 0);
    CHECK(remove("arithmetic_ball.obj") == 0);
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_mesh_release(sheet));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
