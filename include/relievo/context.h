/* Relievo: contexts.
 *
 * A context owns the threads that work, the memory limit and the statistics. Every object is made with a context and
 * keeps it alive. Results are bit-identical for any number of threads.
 *
 * Rules that hold for every noun:
 * - Handles are structs passed by value. A function that makes one gives its caller one reference; _retain adds one,
 *   _release takes one away, the last one kills the handle. NULL, dead and foreign handles are RLV_ERROR_INVALID.
 *   An object stays alive while others need it: releasing a mesh does not hurt the surface made from it.
 * - Every function may be called from any thread. Calls that do not change an object may run at the same time. A call
 *   that changes an object ("mutating" in the headers) needs it alone; nobody waits, the later call returns
 *   RLV_ERROR_BUSY, and says which function is at work; rlv_object_wait waits. Calls on a surface or a detail read a
 *   snapshot, so they neither cause nor get RLV_ERROR_BUSY while it is being changed.
 * - Arrays are pointer, count and stride in bytes from one element to the next, 0 for packed. They are borrowed for the
 *   call. NULL is allowed where the count is 0 or the header says so. Floats must be finite.
 * - A place that a host gives alone is three doubles. Arrays of points are floats, and so is what the library finds in them,
 *   such as bounds and hits.
 * - A function that writes as many elements as there are takes their capacity and a place for their count. The count is
 *   written first, so that a host whose array is too small knows how large it must be; elements are written if all fit.
 * - Names and parameters have one order: rlv_<noun>_<verb>; the handles that are needed, the context or the noun first; then
 *   what is given, each array as pointer, count, stride; callbacks, each followed by user; what is returned at the end, a
 *   new handle as the last parameter, out. A range of an object is first and count.
 * - Every function fails at invalid handles, at NULL and counts of 0 where the header does not allow them, at
 *   floats that are not finite, at numbers of enums that it does not know, and at a struct_size that it does not know.
 *   "No failure of its own" in the headers says that it fails at nothing else.
 * - Structs that begin with struct_size are started from their RLV_..._INIT and may grow in later versions.
 * - Callbacks run on the thread that made the call, must not throw, and may call into the library. Some run
 *   on other threads, as their comments say: the host's loop and tasks, monitors of memory, notices of jobs.
 * - A forked child has none of its parent's threads: calls on objects made before the fork fail there with
 *   RLV_ERROR_UNSUPPORTED. They may be released; a context made in the child works. */
#ifndef RELIEVO_CONTEXT_H
#define RELIEVO_CONTEXT_H

#include "relievo/error.h"

typedef struct RlvContext {
    uint64_t id;
} RlvContext;

typedef enum RlvDevice {
    RLV_DEVICE_CPU = 0,
    RLV_DEVICE_GPU = 1, /* a graphics device; an error where there is none */
    RLV_DEVICE_AUTO = 2 /* a graphics device, but none that is the processor itself unless it is named; the processor
                           where there is none */
} RlvDevice;

/* Does the piece of a loop that has the index. work is what the loop got. */
typedef void (*RlvLoopBody)(void *work, size_t index);

/* The host's parallel loop: calls body(work, index) once for every index below count, on any threads and in any order, and
 * returns when all of these calls have returned. It is called on the threads of calls into the library and, for loops
 * within loops, on the threads that run body; so it must allow loops within loops, as TBB's does. Pieces that it leaves
 * out run on the calling thread. It must not throw. */
typedef void (*RlvLoop)(void *user, size_t count, RlvLoopBody body, void *work);

/* Does all of a task. */
typedef void (*RlvTask)(void *work);

/* Has task(work) run once, on a thread of the host, and returns without waiting for it. It must not throw. */
typedef void (*RlvSpawn)(void *user, RlvTask task, void *work);

typedef struct RlvContextOptions {
    uint32_t struct_size;
    uint32_t device;       /* RlvDevice */
    uint32_t threads;      /* 0 to 1024; 0 for one per core, 1 to stay on the calling thread and create none */
    uint32_t reserved;     /* 0 */
    uint64_t memory_limit; /* bytes that tables made from one input may occupy; 0 for no limit. rlv_allocator_set_limit
                              bounds all of them together */
    uint64_t device_memory_limit; /* bytes that buffers on the graphics device may occupy together; 0 for no limit */
    const char *adapter; /* UTF-8: which graphics device, by a part of its name in letters of any case; NULL or "" for the
                            best, as rlv_adapter_list orders them. Not read for RLV_DEVICE_CPU. */
    RlvContext shared;   /* the context whose threads, or host_loop, this one uses too; RLV_NULL for threads of its own.
                            Needs threads = 0 and host_loop = NULL. */
    RlvLoop host_loop;   /* the host's parallel loop in place of threads of the context; then `threads` says how many
                            threads of the host work on it, 0 for one per core. NULL for none. */
    RlvSpawn host_spawn; /* runs jobs on threads of the host; see relievo/job.h. NULL for a thread a job. */
    void *host_user;     /* first argument of host_loop and host_spawn; valid as long as the context or an object of it */
} RlvContextOptions;

#define RLV_CONTEXT_OPTIONS_INIT {sizeof(RlvContextOptions), RLV_DEVICE_CPU, 0, 0, 0, 0, NULL, {0}, NULL, NULL, NULL}

typedef struct RlvContextInfo {
    uint32_t struct_size;
    uint32_t device;  /* the device that works: RLV_DEVICE_CPU or RLV_DEVICE_GPU */
    uint32_t threads; /* how many threads work, at least 1 */
    uint32_t reserved;
    uint64_t memory_limit;    /* as given */
    char simd[RLV_NAME_SIZE]; /* instruction level: "baseline", "avx2", "avx512" or "neon" */
    uint64_t device_memory_limit; /* bytes, as given */
    uint64_t device_memory;       /* bytes that buffers on the graphics device occupy */
    char adapter[RLV_TEXT_SIZE];  /* name of the graphics device that was opened, "" for none */
    char fallback[RLV_TEXT_SIZE]; /* why the processor works where a graphics device was asked for, "" if it does not */
} RlvContextInfo;

#define RLV_CONTEXT_INFO_INIT {sizeof(RlvContextInfo), 0, 0, 0, 0, {0}, 0, 0, {0}, {0}}

/* One row of the statistics. */
typedef struct RlvContextStat {
    char stage[RLV_NAME_SIZE];    /* "imprint.voxelise" */
    char quantity[RLV_NAME_SIZE]; /* "seconds", or what the stage counts */
    double total;                 /* sum over all runs of the stage since the last reset */
    uint64_t samples;             /* how many runs there were */
} RlvContextStat;

typedef enum RlvProgressAnswer { RLV_PROGRESS_CONTINUE = 0, RLV_PROGRESS_CANCEL = 1 } RlvProgressAnswer;

/* Receives the progress of a long call: fraction is 0 to 1, stage names what is being done and lives for the call.
 * Returns RlvProgressAnswer; after RLV_PROGRESS_CANCEL the long call returns RLV_ERROR_CANCELLED. May be NULL. */
typedef uint32_t (*RlvProgress)(void *user, float fraction, const char *stage);

typedef enum RlvLogLevel { RLV_LOG_INFO = 0, RLV_LOG_WARNING = 1 } RlvLogLevel;

/* Receives what is worth knowing but no failure: an accepted non-manifold cage, a refused tile. UTF-8, no newline. */
typedef void (*RlvLog)(void *user, uint32_t level, const char *text);

/* Which threads work. Everything that a context computes on the processor runs on the calling thread and on one of these:
 * its own threads, which start with the first loop that has work for two of them and end with the context; those of a
 * context that it shares; or those of host_loop. With threads = 1, and with host_loop, the context starts no thread. Where
 * the system starts no more threads, loops stay on the calling thread. What runs elsewhere:
 * - OpenSubdiv refines on the calling thread, and no OpenMP is loaded for it. Embree builds on the calling thread,
 *   inside a TBB arena of one thread, so that TBB starts none either.
 * - OpenVDB's operations on grids run on the threads of the TBB that its module loads.
 * - A job has a thread of its own, unless host_spawn runs it. Drivers of graphics devices start what they like. */

/* Makes a context. options may be NULL for the defaults. Fails with RLV_ERROR_NOT_FOUND if RLV_DEVICE_GPU is asked for
 * and there is no graphics device, or none of that name, and with RLV_ERROR_UNSUPPORTED if it lacks something or the
 * library was built without graphics devices; with RLV_DEVICE_AUTO the processor works then, and rlv_context_info says
 * why. Fails too if the environment variable RELIEVO_SIMD names an instruction level that this processor lacks.
 *
 * On a graphics device details are sculpted, painted and pressed into, and fade: no call takes another argument for it.
 * What a device does not do, the processor does. Heights differ from the processor's by units in the last place of a half
 * float, but for the few rays of an imprint that graze a voxel. Where a device fails or has no room, the processor takes
 * over and nothing is lost; the log says so, and rlv_detail_device_fault. */
RLV_API RlvResult rlv_context_create(const RlvContextOptions *options, RlvContext *out);

RLV_API RlvResult rlv_context_retain(RlvContext context);
RLV_API RlvResult rlv_context_release(RlvContext context);

/* What the context is: its device, threads, limits and the level of its instructions. No failure of its own. */
RLV_API RlvResult rlv_context_info(RlvContext context, RlvContextInfo *out);

/* Lets the graphics device go, as if it were lost: the processor takes over, also in the middle of a stroke. For hosts
 * that need its memory, and before a driver is unloaded. Does nothing where there is none. No failure of its own. */
RLV_API RlvResult rlv_context_close_device(RlvContext context);

/* Sets where log texts of calls on objects of this context go. NULL, the initial state, is silence. The callback runs
 * on the thread that made the logging call; user must stay valid until another callback or NULL is set and the calls in
 * progress have returned. No failure of its own. */
RLV_API RlvResult rlv_context_set_log(RlvContext context, RlvLog callback, void *user);

/* Hears of bytes that large objects of a context take or, below 0, give back: the arrays of meshes as they are made, and all
 * that Embree allocates for casters. Returns RlvProgressAnswer: after RLV_PROGRESS_CANCEL to bytes above 0 the call that
 * needs them fails with RLV_ERROR_MEMORY and changes nothing; refused bytes are not given back later. Answers to bytes
 * below 0 count for nothing. Called on any thread that works, maybe on several at once and under locks of Embree: it must
 * be quick and must not call into the library. */
typedef uint32_t (*RlvMemoryMonitor)(void *user, int64_t bytes);

/* Sets the monitor of memory of the objects that are made with the context afterwards, and of the earlier ones; NULL, the
 * initial state, for none. user must stay valid until another monitor or NULL is set and the calls in progress have
 * returned. No failure of its own. */
RLV_API RlvResult rlv_context_set_memory_monitor(RlvContext context, RlvMemoryMonitor callback, void *user);

/* Time and counts per stage since the last reset, ordered by stage and quantity. Writes up to capacity rows to stats
 * and their number to count. stats may be NULL to ask for the number. Fails if there are more rows than capacity. */
RLV_API RlvResult rlv_context_stats(RlvContext context, RlvContextStat *stats, size_t capacity, size_t *count);

/* Forgets the statistics. No failure of its own. */
RLV_API RlvResult rlv_context_reset_stats(RlvContext context);

#endif
