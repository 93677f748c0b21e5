/* Functions that get handles which they do not take. */
#ifndef GARBAGE_H
#define GARBAGE_H

#include "check.h"

/* A function with whatever handle, NULL or room for what else it takes, and the number of the noun whose handles it takes. */
typedef RlvResult (*ByHandle)(uint64_t id);
typedef struct HandleFunction {
    ByHandle call;
    int noun;
} HandleFunction;

/* The function fails with a message for handles of the other nouns, one each, and for those of `others`. */
static inline void check_handle_function(HandleFunction function, const uint64_t *alive, int nouns, const uint64_t *others,
                                         size_t count) {
    for (int noun = 0; noun < nouns; ++noun) {
        if (noun != function.noun) {
            CHECK(function.call(alive[noun]) == RLV_ERROR_INVALID && rlv_error_last()[0] != 0);
        }
    }
    for (size_t other = 0; other < count; ++other) {
        CHECK(function.call(others[other]) == RLV_ERROR_INVALID && rlv_error_last()[0] != 0);
    }
}

#endif
