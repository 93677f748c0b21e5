/* Relievo: surfaces, which are Catmull-Clark limit surfaces or triangle meshes.
 *
 * A limit surface is made from a control cage with its creases, sharp points, boundaries, holes and n-gons. Its places
 * are (tile, u, v) with u and v from 0 to 1: one tile per quad face, n tiles per face of n other than four corners, in
 * face order. Corners of a tile are 0 = (0,0), 1 = (1,0), 2 = (1,1), 3 = (0,1). A quad's corners are its face's. Tile k
 * of another face has corner 0 at the face's corner k, 1 in the middle of the edge to the next corner, 2 in the middle
 * of the face, 3 in the middle of the edge to the previous corner.
 *
 * A triangle mesh is what it is: flat triangles with normals that are interpolated between those of the points.
 * Polygons are fanned from their first corner, holes left out, anything but a mesh without faces is accepted. Its tiles
 * are its triangles, in order; u and v are the barycentric coordinates of the second and third corner, which make at
 * most 1 together. Large triangles hold no fine detail: see rlv_mesh_split. What is said of cages and limit surfaces in
 * the headers holds for triangle meshes, unless they say otherwise. */
#ifndef RELIEVO_SURFACE_H
#define RELIEVO_SURFACE_H

#include "relievo/mesh.h"

typedef struct RlvSurface {
    uint64_t id;
} RlvSurface;

typedef enum RlvBoundary {
    RLV_BOUNDARY_EDGES_AND_CORNERS = 0, /* boundary edges are sharp, and so are boundary points of one face */
    RLV_BOUNDARY_EDGES = 1,             /* boundary edges are sharp, corners are rounded */
    RLV_BOUNDARY_NONE = 2               /* faces at boundary points shape their neighbours and become holes */
} RlvBoundary;

typedef enum RlvSurfaceKind {
    RLV_SURFACE_CATMULL_CLARK = 0,
    RLV_SURFACE_TRIANGLES = 1,
    /* Of cages of quads: Catmull-Clark with all edges and points made sharp, and so called by rlv_surface_info. Other cages
     * become quads when rlv_subdivision_refine refines them once. */
    RLV_SURFACE_BILINEAR = 2
} RlvSurfaceKind;

typedef struct RlvSurfaceOptions {
    uint32_t struct_size;
    uint32_t boundary;    /* RlvBoundary */
    uint32_t isolation;   /* levels to which extraordinary features are isolated, 1 to 10; 0 for 6. Raised to the
                             largest finite sharpness of the cage. More levels are more exact and more patches. */
    uint32_t patch_limit; /* cages from which more patches are expected are refused; 0 for 8 million */
    uint32_t kind;        /* RlvSurfaceKind; triangle meshes have no use for the other options */
    uint32_t reserved;    /* 0 */
} RlvSurfaceOptions;

#define RLV_SURFACE_OPTIONS_INIT \
    {sizeof(RlvSurfaceOptions), RLV_BOUNDARY_EDGES_AND_CORNERS, 0, 0, RLV_SURFACE_CATMULL_CLARK, 0}

typedef struct RlvSurfaceInfo {
    uint32_t struct_size;
    uint32_t non_manifold; /* 1 if edges of three or more faces were accepted, else 0 */
    size_t point_count;    /* of the cage */
    size_t face_count;     /* of the cage */
    size_t tile_count;     /* those of holes included */
    size_t patch_count;    /* as many as tiles, of a triangle mesh */
    uint64_t bytes;        /* of the patches' control data, or of points and normals */
    float low[3];          /* bounds of the limit surface, conservative */
    float high[3];
    float extent;  /* diagonal of the bounds */
    uint32_t kind; /* RlvSurfaceKind */
} RlvSurfaceInfo;

#define RLV_SURFACE_INFO_INIT {sizeof(RlvSurfaceInfo), 0, 0, 0, 0, 0, 0, {0}, {0}, 0, 0}

typedef struct RlvTileInfo {
    uint32_t struct_size;
    uint32_t face;    /* of the cage */
    uint32_t corner;  /* the face's corner at corner 0 of the tile; 0 for a triangle mesh */
    uint32_t is_part; /* 1 if the tile is one of several of its face */
    uint32_t is_hole; /* 1 if the face is a hole: the tile has a number but no surface */
    float low[3];     /* bounds of the tile's limit surface, conservative */
    float high[3];
} RlvTileInfo;

#define RLV_TILE_INFO_INIT {sizeof(RlvTileInfo), 0, 0, 0, 0, {0}, {0}}

/* Makes the limit surface of a cage, which may be released or changed afterwards. options may be NULL. Non-manifold
 * cages are accepted and logged. Fails with RLV_ERROR_UNSUPPORTED for faces of more corners than OpenSubdiv takes, of other
 * than four under RLV_SURFACE_BILINEAR, and
 * for cages from which more patches than the limit are expected. */
RLV_API RlvResult rlv_surface_create(RlvContext context, RlvMesh cage, const RlvSurfaceOptions *options,
                                     RlvSurface *out);

RLV_API RlvResult rlv_surface_retain(RlvSurface surface);
RLV_API RlvResult rlv_surface_release(RlvSurface surface);

/* The surface in its present pose. No failure of its own. */
RLV_API RlvResult rlv_surface_info(RlvSurface surface, RlvSurfaceInfo *out);

/* Mutating. Poses an animated cage: count is its number of points. The topology is not made again. Calls that started
 * before go on with the pose they started with. Fails, and changes nothing, if count is another number or a coordinate
 * is not finite. */
RLV_API RlvResult rlv_surface_set_points(RlvSurface surface, const float *points, size_t count, size_t stride);

/* Which face a tile is of, and where it is in the present pose. Fails if there is no such tile. */
RLV_API RlvResult rlv_surface_tile_info(RlvSurface surface, uint32_t tile, RlvTileInfo *out);

/* The tiles of a face of the cage: the first and how many. Fails if there is no such face. */
RLV_API RlvResult rlv_surface_face_tiles(RlvSurface surface, uint32_t face, uint32_t *first, uint32_t *count);

#endif
