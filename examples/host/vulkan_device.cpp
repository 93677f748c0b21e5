#include "vulkan_device.hpp"

#include <stdexcept>
#include <string>
#include <vector>

namespace studio {

namespace {

/// A handle of Vulkan as the library takes it.
std::uint64_t number(const void *handle) { return static_cast<std::uint64_t>(reinterpret_cast<std::uintptr_t>(handle)); }

VkDeviceMemory allocate(const VulkanDevice &device, const VkMemoryRequirements &needed, VkMemoryPropertyFlags properties) {
    auto info = structure<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
    info.allocationSize = needed.size;
    info.memoryTypeIndex = device.memory_type(needed.memoryTypeBits, properties);
    VkDeviceMemory memory = VK_NULL_HANDLE;
    check(vkAllocateMemory(device.get(), &info, nullptr, &memory), "vkAllocateMemory");
    return memory;
}

} // namespace

void check(VkResult result, const char *call) {
    if (result != VK_SUCCESS) {
        throw std::runtime_error(std::string(call) + " returns " + std::to_string(result));
    }
}

std::unique_ptr<VulkanDevice> VulkanDevice::open() {
    std::unique_ptr<VulkanDevice> made(new VulkanDevice);
    auto application = structure<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
    application.apiVersion = VK_API_VERSION_1_2;
    auto instance = structure<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
    instance.pApplicationInfo = &application;
    if (vkCreateInstance(&instance, nullptr, &made->instance_) != VK_SUCCESS) {
        return nullptr;
    }
    std::uint32_t count = 0;
    vkEnumeratePhysicalDevices(made->instance_, &count, nullptr);
    std::vector<VkPhysicalDevice> devices(count);
    vkEnumeratePhysicalDevices(made->instance_, &count, devices.data());
    if (count == 0) {
        return nullptr;
    }
    made->physical_ = devices[count - 1];
    vkGetPhysicalDeviceQueueFamilyProperties(made->physical_, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(made->physical_, &count, families.data());
    const VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    while (made->family_ < count && (families[made->family_].queueFlags & wanted) != wanted) {
        ++made->family_;
    }
    if (made->family_ == count) {
        return nullptr;
    }
    const float priority = 1.0f;
    auto queue = structure<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
    queue.queueFamilyIndex = made->family_;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    auto timeline = structure<VkPhysicalDeviceTimelineSemaphoreFeatures>(
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES);
    timeline.timelineSemaphore = VK_TRUE;
    auto device = structure<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
    device.pNext = &timeline;
    device.queueCreateInfoCount = 1;
    device.pQueueCreateInfos = &queue;
    device.pEnabledFeatures = &made->features_;
    check(vkCreateDevice(made->physical_, &device, nullptr, &made->device_), "vkCreateDevice");
    vkGetDeviceQueue(made->device_, made->family_, 0, &made->queue_);
    return made;
}

VulkanDevice::~VulkanDevice() {
    std::unique_lock<std::mutex> guard(contexts_lock_);
    released_.wait(guard, [this] { return contexts_ == 0; });
    vkDestroyDevice(device_, nullptr);
    vkDestroyInstance(instance_, nullptr);
}

relievo::Context VulkanDevice::context(const RlvContextOptions &options) {
    RlvVulkanDevice described = RLV_VULKAN_DEVICE_INIT;
    described.api_version = VK_API_VERSION_1_2;
    described.queue_family = family_;
    described.instance = number(instance_);
    described.physical_device = number(physical_);
    described.device = number(device_);
    described.loader = reinterpret_cast<RlvVulkanLoader>(vkGetInstanceProcAddr);
    described.features = &features_;
    described.lock = [](void *user) { static_cast<VulkanDevice *>(user)->queue_lock_.lock(); };
    described.unlock = [](void *user) { static_cast<VulkanDevice *>(user)->queue_lock_.unlock(); };
    described.released = [](void *user) {
        auto &device = *static_cast<VulkanDevice *>(user);
        const std::lock_guard<std::mutex> guard(device.contexts_lock_);
        --device.contexts_;
        // Under the lock, since the device may be gone right after it.
        device.released_.notify_all();
    };
    described.user = this;
    auto made = relievo::Context::create(described, options);
    const std::lock_guard<std::mutex> guard(contexts_lock_);
    ++contexts_;
    return made;
}

void VulkanDevice::submit(const VkSubmitInfo &work) {
    const std::lock_guard<std::mutex> guard(queue_lock_);
    check(vkQueueSubmit(queue_, 1, &work, VK_NULL_HANDLE), "vkQueueSubmit");
}

void VulkanDevice::wait_idle() {
    const std::lock_guard<std::mutex> guard(queue_lock_);
    vkDeviceWaitIdle(device_);
}

std::uint32_t VulkanDevice::memory_type(std::uint32_t types, VkMemoryPropertyFlags properties) const {
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(physical_, &memory);
    for (std::uint32_t type = 0; type < memory.memoryTypeCount; ++type) {
        if ((types >> type & 1) != 0 && (memory.memoryTypes[type].propertyFlags & properties) == properties) {
            return type;
        }
    }
    throw std::runtime_error("the Vulkan device has no such memory");
}

VulkanBuffer::VulkanBuffer(const VulkanDevice &device, VkDeviceSize bytes, VkBufferUsageFlags usage)
    : device_(device.get()), bytes_(bytes) {
    auto info = structure<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
    info.size = bytes;
    info.usage = usage;
    check(vkCreateBuffer(device_, &info, nullptr, &buffer_), "vkCreateBuffer");
    VkMemoryRequirements needed;
    vkGetBufferMemoryRequirements(device_, buffer_, &needed);
    memory_ = allocate(device, needed, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    check(vkBindBufferMemory(device_, buffer_, memory_, 0), "vkBindBufferMemory");
    check(vkMapMemory(device_, memory_, 0, VK_WHOLE_SIZE, 0, &seen_), "vkMapMemory");
}

VulkanBuffer::~VulkanBuffer() {
    vkDestroyBuffer(device_, buffer_, nullptr);
    vkFreeMemory(device_, memory_, nullptr);
}

VulkanImage::VulkanImage(const VulkanDevice &device, VkExtent2D extent, VkFormat format, VkImageUsageFlags usage,
                         VkImageAspectFlags aspect)
    : device_(device.get()) {
    auto info = structure<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = {extent.width, extent.height, 1};
    info.mipLevels = 1;
    info.arrayLayers = 1;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.tiling = VK_IMAGE_TILING_OPTIMAL;
    info.usage = usage;
    check(vkCreateImage(device_, &info, nullptr, &image_), "vkCreateImage");
    VkMemoryRequirements needed;
    vkGetImageMemoryRequirements(device_, image_, &needed);
    memory_ = allocate(device, needed, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    check(vkBindImageMemory(device_, image_, memory_, 0), "vkBindImageMemory");
    auto view = structure<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
    view.image = image_;
    view.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view.format = format;
    view.subresourceRange = {aspect, 0, 1, 0, 1};
    check(vkCreateImageView(device_, &view, nullptr, &view_), "vkCreateImageView");
}

VulkanImage::~VulkanImage() {
    vkDestroyImageView(device_, view_, nullptr);
    vkDestroyImage(device_, image_, nullptr);
    vkFreeMemory(device_, memory_, nullptr);
}

} // namespace studio
