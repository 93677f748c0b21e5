/* Relievo: an allocator of the host, for the whole library and the life of the process, and a limit on what the library takes.
 *
 * With one, every block that the library's own code takes comes from the host, on any thread: meshes, surfaces' tables, tiles,
 * layers and their history, particles, bytes that are handed out (rlv_bytes_get), pictures, tables of handles, and what
 * is needed while a call works. What does not:
 * - memory of other libraries, which take it from the system: OpenSubdiv while it refines and its patches, OpenVDB's trees,
 *   Embree's hierarchies (a monitor of memory hears of those: rlv_context_set_memory_monitor), the C++ runtime;
 * - memory of graphics devices and what drivers take;
 * - stacks of threads, files that are mapped into memory, and the library itself;
 * - what was taken before the allocator was set, which goes back to the system. */
#ifndef RELIEVO_ALLOCATOR_H
#define RELIEVO_ALLOCATOR_H

#include "relievo/error.h"

/* Returns a block of size bytes, more than 0, at a multiple of alignment, a power of two, which nobody else uses until it is
 * freed; or NULL. For large arrays NULL makes the call fail with RLV_ERROR_MEMORY; where small blocks are refused the
 * process ends, as it does where the system refuses them: to bound memory, use the context's limit and monitor. Called
 * on any thread, several at once and under locks of the library: it must not call into the library or throw. */
typedef void *(*RlvAllocate)(void *user, size_t size, size_t alignment);

/* Takes back a block with the size and the alignment, in bytes, that RlvAllocate was called with. Called as RlvAllocate is. */
typedef void (*RlvFree)(void *user, void *block, size_t size, size_t alignment);

typedef struct RlvAllocator {
    uint32_t struct_size;
    uint32_t reserved;
    RlvAllocate allocate;
    RlvFree free;
    void *user; /* for both; they and what it points to live until the process ends */
} RlvAllocator;

#define RLV_ALLOCATOR_INIT {sizeof(RlvAllocator), 0, NULL, NULL, NULL}

/* Takes all memory from the host from now on. Call it once, before any other function of the library and before other
 * threads do. Fails if a function is missing, if an allocator is set already, or if it is too late, since a context was
 * made. */
RLV_API RlvResult rlv_allocator_set(const RlvAllocator *allocator);

/* What the library's own code occupies. Blocks count with the bytes that were asked for, from any allocator. */
typedef struct RlvAllocatorInfo {
    uint32_t struct_size;
    uint32_t is_set; /* 0 or 1: whether the host has set an allocator */
    uint64_t bytes;  /* that the library's blocks occupy now; what does not count is listed above */
    uint64_t limit;  /* as set; 0 for none */
} RlvAllocatorInfo;

#define RLV_ALLOCATOR_INFO_INIT {sizeof(RlvAllocatorInfo), 0, 0, 0}

/* What the library occupies, and what it may. No failure of its own. */
RLV_API RlvResult rlv_allocator_info(RlvAllocatorInfo *out);

/* Sets how many bytes the library's blocks may occupy together, of all contexts; 0, the initial state, for no limit. A call
 * that reads input or makes a table for which the limit leaves no room fails with RLV_ERROR_MEMORY and changes nothing, as
 * if the memory_limit of its context were what is left. Blocks of other uses are counted but not refused, so that the
 * library may exceed the limit by what running calls need. A limit below what is occupied already refuses new tables and takes
 * nothing back. No failure of its own. */
RLV_API RlvResult rlv_allocator_set_limit(uint64_t bytes);

#endif
