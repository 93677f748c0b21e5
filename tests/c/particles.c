/* What a host may hand over by mistake to fluids and their surfaces: NULL, handles that are dead, of another noun or made
 * up, descriptors of other sizes, and several threads at once. All is an error by the rules of the headers, or done. */
#include "check.h"

#include <pthread.h>

typedef RlvResult (*ByHandle)(uint64_t id);

static const double three[3] = {0.1, 0.1, 0.1}, zero[3] = {0, 0, 0};

static RlvResult create_fluid(uint64_t id) { RlvFluid out; return rlv_fluid_create((RlvContext){id}, NULL, &out); }
static RlvResult retain_fluid(uint64_t id) { return rlv_fluid_retain((RlvFluid){id}); }
static RlvResult release_fluid(uint64_t id) { return rlv_fluid_release((RlvFluid){id}); }
static RlvResult fluid_info(uint64_t id) { RlvFluidInfo out = RLV_FLUID_INFO_INIT; return rlv_fluid_info((RlvFluid){id}, &out); }
static RlvResult add(uint64_t id) { RlvFluidParticles in = RLV_FLUID_PARTICLES_INIT; return rlv_fluid_add((RlvFluid){id}, &in); }
static RlvResult add_box(uint64_t id) { return rlv_fluid_add_box((RlvFluid){id}, zero, three, NULL); }
static RlvResult remove_some(uint64_t id) { return rlv_fluid_remove((RlvFluid){id}, NULL, 0, 0, NULL); }
static RlvResult set_walls(uint64_t id) { return rlv_fluid_set_walls((RlvFluid){id}, NULL, 0, 0); }
static RlvResult set_basin(uint64_t id) { return rlv_fluid_set_basin((RlvFluid){id}, zero, three); }
static RlvResult move_walls(uint64_t id) { return rlv_fluid_set_wall_points((RlvFluid){id}, NULL, 0, 0, NULL, 0); }
static RlvResult accelerate(uint64_t id) { return rlv_fluid_accelerate((RlvFluid){id}, NULL, 0, 0); }
static RlvResult add_collider(uint64_t id) { uint32_t out; return rlv_fluid_add_collider((RlvFluid){id}, (RlvMesh){id}, NULL, NULL, &out); }
static RlvResult move_collider(uint64_t id) { return rlv_fluid_move_collider((RlvFluid){id}, 0, NULL, NULL, 0, 0, 0); }
static RlvResult impulse(uint64_t id) { return rlv_fluid_impulse((RlvFluid){id}, RLV_FLUID_WALLS, NULL, NULL); }
static RlvResult fill(uint64_t id) { return rlv_fluid_fill((RlvFluid){id}, (RlvMesh){id}, NULL, NULL, NULL); }
static RlvResult add_emitter(uint64_t id) {
    RlvFluidEmitterOptions in = RLV_FLUID_EMITTER_OPTIONS_INIT;
    return rlv_fluid_add_emitter((RlvFluid){id}, (RlvMesh){0}, NULL, &in);
}
static RlvResult add_sink(uint64_t id) { return rlv_fluid_add_sink((RlvFluid){id}, zero, three, 0); }
static RlvResult add_sink_mesh(uint64_t id) { return rlv_fluid_add_sink_mesh((RlvFluid){id}, (RlvMesh){id}, NULL); }
static RlvResult clear_sources(uint64_t id) { return rlv_fluid_clear_sources((RlvFluid){id}); }
static RlvResult set_budget(uint64_t id) { return rlv_fluid_set_budget((RlvFluid){id}, 0, 0); }
static RlvResult set_forces(uint64_t id) { return rlv_fluid_set_forces((RlvFluid){id}, NULL, 0, 0); }
static RlvResult step(uint64_t id) { return rlv_fluid_step((RlvFluid){id}, 0.001f, NULL); }
static RlvResult advance(uint64_t id) { return rlv_fluid_advance((RlvFluid){id}, 0.001, NULL, NULL, NULL); }
static RlvResult get(uint64_t id) { RlvFluidArrays in = RLV_FLUID_ARRAYS_INIT; return rlv_fluid_get((RlvFluid){id}, &in); }
static RlvResult surface_of(uint64_t id) { RlvIsosurface out; return rlv_fluid_isosurface((RlvFluid){id}, NULL, &out); }
static RlvResult set_channel(uint64_t id) { RlvAttributeArrays in = RLV_ATTRIBUTE_ARRAYS_INIT; return rlv_fluid_set_channel((RlvFluid){id}, &in); }
static RlvResult find_channel(uint64_t id) { uint32_t out; return rlv_fluid_find_channel((RlvFluid){id}, "heat", &out); }
static RlvResult channel_info(uint64_t id) { RlvAttributeInfo out = RLV_ATTRIBUTE_INFO_INIT; return rlv_fluid_channel_info((RlvFluid){id}, 0, &out); }
static RlvResult get_channel(uint64_t id) { return rlv_fluid_get_channel((RlvFluid){id}, 0, NULL, 0, 0); }
static RlvResult save(uint64_t id) { return rlv_fluid_save((RlvFluid){id}, "never.rlvfluid"); }
static RlvResult restore(uint64_t id) { return rlv_fluid_restore((RlvFluid){id}, "never.rlvfluid"); }
static RlvResult save_bytes(uint64_t id) { RlvBytes out; return rlv_fluid_save_bytes((RlvFluid){id}, &out); }
static RlvResult restore_bytes(uint64_t id) { return rlv_fluid_restore_bytes((RlvFluid){id}, NULL, 0); }
static RlvResult particles_of(uint64_t id) { RlvParticles out; return rlv_fluid_particles((RlvFluid){id}, &out); }
static RlvResult add_particles(uint64_t id) { return rlv_fluid_add_particles((RlvFluid){id}, (RlvParticles){id}); }
static RlvResult job_fluid(uint64_t id) { RlvJob out; return rlv_job_fluid((RlvFluid){id}, 0.001, &out); }
static RlvResult job_report(uint64_t id) { RlvFluidReport out = RLV_FLUID_REPORT_INIT; return rlv_job_fluid_report((RlvJob){id}, &out); }
static RlvResult create_surface(uint64_t id) {
    RlvIsosurfaceParticles in = RLV_ISOSURFACE_PARTICLES_INIT;
    RlvIsosurface out;
    return rlv_isosurface_create((RlvContext){id}, &in, NULL, &out);
}
static RlvResult retain_surface(uint64_t id) { return rlv_isosurface_retain((RlvIsosurface){id}); }
static RlvResult release_surface(uint64_t id) { return rlv_isosurface_release((RlvIsosurface){id}); }
static RlvResult surface_info(uint64_t id) { RlvIsosurfaceInfo out = RLV_ISOSURFACE_INFO_INIT; return rlv_isosurface_info((RlvIsosurface){id}, &out); }
static RlvResult surface_mesh(uint64_t id) { RlvMesh out; return rlv_isosurface_mesh((RlvIsosurface){id}, NULL, NULL, NULL, &out); }
static RlvResult classify(uint64_t id) { return rlv_isosurface_classify((RlvIsosurface){id}, 0, NULL, 0, 0, NULL, NULL, NULL); }
static RlvResult cast(uint64_t id) { RlvRayArrays rays = RLV_RAY_ARRAYS_INIT; return rlv_isosurface_cast((RlvIsosurface){id}, &rays, NULL, 0); }
static RlvResult table(uint64_t id) { RlvIsosurfaceTable out = RLV_ISOSURFACE_TABLE_INIT; return rlv_isosurface_table((RlvIsosurface){id}, &out); }
static RlvResult job_surface(uint64_t id) { RlvJob out; return rlv_job_isosurface((RlvIsosurface){id}, NULL, &out); }

enum { CONTEXT, FLUID, SURFACE, JOB, NOUNS };

static const struct {
    ByHandle call;
    int noun;
} calls[] = {
    {create_fluid, CONTEXT}, {retain_fluid, FLUID},    {release_fluid, FLUID},     {fluid_info, FLUID},
    {add, FLUID},            {add_box, FLUID},         {remove_some, FLUID},       {set_walls, FLUID},
    {set_basin, FLUID},      {move_walls, FLUID},      {accelerate, FLUID},        {step, FLUID},
    {advance, FLUID},        {get, FLUID},             {surface_of, FLUID},        {job_fluid, FLUID},
    {job_report, JOB},       {create_surface, CONTEXT}, {retain_surface, SURFACE}, {release_surface, SURFACE},
    {surface_info, SURFACE}, {surface_mesh, SURFACE},  {classify, SURFACE},        {cast, SURFACE},
    {table, SURFACE},        {job_surface, SURFACE},   {add_collider, FLUID},      {move_collider, FLUID},
    {impulse, FLUID},        {fill, FLUID},            {add_emitter, FLUID},       {add_sink, FLUID},
    {add_sink_mesh, FLUID},  {clear_sources, FLUID},   {set_budget, FLUID},        {set_forces, FLUID},
    {set_channel, FLUID},    {find_channel, FLUID},    {channel_info, FLUID},      {get_channel, FLUID},
    {save, FLUID},           {restore, FLUID},         {save_bytes, FLUID},        {restore_bytes, FLUID},
    {particles_of, FLUID},   {add_particles, FLUID},
};

static void check_handles(const uint64_t living[NOUNS], uint64_t dead_fluid, uint64_t dead_surface) {
    for (size_t call = 0; call < sizeof calls / sizeof *calls; ++call) {
        const uint64_t made_up[] = {0, 1, UINT64_MAX, dead_fluid, dead_surface, living[calls[call].noun] ^ 1u << 31};
        for (size_t k = 0; k < sizeof made_up / sizeof *made_up; ++k) {
            CHECK(calls[call].call(made_up[k]) == RLV_ERROR_INVALID);
        }
        for (int noun = 0; noun < NOUNS; ++noun) {
            if (noun != calls[call].noun) {
                CHECK(calls[call].call(living[noun]) == RLV_ERROR_INVALID);
            }
        }
    }
}

/* A descriptor that says of itself that it has other sizes: too small ones and huge ones are refused, larger ones if what
 * is unknown is not zero. */
#define CHECK_SIZES(type, init, call)                                \
    do {                                                             \
        struct {                                                     \
            type known;                                              \
            uint8_t unknown[64];                                     \
        } given;                                                     \
        const type initial = init;                                   \
        const uint32_t sizes[4] = {0, 3, (uint32_t)sizeof(type) - 1, 1 << 20}; \
        memset(&given, 0, sizeof given);                             \
        given.known = initial;                                       \
        for (int k = 0; k < 4; ++k) {                                \
            given.known.struct_size = sizes[k];                      \
            CHECK((call) == RLV_ERROR_INVALID);                      \
        }                                                            \
        given.known.struct_size = sizeof given;                      \
        given.unknown[9] = 1;                                        \
        CHECK((call) == RLV_ERROR_UNSUPPORTED);                      \
    } while (0)

static void check_sizes(RlvContext context, RlvFluid fluid, RlvIsosurface surface) {
    RlvFluid made = {77};
    RlvIsosurface other = {77};
    RlvMesh mesh = {77};
    RlvIsosurfaceParticles none = RLV_ISOSURFACE_PARTICLES_INIT;
    CHECK_SIZES(RlvFluidOptions, RLV_FLUID_OPTIONS_INIT, rlv_fluid_create(context, &given.known, &made));
    CHECK_SIZES(RlvFluidParticles, RLV_FLUID_PARTICLES_INIT, rlv_fluid_add(fluid, &given.known));
    CHECK_SIZES(RlvFluidArrays, RLV_FLUID_ARRAYS_INIT, rlv_fluid_get(fluid, &given.known));
    CHECK_SIZES(RlvIsosurfaceOptions, RLV_ISOSURFACE_OPTIONS_INIT, rlv_fluid_isosurface(fluid, &given.known, &other));
    CHECK_SIZES(RlvIsosurfaceOptions, RLV_ISOSURFACE_OPTIONS_INIT, rlv_isosurface_create(context, &none, &given.known, &other));
    CHECK_SIZES(RlvIsosurfaceParticles, RLV_ISOSURFACE_PARTICLES_INIT, rlv_isosurface_create(context, &given.known, NULL, &other));
    CHECK_SIZES(RlvIsosurfaceMeshOptions, RLV_ISOSURFACE_MESH_OPTIONS_INIT, rlv_isosurface_mesh(surface, &given.known, NULL, NULL, &mesh));
    CHECK(made.id == 77 && other.id == 77 && mesh.id == 77);
    RlvMesh box = check_box(context, 0.0f, 1.0f, 0.0f, 1.0f);
    uint32_t number = 77;
    CHECK_SIZES(RlvFluidColliderOptions, RLV_FLUID_COLLIDER_OPTIONS_INIT, rlv_fluid_add_collider(fluid, box, NULL, &given.known, &number));
    CHECK_SIZES(RlvFluidEmitterOptions, RLV_FLUID_EMITTER_OPTIONS_INIT, rlv_fluid_add_emitter(fluid, (RlvMesh){0}, NULL, &given.known));
    CHECK(rlv_fluid_add_collider(fluid, box, NULL, NULL, NULL) == RLV_ERROR_INVALID && number == 77);
    CHECK_OK(rlv_mesh_release(box));
    RlvFluidReport report = RLV_FLUID_REPORT_INIT;
    RlvIsosurfaceTable functions = RLV_ISOSURFACE_TABLE_INIT;
    report.struct_size = 5;
    functions.struct_size = 0;
    CHECK(rlv_fluid_step(fluid, 0.001f, &report) == RLV_ERROR_INVALID && report.steps == 0);
    CHECK(rlv_fluid_advance(fluid, 0.001, NULL, NULL, &report) == RLV_ERROR_INVALID);
    CHECK(rlv_isosurface_table(surface, &functions) == RLV_ERROR_INVALID && functions.data == NULL);
    CHECK(rlv_fluid_info(fluid, NULL) == RLV_ERROR_INVALID && rlv_isosurface_info(surface, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_fluid_isosurface(fluid, NULL, NULL) == RLV_ERROR_INVALID && rlv_job_fluid(fluid, 0.1, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_job_isosurface(surface, NULL, NULL) == RLV_ERROR_INVALID);
}

/* Steps, reads and looks at surfaces at the same time: each call is done or busy. */
static void *use(void *user) {
    const RlvFluid fluid = *(const RlvFluid *)user;
    for (int round = 0; round < 30; ++round) {
        float points[400][3];
        RlvFluidArrays arrays = RLV_FLUID_ARRAYS_INIT;
        RlvIsosurface surface = RLV_NULL;
        RlvResult result = rlv_fluid_step(fluid, 0.0005f, NULL);
        CHECK(result == RLV_OK || result == RLV_ERROR_BUSY);
        arrays.capacity = 400;
        arrays.points = points[0];
        result = rlv_fluid_get(fluid, &arrays);
        CHECK(result == RLV_OK || result == RLV_ERROR_BUSY);
        result = rlv_fluid_isosurface(fluid, NULL, &surface);
        CHECK(result == RLV_OK || result == RLV_ERROR_BUSY);
        if (result == RLV_OK) {
            CHECK(cast(surface.id) == RLV_OK);
            CHECK_OK(rlv_isosurface_release(surface));
        }
    }
    return NULL;
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvFluid fluid = RLV_NULL, dead_fluid = RLV_NULL;
    RlvIsosurface surface = RLV_NULL, dead_surface = RLV_NULL;
    RlvJob job = RLV_NULL;
    RlvFluidReport report = RLV_FLUID_REPORT_INIT;
    RlvMesh mesh = RLV_NULL;
    const double size[3] = {0.14, 0.14, 0.14}, tall[3] = {0.14, 0.14, 0.3};
    CHECK_OK(rlv_context_create(NULL, &context));
    CHECK_OK(rlv_fluid_create(context, NULL, &fluid));
    CHECK_OK(rlv_fluid_set_basin(fluid, zero, tall));
    CHECK_OK(rlv_fluid_add_box(fluid, zero, size, NULL));
    CHECK_OK(rlv_fluid_isosurface(fluid, NULL, &surface));
    CHECK_OK(rlv_job_isosurface(surface, NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_fluid_report(job, &report), "not started for a fluid");
    CHECK_OK(rlv_fluid_create(context, NULL, &dead_fluid));
    CHECK_OK(rlv_fluid_isosurface(dead_fluid, NULL, &dead_surface));
    CHECK_OK(rlv_fluid_release(dead_fluid));
    CHECK_OK(rlv_isosurface_release(dead_surface));
    const uint64_t living[NOUNS] = {context.id, fluid.id, surface.id, job.id};
    check_handles(living, dead_fluid.id, dead_surface.id);
    check_sizes(context, fluid, surface);
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_job_fluid(fluid, 0.001, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_mesh(job, &mesh), "not started for triangles");
    CHECK_OK(rlv_job_release(job));
    pthread_t threads[4];
    for (int k = 0; k < 4; ++k) {
        CHECK(pthread_create(&threads[k], NULL, use, &fluid) == 0);
    }
    for (int k = 0; k < 4; ++k) {
        CHECK(pthread_join(threads[k], NULL) == 0);
    }
    CHECK_OK(rlv_isosurface_release(surface));
    CHECK_OK(rlv_fluid_release(fluid));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
