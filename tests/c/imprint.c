/* Imprints: the table of parameters is the struct, and a ball leaves a dent of its depth and shape. */
#include "ball.h"

static const RlvParameter *find(const char *name) {
    const RlvParameter *params = NULL;
    size_t count = 0;
    CHECK_OK(rlv_imprint_params(&params, &count));
    for (size_t index = 0; index < count; ++index) {
        if (strcmp(params[index].name, name) == 0) {
            return &params[index];
        }
    }
    return NULL;
}

static void table(void) {
    const RlvParameter *params = NULL;
    size_t count = 0;
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    CHECK_OK(rlv_imprint_params(&params, &count));
    CHECK(sizeof(settings) == 4 + 4 * count);
    for (size_t index = 0; index < count; ++index) {
        const RlvParameter *param = &params[index];
        const char *field = (const char *)&settings + param->offset;
        float number;
        uint32_t whole;
        CHECK(param->offset == 4 + 4 * index && param->min <= param->value && param->value <= param->max);
        CHECK(strlen(param->help) > 10 && param->unit != NULL);
        memcpy(&number, field, 4);
        memcpy(&whole, field, 4);
        if (param->kind == RLV_PARAMETER_F32) {
            CHECK_NEAR(number, param->value, 1e-6 * fabs(param->value));
        } else {
            CHECK((double)whole == param->value);
        }
    }
    CHECK(find("share") != NULL && find("share")->offset == offsetof(RlvImprintSettings, share));
    CHECK(strcmp(find("max_displacement")->unit, "object units") == 0);
    CHECK(find("nothing") == NULL);
}

int main(void) {
    table();
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
    CHECK(report.voxel_diagonal > 0.0 && report.voxel_diagonal < 0.05 && report.bytes > 0);

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

    /* Pressing again where it is changes next to nothing: the dent is there already. */
    RlvImprintReport again = RLV_IMPRINT_REPORT_INIT;
    CHECK_OK(rlv_imprint_run(detail, collider, &settings, &moment, &again));
    CHECK(again.allocated_tiles == 0 && again.changed_coefficients < report.changed_coefficients / 20);
    CHECK_OK(rlv_detail_commit(detail, NULL));

    /* Rays hit the dent, and say where it is. */
    RlvCaster caster = RLV_NULL;
    RlvHit hit;
    const float origin[3] = {2.5f, 2.5f, 2.0f}, direction[3] = {0, 0, -1};
    RlvRayArrays rays = RLV_RAY_ARRAYS_INIT;
    rays.count = 1;
    rays.origins = origin;
    rays.directions = direction;
    rays.hits = &hit;
    CHECK_OK(rlv_caster_create_detail(detail, NULL, &caster));
    CHECK_OK(rlv_caster_cast(caster, &rays));
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
