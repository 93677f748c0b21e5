/* Jobs: what runs in the background gives what the call gives, can be watched, waited for and cancelled, and has to itself
 * what the call has to itself; garbage is refused at the start. */
#include "ball.h"

static int logged;

static void hear(void *user, uint32_t level, const char *text) {
    (void)user;
    (void)level;
    logged += strstr(text, "refused") != NULL;
}

typedef struct Scene {
    RlvDetail detail;
    RlvCollider ball;
} Scene;

static const double FROM[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0.8, 2.0, 0.3};
static const double TO[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 3.2, 2.0, 0.3};

static Scene make(RlvContext context, uint64_t budget) {
    Scene scene;
    RlvMesh plane = check_plane(context, 4, 4), ball = check_ball(context, 0.4f);
    RlvSurface surface = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    options.tile_size = 32;
    options.budget = budget;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &scene.detail));
    CHECK_OK(rlv_collider_create_mesh(context, ball, FROM, &scene.ball));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_mesh_release(ball));
    return scene;
}

static void release(Scene scene) {
    CHECK_OK(rlv_detail_release(scene.detail));
    CHECK_OK(rlv_collider_release(scene.ball));
}

static float deepest(RlvDetail detail) {
    RlvMesh mesh = RLV_NULL;
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_tessellate_detail(detail, NULL, &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK_OK(rlv_mesh_release(mesh));
    return info.low[2];
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvJob job = RLV_NULL, untouched = {77};
    RlvJobInfo info = RLV_JOB_INFO_INIT;
    RlvImprintReport report = RLV_IMPRINT_REPORT_INIT, expected = RLV_IMPRINT_REPORT_INIT;
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    RlvBakeReport bake = RLV_BAKE_REPORT_INIT;
    RlvMesh mesh = RLV_NULL, again = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    CHECK_OK(rlv_context_set_log(context, hear, NULL));

    /* A sweep in the background is the sweep. */
    Scene one = make(context, 0), other = make(context, 0);
    CHECK_OK(rlv_imprint_sweep(one.detail, one.ball, FROM, TO, NULL, NULL, NULL, NULL, &expected));
    CHECK_OK(rlv_job_sweep(other.detail, other.ball, FROM, TO, NULL, NULL, &job));
    /* Whoever comes meanwhile is told so, or finds it done. */
    RlvResult result = rlv_detail_set_budget(other.detail, 1 << 30);
    CHECK(result == RLV_OK || result == RLV_ERROR_BUSY);
    CHECK_OK(rlv_job_poll(job, &info));
    CHECK(info.state == RLV_JOB_RUNNING || info.state == RLV_JOB_DONE);
    CHECK_OK(rlv_job_wait(job, -1.0, &info));
    CHECK(info.state == RLV_JOB_DONE && info.result == RLV_OK && info.fraction == 1.0f);
    CHECK(strcmp(info.stage, "imprint") == 0);
    CHECK_OK(rlv_job_result(job));
    CHECK_OK(rlv_job_imprint_report(job, &report));
    CHECK(report.steps == expected.steps && report.steps > 10);
    CHECK(report.changed_coefficients == expected.changed_coefficients && report.bytes == expected.bytes);
    CHECK(deepest(other.detail) == deepest(one.detail) && deepest(one.detail) < -0.05f);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_mesh(job, &mesh), "was not started for triangles");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_bake_report(job, &bake), "was not started for a bake");
    CHECK_OK(rlv_job_cancel(job)); /* too late */
    CHECK_OK(rlv_job_result(job));
    CHECK_OK(rlv_job_retain(job));
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_job_poll(job, NULL));
    CHECK_OK(rlv_job_release(job));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_poll(job, &info), "not alive");

    /* Cancelled, it leaves all as it was; while it runs both are its own. It may be done before we come, so it is asked for
     * many steps. */
    Scene third = make(context, 0);
    const double far[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 400.0, 2.0, 0.3};
    settings.sub_steps = 4096;
    CHECK_OK(rlv_job_sweep(third.detail, third.ball, FROM, far, &settings, NULL, &job));
    CHECK_FAILS(RLV_ERROR_BUSY, rlv_job_sweep(third.detail, third.ball, FROM, TO, NULL, NULL, &untouched), "at work");
    CHECK_FAILS(RLV_ERROR_BUSY, rlv_detail_commit(third.detail, NULL), "detail");
    CHECK_FAILS(RLV_ERROR_BUSY, rlv_job_result(job), "rlv_job_wait");
    CHECK_OK(rlv_job_wait(job, 0.0, &info));
    CHECK(info.state == RLV_JOB_RUNNING && info.result == RLV_OK);
    CHECK_OK(rlv_job_cancel(job));
    CHECK_OK(rlv_job_wait(job, 60.0, &info));
    CHECK(info.state == RLV_JOB_CANCELLED && info.result == RLV_ERROR_CANCELLED && info.fraction < 1.0f);
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_job_result(job), "cancelled");
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_job_imprint_report(job, &report), "cancelled");
    CHECK(deepest(third.detail) == 0.0f);
    CHECK_OK(rlv_job_release(job));
    /* Released while it runs, it stops by itself, and what it had is free again. */
    CHECK_OK(rlv_job_sweep(third.detail, third.ball, FROM, far, &settings, NULL, &job));
    CHECK_OK(rlv_job_release(job));
    do {
        result = rlv_detail_commit(third.detail, NULL);
        CHECK(result == RLV_OK || result == RLV_ERROR_BUSY);
    } while (result == RLV_ERROR_BUSY);
    CHECK(deepest(third.detail) == 0.0f);
    release(third);

    /* What it logs comes when the host asks. */
    Scene poor = make(context, 10);
    CHECK(logged == 0);
    CHECK_OK(rlv_job_sweep(poor.detail, poor.ball, FROM, TO, NULL, NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK(logged == 1);
    CHECK_OK(rlv_job_poll(job, &info));
    CHECK(logged == 1 && info.state == RLV_JOB_DONE);
    CHECK_OK(rlv_job_release(job));
    release(poor);

    /* Triangles: the same mesh every time, which outlives the job. */
    RlvMeshInfo made = RLV_MESH_INFO_INIT, wanted = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_job_tessellate(one.detail, NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_mesh(job, &mesh));
    CHECK_OK(rlv_job_mesh(job, &again));
    CHECK(mesh.id == again.id);
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_mesh_release(again));
    CHECK_OK(rlv_mesh_info(mesh, &made));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_info(mesh, &made), "not alive");
    CHECK_OK(rlv_tessellate_detail(one.detail, NULL, &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &wanted));
    CHECK(made.triangle_count == wanted.triangle_count && made.low[2] == wanted.low[2] && made.triangle_count > 512);
    CHECK_OK(rlv_mesh_release(mesh));
    /* Whose mesh nobody fetched. */
    CHECK_OK(rlv_job_tessellate(one.detail, NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_release(job));

    /* Cancelled while it works, it ends as cancelled and has no mesh. One that has ended before is started again. */
    RlvTessellateOptions many = RLV_TESSELLATE_OPTIONS_INIT;
    many.coarse = many.fine = 64;
    int is_cancelled = 0;
    for (int attempt = 0; attempt < 10 && !is_cancelled; ++attempt) {
        CHECK_OK(rlv_job_tessellate(one.detail, &many, &job));
        CHECK_OK(rlv_job_cancel(job));
        CHECK_OK(rlv_job_wait(job, -1.0, &info));
        is_cancelled = info.state == RLV_JOB_CANCELLED && info.result == RLV_ERROR_CANCELLED;
        if (is_cancelled) {
            CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_job_mesh(job, &mesh), "cancel");
        }
        CHECK_OK(rlv_job_release(job));
    }
    CHECK(is_cancelled);

    /* Points that stay as they are in their own space: the sweep again. */
    Scene points = make(context, 0);
    RlvMesh ball = check_ball(context, 0.4f);
    float *at;
    CHECK_OK(rlv_mesh_info(ball, &made));
    at = malloc(made.point_count * 3 * sizeof *at);
    CHECK(at != NULL);
    CHECK_OK(rlv_mesh_get_points(ball, at, made.point_count, 0));
    CHECK_OK(rlv_job_sweep_points(points.detail, points.ball, FROM, TO, at, at, made.point_count, 0, NULL, NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_imprint_report(job, &report));
    CHECK(report.changed_coefficients == expected.changed_coefficients);
    CHECK_OK(rlv_job_release(job));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_sweep_points(points.detail, points.ball, FROM, TO, at, NULL, made.point_count, 0, NULL, NULL, &untouched),
                "to_points");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_sweep_points(points.detail, points.ball, FROM, TO, at, at, made.point_count - 1, 0, NULL, NULL, &untouched),
                "points");
    free(at);

    /* To Ptex and back. */
    RlvPtexReport faces = RLV_PTEX_REPORT_INIT;
    Scene copy = make(context, 0);
    CHECK_OK(rlv_detail_commit(points.detail, NULL));
    CHECK_OK(rlv_job_ptex_write(points.detail, RLV_CHANNEL_DISPLACEMENT, "job.ptx", &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_result(job));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_ptex_report(job, &faces), "was not started for reading Ptex");
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_job_ptex_read(copy.detail, "job.ptx", NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_ptex_report(job, &faces));
    CHECK(faces.face_count == 16 && faces.channel == RLV_CHANNEL_DISPLACEMENT);
    CHECK_OK(rlv_job_release(job));
    CHECK(fabsf(deepest(copy.detail) - deepest(points.detail)) < 0.01f);
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_job_ptex_write(points.detail, RLV_CHANNEL_TRACES, "job.ptx", &untouched), "traces");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_ptex_write(points.detail, 99, "job.ptx", &untouched), "channel");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_job_ptex_read(points.detail, "nowhere.ptx", NULL, &untouched), "nowhere.ptx");
    CHECK(remove("job.ptx") == 0);
    release(copy);

    /* A document to the mesh it was made on. */
    RlvDocument document = RLV_NULL;
    RlvTransferReport moved = RLV_TRANSFER_REPORT_INIT;
    RlvMesh plane = check_plane(context, 4, 4);
    CHECK_OK(rlv_document_create(points.detail, "job.relievo", 0, &document));
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_job_transfer(context, plane, "job.relievo", "job_to.relievo", NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_transfer_report(job, &moved));
    CHECK(moved.layer_count == 1 && moved.uncovered_area == 0.0 && moved.area > 0.0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_ptex_report(job, &faces), "was not started for");
    CHECK_OK(rlv_job_release(job));
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_job_transfer(context, plane, "nowhere.relievo", "job_to.relievo", NULL, &untouched), "nowhere");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_transfer(context, plane, "job.relievo", NULL, NULL, &untouched), "to_path");
    CHECK(remove("job.relievo") == 0 && remove("job_to.relievo") == 0);
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_mesh_release(ball));
    release(points);

    /* A bake that fails: the plane has no texture coordinates. */
    result = rlv_job_bake(one.detail, NULL, "job.exr", &job);
    if (result == RLV_OK) {
        CHECK_OK(rlv_job_wait(job, -1.0, &info));
        CHECK(info.state == RLV_JOB_FAILED && info.result == RLV_ERROR_INVALID);
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_result(job), "uv");
        CHECK_OK(rlv_job_release(job));
    } else {
        CHECK(result == RLV_ERROR_INVALID && strstr(rlv_error_last(), "uv") != NULL);
    }

    /* Garbage. */
    double bent[12] = {0};
    RlvTessellateOptions odd = RLV_TESSELLATE_OPTIONS_INIT;
    odd.coarse = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_tessellate(one.detail, &odd, &untouched), "coarse");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_tessellate(one.detail, NULL, NULL), "out");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_sweep(one.detail, one.ball, bent, TO, NULL, NULL, &untouched), "rlv_job_sweep");
    settings.share = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_sweep(one.detail, one.ball, FROM, TO, &settings, NULL, &untouched), "share");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_sweep((RlvDetail){one.ball.id}, one.ball, FROM, TO, NULL, NULL, &untouched),
                "detail");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_bake(one.detail, NULL, NULL, &untouched), "path");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_poll(untouched, &info), "job");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_result((RlvJob){0}), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_cancel((RlvJob){one.detail.id}), "of a detail");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_release((RlvJob){0}), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_retain((RlvJob){0}), "NULL");
    CHECK(untouched.id == 77);
    CHECK_OK(rlv_job_tessellate(one.detail, NULL, &job));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_wait(job, NAN, &info), "seconds");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_wait(job, -2.0, &info), "seconds");
    info.struct_size = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_wait(job, 0.0, &info), "struct_size");
    CHECK_OK(rlv_job_wait(job, 1e300, NULL));
    CHECK_OK(rlv_job_release(job));
    release(one);
    release(other);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
