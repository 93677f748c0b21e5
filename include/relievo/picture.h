/* Relievo: documents and Ptex files as pictures, for hosts that look textures up in images.
 *
 * A picture is a file with images. It is opened without its mesh and never changes, so any number of threads may read.
 *
 * A document has an image of every kind that it has layers of, colours first: what all layers of the kind come to. If
 * that is not simply a single layer, an image of each layer alone follows. All tiles have cells of one size in an
 * image: tile t is in column t % columns and row t / columns. Around a tile is a gutter that continues it, so that
 * bilinear look-up at any level gives what the surface has there, also at the edges of tiles. For a place (tile, u, v)
 *     x = (t % columns) * cell + gutter + u * side        y = (t / columns) * cell + gutter + v * side
 * in pixels of level 0 from the first corner of the first pixel; divided by width and height it holds for all levels.
 *
 * In a document of a triangle mesh the tiles are its triangles, u and v the barycentric coordinates of the second and
 * third corner, so that a triangle is the half u + v <= 1 of its cell. What is beyond that diagonal continues it, as the
 * gutter does. Values are sampled as far apart as they are kept along the edges; vectors are in the frame of the
 * triangle, along its first edge. What is said of the file has "surface": "triangles", or else "catmull-clark".
 *
 * A Ptex file has an image for every face, with the reductions that the file holds as further levels. */
#ifndef RELIEVO_PICTURE_H
#define RELIEVO_PICTURE_H

#include "relievo/context.h"

#define RLV_PICTURE_NAME_SIZE 264

/* The number of no channel and no face. */
#define RLV_PICTURE_NONE 0xffffffffu

typedef struct RlvPicture {
    uint64_t id;
} RlvPicture;

typedef enum RlvPictureFormat { RLV_PICTURE_DOCUMENT = 0, RLV_PICTURE_PTEX = 1 } RlvPictureFormat;

/* What the numbers of a pixel are: little-endian, as on every machine this runs on. */
typedef enum RlvPictureType {
    RLV_PICTURE_U8 = 0, /* 255 stands for 1 */
    RLV_PICTURE_U16 = 1, /* 65535 stands for 1 */
    RLV_PICTURE_F16 = 2,
    RLV_PICTURE_F32 = 3,
    RLV_PICTURE_I32 = 4, /* of meta data alone */
    RLV_PICTURE_F64 = 5, /* of meta data alone */
    RLV_PICTURE_TEXT = 6 /* of meta data alone: UTF-8 */
} RlvPictureType;

typedef enum RlvPictureContent {
    RLV_PICTURE_COLOR = 0,        /* linear Rec.709, multiplied by alpha, and alpha */
    RLV_PICTURE_DISPLACEMENT = 1, /* along the normal, object units */
    RLV_PICTURE_VECTORS = 2,      /* along the tangent by u, across it, along the normal, object units */
    RLV_PICTURE_TRACES = 3,       /* contact, depth in object units, time of the last push in seconds or -1 */
    RLV_PICTURE_NUMBERS = 4       /* of a Ptex file: what its meta data says; colours are multiplied by alpha */
} RlvPictureContent;

typedef struct RlvPictureInfo {
    uint32_t struct_size;
    uint32_t format;      /* RlvPictureFormat */
    uint32_t image_count; /* at least 1 */
    uint32_t face_count;  /* of the mesh, or of the Ptex file */
    uint32_t tile_count;  /* tiles of the mesh, or its triangles; as many as faces of a Ptex file */
    uint32_t meta_count;  /* see rlv_picture_meta */
} RlvPictureInfo;

#define RLV_PICTURE_INFO_INIT {sizeof(RlvPictureInfo), 0, 0, 0, 0, 0}

typedef struct RlvPictureImage {
    uint32_t struct_size;
    uint32_t content; /* RlvPictureContent */
    uint32_t type;    /* RlvPictureType */
    uint32_t channels;
    uint32_t alpha;  /* the channel that is alpha, or RLV_PICTURE_NONE */
    uint32_t width;  /* pixels of level 0 */
    uint32_t height;
    uint32_t level_count; /* at least 1; each has half the pixels of the one before along both axes */
    uint32_t face;        /* of a Ptex file; RLV_PICTURE_NONE for a document, as are columns to gutter of Ptex 0 */
    uint32_t columns;     /* cells in a row */
    uint32_t cell;        /* pixels along a cell of level 0: the tile and a gutter on both sides */
    uint32_t side;        /* pixels along a tile */
    uint32_t gutter;      /* pixels of a gutter */
    uint32_t is_layer;    /* 1 for one layer alone; 0 for what all layers of the kind come to, and for Ptex */
    uint32_t blend;       /* of a layer: RlvBlend */
    uint32_t is_visible;  /* of a layer: 0 or 1 */
    float opacity;        /* of a layer: 0 to 1; else 1 */
    uint32_t reserved;
    char name[RLV_PICTURE_NAME_SIZE]; /* of the layer, the kind, or "face 17" */
} RlvPictureImage;

#define RLV_PICTURE_IMAGE_INIT {sizeof(RlvPictureImage), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1.0f, 0, {0}}

/* What is said of the whole file: of a document its mesh and who wrote it, of a Ptex file all that is in it. Pointers
 * live as long as the picture. */
typedef struct RlvPictureMeta {
    uint32_t struct_size;
    uint32_t type;      /* RlvPictureType: F32, I32, F64 or TEXT */
    size_t count;       /* numbers, or bytes of the text without its terminating NUL */
    const char *name;   /* UTF-8 */
    const void *values; /* numbers, aligned, or the text, NUL-terminated */
} RlvPictureMeta;

#define RLV_PICTURE_META_INIT {sizeof(RlvPictureMeta), 0, 0, NULL, NULL}

/* Opens a file by what is in it, not by its name. It may be hostile: the context's memory limit bounds what is made of
 * it. Layers are unpacked when they are first read. Fails with RLV_ERROR_UNSUPPORTED if it is neither a document nor
 * Ptex. */
RLV_API RlvResult rlv_picture_open(RlvContext context, const char *path, RlvPicture *out);

RLV_API RlvResult rlv_picture_retain(RlvPicture picture);
RLV_API RlvResult rlv_picture_release(RlvPicture picture);

/* What the file is, and how much is in it. No failure of its own. */
RLV_API RlvResult rlv_picture_info(RlvPicture picture, RlvPictureInfo *out);

/* What an image is. Fails if there is none. */
RLV_API RlvResult rlv_picture_image(RlvPicture picture, uint32_t image, RlvPictureImage *out);

/* What is said of the whole file, one thing at an index. Fails if there is none. */
RLV_API RlvResult rlv_picture_meta(RlvPicture picture, uint32_t index, RlvPictureMeta *out);

/* Copies width by height pixels of a level of an image, from (x, y) on, row by row; row 0 of a cell or a face is v = 0.
 * row_stride is in bytes, 0 for packed. The first call on a layer unpacks it, which others that want it wait for. Fails
 * if they are not all in the image, or the layer is damaged or does not fit the context's memory limit. */
RLV_API RlvResult rlv_picture_read(RlvPicture picture, uint32_t image, uint32_t level, uint32_t x, uint32_t y,
                                   uint32_t width, uint32_t height, void *pixels, size_t row_stride);

#endif
