/* Relievo: evaluation of surfaces and details at arrays of places. */
#ifndef RELIEVO_EVALUATE_H
#define RELIEVO_EVALUATE_H

#include "relievo/detail.h"

/* Places and what is wanted there. Every output is an array of count times three floats (one for displacements, four
 * for colours), or NULL if it is not wanted. Strides are in bytes, 0 for packed. Outputs must not overlap one another
 * or the inputs. */
typedef struct RlvEvaluateArrays {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    size_t count;

    const uint32_t *tiles; /* tile of every place */
    size_t tile_stride;
    const float *uvs; /* u and v of every place, each from 0 to 1 */
    size_t uv_stride;

    float *positions; /* object units */
    size_t position_stride;
    float *normals; /* unit length; zero where the surface has no normal */
    size_t normal_stride;
    float *du; /* derivatives by u and v, object units per tile; of a triangle its edges from the first corner */
    size_t du_stride;
    float *dv;
    size_t dv_stride;
    float *duu; /* second derivatives */
    size_t duu_stride;
    float *duv;
    size_t duv_stride;
    float *dvv;
    size_t dvv_stride;
    float *displacements; /* one float each: scalar displacement along the normal of the limit surface, object units */
    size_t displacement_stride;
    float *colors; /* linear Rec.709 and alpha, 4 floats a place; details with colours only */
    size_t color_stride;
    float *vectors; /* what the vector displacement adds, object units in object space; 0 without any */
    size_t vector_stride;
    float *traces; /* contact, 0 to 1, depth, object units, and age, seconds before the detail's time or -1 where nothing
                      ever touched; details with traces only */
    size_t trace_stride;
    /* An input, or NULL: how far u and v go from every place to the next two samples, say du and dv by the columns and
     * by the rows of a picture, 4 floats a place. Colours are then means over the parallelogram of the two, across
     * edges. What is no finite number is taken for 0. Triangle meshes keep no reductions: their colours are
     * interpolated. */
    const float *footprints;
    size_t footprint_stride;
} RlvEvaluateArrays;

#define RLV_EVALUATE_ARRAYS_INIT                                                                                  \
    {sizeof(RlvEvaluateArrays), 0, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, \
     NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0}

/* Evaluates the limit surface, without any detail on it; displacements are 0. A place in a hole gives zeros. Fails
 * without writing if a tile does not exist or u or v is outside it. */
RLV_API RlvResult rlv_evaluate_surface(RlvSurface surface, const RlvEvaluateArrays *arrays);

/* Evaluates the displaced surface as it was committed last: positions, normals, displacements, vectors, colours and
 * traces. A point on an edge or
 * vertex that tiles share is the same to the last bit whichever tile is asked. Fails with RLV_ERROR_UNSUPPORTED if one
 * of du to dvv is wanted. */
RLV_API RlvResult rlv_evaluate_detail(RlvDetail detail, const RlvEvaluateArrays *arrays);

#endif
