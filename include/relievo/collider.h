/* Relievo: colliders, triangle meshes that imprint themselves on details.
 *
 * A collider whose every edge is met by the same edge in the opposite direction is closed and solid inside, also where
 * shells overlap. Points that coincide when it is made, within 4e-6 of the largest coordinate, are one as long as they
 * move together, so a mesh whose vertices are split along seams is closed.
 *
 * The other edges are open. They bound holes, each of which is covered by triangles from its edges to its middle, and the
 * collider is solid inside: never outside of its own box. A sheet, an open collider whose faces point one way by more
 * than half of their area, has no inside: it is solid behind its front, the side from which its corners are
 * counter-clockwise, as far as max_displacement of the imprint reaches. */
#ifndef RELIEVO_COLLIDER_H
#define RELIEVO_COLLIDER_H

#include "relievo/parameter.h"
#include "relievo/tessellate.h"

typedef struct RlvCollider {
    uint64_t id;
} RlvCollider;

typedef struct RlvColliderInfo {
    uint32_t struct_size;
    uint32_t is_closed; /* 1 if the mesh has no open edge, else 0 */
    size_t point_count;
    size_t triangle_count;
    double matrix[12];      /* from object space to the world, in columns, the translation last */
    size_t open_edge_count; /* edges that no edge in the opposite direction meets */
} RlvColliderInfo;

#define RLV_COLLIDER_INFO_INIT {sizeof(RlvColliderInfo), 0, 0, 0, {0}, 0}

/* How a tool yields to a force. rlv_collider_press_params has ranges, units and defaults. */
typedef struct RlvToolSettings {
    uint32_t struct_size;
    float stiffness; /* force that displaces one cubic world unit of material */
    float max_depth; /* largest depth to which the tool sinks, world units */
} RlvToolSettings;

#define RLV_TOOL_SETTINGS_INIT {sizeof(RlvToolSettings), 1.0f, 1.0f}

/* Makes a collider of a mesh, which may be released or changed afterwards. matrix is twelve doubles, the affine map
 * from object space to the world in columns: three for the linear part, then the translation; NULL for the identity.
 * Fails if the mesh has no triangles, a number is not finite, or the matrix is singular. */
RLV_API RlvResult rlv_collider_create_mesh(RlvContext context, RlvMesh mesh, const double *matrix, RlvCollider *out);

/* Makes a collider of the triangles of a limit surface in its present pose; options as for rlv_tessellate_surface.
 * Triangles should be smaller than a voxel of the imprint. Fails as rlv_tessellate_surface and rlv_collider_create_mesh
 * do. */
RLV_API RlvResult rlv_collider_create_surface(RlvSurface surface, const RlvTessellateOptions *options,
                                              const double *matrix, RlvCollider *out);

/* Makes a collider of a detail as it was committed last, at its place in the world, displacement included. For two
 * details that deform each other: make a collider of each, imprint each with a share of its own, commit both. Fails as
 * rlv_tessellate_detail and rlv_collider_create_mesh do. */
RLV_API RlvResult rlv_collider_create_detail(RlvDetail detail, const RlvTessellateOptions *options, RlvCollider *out);

RLV_API RlvResult rlv_collider_retain(RlvCollider collider);
RLV_API RlvResult rlv_collider_release(RlvCollider collider);

/* What the collider is, and where. No failure of its own. */
RLV_API RlvResult rlv_collider_info(RlvCollider collider, RlvColliderInfo *out);

/* Mutating. Moves the collider; matrix as for rlv_collider_create_mesh. Fails, and changes nothing, if the matrix is
 * singular or not finite. */
RLV_API RlvResult rlv_collider_set_transform(RlvCollider collider, const double *matrix);

/* Mutating. Deforms the collider: count is its number of points, in the order of the mesh it was made from. Fails, and
 * changes nothing, if count is another number or a coordinate is not finite. */
RLV_API RlvResult rlv_collider_set_points(RlvCollider collider, const float *points, size_t count, size_t stride);

/* The fields of RlvToolSettings in order: a table that lives as long as the process, and its length. No failure of its
 * own. */
RLV_API RlvResult rlv_collider_press_params(const RlvParameter **params, size_t *count);

/* Mutating. Places a tool as a pen presses it: in its present rotation, its foremost point against the normal at the
 * place, three doubles in the world, and sunk until the material it displaces carries the force. Then imprint it.
 * settings may be NULL for the defaults. Fails if the collider is not closed or the force is negative. */
RLV_API RlvResult rlv_collider_press(RlvCollider collider, const double *place, const double *normal, double force,
                                     const RlvToolSettings *settings);

#endif
