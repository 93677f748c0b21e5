/* The last error: in one line, in parts, per thread. */
#include "check.h"

#include <pthread.h>

static void *other_thread(void *unused) {
    (void)unused;
    CHECK(strcmp(rlv_error_last(), "") == 0);
    RlvContext nothing = RLV_NULL;
    CHECK(rlv_context_release(nothing) == RLV_ERROR_INVALID);
    return NULL;
}

int main(void) {
    RlvError error = RLV_ERROR_INIT;
    CHECK_OK(rlv_error_get(&error));
    CHECK(error.result == RLV_OK && strcmp(error.message, "") == 0 && strcmp(rlv_error_last(), "") == 0);

    CHECK(rlv_context_create(NULL, NULL) == RLV_ERROR_INVALID);
    CHECK_OK(rlv_error_get(&error));
    CHECK(error.result == RLV_ERROR_INVALID);
    CHECK(strcmp(error.what, "the output pointer is NULL") == 0);
    CHECK(strcmp(error.place, "rlv_context_create: out") == 0);
    CHECK(strlen(error.remedy) > 0);
    CHECK(strcmp(error.message, rlv_error_last()) == 0);
    CHECK(strstr(error.message, error.what) && strstr(error.message, error.place) && strstr(error.message, error.remedy));

    /* Another thread has its own, and a success does not touch it. */
    char before[512];
    strncpy(before, rlv_error_last(), sizeof(before) - 1);
    before[sizeof(before) - 1] = 0;
    pthread_t thread;
    CHECK(pthread_create(&thread, NULL, other_thread, NULL) == 0);
    CHECK(pthread_join(thread, NULL) == 0);
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    CHECK(strcmp(before, rlv_error_last()) == 0);
    CHECK_OK(rlv_context_release(context));

    /* In numbers: the element, and the sentence whatever numbers it has. */
    CHECK_OK(rlv_context_create(NULL, &context));
    float points[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    uint32_t corners[6] = {0, 1, 2, 1, 3, 2}, codes[2];
    RlvMeshArrays arrays = check_faces(points, 4, 3, 2, corners);
    RlvMesh mesh = RLV_NULL;
    for (int k = 0; k < 2; ++k) {
        corners[3 + k] = 77 + 100 * (uint32_t)k;
        CHECK(rlv_mesh_create(context, &arrays, &mesh) == RLV_ERROR_INVALID);
        CHECK_OK(rlv_error_get(&error));
        CHECK(error.element_kind == RLV_ELEMENT_CORNER && error.element == (uint64_t)k);
        codes[k] = error.code;
        corners[3 + k] = (uint32_t)(k == 0 ? 1 : 3);
    }
    CHECK(codes[0] == codes[1] && codes[0] != 0);
    points[7] = NAN;
    CHECK(rlv_mesh_create(context, &arrays, &mesh) == RLV_ERROR_INVALID);
    CHECK_OK(rlv_error_get(&error));
    CHECK(error.element_kind == RLV_ELEMENT_POINT && error.element == 2 && error.code != codes[0] && error.code != 0);
    CHECK_OK(rlv_context_release(context));
    CHECK(rlv_context_release(context) == RLV_ERROR_INVALID);
    CHECK_OK(rlv_error_get(&error));
    CHECK(error.element_kind == RLV_ELEMENT_NONE && error.element == 0 && error.code != 0);

    /* Descriptors must say their size. */
    error.struct_size = 0;
    CHECK(rlv_error_get(&error) == RLV_ERROR_INVALID);
    CHECK(rlv_error_get(NULL) == RLV_ERROR_INVALID);
    return 0;
}
