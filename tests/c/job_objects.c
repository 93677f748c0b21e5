/* Jobs that make objects and files: each says from its start what it makes, gives what the call gives, the same object every
 * time, ends as cancelled when it is cancelled before, may be released while it runs, and fails with the sentence of the
 * call. Once on threads of the library and once as tasks of the host, which run when the test says so. */
#include "check.h"

static RlvTask task;
static void *work;

static void keep(void *user, RlvTask given, void *given_work) {
    (void)user;
    CHECK(task == NULL);
    task = given;
    work = given_work;
}

/* Lets the host run what it was given, if it was. */
static void run(void) {
    RlvTask given = task;
    task = NULL;
    if (given != NULL) {
        given(work);
    }
}

static RlvContext context;
static RlvMesh plane;
static RlvSurface surface;
static RlvDetail detail;
static RlvTessellation tessellation;
static RlvProcedural still;
static RlvParticles particles;
static RlvDocument document;
static RlvProgressive progressive;
static RlvTissue tissue;
static RlvCrowdModel model;
static RlvGrid grid;
static RlvBytes embedded;
/* Files of their own, since a job that was released may still write. */
static int number;
static char path[64];

static const char *name(const char *pattern) {
    snprintf(path, sizeof path, pattern, number);
    return path;
}

static RlvResult surfaces(RlvJob *out) { return rlv_job_surface_create(context, plane, NULL, out); }
static RlvResult mesh_casters(RlvJob *out) { return rlv_job_caster_create_mesh(context, plane, out); }
static RlvResult detail_casters(RlvJob *out) { return rlv_job_caster_create_detail(detail, NULL, out); }
static RlvResult followers(RlvJob *out) { return rlv_job_caster_create_tessellation(tessellation, out); }
static RlvResult procedurals(RlvJob *out) { return rlv_job_procedural_create(detail, NULL, out); }
static RlvResult movings(RlvJob *out) { return rlv_job_procedural_create_moving(still, detail, out); }
static RlvResult mesh_colliders(RlvJob *out) { return rlv_job_collider_create_mesh(context, plane, NULL, out); }
static RlvResult surface_colliders(RlvJob *out) { return rlv_job_collider_create_surface(surface, NULL, NULL, out); }
static RlvResult detail_colliders(RlvJob *out) { return rlv_job_collider_create_detail(detail, NULL, out); }
static RlvResult mesh_reads(RlvJob *out) { return rlv_job_mesh_read(context, "job_objects.obj", out); }
static RlvResult mesh_writes(RlvJob *out) { return rlv_job_mesh_write(plane, name("job_objects_%d.obj"), out); }
static RlvResult particle_reads(RlvJob *out) { return rlv_job_particles_read(context, "job_objects.bgeo", out); }
static RlvResult particle_writes(RlvJob *out) { return rlv_job_particles_write(particles, name("job_objects_%d.bgeo"), out); }
static RlvResult pictures(RlvJob *out) { return rlv_job_picture_open(context, "job_objects.relievo", out); }
static RlvResult documents(RlvJob *out) { return rlv_job_document_create(detail, name("job_objects_%d.relievo"), 0, out); }
static RlvResult opened(RlvJob *out) { return rlv_job_document_open(detail, "job_objects_open.relievo", 0, out); }
static RlvResult saves(RlvJob *out) { return rlv_job_document_save(document, name("job_objects_%d_saved.relievo"), out); }
static RlvResult progressive_reads(RlvJob *out) { return rlv_job_progressive_read(context, "job_objects.rlvpm", SIZE_MAX, out); }
static RlvResult progressive_writes(RlvJob *out) { return rlv_job_progressive_write(progressive, name("job_objects_%d.rlvpm"), out); }
static RlvResult crowd_reads(RlvJob *out) { return rlv_job_crowd_model_read(context, "job_objects.rcrowd", out); }
static RlvResult crowd_writes(RlvJob *out) { return rlv_job_crowd_model_write(model, name("job_objects_%d.rcrowd"), out); }
static RlvResult tissue_reads(RlvJob *out) { return rlv_job_tissue_read(context, "job_objects.rtissue", out); }
static RlvResult tissue_writes(RlvJob *out) { return rlv_job_tissue_write(tissue, name("job_objects_%d.rtissue"), out); }
static RlvResult grid_writes(RlvJob *out) { return rlv_job_grid_write(&grid, 1, name("job_objects_%d.vdb"), RLV_GRID_PACK_ZIP, out); }
static RlvResult save_bytes(RlvJob *out) { return rlv_job_document_save_bytes(document, out); }
static RlvResult open_bytes(RlvJob *out) {
    const uint8_t *data = NULL;
    size_t size = 0;
    CHECK_OK(rlv_bytes_get(embedded, &data, &size));
    return rlv_job_document_open_bytes(detail, data, size, 0, out);
}
static RlvResult compactions(RlvJob *out) { return rlv_job_document_compact(context, "job_objects.relievo", 0, out); }

#define TAKE(noun, type)                                             \
    static RlvResult take_##noun(RlvJob job, uint64_t *out) {        \
        type made = {*out};                                          \
        RlvResult result = rlv_job_##noun(job, &made);               \
        *out = made.id;                                              \
        return result;                                               \
    }                                                                \
    static RlvResult drop_##noun(uint64_t id) { return rlv_##noun##_release((type){id}); }

TAKE(mesh, RlvMesh)
TAKE(particles, RlvParticles)
TAKE(surface, RlvSurface)
TAKE(caster, RlvCaster)
TAKE(procedural, RlvProcedural)
TAKE(collider, RlvCollider)
TAKE(picture, RlvPicture)
TAKE(document, RlvDocument)
TAKE(crowd_model, RlvCrowdModel)
TAKE(tissue, RlvTissue)
TAKE(bytes, RlvBytes)

/* Its functions have two names. */
static RlvResult take_progressive(RlvJob job, uint64_t *out) {
    RlvProgressive made = {*out};
    RlvResult result = rlv_job_progressive_mesh(job, &made);
    *out = made.id;
    return result;
}

static RlvResult drop_progressive(uint64_t id) { return rlv_progressive_release((RlvProgressive){id}); }

static RlvResult take_nothing(RlvJob job, uint64_t *out) {
    (void)out;
    return rlv_job_result(job);
}

static RlvResult drop_nothing(uint64_t id) {
    (void)id;
    return RLV_OK;
}

typedef struct Kind {
    RlvResult (*start)(RlvJob *out);
    uint32_t kind;
    RlvResult (*take)(RlvJob job, uint64_t *out);
    RlvResult (*drop)(uint64_t id);
} Kind;

static const Kind KINDS[] = {
    {surfaces, RLV_JOB_KIND_SURFACE, take_surface, drop_surface},
    {mesh_casters, RLV_JOB_KIND_CASTER, take_caster, drop_caster},
    {detail_casters, RLV_JOB_KIND_CASTER, take_caster, drop_caster},
    {followers, RLV_JOB_KIND_CASTER, take_caster, drop_caster},
    {procedurals, RLV_JOB_KIND_PROCEDURAL, take_procedural, drop_procedural},
    {movings, RLV_JOB_KIND_PROCEDURAL, take_procedural, drop_procedural},
    {mesh_colliders, RLV_JOB_KIND_COLLIDER, take_collider, drop_collider},
    {surface_colliders, RLV_JOB_KIND_COLLIDER, take_collider, drop_collider},
    {detail_colliders, RLV_JOB_KIND_COLLIDER, take_collider, drop_collider},
    {mesh_reads, RLV_JOB_KIND_MESH, take_mesh, drop_mesh},
    {mesh_writes, RLV_JOB_KIND_NONE, take_nothing, drop_nothing},
    {particle_reads, RLV_JOB_KIND_PARTICLES, take_particles, drop_particles},
    {particle_writes, RLV_JOB_KIND_NONE, take_nothing, drop_nothing},
    {pictures, RLV_JOB_KIND_PICTURE, take_picture, drop_picture},
    {documents, RLV_JOB_KIND_DOCUMENT, take_document, drop_document},
    {saves, RLV_JOB_KIND_NONE, take_nothing, drop_nothing},
    {compactions, RLV_JOB_KIND_NONE, take_nothing, drop_nothing},
    {opened, RLV_JOB_KIND_DOCUMENT, take_document, drop_document},
    {progressive_reads, RLV_JOB_KIND_PROGRESSIVE, take_progressive, drop_progressive},
    {progressive_writes, RLV_JOB_KIND_NONE, take_nothing, drop_nothing},
    {crowd_reads, RLV_JOB_KIND_CROWD_MODEL, take_crowd_model, drop_crowd_model},
    {crowd_writes, RLV_JOB_KIND_NONE, take_nothing, drop_nothing},
    {tissue_reads, RLV_JOB_KIND_TISSUE, take_tissue, drop_tissue},
    {tissue_writes, RLV_JOB_KIND_NONE, take_nothing, drop_nothing},
    {grid_writes, RLV_JOB_KIND_NONE, take_nothing, drop_nothing},
    {save_bytes, RLV_JOB_KIND_BYTES, take_bytes, drop_bytes},
    {open_bytes, RLV_JOB_KIND_DOCUMENT, take_document, drop_document},
};

static void check_kind(const Kind *kind, int is_task) {
    RlvJob job = RLV_NULL;
    RlvJobInfo info = RLV_JOB_INFO_INIT;
    uint64_t made = 0, again = 0;
    /* To its end. */
    ++number;
    CHECK_OK(kind->start(&job));
    CHECK_OK(rlv_job_poll(job, &info));
    CHECK(info.kind == kind->kind);
    if (is_task) {
        CHECK(info.state == RLV_JOB_RUNNING);
        CHECK_FAILS(RLV_ERROR_BUSY, kind->take(job, &made), "rlv_job_wait");
        run();
    }
    CHECK_OK(rlv_job_wait(job, -1.0, &info));
    CHECK(info.state == RLV_JOB_DONE && info.kind == kind->kind && info.fraction == 1.0f);
    CHECK_OK(kind->take(job, &made));
    CHECK_OK(kind->take(job, &again));
    CHECK(made == again && (made != 0) == (kind->kind != RLV_JOB_KIND_NONE));
    CHECK_OK(kind->drop(again));
    RlvGrid other = {77};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_grid(job, &other), "was not started for a grid");
    CHECK(other.id == 77);
    RlvTissueReport report = RLV_TISSUE_REPORT_INIT;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_tissue_report(job, &report), "was not started for building soft tissue");
    CHECK_OK(rlv_job_release(job));
    /* The object outlives its job. */
    CHECK_OK(kind->drop(made));
    /* Cancelled before it works, it ends as cancelled; on a thread it may have ended by then. */
    ++number;
    CHECK_OK(kind->start(&job));
    CHECK_OK(rlv_job_cancel(job));
    run();
    CHECK_OK(rlv_job_wait(job, -1.0, &info));
    CHECK(info.state == RLV_JOB_CANCELLED || (!is_task && info.state == RLV_JOB_DONE));
    if (info.state == RLV_JOB_CANCELLED) {
        made = 77;
        CHECK(info.result == RLV_ERROR_CANCELLED);
        CHECK_FAILS(RLV_ERROR_CANCELLED, kind->take(job, &made), "cancelled");
        CHECK(made == 77);
    }
    CHECK_OK(rlv_job_release(job));
    /* Released while it runs. What it needs is free again some time after. */
    ++number;
    CHECK_OK(kind->start(&job));
    CHECK_OK(rlv_job_release(job));
    run();
    CHECK_OK(rlv_object_wait(detail.id, -1.0, NULL));
    CHECK_OK(rlv_object_wait(document.id, -1.0, NULL));
}

/* What follows the name of the function. */
static const char *sentence(void) {
    const char *found = strchr(rlv_error_last(), ' ');
    return found == NULL ? "" : found;
}

/* The job fails with the result and the sentence of the call that failed last, when it starts or when it has ended. */
static void check_failure(RlvResult result, RlvResult started, RlvJob job) {
    static char expected[1024];
    CHECK(result != RLV_OK);
    if (started == RLV_OK) {
        RlvJobInfo info = RLV_JOB_INFO_INIT;
        run();
        CHECK_OK(rlv_job_wait(job, -1.0, &info));
        CHECK(info.state == RLV_JOB_FAILED && info.result == result);
        started = rlv_job_result(job);
        CHECK_OK(rlv_job_release(job));
    }
    CHECK(started == result);
    snprintf(expected, sizeof expected, "%s", sentence());
    CHECK(strlen(expected) > 10);
}

#define FAILS_ALIKE(call, start)                                       \
    do {                                                               \
        char before[1024];                                             \
        RlvJob failing = RLV_NULL;                                     \
        RlvResult result = (call), begun;                              \
        snprintf(before, sizeof before, "%s", sentence());             \
        begun = (start);                                               \
        check_failure(result, begun, failing);                         \
        CHECK(strcmp(before, sentence()) == 0);                        \
    } while (0)

static void check_failures(void) {
    RlvMesh mesh;
    RlvSurface odd_surface;
    RlvCaster caster;
    RlvCollider collider;
    RlvProcedural procedural;
    RlvPicture picture;
    RlvDocument other;
    RlvParticles none;
    const double flat[12] = {0};
    RlvSurfaceOptions deep = RLV_SURFACE_OPTIONS_INIT;
    RlvTessellateOptions odd = RLV_TESSELLATE_OPTIONS_INIT;
    RlvProceduralOptions few = RLV_PROCEDURAL_OPTIONS_INIT;
    deep.isolation = 11;
    odd.coarse = 3;
    few.coarse = 3;
    FAILS_ALIKE(rlv_mesh_read(context, "nowhere.obj", &mesh), rlv_job_mesh_read(context, "nowhere.obj", &failing));
    FAILS_ALIKE(rlv_mesh_write(plane, "plane.unknown"), rlv_job_mesh_write(plane, "plane.unknown", &failing));
    FAILS_ALIKE(rlv_particles_read(context, "nowhere.bgeo", &none), rlv_job_particles_read(context, "nowhere.bgeo", &failing));
    FAILS_ALIKE(rlv_picture_open(context, "nowhere.relievo", &picture), rlv_job_picture_open(context, "nowhere.relievo", &failing));
    FAILS_ALIKE(rlv_document_open(detail, "nowhere.relievo", 0, &other), rlv_job_document_open(detail, "nowhere.relievo", 0, &failing));
    FAILS_ALIKE(rlv_document_compact(context, "nowhere.relievo", 0), rlv_job_document_compact(context, "nowhere.relievo", 0, &failing));
    FAILS_ALIKE(rlv_document_create(detail, "nowhere/there.relievo", 0, &other), rlv_job_document_create(detail, "nowhere/there.relievo", 0, &failing));
    FAILS_ALIKE(rlv_surface_create(context, plane, &deep, &odd_surface), rlv_job_surface_create(context, plane, &deep, &failing));
    FAILS_ALIKE(rlv_caster_create_detail(detail, &odd, &caster), rlv_job_caster_create_detail(detail, &odd, &failing));
    FAILS_ALIKE(rlv_collider_create_mesh(context, plane, flat, &collider), rlv_job_collider_create_mesh(context, plane, flat, &failing));
    FAILS_ALIKE(rlv_collider_create_surface(surface, &odd, NULL, &collider), rlv_job_collider_create_surface(surface, &odd, NULL, &failing));
    FAILS_ALIKE(rlv_procedural_create(detail, &few, &procedural), rlv_job_procedural_create(detail, &few, &failing));
    FAILS_ALIKE(rlv_progressive_read(context, "nowhere.rlvpm", 0, &(RlvProgressive){0}), rlv_job_progressive_read(context, "nowhere.rlvpm", 0, &failing));
    FAILS_ALIKE(rlv_progressive_write(progressive, "nowhere/there.rlvpm"), rlv_job_progressive_write(progressive, "nowhere/there.rlvpm", &failing));
    FAILS_ALIKE(rlv_crowd_model_read(context, "nowhere.rcrowd", &(RlvCrowdModel){0}), rlv_job_crowd_model_read(context, "nowhere.rcrowd", &failing));
    FAILS_ALIKE(rlv_crowd_model_write(model, "nowhere/there.rcrowd"), rlv_job_crowd_model_write(model, "nowhere/there.rcrowd", &failing));
    FAILS_ALIKE(rlv_tissue_read(context, "nowhere.rtissue", &(RlvTissue){0}), rlv_job_tissue_read(context, "nowhere.rtissue", &failing));
    FAILS_ALIKE(rlv_tissue_write(tissue, "nowhere/there.rtissue"), rlv_job_tissue_write(tissue, "nowhere/there.rtissue", &failing));
    FAILS_ALIKE(rlv_grid_write(&grid, 1, "nowhere/there.vdb", 0), rlv_job_grid_write(&grid, 1, "nowhere/there.vdb", 0, &failing));
    FAILS_ALIKE(rlv_document_open_bytes(detail, (const uint8_t *)"no", 2, 0, &other), rlv_job_document_open_bytes(detail, (const uint8_t *)"no", 2, 0, &failing));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_grid_write(&grid, 0, "a.vdb", 0, &(RlvJob){0}), "no grid");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_surface_create(context, plane, NULL, NULL), "out");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_caster_create_mesh(context, (RlvMesh){detail.id}, &(RlvJob){0}), "of a detail");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_mesh_read(context, NULL, &(RlvJob){0}), "path");
}

static void check_all(int is_task) {
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvParticlesArrays arrays = RLV_PARTICLES_ARRAYS_INIT;
    const float points[6] = {0, 0, 0, 1, 0, 0};
    options.threads = 1;
    options.host_spawn = is_task ? keep : NULL;
    CHECK_OK(rlv_context_create(&options, &context));
    plane = check_plane(context, 2, 2);
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    CHECK_OK(rlv_tessellation_create(detail, NULL, &tessellation));
    CHECK_OK(rlv_procedural_create(detail, NULL, &still));
    arrays.points = points;
    arrays.count = 2;
    CHECK_OK(rlv_particles_create(context, &arrays, &particles));
    CHECK_OK(rlv_mesh_write(plane, "job_objects.obj"));
    CHECK_OK(rlv_particles_write(particles, "job_objects.bgeo"));
    /* One that is opened and one that is compacted: a job that was released may still have its file. */
    CHECK_OK(rlv_document_create(detail, "job_objects.relievo", 0, &document));
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_document_create(detail, "job_objects_open.relievo", 0, &document));
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_document_create(detail, NULL, 0, &document));
    CHECK_OK(rlv_document_save_bytes(document, &embedded));
    RlvMesh box = check_box(context, 0.0f, 0.1f, 0.0f, 0.1f);
    tissue = check_tissue(context, box);
    CHECK_OK(rlv_tissue_write(tissue, "job_objects.rtissue"));
    CHECK_OK(rlv_progressive_create(box, NULL, NULL, NULL, &progressive));
    CHECK_OK(rlv_progressive_write(progressive, "job_objects.rlvpm"));
    CHECK_OK(rlv_crowd_model_build(context, "job_objects.obj", NULL, 0, NULL, NULL, NULL, &model));
    CHECK_OK(rlv_crowd_model_write(model, "job_objects.rcrowd"));
    RlvGridSettings coarse = RLV_GRID_SETTINGS_INIT;
    coarse.voxel = 0.02f;
    CHECK_OK(rlv_grid_from_mesh(box, &coarse, NULL, NULL, &grid));
    for (size_t index = 0; index < sizeof KINDS / sizeof *KINDS; ++index) {
        check_kind(&KINDS[index], is_task);
    }
    check_failures();
    CHECK_OK(rlv_grid_release(grid));
    CHECK_OK(rlv_crowd_model_release(model));
    CHECK_OK(rlv_progressive_release(progressive));
    CHECK_OK(rlv_tissue_release(tissue));
    CHECK_OK(rlv_bytes_release(embedded));
    CHECK_OK(rlv_mesh_release(box));
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_particles_release(particles));
    CHECK_OK(rlv_procedural_release(still));
    CHECK_OK(rlv_tessellation_release(tessellation));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(context));
}

static RlvJob stopping;
static int loops, stop_at;

/* A parallel loop of the host, which cancels the job in the middle. */
static void loop(void *user, size_t count, RlvLoopBody body, void *given) {
    (void)user;
    if (++loops == stop_at) {
        CHECK_OK(rlv_job_cancel(stopping));
    }
    for (size_t index = 0; index < count; ++index) {
        body(given, index);
    }
}

/* Cancelled while it works, it does a part of the work only. */
static void check_stop(RlvResult (*start)(RlvJob *)) {
    RlvJobInfo info = RLV_JOB_INFO_INIT;
    CHECK_OK(start(&stopping));
    loops = stop_at = 0;
    run();
    CHECK_OK(rlv_job_wait(stopping, -1.0, &info));
    CHECK(info.state == RLV_JOB_DONE);
    CHECK_OK(rlv_job_release(stopping));
    const int all = loops;
    CHECK(all > 12);
    CHECK_OK(start(&stopping));
    loops = 0;
    stop_at = all / 3;
    run();
    CHECK_OK(rlv_job_wait(stopping, -1.0, &info));
    CHECK(info.state == RLV_JOB_CANCELLED && info.result == RLV_ERROR_CANCELLED);
    CHECK(info.fraction > 0.0f && info.fraction < 0.6f && loops <= all / 2);
    CHECK_OK(rlv_job_release(stopping));
    stop_at = 0;
}

static RlvResult tessellations(RlvJob *out) { return rlv_job_tessellate(detail, NULL, out); }

static void check_stops(uint32_t kind) {
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvSurfaceOptions how = RLV_SURFACE_OPTIONS_INIT;
    options.threads = 2;
    options.host_loop = loop;
    options.host_spawn = keep;
    how.kind = kind;
    CHECK_OK(rlv_context_create(&options, &context));
    plane = check_plane(context, 16, 16);
    CHECK_OK(rlv_surface_create(context, plane, &how, &surface));
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    check_stop(tessellations);
    check_stop(detail_casters);
    check_stop(detail_colliders);
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(context));
}

int main(void) {
    check_stops(RLV_SURFACE_CATMULL_CLARK);
    check_stops(RLV_SURFACE_TRIANGLES);
    check_all(1);
    check_all(0);
    for (; number > 0; --number) {
        /* Some were never written. */
        remove(name("job_objects_%d.obj"));
        remove(name("job_objects_%d.bgeo"));
        remove(name("job_objects_%d.relievo"));
        remove(name("job_objects_%d_saved.relievo"));
        remove(name("job_objects_%d.rlvpm"));
        remove(name("job_objects_%d.rcrowd"));
        remove(name("job_objects_%d.rtissue"));
        remove(name("job_objects_%d.vdb"));
    }
    CHECK(remove("job_objects_open.relievo") == 0 && remove("job_objects.rlvpm") == 0);
    CHECK(remove("job_objects.rcrowd") == 0 && remove("job_objects.rtissue") == 0);
    CHECK(remove("job_objects.obj") == 0 && remove("job_objects.bgeo") == 0 && remove("job_objects.relievo") == 0);
    return 0;
}
