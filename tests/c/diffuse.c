/* Diffuse particles: born where two blocks of fluid meet, advanced, drawn as foam, saved and continued to the same bits, and
 * what is refused. */
#include "sheet.h"

enum { SIDE = 8, BLOCK = SIDE * SIDE * SIDE, COUNT = 2 * BLOCK, MOST = 100000 };
static const char path[] = "state_of_diffuse.rlvfluid";
static float positions[COUNT][3], velocities[COUNT][3];

/* Two blocks, 2 cm between their particles, that meet at 8 m/s. */
static RlvDiffuseFluid collision(void) {
    RlvDiffuseFluid fluid = RLV_DIFFUSE_FLUID_INIT;
    for (int at = 0; at < COUNT; ++at) {
        const int in = at % BLOCK;
        positions[at][0] = 0.02f * (float)(in % SIDE + (at < BLOCK ? 0 : SIDE));
        positions[at][1] = 0.02f * (float)(in / SIDE % SIDE);
        positions[at][2] = 0.02f * (float)(in / SIDE / SIDE);
        velocities[at][0] = at < BLOCK ? 4.0f : -4.0f;
    }
    fluid.count = COUNT;
    fluid.positions = positions[0];
    fluid.velocities = velocities[0];
    return fluid;
}

static RlvDiffuse make(RlvContext context, uint32_t seed) {
    RlvDiffuse diffuse = RLV_NULL;
    RlvDiffuseSettings settings = RLV_DIFFUSE_SETTINGS_INIT;
    settings.seed = seed;
    settings.lifetime_min = 0.01f;
    CHECK_OK(rlv_diffuse_create(context, NULL, &settings, &diffuse));
    return diffuse;
}

static RlvDiffuseInfo info_of(RlvDiffuse diffuse) {
    RlvDiffuseInfo info = RLV_DIFFUSE_INFO_INIT;
    CHECK_OK(rlv_diffuse_info(diffuse, &info));
    return info;
}

/* Air is trapped where the blocks meet, and nowhere else. */
static void check_potentials(RlvContext context) {
    RlvDiffuse diffuse = make(context, 1);
    const RlvDiffuseFluid fluid = collision();
    float air[COUNT], energies[COUNT];
    RlvDiffusePotentials potentials = RLV_DIFFUSE_POTENTIALS_INIT;
    potentials.capacity = COUNT;
    potentials.air = air;
    potentials.energies = energies;
    CHECK_OK(rlv_diffuse_potentials(diffuse, &fluid, &potentials));
    for (int at = 0; at < COUNT; ++at) {
        const int column = at % SIDE + (at < BLOCK ? 0 : SIDE);
        CHECK_NEAR(energies[at], (8.0 - 5.0) / 45.0, 1e-5);
        CHECK(column == SIDE - 1 || column == SIDE ? air[at] > 0.5f : air[at] <= 0.5f);
    }
    potentials.capacity = COUNT - 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_potentials(diffuse, &fluid, &potentials), "air");
    CHECK_OK(rlv_diffuse_release(diffuse));
}

/* The particles are as many as the report says, and foam takes them. */
static void check_particles(RlvContext context) {
    static float at[MOST][3], speeds[MOST][3], ages[MOST], lifetimes[MOST], lives[MOST];
    static uint32_t ids[MOST], kinds[MOST];
    RlvDiffuse diffuse = make(context, 1);
    RlvDiffuseFluid fluid = collision();
    RlvDiffuseReport report = RLV_DIFFUSE_REPORT_INIT;
    RlvDiffuseArrays arrays = RLV_DIFFUSE_ARRAYS_INIT;
    RlvFoam foam = RLV_NULL;
    RlvFoamView view = RLV_FOAM_VIEW_INIT;
    RlvFoamParticles drawn = RLV_FOAM_PARTICLES_INIT;
    RlvParticles file = RLV_NULL;
    RlvParticlesInfo in_file = RLV_PARTICLES_INFO_INIT;
    uint64_t born = 0, gone = 0;
    for (int frame = 0; frame < 3; ++frame) {
        CHECK_OK(rlv_diffuse_advance(diffuse, &fluid, 0.04f, &report, NULL, NULL));
        born += report.born;
        gone += report.gone;
        CHECK(report.refused == 0);
    }
    const RlvDiffuseInfo info = info_of(diffuse);
    CHECK(info.frames == 3 && info.births == born && info.count == born - gone && info.count > 100 && info.count <= MOST);
    arrays.capacity = MOST;
    arrays.positions = at[0];
    arrays.velocities = speeds[0];
    arrays.ids = ids;
    arrays.kinds = kinds;
    arrays.ages = ages;
    arrays.lifetimes = lifetimes;
    arrays.lives = lives;
    CHECK_OK(rlv_diffuse_get(diffuse, &arrays));
    for (size_t one = 0; one < info.count; ++one) {
        CHECK(kinds[one] <= RLV_FOAM_BUBBLE && lifetimes[one] > 0 && ages[one] >= 0 && ages[one] < 0.1201f);
        CHECK(ids[one] < born && (one == 0 || ids[one] > ids[one - 1]));
        CHECK_NEAR(lives[one], ages[one] / (ages[one] + lifetimes[one]), 1e-5);
        CHECK(isfinite(speeds[one][0]));
    }
    arrays.capacity = info.count - 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_get(diffuse, &arrays), "positions");

    view.width = view.height = 8;
    view.eye[2] = 2;
    view.up[1] = 1;
    view.up[2] = 0;
    CHECK_OK(rlv_foam_create(context, &view, NULL, &foam));
    drawn.count = info.count;
    drawn.positions = at[0];
    drawn.ids = ids;
    drawn.kinds = kinds;
    drawn.lives = lives;
    CHECK_OK(rlv_foam_add(foam, &drawn));
    CHECK_OK(rlv_foam_release(foam));

    CHECK_OK(rlv_diffuse_particles(diffuse, 0.12, &file));
    CHECK_OK(rlv_particles_info(file, &in_file));
    CHECK(in_file.count == info.count && in_file.has_numbers == 1 && in_file.channel_count == 4 && in_file.spacing == 0.02f);
    CHECK_OK(rlv_particles_release(file));
    CHECK_OK(rlv_diffuse_release(diffuse));
}

static void positions_of(RlvDiffuse diffuse, float (*at)[3]) {
    RlvDiffuseArrays arrays = RLV_DIFFUSE_ARRAYS_INIT;
    arrays.capacity = MOST;
    arrays.positions = at[0];
    CHECK_OK(rlv_diffuse_get(diffuse, &arrays));
}

/* A run that is saved and continued ends with the same bits, and one of another seed does not. */
static void check_states(RlvContext context) {
    static float first[MOST][3], second[MOST][3];
    RlvDiffuse whole = make(context, 1), other = make(context, 1), seeded = make(context, 2);
    const RlvDiffuseFluid fluid = collision();
    CHECK_OK(rlv_diffuse_advance(whole, &fluid, 0.04f, NULL, NULL, NULL));
    CHECK_OK(rlv_diffuse_save(whole, path, 0.04));
    CHECK_OK(rlv_diffuse_restore(other, path));
    CHECK_OK(rlv_diffuse_advance(whole, &fluid, 0.04f, NULL, NULL, NULL));
    CHECK_OK(rlv_diffuse_advance(other, &fluid, 0.04f, NULL, NULL, NULL));
    CHECK_OK(rlv_diffuse_advance(seeded, &fluid, 0.04f, NULL, NULL, NULL));
    const size_t count = info_of(whole).count;
    CHECK(info_of(other).count == count && info_of(other).births == info_of(whole).births);
    positions_of(whole, first);
    positions_of(other, second);
    CHECK(memcmp(first, second, count * sizeof first[0]) == 0);
    CHECK(info_of(seeded).births != info_of(whole).births);

    RlvDiffuseOptions options = RLV_DIFFUSE_OPTIONS_INIT;
    RlvDiffuse coarse = RLV_NULL;
    RlvParticles plain = RLV_NULL;
    options.spacing = 0.04f;
    CHECK_OK(rlv_diffuse_create(context, &options, NULL, &coarse));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_restore(coarse, path), "0.04");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_diffuse_restore(other, "missing.rlvfluid"), "missing");
    CHECK_OK(rlv_diffuse_particles(whole, 0.08, &plain));
    CHECK_OK(rlv_particles_write(plain, path));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_restore(other, path), "rlv_diffuse_save");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_restore(other, NULL), "path");
    CHECK(info_of(other).count == count);
    CHECK_OK(rlv_particles_release(plain));
    CHECK_OK(rlv_diffuse_release(coarse));
    CHECK_OK(rlv_diffuse_release(seeded));
    CHECK_OK(rlv_diffuse_release(other));
    CHECK_OK(rlv_diffuse_release(whole));
    remove(path);
}

static void check_refusals(RlvContext context) {
    RlvDiffuse diffuse = RLV_NULL;
    RlvDiffuseOptions options = RLV_DIFFUSE_OPTIONS_INIT;
    RlvDiffuseSettings settings = RLV_DIFFUSE_SETTINGS_INIT;
    RlvDiffuseFluid fluid = collision();
    RlvDiffuseReport report = RLV_DIFFUSE_REPORT_INIT;
    const RlvParameter *params = NULL;
    size_t count = 0;
    int left = 0;
    options.spacing = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_create(context, &options, NULL, &diffuse), "spacing");
    options.spacing = 0.02f;
    options.has_bounds = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_create(context, &options, NULL, &diffuse), "bounds");
    options.has_bounds = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_create(context, &options, NULL, &diffuse), "has_bounds");
    settings.air_min = 30;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_create(context, NULL, &settings, &diffuse), "air_max");
    settings.struct_size = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_create(context, NULL, &settings, &diffuse), "struct_size");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_create(context, NULL, NULL, NULL), "out");
    CHECK(diffuse.id == 0);
    diffuse = make(context, 1);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_advance(diffuse, NULL, 0.04f, NULL, NULL, NULL), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_advance(diffuse, &fluid, 0, NULL, NULL, NULL), "seconds");
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_diffuse_advance(diffuse, &fluid, 0.04f, NULL, check_patience, &left), "");
    report.struct_size = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_advance(diffuse, &fluid, 0.04f, &report, NULL, NULL), "struct_size");
    velocities[7][1] = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_advance(diffuse, &fluid, 0.04f, NULL, NULL, NULL), "finite");
    velocities[7][1] = 0;
    fluid.velocities = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_advance(diffuse, &fluid, 0.04f, NULL, NULL, NULL), "velocities");
    CHECK(info_of(diffuse).frames == 0 && info_of(diffuse).count == 0);
    CHECK_OK(rlv_diffuse_release(diffuse));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_diffuse_release(diffuse), "");
    CHECK_OK(rlv_diffuse_params(&params, &count));
    CHECK(count == 17 && strcmp(params[0].name, "air_min") == 0 && params[0].offset == sizeof(uint32_t));
}

int main(void) {
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    check_potentials(context);
    check_particles(context);
    check_states(context);
    check_refusals(context);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
