/* Casting of rays against a mesh. */
#include "check.h"

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
    rays.origins = origins[0];
    rays.directions = directions[0];
    rays.hits = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_cast(caster, &rays), "hits");
    rays.count = 0;
    CHECK_OK(rlv_caster_cast(caster, &rays));

    CHECK_OK(rlv_caster_release(caster));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_caster_cast(caster, &rays), "not alive");
    CHECK_OK(rlv_context_release(context));
    return 0;
}
