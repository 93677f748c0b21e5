/* Repairs: a torn, twisted soup becomes a closed box with its texture coordinates, and wrong calls are refused. */
#include "check.h"

enum { TRIANGLES = 14 };

/* A unit cube of triangles that share no point, one of them missing and one turned over, then a triangle that repeats a
 * point, one with a coordinate that is no number, and one that occurs twice. */
static void soup(float *points, uint32_t *corners, float *uvs) {
    static const uint32_t cube[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                         {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    for (uint32_t triangle = 0; triangle < TRIANGLES; ++triangle) {
        const uint32_t *source = cube[triangle < 11 ? triangle : triangle - 11];
        for (uint32_t side = 0; side < 3; ++side) {
            uint32_t corner = 3 * triangle + side, vertex = source[triangle == 5 ? 2 - side : side];
            points[3 * corner] = (float)(vertex & 1);
            points[3 * corner + 1] = (float)(vertex >> 1 & 1);
            points[3 * corner + 2] = (float)(vertex >> 2);
            corners[corner] = corner;
            uvs[2 * corner] = (float)triangle;
            uvs[2 * corner + 1] = (float)vertex;
        }
    }
    corners[3 * 11 + 1] = corners[3 * 11];
    points[9 * 12] = NAN;
}

static uint32_t cancel(void *user, float fraction, const char *stage) {
    (void)user, (void)fraction, (void)stage;
    return RLV_PROGRESS_CANCEL;
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvMesh made = RLV_NULL, again = RLV_NULL, untouched = {77};
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    RlvRepairReport report = RLV_REPAIR_REPORT_INIT, checked = RLV_REPAIR_REPORT_INIT;
    float points[9 * TRIANGLES], uvs[6 * TRIANGLES];
    uint32_t corners[3 * TRIANGLES];
    CHECK_OK(rlv_context_create(NULL, &context));
    soup(points, corners, uvs);
    RlvMeshArrays arrays = check_faces(points, 3 * TRIANGLES, 3, TRIANGLES, corners);
    RlvAttributeArrays uv = RLV_ATTRIBUTE_ARRAYS_INIT;
    uv.domain = RLV_DOMAIN_POINT;
    uv.type = RLV_TYPE_F32;
    uv.width = 2;
    uv.name = "uv";
    uv.values = uvs;
    uv.value_count = 3 * TRIANGLES;

    /* What a mesh refuses, a repair takes. */
    CHECK(rlv_mesh_create(context, &arrays, &untouched) != RLV_OK && untouched.id == 77);
    CHECK_OK(rlv_repair_arrays(context, &arrays, &uv, 1, NULL, NULL, NULL, &report, &made));
    CHECK(report.invalid_faces.count == 1 && report.invalid_faces.first[0] == 12);
    CHECK(report.invalid_faces.first[1] == UINT32_MAX && report.invalid_faces.first[2] == UINT32_MAX);
    CHECK(report.degenerate_faces.count == 1 && report.degenerate_faces.first[0] == 11);
    CHECK(report.duplicate_faces.count == 1 && report.duplicate_faces.first[0] == 13);
    CHECK(report.misoriented_edges.count == 3 && report.turned_faces == 1);
    CHECK(report.holes.count == 1 && report.filled_holes == 1 && report.open_holes.count == 0);
    CHECK(report.filling_faces == 1 && report.filling_points == 0 && report.seam_attributes == 1);
    CHECK(report.before.faces == 11 && report.before.boundary_edges == 3 && report.is_solid == 0);
    CHECK(report.after.points == 8 && report.after.faces == 12 && report.after.edges == 18 && report.after.euler == 2);
    CHECK(report.after.components == 1 && report.after.closed_components == 1);
    CHECK_NEAR(report.after.volume, 1.0, 1e-12);
    CHECK_NEAR(report.after.area, 6.0, 1e-12);

    /* Texture coordinates differed where points were welded: they are on corners now, as they were. */
    RlvAttributeInfo about = RLV_ATTRIBUTE_INFO_INIT;
    uint32_t number = 77, indices[36], faces[36];
    float values[6 * TRIANGLES];
    CHECK_OK(rlv_mesh_find_attribute(made, "uv", &number));
    CHECK_OK(rlv_mesh_attribute_info(made, number, &about));
    CHECK(about.domain == RLV_DOMAIN_CORNER && about.index_count == 36 && about.value_count == 3 * TRIANGLES);
    CHECK_OK(rlv_mesh_get_attribute(made, number, values, 6 * TRIANGLES, indices, 36));
    CHECK_OK(rlv_mesh_get_faces(made, NULL, 0, faces, 36));
    float places[24];
    CHECK_OK(rlv_mesh_get_points(made, places, 8, 0));
    for (size_t corner = 0; corner < 36; ++corner) {
        const float *place = places + 3 * faces[corner];
        CHECK(values[2 * indices[corner] + 1] == place[0] + 2 * place[1] + 4 * place[2]);
        CHECK(corner >= 33 || values[2 * indices[corner]] == (float)(corner / 3));
    }

    /* Nothing is left to be repaired. */
    CHECK_OK(rlv_repair_check(made, NULL, NULL, NULL, &checked));
    CHECK(checked.is_solid == 1 && checked.holes.count == 0 && checked.holes.first[0] == UINT32_MAX);
    CHECK(memcmp(&checked.before, &report.after, sizeof checked.before) == 0);
    CHECK(memcmp(&checked.before, &checked.after, sizeof checked.before) == 0);

    /* Steps are left out when they are switched off; in the background it is the same. */
    RlvRepairSettings settings = RLV_REPAIR_SETTINGS_INIT;
    settings.fill = 0;
    settings.listed = 0;
    RlvMesh open = RLV_NULL;
    CHECK_OK(rlv_repair_arrays(context, &arrays, NULL, 0, &settings, NULL, NULL, &report, &open));
    CHECK(report.after.boundary_edges == 3 && report.open_holes.count == 1 && report.open_holes.first[0] == UINT32_MAX);
    RlvJob job = RLV_NULL;
    CHECK_OK(rlv_job_repair(open, NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_mesh(job, &again));
    CHECK_OK(rlv_job_repair_report(job, &checked));
    CHECK(checked.filled_holes == 1 && checked.after.faces == 12);
    CHECK_OK(rlv_mesh_info(again, &info));
    CHECK(info.face_count == 12 && info.point_count == 8);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_imprint_report(job, NULL), "not started for");
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_mesh_release(again));

    /* Files that a mesh cannot be read from. */
    char path[64];
    snprintf(path, sizeof path, "repair-%p.off", (void *)&context);
    FILE *file = fopen(path, "w");
    CHECK(file != NULL);
    CHECK(fputs("OFF\n4 5 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n3 2 2 1\n", file) >= 0);
    CHECK(fclose(file) == 0);
    CHECK(rlv_mesh_read(context, path, &untouched) != RLV_OK && untouched.id == 77);
    CHECK_OK(rlv_repair_read(context, path, NULL, NULL, NULL, &report, &again));
    CHECK(report.degenerate_faces.count == 1 && report.after.closed_components == 1);
    CHECK_NEAR(report.after.volume, 1.0 / 6.0, 1e-12);
    CHECK(remove(path) == 0);
    CHECK_OK(rlv_mesh_release(again));
    CHECK(rlv_repair_read(context, path, NULL, NULL, NULL, NULL, &untouched) == RLV_ERROR_NOT_FOUND);

    /* The table is the settings. */
    const RlvParameter *params = NULL;
    size_t count = 0;
    CHECK_OK(rlv_repair_params(&params, &count));
    CHECK(4 * count + 4 == sizeof settings && strcmp(params[1].name, "tolerance") == 0 && params[6].value == 1.0);

    /* Refusals. */
    report.holes.count = 77;
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_repair_mesh(open, NULL, cancel, NULL, &report, &untouched), "cancelled");
    settings.tolerance = -1.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_repair_mesh(open, &settings, NULL, NULL, &report, &untouched), "tolerance");
    settings.struct_size = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_repair_check(open, &settings, NULL, NULL, &report), "struct_size");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_repair_check(open, NULL, NULL, NULL, NULL), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_repair_mesh(open, NULL, NULL, NULL, &report, NULL), "out");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_repair_arrays(context, NULL, NULL, 0, NULL, NULL, NULL, NULL, &untouched), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_repair_arrays(context, &arrays, NULL, 1, NULL, NULL, NULL, NULL, &untouched), "NULL");
    uv.value_count = 5;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_repair_arrays(context, &arrays, &uv, 1, NULL, NULL, NULL, NULL, &untouched), "`uv`");
    for (size_t corner = 0; corner < arrays.corner_count; ++corner) {
        corners[corner] = UINT32_MAX;
    }
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_repair_arrays(context, &arrays, NULL, 0, NULL, NULL, NULL, NULL, &untouched), "no face");
    CHECK(untouched.id == 77 && report.holes.count == 77);
    CHECK_OK(rlv_mesh_release(open));
    CHECK(rlv_repair_check(open, NULL, NULL, NULL, &report) != RLV_OK);
    CHECK_OK(rlv_mesh_release(made));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
