/* The interface of librelievo_openvdb.so, a module over OpenVDB that the crate relievo-openvdb opens at run time.
 *
 * The module and its only caller come from the same source tree: rlvdb_version() of the module must equal
 * RLVDB_VERSION, and nothing else may be called before that was checked. Functions that can fail return 0, or an
 * RLVDB_ code after they wrote *error; no exception leaves the module. Outputs are written on success alone. Handles are
 * freed once with the function named beside their type. Functions that only read a grid may run at the same time on it.
 * Matrices are row-major for row vectors, as OpenVDB stores them: a point is (x, y, z, 1) * M. */
#ifndef RELIEVO_OPENVDB_MODULE_H
#define RELIEVO_OPENVDB_MODULE_H

#include <stddef.h>
#include <stdint.h>

#define RLVDB_VERSION 1

/* Results. */
#define RLVDB_OK 0
#define RLVDB_FAILED 1      /* OpenVDB or the C++ library threw an exception */
#define RLVDB_CANCELLED 2   /* the progress callback asked to stop */
#define RLVDB_MEMORY 3      /* an allocation failed */
#define RLVDB_INVALID 4     /* an argument or the kind of a grid does not fit */
#define RLVDB_NOT_FOUND 5   /* the file has no such grid */

/* Kinds of values of a grid. */
#define RLVDB_FLOAT 0
#define RLVDB_DOUBLE 1
#define RLVDB_BOOL 2
#define RLVDB_MASK 3
#define RLVDB_INT32 4
#define RLVDB_INT64 5
#define RLVDB_VEC3S 6
#define RLVDB_VEC3D 7
#define RLVDB_VEC3I 8

/* Classes of grids. */
#define RLVDB_UNKNOWN 0
#define RLVDB_LEVEL_SET 1
#define RLVDB_FOG 2
#define RLVDB_STAGGERED 3

/* How values of a file are packed; bits. */
#define RLVDB_ZIP 1
#define RLVDB_ACTIVE 2
#define RLVDB_BLOSC 4
/* The file has no table of offsets, as openvdb::io::Stream writes it. */
#define RLVDB_STREAM 256

/* Operations of rlvdb_combine. */
#define RLVDB_UNION 0
#define RLVDB_INTERSECTION 1
#define RLVDB_DIFFERENCE 2

/* Filters of rlvdb_filter. */
#define RLVDB_MEAN 0
#define RLVDB_GAUSSIAN 1
#define RLVDB_MEDIAN 2
#define RLVDB_LAPLACIAN 3
#define RLVDB_MEAN_CURVATURE 4

#ifdef __cplusplus
extern "C" {
#endif

typedef struct RlvdbGrid RlvdbGrid; /* rlvdb_grid_free */
typedef struct RlvdbMesh RlvdbMesh; /* rlvdb_mesh_free */

typedef struct RlvdbError {
    char text[512];
} RlvdbError;

/* How a long call runs. progress may be NULL; it is called on the calling thread with a percentage, or -1 where that is
 * not known, and returns 0 to stop. */
typedef struct RlvdbCall {
    uint32_t threads; /* at least 1; 1 starts no thread */
    void *user;
    int32_t (*progress)(void *user, int32_t percent);
} RlvdbCall;

typedef struct RlvdbInfo {
    int32_t kind;
    int32_t grid_class;
    int32_t is_half;       /* values are written with 16 bits */
    int32_t is_linear;     /* 0 for a frustum */
    double background[3];  /* the first one of scalars */
    double matrix[16];     /* from voxels to world units; of a frustum its linear part */
    double voxel_size[3];
    int32_t low[3];        /* bounds of active voxels, both ends within; low > high where there is none */
    int32_t high[3];
    uint64_t active_voxels;
    uint64_t leaf_count;
    uint64_t memory_bytes;
} RlvdbInfo;

typedef struct RlvdbMeshView {
    const float *points; /* three a point, in world units */
    size_t point_count;
    const uint32_t *triangles; /* three a triangle, counter-clockwise seen from outside */
    size_t triangle_count;
    const uint32_t *quads; /* four a quad */
    size_t quad_count;
} RlvdbMeshView;

uint32_t rlvdb_version(void);
/* Returns the version of OpenVDB as 0xMMmmpp. */
uint32_t rlvdb_library_version(void);
/* Prepares OpenVDB. ends_logging: 1 to end the threads of log4cplus, which came with OpenVDB. */
int32_t rlvdb_initialize(int32_t ends_logging, RlvdbError *error);

/* Makes an empty grid with a uniform transform. background has three numbers. */
int32_t rlvdb_grid_new(int32_t kind, const double *background, double voxel, RlvdbGrid **out, RlvdbError *error);
int32_t rlvdb_grid_copy(const RlvdbGrid *grid, RlvdbGrid **out, RlvdbError *error);
void rlvdb_grid_free(RlvdbGrid *grid);
int32_t rlvdb_grid_info(const RlvdbGrid *grid, RlvdbInfo *out, RlvdbError *error);
int32_t rlvdb_set_class(RlvdbGrid *grid, int32_t grid_class, RlvdbError *error);
int32_t rlvdb_set_half(RlvdbGrid *grid, int32_t is_half, RlvdbError *error);
/* Sets an affine transform. */
int32_t rlvdb_set_matrix(RlvdbGrid *grid, const double *matrix, RlvdbError *error);
/* Sets the transform of a camera's frustum: box (low and high, 6 numbers) in voxels is mapped to a pyramid whose near
 * plane has width 1, with the ratio of the far to the near width and the depth; matrix follows. */
int32_t rlvdb_set_frustum(RlvdbGrid *grid, const double *box, double taper, double depth, const double *matrix,
                          RlvdbError *error);

/* Metadata are texts here; numbers and vectors are written as text by their type. */
int32_t rlvdb_metadata_count(const RlvdbGrid *grid, size_t *out, RlvdbError *error);
/* Writes entry index. Texts are cut to their capacity, which counts the final zero. */
int32_t rlvdb_metadata_get(const RlvdbGrid *grid, size_t index, char *name, size_t name_size, char *type,
                           size_t type_size, char *value, size_t value_size, RlvdbError *error);
/* Sets an entry of a type: string, float, double, int32, int64 or bool. NULL as value removes it. */
int32_t rlvdb_metadata_set(RlvdbGrid *grid, const char *name, const char *type, const char *value, RlvdbError *error);

/* Reads a grid of a file, which must be sound and small enough, by its unique name: what the list of the file says. box is NULL or the bounds (low and high, 6 numbers)
 * in world units beyond which leaves are not read. */
int32_t rlvdb_read(const char *path, const char *unique_name, const double *box, const RlvdbCall *call, RlvdbGrid **out,
                   RlvdbError *error);
int32_t rlvdb_write(const char *path, const RlvdbGrid *const *grids, size_t count, uint32_t packing,
                    const char *const *metadata, size_t metadata_count, const RlvdbCall *call, RlvdbError *error);

/* Reads values at points in world units: count * components doubles. is_linear: 1 to interpolate trilinearly, 0 for the
 * nearest voxel. */
int32_t rlvdb_sample(const RlvdbGrid *grid, const double *points, size_t count, int32_t is_linear, double *values,
                     RlvdbError *error);
/* Reads the values of voxels (x, y, z). */
int32_t rlvdb_voxels(const RlvdbGrid *grid, const int32_t *voxels, size_t count, double *values, RlvdbError *error);
/* Copies a block of size[0] * size[1] * size[2] voxels from low on; x varies slowest. Elements: float, double, uint8_t
 * (bool and mask), int32_t, int64_t, and three float, double or int32_t; byte_count must be their size. */
int32_t rlvdb_dense_get(const RlvdbGrid *grid, const int32_t *low, const uint32_t *size, void *values,
                        size_t byte_count, const RlvdbCall *call, RlvdbError *error);
/* The reverse. Values within tolerance of the background become it and are not active. */
int32_t rlvdb_dense_set(RlvdbGrid *grid, const int32_t *low, const uint32_t *size, const void *values,
                        size_t byte_count, double tolerance, const RlvdbCall *call, RlvdbError *error);

/* Makes a level set of a mesh in world units with bands in voxels. Indices must be in range. */
int32_t rlvdb_from_mesh(const float *points, size_t point_count, const uint32_t *triangles, size_t triangle_count,
                        const double *matrix, float exterior, float interior, const RlvdbCall *call, RlvdbGrid **out,
                        RlvdbError *error);
/* Makes a level set of spheres; the band is in voxels. */
int32_t rlvdb_from_spheres(const float *points, const float *radii, size_t count, double voxel, float band,
                           const RlvdbCall *call, RlvdbGrid **out, RlvdbError *error);
/* Meshes the surface where a scalar grid has a value. adaptivity: 0 for quads alone, up to 1 for the fewest polygons. */
int32_t rlvdb_to_mesh(const RlvdbGrid *grid, double value, double adaptivity, const RlvdbCall *call, RlvdbMesh **out,
                      RlvdbError *error);
void rlvdb_mesh_view(const RlvdbMesh *mesh, RlvdbMeshView *out);
void rlvdb_mesh_free(RlvdbMesh *mesh);

/* Combines two grids of one kind into a new one: level sets by constructive solid geometry, other scalars by maximum,
 * minimum and difference of values, masks by their active voxels. b is resampled to the transform of a. */
int32_t rlvdb_combine(const RlvdbGrid *a, const RlvdbGrid *b, int32_t operation, const RlvdbCall *call,
                      RlvdbGrid **out, RlvdbError *error);
/* Moves the surface of a level set outwards by a distance in world units. */
int32_t rlvdb_offset(const RlvdbGrid *grid, double distance, const RlvdbCall *call, RlvdbGrid **out,
                     RlvdbError *error);
/* Smooths a grid of floats or doubles; width is a radius in voxels. */
int32_t rlvdb_filter(const RlvdbGrid *grid, int32_t filter, uint32_t width, uint32_t iterations,
                     const RlvdbCall *call, RlvdbGrid **out, RlvdbError *error);
/* Resamples to another transform. order: 0 nearest, 1 trilinear, 2 triquadratic. */
int32_t rlvdb_resample(const RlvdbGrid *grid, const double *matrix, uint32_t order, const RlvdbCall *call,
                       RlvdbGrid **out, RlvdbError *error);
/* Makes a grid of another kind with the same values, topology and transform. */
int32_t rlvdb_convert(const RlvdbGrid *grid, int32_t kind, const RlvdbCall *call, RlvdbGrid **out, RlvdbError *error);
/* Makes a fog volume of a level set: 1 inside, falling to 0 over the band. */
int32_t rlvdb_to_fog(const RlvdbGrid *grid, const RlvdbCall *call, RlvdbGrid **out, RlvdbError *error);
/* Makes a level set of a scalar grid's surface at a value, or of the active voxels of a bool or mask grid; band is half its
 * width in voxels. */
int32_t rlvdb_to_level_set(const RlvdbGrid *grid, double value, float band, const RlvdbCall *call, RlvdbGrid **out,
                           RlvdbError *error);
/* Makes an int32 grid with the label of the level set that a voxel is inside of; later ones win. */
int32_t rlvdb_labels(const RlvdbGrid *const *level_sets, const int32_t *labels, size_t count, const RlvdbCall *call,
                     RlvdbGrid **out, RlvdbError *error);
/* Makes a mask of the active voxels of an int32 or int64 grid that have a label. */
int32_t rlvdb_label_mask(const RlvdbGrid *grid, int64_t label, const RlvdbCall *call, RlvdbGrid **out,
                         RlvdbError *error);

/* Entries for tests. Reads an attribute of the points of a file's only grid: vectors, or numbers of a stride; those of P
 * are world positions. Writes at most capacity numbers, and how many there are. */
int32_t rlvdb_test_points_read(const char *path, const char *name, float *values, size_t capacity, size_t *count,
                               RlvdbError *error);
/* Writes points with 16-bit velocities and a radius of 0.25 as a file's only grid. */
int32_t rlvdb_test_points_write(const char *path, const float *points, const float *velocities, size_t count,
                                double voxel, int32_t is_fixed, uint32_t packing, RlvdbError *error);
/* Writes a file of two grids that share one tree. */
int32_t rlvdb_test_instances_write(const char *path, const RlvdbGrid *grid, RlvdbError *error);

#ifdef __cplusplus
}
#endif

#endif
