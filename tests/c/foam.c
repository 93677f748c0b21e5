/* Foam: one particle in closed form, chunks in any order, light, composition in place, and what is refused. */
#include "sheet.h"

enum { WIDTH = 33, HEIGHT = 25, PIXELS = WIDTH * HEIGHT, MIDDLE = PIXELS / 2, CLOUD = 500 };

static RlvFoamView view_of(void) {
    RlvFoamView view = RLV_FOAM_VIEW_INIT;
    view.width = WIDTH;
    view.height = HEIGHT;
    view.eye[2] = 5;
    view.up[1] = 1;
    view.up[2] = 0;
    view.fov = 0.8;
    return view;
}

static RlvFoam make(RlvContext context, const RlvFoamView *view) {
    RlvFoamSettings settings = RLV_FOAM_SETTINGS_INIT;
    RlvFoam foam = RLV_NULL;
    settings.radius = 0.5f;
    CHECK_OK(rlv_foam_create(context, view, &settings, &foam));
    return foam;
}

/* The middle pixel of a particle of each kind. */
static void check_one(RlvContext context) {
    static const float expected[3] = {1, 1, 0}, radius[3] = {0.5f, 0.5f, 0.25f};
    const float position[3] = {0, 0, 0};
    for (uint32_t kind = 0; kind < 3; ++kind) {
        const RlvFoamView view = view_of();
        RlvFoam foam = make(context, &view);
        RlvFoamParticles particles = RLV_FOAM_PARTICLES_INIT;
        float intensity[PIXELS], thickness[PIXELS], depth[PIXELS], normal[PIXELS][3], occlusion[PIXELS], light[PIXELS][3];
        RlvFoamLayers layers = RLV_FOAM_LAYERS_INIT;
        particles.count = 1;
        particles.positions = position;
        particles.kinds = &kind;
        CHECK_OK(rlv_foam_add(foam, &particles));
        CHECK_OK(rlv_foam_shade(foam, NULL, NULL, NULL));
        layers.intensity = intensity;
        layers.thickness = thickness;
        layers.depth = depth;
        layers.normal = normal[0];
        layers.occlusion = occlusion;
        layers.irradiance = light[0];
        CHECK_OK(rlv_foam_get(foam, &layers));
        CHECK_NEAR(thickness[MIDDLE], expected[kind], 1e-5);
        CHECK_NEAR(intensity[MIDDLE], expected[kind] / 4, 1e-5);
        CHECK_NEAR(depth[MIDDLE], 5 - radius[kind], 1e-5);
        CHECK_NEAR(normal[MIDDLE][2], 1, 1e-5);
        CHECK(occlusion[MIDDLE] == 0.0f);
        CHECK_NEAR(light[MIDDLE][0], kind == RLV_FOAM_BUBBLE ? 0 : 1, 1e-5);
        CHECK(isinf(depth[0]) && thickness[0] == 0.0f && normal[0][2] == 0.0f);
        check_idle(foam.id, "foam");
        CHECK_OK(rlv_foam_release(foam));
    }
}

static void composite(RlvContext context, const float (*cloud)[4], int backwards, float *picture) {
    float solids[PIXELS];
    RlvFoamView view = view_of();
    RlvFoamParticles particles = RLV_FOAM_PARTICLES_INIT;
    const float radiance[2][3] = {{1, 2, INFINITY}, {1, 0, 0}};
    RlvFoamLight light = RLV_FOAM_LIGHT_INIT;
    uint32_t ids[CLOUD];
    int left = 1000;
    for (int pixel = 0; pixel < PIXELS; ++pixel) {
        solids[pixel] = pixel % WIDTH < WIDTH / 2 ? 5.2f : INFINITY;
    }
    view.solids = solids;
    RlvFoam foam = make(context, &view);
    for (uint32_t at = 0; at < CLOUD; ++at) {
        ids[at] = at;
    }
    particles.position_stride = particles.life_stride = sizeof cloud[0];
    for (int part = 0; part < 2; ++part) {
        const int first = (part ^ backwards) * CLOUD / 2;
        particles.count = CLOUD / 2;
        particles.positions = cloud[first];
        particles.lives = &cloud[first][3];
        particles.ids = ids + first;
        CHECK_OK(rlv_foam_add(foam, &particles));
    }
    light.width = 2;
    light.height = 1;
    light.radiance = radiance[0];
    CHECK_OK(rlv_foam_shade(foam, &light, check_patience, &left));
    for (int at = 0; at < 4 * PIXELS; ++at) {
        picture[at] = 0.25f;
    }
    CHECK_OK(rlv_foam_composite(foam, picture, 4, picture));
    CHECK_OK(rlv_foam_release(foam));
}

/* The same picture for chunks in both orders, and alpha as it was. */
static void check_order(RlvContext context) {
    static float cloud[CLOUD][4], first[4 * PIXELS], second[4 * PIXELS];
    uint32_t state = 7;
    for (int at = 0; at < 4 * CLOUD; ++at) {
        state = state * 1664525u + 1013904223u;
        cloud[at / 4][at % 4] = (float)(state >> 8) / 16777216.0f * (at % 4 == 3 ? 1.0f : 2.0f) - (at % 4 == 3 ? 0.0f : 1.0f);
    }
    composite(context, (const float(*)[4])cloud, 0, first);
    composite(context, (const float(*)[4])cloud, 1, second);
    CHECK(memcmp(first, second, sizeof first) == 0);
    CHECK(first[4 * MIDDLE] != 0.25f && first[4 * MIDDLE + 3] == 0.25f);
}

static void check_refusals(RlvContext context) {
    RlvFoamView view = view_of();
    RlvFoamSettings settings = RLV_FOAM_SETTINGS_INIT;
    RlvFoamParticles particles = RLV_FOAM_PARTICLES_INIT;
    RlvFoamLight light = RLV_FOAM_LIGHT_INIT;
    RlvFoamLayers layers = RLV_FOAM_LAYERS_INIT;
    RlvFoam foam = RLV_NULL;
    float picture[3 * PIXELS] = {0}, positions[2][3] = {{0, 0, 0}, {0, NAN, 0}};
    const float radiance[2][3] = {{1, 1, 1}, {1, -1, 1}};
    uint32_t kinds[2] = {0, 3};
    int left = 0;
    settings.rho_mod = -1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_foam_create(context, &view, &settings, &foam), "rho_mod");
    view.width = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_foam_create(context, &view, NULL, &foam), "pixels");
    view = view_of();
    view.eye[2] = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_foam_create(context, &view, NULL, &foam), "direction");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_foam_create(context, NULL, NULL, &foam), "NULL");
    CHECK(foam.id == 0);
    view = view_of();
    foam = make(context, &view);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_foam_get(foam, &layers), "rlv_foam_shade");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_foam_composite(foam, picture, 3, picture), "rlv_foam_shade");
    particles.count = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_foam_add(foam, &particles), "positions");
    particles.positions = positions[0];
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_foam_add(foam, &particles), "particle 1");
    positions[1][1] = 0;
    particles.kinds = kinds;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_foam_add(foam, &particles), "kind 3");
    light.width = light.height = 1;
    light.radiance = radiance[0];
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_foam_shade(foam, &light, NULL, NULL), "twice");
    light.width = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_foam_shade(foam, &light, NULL, NULL), "negative");
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_foam_shade(foam, NULL, check_patience, &left), "");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_foam_add(foam, &particles), "shaded");
    CHECK_OK(rlv_foam_release(foam));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_foam_add(foam, &particles), "");

    const RlvParameter *params = NULL;
    size_t count = 0;
    CHECK_OK(rlv_foam_params(&params, &count));
    CHECK(count > 30 && strcmp(params[0].name, "radius") == 0 && params[0].offset == sizeof(uint32_t));
}

int main(void) {
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    check_one(context);
    check_order(context);
    check_refusals(context);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
