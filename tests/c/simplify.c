/* Simplification: attributes and seams are kept, points stay, and what makes no sense is refused. */
#include "sheet.h"

/* Writes the texture coordinates of a mesh that has them on corners, and the point of every corner. */
static size_t read_uvs(RlvMesh mesh, float **points, uint32_t **corners, float **uvs, uint32_t **indices) {
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    RlvAttributeInfo about = RLV_ATTRIBUTE_INFO_INIT;
    uint32_t uv = 0;
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK_OK(rlv_mesh_find_attribute(mesh, "uv", &uv));
    CHECK_OK(rlv_mesh_attribute_info(mesh, uv, &about));
    CHECK(about.domain == RLV_DOMAIN_CORNER && about.width == 2 && about.index_count == info.corner_count);
    *points = malloc(info.point_count * 12), *corners = malloc(info.corner_count * 4);
    *uvs = malloc(about.value_count * 8), *indices = malloc(about.index_count * 4);
    CHECK(*points != NULL && *corners != NULL && *uvs != NULL && *indices != NULL);
    CHECK_OK(rlv_mesh_get_points(mesh, *points, info.point_count, 0));
    CHECK_OK(rlv_mesh_get_faces(mesh, NULL, 0, *corners, info.corner_count));
    CHECK_OK(rlv_mesh_get_attribute(mesh, uv, *uvs, about.value_count * 2, *indices, about.index_count));
    return info.corner_count;
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvMesh made = RLV_NULL, untouched = {77};
    RlvMeshInfo info = RLV_MESH_INFO_INIT, before = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh sheet = check_sheet(context, 24, 16, 0.0f);
    CHECK_OK(rlv_mesh_info(sheet, &before));

    /* Texture coordinates are those of the places where points went; points that are locked have not gone. */
    const uint32_t locked[2] = {30, 31};
    const RlvSimplifyWeight weights[1] = {{"uv", 0.1f, 0}};
    RlvSimplifyOptions options = RLV_SIMPLIFY_OPTIONS_INIT;
    float error = -1.0f, *points, *uvs;
    uint32_t *corners, *indices;
    options.triangles = 60;
    options.weights = weights;
    options.weight_count = 1;
    options.locked = locked;
    options.locked_count = 2;
    CHECK_OK(rlv_simplify_mesh(sheet, &options, NULL, NULL, &error, &made));
    CHECK(error >= 0.0f && error < 0.01f);
    CHECK_OK(rlv_mesh_info(made, &info));
    CHECK(info.triangle_count == info.face_count && info.face_count <= 60 && info.face_count >= 59);
    size_t count = read_uvs(made, &points, &corners, &uvs, &indices);
    for (size_t corner = 0; corner < count; ++corner) {
        const float *point = points + 3 * (size_t)corners[corner], *uv = uvs + 2 * (size_t)indices[corner];
        CHECK(fabsf(uv[0] - point[0] / 24.0f) < 1e-4f && fabsf(uv[1] - point[1] / 16.0f) < 1e-4f);
    }
    int found = 0;
    for (size_t point = 0; point < info.point_count; ++point) {
        found += points[3 * point] == 5.0f && points[3 * point + 1] == 1.0f;
        found += points[3 * point] == 6.0f && points[3 * point + 1] == 1.0f;
    }
    CHECK(found == 2);
    free(points), free(corners), free(uvs), free(indices);
    CHECK_OK(rlv_mesh_release(made));

    /* Without options as few as can be; without the attribute too. */
    CHECK_OK(rlv_simplify_mesh(sheet, NULL, NULL, NULL, NULL, &made));
    CHECK_OK(rlv_mesh_info(made, &info));
    CHECK(info.face_count < 10 && info.attribute_count == 1);
    CHECK_OK(rlv_mesh_release(made));
    RlvSimplifyWeight out[1] = {{"uv", 0.0f, 1}};
    options.weights = out;
    CHECK_OK(rlv_simplify_mesh(sheet, &options, NULL, NULL, NULL, &made));
    CHECK_OK(rlv_mesh_info(made, &info));
    CHECK(info.attribute_count == 0 && info.face_count <= 60);
    CHECK_OK(rlv_mesh_release(made));

    /* In the background: the same mesh, which cannot be changed meanwhile. */
    RlvJob job = RLV_NULL;
    RlvMesh again = RLV_NULL;
    float deviation = -1.0f;
    CHECK_OK(rlv_simplify_mesh(sheet, &options, NULL, NULL, &error, &made));
    CHECK_OK(rlv_job_simplify(sheet, &options, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_mesh(job, &again));
    CHECK_OK(rlv_job_simplify_error(job, &deviation));
    CHECK(deviation == error);
    CHECK_OK(rlv_mesh_info(made, &info));
    CHECK_OK(rlv_mesh_info(again, &before));
    CHECK(memcmp(&info, &before, sizeof info) == 0);
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_mesh_release(again));
    CHECK_OK(rlv_mesh_release(made));

    /* Where factors are greater, more is left. */
    RlvMesh ball = check_ball(context, 1.0);
    CHECK_OK(rlv_mesh_info(ball, &before));
    float *factors = malloc(before.point_count * 4);
    points = malloc(before.point_count * 12);
    CHECK(factors != NULL && points != NULL);
    CHECK_OK(rlv_mesh_get_points(ball, points, before.point_count, 0));
    for (size_t point = 0; point < before.point_count; ++point) {
        factors[point] = points[3 * point + 2] > 0.0f ? 1000.0f : 1.0f;
    }
    RlvSimplifyOptions uneven = RLV_SIMPLIFY_OPTIONS_INIT;
    uneven.triangles = 500;
    uneven.factors = factors;
    uneven.factor_count = before.point_count;
    CHECK_OK(rlv_simplify_mesh(ball, &uneven, NULL, NULL, NULL, &made));
    CHECK_OK(rlv_mesh_info(made, &info));
    CHECK(info.point_count < before.point_count);
    CHECK_OK(rlv_mesh_get_points(made, points, before.point_count, 0));
    size_t above = 0;
    for (size_t point = 0; point < info.point_count; ++point) {
        above += points[3 * point + 2] > 0.0f;
    }
    CHECK(4 * above > 3 * info.point_count);
    CHECK_OK(rlv_mesh_release(made));
    free(factors), free(points);

    /* A bound is never exceeded: points of the ball stay within it, and error is what was measured. Borders may stay. */
    RlvSimplifyOptions bounded = RLV_SIMPLIFY_OPTIONS_INIT;
    CHECK(bounded.bound < 0.0f && bounded.is_border_locked == 0);
    bounded.bound = 0.02f;
    CHECK_OK(rlv_simplify_mesh(ball, &bounded, NULL, NULL, &error, &made));
    CHECK(error > 0.0f && error <= 0.02f);
    CHECK_OK(rlv_mesh_info(made, &info));
    CHECK(info.face_count > 8 && 2 * info.face_count < before.triangle_count);
    points = malloc(info.point_count * 12);
    CHECK(points != NULL);
    CHECK_OK(rlv_mesh_get_points(made, points, info.point_count, 0));
    for (size_t point = 0; point < info.point_count; ++point) {
        const float *p = points + 3 * point;
        CHECK(sqrtf(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) <= 1.02f + 1e-5f);
    }
    free(points);
    CHECK_OK(rlv_mesh_release(made));
    float measured = -1.0f;
    CHECK_OK(rlv_job_simplify(ball, &bounded, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_simplify_error(job, &measured));
    CHECK(measured == error);
    CHECK_OK(rlv_job_release(job));
    bounded.bound = -1.0f;
    bounded.is_border_locked = 1;
    CHECK_OK(rlv_simplify_mesh(sheet, &bounded, NULL, NULL, NULL, &made));
    CHECK_OK(rlv_mesh_info(made, &info));
    CHECK(info.point_count >= 2 * (24 + 16));
    CHECK_OK(rlv_mesh_release(made));
    bounded.is_border_locked = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_simplify_mesh(sheet, &bounded, NULL, NULL, NULL, &untouched), "is_border_locked");
    bounded.is_border_locked = 0;
    bounded.bound = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_simplify_mesh(sheet, &bounded, NULL, NULL, NULL, &untouched), "bound");

    /* Refused, and nothing written. */
    int patience = 1;
    CHECK(rlv_simplify_mesh(ball, NULL, check_patience, &patience, &error, &untouched) == RLV_ERROR_CANCELLED);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_simplify_mesh(ball, &options, NULL, NULL, NULL, &untouched), "no attribute `uv`");
    out[0].is_left_out = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_simplify_mesh(sheet, &options, NULL, NULL, NULL, &untouched), "is_left_out");
    out[0].is_left_out = 0;
    out[0].weight = -1.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_simplify_mesh(sheet, &options, NULL, NULL, NULL, &untouched), "weight");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_simplify(sheet, &options, &job), "weight");
    options.weight_count = 0;
    options.locked = (const uint32_t[1]){100000};
    options.locked_count = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_simplify_mesh(sheet, &options, NULL, NULL, NULL, &untouched), "locked");
    options.locked_count = 0;
    options.factors = (const float[1]){1.0f};
    options.factor_count = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_simplify_mesh(sheet, &options, NULL, NULL, NULL, &untouched), "factors");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_simplify_mesh(sheet, NULL, NULL, NULL, NULL, NULL), "out");
    CHECK(untouched.id == 77);

    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_mesh_release(sheet));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
