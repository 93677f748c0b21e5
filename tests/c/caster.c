/* Casting of rays against meshes and details, masks, and rays that hit nothing, of isosurfaces too. */
#include "check.h"

#include <stddef.h>

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

/* Whether a ray from above with a mask meets a caster. */
static int meets(RlvCaster caster, uint32_t mask) {
    static const float origin[3] = {1.4f, 1.3f, 2}, direction[3] = {0, 0, -1};
    RlvRayArrays rays = RLV_RAY_ARRAYS_INIT;
    uint8_t occluded = 77;
    rays.count = 1;
    rays.origins = origin;
    rays.directions = direction;
    rays.masks = &mask;
    CHECK_OK(rlv_caster_occluded(caster, &rays, &occluded, 0));
    return occluded;
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
    CHECK_OK(rlv_caster_set_mask(caster, 2));
    dent(context, detail, 1.5, 1.5, 0.4f);
    CHECK_OK(rlv_tessellation_update(tessellation, &changes));
    CHECK(changes.rebuilt == 0 && changes.point_count > 0);
    CHECK_OK(rlv_caster_update(caster));
    CHECK(meets(caster, 2) && !meets(caster, 5));
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
    CHECK_OK(rlv_caster_set_mask(caster, 2));
    CHECK_OK(rlv_caster_update(caster));
    CHECK(meets(caster, 2) && !meets(caster, 5));
    check_same_as_new(detail, &cells, caster, &dented);
    CHECK_OK(rlv_caster_release(caster));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_update(caster), "not alive");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_set_mask(caster, 1), "not alive");
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

/* Rays from 2 above a surface at z = 0, and whether they hit it. Distances are their own. */
static const struct {
    float origin[3], direction[3], near, far;
    uint32_t mask;
    int hits;
} TABLE[] = {
    {{3.25f, 2.5f, 2}, {0, 0, -1}, 0, INFINITY, UINT32_MAX, 1},
    {{3.25f, 2.5f, 2}, {0, 0, -1}, 0.5f, 3, 4, 1},
    {{NAN, 2.5f, 2}, {0, 0, -1}, 0, INFINITY, UINT32_MAX, 0},
    {{3.25f, 2.5f, INFINITY}, {0, 0, -1}, 0, INFINITY, UINT32_MAX, 0},
    {{3.25f, 2.5f, 2e12f}, {0, 0, -1}, 0, INFINITY, UINT32_MAX, 0},
    {{3.25f, 2.5f, 2}, {0, 0, 0}, 0, INFINITY, UINT32_MAX, 0},
    {{3.25f, 2.5f, 2}, {0, NAN, -1}, 0, INFINITY, UINT32_MAX, 0},
    {{3.25f, 2.5f, 2}, {0, 0, -INFINITY}, 0, INFINITY, UINT32_MAX, 0},
    {{3.25f, 2.5f, 2}, {0, 0, -2e12f}, 0, INFINITY, UINT32_MAX, 0},
    {{3.25f, 2.5f, 2}, {0, 0, -1}, NAN, INFINITY, UINT32_MAX, 0},
    {{3.25f, 2.5f, 2}, {0, 0, -1}, -1, INFINITY, UINT32_MAX, 0},
    {{3.25f, 2.5f, 2}, {0, 0, -1}, -INFINITY, INFINITY, UINT32_MAX, 0},
    {{3.25f, 2.5f, 2}, {0, 0, -1}, 0, NAN, UINT32_MAX, 0},
    {{3.25f, 2.5f, 2}, {0, 0, -1}, 0, -1, UINT32_MAX, 0},
    {{3.25f, 2.5f, 2}, {0, 0, -1}, 3, 0.5f, UINT32_MAX, 0},
    {{3.25f, 2.5f, 2}, {0, 0, -1}, 0, INFINITY, 0, 0},
    {{3.25f, 2.5f, 2}, {0, 0, -2}, 0, INFINITY, 1, 1},
};
enum { TRIED = sizeof TABLE / sizeof TABLE[0] };

static RlvRayArrays tried(void) {
    RlvRayArrays rays = RLV_RAY_ARRAYS_INIT;
    rays.count = TRIED;
    rays.origins = TABLE[0].origin;
    rays.directions = TABLE[0].direction;
    rays.min_distances = &TABLE[0].near;
    rays.max_distances = &TABLE[0].far;
    rays.masks = &TABLE[0].mask;
    rays.origin_stride = rays.direction_stride = sizeof TABLE[0];
    rays.min_distance_stride = rays.max_distance_stride = rays.mask_stride = sizeof TABLE[0];
    return rays;
}

static void check_caster_of_table(RlvCaster caster) {
    RlvHit hits[TRIED];
    uint8_t occluded[TRIED];
    RlvRayArrays rays = tried();
    memset(hits, 7, sizeof hits);
    rays.hits = hits;
    CHECK_OK(rlv_caster_cast(caster, &rays));
    CHECK_OK(rlv_caster_occluded(caster, &rays, occluded, 0));
    for (int ray = 0; ray < TRIED; ++ray) {
        CHECK(isinf(hits[ray].distance) == !TABLE[ray].hits && occluded[ray] == TABLE[ray].hits);
        CHECK((hits[ray].face == RLV_NO_ELEMENT) == !TABLE[ray].hits && (hits[ray].normal[2] == 0.0f) == !TABLE[ray].hits);
    }
}

/* What hits nothing is the same for meshes, details and isosurfaces; the others of a call are cast. */
static void check_bad_rays(RlvContext context) {
    const float point[3] = {3.25f, 2.5f, 0};
    const RlvIsosurfaceHit nothing = {INFINITY, {0}, {0}, {0}, 0};
    RlvMesh plane = check_plane(context, 8, 8);
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvCaster casters[2] = {RLV_NULL, RLV_NULL};
    RlvIsosurfaceParticles particle = RLV_ISOSURFACE_PARTICLES_INIT;
    RlvIsosurfaceOptions options = RLV_ISOSURFACE_OPTIONS_INIT;
    RlvIsosurface sphere = RLV_NULL;
    RlvIsosurfaceTable table = RLV_ISOSURFACE_TABLE_INIT;
    RlvIsosurfaceHit hits[TRIED];
    RlvRayArrays rays = tried();
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    CHECK_OK(rlv_caster_create_mesh(context, plane, &casters[0]));
    CHECK_OK(rlv_caster_create_detail(detail, NULL, &casters[1]));
    particle.count = 1;
    particle.points = point;
    options.radius = 0.25f;
    CHECK_OK(rlv_isosurface_create(context, &particle, &options, &sphere));
    CHECK_OK(rlv_isosurface_table(sphere, &table));
    check_caster_of_table(casters[0]);
    check_caster_of_table(casters[1]);
    memset(hits, 7, sizeof hits);
    CHECK_OK(rlv_isosurface_cast(sphere, &rays, hits, 0));
    for (int ray = 0; ray < TRIED; ++ray) {
        CHECK(isinf(hits[ray].distance) == !TABLE[ray].hits);
        CHECK(TABLE[ray].hits || memcmp(&hits[ray], &nothing, sizeof nothing) == 0);
        /* One by one they have no masks. */
        if (TABLE[ray].mask != 0) {
            RlvIsosurfaceRay one = {{0}, {0}, TABLE[ray].near, TABLE[ray].far, 0};
            RlvIsosurfaceHit hit;
            memcpy(one.origin, TABLE[ray].origin, sizeof one.origin);
            memcpy(one.direction, TABLE[ray].direction, sizeof one.direction);
            CHECK(table.intersect(table.data, &one, &hit) == (uint32_t)TABLE[ray].hits);
            CHECK(memcmp(&hit, &hits[ray], sizeof hit) == 0);
        }
    }
    /* Distances of all rays are an argument of the call. */
    static const float wrong[4][2] = {{-1, 2}, {3, 2}, {NAN, 2}, {0, NAN}};
    RlvHit met[TRIED];
    uint8_t occluded[TRIED];
    rays.hits = met;
    for (int k = 0; k < 4; ++k) {
        rays.min_distance = wrong[k][0];
        rays.max_distance = wrong[k][1];
        for (int caster = 0; caster < 2; ++caster) {
            CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_cast(casters[caster], &rays), "min_distance");
            CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_occluded(casters[caster], &rays, occluded, 0), "min_distance");
        }
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_cast(sphere, &rays, hits, 0), "min_distance");
    }
    CHECK_OK(rlv_isosurface_release(sphere));
    CHECK_OK(rlv_caster_release(casters[0]));
    CHECK_OK(rlv_caster_release(casters[1]));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
}

/* A ray meets the casters with which it shares a bit. Hosts of before masks have rays of all bits. */
static void check_masks(RlvCaster caster) {
    static const float origins[5][3] = {{3.25f, 2.5f, 2}, {3.25f, 2.5f, 2}, {3.25f, 2.5f, 2}, {3.25f, 2.5f, 2}, {3.25f, 2.5f, 2}};
    static const float directions[5][3] = {{0, 0, -1}, {0, 0, -1}, {0, 0, -1}, {0, 0, -1}, {0, 0, -1}};
    static const uint32_t masks[5][2] = {{1, 9}, {2, 9}, {6, 9}, {UINT32_MAX, 9}, {0, 9}};
    static const uint32_t of_caster[4] = {UINT32_MAX, 2, 12, 0};
    RlvHit hits[5];
    uint8_t occluded[5];
    RlvRayArrays rays = RLV_RAY_ARRAYS_INIT;
    rays.count = 5;
    rays.origins = origins[0];
    rays.directions = directions[0];
    rays.hits = hits;
    rays.masks = masks[0];
    rays.mask_stride = sizeof masks[0];
    for (int k = 0; k < 4; ++k) {
        CHECK_OK(rlv_caster_set_mask(caster, of_caster[k]));
        CHECK_OK(rlv_caster_cast(caster, &rays));
        CHECK_OK(rlv_caster_occluded(caster, &rays, occluded, 0));
        for (int ray = 0; ray < 5; ++ray) {
            const int shares = (masks[ray][0] & of_caster[k]) != 0;
            CHECK(isinf(hits[ray].distance) == !shares && occluded[ray] == shares);
        }
    }
    rays.mask_stride = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_cast(caster, &rays), "masks");
    rays.mask_stride = 0;
    CHECK_OK(rlv_caster_set_mask(caster, 8));
    rays.struct_size = (uint32_t)offsetof(RlvRayArrays, masks);
    CHECK_OK(rlv_caster_cast(caster, &rays));
    for (int ray = 0; ray < 5; ++ray) {
        CHECK(hits[ray].face == 19);
    }
    rays.struct_size -= 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_cast(caster, &rays), "struct_size");
    CHECK_OK(rlv_caster_set_mask(caster, UINT32_MAX));
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

    /* Distances of their own, one after the other: those between which nothing lies. */
    static const float near[4] = {0, 0.4f, 0, 0}, far[4] = {1.5f, INFINITY, 3, 0};
    uint8_t occluded[4];
    rays.count = 4;
    rays.min_distances = near;
    rays.max_distances = far;
    CHECK_OK(rlv_caster_cast(caster, &rays));
    CHECK_OK(rlv_caster_occluded(caster, &rays, occluded, 0));
    for (int ray = 0; ray < 4; ++ray) {
        CHECK(occluded[ray] == (ray == 1) && isinf(hits[ray].distance) == (ray != 1));
    }
    check_masks(caster);
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
    check_bad_rays(context);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
