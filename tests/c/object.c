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
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_object_wait(detail.id, 0.0, &info), "not alive");
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
