/* host before|after LIBRARY OTHER: a host that opens OTHER, such as an OpenVDB or a TBB of its own, for all names, before or
 * after the library opens its module over OpenVDB. Grids come out the same, no thread is left behind, the module is not there
 * before the first call that needs it, and none of its names is found by the host. */
#include <relievo/relievo.h>

#include <dirent.h>
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void *library;

static void fail(const char *what, const char *why) {
    fprintf(stderr, "%s: %s\n", what, why);
    exit(1);
}

static void *find(const char *name) {
    void *const found = dlsym(library, name);
    if (!found) {
        fail(name, "the library does not have it");
    }
    return found;
}

/* Calls a function of the library, which must succeed. */
#define CALL(function, ...)                                          \
    do {                                                             \
        RlvResult (*call)() = NULL;                                  \
        *(void **)&call = find(#function);                           \
        if (call(__VA_ARGS__) != RLV_OK) {                           \
            const char *(*last)(void) = NULL;                        \
            *(void **)&last = find("rlv_error_last");                \
            fail(#function, last());                                 \
        }                                                            \
    } while (0)

static int threads(void) {
    int count = 0;
    DIR *const folder = opendir("/proc/self/task");
    if (!folder) {
        fail("/proc/self/task", "cannot be read");
    }
    for (struct dirent *entry = readdir(folder); entry; entry = readdir(folder)) {
        count += entry->d_name[0] != '.';
    }
    closedir(folder);
    return count;
}

/* Whether a library is in the process. */
static int is_loaded(const char *name) {
    char line[4096];
    int found = 0;
    FILE *const maps = fopen("/proc/self/maps", "r");
    if (!maps) {
        fail("/proc/self/maps", "cannot be read");
    }
    while (fgets(line, sizeof line, maps)) {
        found |= strstr(line, name) != NULL;
    }
    fclose(maps);
    return found;
}

static void open_other(const char *path) {
    if (!dlopen(path, RTLD_NOW | RTLD_GLOBAL)) {
        fail(path, dlerror());
    }
}

int main(int argc, char **argv) {
    static const float points[24] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
    static const uint32_t corners[24] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6};
    const double place[3] = {0.5, 0.5, 1.1};
    double value = 0.0;
    if (argc != 4) {
        fail("usage", "host before|after LIBRARY OTHER");
    }
    library = dlopen(argv[2], RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        fail(argv[2], dlerror());
    }
    if (strcmp(argv[1], "before") == 0) {
        open_other(argv[3]);
    }
    const int before = threads();
    if (is_loaded("librelievo_openvdb")) {
        fail("librelievo_openvdb.so", "it is there before it is needed");
    }
    RlvContext context = RLV_NULL;
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvMesh box = RLV_NULL, made = RLV_NULL;
    RlvGrid grid = RLV_NULL;
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    options.threads = 1;
    arrays.points = points, arrays.point_count = 8, arrays.face_size = 4, arrays.face_count = 6;
    arrays.corners = corners, arrays.corner_count = 24;
    CALL(rlv_context_create, &options, &context);
    CALL(rlv_mesh_create, context, &arrays, &box);
    for (int round = 0; round < 2; ++round) {
        CALL(rlv_grid_from_mesh, box, (const RlvGridSettings *)NULL, (RlvProgress)NULL, (void *)NULL, &grid);
        CALL(rlv_grid_sample, grid, place, (size_t)1, (size_t)0, (uint32_t)1, &value, (size_t)1);
        if (fabs(value - 0.1) > 1e-5) {
            fail("rlv_grid_sample", "the distance to the box is wrong");
        }
        CALL(rlv_grid_mesh, grid, (const RlvGridSettings *)NULL, (RlvProgress)NULL, (void *)NULL, &made);
        CALL(rlv_mesh_release, made);
        CALL(rlv_grid_release, grid);
        if (!is_loaded("librelievo_openvdb")) {
            fail("librelievo_openvdb.so", "it is not there");
        }
        if (threads() != before) {
            fail("threads", "the module left some behind");
        }
        if (dlsym(RTLD_DEFAULT, "rlvdb_version")) {
            fail("rlvdb_version", "the host finds a name of the module");
        }
        if (round == 0 && strcmp(argv[1], "after") == 0) {
            open_other(argv[3]);
            /* An OpenVDB of the host brings threads of its own. */
            if (threads() != before) {
                break;
            }
        }
    }
    CALL(rlv_mesh_release, box);
    CALL(rlv_context_release, context);
    return 0;
}
