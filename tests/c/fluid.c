/* Fluids: closed forms of particles that fall and are pushed, colliders, sources, a dam that is simulated here and in the background, what
 * particles have, their surface, and what is refused. */
#include "sheet.h"

static RlvFluid make(RlvContext context, const RlvFluidOptions *options) {
    RlvFluid fluid = RLV_NULL;
    CHECK_OK(rlv_fluid_create(context, options, &fluid));
    return fluid;
}

static RlvFluidInfo info_of(RlvFluid fluid) {
    RlvFluidInfo info = RLV_FLUID_INFO_INIT;
    CHECK_OK(rlv_fluid_info(fluid, &info));
    return info;
}

/* Particles far from each other fall and are pushed as if they were alone. */
static void check_alone(RlvContext context) {
    enum { COUNT = 5, STEPS = 10 };
    float points[COUNT][3], found[COUNT][3], velocities[COUNT][4], pushes[COUNT][3];
    RlvFluidOptions options = RLV_FLUID_OPTIONS_INIT;
    RlvFluidParticles particles = RLV_FLUID_PARTICLES_INIT;
    options.steps = RLV_FLUID_FIXED;
    options.step = 0.01f;
    RlvFluid fluid = make(context, &options);
    for (int k = 0; k < COUNT; ++k) {
        /* From the right to the left, so that they are sorted the other way round. */
        points[k][0] = -1.0f * (float)k;
        points[k][1] = points[k][2] = 0.0f;
        pushes[k][0] = 0.0f;
        pushes[k][1] = (float)k;
        pushes[k][2] = 0.0f;
    }
    particles.count = COUNT;
    particles.points = points[0];
    particles.velocity[0] = 0.01f;
    CHECK_OK(rlv_fluid_add(fluid, &particles));
    CHECK_OK(rlv_fluid_accelerate(fluid, pushes[0], COUNT, 0));
    RlvFluidReport report = RLV_FLUID_REPORT_INIT;
    for (int k = 0; k < STEPS; ++k) {
        CHECK_OK(rlv_fluid_step(fluid, 0.01f, &report));
        CHECK(report.steps == 1 && report.seconds == (double)0.01f && report.max_excess == 0.0f);
    }
    RlvFluidArrays arrays = RLV_FLUID_ARRAYS_INIT;
    uint32_t numbers[COUNT];
    double births[COUNT];
    arrays.capacity = COUNT;
    arrays.points = found[0];
    arrays.velocities = velocities[0];
    arrays.velocity_stride = sizeof velocities[0];
    arrays.numbers = numbers;
    arrays.births = births;
    CHECK_OK(rlv_fluid_get(fluid, &arrays));
    for (int k = 0; k < COUNT; ++k) {
        CHECK(numbers[k] == (uint32_t)k && births[k] == 0.0);
        CHECK_NEAR(velocities[k][1], 0.1 * k, 1e-5);
        CHECK_NEAR(velocities[k][2], -0.981, 1e-4);
        CHECK_NEAR(found[k][0], -1.0 * k + 0.001, 1e-5);
        /* Explicit: g dt^2 n (n + 1) / 2. */
        CHECK_NEAR(found[k][2], -9.81 * 1e-4 * STEPS * (STEPS + 1) / 2, 1e-4);
    }
    const RlvFluidInfo info = info_of(fluid);
    /* So that a lattice has the density at rest. */
    CHECK_NEAR(info.mass, 1000 * 8e-6, 4e-4);
    CHECK_NEAR(info.momentum[2], -0.981 * COUNT * info.mass, 1e-5);
    CHECK_NEAR(info.seconds, 0.1, 1e-6);

    /* Those that are removed or have lived are gone, and the others keep their numbers. */
    const uint32_t gone[3] = {3, 1, 99};
    size_t removed = 0;
    CHECK_OK(rlv_fluid_remove(fluid, gone, 3, 0, &removed));
    CHECK(removed == 2 && info_of(fluid).particle_count == 3);
    particles.count = 1;
    particles.lifetime = 0.015f;
    points[0][1] = 7.0f;
    CHECK_OK(rlv_fluid_add(fluid, &particles));
    CHECK_OK(rlv_fluid_get(fluid, &arrays));
    CHECK(numbers[0] == 0 && numbers[1] == 2 && numbers[2] == 4 && numbers[3] == 5 && found[3][1] == 7.0f);
    CHECK_NEAR(births[3], 0.1, 1e-6);
    CHECK_OK(rlv_fluid_advance(fluid, 0.03, NULL, NULL, NULL));
    CHECK(info_of(fluid).particle_count == 3);
    CHECK_OK(rlv_fluid_release(fluid));
}

/* A dam 8 particles wide that stands in a basin for a while. */
static const double low[3] = {0, 0, 0}, high[3] = {0.16, 0.16, 0.16}, far_end[3] = {0.32, 0.16, 0.32};
enum { DAM = 512 };

static RlvFluid dam(RlvContext context) {
    RlvFluid fluid = make(context, NULL);
    CHECK_OK(rlv_fluid_set_basin(fluid, low, far_end));
    CHECK_OK(rlv_fluid_add_box(fluid, low, high, NULL));
    CHECK(info_of(fluid).particle_count == DAM && info_of(fluid).wall_count == 18 * 10 * 18 - 16 * 8 * 16);
    return fluid;
}

static void check_dam(RlvContext context) {
    static float points[DAM][3], others[DAM][3], densities[DAM], pressures[DAM];
    RlvFluid fluid = dam(context), other = dam(context);
    RlvFluidReport report = RLV_FLUID_REPORT_INIT, told = RLV_FLUID_REPORT_INIT;
    RlvFluidArrays arrays = RLV_FLUID_ARRAYS_INIT;
    CHECK_OK(rlv_fluid_advance(fluid, 0.05, NULL, NULL, &report));
    CHECK(report.steps > 5 && report.corrections >= 3 * report.steps);
    CHECK(report.max_excess < 0.05f && report.mean_excess < 0.01f);

    /* In the background the same, to the bit. */
    RlvJob job = RLV_NULL;
    CHECK_OK(rlv_job_fluid(other, 0.05, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_fluid_report(job, &told));
    CHECK(memcmp(&report, &told, sizeof report) == 0);
    CHECK_OK(rlv_job_release(job));
    arrays.capacity = DAM;
    arrays.points = others[0];
    CHECK_OK(rlv_fluid_get(other, &arrays));
    arrays.points = points[0];
    arrays.densities = densities;
    arrays.pressures = pressures;
    CHECK_OK(rlv_fluid_get(fluid, &arrays));
    CHECK(memcmp(points, others, sizeof points) == 0);
    double density = 0, below = 0;
    for (int k = 0; k < DAM; ++k) {
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(points[k][axis] > 0 && points[k][axis] < far_end[axis]);
        }
        CHECK(densities[k] > 0 && densities[k] < 1060);
        density += densities[k] / DAM;
        below += points[k][2] < 0.08f ? pressures[k] : -pressures[k];
    }
    /* Where the surface is a good part of it the mean is less than at rest. */
    CHECK(density > 750 && density < 1010);
    CHECK(below > 0);

    /* What the densities were asked for does not change what comes after. */
    arrays.densities = arrays.pressures = NULL;
    CHECK_OK(rlv_fluid_advance(fluid, 0.01, NULL, NULL, NULL));
    CHECK_OK(rlv_fluid_advance(other, 0.01, NULL, NULL, NULL));
    CHECK_OK(rlv_fluid_get(fluid, &arrays));
    arrays.points = others[0];
    CHECK_OK(rlv_fluid_get(other, &arrays));
    CHECK(memcmp(points, others, sizeof points) == 0);

    /* Cancelled, it stays at a whole step and goes on. */
    int patience = 2;
    const double before = info_of(other).seconds;
    CHECK(rlv_fluid_advance(other, 1.0, check_patience, &patience, NULL) == RLV_ERROR_CANCELLED);
    CHECK(info_of(other).seconds > before && info_of(other).seconds < before + 0.5);
    CHECK_OK(rlv_fluid_step(other, info_of(other).time_step, &told));
    CHECK(told.steps == 1 && told.seconds > 0);
    CHECK_OK(rlv_fluid_release(other));

    /* Its surface is about as large as the water. */
    RlvIsosurface surface = RLV_NULL;
    RlvIsosurfaceInfo about = RLV_ISOSURFACE_INFO_INIT;
    RlvMesh mesh = RLV_NULL;
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_fluid_isosurface(fluid, NULL, &surface));
    CHECK_OK(rlv_isosurface_info(surface, &about));
    CHECK(about.particle_count == DAM && about.has_velocities == 1);
    CHECK_NEAR(about.support, 0.04, 1e-7);
    CHECK_OK(rlv_isosurface_mesh(surface, NULL, NULL, NULL, &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK(info.triangle_count > 1000 && info.triangle_count % 2 == 0 && info.attribute_count == 2);
    CHECK(info.low[2] > -0.01f && info.high[2] < 0.17f && info.high[0] > 0.15f);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_isosurface_release(surface));

    /* Without walls it falls out. */
    CHECK_OK(rlv_fluid_set_walls(fluid, NULL, 0, 0));
    CHECK(info_of(fluid).wall_count == 0);
    CHECK_OK(rlv_fluid_advance(fluid, 0.2, NULL, NULL, NULL));
    arrays.points = points[0];
    CHECK_OK(rlv_fluid_get(fluid, &arrays));
    CHECK(points[0][2] < -0.1f);
    CHECK_OK(rlv_fluid_release(fluid));
}

/* A plate of walls that goes up takes the water on it along. */
static void check_moving_walls(RlvContext context) {
    enum { SIDE = 12, PLATE = SIDE * SIDE };
    float plate[PLATE][3], velocities[PLATE][3], points[64][3];
    RlvFluidOptions options = RLV_FLUID_OPTIONS_INIT;
    options.gravity[2] = 0.0f;
    RlvFluid fluid = make(context, &options);
    for (int k = 0; k < PLATE; ++k) {
        plate[k][0] = 0.02f * (float)(k % SIDE) - 0.07f;
        plate[k][1] = 0.02f * (float)(k / SIDE) - 0.07f;
        plate[k][2] = -0.01f;
        velocities[k][0] = velocities[k][1] = 0.0f;
        velocities[k][2] = 0.5f;
    }
    const double top[3] = {0.08, 0.08, 0.08};
    CHECK_OK(rlv_fluid_set_walls(fluid, plate[0], PLATE, 0));
    CHECK_OK(rlv_fluid_add_box(fluid, low, top, NULL));
    CHECK_OK(rlv_fluid_set_wall_points(fluid, plate[0], PLATE, 0, velocities[0], 0));
    CHECK_OK(rlv_fluid_advance(fluid, 0.1, NULL, NULL, NULL));
    RlvFluidArrays arrays = RLV_FLUID_ARRAYS_INIT;
    arrays.capacity = 64;
    arrays.points = points[0];
    CHECK_OK(rlv_fluid_get(fluid, &arrays));
    for (int k = 0; k < 64; ++k) {
        CHECK(points[k][2] > 0.04f);
    }
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_wall_points(fluid, plate[0], 3, 0, velocities[0], 0), "walls");
    CHECK_OK(rlv_fluid_release(fluid));
}

/* A block that meets a box gives it what it loses, does not get into it, and is taken along when that moves. */
static void check_colliders(RlvContext context) {
    float points[64][3], corners[8][3];
    RlvFluidOptions options = RLV_FLUID_OPTIONS_INIT;
    RlvFluidColliderOptions rough = RLV_FLUID_COLLIDER_OPTIONS_INIT;
    options.gravity[2] = 0.0f;
    RlvFluid fluid = make(context, &options);
    RlvMesh box = check_box(context, -0.1f, 0.2f, -0.2f, 0.0f), open = check_plane(context, 1, 1);
    const double top[3] = {0.08, 0.08, 0.08};
    const float down[3] = {0, 0, -1};
    uint32_t number = 77, other = 77;
    double linear[3], angular[3];
    rough.contact = RLV_FLUID_FRICTION;
    rough.friction = 0.5f;
    CHECK_OK(rlv_fluid_add_collider(fluid, box, NULL, NULL, &number));
    const double away[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 5, 5, 5};
    CHECK_OK(rlv_fluid_add_collider(fluid, open, away, &rough, &other));
    CHECK(number == 0 && other == 1);
    CHECK_OK(rlv_fluid_impulse(fluid, number, linear, angular));
    CHECK(linear[2] == 0.0);
    CHECK_OK(rlv_fluid_add_box(fluid, low, top, down));
    double given = 0.0;
    const float before = info_of(fluid).momentum[2];
    for (int k = 0; k < 20; ++k) {
        const float was = info_of(fluid).momentum[2];
        CHECK_OK(rlv_fluid_step(fluid, 0.002f, NULL));
        CHECK_OK(rlv_fluid_impulse(fluid, number, linear, NULL));
        CHECK_NEAR(linear[2], was - info_of(fluid).momentum[2], 1e-4 * fabs((double)before));
        given += linear[2];
        CHECK_OK(rlv_fluid_impulse(fluid, other, linear, angular));
        CHECK(linear[0] == 0.0 && linear[2] == 0.0 && angular[1] == 0.0);
        CHECK_OK(rlv_fluid_impulse(fluid, RLV_FLUID_WALLS, linear, NULL));
        CHECK(linear[2] == 0.0);
    }
    CHECK(given < 0.5 * (double)before);
    RlvFluidArrays arrays = RLV_FLUID_ARRAYS_INIT;
    arrays.capacity = 64;
    arrays.points = points[0];
    CHECK_OK(rlv_mesh_get_points(box, corners[0], 8, 0));
    CHECK_OK(rlv_fluid_get(fluid, &arrays));
    for (int k = 0; k < 64; ++k) {
        CHECK(points[k][2] > 0.0f);
    }
    for (int k = 0; k < 8; ++k) {
        corners[k][2] += 0.1f;
    }
    CHECK_OK(rlv_fluid_move_collider(fluid, number, NULL, corners[0], 8, 0, 0.1f));
    CHECK_OK(rlv_fluid_advance(fluid, 0.15, NULL, NULL, NULL));
    CHECK_OK(rlv_fluid_get(fluid, &arrays));
    for (int k = 0; k < 64; ++k) {
        CHECK(points[k][2] > 0.1f || points[k][0] < -0.1f || points[k][0] > 0.2f || points[k][1] < -0.1f || points[k][1] > 0.2f);
    }
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_move_collider(fluid, 9, NULL, corners[0], 8, 0, 0.1f), "collider 9");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_move_collider(fluid, 0, NULL, corners[0], 7, 0, 0.1f), "collider 0");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_move_collider(fluid, 0, NULL, corners[0], 8, 0, -0.1f), "seconds");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_move_collider(fluid, 0, NULL, NULL, 8, 0, 0.1f), "to");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_impulse(fluid, 2, linear, NULL), "collider 2");
    rough.contact = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add_collider(fluid, box, NULL, &rough, &other), "contact");
    rough.contact = 0;
    rough.friction = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add_collider(fluid, box, NULL, &rough, &other), "friction");
    rough.friction = 0.0f;
    rough.is_container = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add_collider(fluid, box, NULL, &rough, &other), "is_container");
    CHECK(other == 1);
    CHECK_OK(rlv_mesh_release(open));
    CHECK_OK(rlv_mesh_release(box));
    CHECK_OK(rlv_fluid_release(fluid));
}

/* Meshes are filled, emitters make jets, sinks take them away, forces act, and reports tell all momentum. */
static void check_sources(RlvContext context) {
    RlvFluidOptions options = RLV_FLUID_OPTIONS_INIT;
    RlvFluidEmitterOptions tap = RLV_FLUID_EMITTER_OPTIONS_INIT;
    const RlvMesh nothing = RLV_NULL;
    RlvFluidReport report = RLV_FLUID_REPORT_INIT;
    options.gravity[2] = 0.0f;
    RlvFluid fluid = make(context, &options);
    RlvMesh box = check_box(context, 0.0f, 0.16f, 0.0f, 0.16f);
    const double up[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 3};
    size_t added = 77;
    CHECK_OK(rlv_fluid_fill(fluid, box, up, NULL, &added));
    CHECK(added == 512 && info_of(fluid).particle_count == 512);
    CHECK_OK(rlv_fluid_add_sink_mesh(fluid, box, up));
    CHECK_OK(rlv_fluid_step(fluid, 0.001f, &report));
    CHECK(report.removed == 512 && report.added == 0);

    /* A rectangle of 4 x 4 particles at 1 m/s: a layer every 0.02 s, until a sink after 0.2 m. */
    const double low[3] = {-1, -1, 0.2}, high[3] = {1, 1, 1};
    tap.shape = RLV_FLUID_RECTANGLE;
    tap.u[0] = tap.v[1] = 0.04f;
    tap.u[2] = 0.0f;
    CHECK_OK(rlv_fluid_add_emitter(fluid, nothing, NULL, &tap));
    CHECK_OK(rlv_fluid_add_sink(fluid, low, high, 0));
    CHECK_OK(rlv_fluid_advance(fluid, 0.15, NULL, NULL, &report));
    CHECK(report.added >= 7 * 16 && report.added <= 9 * 16 && report.removed == 0);
    CHECK_OK(rlv_fluid_advance(fluid, 0.15, NULL, NULL, &report));
    CHECK(report.removed >= 3 * 16 && info_of(fluid).particle_count <= 11 * 16);
    CHECK_OK(rlv_fluid_set_budget(fluid, 1, 0));
    CHECK(rlv_fluid_advance(fluid, 0.1, NULL, NULL, NULL) == RLV_ERROR_MEMORY);
    CHECK_OK(rlv_fluid_set_budget(fluid, 1, 1));
    CHECK_OK(rlv_fluid_advance(fluid, 0.3, NULL, NULL, &report));
    CHECK(report.added == 0 && info_of(fluid).particle_count == 0);
    CHECK_OK(rlv_fluid_clear_sources(fluid));
    CHECK_OK(rlv_fluid_set_budget(fluid, 0, 0));

    /* Gravity as a force, an attractor far away, and the host: what was given is what there is. */
    const RlvFluidForce forces[2] = {{RLV_FLUID_GRAVITY, 0, {0, 3, 0}, 0, {0}, 0, 0},
                                     {RLV_FLUID_ATTRACTOR, 0, {0}, 2, {100, 0, 0}, 1000, 0}};
    float pushes[512][3];
    CHECK_OK(rlv_fluid_fill(fluid, box, NULL, NULL, NULL));
    for (int k = 0; k < 512; ++k) {
        pushes[k][0] = pushes[k][1] = 0.0f;
        pushes[k][2] = 1.0f;
    }
    CHECK_OK(rlv_fluid_accelerate(fluid, pushes[0], 512, 0));
    CHECK_OK(rlv_fluid_set_forces(fluid, forces, 2, 0));
    CHECK_OK(rlv_fluid_advance(fluid, 0.05, NULL, NULL, &report));
    const RlvFluidInfo info = info_of(fluid);
    const double whole = 512.0 * info.mass * 0.05;
    CHECK_NEAR(report.forces[0], 2 * whole, 0.01 * whole);
    CHECK_NEAR(report.forces[1], 3 * whole, 0.01 * whole);
    CHECK_NEAR(report.host[2], whole, 1e-3 * whole);
    for (int axis = 0; axis < 3; ++axis) {
        CHECK(report.gravity[axis] == 0.0 && report.walls[axis] == 0.0);
        CHECK_NEAR(info.momentum[axis], report.forces[axis] + report.host[axis], 1e-3 * whole);
    }
    CHECK_OK(rlv_fluid_set_forces(fluid, NULL, 0, 0));

    RlvFluidForce bad = forces[1];
    bad.place[1] = 1e300; /* which no float holds */
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_forces(fluid, &bad, 1, 0), "force 0");
    bad = forces[0];
    bad.kind = 6;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_forces(fluid, &bad, 1, 0), "force 0");
    bad.kind = RLV_FLUID_VORTEX;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_forces(fluid, &bad, 1, 0), "force 0");
    tap.shape = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add_emitter(fluid, nothing, NULL, &tap), "shape");
    tap.shape = RLV_FLUID_SURFACE;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add_emitter(fluid, nothing, NULL, &tap), "mesh");
    CHECK_OK(rlv_fluid_add_emitter(fluid, box, up, &tap));
    tap.speed = 0.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add_emitter(fluid, box, NULL, &tap), "speed");
    tap.speed = 1.0f;
    tap.end = -1.0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add_emitter(fluid, box, NULL, &tap), "ends");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add_sink(fluid, low, high, 2), "is_outside");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_budget(fluid, 1, 2), "stops");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_fill(fluid, (RlvMesh){0}, NULL, NULL, NULL), "mesh");
    CHECK_OK(rlv_mesh_release(box));
    CHECK_OK(rlv_fluid_release(fluid));
}

/* A cube of water without weight gets round by its surface tension: the corners come nearer to the middle. */
static void check_tension(RlvContext context) {
    static float points[DAM][3];
    const double cube[3] = {0.008, 0.008, 0.008};
    float farthest[2] = {0, 0};
    for (int k = 0; k < 2; ++k) {
        RlvFluidOptions options = RLV_FLUID_OPTIONS_INIT;
        RlvFluidArrays arrays = RLV_FLUID_ARRAYS_INIT;
        options.spacing = 0.001f;
        options.gravity[2] = 0.0f;
        options.tension = k == 1 ? 0.072f : 0.0f;
        RlvFluid fluid = make(context, &options);
        CHECK_OK(rlv_fluid_add_box(fluid, low, cube, NULL));
        CHECK_OK(rlv_fluid_advance(fluid, 0.01, NULL, NULL, NULL));
        arrays.capacity = DAM;
        arrays.points = points[0];
        CHECK_OK(rlv_fluid_get(fluid, &arrays));
        for (int at = 0; at < DAM; ++at) {
            float square = 0;
            for (int axis = 0; axis < 3; ++axis) {
                square += (points[at][axis] - 0.004f) * (points[at][axis] - 0.004f);
            }
            farthest[k] = square > farthest[k] ? square : farthest[k];
        }
        CHECK_OK(rlv_fluid_release(fluid));
    }
    CHECK(sqrtf(farthest[1]) < 0.95f * sqrtf(farthest[0]));
}

static void check_refused(RlvContext context) {
    RlvFluid fluid = make(context, NULL), untouched = {77};
    RlvFluidOptions options = RLV_FLUID_OPTIONS_INIT;
    RlvFluidParticles particles = RLV_FLUID_PARTICLES_INIT;
    RlvFluidArrays arrays = RLV_FLUID_ARRAYS_INIT;
    RlvIsosurface surface = {77};
    float points[2][3] = {{0, 0, 0}, {0, 0, NAN}}, one[3];
    options.spacing = 0.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_create(context, &options, &untouched), "spacing");
    options.spacing = 0.02f;
    options.viscosity = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_create(context, &options, &untouched), "viscosity");
    options.viscosity = 0.0f;
    options.kernels = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_create(context, &options, &untouched), "kernels");
    options.kernels = 1;
    options.steps = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_create(context, &options, &untouched), "steps");
    options.steps = 0;
    options.tension = -1.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_create(context, &options, &untouched), "tension");
    options.tension = 0.0f;
    options.solver = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_create(context, &options, &untouched), "solver");
    options.solver = RLV_FLUID_DFSPH;
    options.min_corrections = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_create(context, &options, &untouched), "corrections");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_create(context, NULL, NULL), "out");
    CHECK(untouched.id == 77);
    particles.count = 2;
    particles.points = points[0];
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add(fluid, &particles), "points, element 1");
    points[1][2] = 1.0f;
    particles.velocity[1] = INFINITY;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add(fluid, &particles), "not finite");
    particles.velocity[1] = 0.0f;
    particles.lifetime = -1.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add(fluid, &particles), "live");
    particles.lifetime = 0.0f;
    particles.points = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add(fluid, &particles), "points");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add(fluid, NULL), "RlvFluidParticles");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add_box(fluid, high, low, NULL), "block");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_add_box(fluid, low, NULL, NULL), "high");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_basin(fluid, high, low), "basin");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_set_walls(fluid, NULL, 1, 0), "points");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_accelerate(fluid, points[0], 2, 0), "0 particles");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_remove(fluid, NULL, 1, 0, NULL), "numbers");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_step(fluid, -1.0f, NULL), "seconds");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_advance(fluid, NAN, NULL, NULL, NULL), "seconds");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_get(fluid, NULL), "RlvFluidArrays");
    CHECK(info_of(fluid).particle_count == 0);

    /* A fluid without particles goes on, and has a surface without any. */
    CHECK_OK(rlv_fluid_advance(fluid, 0.25, NULL, NULL, NULL));
    CHECK_NEAR(info_of(fluid).seconds, 0.25, 1e-6);
    CHECK_OK(rlv_fluid_get(fluid, &arrays));
    CHECK_OK(rlv_fluid_isosurface(fluid, NULL, &surface));
    CHECK_OK(rlv_isosurface_release(surface));
    particles.points = points[0];
    CHECK_OK(rlv_fluid_add(fluid, &particles));
    arrays.points = one;
    arrays.capacity = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_get(fluid, &arrays), "room for 1");

    /* All at one point: an error that says so, or an answer, and nothing lost. */
    float heap[300][3];
    memset(heap, 0, sizeof heap);
    particles.points = heap[0];
    particles.count = 300;
    CHECK_OK(rlv_fluid_add(fluid, &particles));
    const RlvResult result = rlv_fluid_step(fluid, 0.001f, NULL);
    CHECK(result == RLV_OK || result == RLV_ERROR_INVALID);
    CHECK(info_of(fluid).particle_count == 302);

    RlvContextOptions small = RLV_CONTEXT_OPTIONS_INIT;
    RlvContext poor = RLV_NULL;
    small.memory_limit = 1 << 16;
    CHECK_OK(rlv_context_create(&small, &poor));
    RlvFluid little = make(poor, NULL);
    const double wide[3] = {50, 50, 50};
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_fluid_add_box(little, low, wide, NULL), "memory limit");
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_fluid_add(little, &particles), "memory limit");
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_fluid_set_basin(little, low, far_end), "memory limit");
    CHECK_OK(rlv_fluid_release(little));
    CHECK_OK(rlv_context_release(poor));
    CHECK_OK(rlv_fluid_retain(fluid));
    CHECK_OK(rlv_fluid_release(fluid));
    CHECK_OK(rlv_fluid_release(fluid));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_fluid_step(fluid, 0.1f, NULL), "not alive");
}

int main(void) {
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    check_alone(context);
    check_dam(context);
    check_moving_walls(context);
    check_colliders(context);
    check_sources(context);
    check_tension(context);
    check_refused(context);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
