/* Relievo: strokes of brushes over details.
 *
 * A stroke puts dabs of its brush on the surface along its points. What counts for all of them is the surface as it was
 * when the stroke began, so that a stroke that raises it does not climb its own ridge. A stroke can be made at once, or
 * be drawn: its points then come a few at a time, from the events of a tablet, and the result is the same to the
 * bit. */
#ifndef RELIEVO_STROKE_H
#define RELIEVO_STROKE_H

#include "relievo/brush.h"
#include "relievo/detail.h"

typedef struct RlvStroke {
    uint64_t id;
} RlvStroke;

typedef struct RlvStrokePoint {
    double position[3]; /* near the surface, world units */
    double pressure;    /* 0 to 1 */
    double time;        /* seconds, which do not go back, for airbrushes; -1 for none */
} RlvStrokePoint;

/* What the dabs of a call did. */
typedef struct RlvStrokeReport {
    uint32_t struct_size;
    uint32_t reserved;
    uint64_t dabs;
    uint64_t missed_dabs; /* that were left out because the surface is too far away */
    uint64_t tested_tiles;
    uint64_t tested_texels;
    uint64_t changed_tiles;
    uint64_t changed_texels;
    uint64_t allocated_tiles; /* that were not before, neighbours included */
    uint64_t freed_tiles;     /* that an eraser gave back */
    uint64_t refused_tiles;   /* that the budget refused; they stayed as they were, and the context's log says so */
    uint64_t bytes;           /* of the tiles that were painted or sculpted, afterwards */
} RlvStrokeReport;

#define RLV_STROKE_REPORT_INIT {sizeof(RlvStrokeReport), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}

/* Edits the detail: makes a whole stroke. stride is in bytes from point to point, 0 for packed; report may be NULL. The
 * result is visible after rlv_detail_commit. Fails, and changes nothing, if there are no points, a number is out of its
 * range, or the detail has no colours and is to be painted. */
RLV_API RlvResult rlv_stroke_run(RlvDetail detail, RlvBrush brush, const RlvStrokePoint *points, size_t count,
                                 size_t stride, RlvStrokeReport *report);

/* Begins a stroke that is drawn, with the brush's present settings. Nothing else should edit the detail until the
 * stroke has ended; if it does, dabs go by a surface that is no more. It keeps the detail alive. Fails as
 * rlv_stroke_run does, but for the points. */
RLV_API RlvResult rlv_stroke_begin(RlvDetail detail, RlvBrush brush, RlvStroke *out);

RLV_API RlvResult rlv_stroke_retain(RlvStroke stroke);
RLV_API RlvResult rlv_stroke_release(RlvStroke stroke);

/* Edits the detail: goes on to the points and makes the dabs on the way. Commit to see them. The first dab waits for
 * the second place, which says where it looks, unless it is an airbrush's. Fails, and changes nothing, as
 * rlv_stroke_run does. */
RLV_API RlvResult rlv_stroke_extend(RlvStroke stroke, const RlvStrokePoint *points, size_t count, size_t stride,
                                    RlvStrokeReport *report);

/* Edits the detail: makes what dabs are left and ends the stroke. Fails if it has no points, and if it has ended. */
RLV_API RlvResult rlv_stroke_end(RlvStroke stroke, RlvStrokeReport *report);

#endif
