/* Relievo: progressive meshes, triangle meshes that are taken as coarse or as fine as needed.
 *
 * A progressive mesh is a coarse base mesh and the splits of vertices that make it fine again (Derzapf, Grund, Guthe
 * 2014). It is built by simplification, in about 40 bytes a triangle, and does not change, so that its calls may run at
 * the same time. A level (level.h) is a mesh of it. Attributes, where they are kept, are in wedges: a vertex has one for
 * each set of values that its triangles have there. Lengths are in object units. */
#ifndef RELIEVO_PROGRESSIVE_H
#define RELIEVO_PROGRESSIVE_H

#include "relievo/bytes.h"
#include "relievo/simplify.h"

typedef struct RlvProgressive {
    uint64_t id;
} RlvProgressive;

typedef struct RlvProgressiveOptions {
    uint32_t struct_size;
    uint32_t keeps_attributes; /* 1: attributes are kept as rlv_simplify_mesh keeps them; 0: none is */
    size_t base_triangles;  /* triangles at which the base mesh is coarse enough; there may be more where no edge can go */
    const uint32_t *locked; /* points that stay where they are at all levels; NULL for none */
    size_t locked_count;
    size_t locked_stride; /* bytes, 0 for packed */
    const RlvSimplifyWeight *weights; /* what attributes count for, where they are kept; NULL for the defaults */
    size_t weight_count;
    size_t weight_stride; /* bytes, 0 for packed */
} RlvProgressiveOptions;

#define RLV_PROGRESSIVE_OPTIONS_INIT {sizeof(RlvProgressiveOptions), 0, 100, NULL, 0, 0, NULL, 0, 0}

typedef struct RlvProgressiveInfo {
    uint32_t struct_size;
    uint32_t attribute_count; /* beside normals */
    size_t vertex_count; /* of the finest mesh */
    size_t triangle_count;
    size_t base_vertex_count; /* of the coarsest */
    size_t base_triangle_count;
    size_t bytes; /* in memory */
    size_t wedge_count;   /* of the finest mesh */
    uint32_t wedge_width; /* numbers of a wedge: those of all attributes on points and corners, in their order */
    uint32_t face_width;  /* numbers of a triangle: those of all attributes on faces */
} RlvProgressiveInfo;

#define RLV_PROGRESSIVE_INFO_INIT {sizeof(RlvProgressiveInfo), 0, 0, 0, 0, 0, 0, 0, 0, 0}

/* Builds a progressive mesh of a mesh's triangles, fanned as rlv_mesh_get_triangles does; points at the same place are
 * taken as one. options may be NULL for the defaults, progress too. Fails if a locked point or an attribute does not
 * exist, a number is out of its range or faces have more than 64 numbers, with RLV_ERROR_MEMORY if it would take more than the context's memory limit, and with
 * RLV_ERROR_CANCELLED. */
RLV_API RlvResult rlv_progressive_create(RlvMesh mesh, const RlvProgressiveOptions *options, RlvProgress progress,
                                         void *user, RlvProgressive *out);

/* Reads a file (.rlvpm). path is UTF-8. triangles is how fine it has to be at least: only as much of the file is read,
 * SIZE_MAX for all of it. The file may be hostile: it is checked, and the context's memory limit bounds what reading it
 * takes. Fails if the file cannot be read, is of a newer version or not what was written. */
RLV_API RlvResult rlv_progressive_read(RlvContext context, const char *path, size_t triangles, RlvProgressive *out);

/* Writes a file (.rlvpm), compressed, whose beginning is a coarser mesh. path is UTF-8. The file appears whole or not at
 * all. Fails if it cannot be written. */
RLV_API RlvResult rlv_progressive_write(RlvProgressive progressive, const char *path);

/* As rlv_progressive_read, from the size bytes of a file. Fails as that does. */
RLV_API RlvResult rlv_progressive_read_bytes(RlvContext context, const uint8_t *bytes, size_t size, size_t triangles,
                                             RlvProgressive *out);

/* Makes the bytes of the file that rlv_progressive_write writes. Fails if not all of the mesh was read. */
RLV_API RlvResult rlv_progressive_write_bytes(RlvProgressive progressive, RlvBytes *out);

RLV_API RlvResult rlv_progressive_retain(RlvProgressive progressive);
RLV_API RlvResult rlv_progressive_release(RlvProgressive progressive);

/* How large its finest and coarsest meshes are. No failure of its own. */
RLV_API RlvResult rlv_progressive_info(RlvProgressive progressive, RlvProgressiveInfo *out);

/* What attribute index, counted from 0, is: those on points and corners come first, with a value for each wedge, then
 * those on faces, with one for each triangle. Fails if there is none. */
RLV_API RlvResult rlv_progressive_attribute_info(RlvProgressive progressive, uint32_t index, RlvAttributeInfo *out);

#endif
