/* Subdivision surfaces: schemes, boundaries, primvars of every interpolation, poses, refined meshes, what is refused. */
#include "check.h"

/* Two triangles, or one quad, over the unit square, with the height of the last point at 1. */
static RlvMesh square(RlvContext context, uint32_t face_size) {
    static const float points[] = {0, 0, 0, 1, 0, 0, 1, 1, 1, 0, 1, 0};
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
    const uint32_t *corners = face_size == 3 ? triangles : (const uint32_t[]){0, 1, 2, 3};
    return check_mesh_of(context, points, 4, face_size, face_size == 3 ? 2 : 1, corners);
}

static void add(RlvMesh mesh, const char *name, uint32_t domain, uint32_t type, uint32_t width, const void *values,
                size_t count) {
    RlvAttributeArrays arrays = RLV_ATTRIBUTE_ARRAYS_INIT;
    arrays.name = name;
    arrays.domain = domain;
    arrays.type = type;
    arrays.width = width;
    arrays.values = values;
    arrays.value_count = count;
    CHECK_OK(rlv_mesh_add_attribute(mesh, &arrays));
}

int main(void) {
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvSubdivision made = RLV_NULL, untouched = {77};
    RlvSubdivisionOptions options = RLV_SUBDIVISION_OPTIONS_INIT;
    RlvSubdivisionInfo info = RLV_SUBDIVISION_INFO_INIT;

    /* A bilinear square: z = u v, and primvars of every interpolation. */
    RlvMesh quad = square(context, 4);
    const float heat[] = {0, 10, 20, 10}, uv[] = {0, 0, 2, 0, 2, 2, 0, 2}, tint[] = {0.25f, 0.5f, 0.75f, 1};
    const uint32_t slot[] = {7};
    add(quad, "heat", RLV_DOMAIN_POINT, RLV_TYPE_F32, 1, heat, 4);
    add(quad, "uv", RLV_DOMAIN_CORNER, RLV_TYPE_F32, 2, uv, 4);
    add(quad, "tint", RLV_DOMAIN_FACE, RLV_TYPE_F32, 4, tint, 1);
    add(quad, "material", RLV_DOMAIN_FACE, RLV_TYPE_U32, 1, slot, 1);
    options.scheme = RLV_SCHEME_BILINEAR;
    options.face_varying = RLV_FACE_VARYING_ALL;
    CHECK_OK(rlv_subdivision_create(context, quad, &options, &made));
    CHECK_OK(rlv_subdivision_info(made, &info));
    CHECK(info.scheme == RLV_SCHEME_BILINEAR && info.tile_count == 1 && info.face_count == 1 && info.point_count == 4);
    const uint32_t tiles[] = {0, 0};
    const float uvs[] = {0.25f, 0.5f, 1.0f, 1.0f};
    struct { float value[4], padding; } values[2];
    float du[2][3], dv[2][3], duv[2][3];
    RlvSubdivisionArrays at = RLV_SUBDIVISION_ARRAYS_INIT;
    at.count = 2;
    at.tiles = tiles;
    at.uvs = uvs;
    at.values = values[0].value;
    at.value_stride = sizeof values[0];
    at.du = du[0];
    at.dv = dv[0];
    at.duv = duv[0];
    CHECK_OK(rlv_subdivision_evaluate(made, NULL, &at));
    CHECK_NEAR(values[0].value[0], 0.25, 1e-6);
    CHECK_NEAR(values[0].value[2], 0.125, 1e-6);
    CHECK_NEAR(values[1].value[2], 1.0, 1e-6);
    CHECK_NEAR(du[0][0], 1.0, 1e-6);
    CHECK_NEAR(du[0][2], 0.5, 1e-6);
    CHECK_NEAR(dv[0][2], 0.25, 1e-6);
    CHECK_NEAR(duv[0][2], 1.0, 1e-5);
    at.du = at.dv = at.duv = NULL;
    CHECK_OK(rlv_subdivision_evaluate(made, "uv", &at));
    CHECK_NEAR(values[0].value[0], 0.5, 1e-6);
    CHECK_NEAR(values[0].value[1], 1.0, 1e-6);
    at.point_rule = RLV_POINT_VARYING;
    CHECK_OK(rlv_subdivision_evaluate(made, "heat", &at));
    CHECK_NEAR(values[0].value[0], 7.5, 1e-5);
    CHECK_OK(rlv_subdivision_evaluate(made, "tint", &at));
    CHECK(memcmp(values[1].value, tint, sizeof tint) == 0);
    at.point_rule = 0;
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_subdivision_evaluate(made, "material", &at), "material");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_subdivision_evaluate(made, "st", &at), "st");

    /* Another pose, and what leaves it alone. */
    const float moved[] = {0, 0, 5, 1, 0, 5, 1, 1, 5, 0, 1, 5}, bad[] = {0, 0, 5, 1, 0, 5, 1, 1, (float)NAN, 0, 1, 5};
    CHECK_OK(rlv_subdivision_set_points(made, moved, 4, 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_set_points(made, moved, 3, 0), "3 points");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_set_points(made, bad, 4, 0), "point 2");
    CHECK_OK(rlv_subdivision_evaluate(made, NULL, &at));
    CHECK_NEAR(values[0].value[2], 5.0, 1e-6);
    values[0].value[0] = 9.0f;
    at.uvs = (const float[]){0.25f, 0.5f, 1.5f, 0.0f};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_evaluate(made, NULL, &at), "place 1");
    CHECK(values[0].value[0] == 9.0f);
    at.uvs = uvs;
    at.point_rule = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_evaluate(made, NULL, &at), "point_rule");
    at.point_rule = 0;

    /* Refined: 16 faces with the attributes. */
    RlvMesh refined = RLV_NULL;
    RlvMeshInfo mesh_info = RLV_MESH_INFO_INIT;
    uint32_t index = 9, first = 9, count = 9;
    CHECK_OK(rlv_subdivision_refine(made, 2, &refined));
    CHECK_OK(rlv_mesh_info(refined, &mesh_info));
    CHECK(mesh_info.face_count == 16 && mesh_info.point_count == 25 && mesh_info.attribute_count == 4);
    CHECK_OK(rlv_mesh_find_attribute(refined, "material", &index));
    uint32_t materials[16];
    CHECK_OK(rlv_mesh_get_attribute(refined, index, materials, 16, NULL, 0));
    CHECK(materials[0] == 7 && materials[15] == 7);
    CHECK_OK(rlv_mesh_release(refined));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_refine(made, 0, &refined), "level");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_refine(made, 11, &refined), "level");
    CHECK_OK(rlv_subdivision_face_tiles(made, 0, &first, &count));
    CHECK(first == 0 && count == 1);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_face_tiles(made, 1, &first, &count), "1 faces");
    CHECK_OK(rlv_subdivision_retain(made));
    CHECK_OK(rlv_subdivision_release(made));
    CHECK_OK(rlv_subdivision_release(made));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_info(made, &info), "subdivision");

    /* Loop takes triangles alone; its tiles are the triangles. */
    options = (RlvSubdivisionOptions)RLV_SUBDIVISION_OPTIONS_INIT;
    options.scheme = RLV_SCHEME_LOOP;
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_subdivision_create(context, quad, &options, &untouched), "face 0");
    RlvMesh triangles = square(context, 3);
    CHECK_OK(rlv_subdivision_create(context, triangles, &options, &made));
    CHECK_OK(rlv_subdivision_info(made, &info));
    CHECK(info.tile_count == 2);
    CHECK_OK(rlv_subdivision_evaluate(made, NULL, (at.uvs = (const float[]){0, 0, 0.25f, 0.25f}, &at)));
    CHECK_NEAR(values[0].value[0], 1.0 / 6.0, 1e-5); /* a smooth boundary point: 4 parts of itself, 1 of each neighbour */
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_evaluate(made, NULL, (at.uvs = (const float[]){0, 0, 0.75f, 0.75f}, &at)),
                "place 1");
    CHECK_OK(rlv_subdivision_release(made));

    /* Without its boundary nothing of a square is left: zeros, and no mesh. */
    options.boundary = RLV_BOUNDARY_NONE;
    CHECK_OK(rlv_subdivision_create(context, triangles, &options, &made));
    CHECK_OK(rlv_subdivision_evaluate(made, NULL, (at.uvs = (const float[]){0, 0, 0.25f, 0.25f}, &at)));
    CHECK(values[1].value[0] == 0.0f);
    CHECK(rlv_subdivision_refine(made, 1, &refined) != RLV_OK);
    CHECK_OK(rlv_subdivision_release(made));

    /* The same rules of surfaces that hold detail. */
    RlvSurfaceOptions surface_options = RLV_SURFACE_OPTIONS_INIT;
    RlvSurface surface = RLV_NULL;
    surface_options.kind = RLV_SURFACE_BILINEAR;
    CHECK_OK(rlv_surface_create(context, quad, &surface_options, &surface));
    float position[3];
    RlvEvaluateArrays place = RLV_EVALUATE_ARRAYS_INIT;
    place.count = 1;
    place.tiles = tiles;
    place.uvs = uvs;
    place.positions = position;
    CHECK_OK(rlv_evaluate_surface(surface, &place));
    CHECK_NEAR(position[2], 0.125, 1e-6);
    CHECK_OK(rlv_surface_release(surface));
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_surface_create(context, triangles, &surface_options, &surface), "quads");
    RlvMesh plane = check_plane(context, 4, 3);
    RlvTileInfo tile = RLV_TILE_INFO_INIT;
    surface_options.kind = RLV_SURFACE_CATMULL_CLARK;
    surface_options.boundary = RLV_BOUNDARY_NONE;
    CHECK_OK(rlv_surface_create(context, plane, &surface_options, &surface));
    uint32_t holes = 0;
    for (uint32_t k = 0; k < 12; ++k) {
        CHECK_OK(rlv_surface_tile_info(surface, k, &tile));
        holes += tile.is_hole;
    }
    CHECK(holes == 10);
    CHECK_OK(rlv_surface_release(surface));

    /* What is refused. */
    options = (RlvSubdivisionOptions)RLV_SUBDIVISION_OPTIONS_INIT;
    options.scheme = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_create(context, quad, &options, &untouched), "scheme");
    options.scheme = 0;
    options.boundary = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_create(context, quad, &options, &untouched), "boundary");
    options.boundary = 0;
    options.face_varying = 6;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_create(context, quad, &options, &untouched), "face_varying");
    options.face_varying = 0;
    options.creasing = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_create(context, quad, &options, &untouched), "creasing");
    options.creasing = 0;
    options.triangle_rule = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_create(context, quad, &options, &untouched), "triangle_rule");
    options.triangle_rule = 0;
    options.isolation = 11;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_create(context, quad, &options, &untouched), "isolation");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_subdivision_create(context, quad, NULL, NULL), "out");
    CHECK(untouched.id == 77);

    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_mesh_release(triangles));
    CHECK_OK(rlv_mesh_release(quad));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
