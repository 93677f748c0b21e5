/* Relievo: device crowds, crowds that a graphics device cuts into the arguments of indirect draws in its memory.
 *
 * A device crowd makes the draws of rlv_crowd_cut (crowd.h) on the device of the crowd's context, in the same order, for the
 * agents that the crowd has at that time. The host sends what changed and eight bytes an agent for its pose; skin matrices of
 * all poses of all clips stay on the device. Where a device rounds square roots otherwise, an agent at the limit of two steps
 * may take the other one. Pictures of impostors are made by the processor when they are first needed. Who may use its Vulkan
 * objects, and when, is as in buffer.h; each cut may make new ones where there are more agents, weights or draws. */
#ifndef RELIEVO_DEVICE_CROWD_H
#define RELIEVO_DEVICE_CROWD_H

#include "relievo/crowd.h"

typedef struct RlvDeviceCrowd {
    uint64_t id;
} RlvDeviceCrowd;

/* Counts of the last cut, and of what the device has of all poses. */
typedef struct RlvDeviceCrowdInfo {
    uint32_t struct_size;
    uint32_t agent_count; /* in view, without impostors: instances */
    uint32_t draw_count;
    uint32_t matrix_count; /* of all poses of all clips of all models: one for each bone of each pose */
    uint32_t weight_count; /* of the same poses, one for each morph target of each pose; then those agents have of their own */
    uint32_t impostor_count; /* agents that are quads */
    uint32_t picture_count;  /* of impostors, which share those of equal poses and directions */
    uint32_t hidden;         /* agents in view that others hide, which have no draws */
    uint64_t hidden_triangles;   /* of hidden agents and clusters */
    uint64_t occluder_triangles; /* that were drawn into depths to find what is hidden; 0 where that rested */
    uint32_t hidden_clusters;    /* of agents that others hide in part, whose draws have no instances */
    uint32_t reserved;
} RlvDeviceCrowdInfo;

#define RLV_DEVICE_CROWD_INFO_INIT {sizeof(RlvDeviceCrowdInfo), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}

/* Vulkan objects: dispatchable ones as pointers in 64 bits, others unchanged. */
typedef struct RlvDeviceCrowdVulkan {
    uint32_t struct_size;
    uint32_t queue_family;    /* index of the family of the queue */
    uint32_t queue_index;     /* index of the queue in its family */
    uint32_t reserved;        /* 0 */
    uint64_t instance;        /* VkInstance */
    uint64_t physical_device; /* VkPhysicalDevice */
    uint64_t device;          /* VkDevice */
    uint64_t queue;           /* VkQueue */
    uint64_t draws;           /* VkBuffer: VkDrawIndexedIndirectCommand, as RlvCrowdDraw; those after the last are 0 */
    uint64_t clusters;        /* VkBuffer: model and cluster of each draw, two numbers of 4 bytes */
    uint64_t instances;       /* VkBuffer, 64 bytes each: agent, first matrix, first weight, model, then the transform, three
                               * rows of four floats */
    uint64_t counts;          /* VkBuffer, 4 bytes each: agents in view without impostors, draws, triangles of all instances,
                               * impostors */
    uint64_t matrices;        /* VkBuffer: three rows of four floats each */
    uint64_t weights;         /* VkBuffer: floats; one that nothing reads where there are no morph targets */
    uint64_t blends;          /* VkBuffer: how far the vertices of each draw are on the way to their targets, 0 to 1, floats */
} RlvDeviceCrowdVulkan;

#define RLV_DEVICE_CROWD_VULKAN_INIT {sizeof(RlvDeviceCrowdVulkan), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}

/* Sends the models of a crowd to the device of its context. Fails with RLV_ERROR_UNSUPPORTED if the context has no graphics
 * device, with RLV_ERROR_DEVICE if that was lost, and with RLV_ERROR_MEMORY if it has no room. */
RLV_API RlvResult rlv_device_crowd_create(RlvCrowd crowd, RlvDeviceCrowd *out);

RLV_API RlvResult rlv_device_crowd_retain(RlvDeviceCrowd crowd);
RLV_API RlvResult rlv_device_crowd_release(RlvDeviceCrowd crowd);

/* Mutating. Finds what a view draws of the crowd, and waits until the device has done it; out may be NULL. Fails as
 * rlv_crowd_cut, and with RLV_ERROR_DEVICE if the device was lost. With occlusion all agents that were drawn in the last cut with
 * occlusion are posed there and drawn as depths, and a pyramid of these hides the boxes of others: a picture with one sample in
 * the middle of each pixel stays the same. Draws of hidden clusters that a single agent shows have no instances. It fails with
 * RLV_ERROR_UNSUPPORTED then if the bones of some models are blended as matrices and those of others as dual quaternions. A cut
 * that fails leaves nothing for rlv_device_crowd_get, unless it fails with RLV_ERROR_BUSY. */
RLV_API RlvResult rlv_device_crowd_cut(RlvDeviceCrowd crowd, const RlvCrowdView *view, RlvDeviceCrowdInfo *out);

/* Copies draws, clusters, blends, instances, matrices, weights and first weights of the last cut back from the device, and makes
 * dual rows; matrices, dual rows and weights are those of all poses, and weights of agents of their own. Fails, and writes
 * nothing, if a capacity is too small, there was no cut, or the last one failed. */
RLV_API RlvResult rlv_device_crowd_get(RlvDeviceCrowd crowd, const RlvCrowdBuffers *buffers);

/* Writes the impostors of the last cut, in the order of agents, with their pictures. Fails as rlv_device_crowd_get. */
RLV_API RlvResult rlv_device_crowd_get_impostors(RlvDeviceCrowd crowd, const RlvCrowdImpostors *impostors);

/* Its Vulkan objects. Fails with RLV_ERROR_UNSUPPORTED if the device is reached by another interface than Vulkan. */
RLV_API RlvResult rlv_device_crowd_vulkan(RlvDeviceCrowd crowd, RlvDeviceCrowdVulkan *out);

#endif
