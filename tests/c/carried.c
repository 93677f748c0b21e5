/* What particles of fluids carry: channels that are set, added, emitted and read, that stay with their particles through
 * steps and removals, and that meshes of the surface have. */
#include "check.h"

enum { DAM = 512 };
static const double low[3] = {0, 0, 0}, high[3] = {0.16, 0.16, 0.16}, far_end[3] = {0.32, 0.16, 0.32};

static RlvFluid dam(RlvContext context) {
    RlvFluid fluid = RLV_NULL;
    CHECK_OK(rlv_fluid_create(context, NULL, &fluid));
    CHECK_OK(rlv_fluid_set_basin(fluid, low, far_end));
    CHECK_OK(rlv_fluid_add_box(fluid, low, high, NULL));
    return fluid;
}

static RlvAttributeArrays channel(const char *name, const float *values, size_t count, uint32_t width, size_t stride) {
    RlvAttributeArrays made = RLV_ATTRIBUTE_ARRAYS_INIT;
    made.domain = RLV_DOMAIN_POINT;
    made.type = RLV_TYPE_F32;
    made.name = name;
    made.width = width;
    made.values = values;
    made.value_count = count;
    made.value_stride = stride;
    return made;
}

static size_t particles_of(RlvFluid fluid) {
    RlvFluidInfo info = RLV_FLUID_INFO_INIT;
    CHECK_OK(rlv_fluid_info(fluid, &info));
    return info.particle_count;
}

/* A channel is the place where a particle began, in the order of numbers, so that it tells which is which. */
static void check_kept(RlvContext context) {
    static float wide[DAM][5], begun[DAM][3], found[DAM + 2][4];
    uint32_t index = 77, numbers[DAM];
    RlvFluid fluid = dam(context);
    RlvFluidArrays arrays = RLV_FLUID_ARRAYS_INIT;
    arrays.capacity = DAM;
    arrays.points = begun[0];
    CHECK_OK(rlv_fluid_get(fluid, &arrays));
    for (int k = 0; k < DAM; ++k) {
        memcpy(wide[k] + 1, begun[k], sizeof begun[k]);
    }
    RlvAttributeArrays origin = channel("origin", wide[0] + 1, DAM, 3, sizeof wide[0]);
    CHECK_OK(rlv_fluid_set_channel(fluid, &origin));
    CHECK_OK(rlv_fluid_advance(fluid, 0.05, NULL, NULL, NULL));
    const uint32_t gone[2] = {0, 300};
    CHECK_OK(rlv_fluid_remove(fluid, gone, 2, 0, NULL));
    arrays.points = NULL;
    arrays.numbers = numbers;
    CHECK_OK(rlv_fluid_get(fluid, &arrays));

    RlvAttributeInfo info = RLV_ATTRIBUTE_INFO_INIT;
    CHECK_OK(rlv_fluid_find_channel(fluid, "origin", &index));
    CHECK_OK(rlv_fluid_channel_info(fluid, index, &info));
    CHECK(index == 0 && info.width == 3 && info.value_count == DAM - 2 && strcmp(info.name, "origin") == 0);
    CHECK(info.domain == RLV_DOMAIN_POINT && info.type == RLV_TYPE_F32 && info.index_count == 0);
    CHECK_OK(rlv_fluid_get_channel(fluid, index, found[0], DAM, sizeof found[0]));
    for (int k = 0; k < DAM - 2; ++k) {
        CHECK(memcmp(found[k], begun[numbers[k]], sizeof begun[0]) == 0);
    }

    /* What is added brings its own, one value for all or one for each, and zeros for what it has not. */
    const float places[2][3] = {{0.2f, 0.08f, 0.2f}, {0.25f, 0.08f, 0.2f}}, heat[2] = {1.5f, 2.5f}, red[3] = {1, 0, 0};
    RlvAttributeArrays more[2] = {channel("heat", heat, 2, 1, 0), channel("color", red, 1, 3, 0)};
    RlvFluidParticles added = RLV_FLUID_PARTICLES_INIT;
    added.count = 2;
    added.points = places[0];
    added.channels = more;
    added.channel_count = 2;
    CHECK_OK(rlv_fluid_add(fluid, &added));
    CHECK(particles_of(fluid) == DAM);
    CHECK_OK(rlv_fluid_find_channel(fluid, "heat", &index));
    CHECK_OK(rlv_fluid_get_channel(fluid, index, found[0], DAM, sizeof found[0]));
    CHECK(found[0][0] == 0 && found[DAM - 2][0] == 1.5f && found[DAM - 1][0] == 2.5f);
    CHECK_OK(rlv_fluid_find_channel(fluid, "color", &index));
    CHECK_OK(rlv_fluid_get_channel(fluid, index, found[0], DAM, sizeof found[0]));
    CHECK(found[DAM - 3][0] == 0 && found[DAM - 2][0] == 1 && found[DAM - 1][0] == 1 && found[DAM - 1][1] == 0);
    CHECK_OK(rlv_fluid_get_channel(fluid, 0, found[0], DAM, sizeof found[0]));
    CHECK(found[DAM - 1][0] == 0 && found[DAM - 1][2] == 0);

    /* A mesh of the surface has them, between the least and the most that particles have. */
    RlvIsosurface surface = RLV_NULL;
    RlvMesh mesh = RLV_NULL;
    RlvMeshInfo about = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_fluid_isosurface(fluid, NULL, &surface));
    CHECK_OK(rlv_isosurface_mesh(surface, NULL, NULL, NULL, &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &about));
    CHECK(about.attribute_count == 5);
    CHECK_OK(rlv_mesh_find_attribute(mesh, "heat", &index));
    float *values = (float *)malloc(about.point_count * sizeof(float)), most = 0;
    CHECK(values != NULL);
    CHECK_OK(rlv_mesh_get_attribute(mesh, index, values, about.point_count, NULL, 0));
    for (size_t k = 0; k < about.point_count; ++k) {
        CHECK(values[k] >= 0 && values[k] <= 2.5001f);
        most = values[k] > most ? values[k] : most;
    }
    CHECK_NEAR(most, 2.5, 1e-4);
    free(values);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_isosurface_release(surface));
    CHECK_OK(rlv_fluid_release(fluid));
}

/* Emitters give what their particles carry. */
static void check_emitted(RlvContext context) {
    static float found[4096][2];
    RlvFluid fluid = dam(context);
    RlvFluidEmitterOptions tap = RLV_FLUID_EMITTER_OPTIONS_INIT;
    const float pair[2] = {3, 4};
    RlvAttributeArrays one = channel("pair", pair, 1, 2, 0);
    uint32_t index = 77;
    tap.center[0] = tap.center[1] = tap.center[2] = 5;
    tap.speed = 5;
    tap.channels = &one;
    tap.channel_count = 1;
    CHECK_OK(rlv_fluid_add_emitter(fluid, (RlvMesh){0}, NULL, &tap));
    CHECK_OK(rlv_fluid_advance(fluid, 0.01, NULL, NULL, NULL));
    const size_t count = particles_of(fluid);
    CHECK(count > DAM && count < 4096);
    CHECK_OK(rlv_fluid_find_channel(fluid, "pair", &index));
    CHECK_OK(rlv_fluid_get_channel(fluid, index, found[0], 4096, 0));
    for (size_t k = 0; k < count; ++k) {
        CHECK(found[k][0] == (k < DAM ? 0 : 3) && found[k][1] == (k < DAM ? 0 : 4));
    }
    one.value_count = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add_emitter(fluid, (RlvMesh){0}, NULL, &tap), "one finite value");
    CHECK_OK(rlv_fluid_release(fluid));
}

static void check_refused(RlvContext context) {
    static float values[DAM][4];
    RlvFluid fluid = dam(context);
    uint32_t index = 77;
    RlvAttributeInfo info = RLV_ATTRIBUTE_INFO_INIT;
    RlvAttributeArrays given = channel("heat", values[0], DAM, 2, 0);
    CHECK_OK(rlv_fluid_set_channel(fluid, &given));
    given.width = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_channel(fluid, &given), "heat");
    given.width = 2;
    given.value_count = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_channel(fluid, &given), "512 particles");
    given.value_count = DAM;
    given.value_stride = 4;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_channel(fluid, &given), "stride");
    given.value_stride = 0;
    given.domain = RLV_DOMAIN_FACE;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_channel(fluid, &given), "RLV_DOMAIN_POINT");
    given.domain = RLV_DOMAIN_POINT;
    given.name = "velocity";
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_channel(fluid, &given), "velocity");
    given.name = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_channel(fluid, &given), "name");
    given.name = "other";
    values[7][1] = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_channel(fluid, &given), "not finite");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_channel(fluid, NULL), "channels");

    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_fluid_find_channel(fluid, "heal", &index), "heat");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_channel_info(fluid, 1, &info), "the fluid has 1");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_get_channel(fluid, 9, values[0], DAM, 0), "channel 9");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_get_channel(fluid, 0, values[0], DAM - 1, 0), "512");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_get_channel(fluid, 0, values[0], DAM, 4), "stride");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_get_channel(fluid, 0, NULL, DAM, 0), "NULL");
    CHECK(index == 77);

    /* What cannot be carried is not added. */
    const float place[3] = {0.3f, 0.08f, 0.2f};
    RlvFluidParticles added = RLV_FLUID_PARTICLES_INIT;
    added.count = 1;
    added.points = place;
    added.channels = &given;
    added.channel_count = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add(fluid, &added), "1 particles");
    given.name = "heat";
    given.value_count = given.width = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add(fluid, &added), "heat");
    added.channels = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add(fluid, &added), "channels");
    CHECK(particles_of(fluid) == DAM);
    CHECK_OK(rlv_fluid_release(fluid));
}

int main(void) {
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    check_kept(context);
    check_emitted(context);
    check_refused(context);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
