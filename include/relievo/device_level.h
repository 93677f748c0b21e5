/* Relievo: device levels, meshes of a progressive mesh in the memory of a graphics device, for hosts that draw them there.
 *
 * A device level becomes finer, coarser or as a view needs it on the device of the context, whatever it was before, and is
 * edited there. It is the mesh that a level (level.h) of the processor is: without edits to the bit, but that a view may have
 * other splits nearer to a limit than 1e-5 of it; after edits vertices of the finest mesh differ by less than 1e-5 of its
 * extent, and normals and tangents among its attributes, which turn with them, by less than 1e-3 of their length. A view gives the mesh that a level has after its finest one. Brushes,
 * journals and what makes other meshes are levels' alone. Who may use its Vulkan objects, and when, is as in buffer.h; they stay the same for as long as it lives.
 * Lengths are in object units, angles in radians. */
#ifndef RELIEVO_DEVICE_LEVEL_H
#define RELIEVO_DEVICE_LEVEL_H

#include "relievo/level.h"

typedef struct RlvDeviceLevel {
    uint64_t id;
} RlvDeviceLevel;

typedef struct RlvDeviceLevelInfo {
    uint32_t struct_size;
    uint32_t undo_count; /* edits that can be taken back */
    uint32_t redo_count; /* edits that were taken back and can be made again */
    uint32_t reserved;
    size_t vertex_count; /* of the present mesh */
    size_t triangle_count;
    size_t wedge_count; /* 0 without attributes; there may be some that no triangle has */
} RlvDeviceLevelInfo;

#define RLV_DEVICE_LEVEL_INFO_INIT {sizeof(RlvDeviceLevelInfo), 0, 0, 0, 0, 0, 0}

/* Vulkan objects: dispatchable ones as pointers in 64 bits, others unchanged. */
typedef struct RlvDeviceLevelVulkan {
    uint32_t struct_size;
    uint32_t queue_family;    /* index of the family of the queue */
    uint32_t queue_index;     /* index of the queue in its family */
    uint32_t reserved;        /* 0 */
    uint64_t instance;        /* VkInstance */
    uint64_t physical_device; /* VkPhysicalDevice */
    uint64_t device;          /* VkDevice */
    uint64_t queue;           /* VkQueue */
    uint64_t vertices;        /* VkBuffer, 16 bytes each: 3 floats of the point, and the normal on an octahedron in two
                               * numbers of 16 bits, the first in the low ones: (number - 32768) / 32767, 0 for no normal */
    uint64_t triangles;       /* VkBuffer: 3 numbers of vertices, 4 bytes each, counter-clockwise from the front */
    uint64_t arguments;       /* VkBuffer: a VkDrawIndexedIndirectCommand, the number of vertices, and that of wedges */
    uint64_t wedges;          /* VkBuffer: of every triangle 3 numbers of wedges; 0 without attributes, as what follows */
    uint64_t wedge_values;    /* VkBuffer: floats, of every wedge as many as rlv_progressive_info tells */
    uint64_t face_values;     /* VkBuffer: of every triangle as many as rlv_progressive_info tells; of floats their bits */
} RlvDeviceLevelVulkan;

#define RLV_DEVICE_LEVEL_VULKAN_INIT {sizeof(RlvDeviceLevelVulkan), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}

/* Makes a level on the device of the progressive mesh's context, which is the base mesh. What there is of the progressive
 * mesh, some 95 bytes a triangle, is sent with the first one and shared by all that live at the same time. Fails with
 * RLV_ERROR_UNSUPPORTED if the context has no graphics device, with RLV_ERROR_DEVICE if that was lost, and with
 * RLV_ERROR_MEMORY if it has no room. */
RLV_API RlvResult rlv_device_level_create(RlvProgressive progressive, RlvDeviceLevel *out);

RLV_API RlvResult rlv_device_level_retain(RlvDeviceLevel level);
RLV_API RlvResult rlv_device_level_release(RlvDeviceLevel level);

/* How large the mesh is now, and how many edits there are to take back. Fails with RLV_ERROR_DEVICE if the device was
 * lost, as all that follow. */
RLV_API RlvResult rlv_device_level_info(RlvDeviceLevel level, RlvDeviceLevelInfo *out);

/* Mutating. Becomes the coarsest mesh that deviates by at most error from the finest, 0 or more. Fails if error is
 * negative or no number. */
RLV_API RlvResult rlv_device_level_set_error(RlvDeviceLevel level, float error);

/* Mutating. Becomes the finest mesh of at most so many triangles, or the base mesh if that has more; SIZE_MAX for the
 * finest of all. Fails with RLV_ERROR_DEVICE if the device was lost. */
RLV_API RlvResult rlv_device_level_set_triangles(RlvDeviceLevel level, size_t triangles);

/* Mutating. Becomes as fine as a view needs it. Fails, and changes nothing, if a number of the view is not finite or out of
 * its range, and if it has more than six planes. */
RLV_API RlvResult rlv_device_level_set_view(RlvDeviceLevel level, const RlvLevelView *view);

/* Mutating. Moves and turns regions of the present mesh, also where that is made for a view. reached, which may be
 * NULL, is how many vertices are moved. The first edit takes 65 bytes a triangle of the finest mesh on the device, and
 * 31 more where there are normals or tangents among attributes. Fails, and changes nothing, if no vertex is in a region or a
 * number is out of its range, and with RLV_ERROR_UNSUPPORTED if there are such and a vertex has more than 4,096 triangles. */
RLV_API RlvResult rlv_device_level_edit(RlvDeviceLevel level, const RlvLevelEdit *edit, size_t *reached);

/* Mutating. Takes the last edit back, at whatever level, and keeps the level's fineness. Fails with RLV_ERROR_NOT_FOUND
 * if there is none. */
RLV_API RlvResult rlv_device_level_undo(RlvDeviceLevel level);

/* Mutating. Makes the edit again that was taken back last. Fails with RLV_ERROR_NOT_FOUND if there is none. */
RLV_API RlvResult rlv_device_level_redo(RlvDeviceLevel level);

/* Mutating. Adds an edit over time, of the mesh at its present fineness; rlv_device_level_set_time shows it. Fails, and
 * changes nothing, if a number is out of its range or keys do not come one after another. */
RLV_API RlvResult rlv_device_level_add_motion(RlvDeviceLevel level, const RlvLevelMotion *motion);

/* Mutating. Applies the edits over time for a time in seconds, in the order they were added, in place of those of
 * another time; the mesh keeps its fineness. Edits, undo and redo put it at rest first. reached, which may be NULL, is
 * how many vertices were reached. Fails, and puts it at rest, if the time is not finite or no vertex is in a region that
 * moves. */
RLV_API RlvResult rlv_device_level_set_time(RlvDeviceLevel level, double time, size_t *reached);

/* Mutating. Forgets the edits over time, and puts the mesh at rest. Fails with RLV_ERROR_DEVICE if the device was lost. */
RLV_API RlvResult rlv_device_level_clear_motions(RlvDeviceLevel level);

/* Copies the mesh back from the device, as a whole, to the host's buffers, of which nothing that was there before counts:
 * vertices, triangles and wedges in the order of the finest mesh. out may be NULL. Fails if there is too little room. */
RLV_API RlvResult rlv_device_level_read(RlvDeviceLevel level, const RlvLevelBuffers *buffers, RlvLevelUpdate *out);

/* Its Vulkan objects. Fails with RLV_ERROR_UNSUPPORTED if the device is reached by another interface than Vulkan. */
RLV_API RlvResult rlv_device_level_vulkan(RlvDeviceLevel level, RlvDeviceLevelVulkan *out);

#endif
