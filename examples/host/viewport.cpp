#include "viewport.hpp"

#include "viewport_shader.hpp"

#include <cstring>

namespace studio {

namespace {

const VkFormat COLOR = VK_FORMAT_R32G32B32A32_SFLOAT, DEPTH = VK_FORMAT_D32_SFLOAT;
const VkDeviceSize POINT_BYTES = 6 * sizeof(float), COLOR_BYTES = 3 * sizeof(float);
/// Nothing nearer to the camera is seen.
const float NEAR = 0.05f;

/// What the shader takes for an object, as viewport.wgsl has it: column by column, each of four floats.
struct Placed {
    float clip[4][4], turn[3][4];
};

Placed placed(const relievo::Matrix &place, const Camera &camera, VkExtent2D extent) {
    const auto [ahead, right, up] = camera.axes();
    const float across = 2.0f / camera.width;
    const float down = -across * static_cast<float>(extent.width) / static_cast<float>(extent.height);
    Placed made{};
    for (std::size_t column = 0; column < 4; ++column) {
        Vec image{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            image[axis] = static_cast<float>(place[3 * column + axis]);
            if (column < 3) {
                made.turn[column][axis] = image[axis];
            }
        }
        const Vec seen = column < 3 ? image : image - camera.eye;
        made.clip[column][0] = across * dot(right, seen);
        made.clip[column][1] = down * dot(up, seen);
        made.clip[column][3] = dot(ahead, seen);
    }
    // Depth is NEAR over the distance: 1 at NEAR, 0 far away.
    made.clip[3][2] = NEAR;
    return made;
}

RlvTessellateOptions cells() {
    RlvTessellateOptions options = RLV_TESSELLATE_OPTIONS_INIT;
    // As many everywhere, so that no edit changes the number of points.
    options.coarse = options.fine = 64;
    return options;
}

} // namespace

Viewport::Viewport(VulkanDevice &device, const relievo::Context &context, unsigned width, unsigned height)
    : device_(device), context_(context), on_device_(context.info().device == RLV_DEVICE_GPU), extent_{width, height},
      color_(device, extent_, COLOR, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
             VK_IMAGE_ASPECT_COLOR_BIT),
      depth_(device, extent_, DEPTH, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_ASPECT_DEPTH_BIT),
      pixels_(device, VkDeviceSize{4 * sizeof(float)} * width * height, VK_BUFFER_USAGE_TRANSFER_DST_BIT) {
    make_pass();
    make_pipeline();
    auto pool = structure<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
    pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    pool.queueFamilyIndex = device.family();
    check(vkCreateCommandPool(device.get(), &pool, nullptr, &pool_), "vkCreateCommandPool");
    auto commands = structure<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
    commands.commandPool = pool_;
    commands.commandBufferCount = 1;
    check(vkAllocateCommandBuffers(device.get(), &commands, &commands_), "vkAllocateCommandBuffers");
    auto kind = structure<VkSemaphoreTypeCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO);
    kind.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    auto semaphore = structure<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO);
    semaphore.pNext = &kind;
    check(vkCreateSemaphore(device.get(), &semaphore, nullptr, &turn_), "vkCreateSemaphore");
}

Viewport::~Viewport() {
    device_.wait_idle();
    vkDestroySemaphore(device_.get(), turn_, nullptr);
    vkDestroyCommandPool(device_.get(), pool_, nullptr);
    vkDestroyPipeline(device_.get(), pipeline_, nullptr);
    vkDestroyPipelineLayout(device_.get(), layout_, nullptr);
    vkDestroyFramebuffer(device_.get(), frame_, nullptr);
    vkDestroyRenderPass(device_.get(), pass_, nullptr);
}

void Viewport::make_pass() {
    VkAttachmentDescription attachments[2]{};
    attachments[0].format = COLOR;
    attachments[0].storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    attachments[0].finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    attachments[1].format = DEPTH;
    attachments[1].storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    attachments[1].finalLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    for (VkAttachmentDescription &attachment : attachments) {
        attachment.samples = VK_SAMPLE_COUNT_1_BIT;
        attachment.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
        attachment.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
        attachment.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    }
    const VkAttachmentReference color{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    const VkAttachmentReference depth{1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    VkSubpassDescription drawing{};
    drawing.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
    drawing.colorAttachmentCount = 1;
    drawing.pColorAttachments = &color;
    drawing.pDepthStencilAttachment = &depth;
    // The copy to the processor comes after the drawing.
    VkSubpassDependency copied{};
    copied.srcSubpass = 0;
    copied.dstSubpass = VK_SUBPASS_EXTERNAL;
    copied.srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    copied.dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT;
    copied.srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    copied.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
    auto pass = structure<VkRenderPassCreateInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO);
    pass.attachmentCount = 2;
    pass.pAttachments = attachments;
    pass.subpassCount = 1;
    pass.pSubpasses = &drawing;
    pass.dependencyCount = 1;
    pass.pDependencies = &copied;
    check(vkCreateRenderPass(device_.get(), &pass, nullptr, &pass_), "vkCreateRenderPass");
    const VkImageView views[] = {color_.view(), depth_.view()};
    auto frame = structure<VkFramebufferCreateInfo>(VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO);
    frame.renderPass = pass_;
    frame.attachmentCount = 2;
    frame.pAttachments = views;
    frame.width = extent_.width;
    frame.height = extent_.height;
    frame.layers = 1;
    check(vkCreateFramebuffer(device_.get(), &frame, nullptr, &frame_), "vkCreateFramebuffer");
}

void Viewport::make_pipeline() {
    const VkPushConstantRange range{VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(Placed)};
    auto layout = structure<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &range;
    check(vkCreatePipelineLayout(device_.get(), &layout, nullptr, &layout_), "vkCreatePipelineLayout");

    auto code = structure<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
    code.codeSize = sizeof VIEWPORT_SHADER;
    code.pCode = VIEWPORT_SHADER;
    VkShaderModule shader = VK_NULL_HANDLE;
    check(vkCreateShaderModule(device_.get(), &code, nullptr, &shader), "vkCreateShaderModule");
    auto stage = structure<VkPipelineShaderStageCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO);
    stage.module = shader;
    VkPipelineShaderStageCreateInfo stages[] = {stage, stage};
    stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
    stages[0].pName = "point";
    stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
    stages[1].pName = "light";

    const VkVertexInputBindingDescription bindings[] = {{0, POINT_BYTES, VK_VERTEX_INPUT_RATE_VERTEX},
                                                        {1, COLOR_BYTES, VK_VERTEX_INPUT_RATE_VERTEX}};
    const VkVertexInputAttributeDescription attributes[] = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0},
                                                            {1, 0, VK_FORMAT_R32G32B32_SFLOAT, 3 * sizeof(float)},
                                                            {2, 1, VK_FORMAT_R32G32B32_SFLOAT, 0}};
    auto vertices = structure<VkPipelineVertexInputStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO);
    vertices.vertexBindingDescriptionCount = 2;
    vertices.pVertexBindingDescriptions = bindings;
    vertices.vertexAttributeDescriptionCount = 3;
    vertices.pVertexAttributeDescriptions = attributes;
    auto assembly = structure<VkPipelineInputAssemblyStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO);
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    const VkViewport view{0, 0, static_cast<float>(extent_.width), static_cast<float>(extent_.height), 0, 1};
    const VkRect2D all{{0, 0}, extent_};
    auto views = structure<VkPipelineViewportStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO);
    views.viewportCount = views.scissorCount = 1;
    views.pViewports = &view;
    views.pScissors = &all;
    auto raster = structure<VkPipelineRasterizationStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO);
    raster.lineWidth = 1.0f;
    auto samples = structure<VkPipelineMultisampleStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO);
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    auto depth = structure<VkPipelineDepthStencilStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO);
    depth.depthTestEnable = depth.depthWriteEnable = VK_TRUE;
    depth.depthCompareOp = VK_COMPARE_OP_GREATER;
    VkPipelineColorBlendAttachmentState opaque{};
    opaque.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
    auto blend = structure<VkPipelineColorBlendStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO);
    blend.attachmentCount = 1;
    blend.pAttachments = &opaque;
    auto info = structure<VkGraphicsPipelineCreateInfo>(VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO);
    info.stageCount = 2;
    info.pStages = stages;
    info.pVertexInputState = &vertices;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &views;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blend;
    info.layout = layout_;
    info.renderPass = pass_;
    const VkResult result = vkCreateGraphicsPipelines(device_.get(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_);
    vkDestroyShaderModule(device_.get(), shader, nullptr);
    check(result, "vkCreateGraphicsPipelines");
}

std::unique_ptr<Viewport::Shown> Viewport::show(const Object &object) const {
    auto triangles = relievo::Tessellation::create(object.detail, cells());
    const RlvTessellationInfo info = triangles.info();
    // The library copies to the first two, and reads them back where it is asked for points.
    const VkBufferUsageFlags library = VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    const VkBufferUsageFlags vertices = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
    std::unique_ptr<Shown> made(
        new Shown{object.place, triangles, info.triangle_count,
                  {device_, POINT_BYTES * info.point_count, vertices | library},
                  {device_, 3 * sizeof(std::uint32_t) * info.triangle_count, VK_BUFFER_USAGE_INDEX_BUFFER_BIT | library},
                  {device_, COLOR_BYTES * info.point_count, vertices}, {}});
    if (on_device_) {
        RlvVulkanBuffers buffers = RLV_VULKAN_BUFFERS_INIT;
        buffers.points = reinterpret_cast<std::uint64_t>(made->points.get());
        buffers.point_bytes = made->points.bytes();
        buffers.triangles = reinterpret_cast<std::uint64_t>(made->corners.get());
        buffers.triangle_bytes = made->corners.bytes();
        made->written = relievo::Buffer::create(triangles, buffers);
    } else {
        const std::vector<std::uint32_t> corners = triangles.mesh().corners();
        std::memcpy(made->corners.seen(), corners.data(), corners.size() * sizeof(std::uint32_t));
    }
    copy(*made, {{0, static_cast<std::uint32_t>(info.point_count)}});
    return made;
}

void Viewport::copy(const Shown &shown, const std::vector<relievo::Tessellation::Range> &ranges) const {
    auto *const points = static_cast<float *>(shown.points.seen());
    auto *const colors = static_cast<float *>(shown.colors.seen());
    for (const auto [first, count] : ranges) {
        if (!on_device_) {
            float *const at = points + std::size_t{6} * first;
            relievo::check(rlv_tessellation_get_points(shown.triangles.get(), first, count, at, POINT_BYTES, at + 3, POINT_BYTES));
        }
        relievo::check(rlv_tessellation_get_colors(shown.triangles.get(), first, count, colors + std::size_t{3} * first, 0));
    }
}

Viewport::Written Viewport::follow(const std::vector<Object> &objects) {
    Written written{0, 0};
    std::vector<std::vector<relievo::Tessellation::Range>> ranges;
    for (std::size_t k = 0; k < shown_.size(); ++k) {
        written.points += shown_[k]->triangles.update().point_count;
        ranges.push_back(shown_[k]->triangles.changed_ranges());
        shown_[k]->place = objects[k].place;
    }
    if (on_device_) {
        context_.wait(reinterpret_cast<std::uint64_t>(turn_), turns_);
        for (std::size_t k = 0; k < ranges.size(); ++k) {
            if (!ranges[k].empty()) {
                shown_[k]->written.update();
            }
        }
    }
    for (std::size_t k = 0; k < ranges.size(); ++k) {
        copy(*shown_[k], ranges[k]);
    }
    while (shown_.size() < objects.size()) {
        shown_.push_back(show(objects[shown_.size()]));
        written.points += shown_.back()->triangles.info().point_count;
    }
    if (on_device_) {
        context_.signal(reinterpret_cast<std::uint64_t>(turn_), ++turns_);
    }
    for (const auto &shown : shown_) {
        written.all += shown->triangles.info().point_count;
    }
    return written;
}

void Viewport::record(const Camera &camera) const {
    auto once = structure<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
    once.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(commands_, &once), "vkBeginCommandBuffer");
    VkClearValue clear[2]{};
    clear[0].color = {{0.22f, 0.3f, 0.43f, 0.0f}};
    auto pass = structure<VkRenderPassBeginInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO);
    pass.renderPass = pass_;
    pass.framebuffer = frame_;
    pass.renderArea = {{0, 0}, extent_};
    pass.clearValueCount = 2;
    pass.pClearValues = clear;
    vkCmdBeginRenderPass(commands_, &pass, VK_SUBPASS_CONTENTS_INLINE);
    vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
    for (const auto &shown : shown_) {
        const Placed place = placed(shown->place, camera, extent_);
        const VkBuffer vertices[] = {shown->points.get(), shown->colors.get()};
        const VkDeviceSize offsets[] = {0, 0};
        vkCmdPushConstants(commands_, layout_, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof place, &place);
        vkCmdBindVertexBuffers(commands_, 0, 2, vertices, offsets);
        vkCmdBindIndexBuffer(commands_, shown->corners.get(), 0, VK_INDEX_TYPE_UINT32);
        vkCmdDrawIndexed(commands_, static_cast<std::uint32_t>(3 * shown->triangle_count), 1, 0, 0, 0);
    }
    vkCmdEndRenderPass(commands_);
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {extent_.width, extent_.height, 1};
    vkCmdCopyImageToBuffer(commands_, color_.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, pixels_.get(), 1, &region);
    auto seen = structure<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
    seen.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    seen.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(commands_, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &seen, 0, nullptr, 0, nullptr);
    check(vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
}

Picture Viewport::draw(const Camera &camera) {
    record(camera);
    const std::uint64_t written = turns_, drawn = turns_ + 1;
    auto values = structure<VkTimelineSemaphoreSubmitInfo>(VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO);
    values.waitSemaphoreValueCount = values.signalSemaphoreValueCount = 1;
    values.pWaitSemaphoreValues = &written;
    values.pSignalSemaphoreValues = &drawn;
    const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_VERTEX_INPUT_BIT;
    auto work = structure<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
    work.pNext = &values;
    work.waitSemaphoreCount = work.commandBufferCount = work.signalSemaphoreCount = 1;
    work.pWaitSemaphores = work.pSignalSemaphores = &turn_;
    work.pWaitDstStageMask = &stage;
    work.pCommandBuffers = &commands_;
    device_.submit(work);
    turns_ = drawn;
    wait();
    const std::size_t count = std::size_t{extent_.width} * extent_.height;
    const auto *const pixels = static_cast<const std::array<float, 4> *>(pixels_.seen());
    Picture picture{extent_.width, extent_.height, {}, {}};
    for (std::size_t k = 0; k < count; ++k) {
        picture.pixels.push_back({pixels[k][0], pixels[k][1], pixels[k][2]});
        picture.covered.push_back(pixels[k][3] > 0.5f);
    }
    return picture;
}

void Viewport::wait() const {
    auto info = structure<VkSemaphoreWaitInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO);
    info.semaphoreCount = 1;
    info.pSemaphores = &turn_;
    info.pValues = &turns_;
    check(vkWaitSemaphores(device_.get(), &info, UINT64_MAX), "vkWaitSemaphores");
}

} // namespace studio
