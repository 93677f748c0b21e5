/* Relievo: crowd streams, crowds whose clusters are read from files while they are drawn, within a budget of memory.
 *
 * A stream is a crowd (crowd.h) whose models are files (.rcrowd). Vertices, poses and hierarchies are in memory, and of the
 * triangles those of the coarsest clusters. Each rlv_crowd_cut reads clusters that it draws from the files, as far as the budget
 * and the number of reads go, before it returns. An agent whose clusters are not all in memory is drawn by the finest ones that are
 * coarser by one error everywhere, so that there are no cracks. They stay in memory while finer ones are read: a budget of twice
 * the clusters of a view and the coarsest ones is always enough. There are no impostors.
 *
 * Triangles are in slots of equal size. A host mirrors the slots in an index buffer of slot_count * slot_triangles triangles:
 * after the stream was opened and after each cut, also one that failed, it copies the clusters that were read, and first_index of RlvCrowdDraw counts
 * in the indices of this buffer. Vertices are those of the models, one model after the other, as for other crowds.
 *
 * All functions of crowd.h work on streams. Cuts of agents with weights of their own are finer than those of whole models, because
 * the vertices of clusters are not known. Device crowds do not work on streams, and the models of a stream have no triangles: what
 * needs them fails with RLV_ERROR_UNSUPPORTED. */
#ifndef RELIEVO_CROWD_STREAM_H
#define RELIEVO_CROWD_STREAM_H

#include "relievo/crowd.h"

/* The path of a crowd model. */
typedef struct RlvCrowdStreamFile {
    const char *path;
} RlvCrowdStreamFile;

/* What a stream may keep and read. */
typedef struct RlvCrowdStreamSettings {
    uint32_t struct_size;
    uint32_t most_read; /* clusters that a cut reads at most, 1 or more */
    uint64_t budget;    /* bytes of all slots at most: 16 for each triangle */
} RlvCrowdStreamSettings;

#define RLV_CROWD_STREAM_SETTINGS_INIT {sizeof(RlvCrowdStreamSettings), 1024, 67108864}

/* Slots, and what the last cut read. */
typedef struct RlvCrowdStreamInfo {
    uint32_t struct_size;
    uint32_t slot_triangles; /* that a slot has room for; slot n begins at triangle n * slot_triangles */
    uint32_t slot_count;
    uint32_t resident; /* clusters in memory */
    uint32_t read;     /* clusters that the last cut has read; before the first, that were read when the stream was opened */
    uint32_t dropped;  /* clusters that left memory for them */
    uint32_t missing;  /* clusters of the last cut that are not in memory: of every agent, of those of one step once */
    uint32_t reserved;
    uint64_t wanted_triangles; /* of the last cut, as if all its clusters were in memory */
} RlvCrowdStreamInfo;

#define RLV_CROWD_STREAM_INFO_INIT {sizeof(RlvCrowdStreamInfo), 0, 0, 0, 0, 0, 0, 0, 0}

/* A cluster that was read. */
typedef struct RlvCrowdStreamCluster {
    uint32_t model;
    uint32_t cluster;
    uint32_t slot;
    uint32_t triangle_count;
} RlvCrowdStreamCluster;

/* Opens crowd models and makes a crowd of them without agents, which is released by rlv_crowd_release. settings may be NULL for
 * the defaults. Fails with RLV_ERROR_NOT_FOUND if a file does not exist, with RLV_ERROR_INVALID if one is no crowd model or is
 * damaged, and with RLV_ERROR_MEMORY if the budget has no room for the coarsest clusters or exceeds the memory limit. Later,
 * rlv_crowd_cut fails with RLV_ERROR_INVALID where a cluster that it reads is damaged. */
RLV_API RlvResult rlv_crowd_stream_open(RlvContext context, const RlvCrowdStreamFile *files, size_t count,
                                        const RlvCrowdStreamSettings *settings, RlvCrowd *out);

/* A model of a stream, for its vertices, clips, materials and clusters. Fails if there is none of this number. */
RLV_API RlvResult rlv_crowd_stream_model(RlvCrowd crowd, uint32_t model, RlvCrowdModel *out);

/* Slots, and what the last cut read. This and the following functions fail with RLV_ERROR_INVALID if the crowd is no stream. */
RLV_API RlvResult rlv_crowd_stream_info(RlvCrowd crowd, RlvCrowdStreamInfo *out);

/* Writes the clusters that the last cut has read, or opening has. A stride is in bytes, 0 for packed. Fails, and writes nothing,
 * if the capacity is too small. */
RLV_API RlvResult rlv_crowd_stream_get_read(RlvCrowd crowd, RlvCrowdStreamCluster *clusters, size_t capacity, size_t stride);

/* Writes the triangles of a slot, three vertices of the model each, and their materials, packed; NULL leaves an array out. Fails
 * if the slot does not exist or is empty, or, and writes nothing, if the capacity is too small. */
RLV_API RlvResult rlv_crowd_stream_get_triangles(RlvCrowd crowd, uint32_t slot, uint32_t *triangles, uint32_t *materials,
                                                 size_t capacity);

#endif
