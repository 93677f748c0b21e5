/* Meshes: making them from arrays of any stride, attributes, tags, and what is refused. */
#include "check.h"

typedef struct Vertex {
    float position[3];
    float weight;
} Vertex;

static const Vertex vertices[] = {
    {{0, 0, 0}, 1}, {{1, 0, 0}, 2}, {{1, 1, 0}, 3}, {{0, 1, 0}, 4}, {{2, 0, 0}, 5}, {{2, 1, 0.5f}, 6}};
static const uint32_t sizes[] = {4, 3, 3};
static const uint32_t corners[] = {0, 1, 2, 3, 1, 4, 5, 1, 5, 2};

static RlvMeshArrays arrays(void) {
    RlvMeshArrays made = RLV_MESH_ARRAYS_INIT;
    made.points = vertices[0].position;
    made.point_count = 6;
    made.point_stride = sizeof(Vertex);
    made.face_sizes = sizes;
    made.face_count = 3;
    made.corners = corners;
    made.corner_count = 10;
    return made;
}

static void refused(RlvContext context, const RlvMeshArrays *given, const char *text) {
    RlvMesh untouched = {77};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_create(context, given, &untouched), text);
    CHECK(untouched.id == 77);
}

static void refusals(RlvContext context) {
    RlvMeshArrays bad = arrays();
    RlvMesh mesh = RLV_NULL, nothing = RLV_NULL;
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    bad.points = NULL;
    refused(context, &bad, "points: the pointer is NULL");
    bad = arrays();
    bad.point_stride = 8;
    refused(context, &bad, "stride of 8");
    bad = arrays();
    bad.point_count = SIZE_MAX / 4;
    refused(context, &bad, "address space");
    bad = arrays();
    bad.corner_count = 9;
    refused(context, &bad, "face sizes add up to 10");
    bad = arrays();
    bad.face_sizes = NULL;
    bad.face_size = 4;
    refused(context, &bad, "do not make 10 corners");
    bad = arrays();
    bad.face_count = 0;
    bad.corner_count = 0;
    refused(context, &bad, "empty");
    bad = arrays();
    uint32_t wild[10];
    memcpy(wild, corners, sizeof(wild));
    wild[5] = 6;
    bad.corners = wild;
    refused(context, &bad, "face 1, corner 1: point 6 does not exist");
    wild[5] = 1;
    refused(context, &bad, "repeated");
    bad = arrays();
    Vertex odd[6];
    memcpy(odd, vertices, sizeof(odd));
    odd[3].position[1] = NAN;
    bad.points = odd[0].position;
    refused(context, &bad, "point 3");
    bad = arrays();
    static const uint32_t edge[] = {0, 6};
    static const float sharp = 2.0f;
    bad.creases = edge;
    bad.crease_count = 1;
    refused(context, &bad, "crease_sharpness: the pointer is NULL");
    bad.crease_sharpness = &sharp;
    refused(context, &bad, "crease 0");
    static const uint32_t real_edge[] = {0, 1};
    static const float below = -1.0f;
    bad.creases = real_edge;
    bad.crease_sharpness = &below;
    refused(context, &bad, "10 and more is infinitely sharp");
    bad = arrays();
    bad.struct_size = 2;
    refused(context, &bad, "struct_size is 2");
    refused(context, NULL, "RlvMeshArrays: the pointer is NULL");
    bad = arrays();
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_create(context, &bad, NULL), "out");

    /* Handles of nothing and of other things. */
    RlvContext wrong_context = RLV_NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_create(wrong_context, &bad, &mesh), "context: the handle is NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_info(nothing, &info), "mesh: the handle is NULL");
    nothing.id = context.id;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_info(nothing, &info), "of a context");
    nothing.id = UINT64_MAX;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_release(nothing), "unknown");
}

static void attributes(RlvMesh mesh) {
    RlvAttributeArrays weight = RLV_ATTRIBUTE_ARRAYS_INIT;
    weight.domain = RLV_DOMAIN_POINT;
    weight.type = RLV_TYPE_F32;
    weight.width = 1;
    weight.name = "weight";
    weight.values = &vertices[0].weight;
    weight.value_count = 6;
    weight.value_stride = sizeof(Vertex);
    CHECK_OK(rlv_mesh_add_attribute(mesh, &weight));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_add_attribute(mesh, &weight), "used twice");

    static const float uv_values[] = {0, 0, 1, 0, 0.5f, 1};
    static const uint32_t uv_indices[] = {0, 1, 2, 0, 1, 2, 0, 1, 2, 0};
    RlvAttributeArrays uv = RLV_ATTRIBUTE_ARRAYS_INIT;
    uv.domain = RLV_DOMAIN_CORNER;
    uv.width = 2;
    uv.name = "uv";
    uv.values = uv_values;
    uv.value_count = 3;
    uv.indices = uv_indices;
    uv.index_count = 10;
    CHECK_OK(rlv_mesh_add_attribute(mesh, &uv));

    static const uint32_t material_values[] = {4, 4, 9};
    RlvAttributeArrays material = RLV_ATTRIBUTE_ARRAYS_INIT;
    material.domain = RLV_DOMAIN_FACE;
    material.type = RLV_TYPE_U32;
    material.width = 1;
    material.name = "material";
    material.values = material_values;
    material.value_count = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_add_attribute(mesh, &material), "2 numbers for 3 elements");
    material.value_count = 3;
    CHECK_OK(rlv_mesh_add_attribute(mesh, &material));
    material.name = "";
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_add_attribute(mesh, &material), "name");
    material.name = "\xff";
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_add_attribute(mesh, &material), "UTF-8");
    material.name = "m";
    material.width = 5;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_add_attribute(mesh, &material), "width");
    material.width = 1;
    material.type = 7;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_add_attribute(mesh, &material), "type");

    uint32_t index = 99;
    RlvAttributeInfo info = RLV_ATTRIBUTE_INFO_INIT;
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_mesh_find_attribute(mesh, "wieght", &index), "did you mean `weight`");
    CHECK(index == 99);
    CHECK_OK(rlv_mesh_find_attribute(mesh, "uv", &index));
    CHECK_OK(rlv_mesh_attribute_info(mesh, index, &info));
    CHECK(info.domain == RLV_DOMAIN_CORNER && info.type == RLV_TYPE_F32 && info.width == 2);
    CHECK(info.value_count == 3 && info.index_count == 10 && strcmp(info.name, "uv") == 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_attribute_info(mesh, 3, &info), "attribute 3 does not exist");
    float values[6] = {0};
    uint32_t indices[10] = {0};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_get_attribute(mesh, index, values, 6, indices, 9), "indices");
    CHECK(values[2] == 0.0f);
    CHECK_OK(rlv_mesh_get_attribute(mesh, index, values, 6, indices, 10));
    CHECK(memcmp(values, uv_values, sizeof(values)) == 0 && memcmp(indices, uv_indices, sizeof(indices)) == 0);
    CHECK_OK(rlv_mesh_find_attribute(mesh, "weight", &index));
    CHECK_OK(rlv_mesh_get_attribute(mesh, index, values, 6, NULL, 0));
    CHECK(values[0] == 1.0f && values[5] == 6.0f);
}

static void write_file(const char *path, const char *text) {
    FILE *file = fopen(path, "w");
    CHECK(file != NULL && fputs(text, file) >= 0 && fclose(file) == 0);
}

static void files(RlvContext context) {
    RlvMesh mesh = {77};
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    write_file("mesh_test.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nt crease 2/1/0 0 1 2.5\n");
    CHECK_OK(rlv_mesh_read(context, "mesh_test.obj", &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK(info.point_count == 4 && info.face_count == 1 && info.crease_count == 1);
    CHECK_OK(rlv_mesh_write(mesh, "mesh_test.ply"));
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_mesh_write(mesh, "mesh_test.xyz"), "mesh_test.xyz");
    CHECK(rlv_mesh_write(mesh, "no such folder/mesh.ply") == RLV_ERROR_NOT_FOUND);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_mesh_read(context, "mesh_test.ply", &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK(info.point_count == 4 && info.face_count == 1 && remove("mesh_test.ply") == 0);
    CHECK_OK(rlv_mesh_release(mesh));
    mesh.id = 77;
    write_file("mesh_test.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_read(context, "mesh_test.obj", &mesh), "mesh_test.obj");
    write_file("mesh_test.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 2\n");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_read(context, "mesh_test.obj", &mesh), "repeated");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_mesh_read(context, "no such file.obj", &mesh), "no such file.obj");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_read(context, NULL, &mesh), "path");
    CHECK(mesh.id == 77 && remove("mesh_test.obj") == 0);
}

/* The points of the mesh of a crease and a point of this sharpness, refined. */
static size_t refined_points(RlvContext context, float sharpness, float *points, size_t capacity) {
    static const uint32_t crease[] = {1, 2}, sharp_point = 3;
    RlvMeshArrays given = arrays();
    RlvMesh mesh = RLV_NULL, refined = RLV_NULL;
    RlvSubdivision subdivision = RLV_NULL;
    RlvSubdivisionOptions options = RLV_SUBDIVISION_OPTIONS_INIT;
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    options.boundary = RLV_BOUNDARY_EDGES;
    given.creases = crease;
    given.crease_sharpness = &sharpness;
    given.crease_count = 1;
    given.sharp_points = &sharp_point;
    given.sharp_point_sharpness = &sharpness;
    given.sharp_point_count = 1;
    CHECK_OK(rlv_mesh_create(context, &given, &mesh));
    CHECK_OK(rlv_subdivision_create(context, mesh, &options, &subdivision));
    CHECK_OK(rlv_subdivision_refine(subdivision, 2, &refined));
    CHECK_OK(rlv_mesh_info(refined, &info));
    CHECK(3 * info.point_count <= capacity);
    CHECK_OK(rlv_mesh_get_points(refined, points, info.point_count, 0));
    CHECK_OK(rlv_mesh_release(refined));
    CHECK_OK(rlv_subdivision_release(subdivision));
    CHECK_OK(rlv_mesh_release(mesh));
    return 3 * info.point_count * sizeof(float);
}

/* From 10 on an edge or point is infinitely sharp, whatever the number. */
static void sharpness_above_ten(RlvContext context) {
    float ten[600], eleven[600], huge[600], half[600];
    const size_t size = refined_points(context, 10.0f, ten, 600);
    CHECK(refined_points(context, 11.0f, eleven, 600) == size && memcmp(ten, eleven, size) == 0);
    CHECK(refined_points(context, 1e30f, huge, 600) == size && memcmp(ten, huge, size) == 0);
    CHECK(refined_points(context, 0.5f, half, 600) == size && memcmp(ten, half, size) != 0);
}

int main(void) {
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    refusals(context);
    sharpness_above_ten(context);
    files(context);

    static const uint32_t creases[] = {0, 1, 1, 2};
    static const float sharpness[] = {10.0f, 2.5f};
    static const uint32_t sharp_point = 3, hole = 2;
    RlvMeshArrays good = arrays();
    good.creases = creases;
    good.crease_sharpness = sharpness;
    good.crease_count = 2;
    good.sharp_points = &sharp_point;
    good.sharp_point_sharpness = sharpness;
    good.sharp_point_count = 1;
    good.holes = &hole;
    good.hole_count = 1;
    RlvMesh mesh = RLV_NULL;
    CHECK_OK(rlv_mesh_create(context, &good, &mesh));
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK(info.point_count == 6 && info.face_count == 3 && info.corner_count == 10 && info.triangle_count == 3);
    CHECK(info.crease_count == 2 && info.sharp_point_count == 1 && info.hole_count == 1 && info.attribute_count == 0);
    CHECK(info.low[0] == 0.0f && info.high[0] == 2.0f && info.high[2] == 0.5f);

    /* What comes out is what went in. */
    float points[24] = {0};
    uint32_t got_sizes[3], got_corners[10], triangles[9];
    CHECK_OK(rlv_mesh_get_points(mesh, points, 6, 16));
    CHECK(points[4 * 5] == 2.0f && points[4 * 5 + 2] == 0.5f);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_get_points(mesh, points, 5, 0), "room for 5");
    CHECK_OK(rlv_mesh_get_faces(mesh, got_sizes, 3, got_corners, 10));
    CHECK(memcmp(got_sizes, sizes, sizeof(sizes)) == 0 && memcmp(got_corners, corners, sizeof(corners)) == 0);
    CHECK_OK(rlv_mesh_get_faces(mesh, NULL, 0, got_corners, 10));
    static const uint32_t expected[] = {0, 1, 2, 0, 2, 3, 1, 4, 5};
    CHECK_OK(rlv_mesh_get_triangles(mesh, triangles, 3, 0));
    CHECK(memcmp(triangles, expected, sizeof(expected)) == 0);

    /* Points can move; bad ones change nothing. */
    float moved[18] = {0};
    moved[4] = 3.0f;
    CHECK_OK(rlv_mesh_set_points(mesh, moved, 6, 0));
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK(info.high[1] == 3.0f && info.high[0] == 0.0f);
    moved[4] = INFINITY;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_set_points(mesh, moved, 6, 0), "element 1");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_set_points(mesh, points, 5, 0), "5 points were given for 6");
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK(info.high[1] == 3.0f);

    attributes(mesh);
    CHECK_OK(rlv_mesh_release(mesh));

    /* A memory limit bounds what a mesh may take. */
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvContext small = RLV_NULL;
    options.memory_limit = 64;
    CHECK_OK(rlv_context_create(&options, &small));
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_mesh_create(small, &good, &mesh), "memory limit");
    CHECK_OK(rlv_context_release(small));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
