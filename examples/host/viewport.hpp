// A viewport on the host's own Vulkan device: the triangles of objects in buffers of the host, drawn by its own render pass
// to an image off screen.
#pragma once

#include "object.hpp"
#include "picture.hpp"
#include "vulkan_device.hpp"

namespace studio {

class Viewport {
public:
    /// `context` is that of the objects. If it works on `device`, the library writes the buffers itself; if it works on the
    /// processor, the host copies what that made.
    Viewport(VulkanDevice &device, const relievo::Context &context, unsigned width, unsigned height);
    ~Viewport();
    Viewport(const Viewport &) = delete;
    Viewport &operator=(const Viewport &) = delete;

    /// Points that were written to buffers, and all there are.
    struct Written {
        std::size_t points, all;
    };

    /// Brings the buffers to what objects show now. Objects keep their order; new ones come after them. What did not
    /// change since the last time is not written again.
    Written follow(const std::vector<Object> &objects);

    /// Draws, and waits for the picture.
    Picture draw(const Camera &camera);

private:
    /// The buffers of an object, and what follows its commits.
    struct Shown {
        relievo::Matrix place;
        relievo::Tessellation triangles;
        std::size_t triangle_count;
        /// Positions and normals; numbers of points; colours.
        VulkanBuffer points, corners, colors;
        /// What writes the first two on the device; nothing where the host copies.
        relievo::Buffer written;
    };

    void make_pass();
    void make_pipeline();
    std::unique_ptr<Shown> show(const Object &object) const;
    /// Copies what the library does not write.
    void copy(const Shown &shown, const std::vector<relievo::Tessellation::Range> &ranges) const;
    void record(const Camera &camera) const;
    /// Waits until all that was begun is done.
    void wait() const;

    VulkanDevice &device_;
    const relievo::Context context_;
    const bool on_device_;
    const VkExtent2D extent_;
    VulkanImage color_, depth_;
    VulkanBuffer pixels_;
    VkRenderPass pass_ = VK_NULL_HANDLE;
    VkFramebuffer frame_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer commands_ = VK_NULL_HANDLE;
    /// A timeline semaphore and its last value: writing to buffers and drawing from them take turns by it.
    VkSemaphore turn_ = VK_NULL_HANDLE;
    std::uint64_t turns_ = 0;
    std::vector<std::unique_ptr<Shown>> shown_;
};

} // namespace studio
