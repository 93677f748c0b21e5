/* Relievo: arrivals, progressive meshes whose files arrive piece by piece, as over a network.
 *
 * A host pushes bytes as they come. As soon as the base has arrived there is a progressive mesh of what is there; levels of
 * it (level.h) go on with more of it (rlv_level_take_up). The beginning of a file is a coarser mesh: chunks of 16,384
 * splits make it finer, each with its sum. */
#ifndef RELIEVO_ARRIVAL_H
#define RELIEVO_ARRIVAL_H

#include "relievo/progressive.h"

typedef struct RlvArrival {
    uint64_t id;
} RlvArrival;

typedef struct RlvArrivalInfo {
    uint32_t struct_size;
    uint32_t is_complete;  /* 1 when all has arrived */
    size_t triangle_count; /* of the finest mesh that is there; 0 before the base is */
} RlvArrivalInfo;

#define RLV_ARRIVAL_INFO_INIT {sizeof(RlvArrivalInfo), 0, 0}

/* Makes an arrival of which nothing is there yet. No failure of its own. */
RLV_API RlvResult rlv_arrival_create(RlvContext context, RlvArrival *out);

RLV_API RlvResult rlv_arrival_retain(RlvArrival arrival);
RLV_API RlvResult rlv_arrival_release(RlvArrival arrival);

/* Mutating. Takes the next bytes of the file (.rlvpm), however many; out tells what is there then and may be NULL. Bytes
 * after its end are not looked at. The file may be hostile: it is checked, and the context's memory limit bounds what it
 * takes. Fails if it is damaged or of a newer version; nothing of it is there then or taken any more, but meshes that
 * were asked for before stay. */
RLV_API RlvResult rlv_arrival_push(RlvArrival arrival, const void *bytes, size_t byte_count, RlvArrivalInfo *out);

/* Gives the progressive mesh of what has arrived so far. It does not change when more arrives: then another one is given,
 * and what is pushed next copies it once, so ask when levels are to become finer, not after every piece. It cannot be
 * written until all has arrived. Fails with RLV_ERROR_NOT_FOUND before the base has arrived. */
RLV_API RlvResult rlv_arrival_progressive(RlvArrival arrival, RlvProgressive *out);

#endif
