/* Relievo: a Vulkan device of the host, on which the library works beside it.
 *
 * A context on the host's VkDevice does there what one with RLV_DEVICE_GPU does on a device of its own. Buffers need no
 * copy between devices: those of the library are VkBuffers of the host's device (rlv_buffer_vulkan, rlv_color_buffer_vulkan,
 * rlv_device_level_vulkan), and the host's own take the points of tessellations (rlv_vulkan_create_buffer). Handles are
 * numbers, dispatchable ones as pointers in 64 bits, so that no header of Vulkan is needed here.
 *
 * Who owns what, and when:
 * - The instance, the device and its memory are the host's, and the library destroys none of them. They live until
 *   `released` was called, which the release of the context and of all objects made with it brings about.
 * - The library uses no extension, and no feature but those in `features`. It makes its own VkBuffers, pipelines and pools
 *   through the device, with memory of its own.
 * - A VkQueue is used by one thread at a time. With lock and unlock the library calls them around every vkQueueSubmit and
 *   vkQueueWaitIdle of its own; the host holds the same lock around what it does with the queue, vkDeviceWaitIdle among
 *   it. Without them the host leaves the queue alone while a call or a job is at work on an object of the context.
 * - When a call has returned, what it wrote to buffers is complete; work of the host that is submitted later sees it after
 *   rlv_vulkan_signal, or after a barrier from transfers and shaders.
 * - Buffers of the library belong to the family of the queue. Another family gets them as Vulkan has it: released and
 *   acquired by barriers, or the host's own buffers, made for both (VK_SHARING_MODE_CONCURRENT).
 * Builds without Vulkan, and those for Apple's systems, return RLV_ERROR_UNSUPPORTED. */
#ifndef RELIEVO_VULKAN_H
#define RELIEVO_VULKAN_H

#include "relievo/buffer.h"

/* vkGetInstanceProcAddr, cast. */
typedef void *(*RlvVulkanLoader)(void *instance, const char *name);

/* A function of the host that is called on any thread, and calls nothing of the library. */
typedef void (*RlvVulkanNotice)(void *user);

typedef struct RlvVulkanDevice {
    uint32_t struct_size;
    uint32_t api_version;     /* apiVersion of the instance's VkApplicationInfo: VK_API_VERSION_1_1 or later */
    uint32_t queue_family;    /* index of a family that draws and computes */
    uint32_t queue_index;     /* index of the queue in its family, made without flags */
    uint64_t instance;        /* VkInstance */
    uint64_t physical_device; /* VkPhysicalDevice */
    uint64_t device;          /* VkDevice */
    RlvVulkanLoader loader;
    const void *features;     /* the VkPhysicalDeviceFeatures that the device was made with; NULL for none. Read by the call. */
    RlvVulkanNotice lock;     /* locks the queue; NULL for none */
    RlvVulkanNotice unlock;   /* unlocks it; NULL if lock is */
    RlvVulkanNotice released; /* nothing of the library uses the device any more; called once, not after a failure. May be
                                 NULL. */
    void *user;               /* for the three; valid until released was called */
} RlvVulkanDevice;

#define RLV_VULKAN_DEVICE_INIT {sizeof(RlvVulkanDevice), 0, 0, 0, 0, 0, 0, NULL, NULL, NULL, NULL, NULL, NULL}

/* Buffers of the host that take a tessellation, of the context's device and with memory. Both are made with
 * VK_BUFFER_USAGE_TRANSFER_DST_BIT and VK_BUFFER_USAGE_TRANSFER_SRC_BIT, and with whatever the host does with them. */
typedef struct RlvVulkanBuffers {
    uint32_t struct_size;
    uint32_t reserved;       /* 0 */
    uint64_t points;         /* VkBuffer: position and unit normal, 6 floats, 24 bytes a point */
    uint64_t point_bytes;    /* its size */
    uint64_t triangles;      /* VkBuffer: 3 numbers of points, 4 bytes each, 12 bytes a triangle */
    uint64_t triangle_bytes; /* its size */
} RlvVulkanBuffers;

#define RLV_VULKAN_BUFFERS_INIT {sizeof(RlvVulkanBuffers), 0, 0, 0, 0, 0}

/* Makes a context on a device of the host. options may be NULL for the defaults; its device and adapter are not read. Fails
 * with RLV_ERROR_INVALID if an object is missing or there is no such queue, with RLV_ERROR_UNSUPPORTED if the version of
 * Vulkan is below 1.1, the queue cannot draw and compute, or the build has no Vulkan, with RLV_ERROR_DEVICE if the driver
 * refuses something, and as rlv_context_create does. rlv_context_close_device ends the library's use of the device and
 * does not destroy the device. */
RLV_API RlvResult rlv_vulkan_create_context(const RlvVulkanDevice *device, const RlvContextOptions *options,
                                            RlvContext *out);

/* Makes a buffer as rlv_buffer_create does, whose points and triangles go to buffers of the host: rlv_buffer_update writes
 * them, and rlv_buffer_vulkan names them. They may be larger than needed, and live until the buffer is released. Fails
 * with RLV_ERROR_MEMORY if one of them is too small, and says how many bytes there have to be; so does rlv_buffer_update
 * where a tessellation was rebuilt with more points, and leaves the buffer as it was: make another one then. */
RLV_API RlvResult rlv_vulkan_create_buffer(RlvTessellation tessellation, const RlvVulkanBuffers *buffers,
                                           RlvBuffer *out);

/* Has all work that the context submits from now on wait for a VkSemaphore of its device: a timeline semaphore until it has
 * value, a binary one where value is 0. The host has submitted the signal before, or given the value by vkSignalSemaphore:
 * submissions of the context wait for one another by binary semaphores, for which Vulkan demands it. The semaphore lives
 * until that work is done. Any context on Vulkan has it. Fails with RLV_ERROR_UNSUPPORTED without Vulkan, with
 * RLV_ERROR_DEVICE if the device was lost. */
RLV_API RlvResult rlv_vulkan_wait(RlvContext context, uint64_t semaphore, uint64_t value);

/* Signals a VkSemaphore of the context's device once all work that it submitted is done: a timeline semaphore with value,
 * above its last one, a binary one where value is 0. It lives until it is signalled. Fails as rlv_vulkan_wait does. */
RLV_API RlvResult rlv_vulkan_signal(RlvContext context, uint64_t semaphore, uint64_t value);

#endif
