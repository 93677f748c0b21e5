/* The graphics device of the machine for the tests, and what they ask of its Vulkan. */
#ifndef GPU_H
#define GPU_H

#include "check.h"

#include <dlfcn.h>

/* Ends a test that has no device: it counts as skipped, and as failed where one is required. */
static inline void check_skipped(void) {
    const char *required = getenv("RELIEVO_GPU_TESTS");
    CHECK(required == NULL || strcmp(required, "required") != 0);
    exit(77); /* what ctest takes for skipped */
}

/* Has a context made on the last adapter. Ends the test where there is none, which the argument "none" demands. */
static inline void check_on_gpu(int argc, char **argv, RlvContextOptions *options) {
    static RlvAdapterInfo adapters[16];
    size_t count = 0;
    CHECK_OK(rlv_adapter_list(adapters, 16, &count));
    if (argc > 1 && strcmp(argv[1], "none") == 0) {
        CHECK(count == 0);
        exit(0);
    }
    if (count == 0) {
        check_skipped();
    }
    options->device = RLV_DEVICE_GPU;
    options->adapter = adapters[count - 1].name;
}

/* What of Vulkan is asked, declared by hand: whoever runs this may have no headers of it. */
typedef struct MemoryRequirements {
    uint64_t size, alignment;
    uint32_t types;
} MemoryRequirements;
typedef void (*Function)(void);
typedef Function (*Lookup)(void *object, const char *name);
typedef void (*GetRequirements)(void *device, uint64_t buffer, MemoryRequirements *out);

static inline void *check_handle(uint64_t value) {
    void *pointer = NULL;
    memcpy(&pointer, &value, sizeof pointer);
    return pointer;
}

/* Opens the Vulkan loader, and returns what looks up functions of the instance's devices in it. */
static inline Lookup check_loader(uint64_t instance, void **library) {
    Lookup of_instance = NULL, of_device = NULL;
    *library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    CHECK(*library != NULL);
    *(void **)&of_instance = dlsym(*library, "vkGetInstanceProcAddr");
    CHECK(of_instance != NULL);
    of_device = (Lookup)of_instance(check_handle(instance), "vkGetDeviceProcAddr");
    CHECK(of_device != NULL);
    return of_device;
}

#endif
