/* Relievo: bytes, what a file would hold, made in memory for hosts that keep it in files of their own.
 *
 * Whatever is written as bytes is read from bytes by the function of the same noun that ends in _bytes, and is the same as
 * the file that is written to a path. Bytes never change. */
#ifndef RELIEVO_BYTES_H
#define RELIEVO_BYTES_H

#include "relievo/context.h"

typedef struct RlvBytes {
    uint64_t id;
} RlvBytes;

RLV_API RlvResult rlv_bytes_retain(RlvBytes bytes);
RLV_API RlvResult rlv_bytes_release(RlvBytes bytes);

/* Where the bytes are and how many there are, both not NULL. They live until the last reference is released.
 * No failure of its own. */
RLV_API RlvResult rlv_bytes_get(RlvBytes bytes, const uint8_t **data, size_t *size);

#endif
