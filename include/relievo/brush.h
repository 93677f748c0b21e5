/* Relievo: brushes, which paint or sculpt details.
 *
 * A brush is a box on the surface with a function of the place in it, what it does there, and how it follows the points
 * of a stroke. It holds no reference to a detail and can be used on several. */
#ifndef RELIEVO_BRUSH_H
#define RELIEVO_BRUSH_H

#include "relievo/context.h"
#include "relievo/parameter.h"

typedef struct RlvBrush {
    uint64_t id;
} RlvBrush;

typedef enum RlvBrushAction {
    RLV_BRUSH_PAINT = 0, /* changes colours */
    RLV_BRUSH_SCULPT = 1 /* changes displacement */
} RlvBrushAction;

/* What a brush makes of a colour c where its share is s. */
typedef enum RlvPaintMode {
    RLV_PAINT_MIX = 0,      /* c + s (brush - c) */
    RLV_PAINT_ADD = 1,      /* c + s brush; alpha stays */
    RLV_PAINT_MULTIPLY = 2, /* c (1 + s (brush - 1)); alpha stays */
    RLV_PAINT_ERASE = 3,    /* toward what is not painted */
    RLV_PAINT_BLUR = 4,     /* toward the mean of the four neighbours */
    RLV_PAINT_SMEAR = 5     /* toward what the dab before picked up at the same place of the brush */
} RlvPaintMode;

/* What a brush makes of a displacement d where its share is s. */
typedef enum RlvSculptMode {
    RLV_SCULPT_DRAW = 0,    /* d + s height, along the normal of the surface without displacement */
    RLV_SCULPT_SMOOTH = 1,  /* toward the mean of the four neighbours */
    RLV_SCULPT_FLATTEN = 2, /* toward the plane through the middle of the box */
    RLV_SCULPT_ERASE = 3,   /* toward no displacement; tiles without any are given back */
    RLV_SCULPT_CLAY = 4,    /* up to the plane that is the height over the middle of the box, and not beyond */
    RLV_SCULPT_SCRAPE = 5,  /* as flatten, but nothing rises */
    RLV_SCULPT_LAYER = 6,   /* as draw, but dabs of a stroke do not add up */
    RLV_SCULPT_INFLATE = 7, /* outwards by the height across the displaced surface itself */
    /* The last two change vector displacement, which the detail must have; smooth and erase change it too if it has
     * some. */
    RLV_SCULPT_PINCH = 8, /* toward the line through the middle along the third axis; away from it if the height is negative */
    RLV_SCULPT_VECTOR = 9 /* by the stamp's vectors times the height along the axes of the box; without one along the third */
} RlvSculptMode;

/* The share of the edit from the middle of the box to its border. */
typedef enum RlvFalloff {
    RLV_FALLOFF_CONSTANT = 0,
    RLV_FALLOFF_LINEAR = 1,
    RLV_FALLOFF_SMOOTH = 2,
    RLV_FALLOFF_SPHERE = 3,
    RLV_FALLOFF_GAUSSIAN = 4
} RlvFalloff;

/* What pressure is taken as, for what. */
typedef enum RlvCurve { RLV_CURVE_SIZE = 0, RLV_CURVE_STRENGTH = 1, RLV_CURVE_ANGLE = 2 } RlvCurve;

typedef struct RlvBrushOptions {
    uint32_t struct_size;
    uint32_t action;  /* RlvBrushAction */
    uint32_t mode;    /* RlvPaintMode or RlvSculptMode */
    uint32_t falloff; /* RlvFalloff */
    float color[4];   /* linear Rec.709 and alpha, 0 to 10000, to paint with */
    float height;     /* to sculpt with where the share is 1, object units */
    uint32_t reserved;
} RlvBrushOptions;

#define RLV_BRUSH_OPTIONS_INIT \
    {sizeof(RlvBrushOptions), RLV_BRUSH_PAINT, RLV_PAINT_MIX, RLV_FALLOFF_SMOOTH, {1.0f, 1.0f, 1.0f, 1.0f}, 0.1f, 0}

/* How big a brush is and how it follows the points. rlv_brush_params has ranges, units and defaults of every field. */
typedef struct RlvBrushSettings {
    uint32_t struct_size;
    float radius;            /* of the brush on the surface, world units */
    float depth;             /* how far it reaches out of the surface and into it, as a share of the radius */
    float spacing;           /* distance between dabs, as a share of the radius */
    float strength;          /* how much of the edit each dab makes, 0 to 1 */
    float strength_pressure; /* how much of the strength is up to the pressure, 0 to 1 */
    float size_pressure;     /* how much of the radius is up to the pressure, 0 to 1 */
    float angle;             /* by which the brush is turned, from where the stroke goes to its left, rad */
    float angle_pressure;    /* by which full pressure turns it further, rad */
    float jitter_position;   /* how far a dab may be put beside its place, as a share of the radius */
    float jitter_size;       /* how much of the radius is up to chance, 0 to 1 */
    float jitter_strength;   /* how much of the strength is up to chance, 0 to 1 */
    float jitter_angle;      /* by which a dab may be turned either way, rad */
    uint32_t seed;           /* what chance begins with: the same seed is the same stroke */
    float string;            /* on which the brush is drawn along, world units; 0 follows the points */
    float rate;              /* dabs a second of an airbrush, besides those by distance; 0 makes none */
    uint32_t symmetry_x;     /* 1 to make the stroke at x mirrored too, in the space of the object */
    uint32_t symmetry_y;     /* the same at y mirrored */
    uint32_t symmetry_z;     /* the same at z mirrored */
    float reach;             /* how far a point may be from the surface, in radii */
    uint32_t level;          /* what it edits: 0 all texels, 1 half of them along an edge, 2 a quarter; detail stays */
} RlvBrushSettings;

#define RLV_BRUSH_SETTINGS_INIT \
    {sizeof(RlvBrushSettings), 0.1f, 1.0f, 0.25f, 1.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0, 0.0f, 0.0f, 0, 0, 0, 2.0f, 0}

/* An image in the box: what it paints with where the brush's colour is multiplied by it, or heights. */
typedef struct RlvStampOptions {
    uint32_t struct_size;
    uint32_t channel;  /* of a pixel that is the height: 0 to 3 */
    uint32_t width;    /* pixels, 1 to 16384 */
    uint32_t height;   /* pixels; 67108864 pixels at most */
    uint32_t channels; /* numbers of a pixel: 1 grey, 2 grey and alpha, 3 red, green and blue, 4 those and alpha */
    uint32_t reserved;
    const float *pixels; /* row by row from the top, linear Rec.709, copied; alpha is 0 to 1 and not multiplied in */
} RlvStampOptions;

#define RLV_STAMP_OPTIONS_INIT {sizeof(RlvStampOptions), 0, 0, 0, 0, 0, NULL}

/* How the image lies in the box. rlv_brush_stamp_params has ranges, units and defaults of every field. */
typedef struct RlvStampSettings {
    uint32_t struct_size;
    float angle;        /* by which it is turned, from the first axis of the box to the second, rad */
    float repeat;       /* how often it is repeated across the box; once changes nothing beside it */
    uint32_t mirror;    /* 1 to mirror it left to right */
    uint32_t alternate; /* 1 to mirror every other repeat, so that repeats meet without a seam */
    float mid;          /* the number that means no height */
    float scale;        /* how many heights one more than that is */
} RlvStampSettings;

#define RLV_STAMP_SETTINGS_INIT {sizeof(RlvStampSettings), 0.0f, 1.0f, 0, 0, 0.5f, 2.0f}

/* The fields of RlvBrushSettings in order: a table that lives as long as the process, and its length. No failure of its
 * own. */
RLV_API RlvResult rlv_brush_params(const RlvParameter **params, size_t *count);

/* The fields of RlvStampSettings in order. The table lives as long as the process. No failure of its own. */
RLV_API RlvResult rlv_brush_stamp_params(const RlvParameter **params, size_t *count);

/* Makes a brush. settings may be NULL for the defaults. Fails if a number is out of its range. */
RLV_API RlvResult rlv_brush_create(RlvContext context, const RlvBrushOptions *options, const RlvBrushSettings *settings,
                                   RlvBrush *out);

RLV_API RlvResult rlv_brush_retain(RlvBrush brush);
RLV_API RlvResult rlv_brush_release(RlvBrush brush);

/* Mutates the brush: gives it other options and settings; stamp and curves stay. Strokes that were begun do not change.
 * Fails, and changes nothing, as rlv_brush_create does. */
RLV_API RlvResult rlv_brush_set(RlvBrush brush, const RlvBrushOptions *options, const RlvBrushSettings *settings);

/* Mutates the brush: what pressure is taken as for an RlvCurve. points are count pairs of a pressure and what it is
 * taken as, both 0 to 1, with growing pressures; straight lines join them. count 0 takes the pressure itself. Fails,
 * and changes nothing, if there is no such curve, a number is not 0 to 1, the pressures do not ascend, or there are
 * more than 256. */
RLV_API RlvResult rlv_brush_set_curve(RlvBrush brush, uint32_t curve, const double *points, size_t count);

/* Mutates the brush: gives it an image, or none for NULL. settings may be NULL for the defaults. Fails if the image is
 * empty or too large, a number is not finite or beyond what stamps may hold, or the image does not have the channel;
 * after a failure the brush has the image that it had. */
RLV_API RlvResult rlv_brush_set_stamp(RlvBrush brush, const RlvStampOptions *options, const RlvStampSettings *settings);

#endif
