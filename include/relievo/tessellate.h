/* Relievo: triangles of surfaces and details.
 *
 * Every tile becomes a grid of cells. A segment between two tiles has the cells of the finer one on both sides, and
 * points there are one point, so that no cracks open. Triangle meshes keep their triangles where nothing happened, and
 * have the triangles of the pattern that their values are kept at elsewhere: coarse, fine and smooth_uvs are not for
 * them, and whatever becomes finer rebuilds a tessellation. */
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
    uint32_t smooth_uvs; /* 1 to subdivide the corner attribute "uv" as the surface, which is what bakes go by; 0 to blend
                            it */
    uint32_t reserved;   /* 0 */
} RlvTessellateOptions;

#define RLV_TESSELLATE_OPTIONS_INIT {sizeof(RlvTessellateOptions), 0, 0, 0, 0, 0}

/* Makes a triangle mesh of the limit surface. It has unit normals as the point attribute "normal", and the attributes
 * of the cage: those of points and corners are blended, those of faces copied. Holes are left out. options may be NULL.
 * Fails with RLV_ERROR_MEMORY if the triangles do not fit the context's memory limit. */
RLV_API RlvResult rlv_tessellate_surface(RlvSurface surface, const RlvTessellateOptions *options, RlvMesh *out);

/* The same for the displaced surface as it was committed last, in object space. If it has colours the mesh has them as
 * the point attribute "color", 3 floats; if it has traces, as "contact", "depth" and "age", one float each, as
 * RlvEvaluateArrays has them. Cells are as fine as the texels of all that the detail has. Fails as
 * rlv_tessellate_surface does. */
RLV_API RlvResult rlv_tessellate_detail(RlvDetail detail, const RlvTessellateOptions *options, RlvMesh *out);

/* Triangles of a detail that follow its commits: after rlv_detail_commit, rlv_tessellation_update renews the points of
 * the tiles that changed and says which points are other than before, so that a host uploads and refits these and leaves
 * the rest. The points are the same to the last bit as those of rlv_tessellate_detail. */
typedef struct RlvTessellation {
    uint64_t id;
} RlvTessellation;

typedef struct RlvTessellationInfo {
    uint32_t struct_size;
    uint32_t reserved;
    size_t point_count;
    size_t triangle_count;
    uint64_t revision; /* of the detail, which the points are of */
} RlvTessellationInfo;

#define RLV_TESSELLATION_INFO_INIT {sizeof(RlvTessellationInfo), 0, 0, 0, 0}

/* What an update did. */
typedef struct RlvTessellationChanges {
    uint32_t struct_size;
    uint32_t rebuilt; /* 1 if there are other triangles and points than before, all in one range, because tiles got or
                         lost displacement, or another size, and with it another number of cells. That never happens
                         where the options say the same number for coarse and fine. */
    size_t range_count; /* ranges of points that changed; rlv_tessellation_changed_ranges lists them */
    size_t point_count; /* points in them */
    float low[3];       /* bounds of these points, with those of small gaps, object units; zero for none */
    float high[3];
} RlvTessellationChanges;

#define RLV_TESSELLATION_CHANGES_INIT {sizeof(RlvTessellationChanges), 0, 0, 0, {0}, {0}}

/* Makes the triangles of the detail as it was committed last. Options, failures and the order of points and triangles
 * are those of rlv_tessellate_detail. It keeps the detail alive. Fails as rlv_tessellate_detail does. */
RLV_API RlvResult rlv_tessellation_create(RlvDetail detail, const RlvTessellateOptions *options, RlvTessellation *out);

RLV_API RlvResult rlv_tessellation_retain(RlvTessellation tessellation);
RLV_API RlvResult rlv_tessellation_release(RlvTessellation tessellation);

/* How many points and triangles there are. No failure of its own. */
RLV_API RlvResult rlv_tessellation_info(RlvTessellation tessellation, RlvTessellationInfo *out);

/* Brings the points to the detail's last commit, however many there were since the last update. Costs what changed,
 * unless triangles are rebuilt or the cage was posed, which concerns all points; triangle meshes cost a look at all
 * points. Colours and traces are renewed too; the ages of traces, where the detail came to another time, are renewed at
 * all points, in the ranges or not. Needs the tessellation for itself and returns RLV_ERROR_BUSY while
 * another call is at work on it; edits of the detail do not matter. After a failure the tessellation is what it was.
 * out may be NULL. */
RLV_API RlvResult rlv_tessellation_update(RlvTessellation tessellation, RlvTessellationChanges *out);

/* The ranges of points that the last update changed, as pairs of the first point and the number of points, ascending. A
 * point changed if a bit of its position, normal, colour or trace did, but for ages that only time changed; all did where
 * the detail got colours or traces, or colours of another format. Each range begins and ends with a point that changed; it
 * may have gaps of at most 8 points that did not. Before the first update all points are in one range. Writes up to
 * capacity pairs to ranges, and the number of ranges to count. ranges may be NULL to ask for the number. Fails if capacity is too small for them. */
RLV_API RlvResult rlv_tessellation_changed_ranges(RlvTessellation tessellation, uint32_t *ranges, size_t capacity,
                                                  size_t *count);

/* Copies positions and unit normals of count points from first on, three floats each. Strides are in bytes, 0 for
 * packed; either array may be NULL. Fails, and writes nothing, if there are not as many points. */
RLV_API RlvResult rlv_tessellation_get_points(RlvTessellation tessellation, size_t first, size_t count,
                                              float *positions, size_t position_stride, float *normals,
                                              size_t normal_stride);

/* Copies the colours of count points from first on, linear Rec.709, three floats each. Fails if the detail has none. */
RLV_API RlvResult rlv_tessellation_get_colors(RlvTessellation tessellation, size_t first, size_t count, float *colors,
                                              size_t stride);

/* Copies the traces of count points from first on: contact, depth and age, three floats each, as RlvEvaluateArrays has
 * them. Fails if the detail has none. */
RLV_API RlvResult rlv_tessellation_get_traces(RlvTessellation tessellation, size_t first, size_t count, float *traces,
                                              size_t stride);

/* A copy of all triangles with their attributes as a mesh, as rlv_tessellate_detail makes it: for the start, and for
 * when they were rebuilt. No failure of its own. */
RLV_API RlvResult rlv_tessellation_mesh(RlvTessellation tessellation, RlvMesh *out);

#endif
