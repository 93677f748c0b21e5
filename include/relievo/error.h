/* Relievo: results and the last error of a thread.
 *
 * Every function that can fail returns RlvResult and writes its outputs only if that is RLV_OK. The text of the failure
 * is kept for the calling thread until its next failure. No panic or exception of the library reaches the caller. */
#ifndef RELIEVO_ERROR_H
#define RELIEVO_ERROR_H

#include "relievo/version.h"

typedef int32_t RlvResult;

enum {
    RLV_OK = 0,
    RLV_ERROR_INVALID = 1,     /* an argument or data that cannot be used: NULL, dead handle, out of range, not finite */
    RLV_ERROR_UNSUPPORTED = 2, /* valid input that this build or device does not handle */
    RLV_ERROR_NOT_FOUND = 3,   /* a file, name or element that does not exist */
    RLV_ERROR_IO = 4,          /* the operating system refused to read or write */
    RLV_ERROR_MEMORY = 5,      /* a budget or limit would be exceeded; nothing was changed */
    RLV_ERROR_BUSY = 6,        /* another call is at work on the object; nothing was changed, call again later */
    RLV_ERROR_CANCELLED = 7,   /* the progress callback asked to stop; nothing was changed */
    RLV_ERROR_INTERNAL = 8,    /* a fault of the library; nothing can be said about the objects of the call */
    RLV_ERROR_DEVICE = 9       /* a graphics device failed or was lost; what was committed is kept */
};

/* What failed, in parts. The texts are UTF-8, may be empty, and live until the next failure on the same thread. */
typedef struct RlvError {
    uint32_t struct_size;
    RlvResult result;    /* what the failed function returned; RLV_OK if none failed yet */
    const char *message; /* everything in one line: "place: what; remedy" */
    const char *what;    /* what went wrong */
    const char *place;   /* where: the function, then the argument, file and line, or element */
    const char *remedy;  /* what can be done about it */
} RlvError;

#define RLV_ERROR_INIT {sizeof(RlvError), RLV_OK, NULL, NULL, NULL, NULL}

/* The message of the last failed call on this thread, UTF-8, "" if there was none. Never NULL. It lives until the next
 * failure on this thread. */
RLV_API const char *rlv_last_error(void);

/* The last failed call on this thread, in parts. No failure of its own. */
RLV_API RlvResult rlv_error_get(RlvError *out);

#endif
