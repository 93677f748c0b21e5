/* Relievo: the colours of a detail and their mips in the memory of a graphics device, for shaders of hosts.
 *
 * A color buffer lives on the device of the context. What buffer.h says of handles, of when what is written is visible, and
 * of threads, holds here too. Its four Vulkan buffers hold words of 32 bits in the order of the device:
 * - tiles: of every tile its first word in texels, UINT32_MAX where it has no block, and the number n of its texels a side, 0
 *   there. A tile without a block has the colour `color` everywhere.
 * - texels: blocks of (n + 2)^2 texels, row by row, with a ring of one texel of the neighbours, as rlv_detail_read_block has
 *   them. A texel is one word, red in its lowest byte, as RLV_COLOR_RGBA8, or two, red and green, blue and alpha, as
 *   RLV_COLOR_RGBA16F.
 * - mip_firsts: of every tile its first word in mips, or UINT32_MAX.
 * - mips: of a tile the levels n / 2, n / 4, ... down to 2 texels a side, one after the other, as texels has the tile, each
 *   with a ring of its own.
 * Texel (i, j) of n a side is number (j + 1) (n + 2) + i + 1 of its block and lies at u = (i + 0.5) / n, v = (j + 0.5) / n;
 * i and j go from -1 to n. So a bilinear look-up never leaves the block, and goes on without a step across edges where both
 * sides have as many texels; beside tiles of other sizes colours may jump by what lies between two texels. A triangle's tile,
 * and u and v at its corners, are the attributes "tile" and "tile_uv" of RlvTessellateOptions.places. */
#ifndef RELIEVO_COLOR_BUFFER_H
#define RELIEVO_COLOR_BUFFER_H

#include "relievo/detail.h"

typedef struct RlvColorBuffer {
    uint64_t id;
} RlvColorBuffer;

typedef struct RlvColorBufferInfo {
    uint32_t struct_size;
    uint32_t rebuilt;       /* 1 if the last update made other Vulkan buffers in place of one of the four, else 0 */
    uint32_t format;        /* RlvColorFormat of the texels */
    uint32_t reserved;      /* 0 */
    size_t tile_count;      /* tiles of the detail */
    size_t allocated_count; /* tiles that have a block */
    size_t written_count;   /* tiles that the last update wrote or freed */
    uint64_t bytes;         /* on the device */
    float color[4];         /* of tiles without a block: linear Rec.709 and alpha */
} RlvColorBufferInfo;

#define RLV_COLOR_BUFFER_INFO_INIT {sizeof(RlvColorBufferInfo), 0, 0, 0, 0, 0, 0, 0, {0}}

/* Vulkan objects: dispatchable ones as pointers in 64 bits, others unchanged. Buffers are for storage. */
typedef struct RlvColorBufferVulkan {
    uint32_t struct_size;
    uint32_t queue_family;    /* index of the family of the queue */
    uint32_t queue_index;     /* index of the queue in its family */
    uint32_t reserved;        /* 0 */
    uint64_t instance;        /* VkInstance */
    uint64_t physical_device; /* VkPhysicalDevice */
    uint64_t device;          /* VkDevice */
    uint64_t queue;           /* VkQueue */
    uint64_t tiles;           /* VkBuffer */
    uint64_t texels;          /* VkBuffer */
    uint64_t mip_firsts;      /* VkBuffer */
    uint64_t mips;            /* VkBuffer */
} RlvColorBufferVulkan;

#define RLV_COLOR_BUFFER_VULKAN_INIT {sizeof(RlvColorBufferVulkan), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}

/* Puts the colours of a detail, as it was committed last, on the device of its context, makes their mips there, and keeps the
 * detail alive. Fails if the detail has no colours, with RLV_ERROR_UNSUPPORTED if it is of a triangle mesh or the context has
 * no graphics device, with RLV_ERROR_DEVICE if that was lost, and with RLV_ERROR_MEMORY if it has no room. */
RLV_API RlvResult rlv_color_buffer_create(RlvDetail detail, RlvColorBuffer *out);

RLV_API RlvResult rlv_color_buffer_retain(RlvColorBuffer buffer);
RLV_API RlvResult rlv_color_buffer_release(RlvColorBuffer buffer);

/* Mutating: brings the buffer to the detail's last commit: tiles that changed are copied, and their mips and the mips
 * that these reach are made on the device. Waits for it. out may be NULL. Fails as rlv_color_buffer_create does, with
 * RLV_ERROR_BUSY if another call is at work on the buffer. */
RLV_API RlvResult rlv_color_buffer_update(RlvColorBuffer buffer, RlvColorBufferInfo *out);

/* What is in the buffer. No failure of its own. */
RLV_API RlvResult rlv_color_buffer_info(RlvColorBuffer buffer, RlvColorBufferInfo *out);

/* Its Vulkan objects. Fails with RLV_ERROR_UNSUPPORTED if the device is reached by another interface than Vulkan, and with
 * RLV_ERROR_DEVICE if it was lost. */
RLV_API RlvResult rlv_color_buffer_vulkan(RlvColorBuffer buffer, RlvColorBufferVulkan *out);

/* Copies the block of a tile back from the device: level 0 is the tile, 1 its first mip. Writes its bytes and their number, 0
 * if the tile has none at that level. bytes may be NULL to ask for the number. Fails if there is no such tile, and with
 * RLV_ERROR_DEVICE if the device was lost. */
RLV_API RlvResult rlv_color_buffer_read(RlvColorBuffer buffer, uint32_t tile, uint32_t level, void *bytes,
                                        size_t capacity, size_t *size);

#endif
