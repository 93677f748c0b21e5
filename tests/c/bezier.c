/* Bezier patches: closed forms, shared edges, levels from a picture, triangles in the caller's arrays, files, garbage. */
#include "check.h"

/* Control points of the paraboloid piece z = (x - 0.5)^2 over the squares from (column, 0) on, which is exact. */
static void bow(float *points, int column) {
    static const float heights[4] = {0.25f, -1.0f / 12.0f, -1.0f / 12.0f, 0.25f};
    for (int k = 0; k < 16; ++k) {
        points[3 * k] = (float)column + (float)(k % 4) / 3.0f;
        points[3 * k + 1] = (float)(k / 4) / 3.0f;
        points[3 * k + 2] = heights[k % 4];
    }
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvBezier bezier = RLV_NULL, untouched = {77};
    RlvBezierArrays arrays = RLV_BEZIER_ARRAYS_INIT;
    RlvBezierInfo info = RLV_BEZIER_INFO_INIT;
    float points[2 * 48], strided[32][5];
    CHECK_OK(rlv_context_create(NULL, &context));
    bow(points, 0);
    bow(points + 48, 1);

    /* As they lie, and by strides and indices: the same patches. */
    arrays.points = points;
    arrays.point_count = 32;
    CHECK_OK(rlv_bezier_create(context, &arrays, &bezier));
    CHECK_OK(rlv_bezier_info(bezier, &info));
    CHECK(info.patch_count == 2 && info.curve_count == 7 && info.is_rational == 0);
    CHECK(info.low[0] == 0.0f && info.high[0] == 2.0f && info.high[1] == 1.0f);
    uint32_t indices[32][2];
    for (uint32_t k = 0; k < 32; ++k) {
        memcpy(strided[31 - k], points + 3 * k, 12);
        indices[k][0] = 31 - k;
    }
    RlvBezier named = RLV_NULL;
    arrays.points = strided[0];
    arrays.point_stride = sizeof strided[0];
    arrays.indices = indices[0];
    arrays.index_count = 32;
    arrays.index_stride = sizeof indices[0];
    CHECK_OK(rlv_bezier_create(context, &arrays, &named));
    float controls[2][16][4];
    CHECK_OK(rlv_bezier_get_controls(bezier, 1, controls[0][0], 0));
    CHECK_OK(rlv_bezier_get_controls(named, 1, controls[1][0], 16));
    CHECK(memcmp(controls[0], controls[1], sizeof controls[0]) == 0);
    CHECK(controls[0][3][0] == 2.0f && controls[0][3][3] == 1.0f);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_get_controls(bezier, 2, controls[0][0], 0), "no patch 2");
    CHECK_OK(rlv_bezier_release(named));

    /* z = (u - 0.5)^2: point, tangents, normal. */
    const uint32_t tiles[3] = {0, 1, 0};
    const float uvs[6] = {0.25f, 0.75f, 0.0f, 0.5f, 1.0f, 0.5f};
    float positions[9], normals[9], du[9], dv[9], displacements[3] = {7, 7, 7};
    RlvEvaluateArrays at = RLV_EVALUATE_ARRAYS_INIT;
    at.count = 3;
    at.tiles = tiles;
    at.uvs = uvs;
    at.positions = positions;
    at.normals = normals;
    at.du = du;
    at.dv = dv;
    at.displacements = displacements;
    CHECK_OK(rlv_bezier_evaluate(bezier, &at));
    CHECK_NEAR(positions[0], 0.25, 1e-6);
    CHECK_NEAR(positions[1], 0.75, 1e-6);
    CHECK_NEAR(positions[2], 0.0625, 1e-6);
    CHECK_NEAR(du[0], 1.0, 1e-6);
    CHECK_NEAR(du[2], -0.5, 1e-6);
    CHECK_NEAR(dv[1], 1.0, 1e-6);
    CHECK_NEAR(normals[0], 0.5 / sqrt(1.25), 1e-6);
    CHECK_NEAR(normals[2], 1.0 / sqrt(1.25), 1e-6);
    CHECK(displacements[0] == 0.0f);
    CHECK(memcmp(positions + 3, positions + 6, 12) == 0); /* the edge that both have */
    const float outside[6] = {0.25f, 0.75f, 0.0f, 0.5f, 1.5f, 0.5f};
    at.uvs = outside;
    positions[0] = 9.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_evaluate(bezier, &at), "place 2");
    CHECK(positions[0] == 9.0f);
    at.uvs = uvs;
    float duu[9], duv[9], dvv[9];
    at.duu = duu;
    at.duv = duv;
    at.dvv = dvv;
    CHECK_OK(rlv_bezier_evaluate(bezier, &at));
    for (size_t k = 0; k < 3; ++k) {
        CHECK_NEAR(duu[3 * k], 0.0, 1e-5);
        CHECK_NEAR(duu[3 * k + 2], 2.0, 1e-5);
        CHECK_NEAR(duv[3 * k + 2], 0.0, 1e-5);
        CHECK_NEAR(dvv[3 * k + 2], 0.0, 1e-5);
    }
    at.colors = controls[0][0];
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_bezier_evaluate(bezier, &at), "colors");

    /* Triangles: counts of the maps, and points of a patch where they belong. */
    RlvBezierLevels levels = RLV_BEZIER_LEVELS_INIT;
    RlvBezierTriangles room = RLV_BEZIER_TRIANGLES_INIT;
    size_t point_count = 0, triangle_count = 0;
    levels.level = 2;
    CHECK_OK(rlv_bezier_count(bezier, &levels, &point_count, &triangle_count));
    CHECK(point_count == 2 * 64 && triangle_count == 2 * 2 * 49);
    float *made = malloc(point_count * 24);
    uint32_t *corners = malloc(triangle_count * 12);
    CHECK(made != NULL && corners != NULL);
    room.positions = made;
    room.normals = made + 3;
    room.position_stride = room.normal_stride = 24;
    room.point_capacity = point_count;
    room.corners = corners;
    room.triangle_capacity = triangle_count - 1;
    made[0] = 9.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_tessellate(bezier, &levels, &room), "corners");
    CHECK(made[0] == 9.0f);
    room.triangle_capacity = triangle_count;
    CHECK_OK(rlv_bezier_tessellate(bezier, &levels, &room));
    for (size_t k = 0; k < point_count; ++k) {
        const float *point = made + 6 * k, u = point[0] - (k < 64 ? 0.0f : 1.0f);
        CHECK_NEAR(point[2], (u - 0.5f) * (u - 0.5f), 1e-5);
        CHECK_NEAR(point[3] * point[3] + point[4] * point[4] + point[5] * point[5], 1.0, 1e-5);
    }
    for (size_t k = 0; k < 3 * triangle_count; ++k) {
        CHECK(corners[k] < point_count);
    }
    /* Welded, the edge is there once. */
    RlvMesh mesh = RLV_NULL;
    RlvMeshInfo mesh_info = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_bezier_mesh(bezier, &levels, &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &mesh_info));
    CHECK(mesh_info.point_count == 2 * 64 - 8 && mesh_info.triangle_count == triangle_count);
    CHECK_OK(rlv_mesh_release(mesh));

    /* Levels that differ: the coarser patch has the finer one's points of the edge, and triangles between. */
    const uint32_t each[2] = {1, 3};
    levels.levels = each;
    levels.level_count = 2;
    CHECK_OK(rlv_bezier_count(bezier, &levels, &point_count, &triangle_count));
    CHECK(point_count == 16 + 256 + 14 && triangle_count == 2 * 9 + 2 * 225 + 3 + 15 - 2);
    free(made);
    free(corners);
    made = malloc(point_count * 12);
    CHECK(made != NULL);
    memset(&room, 0, sizeof room);
    room.struct_size = sizeof room;
    room.positions = made;
    room.point_capacity = point_count;
    CHECK_OK(rlv_bezier_tessellate(bezier, &levels, &room));
    for (int k = 1; k < 15; ++k) {
        CHECK(memcmp(made + 3 * (16 + 16 * k), made + 3 * (16 + 256 + k - 1), 12) == 0);
    }
    free(made);

    /* Nearer is finer; a coarser tolerance is coarser. */
    RlvBezierView view = RLV_BEZIER_VIEW_INIT;
    uint32_t near_levels[2] = {0, 0}, far_levels[2] = {0, 0};
    view.eye[0] = view.eye[1] = 0.5;
    view.eye[2] = 1.0;
    CHECK_OK(rlv_bezier_levels(bezier, &view, near_levels, 2));
    view.eye[2] = 1000.0;
    CHECK_OK(rlv_bezier_levels(bezier, &view, far_levels, 2));
    CHECK(near_levels[0] > far_levels[0] && far_levels[0] == 1 && near_levels[0] <= 8);
    view.tolerance = 0.0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_levels(bezier, &view, near_levels, 2), "tolerance");
    view.tolerance = 1.0;
    view.most = 9;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_levels(bezier, &view, near_levels, 2), "level");
    view.most = 8;
    view.forward[1] = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_levels(bezier, &view, near_levels, 2), "viewpoint");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_levels(bezier, &view, near_levels, 1), "levels");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_levels(bezier, NULL, near_levels, 2), "RlvBezierView");

    /* A quarter of a cylinder by weights. */
    const float root = (float)sqrt(0.5);
    FILE *file = fopen("bezier.bpt", "w");
    CHECK(file != NULL);
    fprintf(file, "1\n1 2\n1 0 0 1\n1 1 0 %.9g\n0 1 0 1\n1 0 1 1\n1 1 1 %.9g\n0 1 1 1\n", root, root);
    fclose(file);
    RlvBezier cylinder = RLV_NULL;
    CHECK_OK(rlv_bezier_read(context, "bezier.bpt", &cylinder));
    remove("bezier.bpt");
    CHECK_OK(rlv_bezier_info(cylinder, &info));
    CHECK(info.patch_count == 1 && info.is_rational == 1);
    at.colors = NULL;
    at.count = 1;
    CHECK_OK(rlv_bezier_evaluate(cylinder, &at));
    CHECK_NEAR(positions[0] * positions[0] + positions[1] * positions[1], 1.0, 1e-6);
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_bezier_read(context, "no such.bpt", &untouched), "no such.bpt");

    /* Garbage. */
    arrays.index_count = 31;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_create(context, &arrays, &untouched), "31 control points");
    arrays.index_count = 32;
    indices[5][0] = 32;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_create(context, &arrays, &untouched), "point 32 does not exist");
    indices[5][0] = 26;
    arrays.index_stride = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_create(context, &arrays, &untouched), "indices");
    arrays.index_stride = 8;
    strided[4][1] = INFINITY;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_create(context, &arrays, &untouched), "coordinate");
    strided[4][1] = 0.0f;
    float weights[32] = {0};
    arrays.weights = weights;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_create(context, &arrays, &untouched), "weight");
    arrays.points = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_create(context, &arrays, &untouched), "points");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_create(context, NULL, &untouched), "RlvBezierArrays");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_read(context, NULL, &untouched), "path");
    levels.level_count = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_count(bezier, &levels, &point_count, &triangle_count), "3 levels");
    const uint32_t wild[2] = {1, 257};
    levels.levels = wild;
    levels.level_count = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_count(bezier, &levels, &point_count, &triangle_count), "patch 1");
    levels.levels = NULL;
    levels.level = 9;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_mesh(bezier, &levels, &mesh), "level");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_tessellate(bezier, NULL, NULL), "RlvBezierTriangles");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_info((RlvBezier){context.id}, &info), "of a context");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bezier_retain((RlvBezier){0}), "NULL");
    CHECK(untouched.id == 77);

    /* Triangles beyond the memory limit. */
    RlvContext small = RLV_NULL;
    RlvContextOptions little = RLV_CONTEXT_OPTIONS_INIT;
    RlvBezier tight = RLV_NULL;
    little.threads = 1;
    little.memory_limit = 100000;
    CHECK_OK(rlv_context_create(&little, &small));
    arrays.points = points;
    arrays.point_stride = 0;
    arrays.weights = NULL;
    arrays.indices = NULL;
    CHECK_OK(rlv_bezier_create(small, &arrays, &tight));
    levels.level = 6;
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_bezier_mesh(tight, &levels, &mesh), "limit");
    CHECK_OK(rlv_bezier_release(tight));
    CHECK_OK(rlv_context_release(small));
    CHECK_OK(rlv_bezier_release(cylinder));
    CHECK_OK(rlv_bezier_release(bezier));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
