/* Foam on a graphics device: 999 of 1,000 pixels are within 1/255 of the processor's, and where there is no device, or it is
 * lost or has no room, that is said and the processor draws. With the argument "none", where no driver can be found: what
 * happens then. */
#include "gpu.h"

enum { WIDTH = 64, HEIGHT = 48, PIXELS = WIDTH * HEIGHT, CLOUD = 2000 };

static float positions[CLOUD][3], velocities[CLOUD][3], lives[CLOUD], solids[PIXELS], fluid[PIXELS];
static uint32_t kinds[CLOUD];

static void make_cloud(void) {
    uint32_t state = 7;
    for (int at = 0; at < CLOUD; ++at) {
        for (int axis = 0; axis < 3; ++axis) {
            state = state * 1664525u + 1013904223u;
            positions[at][axis] = (float)(state >> 8) / 8388608.0f - 1.0f;
            velocities[at][axis] = positions[at][axis];
        }
        lives[at] = (float)(at % 97) / 97.0f;
        kinds[at] = (uint32_t)at % 3;
    }
    for (int pixel = 0; pixel < PIXELS; ++pixel) {
        solids[pixel] = pixel % WIDTH < WIDTH / 4 ? 5.2f : INFINITY;
        fluid[pixel] = 4.8f;
    }
}

static RlvFoam make(RlvContext context) {
    RlvFoamView view = RLV_FOAM_VIEW_INIT;
    RlvFoamSettings settings = RLV_FOAM_SETTINGS_INIT;
    RlvFoam foam = RLV_NULL;
    view.width = WIDTH;
    view.height = HEIGHT;
    view.eye[2] = 5;
    view.up[1] = 1;
    view.up[2] = 0;
    view.solids = solids;
    view.fluid = fluid;
    settings.radius = 0.2f;
    settings.ao_max_samp = 48;
    settings.aperture = 0.1f;
    settings.focus = 4.5f;
    settings.shutter = 0.05f;
    settings.shutter_samples = 2;
    CHECK_OK(rlv_foam_create(context, &view, &settings, &foam));
    return foam;
}

static RlvResult add(RlvFoam foam) {
    RlvFoamParticles particles = RLV_FOAM_PARTICLES_INIT;
    particles.count = CLOUD;
    particles.positions = positions[0];
    particles.velocities = velocities[0];
    particles.kinds = kinds;
    particles.lives = lives;
    return rlv_foam_add(foam, &particles);
}

/* Lays foam over a picture, and releases it. */
static void draw(RlvFoam foam, float *picture) {
    CHECK_OK(add(foam));
    CHECK_OK(rlv_foam_shade(foam, NULL, NULL, NULL));
    for (int at = 0; at < 3 * PIXELS; ++at) {
        picture[at] = 0.25f;
    }
    CHECK_OK(rlv_foam_composite(foam, picture, 3, picture));
    CHECK_OK(rlv_foam_release(foam));
}

static int far_pixels(const float *a, const float *b, float tolerance) {
    int count = 0;
    for (int pixel = 0; pixel < PIXELS; ++pixel) {
        int is_far = 0;
        for (int channel = 0; channel < 3; ++channel) {
            is_far |= fabsf(a[3 * pixel + channel] - b[3 * pixel + channel]) > tolerance;
        }
        count += is_far;
    }
    return count;
}

static void hear(void *user, uint32_t level, const char *text) {
    CHECK(level == RLV_LOG_WARNING && strstr(text, "the processor draws foam") != NULL);
    ++*(int *)user;
}

int main(int argc, char **argv) {
    static float expected[3 * PIXELS], found[3 * PIXELS], grey[3 * PIXELS];
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvContextInfo info = RLV_CONTEXT_INFO_INIT;
    RlvContext context = RLV_NULL;
    RlvAdapterInfo adapters[16];
    size_t count = 0;
    int heard = 0;
    make_cloud();
    options.threads = 1;
    options.device = RLV_DEVICE_AUTO;
    CHECK_OK(rlv_context_create(&options, &context));
    for (int at = 0; at < 3 * PIXELS; ++at) {
        grey[at] = 0.25f;
    }
    CHECK_OK(rlv_adapter_list(adapters, 16, &count));
    if (count == 0) {
        draw(make(context), expected);
        CHECK(far_pixels(expected, grey, 0.1f) > PIXELS / 10);
        CHECK_OK(rlv_context_release(context));
        if (argc > 1 && strcmp(argv[1], "none") == 0) {
            return 0;
        }
        check_skipped();
    }
    CHECK_OK(rlv_context_release(context));
    options.device = RLV_DEVICE_CPU;
    CHECK_OK(rlv_context_create(&options, &context));
    draw(make(context), expected);
    CHECK(far_pixels(expected, grey, 0.1f) > PIXELS / 10);
    CHECK_OK(rlv_context_release(context));

    /* The device has the pixels, and the picture is the processor's. */
    options.device = RLV_DEVICE_GPU;
    options.adapter = adapters[count - 1].name;
    CHECK_OK(rlv_context_create(&options, &context));
    CHECK_OK(rlv_context_set_log(context, hear, &heard));
    RlvFoam foam = make(context);
    CHECK_OK(rlv_context_info(context, &info));
    CHECK(info.device == RLV_DEVICE_GPU && info.device_memory >= 48 * PIXELS);
    draw(foam, found);
    CHECK_OK(rlv_context_info(context, &info));
    CHECK(info.device_memory == 0 && heard == 0);
    CHECK(far_pixels(found, expected, 1.0f / 255.0f) <= PIXELS / 1000);
    /* Foam that is begun needs its device; what is made afterwards is the processor's. */
    foam = make(context);
    CHECK_OK(rlv_context_close_device(context));
    CHECK_FAILS(RLV_ERROR_DEVICE, add(foam), "");
    CHECK_OK(rlv_foam_release(foam));
    draw(make(context), found);
    CHECK(memcmp(found, expected, sizeof found) == 0);
    CHECK_OK(rlv_context_release(context));

    /* A device without room. */
    options.device_memory_limit = 1 << 20;
    CHECK_OK(rlv_context_create(&options, &context));
    CHECK_OK(rlv_context_set_log(context, hear, &heard));
    draw(make(context), found);
    CHECK(heard == 1 && memcmp(found, expected, sizeof found) == 0);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
