/* Relievo: details, surfaces with displacement and colours that can be edited.
 *
 * A detail is a surface, an affine transform to the world, and a displacement along the surface's normal in tiles of
 * B-spline coefficients. It may be given more channels, each in tiles of its own: colours, a vector displacement that
 * comes after the one along the normal, and traces of contact. Tiles are allocated only where something happened,
 * within a budget of bytes; a tile the budget refuses stays as it was, the edit goes on without it and reports it, and
 * nothing is lost.
 *
 * On a triangle mesh values are kept at the vertices of a tessellation pattern: faces and edges get blocks of them
 * where something happened, and "tile" means a face with its edges. Sizes are segments along an edge: 8, 16, 32 or 64,
 * 0 for 16. It takes strokes, imprints, layers and documents; what it lacks is said below, and answers
 * RLV_ERROR_UNSUPPORTED.
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
    const uint32_t *face_sizes; /* pairs of a face and its size, for faces that differ from tile_size; may be NULL, and
                                   is for triangle meshes */
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
    double time;           /* when edits were made, seconds; see rlv_detail_advance */
    uint64_t stamp_bytes;  /* of the time stamps of edits that fade */
} RlvDetailInfo;

#define RLV_DETAIL_INFO_INIT {sizeof(RlvDetailInfo), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.0, 0}

/* What a detail keeps in tiles. A block is (size + 2)^2 little-endian texels, row by row, with a ring of one texel of
 * the neighbours. */
typedef enum RlvChannel {
    RLV_CHANNEL_DISPLACEMENT = 0, /* along the normal: a half float */
    RLV_CHANNEL_COLOR = 1,        /* red, green, blue and alpha as RlvColorFormat says */
    RLV_CHANNEL_VECTORS = 2,      /* along the tangent by u, across it and along the normal: three half floats */
    RLV_CHANNEL_TRACES = 3        /* contact and depth as half floats, and the time times the contact as a float */
} RlvChannel;

typedef struct RlvChannelInfo {
    uint32_t struct_size;
    uint32_t is_there;      /* 0 or 1: whether the detail has it; all else is 0 if not */
    size_t allocated_count; /* tiles that are allocated */
    uint64_t bytes;         /* of these, in memory */
    uint64_t full_bytes;    /* if every tile were allocated */
    uint64_t budget;        /* bytes that its tiles may occupy */
    uint32_t texel_size;    /* bytes of a texel */
    uint32_t paged_count;   /* tiles that are allocated and not in memory, see rlv_detail_set_paging */
} RlvChannelInfo;

#define RLV_CHANNEL_INFO_INIT {sizeof(RlvChannelInfo), 0, 0, 0, 0, 0, 0, 0}

/* The folds of a displaced surface. Tiles with vectors are not counted, since vectors may overhang. */
typedef struct RlvDetailFolds {
    uint32_t struct_size;
    uint32_t tile;           /* with most folded triangles, or the face of a triangle mesh; UINT32_MAX if nothing is folded */
    uint64_t triangle_count; /* two for each coefficient of the displaced tiles; of triangle meshes, of displaced faces */
    uint64_t folded_count;   /* triangles that the displacement turns over */
} RlvDetailFolds;

#define RLV_DETAIL_FOLDS_INIT {sizeof(RlvDetailFolds), 0, 0, 0}

/* The colours of a detail. */
typedef enum RlvColorFormat {
    RLV_COLOR_RGBA8 = 0,  /* red, green, blue as sRGB encodes them, and alpha: four bytes, 0 to 1 */
    RLV_COLOR_RGBA16F = 1 /* linear Rec.709 and alpha: four half floats, which may be brighter than 1 */
} RlvColorFormat;

typedef struct RlvPaintOptions {
    uint32_t struct_size;
    uint32_t tile_size; /* texels along an edge of the cage: 8, 16, 32, 64, 128 or 256; 0 for 128 */
    uint64_t budget;    /* bytes that tiles of colour may occupy; 0 for 1 GiB */
    float color[4];     /* where nothing is painted: linear Rec.709 and alpha, 0 to 1, or to 65504 as RLV_COLOR_RGBA16F */
    uint32_t format;    /* RlvColorFormat that the texels have, those of added layers too */
    uint32_t reserved;
} RlvPaintOptions;

#define RLV_PAINT_OPTIONS_INIT {sizeof(RlvPaintOptions), 0, 0, {1.0f, 1.0f, 1.0f, 1.0f}, RLV_COLOR_RGBA8, 0}

/* The vector displacement of a detail. */
typedef struct RlvVectorOptions {
    uint32_t struct_size;
    uint32_t tile_size; /* texels along an edge of the cage: 8, 16, 32, 64, 128 or 256; 0 for 128 */
    uint64_t budget;    /* bytes that its tiles may occupy; 0 for 1 GiB */
} RlvVectorOptions;

#define RLV_VECTOR_OPTIONS_INIT {sizeof(RlvVectorOptions), 0, 0}

/* When edits fade. */
typedef struct RlvDecayOptions {
    uint32_t struct_size;
    float delay;    /* how long an edit stays unchanged, seconds, 0 or more */
    float duration; /* how long it then takes to fade, seconds, more than 0 */
    uint32_t reserved;
    uint64_t budget; /* bytes that time stamps of displacement and of colours may occupy each; 0 for 1 GiB */
} RlvDecayOptions;

#define RLV_DECAY_OPTIONS_INIT {sizeof(RlvDecayOptions), 0.0f, 10.0f, 0, 0}

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
    uint32_t is_allocated; /* 0 or 1; tiles that are not allocated are blank: displacement 0, the colour of the options */
    uint32_t size;         /* texels a side, whether allocated or not */
    uint32_t reserved;
    uint64_t version;  /* number of the edit that changed the tile last, 0 if not allocated */
    size_t block_size; /* bytes of its block, if it is allocated */
    float low[3];      /* bounds of the displaced surface of the tile, object units, conservative */
    float high[3];
} RlvDetailTileInfo;

#define RLV_DETAIL_TILE_INFO_INIT {sizeof(RlvDetailTileInfo), 0, 0, 0, 0, 0, {0}, {0}}

/* Makes a detail of zero displacement on the surface in its present pose; rlv_surface_set_points does not concern it
 * afterwards, rlv_detail_set_points does. options may be NULL. matrix is twelve doubles, the affine map from object
 * space to the world in columns: three for the linear part, then the translation; NULL for the identity. Fails if a
 * tile size is not one of those allowed, a face does not exist, or the matrix is singular. */
RLV_API RlvResult rlv_detail_create(RlvSurface surface, const RlvDetailOptions *options, const double *matrix,
                                    RlvDetail *out);

RLV_API RlvResult rlv_detail_retain(RlvDetail detail);
RLV_API RlvResult rlv_detail_release(RlvDetail detail);

/* The detail as it was committed last. No failure of its own. */
RLV_API RlvResult rlv_detail_info(RlvDetail detail, RlvDetailInfo *out);

/* Whether edits still run on the graphics device of the context: RLV_OK if they do, or if it has none. Fails with what
 * went wrong when the processor took over: RLV_ERROR_DEVICE if the device failed or was lost, RLV_ERROR_MEMORY if it has
 * no room for the detail; rlv_error_last() has the text. No edit was lost. Such a detail stays with the processor; saved
 * to a document and opened in another context it returns to a device. */
RLV_API RlvResult rlv_detail_device_fault(RlvDetail detail);

/* Edits. Sets the bytes that tiles may occupy. Tiles that are allocated stay, even beyond it, unless they page. No
 * failure of its own. */
RLV_API RlvResult rlv_detail_set_budget(RlvDetail detail, uint64_t budget);

/* Edits. If page is not 0, tiles of all channels and layers that were edited longest ago leave memory when a budget is
 * spent, and return when they are looked at or edited; only new tiles that do not fit a budget together with the others
 * of the same edit are refused. Tiles that a document holds, opened with rlv_document_open, are read from its file
 * again; others go to a file without a name in folder, or where temporary files are if folder is NULL or cannot be
 * written to. What readers bring back is let go with the next edit or commit that exceeds the budget. A tile that
 * cannot be read back is blank to readers, and an error that names it to the next edit or commit. If page is 0 all
 * tiles return. */
RLV_API RlvResult rlv_detail_set_paging(RlvDetail detail, uint32_t page, const char *folder);

/* Edits. Gives the detail colours, so that it can be painted. options may be NULL. Fails if it has
 * colours already. */
RLV_API RlvResult rlv_detail_add_paint(RlvDetail detail, const RlvPaintOptions *options);

/* Edits. Gives the detail a vector displacement, zero at first, that comes after the one along the normal. Its frame is
 * that of the pose the detail has now. options may be NULL. Fails if it has one already. */
RLV_API RlvResult rlv_detail_add_vectors(RlvDetail detail, const RlvVectorOptions *options);

/* Edits. Lets imprints leave traces from now on: contact, 0 to 1, how far colliders have pushed in all, and when last.
 * Their tiles have the size of the displacement's and may occupy budget bytes; 0 for 1 GiB. Fails if it has traces. */
RLV_API RlvResult rlv_detail_add_traces(RlvDetail detail, uint64_t budget);

/* Edits. Lets edits of displacement and colours from now on fade back to what was there without any; each texel counts
 * from its last edit. What was edited before stays. options may be NULL. Fails if edits fade already, a time is out of
 * range, or the detail is of a triangle mesh and has several layers of a kind. */
RLV_API RlvResult rlv_detail_set_decay(RlvDetail detail, const RlvDecayOptions *options);

/* Edits. Comes to a time in seconds, 0 at first: edits that fade do so, and imprints leave it in their traces from now
 * on. Call it once a frame, before the frame's edits. Fails if the time is not finite, or before that of the last call
 * while edits fade. Time stamps that their budget refuses are logged; what was edited there stays. */
RLV_API RlvResult rlv_detail_advance(RlvDetail detail, double time);

/* A channel as it was committed last. Fails if there is no such channel; one that the detail could have and has not is
 * no failure. */
RLV_API RlvResult rlv_detail_channel_info(RlvDetail detail, uint32_t channel, RlvChannelInfo *out);

/* Counts where the displaced surface, as it was committed last, is folded: where a displacement goes deeper than the
 * surface is bent there, as a press through a thin part does, so that triangles are turned over. Costs about what a
 * tessellation of the displaced tiles does. Fails if memory for that is refused. */
RLV_API RlvResult rlv_detail_folds(RlvDetail detail, RlvDetailFolds *out);

/* Edits. Gives faces another number of coefficients along their edges, of displacement and traces; pairs of a face and
 * its size as in the options. Displacements stay, exactly but for rounding where a face becomes finer. Fails with
 * RLV_ERROR_MEMORY, and changes nothing, if the budget does not allow it, and on triangle meshes. */
RLV_API RlvResult rlv_detail_set_face_sizes(RlvDetail detail, const uint32_t *face_sizes, size_t count, size_t stride);

/* Edits. Moves the detail; matrix as for rlv_detail_create. Fails, and changes nothing, if the matrix is singular or
 * not finite. */
RLV_API RlvResult rlv_detail_set_transform(RlvDetail detail, const double *matrix);

/* Edits. Poses an animated cage: count is its number of points. Displacements stay. Fails, and changes nothing, if
 * count is another number or a coordinate is not finite. */
RLV_API RlvResult rlv_detail_set_points(RlvDetail detail, const float *points, size_t count, size_t stride);

/* Edits. Makes all edits since the last commit visible, and says what changed. out may be NULL. Fails, once, if a tile
 * that was paged could not be read back, and names it. */
RLV_API RlvResult rlv_detail_commit(RlvDetail detail, RlvDetailChanges *out);

/* The tiles that changed with the last commit, ascending, so that a host can refit what it made of them. Writes up to
 * capacity numbers to tiles and their number to count. tiles may be NULL to ask for the number. Fails if capacity is
 * too small for them. */
RLV_API RlvResult rlv_detail_changed_tiles(RlvDetail detail, uint32_t *tiles, size_t capacity, size_t *count);

/* The faces, ascending, that have tiles which a budget refused at the last stroke, imprint, change of layers or of
 * sizes: they stayed as they were. Writes up to capacity numbers to faces and their number to count. faces may be NULL
 * to ask for the number. */
RLV_API RlvResult rlv_detail_refused_faces(RlvDetail detail, uint32_t *faces, size_t capacity, size_t *count);

/* A tile of a channel as it was committed last. Its bounds are those of the surface with all its displacements. Fails
 * if there is no such channel or tile. */
RLV_API RlvResult rlv_detail_tile_info(RlvDetail detail, uint32_t channel, uint32_t tile, RlvDetailTileInfo *out);

/* Copies the block of a tile as it was committed last, for caches and files: see RlvChannel. Writes its bytes and their
 * number, 0 if the tile is not allocated. bytes may be NULL to ask for the number. Fails if the detail does not have
 * the channel, or is of a triangle mesh, whose faces share the blocks of their edges: its edits are kept in
 * documents. */
RLV_API RlvResult rlv_detail_read_block(RlvDetail detail, uint32_t channel, uint32_t tile, void *bytes, size_t capacity,
                                        size_t *size);

/* Edits. Puts a block back that rlv_detail_read_block gave; size 0 frees the tile. The neighbours' rings are brought up
 * to date at the commit. Fails with RLV_ERROR_MEMORY if the budget does not allow it, and with RLV_ERROR_UNSUPPORTED
 * for colours of several layers and on triangle meshes. */
RLV_API RlvResult rlv_detail_write_block(RlvDetail detail, uint32_t channel, uint32_t tile, const void *bytes,
                                         size_t size);

#endif
