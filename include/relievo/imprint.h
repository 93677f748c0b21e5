/* Relievo: imprints of colliders on details.
 *
 * Where a collider overlaps a detail in the world, the surface gives way along its inward normal until it is outside
 * the collider. The overlap is divided into voxels, so the result is exact to about one voxel's diagonal. */
#ifndef RELIEVO_IMPRINT_H
#define RELIEVO_IMPRINT_H

#include "relievo/collider.h"

typedef enum RlvParameterKind {
    RLV_PARAMETER_F32 = 0, /* float */
    RLV_PARAMETER_U32 = 1, /* uint32_t */
    RLV_PARAMETER_BOOL = 2 /* uint32_t, 0 or 1 */
} RlvParameterKind;

/* One field of a settings struct, from which a host can make its panel. The texts are UTF-8 and live as long as the
 * process. */
typedef struct RlvParameter {
    const char *name; /* of the field */
    const char *unit; /* "" for a pure number, "rad", "object units" */
    const char *help; /* what it does, one sentence or two */
    uint32_t kind;    /* RlvParameterKind */
    uint32_t offset;  /* bytes from the start of the struct */
    double min;       /* smallest value */
    double max;       /* largest value */
    double value;     /* what the RLV_..._INIT has */
} RlvParameter;

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
    uint32_t culling;    /* 1, or 0 to look at the whole surface, for comparison */
    uint32_t compaction; /* 1, or 0 to update all tiles, for comparison */
} RlvImprintSettings;

#define RLV_IMPRINT_SETTINGS_INIT \
    {sizeof(RlvImprintSettings), 16777216, 0.09817477f, 0, 1.0f, 1.0f, 60000.0f, 0.0f, 1, 256, 1, 1}

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
    uint32_t steps;             /* sub-steps that were made */
    uint64_t tested_tiles;      /* tiles whose coefficients were ray cast */
    uint64_t tested_coefficients;
    uint64_t changed_tiles;
    uint64_t changed_coefficients;
    uint64_t allocated_tiles; /* that were not before, neighbours included */
    uint64_t refused_tiles;   /* that the budget refused; they stayed as they were, and the context's log says so */
    uint64_t clamped_rays;    /* that left the voxels inside the collider and were held at their border */
    uint64_t triangles;       /* of the collider that were voxelised */
    uint64_t bytes;           /* of the detail's tiles afterwards */
    double voxel_diagonal;    /* world units; 0 if the boxes do not meet */
} RlvImprintReport;

#define RLV_IMPRINT_REPORT_INIT {sizeof(RlvImprintReport), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}

/* The fields of RlvImprintSettings in order: a table that lives as long as the process, and its length. */
RLV_API RlvResult rlv_imprint_params(const RlvParameter **params, size_t *count);

/* Edits the detail: presses the collider into it where both are. settings and moment may be NULL for the defaults,
 * report may be NULL. The result is visible after rlv_detail_commit. Fails, and changes nothing, if a setting is out of
 * range, with RLV_ERROR_BUSY if another edit of the detail or a change of the collider is at work, and with
 * RLV_ERROR_UNSUPPORTED if the collider is too large for its overlap. */
RLV_API RlvResult rlv_imprint_run(RlvDetail detail, RlvCollider collider, const RlvImprintSettings *settings,
                                  const RlvImprintMoment *moment, RlvImprintReport *report);

#endif
