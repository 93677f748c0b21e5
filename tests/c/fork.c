/* Forks: a child refuses objects of before the fork, which would wait for threads that it does not have, may release
 * them, and works with a context of its own. The parent goes on. */
#define _POSIX_C_SOURCE 200809L
#include "check.h"

#include <pthread.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct Host {
    RlvContext context;
    RlvMesh plane;
    RlvSurface surface;
    RlvDetail detail;
    RlvCaster caster;
} Host;

static Host begin(void) {
    Host host;
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    options.threads = 2;
    CHECK_OK(rlv_context_create(&options, &host.context));
    host.plane = check_plane(host.context, 12, 12);
    CHECK_OK(rlv_surface_create(host.context, host.plane, NULL, &host.surface));
    CHECK_OK(rlv_detail_create(host.surface, NULL, NULL, &host.detail));
    CHECK_OK(rlv_caster_create_mesh(host.context, host.plane, &host.caster));
    return host;
}

/* Works on the threads of the context, and casts a ray. */
static void work(const Host *host) {
    static const float origin[3] = {3.25f, 2.5f, 2}, direction[3] = {0, 0, -1};
    RlvMesh mesh = RLV_NULL;
    CHECK_OK(rlv_tessellate_detail(host->detail, NULL, &mesh));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_NEAR(check_cast(host->caster, origin, direction).distance, 2, 1e-5);
}

static void end(const Host *host) {
    CHECK_OK(rlv_caster_release(host->caster));
    CHECK_OK(rlv_detail_release(host->detail));
    CHECK_OK(rlv_surface_release(host->surface));
    CHECK_OK(rlv_mesh_release(host->plane));
    CHECK_OK(rlv_context_release(host->context));
}

static int child(const Host *old) {
    RlvMesh mesh = RLV_NULL;
    RlvRayArrays rays = RLV_RAY_ARRAYS_INIT;
    RlvJob job = RLV_NULL;
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_tessellate_detail(old->detail, NULL, &mesh), "forked");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_caster_cast(old->caster, &rays), "forked");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_job_tessellate(old->detail, NULL, &job), "forked");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_surface_create(old->context, old->plane, NULL, (RlvSurface *)&mesh), "context");
    const Host own = begin();
    work(&own);
    end(&own);
    end(old);
    return 0;
}

/* Makes and releases objects until it is told to stop, so that forks fall into its calls. */
static int stopped;
static void *make_objects(void *context) {
    while (!__atomic_load_n(&stopped, __ATOMIC_RELAXED)) {
        CHECK_OK(rlv_mesh_release(check_plane(*(RlvContext *)context, 1, 1)));
    }
    return NULL;
}

int main(void) {
    Host host = begin();
    pthread_t maker;
    work(&host);
    CHECK(pthread_create(&maker, NULL, make_objects, &host.context) == 0);
    for (int round = 0; round < 20; ++round) {
        const pid_t id = fork();
        int status = 0;
        CHECK(id >= 0);
        if (id == 0) {
            /* A call that hangs ends the child. */
            alarm(30);
            _exit(child(&host));
        }
        CHECK(waitpid(id, &status, 0) == id && WIFEXITED(status) && WEXITSTATUS(status) == 0);
    }
    __atomic_store_n(&stopped, 1, __ATOMIC_RELAXED);
    CHECK(pthread_join(maker, NULL) == 0);
    work(&host);
    end(&host);
    return 0;
}
