/* States of fluids: one that is restored goes on to the same bits as the one that was saved, from a file and from bytes, with
 * what its particles carry; and what is no state, or of another fluid, is refused and changes nothing. */
#include "check.h"

enum { DAM = 512, MOST = 2048 };
static const double low[3] = {0, 0, 0}, high[3] = {0.16, 0.16, 0.16}, far_end[3] = {0.32, 0.16, 0.32};
static const char path[] = "state_of_fluid.rlvfluid";

/* A fluid in a basin with an emitter, but for its particles. */
static RlvFluid basin(RlvContext context, uint32_t solver, float spacing) {
    RlvFluid fluid = RLV_NULL;
    RlvFluidOptions options = RLV_FLUID_OPTIONS_INIT;
    RlvFluidEmitterOptions tap = RLV_FLUID_EMITTER_OPTIONS_INIT;
    const float red[3] = {1, 0, 0};
    RlvAttributeArrays color = RLV_ATTRIBUTE_ARRAYS_INIT;
    options.solver = solver;
    options.spacing = spacing;
    CHECK_OK(rlv_fluid_create(context, &options, &fluid));
    CHECK_OK(rlv_fluid_set_basin(fluid, low, far_end));
    color.domain = RLV_DOMAIN_POINT;
    color.type = RLV_TYPE_F32;
    color.name = "color";
    color.width = 3;
    color.values = red;
    color.value_count = 1;
    tap.center[0] = 0.25f;
    tap.center[1] = 0.08f;
    tap.center[2] = 0.25f;
    tap.u[2] = -1.0f;
    tap.radius = 0.03f;
    tap.lifetime = 0.05f;
    tap.channels = &color;
    tap.channel_count = 1;
    CHECK_OK(rlv_fluid_add_emitter(fluid, (RlvMesh){0}, NULL, &tap));
    return fluid;
}

static size_t count_of(RlvFluid fluid) {
    RlvFluidInfo info = RLV_FLUID_INFO_INIT;
    CHECK_OK(rlv_fluid_info(fluid, &info));
    return info.particle_count;
}

/* All that particles have is the same, to the bit. */
static void check_same(RlvFluid fluid, RlvFluid other) {
    static float points[2][MOST][3], velocities[2][MOST][3], pressures[2][MOST], colors[2][MOST][3];
    static uint32_t numbers[2][MOST];
    static double births[2][MOST];
    const RlvFluid both[2] = {fluid, other};
    const size_t count = count_of(fluid);
    CHECK(count > DAM && count <= MOST && count_of(other) == count);
    for (int k = 0; k < 2; ++k) {
        RlvFluidArrays arrays = RLV_FLUID_ARRAYS_INIT;
        uint32_t index = 77;
        arrays.capacity = MOST;
        arrays.points = points[k][0];
        arrays.velocities = velocities[k][0];
        arrays.pressures = pressures[k];
        arrays.numbers = numbers[k];
        arrays.births = births[k];
        CHECK_OK(rlv_fluid_get(both[k], &arrays));
        CHECK_OK(rlv_fluid_find_channel(both[k], "color", &index));
        CHECK_OK(rlv_fluid_get_channel(both[k], index, colors[k][0], MOST, 0));
    }
    CHECK(memcmp(points[0], points[1], count * sizeof *points[0]) == 0);
    CHECK(memcmp(velocities[0], velocities[1], count * sizeof *velocities[0]) == 0);
    CHECK(memcmp(pressures[0], pressures[1], count * sizeof *pressures[0]) == 0);
    CHECK(memcmp(numbers[0], numbers[1], count * sizeof *numbers[0]) == 0);
    CHECK(memcmp(births[0], births[1], count * sizeof *births[0]) == 0);
    CHECK(memcmp(colors[0], colors[1], count * sizeof *colors[0]) == 0);
}

static void check_goes_on(RlvContext context, uint32_t solver) {
    RlvFluid fluid = basin(context, solver, 0.02f), filed = basin(context, solver, 0.02f), other = basin(context, solver, 0.02f);
    RlvBytes made = RLV_NULL;
    const uint8_t *bytes = NULL;
    size_t size = 0;
    const uint32_t gone[2] = {5, 100};
    CHECK_OK(rlv_fluid_add_box(fluid, low, high, NULL));
    CHECK_OK(rlv_fluid_advance(fluid, 0.03, NULL, NULL, NULL));
    CHECK_OK(rlv_fluid_remove(fluid, gone, 2, 0, NULL));
    CHECK_OK(rlv_fluid_save(fluid, path));
    CHECK_OK(rlv_fluid_save_bytes(fluid, &made));
    CHECK_OK(rlv_bytes_get(made, &bytes, &size));
    CHECK(size > 8 && memcmp(bytes, "RLVFLUID", 8) == 0);
    CHECK_OK(rlv_fluid_restore(filed, path));
    CHECK_OK(rlv_fluid_restore_bytes(other, bytes, size));
    check_same(fluid, other);
    for (int k = 0; k < 3; ++k) {
        CHECK_OK(rlv_fluid_advance(fluid, 0.01, NULL, NULL, NULL));
        CHECK_OK(rlv_fluid_advance(filed, 0.01, NULL, NULL, NULL));
        CHECK_OK(rlv_fluid_advance(other, 0.01, NULL, NULL, NULL));
        check_same(fluid, filed);
        check_same(fluid, other);
    }
    /* Back to what was saved, in the fluid itself. */
    CHECK_OK(rlv_fluid_restore(fluid, path));
    CHECK_OK(rlv_fluid_advance(fluid, 0.01, NULL, NULL, NULL));
    CHECK_OK(rlv_fluid_restore_bytes(filed, bytes, size));
    CHECK_OK(rlv_fluid_advance(filed, 0.01, NULL, NULL, NULL));
    check_same(fluid, filed);
    CHECK_OK(rlv_bytes_release(made));
    CHECK_OK(rlv_fluid_release(fluid));
    CHECK_OK(rlv_fluid_release(filed));
    CHECK_OK(rlv_fluid_release(other));
    remove(path);
}

static void check_refused(RlvContext context) {
    RlvFluid fluid = basin(context, RLV_FLUID_PCISPH, 0.02f), coarse = basin(context, RLV_FLUID_PCISPH, 0.04f);
    RlvParticles particles = RLV_NULL;
    size_t size = 0;
    CHECK_OK(rlv_fluid_add_box(fluid, low, high, NULL));
    CHECK_OK(rlv_fluid_advance(fluid, 0.01, NULL, NULL, NULL));
    RlvBytes made = RLV_NULL;
    const uint8_t *data = NULL;
    CHECK_OK(rlv_fluid_save_bytes(fluid, &made));
    CHECK_OK(rlv_bytes_get(made, &data, &size));
    uint8_t *bytes = (uint8_t *)malloc(size);
    CHECK(bytes != NULL);
    memcpy(bytes, data, size);
    CHECK_OK(rlv_bytes_release(made));
    const size_t count = count_of(fluid);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_restore_bytes(coarse, bytes, size), "apart");
    CHECK(count_of(coarse) == 0);

    /* Bytes that are cut off, or of which one is another. */
    for (size_t length = 0; length < size; length += 1 + size / 97) {
        CHECK(rlv_fluid_restore_bytes(fluid, bytes, length) == RLV_ERROR_INVALID);
    }
    for (size_t at = 0; at < size; at += 1 + size / 97) {
        bytes[at] ^= 0x55;
        CHECK(rlv_fluid_restore_bytes(fluid, bytes, size) != RLV_OK);
        bytes[at] ^= 0x55;
    }
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_restore_bytes(fluid, NULL, 8), "bytes");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_save_bytes(fluid, NULL), "out");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_fluid_restore(fluid, "no/such/file.rlvfluid"), "no/such/file");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_fluid_save(fluid, "no/such/file.rlvfluid"), "no/such/file");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_save(fluid, NULL), "path");

    /* Particles alone are no state. */
    CHECK_OK(rlv_fluid_particles(fluid, &particles));
    CHECK_OK(rlv_particles_write(particles, "particles_alone.rlvfluid"));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_restore(fluid, "particles_alone.rlvfluid"), "no state");
    CHECK_OK(rlv_particles_release(particles));
    remove("particles_alone.rlvfluid");
    CHECK(count_of(fluid) == count);

    RlvContextOptions small = RLV_CONTEXT_OPTIONS_INIT;
    RlvContext poor = RLV_NULL;
    small.memory_limit = 300000;
    CHECK_OK(rlv_context_create(&small, &poor));
    RlvFluid little = RLV_NULL;
    CHECK_OK(rlv_fluid_create(poor, NULL, &little));
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_fluid_restore_bytes(little, bytes, size), "memory limit");
    CHECK_OK(rlv_fluid_release(little));
    CHECK_OK(rlv_context_release(poor));
    free(bytes);
    CHECK_OK(rlv_fluid_release(fluid));
    CHECK_OK(rlv_fluid_release(coarse));
}

int main(void) {
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    check_goes_on(context, RLV_FLUID_PCISPH);
    check_goes_on(context, RLV_FLUID_DFSPH);
    check_refused(context);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
