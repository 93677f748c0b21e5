/* Relievo: casting of rays against meshes and details.
 *
 * A caster is a picture of the geometry at the time it was made; it does not change. Rays are traced by Embree, which
 * is loaded with symbols of its own: a host that links another version of Embree is not affected and does not affect
 * it. */
#ifndef RELIEVO_CASTER_H
#define RELIEVO_CASTER_H

#include "relievo/tessellate.h"

typedef struct RlvCaster {
    uint64_t id;
} RlvCaster;

/* The number of no face and no tile. */
#define RLV_NO_ELEMENT 0xffffffffu

/* Where a ray met the geometry. Without a hit, distance is infinite, face and tile are RLV_NO_ELEMENT, the rest
 * zero. */
typedef struct RlvHit {
    float distance;    /* in multiples of the ray's direction */
    uint32_t face;     /* of the mesh, or of the detail's cage */
    uint32_t tile;     /* of the detail; RLV_NO_ELEMENT for a mesh */
    float u;           /* place in the tile; for a mesh, as for a detail of a triangle mesh, the barycentric weight of the triangle's second corner, */
    float v;           /* and that of the third */
    float position[3]; /* object units */
    float normal[3];   /* unit length, of the displaced surface or of the triangle, to the front */
} RlvHit;

/* Rays and where their hits go. Strides are in bytes, 0 for packed. */
typedef struct RlvRayArrays {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    size_t count;
    const float *origins; /* three floats each */
    size_t origin_stride;
    const float *directions; /* three floats each, of any length */
    size_t direction_stride;
    RlvHit *hits; /* the closest hit of every ray */
    size_t hit_stride;
    float min_distance; /* smallest distance of a hit, 0 or more */
    float max_distance; /* largest distance of a hit; 0 for no limit */
} RlvRayArrays;

#define RLV_RAY_ARRAYS_INIT {sizeof(RlvRayArrays), 0, 0, NULL, 0, NULL, 0, NULL, 0, 0, 0}

/* Makes a caster for the triangles of a mesh, which may be released or changed afterwards. Faces are cut as
 * rlv_mesh_get_triangles does. Fails with RLV_ERROR_UNSUPPORTED or RLV_ERROR_NOT_FOUND if there is no Embree 3.13
 * or 4 to load; the environment variable RELIEVO_EMBREE may name its file. */
RLV_API RlvResult rlv_caster_create_mesh(RlvContext context, RlvMesh mesh, RlvCaster *out);

/* Makes a caster for a detail as it was committed last, in object space: the triangles that rlv_tessellate_detail makes
 * with these options, NULL for the defaults. A hit is as exact as they are; its place can be evaluated. Fails as
 * rlv_caster_create_mesh and rlv_tessellate_detail do. */
RLV_API RlvResult rlv_caster_create_detail(RlvDetail detail, const RlvTessellateOptions *options, RlvCaster *out);

RLV_API RlvResult rlv_caster_retain(RlvCaster caster);
RLV_API RlvResult rlv_caster_release(RlvCaster caster);

/* Casts rays. A ray hits nothing if a number of it is not finite or beyond 1e12, which is as far as Embree goes, or if
 * its direction is zero; the others of the call are cast. Fails if min_distance is negative or above max_distance. */
RLV_API RlvResult rlv_caster_cast(RlvCaster caster, const RlvRayArrays *arrays);

#endif
