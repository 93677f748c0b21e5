/* Surfaces: tiles, bounds, poses, options and what is refused. */
#include "check.h"

int main(void) {
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh plane = check_plane(context, 3, 2);
    RlvSurface surface = RLV_NULL;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_mesh_release(plane));

    RlvSurfaceInfo info = RLV_SURFACE_INFO_INIT;
    CHECK_OK(rlv_surface_info(surface, &info));
    CHECK(info.tile_count == 6 && info.face_count == 6 && info.point_count == 12 && info.non_manifold == 0);
    CHECK(info.patch_count >= 6 && info.bytes > 0);
    CHECK_NEAR(info.low[0], 0, 1e-5);
    CHECK_NEAR(info.high[0], 3, 1e-5);
    CHECK_NEAR(info.high[1], 2, 1e-5);
    CHECK_NEAR(info.extent, sqrt(13.0), 1e-4);

    RlvTileInfo tile = RLV_TILE_INFO_INIT;
    CHECK_OK(rlv_surface_tile_info(surface, 4, &tile));
    CHECK(tile.face == 4 && tile.corner == 0 && tile.is_part == 0 && tile.is_hole == 0);
    CHECK(tile.low[0] <= 1.0f && tile.high[0] >= 2.0f && tile.low[0] > 0.5f && tile.high[0] < 2.5f);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_surface_tile_info(surface, 6, &tile), "the surface has 6 tiles");

    /* A triangle is three tiles. */
    static const float points[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint32_t corners[] = {0, 1, 2};
    RlvMeshArrays arrays = check_faces(points, 3, 3, 1, corners);
    RlvMesh triangle = RLV_NULL;
    RlvSurface parts = RLV_NULL;
    uint32_t first = 9, count = 9;
    CHECK_OK(rlv_mesh_create(context, &arrays, &triangle));
    CHECK_OK(rlv_surface_create(context, triangle, NULL, &parts));
    CHECK_OK(rlv_surface_face_tiles(parts, 0, &first, &count));
    CHECK(first == 0 && count == 3);
    CHECK_OK(rlv_surface_tile_info(parts, 2, &tile));
    CHECK(tile.face == 0 && tile.corner == 2 && tile.is_part == 1);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_surface_face_tiles(parts, 1, &first, &count), "face 1 does not exist");
    CHECK_OK(rlv_surface_release(parts));

    /* Options out of range. */
    RlvSurfaceOptions options = RLV_SURFACE_OPTIONS_INIT;
    RlvSurface untouched = {77};
    options.boundary = 5;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_surface_create(context, triangle, &options, &untouched), "boundary");
    options.boundary = RLV_BOUNDARY_EDGES;
    options.isolation = 11;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_surface_create(context, triangle, &options, &untouched), "isolation");
    options.isolation = 8;
    options.patch_limit = 1;
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_surface_create(context, triangle, &options, &untouched), "patches");
    CHECK(untouched.id == 77);
    CHECK_OK(rlv_mesh_release(triangle));

    /* A crease between points that no face connects means nothing, and nothing is printed about it. */
    static const uint32_t diagonal[] = {0, 5};
    static const float sharpness = 3.0f;
    static const uint32_t quad[] = {0, 1, 3, 2};
    static const float flat[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 5, 5, 5, 6, 6, 6};
    RlvMeshArrays creased = check_faces(flat, 6, 4, 1, quad);
    RlvMesh loose = RLV_NULL;
    RlvSurface smooth = RLV_NULL;
    creased.creases = diagonal;
    creased.crease_sharpness = &sharpness;
    creased.crease_count = 1;
    CHECK_OK(rlv_mesh_create(context, &creased, &loose));
    CHECK_OK(rlv_surface_create(context, loose, NULL, &smooth));
    CHECK_OK(rlv_surface_release(smooth));
    CHECK_OK(rlv_mesh_release(loose));

    /* Another pose of the same cage. */
    float raised[36];
    for (int point = 0; point < 12; ++point) {
        raised[3 * point] = 2.0f * (float)(point % 4);
        raised[3 * point + 1] = (float)(point / 4);
        raised[3 * point + 2] = 5.0f;
    }
    CHECK_OK(rlv_surface_set_points(surface, raised, 12, 0));
    CHECK_OK(rlv_surface_info(surface, &info));
    CHECK_NEAR(info.low[2], 5, 1e-5);
    CHECK_NEAR(info.high[0], 6, 1e-5);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_surface_set_points(surface, raised, 11, 0), "11 points");
    raised[7] = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_surface_set_points(surface, raised, 12, 0), "point 2");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_surface_set_points(surface, NULL, 12, 0), "NULL");
    CHECK_OK(rlv_surface_info(surface, &info));
    CHECK_NEAR(info.low[2], 5, 1e-5);

    CHECK_OK(rlv_surface_release(surface));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_surface_info(surface, &info), "not alive");
    CHECK_OK(rlv_context_release(context));
    return 0;
}
