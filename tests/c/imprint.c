/* Imprints: a ball leaves a dent of its depth and shape, a moving one a track, and two surfaces share a dent. */
#include "ball.h"

/* Answers a number of times, then cancels; counts the calls. */
typedef struct Watch {
    int answers;
    int calls;
    float last;
    RlvDetail detail;
    RlvCollider collider;
} Watch;

static uint32_t watch(void *user, float fraction, const char *stage) {
    Watch *watch = user;
    CHECK(fraction >= watch->last && fraction <= 1.0f && strlen(stage) > 0);
    watch->last = fraction;
    /* While the call is at work, at its end too, both are busy, but readers see what was committed before. */
    RlvColliderInfo info = RLV_COLLIDER_INFO_INIT;
    CHECK_FAILS(RLV_ERROR_BUSY, rlv_detail_commit(watch->detail, NULL), "detail: another call is at work");
    CHECK_FAILS(RLV_ERROR_BUSY, rlv_imprint_run(watch->detail, watch->collider, NULL, NULL, NULL), "collider");
    CHECK_FAILS(RLV_ERROR_BUSY, rlv_collider_info(watch->collider, &info), "collider");
    CHECK(check_displacement(watch->detail, 14, 0.5f, 0.5f) == 0.0f);
    return ++watch->calls > watch->answers ? RLV_PROGRESS_CANCEL : RLV_PROGRESS_CONTINUE;
}

/* A ball that moves 4 to the right in one frame leaves a track, and a cancelled one leaves nothing. */
static void sweep(RlvContext context, RlvSurface surface, RlvMesh ball) {
    const double from[12] = CHECK_MOVED(1.0, 2.5, 0.85), to[12] = CHECK_MOVED(5.0, 2.5, 0.85);
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvDetail detail = RLV_NULL;
    RlvCollider collider = RLV_NULL;
    RlvColliderInfo info = RLV_COLLIDER_INFO_INIT;
    RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
    RlvDetailChanges changes = RLV_DETAIL_CHANGES_INIT;
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    options.tile_size = 32;
    settings.voxels = 1 << 18;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_collider_create_mesh(context, ball, from, &collider));

    /* Before the fourth of eight sub-steps, and after the last. */
    for (int answers = 3; answers <= 8; answers += 5) {
        Watch impatient = {answers, 0, 0.0f, detail, collider};
        CHECK_FAILS(RLV_ERROR_CANCELLED,
                    rlv_imprint_sweep(detail, collider, from, to, &settings, NULL, watch, &impatient, &report), "cancelled");
        CHECK(impatient.calls == answers + 1 && report.steps == 0);
        CHECK_OK(rlv_collider_info(collider, &info));
        CHECK(info.matrix[9] == 1.0);
        CHECK_OK(rlv_detail_commit(detail, &changes));
        RlvDetailInfo nothing = RLV_DETAIL_INFO_INIT;
        CHECK_OK(rlv_detail_info(detail, &nothing));
        CHECK(nothing.allocated_count == 0 && nothing.bytes == 0);
    }

    Watch patient = {1000, 0, 0.0f, detail, collider};
    CHECK_OK(rlv_imprint_sweep(detail, collider, from, to, &settings, NULL, watch, &patient, &report));
    CHECK(report.steps == 8 && report.wanted_steps == 8 && patient.calls == 9 && patient.last == 1.0f);
    CHECK_OK(rlv_collider_info(collider, &info));
    CHECK(info.matrix[9] == 5.0);
    CHECK_OK(rlv_detail_commit(detail, &changes));
    /* Along the middle of the track, between the sub-steps too, it is about as deep as the ball. */
    for (int step = 0; step < 32; ++step) {
        float depth = check_displacement(detail, 14 + (uint32_t)step / 16, (float)(step % 16) / 16, 0.5f);
        CHECK(depth < -0.1f && depth > -0.2f);
    }
    CHECK(check_displacement(detail, 32, 0.5f, 0.5f) == 0.0f);
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_detail_release(detail));
}

/* A ball whose points move as far leaves the same track, and is as it was after it was cancelled. */
static void deform(RlvContext context, RlvSurface surface, RlvMesh ball) {
    const double place[12] = CHECK_MOVED(1.0, 2.5, 0.85);
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvMeshInfo mesh = RLV_MESH_INFO_INIT;
    RlvDetail detail = RLV_NULL;
    RlvCollider collider = RLV_NULL;
    RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    options.tile_size = 32;
    settings.voxels = 1 << 18;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_collider_create_mesh(context, ball, place, &collider));
    CHECK_OK(rlv_mesh_info(ball, &mesh));
    const size_t count = mesh.point_count;
    float *from = malloc(count * 3 * sizeof(float)), *to = malloc(count * 3 * sizeof(float));
    CHECK(from && to);
    CHECK_OK(rlv_mesh_get_points(ball, from, count, 0));
    for (size_t number = 0; number < 3 * count; ++number) {
        to[number] = from[number] + (number % 3 == 0 ? 4.0f : 0.0f);
    }

    Watch impatient = {3, 0, 0.0f, detail, collider};
    CHECK_FAILS(RLV_ERROR_CANCELLED,
                rlv_imprint_sweep_points(detail, collider, place, place, from, to, count, 0, &settings, NULL, watch,
                                         &impatient, &report),
                "cancelled");
    CHECK_FAILS(RLV_ERROR_INVALID,
                rlv_imprint_sweep_points(detail, collider, place, place, from, to, count - 1, 0, &settings, NULL, NULL,
                                         NULL, &report),
                "another number of points");
    CHECK_FAILS(RLV_ERROR_INVALID,
                rlv_imprint_sweep_points(detail, collider, place, place, NULL, to, count, 0, &settings, NULL, NULL, NULL,
                                         &report),
                "from_points");
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK(check_displacement(detail, 14, 0.5f, 0.5f) == 0.0f);
    /* The ball is where it was: pressed in there, it reaches nothing else. */
    CHECK_OK(rlv_imprint_run(detail, collider, &settings, NULL, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK(check_displacement(detail, 15, 0.0f, 0.5f) == 0.0f);

    CHECK_OK(rlv_imprint_sweep_points(detail, collider, place, place, from, to, count, 0, &settings, NULL, NULL, NULL,
                                      &report));
    /* Rounded, a point may go a little further than 4. */
    CHECK(report.steps >= 8 && report.steps <= 9 && report.wanted_steps == report.steps);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    for (int step = 0; step < 32; ++step) {
        float depth = check_displacement(detail, 14 + (uint32_t)step / 16, (float)(step % 16) / 16, 0.5f);
        CHECK(depth < -0.1f && depth > -0.2f);
    }
    free(from);
    free(to);
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_detail_release(detail));
}

/* Two bulges face to face and some way into each other share the dent. */
static void collide(RlvContext context) {
    const double facing[12] = {1, 0, 0, 0, -1, 0, 0, 0, -1, 0, 3, -0.5};
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvSurface surface = RLV_NULL;
    RlvDetail below = RLV_NULL, above = RLV_NULL;
    RlvImprintSettings half = RLV_IMPRINT_SETTINGS_INIT, rest = RLV_IMPRINT_SETTINGS_INIT;
    RlvImprintReport first = RLV_IMPRINT_REPORT_INIT, second = RLV_IMPRINT_REPORT_INIT;
    RlvMesh plane = check_plane(context, 3, 3);
    /* Bulge the middle, so that the planes have boxes with depth. */
    float points[16][3];
    CHECK_OK(rlv_mesh_get_points(plane, points[0], 16, 0));
    for (int point = 0; point < 16; ++point) {
        float x = points[point][0] - 1.5f, y = points[point][1] - 1.5f;
        points[point][2] = -0.2f * (x * x + y * y);
    }
    CHECK_OK(rlv_mesh_set_points(plane, points[0], 16, 0));
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    options.tile_size = 32;
    half.voxels = rest.voxels = 1 << 18;
    half.share = 0.5f;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &below));
    CHECK_OK(rlv_detail_create(surface, &options, facing, &above));
    float top = check_displacement(below, 4, 0.5f, 0.5f);
    CHECK(top == 0.0f);
    CHECK_OK(rlv_imprint_collide(below, above, &half, &rest, NULL, &first, &second));
    CHECK(first.changed_coefficients > 0 && second.changed_coefficients > 0);
    CHECK_OK(rlv_detail_commit(below, NULL));
    CHECK_OK(rlv_detail_commit(above, NULL));
    float one = check_displacement(below, 4, 0.5f, 0.5f), other = check_displacement(above, 4, 0.5f, 0.5f);
    CHECK(one < -0.01f && other < -0.01f);
    CHECK_NEAR(one, other, 0.03);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_imprint_collide(below, below, NULL, NULL, NULL, NULL, NULL), "itself");
    CHECK_OK(rlv_detail_release(below));
    CHECK_OK(rlv_detail_release(above));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
}

/* A share of what a ball pushes away rises around it. */
static void rim(RlvContext context, RlvSurface surface, RlvMesh ball) {
    const double place[12] = CHECK_MOVED(3.0, 3.0, 0.8);
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
    RlvDetail detail = RLV_NULL;
    RlvCollider collider = RLV_NULL;
    options.tile_size = 32;
    settings.voxels = 1 << 18;
    settings.rim = 0.5f;
    settings.rim_width = 0.5f;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_collider_create_mesh(context, ball, place, &collider));
    CHECK_OK(rlv_imprint_run(detail, collider, &settings, NULL, &report));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    /* The cap of height 0.2 of a ball of radius 1. */
    CHECK_NEAR(report.pushed_volume, 0.1173, 0.01);
    CHECK_NEAR(report.raised_volume, 0.5 * report.pushed_volume, 0.01 * report.pushed_volume);
    CHECK(check_displacement(detail, 14, 0.2f, 1.0f) > 0.01f);
    settings.repose = 2.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_imprint_run(detail, collider, &settings, NULL, NULL), "repose");
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_detail_release(detail));
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvCollider collider = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh plane = check_plane(context, 6, 6), ball = check_ball(context, 1.0);
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    options.tile_size = 64;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    /* The lowest point of the ball is 0.3 below the plane, over its middle. */
    const double place[12] = CHECK_MOVED(3.0, 3.0, 0.7);
    CHECK_OK(rlv_collider_create_mesh(context, ball, place, &collider));

    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    RlvImprintMoment moment = RLV_IMPRINT_MOMENT_INIT;
    RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
    moment.frame = 1;
    CHECK_OK(rlv_imprint_run(detail, collider, &settings, &moment, &report));
    CHECK(report.steps == 1 && report.changed_tiles >= 4 && report.refused_tiles == 0 && report.triangles > 0);
    CHECK(report.changed_coefficients > 0 && report.tested_coefficients >= report.changed_coefficients);
    CHECK(report.voxel_diagonal > 0.0 && report.voxel_diagonal < 0.05 && report.bytes > 0 && report.open_edges == 0);

    /* Not visible before the commit. */
    const uint32_t tiles[3] = {14, 14, 0};
    const float uvs[6] = {1, 1, 0.5f, 0.5f, 0.5f, 0.5f};
    float out[3][3], normals[3][3], displacements[3];
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    arrays.count = 3;
    arrays.tiles = tiles;
    arrays.uvs = uvs;
    arrays.positions = out[0];
    arrays.normals = normals[0];
    arrays.displacements = displacements;
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
    CHECK(out[0][2] == 0.0f && displacements[0] == 0.0f);
    RlvDetailChanges changes = RLV_DETAIL_CHANGES_INIT;
    CHECK_OK(rlv_detail_commit(detail, &changes));
    CHECK(changes.tile_count >= report.changed_tiles && changes.moved == 0);
    CHECK(changes.low[2] <= -0.3f && changes.low[0] <= 2.0f && changes.high[0] >= 4.0f);

    /* The bottom of the dent, a place on its wall (0.5 off each axis: z = 0.7 - sqrt(1 - 0.5)), and one far away. */
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
    CHECK_NEAR(out[0][2], -0.3, 2 * report.voxel_diagonal);
    CHECK(out[0][2] <= -0.3f + (float)report.voxel_diagonal);
    CHECK_NEAR(out[1][2], 0.7 - sqrt(0.5), 2 * report.voxel_diagonal + 0.01);
    CHECK_NEAR(displacements[1], out[1][2], 1e-6);
    CHECK(out[2][2] == 0.0f && normals[2][2] == 1.0f);
    CHECK(normals[1][0] > 0.3f && normals[1][1] > 0.3f);

    /* An edge through the dent is the same to the last bit from both tiles. */
    enum { SEAM = 33 };
    uint32_t seam_tiles[2 * SEAM];
    float seam_uvs[2 * SEAM][2], seam[2 * SEAM][3];
    for (int index = 0; index < 2 * SEAM; ++index) {
        seam_tiles[index] = index < SEAM ? 14 : 15;
        seam_uvs[index][0] = index < SEAM ? 1.0f : 0.0f;
        seam_uvs[index][1] = (float)(index % SEAM) / (SEAM - 1);
    }
    RlvEvaluateArrays along = RLV_EVALUATE_ARRAYS_INIT;
    along.count = 2 * SEAM;
    along.tiles = seam_tiles;
    along.uvs = seam_uvs[0];
    along.positions = seam[0];
    CHECK_OK(rlv_evaluate_detail(detail, &along));
    CHECK(seam[SEAM / 2][2] < -0.1f && memcmp(seam[0], seam[SEAM], SEAM * sizeof(seam[0])) == 0);

    /* Pressing again where it is changes next to nothing: the dent is there already. */
    RlvImprintReport again = RLV_IMPRINT_REPORT_INIT;
    CHECK_OK(rlv_imprint_run(detail, collider, &settings, &moment, &again));
    CHECK(again.allocated_tiles == 0 && again.changed_coefficients < report.changed_coefficients / 20);
    CHECK_OK(rlv_detail_commit(detail, NULL));

    /* Rays hit the dent, and say where it is. */
    RlvCaster caster = RLV_NULL;
    const float origin[3] = {2.5f, 2.5f, 2.0f}, direction[3] = {0, 0, -1};
    CHECK_OK(rlv_caster_create_detail(detail, NULL, &caster));
    const RlvHit hit = check_cast(caster, origin, direction);
    CHECK(hit.tile == 14 && hit.face == 14);
    CHECK_NEAR(hit.u, 0.5, 0.01);
    CHECK_NEAR(hit.position[2], out[1][2], 0.005);
    CHECK_NEAR(hit.normal[0], normals[1][0], 0.05);
    CHECK_OK(rlv_caster_release(caster));

    /* A collider elsewhere does nothing. */
    const double away[12] = CHECK_MOVED(3.0, 3.0, 9.0);
    CHECK_OK(rlv_collider_set_transform(collider, away));
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, &again));
    CHECK(again.changed_tiles == 0 && again.voxel_diagonal == 0.0);
    CHECK_OK(rlv_collider_set_transform(collider, place));

    /* Half the share leaves half the depth. */
    RlvDetail half = RLV_NULL;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &half));
    settings.share = 0.5f;
    CHECK_OK(rlv_imprint_run(half, collider, &settings, &moment, NULL));
    CHECK_OK(rlv_detail_commit(half, NULL));
    CHECK_OK(rlv_evaluate_detail(half, &arrays));
    CHECK_NEAR(out[0][2], -0.15, 2 * report.voxel_diagonal);
    CHECK_OK(rlv_detail_release(half));

    sweep(context, surface, ball);
    deform(context, surface, ball);
    rim(context, surface, ball);
    collide(context);

    /* Settings out of range change nothing. */
    settings.share = 2.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_imprint_run(detail, collider, &settings, &moment, &again), "share");
    settings.share = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_imprint_run(detail, collider, &settings, &moment, &again), "share");
    RlvCollider wrong = {detail.id};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_imprint_run(detail, wrong, NULL, NULL, NULL), "of a detail");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_imprint_params(NULL, NULL), "params");

    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
