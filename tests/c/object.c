/* Objects: a call that is refused says which function is at work, and whoever would rather wait for it can. */
#include "ball.h"

#include <pthread.h>

static RlvDetail detail;
static RlvCollider collider;
static int asked;

/* In the middle of a call on the detail: another is refused and names it, and it is busy. */
static uint32_t refuse(void *user, float fraction, const char *stage) {
    RlvObjectInfo info = RLV_OBJECT_INFO_INIT;
    (void)user, (void)fraction, (void)stage;
    CHECK_FAILS(RLV_ERROR_BUSY, rlv_detail_commit(detail, NULL), "`rlv_imprint_sweep`");
    CHECK_OK(rlv_object_wait(detail.id, 0.0, &info));
    CHECK(info.is_busy == 1 && strcmp(info.noun, "detail") == 0 && strcmp(info.worker, "rlv_imprint_sweep") == 0);
    CHECK_OK(rlv_object_wait(collider.id, 0.001, &info));
    CHECK(info.is_busy == 1 && strcmp(info.noun, "collider") == 0 && strcmp(info.worker, "rlv_imprint_sweep") == 0);
    ++asked;
    return RLV_PROGRESS_CONTINUE;
}

/* Waits for the detail on a thread of its own, then commits. */
static void *wait_and_commit(void *unused) {
    RlvObjectInfo info = RLV_OBJECT_INFO_INIT;
    (void)unused;
    CHECK_OK(rlv_object_wait(detail.id, -1.0, &info));
    CHECK(info.is_busy == 0 && info.worker[0] == 0 && strcmp(info.noun, "detail") == 0);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    return NULL;
}

/* One object of each noun that takes neither a device, files nor a server; tests of the others call check_idle too. */
static void every_noun(RlvContext context, RlvSurface surface, RlvMesh plane, RlvMesh ball) {
    RlvCaster caster = RLV_NULL;
    RlvTessellation tessellation = RLV_NULL;
    RlvBrush brush = RLV_NULL;
    RlvBrushOptions sculpting = RLV_BRUSH_OPTIONS_INIT;
    RlvStroke stroke = RLV_NULL;
    RlvDocument document = RLV_NULL;
    RlvProcedural procedural = RLV_NULL;
    RlvJob job = RLV_NULL;
    RlvBezier bezier = RLV_NULL;
    RlvBezierArrays patch = RLV_BEZIER_ARRAYS_INIT;
    RlvProgressive progressive = RLV_NULL;
    RlvLevel level = RLV_NULL;
    RlvArrival arrival = RLV_NULL;
    RlvIsosurface isosurface = RLV_NULL;
    RlvIsosurfaceParticles fluid_of = RLV_ISOSURFACE_PARTICLES_INIT;
    RlvFluid fluid = RLV_NULL;
    RlvParticles particles = RLV_NULL;
    RlvParticlesArrays arrays = RLV_PARTICLES_ARRAYS_INIT;
    RlvDiffuse diffuse = RLV_NULL;
    RlvBytes bytes = RLV_NULL;
    RlvSubdivision subdivision = RLV_NULL;
    RlvPicture picture = RLV_NULL;
    float points[16][3];
    for (int k = 0; k < 16; ++k) {
        points[k][0] = 0.02f * (float)(k % 4), points[k][1] = 0.02f * (float)(k / 4), points[k][2] = 0.0f;
    }
    patch.points = fluid_of.points = arrays.points = points[0];
    patch.point_count = fluid_of.count = arrays.count = 16;
    arrays.spacing = 0.02f;
    sculpting.action = RLV_BRUSH_SCULPT;
    CHECK_OK(rlv_caster_create_mesh(context, ball, &caster));
    CHECK_OK(rlv_tessellation_create(detail, NULL, &tessellation));
    CHECK_OK(rlv_brush_create(context, &sculpting, NULL, &brush));
    CHECK_OK(rlv_document_create(detail, "object.relievo", 0, &document));
    CHECK_OK(rlv_document_begin(document, "a stroke"));
    CHECK_OK(rlv_stroke_begin(detail, brush, &stroke));
    CHECK_OK(rlv_picture_open(context, "object.relievo", &picture));
    CHECK_OK(rlv_procedural_create(detail, NULL, &procedural));
    CHECK_OK(rlv_job_tessellate(detail, NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_bezier_create(context, &patch, &bezier));
    CHECK_OK(rlv_progressive_create(ball, NULL, NULL, NULL, &progressive));
    CHECK_OK(rlv_level_create(progressive, &level));
    CHECK_OK(rlv_arrival_create(context, &arrival));
    CHECK_OK(rlv_isosurface_create(context, &fluid_of, NULL, &isosurface));
    CHECK_OK(rlv_fluid_create(context, NULL, &fluid));
    CHECK_OK(rlv_particles_create(context, &arrays, &particles));
    CHECK_OK(rlv_diffuse_create(context, NULL, NULL, &diffuse));
    CHECK_OK(rlv_mesh_write_bytes(plane, "obj", &bytes));
    CHECK_OK(rlv_subdivision_create(context, plane, NULL, &subdivision));
    const struct {
        uint64_t id;
        const char *noun;
    } alive[] = {
        {context.id, "context"},         {plane.id, "mesh"},               {surface.id, "surface"},
        {detail.id, "detail"},           {collider.id, "collider"},        {caster.id, "caster"},
        {tessellation.id, "tessellation"}, {brush.id, "brush"},            {stroke.id, "stroke"},
        {document.id, "document"},       {picture.id, "picture"},          {procedural.id, "procedural"},
        {job.id, "job"},                 {bezier.id, "bezier"},            {progressive.id, "progressive mesh"},
        {level.id, "level"},             {arrival.id, "arrival"},          {isosurface.id, "isosurface"},
        {fluid.id, "fluid"},             {particles.id, "particles"},      {diffuse.id, "diffuse"},
        {bytes.id, "bytes"},             {subdivision.id, "subdivision"},
    };
    for (size_t k = 0; k < sizeof alive / sizeof *alive; ++k) {
        check_idle(alive[k].id, alive[k].noun);
    }
    CHECK_OK(rlv_stroke_release(stroke));
    CHECK_OK(rlv_document_abandon(document));
    CHECK_OK(rlv_subdivision_release(subdivision));
    CHECK_OK(rlv_bytes_release(bytes));
    CHECK_OK(rlv_diffuse_release(diffuse));
    CHECK_OK(rlv_particles_release(particles));
    CHECK_OK(rlv_fluid_release(fluid));
    CHECK_OK(rlv_isosurface_release(isosurface));
    CHECK_OK(rlv_arrival_release(arrival));
    CHECK_OK(rlv_level_release(level));
    CHECK_OK(rlv_progressive_release(progressive));
    CHECK_OK(rlv_bezier_release(bezier));
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_procedural_release(procedural));
    CHECK_OK(rlv_picture_release(picture));
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_brush_release(brush));
    CHECK_OK(rlv_tessellation_release(tessellation));
    CHECK_OK(rlv_caster_release(caster));
    remove("object.relievo");
}

int main(void) {
    const double from[12] = CHECK_MOVED(1.0, 1.0, 0.35), to[12] = CHECK_MOVED(3.0, 1.0, 0.35);
    RlvContext context = RLV_NULL;
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvSurface surface = RLV_NULL;
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    RlvObjectInfo info = RLV_OBJECT_INFO_INIT;
    options.threads = 2;
    CHECK_OK(rlv_context_create(&options, &context));
    RlvMesh plane = check_plane(context, 4, 2), ball = check_ball_of(context, 0.4, 16, 32);
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    CHECK_OK(rlv_collider_create_mesh(context, ball, from, &collider));
    settings.voxels = 1 << 15;
    settings.sub_steps = 4;
    CHECK_OK(rlv_imprint_sweep(detail, collider, from, to, &settings, NULL, refuse, NULL, NULL));
    CHECK(asked >= 2);
    CHECK_OK(rlv_object_wait(detail.id, 0.0, &info));
    CHECK(info.is_busy == 0 && info.worker[0] == 0);

    /* A job is named by the function that started it; waiting ends when it does, and then the detail is free. */
    RlvJob job = RLV_NULL;
    RlvJobInfo state = RLV_JOB_INFO_INIT;
    pthread_t waiter;
    CHECK_OK(rlv_job_sweep(detail, collider, to, from, &settings, NULL, &job));
    CHECK_OK(rlv_object_wait(detail.id, 0.0, &info));
    CHECK(info.is_busy == 0 || strcmp(info.worker, "rlv_job_sweep") == 0);
    CHECK(pthread_create(&waiter, NULL, wait_and_commit, NULL) == 0);
    CHECK(pthread_join(waiter, NULL) == 0);
    CHECK_OK(rlv_job_wait(job, -1.0, &state));
    CHECK(state.state == RLV_JOB_DONE);
    CHECK_OK(rlv_job_release(job));

    /* What cannot be waited for. */
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_object_wait(detail.id, -2.0, &info), "seconds");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_object_wait(detail.id, NAN, &info), "seconds");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_object_wait(0, 0.0, &info), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_object_wait(detail.id + 1000, 0.0, &info), "not alive");
    CHECK_OK(rlv_object_wait(detail.id, 1e300, NULL));
    every_noun(context, surface, plane, ball);
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_object_wait(detail.id, 0.0, &info), "not alive");
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
