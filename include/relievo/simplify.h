/* Relievo: simplification, fewer triangles for nearly the same surface and the attributes on it.
 *
 * Edges are collapsed in the order of what that costs, places and values of attributes are the best ones (Lindstrom, Turk
 * 1998; Hoppe 1999). Points at the same place are taken as one; where attributes differ between the triangles around it
 * there is a seam, which stays closed. Attributes of floats on points and corners are kept, 16 numbers at most, and all
 * of faces; materials of faces make seams too. Results do not depend on the number of threads. Lengths are in object
 * units. */
#ifndef RELIEVO_SIMPLIFY_H
#define RELIEVO_SIMPLIFY_H

#include "relievo/mesh.h"

/* What an attribute counts for. */
typedef struct RlvSimplifyWeight {
    const char *name;     /* of an attribute of the mesh, UTF-8 */
    float weight;         /* the part of the diagonal of the mesh's box that a difference of 1 counts as, 0 to 1e6 */
    uint32_t is_left_out; /* 1: it is not kept, and weight means nothing */
} RlvSimplifyWeight;

/* When it ends, at the first of these, and what it keeps. Strides are in bytes, 0 for packed. */
typedef struct RlvSimplifyOptions {
    uint32_t struct_size;
    float error;      /* largest estimated deviation, with weighted attributes; below 0 for any */
    size_t triangles; /* triangles to be left; more where no edge can go, one less where two go at once */
    const RlvSimplifyWeight *weights; /* others: "normal", "tangent" 0.0005, "color" 0.002, "uv" 0.02, else 0 */
    size_t weight_count;
    size_t weight_stride;
    const uint32_t *locked; /* points that stay where they are, with their attributes */
    size_t locked_count;
    size_t locked_stride;
    const float *factors; /* of every point, what costs there are multiplied by, 1e-6 to 1e6; NULL for 1 */
    size_t factor_count;  /* 0, or the number of points */
    size_t factor_stride;
    float bound; /* largest distance between both surfaces, either way, measured and never exceeded; below 0 for any */
    uint32_t is_border_locked; /* 1: points of edges with one triangle stay where they are */
} RlvSimplifyOptions;

#define RLV_SIMPLIFY_OPTIONS_INIT {sizeof(RlvSimplifyOptions), -1.0f, 0, NULL, 0, 0, NULL, 0, 0, NULL, 0, 0, -1.0f, 0}

/* Makes a mesh of fewer triangles of a mesh's triangles, fanned as rlv_mesh_get_triangles does. Attributes are on what
 * they were on, those of corners with indices; creases, integers on points and corners, and skins are left out. error,
 * which may be NULL, gets the largest distance between both surfaces, never less than the true one, if there is a bound;
 * else the largest estimated deviation, which the distance may exceed several times. With a bound the mesh is simplified
 * several times; a bound below 1e-7 of the largest coordinate, its rounding, counts as that. options may be NULL for the
 * defaults, progress too. Fails if a
 * number is out of its range, an attribute or a point does not exist, or no triangle is left; with RLV_ERROR_MEMORY if
 * it would take more than the context's memory limit, and with RLV_ERROR_CANCELLED. */
RLV_API RlvResult rlv_simplify_mesh(RlvMesh mesh, const RlvSimplifyOptions *options, RlvProgress progress, void *user,
                                    float *error, RlvMesh *out);

#endif
