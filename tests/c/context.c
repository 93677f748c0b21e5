/* Contexts: options, information, references, log, statistics. */
#include "check.h"

static void remember(void *user, uint32_t level, const char *text) {
    char *last = user;
    CHECK(level == RLV_LOG_INFO || level == RLV_LOG_WARNING);
    strncpy(last, text, 199);
}

/* Three quads that share the edge between points 0 and 1. */
static RlvMesh book(RlvContext context) {
    static const float points[] = {0, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, -1, 0, 0, -1, 0, 1};
    static const uint32_t corners[] = {0, 2, 3, 1, 0, 4, 5, 1, 0, 6, 7, 1};
    return check_mesh_of(context, points, 8, 4, 3, corners);
}

#ifdef __linux__
#include <dirent.h>

/* Counts the threads of this process. */
static int threads(void) {
    DIR *tasks = opendir("/proc/self/task");
    CHECK(tasks != NULL);
    int count = 0;
    for (const struct dirent *task = readdir(tasks); task != NULL; task = readdir(tasks)) {
        count += task->d_name[0] != '.';
    }
    closedir(tasks);
    return count;
}

/* Contexts start their threads when they first work. */
static void check_start(void) {
    enum { COUNT = 1000 };
    static RlvContext contexts[COUNT];
    int before = threads();
    for (int at = 0; at < COUNT; at++) {
        CHECK_OK(rlv_context_create(NULL, &contexts[at]));
    }
    CHECK(threads() == before);
    for (int at = 0; at < COUNT; at++) {
        CHECK_OK(rlv_context_release(contexts[at]));
    }
}
#else
static void check_start(void) {}
#endif

int main(void) {
    check_start();
    RlvContext context = RLV_NULL;
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvContextInfo info = RLV_CONTEXT_INFO_INIT;

    options.threads = 2;
    options.memory_limit = 1 << 20;
    CHECK_OK(rlv_context_create(&options, &context));
    CHECK_OK(rlv_context_info(context, &info));
    CHECK(info.threads == 2 && info.device == RLV_DEVICE_CPU && info.memory_limit == 1 << 20);
    CHECK(info.adapter[0] == 0 && info.fallback[0] == 0 && info.device_memory == 0);
    CHECK_OK(rlv_context_close_device(context));
    CHECK(strcmp(info.simd, "baseline") == 0 || strcmp(info.simd, "avx2") == 0 || strcmp(info.simd, "avx512") == 0 ||
          strcmp(info.simd, "neon") == 0);

    /* References. */
    CHECK_OK(rlv_context_retain(context));
    CHECK_OK(rlv_context_release(context));
    CHECK_OK(rlv_context_info(context, &info));
    CHECK_OK(rlv_context_release(context));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_context_info(context, &info), "not alive");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_context_release(context), "not alive");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_context_retain(context), "not alive");

    /* Options that cannot be had leave the output alone. */
    RlvContext untouched = {77};
    options.device = 9;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_context_create(&options, &untouched), "device");
    options.device = RLV_DEVICE_CPU;
    options.threads = 1u << 30;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_context_create(&options, &untouched), "threads");
    CHECK(untouched.id == 77);

    /* A program with newer headers: fields this library lacks must be zero. */
    struct {
        RlvContextOptions known;
        uint32_t future[2];
    } newer = {RLV_CONTEXT_OPTIONS_INIT, {0, 0}};
    newer.known.struct_size = sizeof(newer);
    CHECK_OK(rlv_context_create(&newer.known, &context));
    CHECK_OK(rlv_context_release(context));
    newer.future[1] = 1;
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_context_create(&newer.known, &untouched), "RlvContextOptions");

    /* The log is silent until it is set, and an accepted non-manifold cage is worth a line. */
    char last[200] = "";
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh mesh = book(context);
    RlvSurface surface = RLV_NULL;
    CHECK_OK(rlv_surface_create(context, mesh, NULL, &surface));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_context_set_log(context, remember, last));
    CHECK_OK(rlv_surface_create(context, mesh, NULL, &surface));
    CHECK(strstr(last, "not manifold") != NULL);
    RlvSurfaceInfo surface_info = RLV_SURFACE_INFO_INIT;
    CHECK_OK(rlv_surface_info(surface, &surface_info));
    CHECK(surface_info.non_manifold == 1);
    CHECK_OK(rlv_context_set_log(context, NULL, NULL));

    /* Statistics: the surface was refined twice. */
    size_t count = 0, again = 0;
    CHECK_OK(rlv_context_stats(context, NULL, 0, &count));
    CHECK(count > 0);
    RlvContextStat *stats = calloc(count, sizeof(RlvContextStat));
    CHECK(stats != NULL);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_context_stats(context, stats, count - 1, &again), "room for");
    CHECK(again == count && stats[0].stage[0] == 0); /* the count is written, rows are not */
    CHECK_OK(rlv_context_stats(context, stats, count, &again));
    CHECK(again == count);
    int found = 0;
    for (size_t row = 0; row < count; ++row) {
        if (strcmp(stats[row].stage, "surface.refine") == 0 && strcmp(stats[row].quantity, "seconds") == 0) {
            found = stats[row].samples == 2 && stats[row].total > 0.0;
        }
    }
    CHECK(found);
    free(stats);
    CHECK_OK(rlv_context_reset_stats(context));
    CHECK_OK(rlv_context_stats(context, NULL, 0, &count));
    CHECK(count == 0);

    /* Objects keep their context alive, whatever the order of release. */
    CHECK_OK(rlv_context_release(context));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_surface_info(surface, &surface_info));
    CHECK_OK(rlv_surface_release(surface));
    return 0;
}
