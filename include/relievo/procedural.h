/* Relievo: displaced surfaces as user geometry of a renderer's own Embree scene, of whatever version that is.
 *
 * A procedural is a detail as it was committed, cut into primitives: blocks of at most 16 by 16 cells of a tile, as fine
 * as the coefficients of the displacement. The renderer's Embree asks for their bounds and lets rays meet them; the
 * functions that answer are plain pointers in a table. They take no lock, keep nothing, allocate nothing, and may be
 * called from any number of threads. A surface takes some 10 bytes a cell, where triangles with their hierarchy take 170.
 *
 * With Embree 3 or 4 a renderer does, for a geometry of type RTC_GEOMETRY_TYPE_USER with table.primitive_count
 * primitives and table.time_step_count time steps:
 *     bounds     table->bounds(table->data, args->primID, args->timeStep, (float *)args->bounds_o)
 *     intersect  table->intersect(table->data, args->valid, args->primID, args->geomID, args->context->instID[0],
 *                                 args->rayhit, args->N)
 *     occluded   table->occluded(table->data, args->valid, args->primID, args->ray, args->N)
 * The hit has the place in the tile as u and v, and du x dv of its triangle as Ng. rlv_procedural_evaluate says the
 * rest of the hits that are shaded: tile, point, smooth normal, colour. Since 4.3 hits of Embree end with a number more,
 * instPrimID, which renderers with arrays of instances set themselves.
 *
 * Filter functions: Embree calls none for user geometry, and those functions that call them belong to the renderer's
 * Embree, so it asks them itself, hit by hit. In intersect, for every ray i with valid[i]:
 *     RTCRayHit one = ray i alone
 *     loop: one.hit.geomID = RTC_INVALID_GEOMETRY_ID, table->intersect(..., &one, 1); if that is still so, no hit: done
 *           RTCFilterFunctionNArguments filter = {&valid, args->geometryUserPtr, args->context, &one.ray, &one.hit, 1}
 *           Embree 3: rtcFilterIntersection(args, &filter), which asks the geometry's and the context's filter
 *           Embree 4: rtcInvokeIntersectFilterFromGeometry(args, &filter), which asks the geometry's; then the
 *                     renderer's own, if it has one for the call, of which no callback hears
 *           if valid is not 0, the hit counts: ray i gets far and the hit of one; done
 *           one.ray.tnear = nextafterf(one.ray.tfar, INFINITY), one.ray.tfar = that of ray i
 * In occluded the same with table->intersect on a copy of the ray, rtcFilterOcclusion or
 * rtcInvokeOccludedFilterFromGeometry; a hit that counts makes far of ray i minus infinity.
 *
 * Triangle meshes: the tile is the triangle, u and v are the barycentric coordinates of its second and third corner. A
 * triangle with displacement, or beside one, has three squares of cells around its corners; one without is a single
 * primitive of 200 bytes.
 *
 * Tiles of different rates meet without cracks: the finer one follows the chords of the coarser one. Corners of cells are
 * rounded to RlvProceduralInfo.step, about a millionth of the extent. */
#ifndef RELIEVO_PROCEDURAL_H
#define RELIEVO_PROCEDURAL_H

#include "relievo/detail.h"

typedef struct RlvProcedural {
    uint64_t id;
} RlvProcedural;

typedef struct RlvProceduralOptions {
    uint32_t struct_size;
    uint32_t coarse; /* cells along an edge of the cage where there is no displacement: a power of two from 4 to 512, 0
                        for 16. Of no effect on triangle meshes, which are flat there. */
    uint32_t fine;   /* cells along an edge where there is displacement, at most; there are as many as coefficients
                        otherwise. A power of two from 4 to 512, 0 for 256. Tiles have at least 4 cells a side, triangles
                        with displacement 8 along an edge. */
    uint32_t reserved;
} RlvProceduralOptions;

#define RLV_PROCEDURAL_OPTIONS_INIT {sizeof(RlvProceduralOptions), 0, 0, 0}

typedef struct RlvProceduralInfo {
    uint32_t struct_size;
    uint32_t primitive_count;
    uint32_t time_step_count; /* 1, or 2 if it moves */
    float step;               /* what corners are rounded to, object units */
    uint64_t cell_count;      /* two triangles each; 16 for a flat triangle */
    uint64_t bytes;           /* it occupies, besides the detail */
    float low[3];             /* bounds at all times, object units */
    float high[3];
} RlvProceduralInfo;

#define RLV_PROCEDURAL_INFO_INIT {sizeof(RlvProceduralInfo), 0, 0, 0.0f, 0, 0, {0}, {0}}

/* Writes the bounds of a primitive at a time step, 0 or 1, as eight floats: low x, y, z, one that is unused, and high
 * the same: RTCBounds. Those of a primitive that does not exist are empty. Between the time steps bounds go straight
 * from one to the other. */
typedef void (*RlvProceduralBounds)(const void *data, uint32_t primitive, uint32_t time_step, float *bounds);

/* Lets count rays meet a primitive. rays are count of each of these numbers of 32 bits, one kind after the other: origin
 * x, y, z, near, direction x, y, z, time, far, mask, id, flags; and of the hit: normal x, y, z, u, v, primitive,
 * geometry, instance. That is RTCRayHitN of Embree 3 and 4, and RTCRayHit for one. Rays with valid[i] = 0 are left
 * alone. A hit from near to far takes the place of the one there is: far, the normal, u and v are set, and the numbers
 * of primitive, geometry and instance. Time is 0 to 1 over the interval of the motion. */
typedef void (*RlvProceduralIntersect)(const void *data, const int32_t *valid, uint32_t primitive, uint32_t geometry,
                                       uint32_t instance, void *rays, uint32_t count);

/* The same for rays that anything stops: rays are the first twelve kinds of numbers, RTCRayN; far becomes minus infinity
 * where there is a hit. */
typedef void (*RlvProceduralOccluded)(const void *data, const int32_t *valid, uint32_t primitive, void *rays,
                                      uint32_t count);

/* The functions for the callbacks of Embree. All is valid as long as the procedural lives: a scene keeps a reference. */
typedef struct RlvProceduralTable {
    uint32_t struct_size;
    uint32_t primitive_count;
    uint32_t time_step_count;
    uint32_t reserved;
    const void *data;      /* to be given to the functions */
    const uint32_t *tiles; /* the tile of every primitive */
    RlvProceduralBounds bounds;
    RlvProceduralIntersect intersect;
    RlvProceduralOccluded occluded;
} RlvProceduralTable;

#define RLV_PROCEDURAL_TABLE_INIT {sizeof(RlvProceduralTable), 0, 0, 0, NULL, NULL, NULL, NULL, NULL}

/* Hits that are shaded. Strides are in bytes, 0 for packed; outputs may be NULL. */
typedef struct RlvProceduralHits {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    size_t count;
    const uint32_t *primitives;
    size_t primitive_stride;
    const float *uvs; /* u and v as intersect wrote them */
    size_t uv_stride;
    const float *times; /* 0 to 1, one float each; NULL for 0 */
    size_t time_stride;
    uint32_t *tiles;
    size_t tile_stride;
    float *positions; /* of the displaced surface, object units, three floats each; off the ray by what cells are flat */
    size_t position_stride;
    float *normals; /* unit normals of the displaced surface, three floats each */
    size_t normal_stride;
    float *colors; /* linear Rec.709 and alpha, four floats each; details with colours only */
    size_t color_stride;
} RlvProceduralHits;

#define RLV_PROCEDURAL_HITS_INIT \
    {sizeof(RlvProceduralHits), 0, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0}

/* Makes the primitives of a detail as it was committed last, in object space. options may be NULL. Fails with
 * RLV_ERROR_MEMORY if it does not fit the context's memory limit while it is made. */
RLV_API RlvResult rlv_procedural_create(RlvDetail detail, const RlvProceduralOptions *options, RlvProcedural *out);

/* Makes the primitives of a surface that moves, from what begin was made of to the detail as it was committed last:
 * another pose, or other displacement, of the same cage. Corners go straight from one to the other; cells are as fine as
 * the finer of both. begin does not change; if it moves itself, its beginning counts.
 * Fails as rlv_procedural_create does, and if end is of another cage. */
RLV_API RlvResult rlv_procedural_create_moving(RlvProcedural begin, RlvDetail end, RlvProcedural *out);

RLV_API RlvResult rlv_procedural_retain(RlvProcedural procedural);
RLV_API RlvResult rlv_procedural_release(RlvProcedural procedural);

/* What the primitives are and take. No failure of its own. */
RLV_API RlvResult rlv_procedural_info(RlvProcedural procedural, RlvProceduralInfo *out);

/* The functions and what they work on. No failure of its own. */
RLV_API RlvResult rlv_procedural_table(RlvProcedural procedural, RlvProceduralTable *out);

/* What is at hits. Of a surface that moves it is blended between both moments. Fails without writing if a primitive does
 * not exist, u or v is not 0 to 1 or they make more than 1 in a triangle, or colours are wanted of a detail without
 * any. */
RLV_API RlvResult rlv_procedural_evaluate(RlvProcedural procedural, const RlvProceduralHits *hits);

#endif
