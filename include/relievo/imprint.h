/* Relievo: imprints of colliders on details.
 *
 * Where a collider overlaps a detail in the world, the surface gives way along its inward normal until it is outside
 * the collider. The overlap is divided into voxels, so the result is exact to about one voxel's diagonal. Two details
 * that press each other are both cages. */
#ifndef RELIEVO_IMPRINT_H
#define RELIEVO_IMPRINT_H

#include "relievo/collider.h"
#include "relievo/parameter.h"

/* How a collider imprints itself. rlv_imprint_params has ranges, units and defaults of every field. */
typedef struct RlvImprintSettings {
    uint32_t struct_size;
    uint32_t voxels;        /* voxels an overlap is divided into at most, one bit each */
    float jitter;           /* largest random turn of the voxel grid per frame about each axis, rad */
    uint32_t seed;          /* of the random turns */
    float max_displacement; /* largest distance by which a surface may be displaced inwards, object units */
    float share;            /* share of the penetration that the surface gives way to, 0 to 1 */
    float depth_limit;      /* largest distance by which it gives way in one call, object units */
    float smoothing;        /* strength of the smoothing of what changed, 0 for none, to 1 */
    uint32_t smoothing_passes;
    uint32_t sub_steps;  /* most sub-steps of a movement */
    uint32_t culling;    /* 1, or 0 to look at the whole surface, for comparison; triangle meshes are always culled */
    uint32_t compaction; /* 1, or 0 to update all tiles, for comparison; triangle meshes update changed triangles only */
    float rim;           /* share of the pushed volume that rises around the contact, 0 for no rim, to 1 */
    float rim_width;     /* distance from the contact at which a rim ends, object units */
    float repose;        /* steepest slope of a rim, rad; what would make it steeper is lost */
} RlvImprintSettings;

#define RLV_IMPRINT_SETTINGS_INIT \
    {sizeof(RlvImprintSettings), 16777216, 0.09817477f, 0, 1.0f, 1.0f, 60000.0f, 0.0f, 1, 256, 1, 1, 0.0f, 0.1f, 0.6f}

/* Which imprint this is; the random turn of the voxel grid depends on it and on the seed alone. */
typedef struct RlvImprintMoment {
    uint32_t struct_size;
    uint32_t pair;  /* of objects, any number of the host's */
    uint64_t frame; /* of the animation */
    uint32_t step;  /* of the frame */
    uint32_t reserved;
} RlvImprintMoment;

#define RLV_IMPRINT_MOMENT_INIT {sizeof(RlvImprintMoment), 0, 0, 0, 0}

/* What an imprint did. */
typedef struct RlvImprintReport {
    uint32_t struct_size;
    uint32_t reserved;
    uint64_t steps;        /* imprints that were made, 1 but for a sweep */
    uint64_t wanted_steps; /* imprints that leave a track without gaps; more than were made if sub_steps forbids them */
    uint64_t tested_tiles; /* tiles whose coefficients were ray cast */
    uint64_t tested_coefficients;
    uint64_t changed_tiles;
    uint64_t changed_coefficients;
    uint64_t allocated_tiles; /* that were not before, neighbours included */
    uint64_t refused_tiles;   /* that the budget refused; they stayed as they were, and the context's log says so */
    uint64_t clamped_rays;    /* that left the voxels inside the collider and were held at their border */
    uint64_t triangles;       /* of the collider that were voxelised */
    uint64_t bytes;           /* of the detail's tiles afterwards */
    double voxel_diagonal;    /* world units; 0 if the boxes do not meet */
    double pushed_volume;     /* that was pushed away, object units cubed; 0 unless a rim is asked for */
    double raised_volume;     /* that rose as a rim */
    uint64_t open_edges;      /* of the collider; how it is solid nevertheless is in collider.h */
} RlvImprintReport;

#define RLV_IMPRINT_REPORT_INIT {sizeof(RlvImprintReport), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}

/* The fields of RlvImprintSettings in order: a table that lives as long as the process, and its length. No failure of
 * its own. */
RLV_API RlvResult rlv_imprint_params(const RlvParameter **params, size_t *count);

/* Edits the detail: presses the collider into it where both are. settings and moment may be NULL for the defaults,
 * report may be NULL. The result is visible after rlv_detail_commit. Fails, and changes nothing, if a setting is out of
 * range, if the active layer of the displacement is hidden, with RLV_ERROR_BUSY if another edit of the detail or a
 * change of the collider is at work, and with RLV_ERROR_UNSUPPORTED if the collider is too large for its overlap. */
RLV_API RlvResult rlv_imprint_run(RlvDetail detail, RlvCollider collider, const RlvImprintSettings *settings,
                                  const RlvImprintMoment *moment, RlvImprintReport *report);

/* Edits the detail, and mutates the collider: moves it from one place to another and presses it in at sub-steps, so
 * many that no point of it travels further than a quarter of the smallest edge of its box between two of them, but no
 * more than the settings allow. So a fast wheel leaves a track and not dots. from and to are matrices as for
 * rlv_collider_create_mesh; the collider is at to afterwards. progress may be NULL; it is asked before every sub-step
 * and once at the end, with 1; while it runs the detail and the collider are busy. If it cancels, at the end too, both
 * are as before the call. Fails, and changes nothing, as rlv_imprint_run does, if a matrix is singular, and if progress
 * asks to stop. */
RLV_API RlvResult rlv_imprint_sweep(RlvDetail detail, RlvCollider collider, const double *from, const double *to,
                                    const RlvImprintSettings *settings, const RlvImprintMoment *moment,
                                    RlvProgress progress, void *user, RlvImprintReport *report);

/* As rlv_imprint_sweep, for a collider that also deforms: from_points and to_points are its count points in object space
 * at either place, in the order of the mesh it was made from, stride bytes apart, 0 for packed; between the two they
 * move on lines, which the number of sub-steps takes into account. The collider has to_points afterwards. Edits the
 * detail, and mutates the collider, on the calling thread. Fails, and changes nothing, as rlv_imprint_sweep does, if
 * count is another number than the collider's points, and if a coordinate is not finite. */
RLV_API RlvResult rlv_imprint_sweep_points(RlvDetail detail, RlvCollider collider, const double *from, const double *to,
                                           const float *from_points, const float *to_points, size_t count,
                                           size_t stride, const RlvImprintSettings *settings,
                                           const RlvImprintMoment *moment, RlvProgress progress, void *user,
                                           RlvImprintReport *report);

/* Edits both details: presses them into each other where they are. The first gives way by its share of the penetration,
 * then the second to what the first has become, by its share of what remains (1 to leave no overlap). Settings and
 * moment may be NULL for the defaults, reports may be NULL; a share of 0.5 for the first and 1 for the second shares
 * the dent evenly. Commit both to see it. If it fails, both are as before. */
RLV_API RlvResult rlv_imprint_collide(RlvDetail first, RlvDetail second, const RlvImprintSettings *first_settings,
                                      const RlvImprintSettings *second_settings, const RlvImprintMoment *moment,
                                      RlvImprintReport *first_report, RlvImprintReport *second_report);

#endif
