/* Relievo: buffers, the triangles of a tessellation in the memory of a graphics device, for hosts that draw them there.
 *
 * A buffer lives on the device of the context. Its Vulkan objects are handed out, so that a host draws from them without a
 * copy, with commands of its own on the same VkDevice. Who may use what, and when:
 * - The handles are valid until the buffer is released or rebuilt, or the device closed; VkDevice and VkQueue as long as
 *   any buffer of the context is alive. They are never the host's to destroy, and what they hold not to be written.
 * - When a call of this header has returned, what it wrote is complete and visible to commands that are submitted later.
 * - A VkQueue is used by one thread at a time: the host submits to it only while no call is at work on an object of the
 *   context, and no job. Its own work that reads a buffer has ended before the buffer is updated or released.
 * Other devices and processes cannot open the memory, which is not allocated for that: they copy. Metal and DX12 objects are
 * not handed out. */
#ifndef RELIEVO_BUFFER_H
#define RELIEVO_BUFFER_H

#include "relievo/tessellate.h"

typedef struct RlvBuffer {
    uint64_t id;
} RlvBuffer;

typedef struct RlvBufferInfo {
    uint32_t struct_size;
    uint32_t rebuilt;      /* 1 if the last update made other buffers, with other handles and counts, else 0 */
    size_t point_count;    /* points: position and unit normal, 6 floats, 24 bytes each */
    size_t triangle_count; /* triangles: 3 numbers of points, 4 bytes each, counter-clockwise from the front */
    size_t written_count;  /* points that the last update wrote */
    uint64_t bytes;        /* on the device */
} RlvBufferInfo;

#define RLV_BUFFER_INFO_INIT {sizeof(RlvBufferInfo), 0, 0, 0, 0, 0}

/* Vulkan objects: dispatchable ones as pointers in 64 bits, others unchanged. */
typedef struct RlvBufferVulkan {
    uint32_t struct_size;
    uint32_t queue_family;    /* index of the family of the queue */
    uint32_t queue_index;     /* index of the queue in its family */
    uint32_t reserved;        /* 0 */
    uint64_t instance;        /* VkInstance */
    uint64_t physical_device; /* VkPhysicalDevice */
    uint64_t device;          /* VkDevice */
    uint64_t queue;           /* VkQueue */
    uint64_t points;          /* VkBuffer, for vertices and storage */
    uint64_t triangles;       /* VkBuffer, for indices and storage */
} RlvBufferVulkan;

#define RLV_BUFFER_VULKAN_INIT {sizeof(RlvBufferVulkan), 0, 0, 0, 0, 0, 0, 0, 0, 0}

/* Puts the triangles of a tessellation, as it was updated last, on the device of its context, and keeps the tessellation
 * alive. Fails with RLV_ERROR_UNSUPPORTED if the context has no graphics device, with RLV_ERROR_DEVICE if that was lost, and
 * with RLV_ERROR_MEMORY if it has no room. */
RLV_API RlvResult rlv_buffer_create(RlvTessellation tessellation, RlvBuffer *out);

RLV_API RlvResult rlv_buffer_retain(RlvBuffer buffer);
RLV_API RlvResult rlv_buffer_release(RlvBuffer buffer);

/* Mutating: brings the buffer to the tessellation's last update; after each update only the points that it wrote are
 * copied, after several all of them. Waits for the device. out may be NULL. Fails as rlv_buffer_create does, with
 * RLV_ERROR_BUSY if another call is at work on the buffer or updates the tessellation. */
RLV_API RlvResult rlv_buffer_update(RlvBuffer buffer, RlvBufferInfo *out);

/* What is in the buffer. No failure of its own. */
RLV_API RlvResult rlv_buffer_info(RlvBuffer buffer, RlvBufferInfo *out);

/* Its Vulkan objects. Fails with RLV_ERROR_UNSUPPORTED if the device is reached by another interface than Vulkan, and with
 * RLV_ERROR_DEVICE if it was lost. */
RLV_API RlvResult rlv_buffer_vulkan(RlvBuffer buffer, RlvBufferVulkan *out);

/* Copies count points from first on back from the device, 6 floats each, stride bytes apart, 0 for packed. Fails if there
 * are not as many points, and with RLV_ERROR_DEVICE if the device was lost. */
RLV_API RlvResult rlv_buffer_read(RlvBuffer buffer, size_t first, size_t count, float *points, size_t stride);

#endif
