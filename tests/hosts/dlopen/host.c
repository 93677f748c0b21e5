/* dlopen LIBRARY: a host that opens the library as it opens plugins, uses it on a thread of its own, and closes it
 * before that thread and the library's threads have ended; a hundred times. */
#define _POSIX_C_SOURCE 200809L
#include <relievo/relievo.h>

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

typedef uint32_t (*Version)(void);
typedef const char *(*LastError)(void);
typedef RlvResult (*Create)(const RlvContextOptions *, RlvContext *);
typedef RlvResult (*Release)(RlvContext);

static void *library;
static pthread_barrier_t used, closed;

/* The address of a function; ISO C has no cast from an object's to a function's. */
static void find(const char *name, void *function) {
    void *found = dlsym(library, name);
    memcpy(function, &found, sizeof(found));
}

static void *use(void *failed) {
    Create create;
    Release release;
    LastError last_error;
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvContext context = RLV_NULL;
    find("rlv_context_create", &create);
    find("rlv_context_release", &release);
    find("rlv_error_last", &last_error);
    options.threads = 4;
    *(int *)failed = create == NULL || create(&options, &context) != RLV_OK || release(context) != RLV_OK ||
                     release(context) != RLV_ERROR_INVALID || strlen(last_error()) == 0;
    pthread_barrier_wait(&used);
    pthread_barrier_wait(&closed);
    /* Now this thread's last error is destroyed, by code of a library that was closed. */
    return NULL;
}

/* Opens the library, uses it and closes it. */
static int round_trip(const char *path) {
    pthread_t thread;
    int failed = 1;
    Version version = NULL;
    library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) {
        fprintf(stderr, "cannot open the library: %s\n", dlerror());
        return 1;
    }
    find("rlv_version", &version);
    if (version == NULL || version() != RLV_VERSION) {
        fprintf(stderr, "the library is of another version\n");
        return 1;
    }
    pthread_barrier_init(&used, NULL, 2);
    pthread_barrier_init(&closed, NULL, 2);
    if (pthread_create(&thread, NULL, use, &failed) != 0) {
        return 1;
    }
    pthread_barrier_wait(&used);
    dlclose(library);
    pthread_barrier_wait(&closed);
    pthread_join(thread, NULL);
    pthread_barrier_destroy(&used);
    pthread_barrier_destroy(&closed);
    return failed;
}

int main(int argc, char **argv) {
    int failed = argc != 2;
    for (int k = 0; k < 100 && !failed; ++k) {
        failed = round_trip(argv[1]);
    }
    return failed;
}
