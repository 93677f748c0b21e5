/* Reads a mesh and writes it with half the triangles, a quarter, an eighth and so on, texture coordinates and all, until
 * the next one would deviate too far.
 *
 *   cc simplify.c $(pkg-config --cflags --libs relievo) -o simplify && ./simplify MESH OUT [ERROR]
 *
 * MESH is OBJ, PLY, glTF, STL, OFF or USD; the files are OUT-1.obj, OUT-2.obj and on. ERROR is a part of the largest side
 * of the mesh's box, 0.005 if it is not given. */
#include <relievo/relievo.h>

#include <stdio.h>
#include <stdlib.h>

static void check(RlvResult result) {
    if (result != RLV_OK) {
        fprintf(stderr, "%s\n", rlv_error_last());
        exit(1);
    }
}

int main(int argc, char **argv) {
    if (argc < 3) {
        fprintf(stderr, "usage: simplify MESH OUT [ERROR]\n");
        return 2;
    }
    RlvContext context = RLV_NULL;
    RlvMesh mesh = RLV_NULL;
    RlvMeshInfo given = RLV_MESH_INFO_INIT;
    check(rlv_context_create(NULL, &context));
    check(rlv_mesh_read(context, argv[1], &mesh));
    check(rlv_mesh_info(mesh, &given));
    float most = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
        const float side = given.high[axis] - given.low[axis];
        most = side > most ? side : most;
    }
    most *= argc > 3 ? strtof(argv[3], NULL) : 0.005f;

    RlvSimplifyOptions options = RLV_SIMPLIFY_OPTIONS_INIT;
    for (int level = 1; level < 32; ++level) {
        RlvMesh fewer = RLV_NULL;
        RlvMeshInfo info = RLV_MESH_INFO_INIT;
        float error = 0.0f;
        char path[4096];
        /* Always of the mesh that was read: errors would add up otherwise. */
        options.triangles = given.triangle_count >> level;
        check(rlv_simplify_mesh(mesh, &options, NULL, NULL, &error, &fewer));
        check(rlv_mesh_info(fewer, &info));
        const int is_last = error > most || info.triangle_count > options.triangles + 1;
        if (!is_last) {
            snprintf(path, sizeof path, "%s-%d.obj", argv[2], level);
            check(rlv_mesh_write(fewer, path));
            printf("%s: %zu of %zu triangles, error %g\n", path, info.triangle_count, given.triangle_count, error);
        }
        check(rlv_mesh_release(fewer));
        if (is_last) {
            break;
        }
    }
    check(rlv_mesh_release(mesh));
    check(rlv_context_release(context));
    return 0;
}
