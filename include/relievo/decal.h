/* Relievo: decals, stickers cut out of an image that lie on a surface exactly at given points.
 *
 * A sticker is the part of an image within an outline. Each pin is a point of the image with the place of the surface that
 * it belongs to. The map has its pins exactly there, flips no triangle and stretches as little as it can (multiple-constrained
 * decaling, Journal of WSCG 21, 2013; symmetric Dirichlet energy, Smith and Schaefer 2015). The decal can be followed while a
 * pin is dragged, written into the layers of a detail, or made a mesh with texture coordinates.
 *
 * Points of the image are in pixels from its lower left corner; lengths are in object units. Results do not depend on the
 * number of threads. */
#ifndef RELIEVO_DECAL_H
#define RELIEVO_DECAL_H

#include "relievo/detail.h"
#include "relievo/document.h"
#include "relievo/layer.h"

typedef struct RlvDecal {
    uint64_t id;
} RlvDecal;

/* A point of the image and the place of the surface that it belongs to. */
typedef struct RlvDecalPin {
    double image[2];    /* pixels, within the outline */
    double position[3]; /* the pin belongs to the nearest place of the surface, object units */
    double depth;       /* where the sticker overlaps itself, the part near pins of larger depths lies on top */
} RlvDecalPin;

/* The sticker, and how it is laid. Strides are in bytes, 0 for packed. */
typedef struct RlvDecalOptions {
    uint32_t struct_size;
    uint32_t width;        /* of the image, 1 to 32768 pixels */
    uint32_t height;       /* of the image, 1 to 32768 pixels */
    uint32_t can_overlap;  /* 1: the sticker may lie on a part of the surface more than once, as around a finger */
    const double *outline; /* x and y of each corner, pixels; NULL for the whole image */
    size_t outline_count;  /* corners, 3 to 65536 */
    size_t outline_stride;
    double pose_width;     /* with one pin: the width of the whole image on the surface, object units */
    double pose_up[3];     /* with one pin: the direction in space that is up in the image */
    uint32_t steps;        /* Newton steps of the last relaxation, 1 to 1000 */
    float decrease;        /* the expected decrease of the distortion, as a share, that is not worth a step; 0 or more */
    uint32_t triangles;    /* the most triangles of the decal */
    uint32_t cells;        /* of details: cells along an edge of the cage that the decal lies on, a power of two */
} RlvDecalOptions;

#define RLV_DECAL_OPTIONS_INIT \
    {sizeof(RlvDecalOptions), 0, 0, 0, NULL, 0, 0, 0.0, {0.0, 1.0, 0.0}, 30, 0.0001f, 4000000, 8}

/* How a decal lies. */
typedef struct RlvDecalQuality {
    uint32_t struct_size;
    uint32_t pin_count;
    size_t triangle_count;
    size_t flip_count;    /* triangles that are turned over: 0 */
    size_t overlap_count; /* faces of the surface under more than one layer of the sticker */
    double l2;            /* root mean square stretch (Sander et al. 2001), 1 for an isometric map */
    double l_infinity;    /* the largest stretch, scaled likewise */
    double worst_angle;   /* the largest difference of an angle between image and surface, radians */
    double area_ratio;    /* the largest ratio of the scale of an area to the mean scale, or its inverse */
    double coverage;      /* the share of the sticker that lies on the surface, 0 to 1 */
    double doubled;       /* the share of the sticker that lies on more than one place of the surface, 0 to 1 */
} RlvDecalQuality;

#define RLV_DECAL_QUALITY_INIT {sizeof(RlvDecalQuality), 0, 0, 0, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}

/* The pixels of the image: linear Rec.709 and alpha that is not premultiplied, row by row from the top. */
typedef struct RlvDecalImage {
    uint32_t struct_size;
    uint32_t channels; /* 1 for grey, 3 for colour, 4 for colour and alpha */
    const float *pixels;
    size_t pixel_count; /* width times height of the sticker */
} RlvDecalImage;

#define RLV_DECAL_IMAGE_INIT {sizeof(RlvDecalImage), 4, NULL, 0}

/* Where and how a decal is written. */
typedef struct RlvDecalInk {
    uint32_t struct_size;
    uint32_t channel; /* RLV_CHANNEL_COLOR, RLV_CHANNEL_DISPLACEMENT or RLV_CHANNEL_VECTORS */
    uint32_t blend;   /* an RLV_BLEND_ value that its channel has; of vectors RLV_BLEND_ADD or RLV_BLEND_SUBTRACT */
    float opacity;    /* 0 to 1 */
    float height;     /* of displacement and vectors: what 1 in the image stands for, object units, -60000 to 60000 */
    uint32_t reserved;
} RlvDecalInk;

#define RLV_DECAL_INK_INIT {sizeof(RlvDecalInk), RLV_CHANNEL_COLOR, RLV_BLEND_NORMAL, 1.0f, 0.0f, 0}

/* A texture that a decal is painted into: linear, row by row from the top, of alpha that is not premultiplied. */
typedef struct RlvDecalTexture {
    uint32_t struct_size;
    uint32_t width;    /* pixels */
    uint32_t height;   /* pixels */
    uint32_t channels; /* 1 for grey, 2 for grey and alpha, 3 for colour, 4 for colour and alpha */
    uint32_t gutter;   /* pixels around islands that continue what is painted, 0 to 256 */
    uint32_t reserved;
    float *pixels;
    size_t pixel_count; /* width times height */
} RlvDecalTexture;

#define RLV_DECAL_TEXTURE_INIT {sizeof(RlvDecalTexture), 0, 0, 3, 8, 0, NULL, 0}

/* What writing a decal changed. */
typedef struct RlvDecalReport {
    uint32_t struct_size;
    uint32_t reserved;
    uint64_t changed_tiles; /* of a triangle mesh: faces */
    uint64_t texels;        /* under the sticker; of a triangle mesh: values */
    uint64_t refused_tiles; /* by the budget: the sticker is missing there */
} RlvDecalReport;

#define RLV_DECAL_REPORT_INIT {sizeof(RlvDecalReport), 0, 0, 0, 0}

/* A decal that a document keeps in a layer of its own. */
typedef struct RlvDecalRecipe {
    uint32_t struct_size;
    uint32_t id;         /* its number in the document */
    uint32_t layer;      /* the number of its layer */
    uint32_t pin_count;
    uint32_t width;      /* of the image, pixels */
    uint32_t height;     /* of the image, pixels */
    uint32_t channel;    /* RLV_CHANNEL_COLOR or RLV_CHANNEL_DISPLACEMENT */
    uint32_t blend;      /* an RLV_BLEND_ value */
    float opacity;       /* 0 to 1 */
    float relief;        /* of displacement: what 1 in the image stands for, object units */
    uint64_t image_hash; /* FNV-1a over width, height, channels and the bits of all pixels, numbers of 32 bits */
} RlvDecalRecipe;

#define RLV_DECAL_RECIPE_INIT {sizeof(RlvDecalRecipe), 0, 0, 0, 0, 0, 0, 0, 0.0f, 0.0f, 0}

/* Lays a sticker on the triangles of a mesh. progress may be NULL. Fails if a pin or the options are out of range, pins lie
 * on different components, the sticker would fold at a pin or exceeds the triangles allowed; the message names the pin and
 * proposes a place for it. */
RLV_API RlvResult rlv_decal_on_mesh(RlvMesh mesh, const RlvDecalOptions *options, const RlvDecalPin *pins, size_t count,
                                    size_t stride, RlvProgress progress, void *user, RlvDecal *out);

/* Lays a sticker on the displaced surface of a detail as it was committed last. A Catmull-Clark surface is
 * divided into options->cells cells along an edge for it, a triangle mesh as finely as its layers are. Fails as
 * rlv_decal_on_mesh. */
RLV_API RlvResult rlv_decal_on_detail(RlvDetail detail, const RlvDecalOptions *options, const RlvDecalPin *pins,
                                      size_t count, size_t stride, RlvProgress progress, void *user, RlvDecal *out);

RLV_API RlvResult rlv_decal_retain(RlvDecal decal);
RLV_API RlvResult rlv_decal_release(RlvDecal decal);

/* Measures the decal as it lies now. No failure of its own. */
RLV_API RlvResult rlv_decal_quality(RlvDecal decal, RlvDecalQuality *out);

/* Makes a mesh of the decal with the point attributes `uv`, 0 to 1 from left to right and from bottom to top of the image,
 * and `normal`, lifted off the surface by offset. Fails if offset is not finite. */
RLV_API RlvResult rlv_decal_mesh(RlvDecal decal, double offset, RlvMesh *out);

/* Moves a pin to the place of the surface nearest to a position of three numbers. The map follows from its last state; its
 * triangles stay until rlv_decal_settle. Fails, and changes nothing, if there is no such pin, the place is not under the
 * sticker, or the sticker cannot follow without folds. */
RLV_API RlvResult rlv_decal_drag_pin(RlvDecal decal, size_t pin, const double *position);

/* Moves the point of the image that a pin belongs to, two numbers in pixels, and settles the decal. Fails, and changes
 * nothing, if there is no such pin, the point is not within the outline, or as rlv_decal_settle. */
RLV_API RlvResult rlv_decal_move_image(RlvDecal decal, size_t pin, const double *image, RlvProgress progress, void *user);

/* Lays a decal on a mesh anew where count points of its mesh moved. Fails, and changes nothing, if there are more or fewer
 * points, one is not finite, the decal is on a detail, or as rlv_decal_settle. */
RLV_API RlvResult rlv_decal_pose(RlvDecal decal, const float *points, size_t count, size_t stride, RlvProgress progress,
                                 void *user);

/* Lowers the distortion after pins were dragged and lets the decal grow and shrink until it covers the sticker. Fails, and
 * changes nothing, if the sticker would fold; with RLV_ERROR_CANCELLED if progress, which may be NULL, says so. */
RLV_API RlvResult rlv_decal_settle(RlvDecal decal, RlvProgress progress, void *user);

/* Paints a decal that lies on a detail over the active layer of colour: an edit as strokes are. opacity is 0 to 1; report
 * may be NULL. Fails, and changes nothing, if the detail has no colours or the active layer cannot be seen, the decal lies on
 * a mesh, or the image has other pixels than the sticker. */
RLV_API RlvResult rlv_decal_paint(RlvDecal decal, const RlvDecalImage *image, float opacity, RlvDecalReport *report);

/* Raises the displacement of the detail by height, object units, where the image is white and opaque, not where it is black
 * or transparent. Fails as rlv_decal_paint. */
RLV_API RlvResult rlv_decal_emboss(RlvDecal decal, const RlvDecalImage *image, float height, RlvDecalReport *report);

/* Writes a decal that lies on a detail into a channel, with a blend mode and an opacity; ink may be NULL for its initial
 * values. In RLV_CHANNEL_VECTORS red moves along the image's direction to the right on the surface, green along the one
 * upwards, blue along the normal: by -height at 0, not at all at 0.5, by height at 1. Vectors have no layers. Fails, and
 * changes nothing, if the channel is another one, the detail has it not, the blend mode is not for it, or as
 * rlv_decal_paint. */
RLV_API RlvResult rlv_decal_write(RlvDecal decal, const RlvDecalImage *image, const RlvDecalInk *ink,
                                  RlvDecalReport *report);

/* Paints a decal that lies on a mesh with texture coordinates `uv` of points or corners over the pixels of its texture. The
 * number of pixels that the decal changed, without those of the gutter, goes to painted, which may be NULL. Fails, and
 * changes nothing, if the decal lies on a mesh without texture coordinates or with some outside of 0 to 1, the opacity is
 * not in 0 to 1, or the image or the texture has another number of pixels. */
RLV_API RlvResult rlv_decal_paint_texture(RlvDecal decal, const RlvDecalImage *image, float opacity,
                                          const RlvDecalTexture *texture, size_t *painted);

/* Finds the outline of an image of width by height pixels, with alpha: the contour at which alpha is level, above 0 and below
 * 1, simplified by at most tolerance, 0 to 1000 pixels. Writes up to capacity corners, x and y of each in pixels, to corners,
 * counter-clockwise, and their number to count; corners may be NULL to ask for the number. Fails if there are more than
 * capacity, the image has no alpha or none above level, or several parts that are larger than the tolerance. */
RLV_API RlvResult rlv_decal_contour(const RlvDecalImage *image, uint32_t width, uint32_t height, double level,
                                    double tolerance, double *corners, size_t capacity, size_t *count);

/* Places a sticker as a strip along a curve through count places of a mesh, three numbers each: the middle line of the outline
 * of options lies along geodesics between the places. Writes up to capacity pins for rlv_decal_on_mesh to pins, which may be
 * NULL to ask for their number, that number to pin_count, and the length of the curve, object units, to length, which may be
 * NULL. Fails if there are more than capacity, fewer than 2 or more than 512 places, or two that follow each other are the
 * same or on different components. */
RLV_API RlvResult rlv_decal_strip_on_mesh(RlvMesh mesh, const RlvDecalOptions *options, const double *curve,
                                          size_t count, size_t stride, RlvDecalPin *pins, size_t capacity,
                                          size_t *pin_count, double *length);

/* As rlv_decal_strip_on_mesh, for rlv_decal_on_detail with the same options. Fails as that does. */
RLV_API RlvResult rlv_decal_strip_on_detail(RlvDetail detail, const RlvDecalOptions *options, const double *curve,
                                            size_t count, size_t stride, RlvDecalPin *pins, size_t capacity,
                                            size_t *pin_count, double *length);

/* Writes the present pins of a decal, in their order, to pins, which may be NULL to ask for their number, and that
 * number to count. Fails if there are more than capacity. */
RLV_API RlvResult rlv_decal_pins(RlvDecal decal, RlvDecalPin *pins, size_t capacity, size_t *count);

/* Writes the number of decals that a document keeps. No failure of its own. */
RLV_API RlvResult rlv_decal_count(RlvDocument document, size_t *count);

/* Describes a decal of a document, by its place from 0 on. Fails if there is none or it is damaged. */
RLV_API RlvResult rlv_decal_recipe(RlvDocument document, size_t index, RlvDecalRecipe *out);

/* Writes a decal that lies on the detail of a document into a new layer called layer, above those of its kind, of colour or
 * displacement, and keeps its pins, its sticker and its settings in the document: one edit, that can be undone. Blend mode and
 * opacity become those of the layer; ink may be NULL for its initial values. The decal is laid anew, on the detail as it was
 * edited last. Its number goes to id. Fails, and changes nothing, if the decal lies on something else, an edit is under way,
 * the name is taken, or as rlv_decal_on_detail and rlv_decal_write. */
RLV_API RlvResult rlv_decal_apply(RlvDecal decal, RlvDocument document, const char *layer, const RlvDecalImage *image,
                                  const RlvDecalInk *ink, RlvProgress progress, void *user, uint32_t *id);

/* Lays a decal of a document again, on the detail as it was committed last: so its pins can be moved. Fails if there is no
 * such decal, or as rlv_decal_on_detail. */
RLV_API RlvResult rlv_decal_take_up(RlvDocument document, uint32_t id, RlvProgress progress, void *user, RlvDecal *out);

/* Writes a decal of a document anew, in place of what its layer has: with the pins, sticker and settings of decal, which was
 * taken up or laid on the same detail. It is laid on the surface without it. A NULL ink keeps that of the layer. One edit.
 * Fails, and changes nothing, if there is no such decal or its layer is gone, the ink is for layers of another kind, or as
 * rlv_decal_apply. */
RLV_API RlvResult rlv_decal_update(RlvDecal decal, RlvDocument document, uint32_t id, const RlvDecalImage *image,
                                   const RlvDecalInk *ink, RlvProgress progress, void *user);

/* Removes a decal of a document with its layer: one edit. Fails, and changes nothing, if there is no such decal, or its layer
 * is gone or the last of its kind. */
RLV_API RlvResult rlv_decal_remove(RlvDocument document, uint32_t id);

#endif
