/* Points of a tessellation in CUDA, without a copy: Vulkan memory that the host exports, opened by CUDA.
 *
 *   cc examples/c/cuda.c -Iinclude -I/usr/local/cuda/include -lrelievo -lvulkan -lcudart
 *
 * The host's Vulkan device, and a buffer and a timeline semaphore that are made for export, are what a host has already:
 * the device with VK_KHR_external_memory_fd and VK_KHR_external_semaphore_fd, the buffer with
 * VkExternalMemoryBufferCreateInfo, its memory with VkExportMemoryAllocateInfo and VkMemoryDedicatedAllocateInfo, the
 * semaphore with VkExportSemaphoreCreateInfo, all of the handle type OPAQUE_FD. This is what comes then; a program calls
 * share_points once and points_ready after every rlv_buffer_update. It has been compiled and not been run. */
#include <relievo/relievo.h>

#include <cuda_runtime_api.h>
#include <vulkan/vulkan.h>

#include <string.h>

/* What the host made for export. */
typedef struct Exported {
    VkDevice device;
    VkBuffer points, triangles;
    VkDeviceMemory memory; /* of points alone, from its beginning on */
    uint64_t memory_bytes, point_bytes, triangle_bytes;
    VkSemaphore semaphore; /* a timeline semaphore */
} Exported;

/* The same in CUDA. */
typedef struct Shared {
    RlvBuffer buffer;
    cudaExternalMemory_t memory;
    cudaExternalSemaphore_t semaphore;
    float *points; /* on the device: position and unit normal, 6 floats a point */
    uint64_t value; /* of the semaphore, after the last update */
} Shared;

/* Has the tessellation's points written to the exported buffer, and opens it in CUDA. 0 if something fails. */
static int share_points(const Exported *exported, RlvTessellation tessellation, Shared *shared) {
    const PFN_vkGetMemoryFdKHR get_memory = (PFN_vkGetMemoryFdKHR)vkGetDeviceProcAddr(exported->device, "vkGetMemoryFdKHR");
    const PFN_vkGetSemaphoreFdKHR get_semaphore =
        (PFN_vkGetSemaphoreFdKHR)vkGetDeviceProcAddr(exported->device, "vkGetSemaphoreFdKHR");
    const VkMemoryGetFdInfoKHR memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_GET_FD_INFO_KHR,
                                         .memory = exported->memory,
                                         .handleType = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT};
    const VkSemaphoreGetFdInfoKHR semaphore = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_GET_FD_INFO_KHR,
                                               .semaphore = exported->semaphore,
                                               .handleType = VK_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD_BIT};
    RlvVulkanBuffers buffers = RLV_VULKAN_BUFFERS_INIT;
    struct cudaExternalMemoryHandleDesc memory_of;
    struct cudaExternalMemoryBufferDesc buffer_of;
    struct cudaExternalSemaphoreHandleDesc semaphore_of;
    memset(shared, 0, sizeof *shared);
    memset(&memory_of, 0, sizeof memory_of);
    memset(&buffer_of, 0, sizeof buffer_of);
    memset(&semaphore_of, 0, sizeof semaphore_of);
    if (get_memory == NULL || get_semaphore == NULL) {
        return 0;
    }
    buffers.points = (uint64_t)exported->points;
    buffers.point_bytes = exported->point_bytes;
    buffers.triangles = (uint64_t)exported->triangles;
    buffers.triangle_bytes = exported->triangle_bytes;
    if (rlv_vulkan_create_buffer(tessellation, &buffers, &shared->buffer) != RLV_OK) {
        return 0;
    }
    /* CUDA owns a file descriptor once it has opened it. */
    memory_of.type = cudaExternalMemoryHandleTypeOpaqueFd;
    memory_of.size = exported->memory_bytes;
    memory_of.flags = cudaExternalMemoryDedicated;
    semaphore_of.type = cudaExternalSemaphoreHandleTypeTimelineSemaphoreFd;
    buffer_of.size = exported->point_bytes;
    return get_memory(exported->device, &memory, &memory_of.handle.fd) == VK_SUCCESS &&
           get_semaphore(exported->device, &semaphore, &semaphore_of.handle.fd) == VK_SUCCESS &&
           cudaImportExternalMemory(&shared->memory, &memory_of) == cudaSuccess &&
           cudaImportExternalSemaphore(&shared->semaphore, &semaphore_of) == cudaSuccess &&
           cudaExternalMemoryGetMappedBuffer((void **)&shared->points, shared->memory, &buffer_of) == cudaSuccess;
}

/* Has the stream wait until the points of the last update are there. 0 if something fails. */
static int points_ready(RlvContext context, const Exported *exported, Shared *shared, cudaStream_t stream) {
    struct cudaExternalSemaphoreWaitParams wait;
    memset(&wait, 0, sizeof wait);
    wait.params.fence.value = ++shared->value;
    return rlv_vulkan_signal(context, (uint64_t)exported->semaphore, shared->value) == RLV_OK &&
           cudaWaitExternalSemaphoresAsync(&shared->semaphore, &wait, 1, stream) == cudaSuccess;
}

/* Gives back what share_points opened, once the stream is done. */
static void end_sharing(Shared *shared) {
    cudaFree(shared->points);
    if (shared->memory != NULL) {
        cudaDestroyExternalMemory(shared->memory);
    }
    if (shared->semaphore != NULL) {
        cudaDestroyExternalSemaphore(shared->semaphore);
    }
    if (shared->buffer.id != 0) {
        rlv_buffer_release(shared->buffer);
    }
}

/* Copies the first points to memory of CUDA's own, behind the update. 0 if something fails. */
int copy_points(RlvContext context, const Exported *exported, RlvTessellation tessellation, float *target, size_t count,
                cudaStream_t stream) {
    Shared shared;
    const int copied = share_points(exported, tessellation, &shared) && points_ready(context, exported, &shared, stream) &&
                       cudaMemcpyAsync(target, shared.points, 24 * count, cudaMemcpyDeviceToDevice, stream) == cudaSuccess &&
                       cudaStreamSynchronize(stream) == cudaSuccess;
    end_sharing(&shared);
    return copied;
}
