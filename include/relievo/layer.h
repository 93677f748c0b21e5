/* Relievo: layers of details.
 *
 * A detail has a stack of layers of displacement and, with colours, one of colour; at first one layer each. What is
 * evaluated is what all of them come to. Edits go to the active layer of their kind: strokes of paint see that layer
 * alone, strokes that sculpt and imprints see all, and what they change goes to the active layer. Layers have numbers,
 * which they keep, and names. All functions edit the detail, queries included, since they read uncommitted edits:
 * RLV_ERROR_BUSY while another edit is at work. */
#ifndef RELIEVO_LAYER_H
#define RELIEVO_LAYER_H

#include "relievo/detail.h"

#define RLV_LAYER_NAME_SIZE 256

typedef enum RlvLayerKind {
    RLV_LAYER_DISPLACEMENT = 0, /* scalar, object units */
    RLV_LAYER_COLOR = 1         /* eight bits a number */
} RlvLayerKind;

/* How a layer is put on what is below it. Colours are blended in linear light and by their alpha. */
typedef enum RlvBlend {
    RLV_BLEND_NORMAL = 0,   /* covers what is below; of colours */
    RLV_BLEND_ADD = 1,      /* added to it */
    RLV_BLEND_SUBTRACT = 2, /* taken away from it */
    RLV_BLEND_MULTIPLY = 3, /* of colours, as the next two */
    RLV_BLEND_SCREEN = 4,
    RLV_BLEND_OVERLAY = 5,
    RLV_BLEND_MAX = 6, /* the larger of both: higher, or lighter */
    RLV_BLEND_MIN = 7  /* the smaller of both: lower, or darker */
} RlvBlend;

typedef struct RlvLayerOptions {
    uint32_t struct_size;
    uint32_t kind;       /* RlvLayerKind; of a new layer */
    uint32_t blend;      /* RlvBlend */
    uint32_t is_visible; /* 0 or 1 */
    float opacity;       /* 0 to 1 */
    uint32_t tile_size;  /* texels along an edge of the cage: 8 to 256, 0 for 128; of a triangle mesh segments: 8 to 64, 0
                            for 16; of a new layer */
} RlvLayerOptions;

#define RLV_LAYER_OPTIONS_INIT {sizeof(RlvLayerOptions), RLV_LAYER_DISPLACEMENT, RLV_BLEND_ADD, 1, 1.0f, 0}

typedef struct RlvLayerInfo {
    uint32_t struct_size;
    uint32_t id;         /* its number */
    uint32_t kind;       /* RlvLayerKind */
    uint32_t blend;      /* RlvBlend */
    uint32_t is_visible; /* 0 or 1 */
    uint32_t is_active;  /* 0 or 1: whether edits of its kind go to it */
    float opacity; /* 0 to 1 */
    uint32_t reserved;
    size_t tile_count; /* tiles that are allocated */
    char name[RLV_LAYER_NAME_SIZE];
} RlvLayerInfo;

#define RLV_LAYER_INFO_INIT {sizeof(RlvLayerInfo), 0, 0, 0, 0, 0, 0.0f, 0, 0, {0}}

/* How many layers there are. No failure of its own. */
RLV_API RlvResult rlv_layer_count(RlvDetail detail, size_t *count);

/* The layer at an index: those of displacement from the lowest, then those of colour. Fails if there is none. */
RLV_API RlvResult rlv_layer_info(RlvDetail detail, size_t index, RlvLayerInfo *out);

/* Adds a layer above those of its kind and makes it the active one; writes its number. The name is 1 to 255 bytes of
 * UTF-8 that no other layer has. Fails if the detail has no colours and the layer is of colour. */
RLV_API RlvResult rlv_layer_add(RlvDetail detail, const char *name, const RlvLayerOptions *options, uint32_t *out);

/* Changes how a layer is seen: blend, is_visible and opacity of the options. Outside of an edit of a document it is no step of
 * undo: it stays, and where undo takes the layer away or sets it otherwise, redo brings it back. Fails, and changes nothing, if there is no
 * such layer, its kind has no such blend mode, or the opacity is not 0 to 1. */
RLV_API RlvResult rlv_layer_set(RlvDetail detail, uint32_t id, const RlvLayerOptions *options);

/* Makes a layer the one that edits of its kind go to. Fails if there is none. */
RLV_API RlvResult rlv_layer_set_active(RlvDetail detail, uint32_t id);

/* Gives a layer another name, as for rlv_layer_add. Fails if there is no such layer or another has the name. */
RLV_API RlvResult rlv_layer_rename(RlvDetail detail, uint32_t id, const char *name);

/* Puts a layer at a place among those of its kind, 0 the lowest. Fails if there is no such layer or place. */
RLV_API RlvResult rlv_layer_place(RlvDetail detail, uint32_t id, size_t place);

/* Removes a layer with all that is on it. Fails if it is the last of its kind. */
RLV_API RlvResult rlv_layer_remove(RlvDetail detail, uint32_t id);

/* Puts a layer and the one below it into one that looks as both did, but for rounding. Fails, and changes nothing,
 * where no one layer would look so, or one of them is hidden. */
RLV_API RlvResult rlv_layer_merge(RlvDetail detail, uint32_t id);

/* Makes one layer of displacement and one of colour of all: what is seen, to the bit. What the budget refuses stays as
 * it was and goes to the log. No failure of its own. */
RLV_API RlvResult rlv_layer_flatten(RlvDetail detail);

#endif
