/* Relievo: Bézier patches, bicubic and rational: evaluated, and tessellated as a camera needs it.
 *
 * A patch has 16 control points, row by row: along a row runs u, from row to row runs v, both from 0 to 1. Patches touch
 * where the control points of their edges are the same; indices may name points twice and need not. There are no cracks
 * between patches of different levels. Where an edge is collapsed to a point the normal is its limit.
 *
 * It is made once and does not change, so that its calls may run at the same time. */
#ifndef RELIEVO_BEZIER_H
#define RELIEVO_BEZIER_H

#include "relievo/evaluate.h"

typedef struct RlvBezier {
    uint64_t id;
} RlvBezier;

/* Control points. Strides are in bytes, 0 for packed. */
typedef struct RlvBezierArrays {
    uint32_t struct_size;
    uint32_t reserved;   /* 0 */
    const float *points; /* 3 floats each, object units, up to 1e12 */
    size_t point_count;
    size_t point_stride;
    const float *weights; /* one float for every point, 1e-6 to 1e6; NULL if all are 1 */
    size_t weight_stride;
    const uint32_t *indices; /* the points of the patches, 16 after 16; NULL for the points in their order */
    size_t index_count;
    size_t index_stride;
} RlvBezierArrays;

#define RLV_BEZIER_ARRAYS_INIT {sizeof(RlvBezierArrays), 0, NULL, 0, 0, NULL, 0, NULL, 0, 0}

typedef struct RlvBezierInfo {
    uint32_t struct_size;
    uint32_t is_rational; /* 0 or 1: whether weights differ */
    size_t patch_count;
    size_t curve_count; /* edges; an edge that patches share counts once */
    float low[3];       /* bounds of the control points, object units */
    float high[3];
} RlvBezierInfo;

#define RLV_BEZIER_INFO_INIT {sizeof(RlvBezierInfo), 0, 0, 0, {0}, {0}}

/* From where it is seen, and how near triangles have to come. */
typedef struct RlvBezierView {
    uint32_t struct_size;
    uint32_t most;     /* the highest level that may be used, 1 to 8; patches for which it is not enough get it */
    double eye[3];     /* where the camera is, object units */
    double forward[3]; /* the direction of view, of unit length */
    double pixels;     /* pixels that a unit across the view covers at distance 1: height / (2 tan(angle / 2)) */
    double corner;     /* tangent of the angle from the direction of view to the corner of the picture */
    double tolerance;  /* pixels that a triangle may be off on the picture, above 0 */
} RlvBezierView;

#define RLV_BEZIER_VIEW_INIT {sizeof(RlvBezierView), 8, {0.0}, {0.0, 0.0, -1.0}, 1000.0, 1.0, 0.5}

/* How fine patches are: 2^(level + 1) points a side. */
typedef struct RlvBezierLevels {
    uint32_t struct_size;
    uint32_t level;         /* of all patches if levels is NULL: 1 to 8 */
    const uint32_t *levels; /* of every patch, 1 to 8 each; or NULL */
    size_t level_count;     /* number of patches if levels is not NULL */
    size_t level_stride;    /* bytes, 0 for packed */
} RlvBezierLevels;

#define RLV_BEZIER_LEVELS_INIT {sizeof(RlvBezierLevels), 4, NULL, 0, 0}

/* Room for triangles. Arrays that are NULL are not wanted; strides are in bytes, 0 for packed. */
typedef struct RlvBezierTriangles {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    float *positions;  /* 3 floats each, object units: grids of points, row by row, patch after patch; then the points
                          that patches have of finer edges, patch after patch */
    size_t position_stride;
    float *normals; /* unit length, each that of its patch; 3 floats each */
    size_t normal_stride;
    size_t point_capacity; /* points that there is room for */
    uint32_t *corners;     /* 3 numbers of points each, counter-clockwise from the front */
    size_t triangle_stride;
    size_t triangle_capacity; /* triangles that there is room for */
} RlvBezierTriangles;

#define RLV_BEZIER_TRIANGLES_INIT {sizeof(RlvBezierTriangles), 0, NULL, 0, NULL, 0, 0, NULL, 0, 0}

/* Makes patches from arrays. Fails if there are not 16 control points for every patch, an index refers to no point, a
 * number is out of its range, or with RLV_ERROR_MEMORY if they do not fit the context's memory limit. */
RLV_API RlvResult rlv_bezier_create(RlvContext context, const RlvBezierArrays *arrays, RlvBezier *out);

/* Reads patches: .bpt files, whose lower degrees are raised to 3, and lists of indices and points as Newell's teapot is
 * handed on. path is UTF-8. Fails if the file cannot be read, and with the line if something in it cannot be used. */
RLV_API RlvResult rlv_bezier_read(RlvContext context, const char *path, RlvBezier *out);

RLV_API RlvResult rlv_bezier_retain(RlvBezier bezier);
RLV_API RlvResult rlv_bezier_release(RlvBezier bezier);

/* Counts and bounds. No failure of its own. */
RLV_API RlvResult rlv_bezier_info(RlvBezier bezier, RlvBezierInfo *out);

/* Copies the control points of a patch, 16 times x, y, z in object units and weight, stride bytes apart, 0 for packed.
 * Fails if there is no such patch. */
RLV_API RlvResult rlv_bezier_get_controls(RlvBezier bezier, size_t patch, float *controls, size_t stride);

/* Evaluates at places, whose tile is a patch: positions, normals, and first and second derivatives per unit of u and v,
 * also of patches with weights. A point on an edge that patches share is the same to the last bit whichever is asked.
 * Where an edge is collapsed to a point, normals are limits, and the derivatives along it, which are those of the patch
 * itself, zero. Displacements and vectors are zero. Fails without writing if a patch does not exist or u or v is outside
 * it, and with RLV_ERROR_UNSUPPORTED if colours or traces are wanted. */
RLV_API RlvResult rlv_bezier_evaluate(RlvBezier bezier, const RlvEvaluateArrays *arrays);

/* The lowest level of every patch whose triangles are nowhere farther from the surface than the tolerance of the view.
 * Writes as many numbers as there are patches to levels. Fails if capacity is less, or a number of the view is out of its
 * range. */
RLV_API RlvResult rlv_bezier_levels(RlvBezier bezier, const RlvBezierView *view, uint32_t *levels, size_t capacity);

/* How many points and triangles rlv_bezier_tessellate makes at these levels; levels may be NULL for level 4. Fails if a
 * level is out of its range, or they are not as many as patches. */
RLV_API RlvResult rlv_bezier_count(RlvBezier bezier, const RlvBezierLevels *levels, size_t *points, size_t *triangles);

/* Writes the triangles at these levels; levels may be NULL for level 4. Ask for their number with rlv_bezier_count first.
 * An edge is divided as the finest of the patches at it is; coarser patches have triangles more, between their own
 * division of it and that one. Fails without writing if there is less room, as rlv_bezier_count does, and with
 * RLV_ERROR_MEMORY if they do not fit the context's memory limit. */
RLV_API RlvResult rlv_bezier_tessellate(RlvBezier bezier, const RlvBezierLevels *levels,
                                        const RlvBezierTriangles *triangles);

/* The same triangles as a mesh whose patches share the points of their edges, with the corner attribute "normal", 3
 * floats, and the face attribute "patch", 1 integer. levels may be NULL for level 4. Fails as rlv_bezier_tessellate
 * does. */
RLV_API RlvResult rlv_bezier_mesh(RlvBezier bezier, const RlvBezierLevels *levels, RlvMesh *out);

#endif
