/* Relievo: polygon meshes with attributes and subdivision tags.
 *
 * A mesh has points, faces of three or more corners, and named attributes of 1 to 4 floats or integers on points,
 * corners or faces. Known names: "uv" (corner, 2 floats, row 0 of an image is v = 0), "normal", "color" (scene-linear
 * Rec.709), "velocity" (point, 3), "joints" and "weights" (point, 4), "material" (face, 1 integer). Front faces are
 * counter-clockwise. Lengths are in object units. */
#ifndef RELIEVO_MESH_H
#define RELIEVO_MESH_H

#include "relievo/bytes.h"

typedef struct RlvMesh {
    uint64_t id;
} RlvMesh;

typedef enum RlvDomain { RLV_DOMAIN_POINT = 0, RLV_DOMAIN_CORNER = 1, RLV_DOMAIN_FACE = 2 } RlvDomain;

typedef enum RlvType { RLV_TYPE_F32 = 0, RLV_TYPE_U32 = 1 } RlvType;

/* The arrays a mesh is made from. All strides are in bytes, 0 for packed. */
typedef struct RlvMeshArrays {
    uint32_t struct_size;
    uint32_t face_size; /* corners of every face, if face_sizes is NULL */

    const float *points; /* x, y, z of every point */
    size_t point_count;
    size_t point_stride;

    const uint32_t *face_sizes; /* corners of each face, 3 or more; NULL if all have face_size */
    size_t face_count;
    size_t face_stride;

    const uint32_t *corners; /* point of every corner, face after face */
    size_t corner_count;
    size_t corner_stride;

    const uint32_t *creases;       /* two points per sharp edge */
    const float *crease_sharpness; /* of each: 0 (smooth) to 10; 10 and more is infinitely sharp */
    size_t crease_count;
    size_t crease_stride;
    size_t crease_sharpness_stride;

    const uint32_t *sharp_points;       /* points that are sharp corners */
    const float *sharp_point_sharpness; /* of each, as of creases */
    size_t sharp_point_count;
    size_t sharp_point_stride;
    size_t sharp_point_sharpness_stride;

    const uint32_t *holes; /* faces that shape their neighbours but have no surface */
    size_t hole_count;
    size_t hole_stride;
} RlvMeshArrays;

#define RLV_MESH_ARRAYS_INIT \
    {sizeof(RlvMeshArrays), 0, NULL, 0, 0, NULL, 0, 0, NULL, 0, 0, NULL, NULL, 0, 0, 0, NULL, NULL, 0, 0, 0, NULL, 0, 0}

typedef struct RlvMeshInfo {
    uint32_t struct_size;
    uint32_t attribute_count;
    size_t point_count;
    size_t face_count;
    size_t corner_count;
    size_t triangle_count; /* that rlv_mesh_get_triangles writes */
    size_t crease_count;
    size_t sharp_point_count;
    size_t hole_count;
    float low[3];  /* smallest coordinates of the points */
    float high[3]; /* largest */
} RlvMeshInfo;

#define RLV_MESH_INFO_INIT {sizeof(RlvMeshInfo), 0, 0, 0, 0, 0, 0, 0, 0, {0}, {0}}

/* The arrays an attribute is made from. */
typedef struct RlvAttributeArrays {
    uint32_t struct_size;
    uint32_t domain; /* RlvDomain */
    uint32_t type;   /* RlvType */
    uint32_t width;  /* numbers per value, 1 to 4 */

    const char *name; /* UTF-8, 1 to 47 bytes, no attribute of the mesh has it yet */

    const void *values; /* width numbers of the type per value; one value per element, or any number with indices */
    size_t value_count;
    size_t value_stride;

    const uint32_t *indices; /* NULL, or for corner attributes the value of each corner */
    size_t index_count;
    size_t index_stride;
} RlvAttributeArrays;

#define RLV_ATTRIBUTE_ARRAYS_INIT {sizeof(RlvAttributeArrays), 0, 0, 0, NULL, NULL, 0, 0, NULL, 0, 0}

typedef struct RlvAttributeInfo {
    uint32_t struct_size;
    uint32_t domain;    /* RlvDomain */
    uint32_t type;      /* RlvType */
    uint32_t width;     /* numbers per value */
    size_t value_count; /* values; there are width times as many numbers */
    size_t index_count; /* 0, or the number of corners */
    char name[RLV_NAME_SIZE];
} RlvAttributeInfo;

#define RLV_ATTRIBUTE_INFO_INIT {sizeof(RlvAttributeInfo), 0, 0, 0, 0, 0, {0}}

/* Makes a mesh from arrays, which are copied and checked: at least one face, indices that exist, no point twice in a
 * face, finite numbers. The message of a refusal names the element. */
RLV_API RlvResult rlv_mesh_create(RlvContext context, const RlvMeshArrays *arrays, RlvMesh *out);

/* Called once when the library uses the arrays of a mesh no more, on the thread that dropped it last: after its last reference
 * was released, and the calls and jobs that read it have ended. It must not call into the library. */
typedef void (*RlvMeshReleased)(void *user);

/* As rlv_mesh_create, without a copy of points, corners and face_sizes: the mesh reads them where they lie. They must be
 * packed (stride 0, or 12, 4 and 4 bytes) at multiples of 4 bytes, and stay unchanged until released(user) is called,
 * which may be NULL for arrays that outlive the mesh. Without face_sizes the sizes take 4 bytes a face of the library's; all
 * other arrays are copied, and what is made of the mesh has copies of its own. rlv_mesh_set_points gives the mesh points of its own.
 * Fails as rlv_mesh_create does, and where an array cannot be borrowed; released is not called then. */
RLV_API RlvResult rlv_mesh_create_borrowed(RlvContext context, const RlvMeshArrays *arrays, RlvMeshReleased released,
                                           void *user, RlvMesh *out);

/* Reads a file as one mesh: OBJ with its subdivision tags "t crease" and "t corner", PLY, glTF or GLB at rest, STL,
 * OFF, USD (.usda, .usdc, .usd) at rest in metres with y up, and each of them packed by gzip (.ply.gz). path is UTF-8.
 * The file may be hostile: the context's memory limit bounds what reading it takes, files that it names are opened only
 * below its own folder, and the message of a refusal names the line or element. */
RLV_API RlvResult rlv_mesh_read(RlvContext context, const char *path, RlvMesh *out);

/* Writes a mesh as OBJ, PLY, GLB, USD (.usda, .usd), STL or OFF, as the extension of the path says. USD takes lengths for
 * metres and y for the axis that points up. The file appears whole or not at all. Fails if
 * the extension is another, the format cannot hold the mesh, or the file cannot be written. */
RLV_API RlvResult rlv_mesh_write(RlvMesh mesh, const char *path);

/* As rlv_mesh_read, from the size bytes of a file. format is the extension of the file, such as "obj" or "glb"; PLY, GLB and
 * USD are known by their first bytes too. Files that it names are not opened: a glTF that needs one is refused, and what
 * else they hold is left out. Fails as rlv_mesh_read does. */
RLV_API RlvResult rlv_mesh_read_bytes(RlvContext context, const char *format, const uint8_t *bytes, size_t size,
                                      RlvMesh *out);

/* Makes the bytes of the file that rlv_mesh_write writes; format is "obj", "ply" or "glb". Fails if it is another, or the
 * format cannot hold the mesh. */
RLV_API RlvResult rlv_mesh_write_bytes(RlvMesh mesh, const char *format, RlvBytes *out);

/* Makes a mesh of a mesh's triangles in which no edge is longer than longest_edge object units, which is above 0:
 * longer ones are halved from both sides, so that nothing opens, and attributes are carried along. What triangles are
 * to hold detail is as fine as that over the segments of the detail. Fails if there would be more than 2^26
 * triangles, if they would take more than the context's memory limit, and where an edge cannot get as short because no
 * float lies between the coordinates of its ends. */
RLV_API RlvResult rlv_mesh_split(RlvMesh mesh, double longest_edge, RlvMesh *out);

RLV_API RlvResult rlv_mesh_retain(RlvMesh mesh);
RLV_API RlvResult rlv_mesh_release(RlvMesh mesh);

/* How large the mesh is. No failure of its own. */
RLV_API RlvResult rlv_mesh_info(RlvMesh mesh, RlvMeshInfo *out);

/* Mutating. Moves the points: count is the mesh's number of points, three floats each. Surfaces that were made from the
 * mesh keep theirs; see rlv_surface_set_points. Fails, and changes nothing, if count is another number or a coordinate
 * is not finite. */
RLV_API RlvResult rlv_mesh_set_points(RlvMesh mesh, const float *points, size_t count, size_t stride);

/* Mutating. Adds an attribute. Fails, and changes nothing, if the mesh has one of that name, the number of values is
 * not that of the domain, or an index is out of range. */
RLV_API RlvResult rlv_mesh_add_attribute(RlvMesh mesh, const RlvAttributeArrays *arrays);

/* Writes the positions; capacity is in points and at least the number of points. Fails, and writes nothing, if there is
 * not enough room. */
RLV_API RlvResult rlv_mesh_get_points(RlvMesh mesh, float *points, size_t capacity, size_t stride);

/* Writes the size of every face and the point of every corner, packed. Either array may be NULL if it is not wanted;
 * capacities are in elements. Fails, and writes nothing, if there is not enough room. */
RLV_API RlvResult rlv_mesh_get_faces(RlvMesh mesh, uint32_t *face_sizes, size_t face_capacity, uint32_t *corners,
                                     size_t corner_capacity);

/* Writes the faces as triangles of three points each, fanned from the first corner of each face; holes are left out.
 * capacity is in triangles. Fails, and writes nothing, if there is not enough room. */
RLV_API RlvResult rlv_mesh_get_triangles(RlvMesh mesh, uint32_t *triangles, size_t capacity, size_t stride);

/* The index of the attribute called name, RLV_ERROR_NOT_FOUND if there is none. */
RLV_API RlvResult rlv_mesh_find_attribute(RlvMesh mesh, const char *name, uint32_t *out);

/* What attribute index, counted from 0, is. Fails if there is none. */
RLV_API RlvResult rlv_mesh_attribute_info(RlvMesh mesh, uint32_t index, RlvAttributeInfo *out);

/* Writes the numbers of attribute index, packed, and its indices if it has any. Either array may be NULL. capacities
 * are in numbers and in indices. Fails, and writes nothing, if there is no such attribute or not enough room. */
RLV_API RlvResult rlv_mesh_get_attribute(RlvMesh mesh, uint32_t index, void *values, size_t number_capacity,
                                         uint32_t *indices, size_t index_capacity);

#endif
