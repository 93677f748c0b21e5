/* Relievo: sparse grids of OpenVDB.
 *
 * A grid has values at voxels of a lattice of any extent (Museth 2013): distances of a level set, densities of fog, labels,
 * masks, vectors. OpenVDB is reached through a module, librelievo_openvdb.so, of the package relievo-openvdb. It is opened by
 * the first call that needs it, with its names hidden from the host, and stays open. Without it calls fail with
 * RLV_ERROR_NOT_FOUND, and the message names the package; rlv_grid_file_count and rlv_grid_file_info need no module. The
 * module is looked for at the path in the environment variable RELIEVO_OPENVDB, beside this library and the program, and in
 * the system's folders.
 *
 * Calls that only read a grid may run at the same time. Lengths are in world units of the grid. */
#ifndef RELIEVO_GRID_H
#define RELIEVO_GRID_H

#include "relievo/particles.h"
#include "relievo/parameter.h"

typedef struct RlvGrid {
    uint64_t id;
} RlvGrid;

/* Kinds of values, and what an element of a block of them is. */
typedef enum RlvGridKind {
    RLV_GRID_FLOAT = 0,  /* float */
    RLV_GRID_DOUBLE = 1, /* double */
    RLV_GRID_BOOL = 2,   /* uint8_t, 0 or 1 */
    RLV_GRID_MASK = 3,   /* uint8_t, 0 or 1: active or not */
    RLV_GRID_INT32 = 4,  /* int32_t, also labels */
    RLV_GRID_INT64 = 5,  /* int64_t */
    RLV_GRID_VEC3S = 6,  /* three float */
    RLV_GRID_VEC3D = 7,  /* three double */
    RLV_GRID_VEC3I = 8,  /* three int32_t */
    RLV_GRID_POINTS = 9, /* in files: read it with rlv_particles_read */
    RLV_GRID_OTHER = 10  /* in files: a type that is not read */
} RlvGridKind;

/* What values mean. */
typedef enum RlvGridClass {
    RLV_GRID_UNKNOWN = 0,
    RLV_GRID_LEVEL_SET = 1, /* signed distances within a band, negative inside */
    RLV_GRID_FOG = 2,       /* densities, 0 outside */
    RLV_GRID_STAGGERED = 3  /* vectors on the faces of voxels */
} RlvGridClass;

/* How files are written; bits. */
typedef enum RlvGridWriting {
    RLV_GRID_PACK_BLOSC = 0,  /* packed by Blosc, quick to read */
    RLV_GRID_PACK_ZIP = 1,    /* packed by zlib, smaller */
    RLV_GRID_PACK_NONE = 2,   /* not packed */
    RLV_GRID_HALF = 4,        /* numbers with 16 bits */
    RLV_GRID_STREAM = 8       /* without places of grids */
} RlvGridWriting;

typedef enum RlvGridOperation {
    RLV_GRID_UNION = 0,
    RLV_GRID_INTERSECTION = 1,
    RLV_GRID_DIFFERENCE = 2
} RlvGridOperation;

/* Ways in which a grid is made of another, and the settings that they take. */
typedef enum RlvGridChange {
    RLV_GRID_OFFSET = 0,         /* moves the surface of a level set: distance */
    RLV_GRID_MEAN = 1,           /* smooths a level set or fog: width, iterations */
    RLV_GRID_GAUSSIAN = 2,       /* the same */
    RLV_GRID_MEDIAN = 3,         /* the same */
    RLV_GRID_LAPLACIAN = 4,      /* smooths a level set: iterations */
    RLV_GRID_MEAN_CURVATURE = 5, /* the same */
    RLV_GRID_RESAMPLE = 6,       /* cubic voxels with their edges along the axes: voxel */
    RLV_GRID_TO_FOG = 7,         /* a level set becomes fog */
    RLV_GRID_TO_LEVEL_SET = 8    /* fog at the value, or a mask, becomes a level set: value, band */
} RlvGridChange;

/* The numbers that conversions and changes take. rlv_grid_params has ranges, units and defaults of every field. */
typedef struct RlvGridSettings {
    uint32_t struct_size;
    float voxel;         /* edge of voxels that are made or resampled to, world units, above 0 */
    float band;          /* half the width of a level set's band, voxels, 1 to 100 */
    float radius;        /* of particles, world units; 0 for their spacing */
    float value;         /* at the surface, in the unit of the grid's values: 0 of level sets, a density of fog */
    float adaptivity;    /* how much polygons grow where the surface is flat, 0 to 1 */
    float distance;      /* that a surface is moved outwards, world units; inwards below 0 */
    uint32_t width;      /* half the width of a filter, voxels, 1 to 100 */
    uint32_t iterations; /* of a filter, 1 to 1000 */
} RlvGridSettings;

#define RLV_GRID_SETTINGS_INIT {sizeof(RlvGridSettings), 0.1f, 3.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1, 1}

typedef struct RlvGridInfo {
    uint32_t struct_size;
    uint32_t kind;       /* RlvGridKind */
    uint32_t grid_class; /* RlvGridClass */
    uint32_t is_half;    /* 1: numbers have 16 bits in files */
    uint32_t is_linear;  /* 0: the transform is a camera's frustum, and matrix is the map that follows it */
    uint32_t is_empty;   /* 1: no voxel is active, and low and high are 0 */
    double matrix[12];   /* what the axes of voxels go to and the origin, three numbers each, in world units */
    double voxel_size[3]; /* edges of a voxel, world units; of a frustum those in its middle */
    int32_t low[3];      /* the lowest and the highest active voxel */
    int32_t high[3];
    uint64_t active_voxels;
    uint64_t leaf_count;
    uint64_t memory_bytes; /* of a grid in a file at most, when it is read */
    char name[RLV_TEXT_SIZE];
} RlvGridInfo;

#define RLV_GRID_INFO_INIT {sizeof(RlvGridInfo), 0, 0, 0, 0, 0, {0}, {0}, {0}, {0}, 0, 0, 0, {0}}

/* The fields of RlvGridSettings in order: a table that lives as long as the process, and its length. No failure of its
 * own. */
RLV_API RlvResult rlv_grid_params(const RlvParameter **params, size_t *count);

/* Opens the module if it is not open yet. Fails with RLV_ERROR_NOT_FOUND if there is none, and with RLV_ERROR_UNSUPPORTED
 * if it belongs to another version. */
RLV_API RlvResult rlv_grid_available(void);

/* Counts the grids of a file. path is UTF-8. The file may be hostile: its sizes are checked, and the context's memory limit
 * bounds what the list takes. Fails if it cannot be read or is damaged. */
RLV_API RlvResult rlv_grid_file_count(RlvContext context, const char *path, size_t *out);

/* Describes grid index, counted from 0, of a file without the values of its leaves. Fails if there is none, and as
 * rlv_grid_file_count does. */
RLV_API RlvResult rlv_grid_file_info(RlvContext context, const char *path, size_t index, RlvGridInfo *out);

/* Writes an entry of the metadata of a file as text to value, of size bytes with the final zero; longer ones are cut. Fails with
 * RLV_ERROR_NOT_FOUND if there is none of the name, and as rlv_grid_file_count does. */
RLV_API RlvResult rlv_grid_file_metadata(RlvContext context, const char *path, const char *name, char *value, size_t size);

/* Makes an empty grid with cubic voxels. background is the value outside of what is set, three numbers, the first of which
 * counts for scalars. Fails if the kind cannot be made, or voxel is not positive and finite. */
RLV_API RlvResult rlv_grid_create(RlvContext context, uint32_t kind, const double *background, double voxel, RlvGrid *out);

/* Reads a grid of a file: the one called name, or the first that can be read if name is NULL. bounds is NULL for all of it,
 * or the lowest and the highest corner of a box, six numbers in world units: other leaves are not read. The file may be
 * hostile: it is checked before OpenVDB reads it. Fails if it is damaged, with RLV_ERROR_NOT_FOUND if it has no such grid,
 * with RLV_ERROR_UNSUPPORTED if it is one of points or of another type, with RLV_ERROR_MEMORY if it would take more than the
 * context's memory limit, and with RLV_ERROR_CANCELLED. */
RLV_API RlvResult rlv_grid_read(RlvContext context, const char *path, const char *name, const double *bounds,
                                RlvProgress progress, void *user, RlvGrid *out);

/* Writes count grids to a file. path is UTF-8, writing is bits of RlvGridWriting. The file appears whole or not at all. Fails
 * if there is no grid, they belong to different contexts, or the file cannot be written. */
RLV_API RlvResult rlv_grid_write(const RlvGrid *grids, size_t count, const char *path, uint32_t writing);

RLV_API RlvResult rlv_grid_retain(RlvGrid grid);
RLV_API RlvResult rlv_grid_release(RlvGrid grid);

/* Describes a grid. No failure of its own. */
RLV_API RlvResult rlv_grid_info(RlvGrid grid, RlvGridInfo *out);

/* Names a grid. Fails with RLV_ERROR_BUSY if another call uses it. */
RLV_API RlvResult rlv_grid_set_name(RlvGrid grid, const char *name);

/* Says what values mean. Fails if there is no such class, and with RLV_ERROR_BUSY if another call uses it. */
RLV_API RlvResult rlv_grid_set_class(RlvGrid grid, uint32_t grid_class);

/* Sets the transform: what the three axes of voxels go to and the origin, twelve numbers. Fails if it is not finite or has no
 * inverse, and with RLV_ERROR_BUSY if another call uses the grid. */
RLV_API RlvResult rlv_grid_set_matrix(RlvGrid grid, const double *matrix);

/* Makes the transform a camera's frustum: a box in voxels, its lowest and its highest corner in six numbers, becomes a pyramid
 * whose near plane is taper times as wide as its far plane and whose depth is depth times the width of the near plane; matrix,
 * twelve numbers as of rlv_grid_set_matrix, follows it. Fails if the box is empty, taper or depth is not positive and finite,
 * or the matrix is not finite or has no inverse, and with RLV_ERROR_BUSY if another call uses the grid. */
RLV_API RlvResult rlv_grid_set_frustum(RlvGrid grid, const double *voxels, double taper, double depth, const double *matrix);

/* Counts the entries of metadata. No failure of its own. */
RLV_API RlvResult rlv_grid_metadata_count(RlvGrid grid, size_t *out);

/* Writes the name and the type of entry index, counted from 0, with their final zeros to name and type, of so many bytes; longer
 * ones are cut. Fails if there is no such entry. */
RLV_API RlvResult rlv_grid_metadata_entry(RlvGrid grid, size_t index, char *name, size_t name_size, char *type,
                                          size_t type_size);

/* Writes an entry of metadata as text to value, of size bytes with the final zero; longer ones are cut. Fails with
 * RLV_ERROR_NOT_FOUND if there is none of the name. */
RLV_API RlvResult rlv_grid_metadata(RlvGrid grid, const char *name, char *value, size_t size);

/* Sets an entry of metadata: type is "string", "bool", "int32", "int64", "float" or "double". Fails if the value is none of
 * its type, and with RLV_ERROR_BUSY if another call uses the grid. */
RLV_API RlvResult rlv_grid_set_metadata(RlvGrid grid, const char *name, const char *type, const char *value);

/* Reads the values at count points, three doubles each in world units, stride in bytes, 0 for packed: trilinear if
 * is_linear is 1, of the nearest voxel if it is 0. values gets one double a point, three of vectors; capacity is in
 * doubles. Integers above 2^53 are rounded. Fails, and writes nothing, if a point is not finite or there is not enough
 * room. */
RLV_API RlvResult rlv_grid_sample(RlvGrid grid, const double *points, size_t count, size_t stride, uint32_t is_linear,
                                  double *values, size_t capacity);

/* Writes the values of a block of voxels: low is its lowest voxel, size the voxels along x, y and z; x varies slowest.
 * Elements are as RlvGridKind says; bytes is the room at values and must be that of the block. Fails if it is not, or if the
 * block is larger than the context's memory limit. */
RLV_API RlvResult rlv_grid_get_block(RlvGrid grid, const int32_t *low, const uint32_t *size, void *values, size_t bytes);

/* Sets a block of voxels, in the form of rlv_grid_get_block. Values within tolerance of the background become it and are not
 * active. Fails if a number is not finite or a truth value is neither 0 nor 1, with RLV_ERROR_BUSY if another call uses the
 * grid, and as rlv_grid_get_block does. */
RLV_API RlvResult rlv_grid_set_block(RlvGrid grid, const int32_t *low, const uint32_t *size, const void *values,
                                     size_t bytes, double tolerance);

/* Makes a level set of a closed mesh: settings voxel and band. settings may be NULL for the defaults, progress too. Fails if a
 * setting is out of range, with RLV_ERROR_MEMORY if its estimate exceeds the context's memory limit, and with
 * RLV_ERROR_CANCELLED. */
RLV_API RlvResult rlv_grid_from_mesh(RlvMesh mesh, const RlvGridSettings *settings, RlvProgress progress, void *user,
                                     RlvGrid *out);

/* Makes a level set of the union of balls at particles: settings voxel, band and radius. Fails if the radius is 0 and the
 * particles have no spacing, and as rlv_grid_from_mesh does. */
RLV_API RlvResult rlv_grid_from_particles(RlvParticles particles, const RlvGridSettings *settings, RlvProgress progress,
                                          void *user, RlvGrid *out);

/* Meshes the surface where a grid of numbers has a value, in quads, and triangles where polygons are merged: settings value
 * and adaptivity. Fails if the grid has bools, masks or vectors, if there is no surface, and with RLV_ERROR_CANCELLED. */
RLV_API RlvResult rlv_grid_mesh(RlvGrid grid, const RlvGridSettings *settings, RlvProgress progress, void *user,
                                RlvMesh *out);

/* Makes a grid of another as change, an RlvGridChange, says. Fails if the change does not fit the kind and class, a setting is
 * out of range, with RLV_ERROR_MEMORY if an estimate exceeds the context's memory limit, and with RLV_ERROR_CANCELLED. */
RLV_API RlvResult rlv_grid_change(RlvGrid grid, uint32_t change, const RlvGridSettings *settings, RlvProgress progress,
                                  void *user, RlvGrid *out);

/* Makes a grid of another kind with the same voxels. Fails between numbers and vectors. */
RLV_API RlvResult rlv_grid_convert(RlvGrid grid, uint32_t kind, RlvGrid *out);

/* Combines two grids of one kind and class: level sets as solids; fog by its densities; masks by their active voxels. b is
 * resampled if its transform is another. Fails if they do not fit or are vectors, and with RLV_ERROR_CANCELLED. */
RLV_API RlvResult rlv_grid_combine(RlvGrid a, RlvGrid b, uint32_t operation, RlvProgress progress, void *user,
                                   RlvGrid *out);

/* Makes a grid of int32 labels of count level sets of floats with one transform: voxels inside have the label, later ones
 * win, 0 is outside. Fails if one is no such level set, or their transforms differ. */
RLV_API RlvResult rlv_grid_labels(const RlvGrid *level_sets, const int32_t *labels, size_t count, RlvGrid *out);

/* Makes a mask of the voxels of a grid of integers that have a label. Fails if it has no integers. */
RLV_API RlvResult rlv_grid_label_mask(RlvGrid grid, int64_t label, RlvGrid *out);

#endif
