/* Relievo: what the loaded library can do on this machine, asked instead of tried.
 *
 * A host reads it once, before its first context, and shows or hides what depends on it. */
#ifndef RELIEVO_CAPABILITY_H
#define RELIEVO_CAPABILITY_H

#include "relievo/context.h"

/* Versions are numbers as RLV_MAKE_VERSION makes them, 0 for what is not there. */
typedef struct RlvCapability {
    uint32_t struct_size;
    uint32_t version;            /* of this library, as rlv_version returns it */
    uint32_t embree_version;     /* of the Embree that casts rays, 0 if none can be loaded */
    uint32_t opensubdiv_version; /* of the OpenSubdiv that the library was built with */
    uint32_t openvdb_version;    /* of the OpenVDB behind grids, 0 if its module cannot be opened */
    uint32_t has_devices;        /* 0 or 1: whether the library was built with graphics devices */
    uint32_t has_usd;            /* 0 or 1: whether it reads and writes USD */
    uint32_t has_shaders;        /* 0 or 1: whether it explores shaders */
    uint32_t has_tls;            /* 0 or 1: whether clients can encrypt */
    uint32_t adapter_count;      /* graphics devices that rlv_adapter_list lists */
    uint32_t cores;              /* threads that a context with threads = 0 has */
    uint32_t max_threads;        /* threads that a context may have */
    uint32_t max_isolation;      /* levels that RlvSurfaceOptions may isolate features to */
    uint32_t reserved;
    uint64_t max_objects;     /* objects that may be alive at once */
    char simd[RLV_NAME_SIZE]; /* instruction level of new contexts: "baseline", "avx2", "avx512" or "neon" */
} RlvCapability;

#define RLV_CAPABILITY_INIT {sizeof(RlvCapability), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, {0}}

/* What a file holds, and which noun reads and writes it. */
typedef enum RlvContent {
    RLV_CONTENT_MESH = 0,       /* rlv_mesh_read, rlv_mesh_write, rlv_mesh_write_bytes */
    RLV_CONTENT_PATCHES = 1,    /* rlv_bezier_read */
    RLV_CONTENT_PARTICLES = 2,  /* rlv_particles_read, rlv_particles_write */
    RLV_CONTENT_GRID = 3,       /* rlv_grid_read, rlv_grid_write */
    RLV_CONTENT_TEXTURE = 4,    /* rlv_ptex_read, rlv_ptex_write */
    RLV_CONTENT_DOCUMENT = 5,   /* rlv_document_open, rlv_document_save, rlv_document_save_bytes */
    RLV_CONTENT_PROGRESSIVE = 6, /* rlv_progressive_read, rlv_progressive_write, rlv_progressive_write_bytes */
    RLV_CONTENT_CROWD = 7,       /* rlv_crowd_model_read, rlv_crowd_model_write, rlv_crowd_model_write_bytes */
    RLV_CONTENT_TISSUE = 8       /* rlv_tissue_read, rlv_tissue_write, rlv_tissue_write_bytes */
} RlvContent;

/* One row of the formats. */
typedef struct RlvCapabilityFormat {
    uint32_t content;              /* RlvContent */
    uint32_t can_read;             /* 0 or 1 */
    uint32_t can_write;            /* 0 or 1 */
    uint32_t can_write_bytes;      /* 0 or 1: whether the bytes of such a file can be made in memory */
    char extension[RLV_NAME_SIZE]; /* without the dot, in small letters */
} RlvCapabilityFormat;

/* What there is. Loads Embree and the module of OpenVDB, and asks the graphics drivers, which takes milliseconds to
 * tenths of a second. What is missing is no failure. No failure of its own. */
RLV_API RlvResult rlv_capability_get(RlvCapability *out);

/* The formats of files that this build reads or writes on this machine, by content. Writes up to capacity rows to formats
 * and their number to count. formats may be NULL to ask for the number. Fails if there are more than capacity. */
RLV_API RlvResult rlv_capability_list(RlvCapabilityFormat *formats, size_t capacity, size_t *count);

#endif
