/* Relievo: levels, meshes of a progressive mesh that become finer and coarser in place and are edited at any level.
 *
 * A level is as fine as was asked for last: by deviation, number of triangles, or for a view. Regions of it are moved and
 * turned by handles, and brushes sculpt it; finer levels follow as it becomes finer, coarser ones as it becomes coarser,
 * and all the same whatever way was taken. Its vertices and triangles are written to the host's own buffers, where they
 * keep their places while they exist: an update writes what has changed, and says in which ranges.
 *
 * A level may write its edits down in a journal, from which they are made again after its host was killed.
 *
 * Several levels of one progressive mesh do not know of each other. Lengths are in object units, angles in radians. */
#ifndef RELIEVO_LEVEL_H
#define RELIEVO_LEVEL_H

#include "relievo/progressive.h"
#include "relievo/stroke.h"

typedef struct RlvLevel {
    uint64_t id;
} RlvLevel;

typedef struct RlvLevelInfo {
    uint32_t struct_size;
    uint32_t undo_count; /* edits that can be taken back */
    uint32_t redo_count; /* edits that were taken back and can be made again */
    uint32_t reserved;
    size_t vertex_count; /* of the present mesh */
    size_t triangle_count;
} RlvLevelInfo;

#define RLV_LEVEL_INFO_INIT {sizeof(RlvLevelInfo), 0, 0, 0, 0, 0}

/* From where it is seen, and how fine it has to be there. */
typedef struct RlvLevelView {
    uint32_t struct_size;
    uint32_t reserved;   /* 0 */
    double eye[3];       /* where it is seen from, object units */
    double pixels;       /* pixels that a unit across the view covers at distance 1: height / (2 tan(angle / 2)) */
    double tolerance;    /* pixels that the mesh may deviate by, above 0 */
    double outline;      /* the same divided by this, at least 1, where there may be an outline */
    const float *planes; /* of what is seen, 4 floats n, d each: n · p + d >= 0, n of length 1; NULL for everything */
    size_t plane_count;
    size_t plane_stride; /* bytes, 0 for packed */
} RlvLevelView;

#define RLV_LEVEL_VIEW_INIT {sizeof(RlvLevelView), 0, {0.0}, 1000.0, 1.0, 1.0, NULL, 0, 0}

/* A ball in which something has an influence, that falls from its middle to its border. */
typedef struct RlvLevelRegion {
    double center[3]; /* object units */
    float radius;     /* object units, above 0 */
    uint32_t falloff; /* RlvFalloff */
} RlvLevelRegion;

/* What grabs a region, turns it about its middle and moves it. */
typedef struct RlvLevelHandle {
    RlvLevelRegion region;
    float translation[3]; /* object units */
    float axis[3];        /* it turns about, of length 1; of any if the angle is 0 */
    float angle;          /* how far it turns, radians, counter-clockwise seen against the axis */
    uint32_t reserved;
} RlvLevelHandle;

/* Handles that act together, and regions that are held. Where the influences of handles sum to more than 1, each has its
 * share; an anchor takes its influence from all of them. Strides are in bytes, 0 for packed. */
typedef struct RlvLevelEdit {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    const RlvLevelHandle *handles;
    size_t handle_count; /* 1 or more */
    size_t handle_stride;
    const RlvLevelRegion *anchors;
    size_t anchor_count; /* 0 or more */
    size_t anchor_stride;
} RlvLevelEdit;

#define RLV_LEVEL_EDIT_INIT {sizeof(RlvLevelEdit), 0, NULL, 0, 0, NULL, 0, 0}

/* What a handle does at a time. */
typedef struct RlvLevelKey {
    double time;          /* seconds */
    float translation[3]; /* object units */
    float axis[3];        /* it turns about, of length 1; of any if the angle is 0 */
    float angle;          /* how far it turns, radians; less than a whole turn beside a key with another axis */
    uint32_t reserved;
} RlvLevelKey;

/* A handle over time: between keys it moves along a line and turns about its middle, evenly about an axis that stays.
 * Before the first key it is as there, after the last one as there. */
typedef struct RlvLevelTrack {
    RlvLevelRegion region;
    const RlvLevelKey *keys; /* later and later */
    size_t key_count;        /* 1 or more */
    size_t key_stride;       /* bytes, 0 for packed */
} RlvLevelTrack;

/* An edit over time, as RlvLevelEdit is one. Strides are in bytes, 0 for packed. */
typedef struct RlvLevelMotion {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    const RlvLevelTrack *tracks;
    size_t track_count; /* 1 or more */
    size_t track_stride;
    const RlvLevelRegion *anchors;
    size_t anchor_count; /* 0 or more */
    size_t anchor_stride;
} RlvLevelMotion;

#define RLV_LEVEL_MOTION_INIT {sizeof(RlvLevelMotion), 0, NULL, 0, 0, NULL, 0, 0}

/* What a stroke on a level did. */
typedef struct RlvLevelSculpted {
    uint32_t struct_size;
    uint32_t reserved;
    uint64_t dabs;        /* that were made, with mirror images */
    uint64_t missed_dabs; /* that were left out because the surface is too far away */
    uint64_t vertices;    /* that moved, of the mesh that was sculpted */
} RlvLevelSculpted;

#define RLV_LEVEL_SCULPTED_INIT {sizeof(RlvLevelSculpted), 0, 0, 0, 0}

/* The host's buffers: the same ones, with what the last update left in them, until one of them is another and is_whole
 * says so. Strides are in bytes, 0 for packed. */
typedef struct RlvLevelBuffers {
    uint32_t struct_size;
    uint32_t is_whole; /* 1: write everything; the first update does so anyway */
    float *points;     /* 3 floats each */
    size_t point_stride;
    float *normals; /* of length 1, 0 at vertices without triangles; 3 floats each; NULL if not wanted */
    size_t normal_stride;
    size_t vertex_capacity; /* vertices that there is room for */
    uint32_t *triangles;    /* 3 vertices each, counter-clockwise from the front */
    size_t triangle_stride;
    size_t triangle_capacity; /* triangles that there is room for */
    uint32_t *wedges;         /* of every triangle, 3 each; NULL if not wanted, as what follows */
    size_t wedge_stride;
    float *wedge_values; /* of every wedge, as many as rlv_progressive_info tells; "normal" and "tangent" turn with edits */
    size_t wedge_value_stride;
    size_t wedge_capacity; /* wedges that there is room for: all of the finest mesh */
    uint32_t *face_values; /* of every triangle, as many as rlv_progressive_info tells; of floats their bits */
    size_t face_value_stride;
} RlvLevelBuffers;

#define RLV_LEVEL_BUFFERS_INIT \
    {sizeof(RlvLevelBuffers), 0, NULL, 0, NULL, 0, 0, NULL, 0, 0, NULL, 0, NULL, 0, 0, NULL, 0}

/* What is in the host's buffers. */
typedef struct RlvLevelUpdate {
    uint32_t struct_size;
    uint32_t reserved;
    size_t vertex_count;         /* vertices, from the first place on */
    size_t triangle_count;       /* triangles, from the first place on */
    size_t first_vertex;         /* all vertices that were written are among changed_vertex_count from this one on;
                                    rlv_level_changed_ranges has them more finely */
    size_t changed_vertex_count; /* 0 if none was */
    size_t first_triangle;       /* the same of triangles */
    size_t changed_triangle_count;
    size_t wedge_count; /* places of wedges, of which some may be free; wedges and face values go with triangles */
    size_t first_wedge; /* the same of wedges' values */
    size_t changed_wedge_count;
} RlvLevelUpdate;

#define RLV_LEVEL_UPDATE_INIT {sizeof(RlvLevelUpdate), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}

/* A split of a level that is out of order: it deviates more than twice as much as it tells, so that meshes that are as
 * coarse as it deviate more than was asked for, and keep triangles elsewhere that are needed here. */
typedef struct RlvLevelMisplaced {
    float point[3]; /* where the vertex is that it splits */
    float told;     /* object units: what it deviates by as levels go by it */
    float now;      /* object units: what it deviates by */
} RlvLevelMisplaced;

/* Makes a level of a progressive mesh, which is its base mesh. Fails with RLV_ERROR_MEMORY if it would take more than the
 * context's memory limit. */
RLV_API RlvResult rlv_level_create(RlvProgressive progressive, RlvLevel *out);

/* Mutating. Goes on with more of the same progressive mesh, which has arrived since (arrival.h). The level has the splits that
 * it had, and its edits; what is finer can be made from now on. Fails, and changes nothing, if progressive is another one,
 * or less of it. */
RLV_API RlvResult rlv_level_take_up(RlvLevel level, RlvProgressive progressive);

RLV_API RlvResult rlv_level_retain(RlvLevel level);
RLV_API RlvResult rlv_level_release(RlvLevel level);

/* How large the mesh is now, and how many edits there are to take back. No failure of its own. */
RLV_API RlvResult rlv_level_info(RlvLevel level, RlvLevelInfo *out);

/* Mutating. Becomes the coarsest mesh whose estimated deviation from the finest is at most error, 0 or more. The distance
 * between the surfaces may be several times as much. Fails if error is negative or no number. */
RLV_API RlvResult rlv_level_set_error(RlvLevel level, float error);

/* Mutating. Becomes a coarse mesh whose surface is nowhere farther than bound, 0 or more, from that of the finest mesh with
 * its edits, nor that from it. Distances of up to 12 meshes are measured. distance, which may be NULL, gets that of the
 * mesh, never less than the true one; less than 1e-7 of the largest coordinate, its rounding, counts as that. progress may
 * be NULL. Fails if bound is negative or no number, and with RLV_ERROR_MEMORY or RLV_ERROR_CANCELLED, when the level may
 * have become another. */
RLV_API RlvResult rlv_level_set_bound(RlvLevel level, float bound, RlvProgress progress, void *user, float *distance);

/* Mutating. Becomes the finest mesh of at most so many triangles, or the base mesh if that has more; SIZE_MAX for the
 * finest of all. No failure of its own. */
RLV_API RlvResult rlv_level_set_triangles(RlvLevel level, size_t triangles);

/* Mutating. Becomes as fine as a view needs it, from what it is: of two views that are near each other little changes.
 * Fails, and changes nothing, if a number of the view is not finite or out of its range. */
RLV_API RlvResult rlv_level_set_view(RlvLevel level, const RlvLevelView *view);

/* Mutating. Moves and turns regions of the present mesh, also where that is made for a view: the vertices that are
 * there are moved. reached, which may be NULL, is how many. Fails, and changes nothing, if no vertex is in a region or a
 * number is out of its range. */
RLV_API RlvResult rlv_level_edit(RlvLevel level, const RlvLevelEdit *edit, size_t *reached);

/* Mutating. Sculpts the present mesh by a whole stroke, which is one edit. The brush's modes move vertices along
 * their normals as they were when the stroke began, erasing back to where they were built, and mirror the stroke as its
 * settings say; the world of the brush and of the points is the space of the mesh. stride is in bytes from point to
 * point, 0 for packed; out may be NULL. Fails, and changes nothing, if there are no points, a number is out of its range,
 * the brush paints, has an image in mode RLV_SCULPT_VECTOR, a level or jitter_position, or no vertex is in it. */
RLV_API RlvResult rlv_level_sculpt(RlvLevel level, RlvBrush brush, const RlvStrokePoint *points, size_t count,
                                   size_t stride, RlvLevelSculpted *out);

/* Mutating. Takes the last edit back, at whatever level, and keeps the level's fineness. Fails with RLV_ERROR_NOT_FOUND
 * if there is none. */
RLV_API RlvResult rlv_level_undo(RlvLevel level);

/* Mutating. Makes the edit again that was taken back last. Fails with RLV_ERROR_NOT_FOUND if there is none. */
RLV_API RlvResult rlv_level_redo(RlvLevel level);

/* Mutating. Adds an edit over time, of the mesh at its present fineness; rlv_level_set_time shows it. Fails, and
 * changes nothing, if a number is out of its range or keys do not come one after another. */
RLV_API RlvResult rlv_level_add_motion(RlvLevel level, const RlvLevelMotion *motion);

/* Mutating. Applies the edits over time for a time in seconds, in the order they were added, in place
 * of what was made for another time; the level is as fine as before. reached, which may be NULL, is how many vertices
 * moved. What is settled, rebuilt or taken as a mesh has them; they are no edits to be taken back, and no journal has
 * them. To edit, sculpt, undo or redo puts the mesh at rest first. Fails, and puts the mesh at rest, if the time is not
 * finite or an edit that moves has no vertex in its regions. */
RLV_API RlvResult rlv_level_set_time(RlvLevel level, double time, size_t *reached);

/* Mutating. Forgets the edits over time, and puts the mesh at rest. No failure of its own. */
RLV_API RlvResult rlv_level_clear_motions(RlvLevel level);

/* Mutating. Writes the edits that follow down in a journal, the file at path (UTF-8): each is handed to the operating
 * system before it is made, and what is taken back too, so that a host that is killed loses none that was made. Where
 * there is a journal already, which a killed host left, its edits are made again, which takes as long as it did at first;
 * the level is as fine as before, and rlv_level_info tells the edits. Notes, such as of an edit that was under way, which
 * is not made, go to the context's log. The file is this level's alone until the journal is closed or the level released,
 * and the host's to delete once the edits are elsewhere. Fails, and changes nothing, if the level has edits or a journal,
 * or the file cannot be written, is of another progressive mesh, damaged, or in use. */
RLV_API RlvResult rlv_level_open_journal(RlvLevel level, const char *path);

/* Waits until all edits are on the disk, where a failure of power does not reach them. Fails if the file cannot be
 * written, and with RLV_ERROR_NOT_FOUND if there is no journal. */
RLV_API RlvResult rlv_level_sync_journal(RlvLevel level);

/* Mutating. Closes the journal: the edits stay, and later edits are not written down. The file stays too. Fails
 * with RLV_ERROR_NOT_FOUND if there is none. */
RLV_API RlvResult rlv_level_close_journal(RlvLevel level);

/* Mutating. Writes to the host's buffers what has changed of the mesh since the last update; out may be NULL. Fails, and
 * writes nothing, if there is not enough room; there is for any level with rlv_progressive_info's counts. */
RLV_API RlvResult rlv_level_update(RlvLevel level, const RlvLevelBuffers *buffers, RlvLevelUpdate *out);

/* The ranges that the last update wrote, as pairs of the first and the number of elements, ascending, those of the domain:
 * RLV_DOMAIN_POINT for vertices, RLV_DOMAIN_FACE for triangles, with their wedges and face values, RLV_DOMAIN_CORNER for
 * values of wedges. Each range begins and ends with an element that was written; it may have gaps of at most 8 elements
 * that were not. Before the first update there is no range. Writes up to capacity pairs to ranges, and the number of
 * ranges to count. ranges may be NULL to ask for the number. Fails if there is no such domain, or capacity is too small. */
RLV_API RlvResult rlv_level_changed_ranges(RlvLevel level, uint32_t domain, uint32_t *ranges, size_t capacity,
                                           size_t *count);

/* Makes a mesh of the level in its present state, with the attributes that the progressive mesh has, and "normal" at
 * its points if that is none of them; it takes less memory than the level. Where attributes of points differ about a
 * vertex it has several points. Fails if no triangle is left. */
RLV_API RlvResult rlv_level_mesh(RlvLevel level, RlvMesh *out);

/* Mutating, though the mesh does not change. Makes a progressive mesh of its own that has the edits at all levels, to
 * be written or handed on. Deviations of its levels are those it was built with. No failure of its own. */
RLV_API RlvResult rlv_level_settle(RlvLevel level, RlvProgressive *out);

/* Mutating, though the mesh does not change. Counts the splits that are out of order, as large edits leave them, and
 * writes the splits that deviate most, up to capacity, to out, the worst one first; out may be NULL if capacity is 0.
 * All splits of the mesh are looked at. No failure of its own. */
RLV_API RlvResult rlv_level_misplaced(RlvLevel level, RlvLevelMisplaced *out, size_t capacity, size_t *count);

/* Mutating, though the mesh does not change. Builds a progressive mesh anew of the finest level with its edits, which
 * takes as long as rlv_progressive_create: its splits are in order, and its levels deviate by what they tell. Locked
 * points are its vertices at the finest level. Attributes are those it has, whatever options say of them. options may be
 * NULL for the defaults, progress too. Fails as
 * rlv_progressive_create. */
RLV_API RlvResult rlv_level_rebuild(RlvLevel level, const RlvProgressiveOptions *options, RlvProgress progress, void *user,
                                    RlvProgressive *out);

#endif
