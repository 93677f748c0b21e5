/* Relievo: objects of any noun, and waiting until no call is at work on them.
 *
 * A call that changes an object needs it alone: a later one returns RLV_ERROR_BUSY, and its message names the function
 * that is at work. A host that would rather wait than come back does it here. */
#ifndef RELIEVO_OBJECT_H
#define RELIEVO_OBJECT_H

#include "relievo/context.h"

typedef struct RlvObjectInfo {
    uint32_t struct_size;
    uint32_t is_busy;           /* 0 or 1: whether a call was at work on it when the time was up */
    char noun[RLV_NAME_SIZE];   /* what it is: "detail", "fluid" */
    char worker[RLV_NAME_SIZE]; /* the function that is at work, "rlv_job_sweep" for a job that this started; "" for none */
} RlvObjectInfo;

#define RLV_OBJECT_INFO_INIT {sizeof(RlvObjectInfo), 0, {0}, {0}}

/* Waits until no call is at work on the object whose handle has this id, but no longer than seconds; 0 to ask without
 * waiting, -1 for as long as it takes. id is the field of any handle (detail.id); out may be NULL. That the time was up is
 * no failure: is_busy is 1 then. Another thread may begin a call before this one returns, so the next call may still be
 * RLV_ERROR_BUSY. Calls on snapshots of surfaces and details hold nothing and are not waited for; nor are jobs by their
 * own id: rlv_job_wait does that. Fails if seconds is another number below 0 or not finite, and at a handle that is not
 * alive. Must not be called by a callback of a call on the same object with a time other than 0: it would wait for itself. */
RLV_API RlvResult rlv_object_wait(uint64_t id, double seconds, RlvObjectInfo *out);

#endif
