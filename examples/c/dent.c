/* Presses a ball into a plane and writes the dented plane as an OBJ file.
 *
 *   cc dent.c $(pkg-config --cflags --libs relievo) -o dent && ./dent dent.obj
 */
#include <relievo/relievo.h>

#include <stdio.h>
#include <stdlib.h>

/* Every function returns RLV_OK, or rlv_error_last() says what went wrong, where, and what can be done. */
static void check(RlvResult result) {
    if (result != RLV_OK) {
        fprintf(stderr, "%s\n", rlv_error_last());
        exit(1);
    }
}

/* The control cage: 8 x 8 quads in the plane z = 0, from (-2, -2) to (2, 2). */
static RlvMesh make_plane(RlvContext context) {
    enum { SIDE = 8, POINTS = (SIDE + 1) * (SIDE + 1), FACES = SIDE * SIDE };
    float points[POINTS][3];
    uint32_t corners[FACES][4];
    for (int i = 0; i < POINTS; ++i) {
        points[i][0] = (float)(i % (SIDE + 1)) * 0.5f - 2.0f;
        points[i][1] = (float)(i / (SIDE + 1)) * 0.5f - 2.0f;
        points[i][2] = 0.0f;
    }
    for (uint32_t face = 0; face < FACES; ++face) {
        uint32_t first = face / SIDE * (SIDE + 1) + face % SIDE;
        corners[face][0] = first;
        corners[face][1] = first + 1;
        corners[face][2] = first + SIDE + 2;
        corners[face][3] = first + SIDE + 1;
    }
    /* Arrays are borrowed for the call. A stride of 0, which the INIT sets, means packed. */
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    arrays.points = points[0];
    arrays.point_count = POINTS;
    arrays.face_size = 4;
    arrays.face_count = FACES;
    arrays.corners = corners[0];
    arrays.corner_count = FACES * 4;
    RlvMesh mesh = RLV_NULL;
    check(rlv_mesh_create(context, &arrays, &mesh));
    return mesh;
}

/* A ball: the limit surface of a cube is round. */
static RlvMesh make_ball(RlvContext context) {
    static const uint32_t corners[] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6};
    float points[8][3];
    for (int i = 0; i < 8; ++i) {
        points[i][0] = i & 1 ? 1.0f : -1.0f;
        points[i][1] = i & 2 ? 1.0f : -1.0f;
        points[i][2] = i & 4 ? 1.0f : -1.0f;
    }
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    arrays.points = points[0];
    arrays.point_count = 8;
    arrays.face_size = 4;
    arrays.face_count = 6;
    arrays.corners = corners;
    arrays.corner_count = 24;
    RlvMesh cube = RLV_NULL, ball = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvTessellateOptions options = RLV_TESSELLATE_OPTIONS_INIT;
    options.coarse = 64;
    check(rlv_mesh_create(context, &arrays, &cube));
    check(rlv_surface_create(context, cube, NULL, &surface));
    check(rlv_tessellate_surface(surface, &options, &ball));
    check(rlv_surface_release(surface));
    check(rlv_mesh_release(cube));
    return ball;
}

/* Copies the triangles out of the library, as a host does that has its own meshes, and writes them. */
static void write_obj(RlvMesh mesh, const char *path) {
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    check(rlv_mesh_info(mesh, &info));
    float *points = malloc(info.point_count * 3 * sizeof(float));
    uint32_t *triangles = malloc(info.triangle_count * 3 * sizeof(uint32_t));
    FILE *file = fopen(path, "w");
    if (points == NULL || triangles == NULL || file == NULL) {
        fprintf(stderr, "cannot write %s\n", path);
        exit(1);
    }
    check(rlv_mesh_get_points(mesh, points, info.point_count, 0));
    check(rlv_mesh_get_triangles(mesh, triangles, info.triangle_count, 0));
    for (size_t i = 0; i < info.point_count; ++i) {
        fprintf(file, "v %.9g %.9g %.9g\n", points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    }
    for (size_t i = 0; i < info.triangle_count; ++i) {
        fprintf(file, "f %u %u %u\n", triangles[3 * i] + 1, triangles[3 * i + 1] + 1, triangles[3 * i + 2] + 1);
    }
    if (fclose(file) != 0) {
        fprintf(stderr, "cannot write %s\n", path);
        exit(1);
    }
    free(points);
    free(triangles);
}

int main(int argc, char **argv) {
    const char *path = argc > 1 ? argv[1] : "dent.obj";

    /* A context has the threads. NULL for the defaults: all cores. */
    RlvContext context = RLV_NULL;
    check(rlv_context_create(NULL, &context));

    /* The smooth surface of the cage, and a detail on it that can be edited. */
    RlvMesh plane = make_plane(context);
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    check(rlv_surface_create(context, plane, NULL, &surface));
    check(rlv_detail_create(surface, NULL, NULL, &detail));

    /* What is pressed into it: a ball over the plane, its lowest point 0.25 below. */
    RlvMesh ball = make_ball(context);
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    check(rlv_mesh_info(ball, &info));
    const double matrix[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -0.25 - info.low[2]};
    RlvCollider collider = RLV_NULL;
    check(rlv_collider_create_mesh(context, ball, matrix, &collider));

    /* Press. An animation does this every frame, with the frame's number in an RlvImprintMoment. */
    RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
    check(rlv_imprint_run(detail, collider, NULL, NULL, &report));

    /* Now the edit becomes visible. A host with triangles of its own would renew those of the changed tiles. */
    RlvDetailChanges changes = RLV_DETAIL_CHANGES_INIT;
    check(rlv_detail_commit(detail, &changes));
    printf("%lu tiles changed, exact to %.4f\n", (unsigned long)changes.tile_count, report.voxel_diagonal);

    RlvMesh dented = RLV_NULL;
    check(rlv_tessellate_detail(detail, NULL, &dented));
    check(rlv_mesh_info(dented, &info));
    printf("depth %.4f\n", -info.low[2]);
    write_obj(dented, path);

    /* Objects keep alive what they need, so the order does not matter. */
    check(rlv_mesh_release(dented));
    check(rlv_collider_release(collider));
    check(rlv_mesh_release(ball));
    check(rlv_detail_release(detail));
    check(rlv_surface_release(surface));
    check(rlv_mesh_release(plane));
    check(rlv_context_release(context));
    return 0;
}
