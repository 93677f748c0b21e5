/* Relievo: triangles of surfaces and details.
 *
 * Every tile becomes a grid of cells. A segment between two tiles has the cells of the finer one on both sides, and
 * points there are one point, so that no cracks open. */
#ifndef RELIEVO_TESSELLATE_H
#define RELIEVO_TESSELLATE_H

#include "relievo/detail.h"

typedef struct RlvTessellateOptions {
    uint32_t struct_size;
    uint32_t coarse; /* cells along an edge of the cage where there is no displacement: a power of two from 1 to 512, 0
                        for 8. Tiles of faces of other than four corners have half as many. */
    uint32_t fine;   /* cells along an edge where there is displacement, at most; there are as many as coefficients
                        otherwise. A power of two from 1 to 512, 0 for 256. */
    uint32_t places; /* 1 to get the tile of every triangle as the face attribute "tile" (1 integer), and its u and v as
                        the corner attribute "tile_uv" (2 floats), else 0 */
} RlvTessellateOptions;

#define RLV_TESSELLATE_OPTIONS_INIT {sizeof(RlvTessellateOptions), 0, 0, 0}

/* Makes a triangle mesh of the limit surface. It has unit normals as the point attribute "normal", and the attributes
 * of the cage: those of points and corners are blended, those of faces copied. Holes are left out. options may be NULL.
 * Fails with RLV_ERROR_MEMORY if the triangles do not fit the context's memory limit. */
RLV_API RlvResult rlv_tessellate_surface(RlvSurface surface, const RlvTessellateOptions *options, RlvMesh *out);

/* The same for the displaced surface as it was committed last, in object space. */
RLV_API RlvResult rlv_tessellate_detail(RlvDetail detail, const RlvTessellateOptions *options, RlvMesh *out);

#endif
