/* Relievo: streams, storage of the host in which a document lives in place of a file, such as a part of the host's own
 * scene file.
 *
 * A stream is a table of callbacks that read and write at a place. Places and sizes are in bytes from the start. A callback
 * returns 0 for success, and any other number for a failure, which becomes the RLV_ERROR_IO of the call that made it, with
 * that number in its message. Callbacks run on the thread that made the call, one at a time for each stream; close may run
 * on any thread that releases the last reference. */
#ifndef RELIEVO_STREAM_H
#define RELIEVO_STREAM_H

#include "relievo/context.h"

/* Reads size bytes from place on; never beyond the length. */
typedef uint32_t (*RlvStreamRead)(void *user, uint64_t place, uint8_t *bytes, size_t size);

/* Writes size bytes from place on, which is at most the length; what reaches beyond the length extends the stream. */
typedef uint32_t (*RlvStreamWrite)(void *user, uint64_t place, const uint8_t *bytes, size_t size);

/* Writes how many bytes the stream has to length. */
typedef uint32_t (*RlvStreamLength)(void *user, uint64_t *length);

/* Cuts the stream off after length bytes; length is at most its present length. */
typedef uint32_t (*RlvStreamCut)(void *user, uint64_t length);

/* Returns when all that was written is safe against a failure of power. */
typedef uint32_t (*RlvStreamSync)(void *user);

/* Ends the use of user: no other callback follows. */
typedef void (*RlvStreamClose)(void *user);

typedef struct RlvStream {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    void *user;        /* given to all callbacks; valid until close is called */
    RlvStreamRead read;
    RlvStreamWrite write;
    RlvStreamLength length;
    RlvStreamCut cut;
    RlvStreamSync sync;   /* NULL where nothing is to be waited for */
    RlvStreamClose close; /* NULL where nothing is to be done. Called once for each function that takes the stream: when its
                             document uses it no longer, or before the function returns if that fails at anything but
                             the table itself. */
} RlvStream;

#define RLV_STREAM_INIT {sizeof(RlvStream), 0, NULL, NULL, NULL, NULL, NULL, NULL, NULL}

#endif
