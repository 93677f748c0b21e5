/* Numbers that no host means: a radius of 0, steps and pushes without measure, colliders with holes, particles all at one point
 * and more of them than the budget. Each is an error that says why, or an answer that is finite, and nothing is lost. */
#include "check.h"

/* Few particles: the test runs under Valgrind too. */
enum { DAM = 64, HEAP = 100, MORE = 100, MOST = 1024 };
static const double low[3] = {0, 0, 0}, high[3] = {0.08, 0.08, 0.08}, far_end[3] = {0.16, 0.16, 0.16};
static const uint32_t solvers[2] = {RLV_FLUID_PCISPH, RLV_FLUID_DFSPH};

static RlvFluid dam(RlvContext context, uint32_t solver) {
    RlvFluid fluid = RLV_NULL;
    RlvFluidOptions options = RLV_FLUID_OPTIONS_INIT;
    options.solver = solver;
    CHECK_OK(rlv_fluid_create(context, &options, &fluid));
    CHECK_OK(rlv_fluid_set_basin(fluid, low, far_end));
    CHECK_OK(rlv_fluid_add_box(fluid, low, high, NULL));
    return fluid;
}

static size_t count_of(RlvFluid fluid) {
    RlvFluidInfo info = RLV_FLUID_INFO_INIT;
    CHECK_OK(rlv_fluid_info(fluid, &info));
    return info.particle_count;
}

/* The call is done or refused, with so many particles, and all of them have places and velocities. */
static void check_bounded(RlvFluid fluid, RlvResult result, size_t count) {
    static float points[MOST][3], velocities[MOST][3];
    RlvFluidArrays arrays = RLV_FLUID_ARRAYS_INIT;
    CHECK(result == RLV_OK || (result == RLV_ERROR_INVALID && rlv_error_last()[0] != 0));
    CHECK(count_of(fluid) == count);
    arrays.capacity = MOST;
    arrays.points = points[0];
    arrays.velocities = velocities[0];
    CHECK_OK(rlv_fluid_get(fluid, &arrays));
    for (size_t k = 0; k < count; ++k) {
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(isfinite(points[k][axis]) && isfinite(velocities[k][axis]));
        }
    }
}

static void check_numbers(RlvContext context) {
    static const float origin[3] = {0, 0, 0};
    static const float no_length[5] = {0.0f, -1.0f, NAN, INFINITY, 1e30f}, no_share[3] = {-1.0f, NAN, INFINITY};
    RlvFluid made = {77};
    RlvIsosurface surface = {77};
    const RlvFluidOptions usual = RLV_FLUID_OPTIONS_INIT;
    for (int k = 0; k < 5; ++k) {
        RlvFluidOptions options = usual;
        RlvIsosurfaceOptions function = RLV_ISOSURFACE_OPTIONS_INIT;
        RlvIsosurfaceParticles particles = RLV_ISOSURFACE_PARTICLES_INIT;
        options.spacing = no_length[k];
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_create(context, &options, &made), "spacing");
        options = usual;
        options.density = no_length[k];
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_create(context, &options, &made), "density");
        options = usual;
        options.step = no_length[k];
        CHECK(rlv_fluid_create(context, &options, &made) == RLV_ERROR_INVALID);
        options.steps = RLV_FLUID_FIXED;
        CHECK(rlv_fluid_create(context, &options, &made) == RLV_ERROR_INVALID);
        function.radius = no_length[k];
        particles.count = 1;
        particles.points = origin;
        if (k < 4) {
            CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_create(context, &particles, &function, &surface), "radius");
        }
    }
    for (int k = 0; k < 3; ++k) {
        RlvFluidOptions options = usual;
        options.viscosity = no_share[k];
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_create(context, &options, &made), "viscosity");
        options = usual;
        options.gravity[1] = k == 0 ? -INFINITY : no_share[k];
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_create(context, &options, &made), "gravity");
    }
    CHECK(made.id == 77 && surface.id == 77);
}

static void check_steps_and_pushes(RlvContext context, uint32_t solver) {
    static float pushes[DAM][3];
    RlvFluid fluid = dam(context, solver);
    check_bounded(fluid, rlv_fluid_step(fluid, 1e30f, NULL), DAM);
    check_bounded(fluid, rlv_fluid_step(fluid, 1e-30f, NULL), DAM);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_step(fluid, INFINITY, NULL), "seconds");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_advance(fluid, INFINITY, NULL, NULL, NULL), "seconds");
    CHECK_OK(rlv_fluid_release(fluid));

    fluid = dam(context, solver);
    pushes[7][2] = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_accelerate(fluid, pushes[0], DAM, 0), "element 7");
    RlvFluidForce force = {RLV_FLUID_GRAVITY, 0, {0, 0, NAN}, 0, {0, 0, 0}, 0, 0};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_forces(fluid, &force, 1, 0), "force 0");
    for (int k = 0; k < DAM; ++k) {
        pushes[k][0] = k % 2 ? 1e30f : -1e30f;
        pushes[k][2] = 1e30f;
    }
    CHECK_OK(rlv_fluid_accelerate(fluid, pushes[0], DAM, 0));
    check_bounded(fluid, rlv_fluid_step(fluid, 0.001f, NULL), DAM);
    CHECK_OK(rlv_fluid_release(fluid));
}

static void check_heap(RlvContext context, uint32_t solver) {
    static float points[HEAP][3];
    RlvFluid fluid = dam(context, solver);
    RlvFluidParticles particles = RLV_FLUID_PARTICLES_INIT;
    for (int k = 0; k < HEAP; ++k) {
        points[k][0] = points[k][1] = points[k][2] = 0.12f;
    }
    particles.count = HEAP;
    particles.points = points[0];
    CHECK_OK(rlv_fluid_add(fluid, &particles));
    check_bounded(fluid, rlv_fluid_step(fluid, 0.001f, NULL), DAM + HEAP);
    CHECK_OK(rlv_fluid_release(fluid));
}

/* A plane has holes all around. */
static void check_holes(RlvContext context, uint32_t solver) {
    RlvFluid fluid = dam(context, solver);
    RlvMesh plane = check_plane(context, 2, 2);
    const double small[12] = {0.05, 0, 0, 0, 0.035, 0, 0, 0, 0.05, 0.085, 0.01, 0.05};
    uint32_t number = 77;
    CHECK_OK(rlv_fluid_add_collider(fluid, plane, small, NULL, &number));
    for (int k = 0; k < 10; ++k) {
        check_bounded(fluid, rlv_fluid_advance(fluid, 0.005, NULL, NULL, NULL), DAM);
    }
    const double nowhere[12] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, no_place[12] = {NAN, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    CHECK(rlv_fluid_add_collider(fluid, plane, nowhere, NULL, &number) == RLV_ERROR_INVALID);
    CHECK(rlv_fluid_add_collider(fluid, plane, no_place, NULL, &number) == RLV_ERROR_INVALID);
    CHECK(number == 0);
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_fluid_release(fluid));
}

static void check_budget(RlvContext context, uint32_t solver) {
    RlvFluidEmitterOptions tap = RLV_FLUID_EMITTER_OPTIONS_INIT;
    tap.center[0] = tap.center[1] = tap.center[2] = 3.0;
    tap.radius = 0.2f;
    tap.speed = 10.0f;
    for (uint32_t stops = 0; stops < 2; ++stops) {
        RlvFluid fluid = dam(context, solver);
        CHECK_OK(rlv_fluid_add_emitter(fluid, (RlvMesh){0}, NULL, &tap));
        CHECK_OK(rlv_fluid_set_budget(fluid, DAM + MORE, stops));
        const RlvResult result = rlv_fluid_advance(fluid, 0.02, NULL, NULL, NULL);
        CHECK(result == (stops ? RLV_OK : RLV_ERROR_MEMORY));
        CHECK(count_of(fluid) <= DAM + MORE);
        check_bounded(fluid, RLV_OK, count_of(fluid));
        CHECK_OK(rlv_fluid_release(fluid));
    }
}

int main(void) {
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    check_numbers(context);
    for (int k = 0; k < 2; ++k) {
        check_steps_and_pushes(context, solvers[k]);
        check_heap(context, solvers[k]);
        check_holes(context, solvers[k]);
        check_budget(context, solvers[k]);
    }
    CHECK_OK(rlv_context_release(context));
    return 0;
}
