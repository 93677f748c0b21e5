/* Casting of rays against a mesh. */
#include "check.h"

enum { SIDE = 40, RAYS = SIDE * SIDE };

/* Rays from above onto a plate of 3 x 3, a few of which pass beside it. */
static void look_down(float origins[RAYS][3], float directions[RAYS][3]) {
    for (int ray = 0; ray < RAYS; ++ray) {
        origins[ray][0] = 3.2f * ((float)(ray % SIDE) + 0.37f) / SIDE - 0.1f;
        origins[ray][1] = 3.2f * ((float)(ray / SIDE) + 0.41f) / SIDE - 0.1f;
        origins[ray][2] = 2.0f;
        directions[ray][0] = 0.05f;
        directions[ray][1] = 0.02f;
        directions[ray][2] = -1.0f;
    }
}

static void dent(RlvContext context, RlvDetail detail, double x, double y, float radius) {
    RlvBrushOptions options = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvStrokePoint points[2] = {{{0, 0, 0}, 1.0, -1.0}, {{0, 0, 0}, 1.0, -1.0}};
    RlvBrush brush = RLV_NULL;
    points[0].position[0] = x;
    points[1].position[0] = x + 0.01;
    points[0].position[1] = points[1].position[1] = y;
    options.action = RLV_BRUSH_SCULPT;
    options.height = 0.2f;
    settings.radius = radius;
    CHECK_OK(rlv_brush_create(context, &options, &settings, &brush));
    CHECK_OK(rlv_stroke_run(detail, brush, points, 2, 0, NULL));
    CHECK_OK(rlv_brush_release(brush));
    CHECK_OK(rlv_detail_commit(detail, NULL));
}

/* A caster that follows finds what one of the detail finds that is made anew, and both find out what is in the way. */
static void check_same_as_new(RlvDetail detail, const RlvTessellateOptions *cells, RlvCaster caster, float *deepest) {
    static float origins[RAYS][3], directions[RAYS][3], far[RAYS];
    static RlvHit hits[RAYS], expected[RAYS];
    static uint8_t occluded[2 * RAYS];
    RlvRayArrays rays = RLV_RAY_ARRAYS_INIT;
    RlvCaster fresh = RLV_NULL;
    look_down(origins, directions);
    rays.count = RAYS;
    rays.origins = origins[0];
    rays.directions = directions[0];
    rays.hits = hits;
    CHECK_OK(rlv_caster_create_detail(detail, cells, &fresh));
    CHECK_OK(rlv_caster_cast(caster, &rays));
    rays.hits = expected;
    CHECK_OK(rlv_caster_cast(fresh, &rays));
    CHECK_OK(rlv_caster_release(fresh));
    *deepest = 2.0f;
    for (int ray = 0; ray < RAYS; ++ray) {
        CHECK(isinf(hits[ray].distance) == isinf(expected[ray].distance));
        if (!isinf(hits[ray].distance)) {
            CHECK_NEAR(hits[ray].distance, expected[ray].distance, 1e-5);
            CHECK(hits[ray].tile == expected[ray].tile && hits[ray].face == expected[ray].face);
            CHECK_NEAR(hits[ray].u, expected[ray].u, 1e-4);
            CHECK_NEAR(hits[ray].normal[2], expected[ray].normal[2], 1e-3);
            *deepest = fminf(*deepest, hits[ray].distance);
        }
    }
    /* Just behind each hit something is in the way, and just before it nothing. */
    rays.hits = NULL;
    rays.max_distances = far;
    for (int side = 0; side < 2; ++side) {
        for (int ray = 0; ray < RAYS; ++ray) {
            far[ray] = isinf(hits[ray].distance) ? INFINITY : hits[ray].distance * (side == 0 ? 0.999f : 1.001f);
        }
        CHECK_OK(rlv_caster_occluded(caster, &rays, occluded, 2));
        for (int ray = 0; ray < RAYS; ++ray) {
            CHECK(occluded[2 * ray] == (side == 1 && !isinf(hits[ray].distance)));
        }
    }
}

static void check_follows(RlvContext context) {
    RlvMesh plane = check_plane(context, 3, 3);
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvTessellateOptions cells = RLV_TESSELLATE_OPTIONS_INIT;
    RlvTessellation tessellation = RLV_NULL;
    RlvTessellationChanges changes = RLV_TESSELLATION_CHANGES_INIT;
    RlvCaster caster = RLV_NULL, other = {77};
    float flat, dented, more;
    options.tile_size = 32;
    cells.coarse = cells.fine = 32;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_tessellation_create(detail, &cells, &tessellation));
    CHECK_OK(rlv_caster_create_tessellation(tessellation, &caster));
    check_same_as_new(detail, &cells, caster, &flat);
    dent(context, detail, 1.5, 1.5, 0.4f);
    CHECK_OK(rlv_tessellation_update(tessellation, &changes));
    CHECK(changes.rebuilt == 0 && changes.point_count > 0);
    CHECK_OK(rlv_caster_update(caster));
    check_same_as_new(detail, &cells, caster, &dented);
    CHECK(dented < flat - 0.1f);
    /* Several updates are caught up with at once. */
    for (int k = 0; k < 3; ++k) {
        dent(context, detail, 0.5 + k, 0.5, 0.3f);
        CHECK_OK(rlv_tessellation_update(tessellation, NULL));
    }
    CHECK_OK(rlv_caster_update(caster));
    CHECK_OK(rlv_caster_update(caster));
    check_same_as_new(detail, &cells, caster, &more);
    CHECK_OK(rlv_tessellation_release(tessellation));
    CHECK_OK(rlv_caster_release(caster));

    /* Finer triangles where something came to be. */
    cells.coarse = 8;
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_tessellation_create(detail, &cells, &tessellation));
    CHECK_OK(rlv_caster_create_tessellation(tessellation, &caster));
    dent(context, detail, 1.5, 1.5, 0.4f);
    CHECK_OK(rlv_tessellation_update(tessellation, &changes));
    CHECK(changes.rebuilt == 1);
    CHECK_OK(rlv_caster_update(caster));
    check_same_as_new(detail, &cells, caster, &dented);
    CHECK_OK(rlv_caster_release(caster));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_update(caster), "not alive");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_create_tessellation((RlvTessellation){3}, &other), "tessellation");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_create_tessellation(tessellation, NULL), "out");
    CHECK(other.id == 77);
    CHECK_OK(rlv_caster_create_mesh(context, plane, &other));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_update(other), "follows nothing");
    CHECK_OK(rlv_caster_release(other));
    CHECK_OK(rlv_tessellation_release(tessellation));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvCaster caster = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh plane = check_plane(context, 8, 8);
    CHECK_OK(rlv_caster_create_mesh(context, plane, &caster));
    CHECK_OK(rlv_mesh_release(plane));

    /* From above onto face 19, from below, past the plane, and away from it. */
    static const float origins[4][4] = {{3.25f, 2.5f, 2, 9}, {3.25f, 2.5f, -1, 9}, {-1, 2, 2, 9}, {3, 2, 2, 9}};
    static const float directions[4][3] = {{0, 0, -1}, {0, 0, 2}, {0, 0, -1}, {0, 0, 1}};
    RlvHit hits[4];
    memset(hits, 0, sizeof(hits));
    RlvRayArrays rays = RLV_RAY_ARRAYS_INIT;
    rays.count = 4;
    rays.origins = origins[0];
    rays.origin_stride = sizeof(origins[0]);
    rays.directions = directions[0];
    rays.hits = hits;
    CHECK_OK(rlv_caster_cast(caster, &rays));
    CHECK_NEAR(hits[0].distance, 2, 1e-5);
    CHECK_NEAR(hits[0].position[0], 3.25, 1e-5);
    CHECK_NEAR(hits[0].position[2], 0, 1e-5);
    CHECK_NEAR(hits[0].normal[2], 1, 1e-6);
    CHECK(hits[0].face == 19 && hits[0].tile == RLV_NO_ELEMENT);
    CHECK_NEAR(hits[1].distance, 0.5, 1e-5);
    CHECK_NEAR(hits[1].normal[2], 1, 1e-6);
    CHECK(isinf(hits[2].distance) && hits[2].face == RLV_NO_ELEMENT && hits[2].normal[2] == 0.0f);
    CHECK(isinf(hits[3].distance));

    /* Limits of distance. */
    rays.count = 1;
    rays.max_distance = 1.5f;
    CHECK_OK(rlv_caster_cast(caster, &rays));
    CHECK(isinf(hits[0].distance));
    rays.min_distance = 2.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_cast(caster, &rays), "min_distance");
    rays.min_distance = 0.0f;
    rays.max_distance = 0.0f;

    /* Rays without a direction, not finite or too far away hit nothing, and those between them what they hit alone. */
    static const float some_origins[7][3] = {{3.25f, 2.5f, 2},    {3.25f, 2.5f, 2}, {3.25f, 2.5f, 2},   {3.25f, NAN, 2},
                                             {3.25f, 2.5f, 1e30f}, {3.25f, 2.5f, 2}, {3.25f, 2.5f, 2}};
    static const float some_directions[7][3] = {{0, 0, -1}, {0, 0, 0},         {0, NAN, -1}, {0, 0, -1},
                                                {0, 0, -1}, {0, 0, -INFINITY}, {0, 0, -2}};
    RlvHit some[7];
    memset(some, 7, sizeof(some));
    rays.count = 7;
    rays.origins = some_origins[0];
    rays.origin_stride = 0;
    rays.directions = some_directions[0];
    rays.hits = some;
    CHECK_OK(rlv_caster_cast(caster, &rays));
    for (int ray = 1; ray < 6; ++ray) {
        CHECK(isinf(some[ray].distance) && some[ray].face == RLV_NO_ELEMENT && some[ray].normal[2] == 0.0f);
    }
    CHECK(some[0].face == 19 && some[6].face == 19);
    CHECK_NEAR(some[0].distance, 2, 1e-5);
    CHECK_NEAR(some[6].distance, 1, 1e-5);
    /* Distances of their own: only those between which something lies. */
    static const float near[7] = {0, 0, 0, 0, 0, 0, 1.5f}, far[7] = {1.5f, 3, 3, 3, 3, 3, INFINITY};
    uint8_t occluded[7];
    rays.min_distances = near;
    rays.max_distances = far;
    CHECK_OK(rlv_caster_cast(caster, &rays));
    CHECK(isinf(some[0].distance) && isinf(some[6].distance));
    static const float wrong[7] = {-1, 0, 0, 0, 0, 0, NAN};
    rays.min_distances = wrong;
    rays.max_distances = NULL;
    CHECK_OK(rlv_caster_cast(caster, &rays));
    CHECK(isinf(some[0].distance) && isinf(some[6].distance));
    rays.min_distances = NULL;
    CHECK_OK(rlv_caster_occluded(caster, &rays, occluded, 0));
    for (int ray = 0; ray < 7; ++ray) {
        CHECK(occluded[ray] == (ray == 0 || ray == 6));
    }
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_occluded(caster, &rays, NULL, 0), "occluded");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_occluded(caster, NULL, occluded, 0), "RlvRayArrays");
    rays.origins = origins[0];
    rays.directions = directions[0];
    rays.hits = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_cast(caster, &rays), "hits");
    rays.count = 0;
    CHECK_OK(rlv_caster_cast(caster, &rays));

    CHECK_OK(rlv_caster_release(caster));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_cast(caster, &rays), "not alive");
    check_follows(context);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
