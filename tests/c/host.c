/* Threads of hosts: what computes on them makes the same bits as one thread, and the library starts none of its own, nor
 * where it is asked for one thread; contexts share threads; jobs run as tasks of the host, and say when they end. */
#include "ball.h"

#include <pthread.h>
#ifdef _WIN32
#include <windows.h>

#include <tlhelp32.h>
#else
#include <dirent.h>
#endif

enum { WORKERS = 2, SIDE = 4, PLACES = 4096 };

/* How many threads the process has. */
static int tasks(void) {
#ifdef _WIN32
    HANDLE snapshot = CreateToolhelp32Snapshot(TH32CS_SNAPTHREAD, 0);
    THREADENTRY32 entry = {.dwSize = sizeof entry};
    int count = 0;
    CHECK(snapshot != INVALID_HANDLE_VALUE);
    for (BOOL is_there = Thread32First(snapshot, &entry); is_there; is_there = Thread32Next(snapshot, &entry)) {
        count += entry.th32OwnerProcessID == GetCurrentProcessId();
    }
    CloseHandle(snapshot);
    return count;
#else
    DIR *folder = opendir("/proc/self/task");
    int count = 0;
    CHECK(folder != NULL);
    for (const struct dirent *entry = readdir(folder); entry != NULL; entry = readdir(folder)) {
        count += entry->d_name[0] != '.';
    }
    closedir(folder);
    return count;
#endif
}

/* A pool: workers take the indices of the loop under way; a loop within a loop stays on its thread. */
typedef struct Pool {
    pthread_mutex_t lock;
    pthread_cond_t changed;
    pthread_t workers[WORKERS];
    RlvLoopBody body;
    void *work;
    size_t next, count, running, loops, pieces, queued;
    int ends;
    RlvTask tasks[4];
    void *task_works[4];
} Pool;

static __thread int inside;

/* Takes indices until there are none; called and returns with the lock. */
static void take_all(Pool *pool) {
    while (pool->next < pool->count) {
        const size_t index = pool->next++;
        RlvLoopBody body = pool->body;
        void *work = pool->work;
        ++pool->running;
        pthread_mutex_unlock(&pool->lock);
        inside = 1;
        body(work, index);
        inside = 0;
        pthread_mutex_lock(&pool->lock);
        --pool->running;
        pthread_cond_broadcast(&pool->changed);
    }
}

static void *serve(void *user) {
    Pool *pool = user;
    pthread_mutex_lock(&pool->lock);
    while (!pool->ends) {
        take_all(pool);
        if (!pool->ends) {
            pthread_cond_wait(&pool->changed, &pool->lock);
        }
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

static void run_loop(void *user, size_t count, RlvLoopBody body, void *work) {
    Pool *pool = user;
    if (inside) {
        for (size_t index = 0; index < count; ++index) {
            body(work, index);
        }
        return;
    }
    pthread_mutex_lock(&pool->lock);
    CHECK(pool->running == 0);
    ++pool->loops;
    pool->pieces += count;
    pool->body = body;
    pool->work = work;
    pool->next = 0;
    pool->count = count;
    pthread_cond_broadcast(&pool->changed);
    take_all(pool);
    while (pool->running > 0) {
        pthread_cond_wait(&pool->changed, &pool->lock);
    }
    pthread_mutex_unlock(&pool->lock);
}

/* A loop that leaves out odd indices, does the others twice, and invents some. */
static void run_badly(void *user, size_t count, RlvLoopBody body, void *work) {
    (void)user;
    for (size_t index = 0; index < count + 2; index += 2) {
        body(work, index);
        body(work, index);
    }
    body(work, SIZE_MAX);
}

/* Tasks wait until the host runs them. */
static void spawn(void *user, RlvTask task, void *work) {
    Pool *pool = user;
    CHECK(pool->queued < 4);
    pool->tasks[pool->queued] = task;
    pool->task_works[pool->queued++] = work;
}

static void note(void *user) { ++*(int *)user; }

/* Sculpts, presses, casts and tessellates; the points of the result, whose count is returned. */
static size_t compute(RlvContext context, float *points) {
    const double from[12] = CHECK_MOVED(1.0, 1.0, 0.35), to[12] = CHECK_MOVED(3.0, 2.0, 0.35);
    RlvMesh plane = check_plane(context, SIDE, SIDE), ball = check_ball_of(context, 0.4, 16, 32), mesh = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvCollider collider = RLV_NULL;
    RlvCaster caster = RLV_NULL;
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    RlvTessellateOptions cells = RLV_TESSELLATE_OPTIONS_INIT;
    RlvDetailOptions small = RLV_DETAIL_OPTIONS_INIT;
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    settings.voxels = 1 << 15;
    small.tile_size = 16;
    cells.coarse = cells.fine = 8;
    settings.sub_steps = 4;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, &small, NULL, &detail));
    check_stroke(context, detail, RLV_BRUSH_SCULPT, 3.5, 3.0, 0.5f);
    CHECK_OK(rlv_collider_create_mesh(context, ball, from, &collider));
    CHECK_OK(rlv_imprint_sweep(detail, collider, from, to, &settings, NULL, NULL, NULL, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_tessellate_detail(detail, &cells, &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK(info.point_count <= PLACES);
    CHECK_OK(rlv_mesh_get_points(mesh, points, info.point_count, 0));
    CHECK_OK(rlv_caster_create_mesh(context, mesh, &caster));
    CHECK_OK(rlv_caster_release(caster));
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_mesh_release(plane));
    return info.point_count;
}

/* A job that tessellates a plane. */
static RlvJob tessellation(RlvContext context) {
    RlvMesh plane = check_plane(context, 2, 2);
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvJob job = RLV_NULL;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    CHECK_OK(rlv_job_tessellate(detail, NULL, &job));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    return job;
}

int main(void) {
    static float expected[3 * PLACES], points[3 * PLACES];
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvContextInfo info = RLV_CONTEXT_INFO_INIT;
    RlvContext context = RLV_NULL, shared = RLV_NULL;
    const int before = tasks();

    /* One thread is the calling one: Embree, TBB and OpenSubdiv start none. */
    options.threads = 1;
    CHECK_OK(rlv_context_create(&options, &context));
    const size_t count = compute(context, expected);
    CHECK(count > 50);
    CHECK(tasks() == before);
    CHECK_OK(rlv_context_release(context));

    /* The host's loop makes the same bits on the host's threads. */
    static Pool pool = {PTHREAD_MUTEX_INITIALIZER, PTHREAD_COND_INITIALIZER, {0}, NULL, NULL, 0, 0, 0, 0, 0, 0, 0, {0}, {0}};
    for (int k = 0; k < WORKERS; ++k) {
        CHECK(pthread_create(&pool.workers[k], NULL, serve, &pool) == 0);
    }
    options.threads = WORKERS + 1;
    options.host_loop = run_loop;
    options.host_spawn = spawn;
    options.host_user = &pool;
    CHECK_OK(rlv_context_create(&options, &context));
    CHECK_OK(rlv_context_info(context, &info));
    CHECK(info.threads == WORKERS + 1);
    CHECK(compute(context, points) == count && memcmp(points, expected, 12 * count) == 0);
    CHECK(pool.loops > 20 && pool.pieces > 4 * pool.loops);
    CHECK(tasks() == before + WORKERS);

    /* Jobs wait until the host runs them, and say when they end. */
    int ended = 0, late = 0;
    RlvJobInfo state = RLV_JOB_INFO_INIT;
    RlvMesh mesh = RLV_NULL;
    RlvJob job = tessellation(context), dropped = tessellation(context);
    CHECK(pool.queued == 2 && tasks() == before + WORKERS);
    CHECK_OK(rlv_job_wait(job, 0.001, &state));
    CHECK(state.state == RLV_JOB_RUNNING);
    CHECK_OK(rlv_job_notify(job, note, &ended));
    CHECK_OK(rlv_job_release(dropped));
    for (size_t k = 0; k < pool.queued; ++k) {
        pool.tasks[k](pool.task_works[k]);
    }
    CHECK(ended == 1);
    CHECK_OK(rlv_job_wait(job, -1.0, &state));
    CHECK(state.state == RLV_JOB_DONE);
    CHECK_OK(rlv_job_notify(job, note, &late));
    CHECK(ended == 1 && late == 1);
    CHECK_OK(rlv_job_mesh(job, &mesh));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_job_release(job));

    /* Another context works on the host's threads too. */
    RlvContextOptions sharing = RLV_CONTEXT_OPTIONS_INIT;
    sharing.shared = context;
    CHECK_OK(rlv_context_create(&sharing, &shared));
    CHECK_OK(rlv_context_release(context));
    const size_t loops = pool.loops;
    CHECK(compute(shared, points) == count && memcmp(points, expected, 12 * count) == 0);
    CHECK(pool.loops > loops + 20);
    CHECK_OK(rlv_context_release(shared));
    pthread_mutex_lock(&pool.lock);
    pool.ends = 1;
    pthread_cond_broadcast(&pool.changed);
    pthread_mutex_unlock(&pool.lock);
    for (int k = 0; k < WORKERS; ++k) {
        CHECK(pthread_join(pool.workers[k], NULL) == 0);
    }

    /* A loop that does not keep its word costs time and nothing else. */
    options.host_loop = run_badly;
    options.host_spawn = NULL;
    CHECK_OK(rlv_context_create(&options, &context));
    CHECK(compute(context, points) == count && memcmp(points, expected, 12 * count) == 0);
    CHECK_OK(rlv_context_release(context));

    /* A thousand contexts share two threads. */
    static RlvContext many[1000];
    RlvContextOptions two = RLV_CONTEXT_OPTIONS_INIT;
    two.threads = 2;
    CHECK_OK(rlv_context_create(&two, &context));
    sharing.shared = context;
    for (int k = 0; k < 1000; ++k) {
        CHECK_OK(rlv_context_create(&sharing, &many[k]));
    }
    CHECK(tasks() <= before + 2);
    CHECK(compute(many[999], points) == count && memcmp(points, expected, 12 * count) == 0);
    for (int k = 0; k < 1000; ++k) {
        CHECK_OK(rlv_context_release(many[k]));
    }

    /* What does not go together. */
    sharing.threads = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_context_create(&sharing, &shared), "shared");
    sharing.threads = 0;
    sharing.host_loop = run_badly;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_context_create(&sharing, &shared), "shared");
    CHECK_OK(rlv_context_release(context));
    sharing.host_loop = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_context_create(&sharing, &shared), "not alive");
    return 0;
}
