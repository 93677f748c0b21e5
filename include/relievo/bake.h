/* Relievo: bakes, pictures of a detail on the texture coordinates of its cage.
 *
 * A bake shows a detail as it was committed last. Texture coordinates are a corner attribute of two floats of the cage
 * and are subdivided as the surface is, with sharp borders; those of a triangle mesh are linear in its triangles. Where
 * several faces lie on one pixel, the first has it. Tangent space is that of the surface without displacement: its
 * normal N, T along increasing s, B along increasing t. */
#ifndef RELIEVO_BAKE_H
#define RELIEVO_BAKE_H

#include "relievo/detail.h"

/* What a picture has numbers of. */
typedef enum RlvBakeQuantity {
    RLV_BAKE_DISPLACEMENT = 0, /* along the normal, object units: 1 channel */
    RLV_BAKE_VECTOR = 1,       /* from the surface without any displacement to the displaced one, object units: 3 */
    RLV_BAKE_NORMAL = 2,       /* unit normal of the displaced surface: 3 */
    RLV_BAKE_COLOR = 3,        /* linear Rec.709 and alpha, which is not multiplied in: 4 */
    RLV_BAKE_MASK = 4,         /* alpha of the colours: 1 */
    RLV_BAKE_CONTACT = 5,      /* of traces, 0 to 1: 1 */
    RLV_BAKE_DEPTH = 6,        /* of traces, object units: 1 */
    RLV_BAKE_TIME = 7          /* of the last push, seconds, -1 where there was none: 1 */
} RlvBakeQuantity;

typedef enum RlvBakeSpace { RLV_BAKE_TANGENT = 0, RLV_BAKE_OBJECT = 1 } RlvBakeSpace;

/* The order of the parts of a vector in tangent space. */
typedef enum RlvBakeAxes {
    RLV_BAKE_TNB = 0, /* tangent, normal, bitangent: as Blender and Mudbox take it */
    RLV_BAKE_TBN = 1  /* tangent, bitangent, normal */
} RlvBakeAxes;

/* Which way the second number of a normal in tangent space points. */
typedef enum RlvBakeHandedness {
    RLV_BAKE_OPENGL = 0, /* along increasing t */
    RLV_BAKE_DIRECTX = 1 /* against it */
} RlvBakeHandedness;

typedef struct RlvBakeOptions {
    uint32_t struct_size;
    uint32_t quantity;   /* RlvBakeQuantity */
    uint32_t width;      /* pixels, 1 to 32768 */
    uint32_t height;     /* pixels, 1 to 32768 */
    uint32_t is_udim;    /* 1 for a picture of every UDIM tile that something lies on, 0 for 0 <= s, t < 1 alone */
    uint32_t gutter;     /* pixels by which pictures go on around islands, 0 to 1024 */
    uint32_t samples;    /* along the sides of a pixel, 1 to 8 */
    uint32_t space;      /* RlvBakeSpace, of vectors and normals */
    uint32_t axes;       /* RlvBakeAxes, of vectors in tangent space */
    uint32_t handedness; /* RlvBakeHandedness, of normals in tangent space */
    float scale;         /* object units or seconds that 1 stands for in a file, with mid_level; 0 for what fits: numbers
                            as they are in EXR, all of 0 to 1 in PNG */
    float mid_level;     /* the number of a file that stands for 0, if scale is not 0 */
    const char *uv;      /* name of the corner attribute, UTF-8; NULL for "uv" */
} RlvBakeOptions;

#define RLV_BAKE_OPTIONS_INIT                                                                                        \
    {sizeof(RlvBakeOptions), RLV_BAKE_DISPLACEMENT, 2048, 2048, 0, 16, 1, RLV_BAKE_TANGENT, RLV_BAKE_TNB, RLV_BAKE_OPENGL, \
     0.0f, 0.0f, NULL}

/* A picture. Its arrays live for the call. */
typedef struct RlvBakePicture {
    uint32_t struct_size;
    uint32_t udim; /* 1001 + column + 10 row; 1001 for the only one */
    uint32_t width;
    uint32_t height;
    uint32_t channels; /* numbers of a pixel */
    uint32_t reserved;
    const float *pixels;    /* row by row, that of the largest t first, in the units of the quantity */
    const uint8_t *covered; /* of every pixel 1 if it lies on the surface, else 0; those of the gutter do not */
} RlvBakePicture;

/* What a bake did. */
typedef struct RlvBakeReport {
    uint32_t struct_size;
    uint32_t picture_count;
    uint64_t covered_pixels;     /* that lie on the surface */
    uint64_t gutter_pixels;      /* that go on around it */
    uint64_t overlapping_pixels; /* on which several tiles lie */
    size_t flat_tiles;           /* without an area in the texture coordinates */
    size_t outside_count;        /* squares of texture coordinates that something lies on and that have no picture */
    float scale;                 /* of the files */
    float mid_level;
} RlvBakeReport;

#define RLV_BAKE_REPORT_INIT {sizeof(RlvBakeReport), 0, 0, 0, 0, 0, 0, 0.0f, 0.0f}

/* Receives a picture. Returns RlvProgressAnswer; after RLV_PROGRESS_CANCEL the bake returns RLV_ERROR_CANCELLED. */
typedef uint32_t (*RlvBakeReceiver)(void *user, const RlvBakePicture *picture);

/* Bakes to memory: calls receive for every picture, by number. options may be NULL, progress and report too; user goes
 * to both callbacks. Fails if the detail has no such quantity, the cage has no such texture coordinates, nothing lies
 * on a picture, a number is out of its range, or a picture does not fit the context's memory limit. */
RLV_API RlvResult rlv_bake_run(RlvDetail detail, const RlvBakeOptions *options, RlvBakeReceiver receive,
                               RlvProgress progress, void *user, RlvBakeReport *report);

/* Bakes to files, .exr or .png as the extension of the path says, with a text in them that says what the numbers are.
 * The numbers of UDIM tiles replace "<UDIM>" in the name, or stand in front of the extension. Each file appears whole
 * or not at all; files finished before a failure or cancel stay. Fails as rlv_bake_run does, and if a file
 * cannot be written. */
RLV_API RlvResult rlv_bake_write(RlvDetail detail, const RlvBakeOptions *options, const char *path,
                                 RlvProgress progress, void *user, RlvBakeReport *report);

#endif
