/* Relievo: casting of rays against meshes and details.
 *
 * A caster is a picture of the geometry at the time it was made, or follows a tessellation and changes where its host says
 * so. Rays are traced by Embree, which
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

/* Rays and where their hits go. Strides are in bytes, 0 for packed.
 *
 * A call fails if min_distance is negative or above max_distance. A ray of its own hits nothing if a number of its origin
 * or direction is not finite or beyond 1e12, which is as far as Embree goes, if its direction is zero, or if a distance of
 * its own is no number, negative or its smallest is above its largest; the others of the call are cast. */
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
    float min_distance; /* smallest distance of a hit, 0 or more, in multiples of the direction */
    float max_distance; /* largest distance of a hit; 0 for no limit */
    const float *min_distances; /* smallest distance of each ray in place of min_distance; NULL for that one */
    size_t min_distance_stride;
    const float *max_distances; /* largest distance of each ray in place of max_distance, which may be infinite; NULL for
                                   that one */
    size_t max_distance_stride;
    const uint32_t *masks; /* a ray hits nothing of a caster with whose mask it shares no bit, and nothing of an isosurface
                              if it has none; NULL for all bits */
    size_t mask_stride;
    const float *times; /* seconds, held within the shutter of an isosurface; NULL for 0. Casters do not move: they do not
                           read it */
    size_t time_stride;
} RlvRayArrays;

#define RLV_RAY_ARRAYS_INIT \
    {sizeof(RlvRayArrays), 0, 0, NULL, 0, NULL, 0, NULL, 0, 0, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0}

/* Makes a caster for the triangles of a mesh, which may be released or changed afterwards. Faces are cut as
 * rlv_mesh_get_triangles does. Fails with RLV_ERROR_UNSUPPORTED or RLV_ERROR_NOT_FOUND if there is no Embree 3.13
 * or 4 to load; the environment variable RELIEVO_EMBREE may name its file. */
RLV_API RlvResult rlv_caster_create_mesh(RlvContext context, RlvMesh mesh, RlvCaster *out);

/* Makes a caster for a detail as it was committed last, in object space: the triangles that rlv_tessellate_detail makes
 * with these options, NULL for the defaults. A hit is as exact as they are; its place can be evaluated. Fails as
 * rlv_caster_create_mesh and rlv_tessellate_detail do. */
RLV_API RlvResult rlv_caster_create_detail(RlvDetail detail, const RlvTessellateOptions *options, RlvCaster *out);

/* Makes a caster for the triangles of a tessellation, as it was updated last, and keeps the tessellation alive. Its hits are
 * those of a caster of the detail with the same options. Fails as rlv_caster_create_mesh does. */
RLV_API RlvResult rlv_caster_create_tessellation(RlvTessellation tessellation, RlvCaster *out);

/* Mutating: brings a caster to the last update of its tessellation. After one update it costs what that wrote; after several
 * all points are moved, and where triangles were rebuilt all is made anew. Fails if the caster follows nothing, and with
 * RLV_ERROR_BUSY while rays are cast or the tessellation is updated. */
RLV_API RlvResult rlv_caster_update(RlvCaster caster);

RLV_API RlvResult rlv_caster_retain(RlvCaster caster);
RLV_API RlvResult rlv_caster_release(RlvCaster caster);

/* Mutating: sets the mask of a caster, which has all bits at first. A ray hits nothing of a caster with which it shares no
 * bit. Fails with RLV_ERROR_BUSY while rays are cast. */
RLV_API RlvResult rlv_caster_set_mask(RlvCaster caster, uint32_t mask);

/* Casts rays. Fails as RlvRayArrays says. */
RLV_API RlvResult rlv_caster_cast(RlvCaster caster, const RlvRayArrays *arrays);

/* Finds out whether rays hit anything between their distances, which is faster than to find what they hit first: writes 1 or
 * 0 for each to occluded, stride bytes apart, 0 for packed. hits of arrays is not used. Fails as rlv_caster_cast does. */
RLV_API RlvResult rlv_caster_occluded(RlvCaster caster, const RlvRayArrays *arrays, uint8_t *occluded, size_t stride);

#endif
