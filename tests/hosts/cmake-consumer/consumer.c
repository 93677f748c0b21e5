/* A program that found the library through its package. */
#include <relievo/relievo.h>

#include <stdio.h>

int main(void) {
    RlvContext context = RLV_NULL;
    if (rlv_version() != RLV_VERSION || rlv_context_create(NULL, &context) != RLV_OK) {
        fprintf(stderr, "%s\n", rlv_error_last());
        return 1;
    }
    return rlv_context_release(context) == RLV_OK ? 0 : 1;
}
