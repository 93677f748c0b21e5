// A Vulkan device of the host, for its viewport, on which the library may work too.
#pragma once

#include <relievo/relievo.hpp>

#include <vulkan/vulkan.h>

#include <condition_variable>
#include <memory>
#include <mutex>

namespace studio {

/// Fails where a call of Vulkan does.
void check(VkResult result, const char *call);

/// A structure of Vulkan, zero but for its type.
template <class Structure> Structure structure(VkStructureType type) {
    Structure made{};
    made.sType = type;
    return made;
}

class VulkanDevice {
public:
    /// Opens the last physical device, which is the processor's where it is one; nothing without a driver.
    static std::unique_ptr<VulkanDevice> open();
    /// Waits until the library has let go of the device.
    ~VulkanDevice();
    VulkanDevice(const VulkanDevice &) = delete;
    VulkanDevice &operator=(const VulkanDevice &) = delete;

    /// A context of the library on this device.
    relievo::Context context(const RlvContextOptions &options);

    /// Submits to the queue, which the library uses too.
    void submit(const VkSubmitInfo &work);

    /// Waits until all that was submitted is done.
    void wait_idle();

    VkDevice get() const { return device_; }
    std::uint32_t family() const { return family_; }

    /// The first type of memory among `types`, bits, that has the properties.
    std::uint32_t memory_type(std::uint32_t types, VkMemoryPropertyFlags properties) const;

private:
    VulkanDevice() = default;

    VkInstance instance_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    VkPhysicalDeviceFeatures features_{};
    std::uint32_t family_ = 0;
    std::mutex queue_lock_;
    std::mutex contexts_lock_;
    std::condition_variable released_;
    std::size_t contexts_ = 0;
};

/// A buffer with memory that the processor sees.
class VulkanBuffer {
public:
    VulkanBuffer(const VulkanDevice &device, VkDeviceSize bytes, VkBufferUsageFlags usage);
    ~VulkanBuffer();
    VulkanBuffer(const VulkanBuffer &) = delete;
    VulkanBuffer &operator=(const VulkanBuffer &) = delete;

    VkBuffer get() const { return buffer_; }
    VkDeviceSize bytes() const { return bytes_; }
    void *seen() const { return seen_; }

private:
    VkDevice device_;
    VkDeviceSize bytes_;
    VkBuffer buffer_ = VK_NULL_HANDLE;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
    void *seen_ = nullptr;
};

/// An image that is drawn to, and its view.
class VulkanImage {
public:
    VulkanImage(const VulkanDevice &device, VkExtent2D extent, VkFormat format, VkImageUsageFlags usage,
                VkImageAspectFlags aspect);
    ~VulkanImage();
    VulkanImage(const VulkanImage &) = delete;
    VulkanImage &operator=(const VulkanImage &) = delete;

    VkImage get() const { return image_; }
    VkImageView view() const { return view_; }

private:
    VkDevice device_;
    VkImage image_ = VK_NULL_HANDLE;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
    VkImageView view_ = VK_NULL_HANDLE;
};

} // namespace studio
