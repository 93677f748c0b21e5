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

/* What an element of a failure is. */
typedef enum RlvElement {
    RLV_ELEMENT_NONE = 0,     /* the failure is about no single element */
    RLV_ELEMENT_POINT = 1,    /* a point, vertex or node */
    RLV_ELEMENT_CORNER = 2,   /* a corner of a face */
    RLV_ELEMENT_EDGE = 3,
    RLV_ELEMENT_FACE = 4,
    RLV_ELEMENT_TRIANGLE = 5,
    RLV_ELEMENT_TILE = 6,
    RLV_ELEMENT_PATCH = 7,
    RLV_ELEMENT_ITEM = 8,     /* an element of an array that place names */
    RLV_ELEMENT_PARTICLE = 9,
    RLV_ELEMENT_LINE = 10,    /* of a file of text, from 1 */
    RLV_ELEMENT_PIN = 11,     /* of a decal */
    RLV_ELEMENT_CREASE = 12
} RlvElement;

/* What failed, in parts. The texts are UTF-8, may be empty, and live until the next failure on the same thread. */
typedef struct RlvError {
    uint32_t struct_size;
    RlvResult result;    /* what the failed function returned; RLV_OK if none failed yet */
    const char *message; /* everything in one line: "place: what; remedy" */
    const char *what;    /* what went wrong */
    const char *place;   /* where: the function, then the argument, file and line, or element */
    const char *remedy;  /* what can be done about it */
    uint32_t code;       /* number of the sentence `what`, the same whatever numbers and quoted names it has, for tables of
                            translations; stable as long as the sentence is, 0 for none */
    uint32_t element_kind; /* RlvElement: what `element` counts */
    uint64_t element;      /* number of the innermost element that place or what names, from 0; 0 for none */
} RlvError;

#define RLV_ERROR_INIT {sizeof(RlvError), RLV_OK, NULL, NULL, NULL, NULL, 0, RLV_ELEMENT_NONE, 0}

/* The message of the last failed call on this thread, UTF-8, "" if there was none. Never NULL. It lives until the next
 * failure on this thread. */
RLV_API const char *rlv_error_last(void);

/* The last failed call on this thread, in parts. No failure of its own. */
RLV_API RlvResult rlv_error_get(RlvError *out);

#endif
