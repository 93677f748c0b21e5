/* Relievo: Ptex files (Burley and Lacewell 2008), textures for every face, to and from a detail.
 *
 * Faces of a file are the tiles of the surface, number by number: files of quads. Displacement in a file is the value
 * at the centre of a texel, in object units; vectors are along the tangent by u of each face, across it, and along its
 * normal. What the numbers are stands in the meta data, as does the cage. */
#ifndef RELIEVO_PTEX_H
#define RELIEVO_PTEX_H

#include "relievo/detail.h"

/* What the texels of a file are. */
typedef enum RlvPtexKind {
    RLV_PTEX_STATED = 0, /* as its meta data says, or else displacement for one float and colours for all else */
    RLV_PTEX_DISPLACEMENT = 1,
    RLV_PTEX_COLOR = 2, /* grey, grey and alpha, RGB, or RGB and alpha */
    RLV_PTEX_VECTORS = 3
} RlvPtexKind;

typedef struct RlvPtexOptions {
    uint32_t struct_size;
    uint32_t kind;   /* RlvPtexKind */
    uint64_t budget; /* bytes that the tiles may occupy; 0 for 1 GiB */
} RlvPtexOptions;

#define RLV_PTEX_OPTIONS_INIT {sizeof(RlvPtexOptions), RLV_PTEX_STATED, 0}

/* What became of the faces of a file. */
typedef struct RlvPtexReport {
    uint32_t struct_size;
    uint32_t channel; /* RlvChannel that the texels went to */
    size_t face_count;
    size_t constant_count;  /* faces of one value */
    size_t squared_count;   /* that were not square and are now as wide as they were long */
    size_t reduced_count;   /* that have fewer texels now */
    size_t enlarged_count;  /* that have more texels now */
    size_t ignored_numbers; /* numbers of a texel that were not taken */
    float deviation;        /* the farthest that a displacement is from that of the file, relative to the largest */
    uint32_t reserved;
} RlvPtexReport;

#define RLV_PTEX_REPORT_INIT {sizeof(RlvPtexReport), 0, 0, 0, 0, 0, 0, 0, 0.0f, 0}

/* Writes a channel of a detail as it was committed last, an RlvChannel other than traces. progress may be NULL. The
 * file appears whole or not at all. Fails if the detail does not have the channel. */
RLV_API RlvResult rlv_ptex_write(RlvDetail detail, uint32_t channel, const char *path, RlvProgress progress, void *user);

/* Edits. Gives the detail what a file has, in place of all layers of that kind; faces have the sizes of the file from
 * then on. Edits that are recorded in the file (Ptex has its own) are applied. A detail needs no colours or vectors
 * before; it keeps colours as bytes. options, progress and report may be NULL. Fails, and changes nothing, if the file
 * is damaged or for other faces, or does not fit the budget; the message says what differs. */
RLV_API RlvResult rlv_ptex_read(RlvDetail detail, const char *path, const RlvPtexOptions *options, RlvProgress progress,
                                void *user, RlvPtexReport *report);

#endif
