/* Tessellation: closed, with normals, attributes and places that evaluate to its points. */
#include "check.h"

/* A cube of side 2 with a face attribute. */
static RlvMesh cube(RlvContext context) {
    static const float points[] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1};
    static const uint32_t corners[] = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7};
    static const uint32_t material[] = {10, 11, 12, 13, 14, 15};
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    arrays.points = points;
    arrays.point_count = 8;
    arrays.face_size = 4;
    arrays.face_count = 6;
    arrays.corners = corners;
    arrays.corner_count = 24;
    RlvMesh mesh = RLV_NULL;
    CHECK_OK(rlv_mesh_create(context, &arrays, &mesh));
    RlvAttributeArrays slots = RLV_ATTRIBUTE_ARRAYS_INIT;
    slots.domain = RLV_DOMAIN_FACE;
    slots.type = RLV_TYPE_U32;
    slots.width = 1;
    slots.name = "material";
    slots.values = material;
    slots.value_count = 6;
    CHECK_OK(rlv_mesh_add_attribute(mesh, &slots));
    return mesh;
}

static void *get(RlvMesh mesh, const char *name, size_t numbers) {
    uint32_t index = 0;
    void *values = malloc(numbers * 4);
    CHECK(values != NULL);
    CHECK_OK(rlv_mesh_find_attribute(mesh, name, &index));
    CHECK_OK(rlv_mesh_get_attribute(mesh, index, values, numbers, NULL, 0));
    return values;
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvMesh mesh = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh cage = cube(context);
    CHECK_OK(rlv_surface_create(context, cage, NULL, &surface));
    CHECK_OK(rlv_mesh_release(cage));

    RlvTessellateOptions options = RLV_TESSELLATE_OPTIONS_INIT;
    options.coarse = 4;
    options.places = 1;
    CHECK_OK(rlv_tessellate_surface(surface, &options, &mesh));
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK(info.face_count == 6 * 4 * 4 * 2 && info.triangle_count == info.face_count);
    /* Euler's number of a sphere. */
    CHECK(info.point_count == 2 + info.face_count / 2);

    /* The place of every corner leads to its point, and faces keep their material. */
    size_t corners = info.corner_count;
    float *points = malloc(info.point_count * 12), *found = malloc(corners * 12);
    uint32_t *indices = malloc(corners * 4), *corner_tiles = malloc(corners * 4);
    CHECK(points && found && indices && corner_tiles);
    CHECK_OK(rlv_mesh_get_points(mesh, points, info.point_count, 0));
    CHECK_OK(rlv_mesh_get_faces(mesh, NULL, 0, indices, corners));
    uint32_t *tiles = get(mesh, "tile", info.face_count), *materials = get(mesh, "material", info.face_count);
    float *uvs = get(mesh, "tile_uv", corners * 2), *normals = get(mesh, "normal", info.point_count * 3);
    for (size_t corner = 0; corner < corners; ++corner) {
        corner_tiles[corner] = tiles[corner / 3];
        CHECK(materials[corner / 3] == 10 + tiles[corner / 3]);
    }
    RlvEvaluateArrays places = RLV_EVALUATE_ARRAYS_INIT;
    places.count = corners;
    places.tiles = corner_tiles;
    places.uvs = uvs;
    places.positions = found;
    CHECK_OK(rlv_evaluate_surface(surface, &places));
    for (size_t corner = 0; corner < corners; ++corner) {
        const float *point = points + 3 * indices[corner], *normal = normals + 3 * indices[corner];
        for (int axis = 0; axis < 3; ++axis) {
            CHECK_NEAR(found[3 * corner + axis], point[axis], 1e-5);
        }
        CHECK(normal[0] * point[0] + normal[1] * point[1] + normal[2] * point[2] > 0.5f);
    }
    free(points), free(found), free(indices), free(corner_tiles);
    free(tiles), free(materials), free(uvs), free(normals);
    CHECK_OK(rlv_mesh_release(mesh));

    /* Refusals. */
    RlvMesh untouched = {77};
    options.coarse = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tessellate_surface(surface, &options, &untouched), "coarse");
    options.coarse = 1024;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tessellate_surface(surface, &options, &untouched), "coarse");
    CHECK(untouched.id == 77);
    CHECK_OK(rlv_surface_release(surface));

    RlvContextOptions limits = RLV_CONTEXT_OPTIONS_INIT;
    RlvContext small = RLV_NULL;
    limits.memory_limit = 64 << 20;
    CHECK_OK(rlv_context_create(&limits, &small));
    cage = cube(small);
    CHECK_OK(rlv_surface_create(small, cage, NULL, &surface));
    options.coarse = 512;
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_tessellate_surface(surface, &options, &untouched), "memory limit");
    CHECK_OK(rlv_mesh_release(cage));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_context_release(small));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
