/* Relievo: details, surfaces with displacement and colours that can be edited.
 *
 * A detail is a surface, an affine transform to the world, and a displacement along the surface's normal in tiles of
 * B-spline coefficients; if it was given any, colours in tiles of their own. Tiles are allocated only where something happened, within a budget of bytes; a tile the budget
 * refuses stays as it was, the edit goes on without it and reports it, and nothing is lost.
 *
 * Edits (imprints, blocks that are written, new poses) become visible at rlv_detail_commit: readers see what was
 * committed last, never half an edit, and do not wait. Functions marked "edits" need the detail for themselves among
 * edits and return RLV_ERROR_BUSY while another one is at work; all others may run at any time. */
#ifndef RELIEVO_DETAIL_H
#define RELIEVO_DETAIL_H

#include "relievo/surface.h"

typedef struct RlvDetail {
    uint64_t id;
} RlvDetail;

typedef struct RlvDetailOptions {
    uint32_t struct_size;
    uint32_t tile_size; /* coefficients along an edge of the cage: 8, 16, 32, 64, 128 or 256; 0 for 128. Tiles of faces
                           of other than four corners have half of it, but at least 8. */
    uint64_t budget;            /* bytes that tiles may occupy; 0 for 1 GiB */
    const uint32_t *face_sizes; /* pairs of a face and its size, for faces that differ from tile_size; may be NULL */
    size_t face_size_count;     /* pairs */
    size_t face_size_stride;    /* bytes, 0 for packed */
} RlvDetailOptions;

#define RLV_DETAIL_OPTIONS_INIT {sizeof(RlvDetailOptions), 0, 0, NULL, 0, 0}

typedef struct RlvDetailInfo {
    uint32_t struct_size;
    uint32_t is_painted;    /* 0 or 1: whether it has colours */
    size_t tile_count;      /* of the surface */
    size_t allocated_count; /* tiles that are allocated */
    uint64_t revision;      /* number of the last edit in it */
    uint64_t bytes;         /* of the allocated tiles */
    uint64_t full_bytes;    /* if every tile were allocated */
    uint64_t budget;
    size_t painted_count;  /* tiles of colour that are allocated */
    uint64_t paint_bytes;  /* of these */
    uint64_t paint_budget; /* bytes that tiles of colour may occupy */
} RlvDetailInfo;

#define RLV_DETAIL_INFO_INIT {sizeof(RlvDetailInfo), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}

/* The colours of a detail. */
typedef struct RlvPaintOptions {
    uint32_t struct_size;
    uint32_t tile_size; /* texels along an edge of the cage: 8, 16, 32, 64, 128 or 256; 0 for 128 */
    uint64_t budget;    /* bytes that tiles of colour may occupy; 0 for 1 GiB */
    float color[4];     /* where nothing is painted: linear Rec.709 and alpha, 0 to 1 */
} RlvPaintOptions;

#define RLV_PAINT_OPTIONS_INIT {sizeof(RlvPaintOptions), 0, 0, {1.0f, 1.0f, 1.0f, 1.0f}}

/* What a commit made visible. */
typedef struct RlvDetailChanges {
    uint32_t struct_size;
    uint32_t moved;    /* 1 if the pose or the transform changed, which concerns all tiles */
    uint64_t revision; /* number of the last edit in it */
    size_t tile_count; /* tiles that changed; rlv_detail_changed_tiles lists them */
    float low[3];      /* bounds of the displaced surface of these tiles, object units, conservative; zero for none */
    float high[3];
} RlvDetailChanges;

#define RLV_DETAIL_CHANGES_INIT {sizeof(RlvDetailChanges), 0, 0, 0, {0}, {0}}

typedef struct RlvDetailTileInfo {
    uint32_t struct_size;
    uint32_t is_allocated; /* 0 or 1; tiles that are not allocated have displacement 0 */
    uint32_t size;         /* coefficients a side, whether allocated or not */
    uint32_t reserved;
    uint64_t version;  /* number of the edit that changed the tile last, 0 if not allocated */
    size_t block_size; /* bytes of its block, if it is allocated */
    float low[3];      /* bounds of the displaced surface of the tile, object units, conservative */
    float high[3];
} RlvDetailTileInfo;

#define RLV_DETAIL_TILE_INFO_INIT {sizeof(RlvDetailTileInfo), 0, 0, 0, 0, 0, {0}, {0}}

/* Makes a detail of zero displacement on the surface in its present pose; rlv_surface_set_points does not concern it
 * afterwards, rlv_detail_set_points does. options may be NULL. matrix is twelve doubles, the affine map from object
 * space to the world in columns: three for the linear part, then the translation; NULL for the identity. */
RLV_API RlvResult rlv_detail_create(RlvSurface surface, const RlvDetailOptions *options, const double *matrix,
                                    RlvDetail *out);

RLV_API RlvResult rlv_detail_retain(RlvDetail detail);
RLV_API RlvResult rlv_detail_release(RlvDetail detail);

RLV_API RlvResult rlv_detail_info(RlvDetail detail, RlvDetailInfo *out);

/* Edits. Sets the bytes that tiles may occupy. Tiles that are allocated stay, even beyond it. */
RLV_API RlvResult rlv_detail_set_budget(RlvDetail detail, uint64_t budget);

/* Edits. Gives the detail colours, eight bits a number, so that it can be painted. options may be NULL. Fails if it has
 * colours already. */
RLV_API RlvResult rlv_detail_add_paint(RlvDetail detail, const RlvPaintOptions *options);

/* Edits. Gives faces another number of coefficients along their edges; pairs of a face and its size as in the options.
 * Displacements stay, exactly but for rounding where a face becomes finer. Fails with RLV_ERROR_MEMORY, and changes
 * nothing, if the budget does not allow it. */
RLV_API RlvResult rlv_detail_set_face_sizes(RlvDetail detail, const uint32_t *face_sizes, size_t count, size_t stride);

/* Edits. Moves the detail; matrix as for rlv_detail_create. */
RLV_API RlvResult rlv_detail_set_transform(RlvDetail detail, const double *matrix);

/* Edits. Poses an animated cage: count is its number of points. Displacements stay. */
RLV_API RlvResult rlv_detail_set_points(RlvDetail detail, const float *points, size_t count, size_t stride);

/* Edits. Makes all edits since the last commit visible, and says what changed. out may be NULL. */
RLV_API RlvResult rlv_detail_commit(RlvDetail detail, RlvDetailChanges *out);

/* The tiles that changed with the last commit, ascending, so that a host can refit what it made of them. Writes up to
 * capacity numbers to tiles and their number to count. tiles may be NULL to ask for the number. */
RLV_API RlvResult rlv_detail_changed_tiles(RlvDetail detail, uint32_t *tiles, size_t capacity, size_t *count);

RLV_API RlvResult rlv_detail_tile_info(RlvDetail detail, uint32_t tile, RlvDetailTileInfo *out);

/* Copies the block of a tile, for undo, caches and files: (size + 2)^2 half floats, little-endian, row by row, with a
 * ring of one coefficient of the neighbours. Writes its bytes and their number, 0 if the tile is not allocated. bytes
 * may be NULL to ask for the number. */
RLV_API RlvResult rlv_detail_read_block(RlvDetail detail, uint32_t tile, void *bytes, size_t capacity, size_t *size);

/* Edits. Puts a block back that rlv_detail_read_block gave; size 0 frees the tile. The neighbours' rings are brought up
 * to date at the commit. Fails with RLV_ERROR_MEMORY if the budget does not allow it. */
RLV_API RlvResult rlv_detail_write_block(RlvDetail detail, uint32_t tile, const void *bytes, size_t size);

#endif
