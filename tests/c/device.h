/* A Vulkan device of the host for the tests, and a lock for its queue. */
#ifndef DEVICE_H
#define DEVICE_H

#include "check.h"

#include <pthread.h>
#include <vulkan/vulkan.h>

#define CHECK_VK(call) CHECK((call) == VK_SUCCESS)

typedef struct HostDevice {
    VkInstance instance;
    VkPhysicalDevice physical;
    VkDevice device;
    VkQueue queue;
    VkCommandPool pool;
    VkPhysicalDeviceFeatures features;
    uint32_t family;
    pthread_mutex_t mutex;
    int locked;   /* times that the library locked, under the mutex */
    int held;     /* whether the library has the lock, under the mutex */
    int released; /* calls of `released` */
} HostDevice;

static inline void host_lock(void *user) {
    HostDevice *host = user;
    pthread_mutex_lock(&host->mutex);
    CHECK(host->held == 0);
    host->held = 1;
    host->locked += 1;
}

static inline void host_unlock(void *user) {
    HostDevice *host = user;
    CHECK(host->held == 1);
    host->held = 0;
    pthread_mutex_unlock(&host->mutex);
}

static inline void host_released(void *user) { ((HostDevice *)user)->released += 1; }

static inline uint64_t host_handle(const void *object) { return (uint64_t)(uintptr_t)object; }

/* A device with timeline semaphores on the last physical device, which is the processor's where it is one. 0 if there is
 * no physical device. */
static inline int host_open(HostDevice *host) {
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_2};
    const VkInstanceCreateInfo instance = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                           .pApplicationInfo = &application};
    const float priority = 1.0f;
    memset(host, 0, sizeof *host);
    if (vkCreateInstance(&instance, NULL, &host->instance) != VK_SUCCESS) {
        return 0;
    }
    VkPhysicalDevice devices[16];
    VkQueueFamilyProperties families[16];
    uint32_t count = 16, family_count = 16;
    vkEnumeratePhysicalDevices(host->instance, &count, devices);
    if (count == 0) {
        vkDestroyInstance(host->instance, NULL);
        return 0;
    }
    host->physical = devices[count - 1];
    const VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    vkGetPhysicalDeviceQueueFamilyProperties(host->physical, &family_count, families);
    while (host->family < family_count && (families[host->family].queueFlags & wanted) != wanted) {
        host->family += 1;
    }
    CHECK(host->family < family_count);
    host->features.robustBufferAccess = VK_TRUE;
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = host->family,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
    const VkPhysicalDeviceTimelineSemaphoreFeatures timeline = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES, .timelineSemaphore = VK_TRUE};
    const VkDeviceCreateInfo device = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                       .pNext = &timeline,
                                       .queueCreateInfoCount = 1,
                                       .pQueueCreateInfos = &queue,
                                       .pEnabledFeatures = &host->features};
    CHECK_VK(vkCreateDevice(host->physical, &device, NULL, &host->device));
    vkGetDeviceQueue(host->device, host->family, 0, &host->queue);
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .queueFamilyIndex = host->family};
    CHECK_VK(vkCreateCommandPool(host->device, &pool, NULL, &host->pool));
    CHECK(pthread_mutex_init(&host->mutex, NULL) == 0);
    return 1;
}

static inline void host_close(HostDevice *host) {
    vkDestroyCommandPool(host->device, host->pool, NULL);
    vkDestroyDevice(host->device, NULL);
    vkDestroyInstance(host->instance, NULL);
    pthread_mutex_destroy(&host->mutex);
}

/* What the library hears of it. */
static inline RlvVulkanDevice host_described(HostDevice *host) {
    RlvVulkanDevice described = RLV_VULKAN_DEVICE_INIT;
    described.api_version = VK_API_VERSION_1_2;
    described.queue_family = host->family;
    described.instance = host_handle(host->instance);
    described.physical_device = host_handle(host->physical);
    described.device = host_handle(host->device);
    described.loader = (RlvVulkanLoader)vkGetInstanceProcAddr;
    described.features = &host->features;
    described.lock = host_lock;
    described.unlock = host_unlock;
    described.released = host_released;
    described.user = host;
    return described;
}

/* A buffer of the host with memory that the host sees. */
typedef struct HostBuffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    VkDeviceSize bytes;
    void *seen;
} HostBuffer;

static inline HostBuffer host_buffer(HostDevice *host, VkDeviceSize bytes) {
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                     .size = bytes,
                                     .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT};
    const VkMemoryPropertyFlags wanted = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    HostBuffer made = {.bytes = bytes};
    VkMemoryRequirements needed;
    VkPhysicalDeviceMemoryProperties types;
    uint32_t type = 0;
    CHECK_VK(vkCreateBuffer(host->device, &info, NULL, &made.buffer));
    vkGetBufferMemoryRequirements(host->device, made.buffer, &needed);
    vkGetPhysicalDeviceMemoryProperties(host->physical, &types);
    while (type < types.memoryTypeCount && ((needed.memoryTypeBits >> type & 1) == 0 ||
                                            (types.memoryTypes[type].propertyFlags & wanted) != wanted)) {
        type += 1;
    }
    CHECK(type < types.memoryTypeCount);
    const VkMemoryAllocateInfo memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                         .allocationSize = needed.size,
                                         .memoryTypeIndex = type};
    CHECK_VK(vkAllocateMemory(host->device, &memory, NULL, &made.memory));
    CHECK_VK(vkBindBufferMemory(host->device, made.buffer, made.memory, 0));
    CHECK_VK(vkMapMemory(host->device, made.memory, 0, VK_WHOLE_SIZE, 0, &made.seen));
    return made;
}

static inline void host_free(HostDevice *host, HostBuffer *buffer) {
    vkDestroyBuffer(host->device, buffer->buffer, NULL);
    vkFreeMemory(host->device, buffer->memory, NULL);
}

static inline VkSemaphore host_semaphore(HostDevice *host, VkSemaphoreType type) {
    const VkSemaphoreTypeCreateInfo kind = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO, .semaphoreType = type};
    const VkSemaphoreCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &kind};
    VkSemaphore made = VK_NULL_HANDLE;
    CHECK_VK(vkCreateSemaphore(host->device, &info, NULL, &made));
    return made;
}

/* Destroys a semaphore once the queue is idle: Mesa 22.3 still reads a timeline semaphore that a batch waited for after the
 * fence of that batch is signalled. */
static inline void host_end_semaphore(HostDevice *host, VkSemaphore semaphore) {
    pthread_mutex_lock(&host->mutex);
    CHECK_VK(vkQueueWaitIdle(host->queue));
    pthread_mutex_unlock(&host->mutex);
    vkDestroySemaphore(host->device, semaphore, NULL);
}

/* Copies the beginning of a buffer by a command buffer of the host, which waits for the semaphore, a timeline semaphore until
 * it has value, and signals another one; either may be VK_NULL_HANDLE. Returns when it is done. */
static inline void host_copy(HostDevice *host, VkBuffer from, const HostBuffer *to, VkDeviceSize bytes, VkSemaphore wait,
                             uint64_t value, VkSemaphore signal) {
    const VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                              .commandPool = host->pool,
                                              .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                              .commandBufferCount = 1};
    const VkCommandBufferBeginInfo once = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                           .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    const VkBufferCopy region = {0, 0, bytes};
    const VkMemoryBarrier seen = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                  .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                  .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_TRANSFER_BIT;
    const uint64_t none = 0;
    const VkTimelineSemaphoreSubmitInfo values = {.sType = VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO,
                                                  .waitSemaphoreValueCount = wait != VK_NULL_HANDLE,
                                                  .pWaitSemaphoreValues = &value,
                                                  .signalSemaphoreValueCount = signal != VK_NULL_HANDLE,
                                                  .pSignalSemaphoreValues = &none};
    const VkFenceCreateInfo plain = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VkCommandBuffer commands;
    VkFence fence;
    CHECK(bytes <= to->bytes);
    CHECK_VK(vkAllocateCommandBuffers(host->device, &info, &commands));
    CHECK_VK(vkCreateFence(host->device, &plain, NULL, &fence));
    CHECK_VK(vkBeginCommandBuffer(commands, &once));
    vkCmdCopyBuffer(commands, from, to->buffer, 1, &region);
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &seen, 0, NULL, 0,
                         NULL);
    CHECK_VK(vkEndCommandBuffer(commands));
    const VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                                 .pNext = &values,
                                 .waitSemaphoreCount = wait != VK_NULL_HANDLE,
                                 .pWaitSemaphores = &wait,
                                 .pWaitDstStageMask = &stage,
                                 .commandBufferCount = 1,
                                 .pCommandBuffers = &commands,
                                 .signalSemaphoreCount = signal != VK_NULL_HANDLE,
                                 .pSignalSemaphores = &signal};
    pthread_mutex_lock(&host->mutex);
    CHECK_VK(vkQueueSubmit(host->queue, 1, &submit, fence));
    pthread_mutex_unlock(&host->mutex);
    CHECK_VK(vkWaitForFences(host->device, 1, &fence, VK_TRUE, UINT64_MAX));
    vkDestroyFence(host->device, fence, NULL);
    vkFreeCommandBuffers(host->device, host->pool, 1, &commands);
}

#endif
