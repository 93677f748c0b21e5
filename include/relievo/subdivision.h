/* Relievo: subdivision surfaces as OpenSubdiv has them, with primvars.
 *
 * A cage under the Catmull-Clark, Loop or bilinear scheme, evaluated at places with derivatives: its points, and its
 * attributes of floats as primvars. Attributes of points are vertex or varying primvars, those of corners face-varying,
 * those of faces uniform. OpenSubdiv's Bfr evaluates; rules have its names. Surfaces that hold detail, are painted or are
 * imprinted are those of surface.h. A Loop surface holds detail as a triangle mesh that rlv_subdivision_refine makes.
 *
 * Places are (tile, u, v). Under Catmull-Clark and bilinear, tiles and their parameters are those of surface.h. Under Loop
 * tiles are the triangles of the cage, in order; u and v are the barycentric coordinates of the second and third corner,
 * which make at most 1 together. */
#ifndef RELIEVO_SUBDIVISION_H
#define RELIEVO_SUBDIVISION_H

#include "relievo/surface.h"

typedef struct RlvSubdivision {
    uint64_t id;
} RlvSubdivision;

typedef enum RlvScheme {
    RLV_SCHEME_CATMULL_CLARK = 0,
    RLV_SCHEME_LOOP = 1, /* of triangles alone */
    RLV_SCHEME_BILINEAR = 2
} RlvScheme;

/* Where face-varying primvars are interpolated linearly. */
typedef enum RlvFaceVarying {
    RLV_FACE_VARYING_NONE = 0,           /* nowhere: seams are smooth */
    RLV_FACE_VARYING_CORNERS_ONLY = 1,   /* at corners of seams */
    RLV_FACE_VARYING_CORNERS_PLUS_1 = 2, /* at corners, and where three or more regions meet */
    RLV_FACE_VARYING_CORNERS_PLUS_2 = 3, /* as before, and at darts and concave corners */
    RLV_FACE_VARYING_BOUNDARIES = 4,     /* along all seams */
    RLV_FACE_VARYING_ALL = 5             /* everywhere */
} RlvFaceVarying;

typedef enum RlvCreasing {
    RLV_CREASING_UNIFORM = 0, /* sharpness falls by 1 from level to level */
    RLV_CREASING_CHAIKIN = 1  /* sharpness is averaged along creases as well */
} RlvCreasing;

typedef enum RlvTriangleRule {
    RLV_TRIANGLE_CATMULL_CLARK = 0,
    RLV_TRIANGLE_SMOOTH = 1 /* weights that make triangles of Catmull-Clark cages smoother */
} RlvTriangleRule;

/* How primvars of points are interpolated. */
typedef enum RlvPointRule {
    RLV_POINT_VERTEX = 0, /* as smoothly as the surface */
    RLV_POINT_VARYING = 1 /* bilinearly over tiles, linearly over triangles */
} RlvPointRule;

typedef struct RlvSubdivisionOptions {
    uint32_t struct_size;
    uint32_t scheme;        /* RlvScheme */
    uint32_t boundary;      /* RlvBoundary */
    uint32_t face_varying;  /* RlvFaceVarying */
    uint32_t creasing;      /* RlvCreasing */
    uint32_t triangle_rule; /* RlvTriangleRule */
    uint32_t isolation;     /* levels to which features are isolated before they are approximated, 1 to 10; 0 for 6 */
    uint32_t reserved;      /* 0 */
} RlvSubdivisionOptions;

#define RLV_SUBDIVISION_OPTIONS_INIT                                                                                  \
    {sizeof(RlvSubdivisionOptions), RLV_SCHEME_CATMULL_CLARK, RLV_BOUNDARY_EDGES_AND_CORNERS,                         \
     RLV_FACE_VARYING_CORNERS_ONLY, RLV_CREASING_UNIFORM, RLV_TRIANGLE_CATMULL_CLARK, 0, 0}

typedef struct RlvSubdivisionInfo {
    uint32_t struct_size;
    uint32_t scheme;    /* RlvScheme */
    size_t point_count; /* of the cage */
    size_t face_count;  /* of the cage */
    size_t tile_count;  /* those of faces without a surface included */
} RlvSubdivisionInfo;

#define RLV_SUBDIVISION_INFO_INIT {sizeof(RlvSubdivisionInfo), 0, 0, 0, 0}

/* Places and where results go. Every output is an array of count values, each as many floats as the primvar has numbers
 * (3 for points), or NULL if it is not wanted. Derivatives are per unit of the tile's parameters. Strides are in bytes, 0
 * for packed. Outputs must not overlap one another or the inputs. */
typedef struct RlvSubdivisionArrays {
    uint32_t struct_size;
    uint32_t point_rule; /* RlvPointRule, of attributes of points */
    size_t count;

    const uint32_t *tiles; /* tile of every place */
    size_t tile_stride;
    const float *uvs; /* u and v of every place, each from 0 to 1 */
    size_t uv_stride;

    float *values;
    size_t value_stride;
    float *du; /* first derivatives */
    size_t du_stride;
    float *dv;
    size_t dv_stride;
    float *duu; /* second derivatives */
    size_t duu_stride;
    float *duv;
    size_t duv_stride;
    float *dvv;
    size_t dvv_stride;
} RlvSubdivisionArrays;

#define RLV_SUBDIVISION_ARRAYS_INIT                                                                               \
    {sizeof(RlvSubdivisionArrays), RLV_POINT_VERTEX, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, \
     NULL, 0}

/* Makes the subdivision surface of a cage with its attributes, which may be released or changed afterwards. options may be
 * NULL. Fails with RLV_ERROR_UNSUPPORTED if a face is no triangle under RLV_SCHEME_LOOP or a face or point has more than
 * 65,535 neighbours, and with RLV_ERROR_MEMORY if it does not fit the memory limit of the context. */
RLV_API RlvResult rlv_subdivision_create(RlvContext context, RlvMesh cage, const RlvSubdivisionOptions *options,
                                         RlvSubdivision *out);

RLV_API RlvResult rlv_subdivision_retain(RlvSubdivision subdivision);
RLV_API RlvResult rlv_subdivision_release(RlvSubdivision subdivision);

/* How large it is. No failure of its own. */
RLV_API RlvResult rlv_subdivision_info(RlvSubdivision subdivision, RlvSubdivisionInfo *out);

/* Mutating. Poses an animated cage: count is its number of points. Calls that started before go on with the pose they
 * started with. Fails, and changes nothing, if count is another number or a coordinate is not finite. */
RLV_API RlvResult rlv_subdivision_set_points(RlvSubdivision subdivision, const float *points, size_t count,
                                             size_t stride);

/* The tiles of a face of the cage: the first and how many. Fails if there is no such face. */
RLV_API RlvResult rlv_subdivision_face_tiles(RlvSubdivision subdivision, uint32_t face, uint32_t *first,
                                             uint32_t *count);

/* Evaluates the points of the cage, or the attribute with that name, at places; attribute is NULL for the points. A place
 * without a surface, in a hole or at the boundary under RLV_BOUNDARY_NONE, gives zeros; uniform primvars have no
 * derivatives. Second derivatives under Loop have the sign of the surface, where those of OpenSubdiv 3.5 change it in
 * triangles that lie turned in a refined level. Fails without writing if a tile does not exist, u or v is outside it, there
 * is no such attribute (RLV_ERROR_NOT_FOUND), or it holds integers (RLV_ERROR_UNSUPPORTED). */
RLV_API RlvResult rlv_subdivision_evaluate(RlvSubdivision subdivision, const char *attribute,
                                           const RlvSubdivisionArrays *arrays);

/* Makes a mesh of the cage in its present pose, refined level times, 1 to 10, whose points lie on the limit surface; at the
 * inner end of a crease OpenSubdiv's limit is approximate. Attributes of floats are subdivided with it, integers of faces
 * are handed on, other integers are left out, and so are faces without a surface. Fails if the level is out of its range or
 * no face has a surface, and with RLV_ERROR_MEMORY if it does not fit the memory limit of the context. */
RLV_API RlvResult rlv_subdivision_refine(RlvSubdivision subdivision, uint32_t level, RlvMesh *out);

#endif
