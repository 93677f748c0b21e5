/* Reads a mesh, pulls the top of it up at a coarse level, and writes the finest level, whose detail has followed.
 *
 *   cc levels.c $(pkg-config --cflags --libs relievo) -o levels && ./levels MESH OUT.obj [TRIANGLES]
 *
 * MESH is OBJ, PLY, glTF, STL, OFF or USD; TRIANGLES is the level at which it is pulled, 500 if it is not given. */
#include <relievo/relievo.h>

#include <stdio.h>
#include <stdlib.h>

static void check(RlvResult result) {
    if (result != RLV_OK) {
        fprintf(stderr, "%s\n", rlv_error_last());
        exit(1);
    }
}

/* A third of the largest side of a mesh's box. */
static float reach(const RlvMeshInfo *info) {
    float most = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
        const float side = info->high[axis] - info->low[axis];
        most = side > most ? side : most;
    }
    return most / 3.0f;
}

int main(int argc, char **argv) {
    if (argc < 3) {
        fprintf(stderr, "usage: levels MESH OUT.obj [TRIANGLES]\n");
        return 2;
    }
    RlvContext context = RLV_NULL;
    RlvMesh mesh = RLV_NULL, finest = RLV_NULL;
    RlvMeshInfo given = RLV_MESH_INFO_INIT;
    RlvProgressive whole = RLV_NULL;
    RlvLevel level = RLV_NULL;
    RlvLevelInfo info = RLV_LEVEL_INFO_INIT;
    check(rlv_context_create(NULL, &context));
    check(rlv_mesh_read(context, argv[1], &mesh));
    check(rlv_mesh_info(mesh, &given));
    check(rlv_progressive_create(mesh, NULL, NULL, NULL, &whole));
    check(rlv_level_create(whole, &level));
    check(rlv_level_set_triangles(level, argc > 3 ? strtoul(argv[3], NULL, 10) : 500));
    check(rlv_level_info(level, &info));

    /* What is within reach of the highest vertex moves up by half of that. */
    RlvLevelUpdate update = RLV_LEVEL_UPDATE_INIT;
    RlvLevelBuffers buffers = RLV_LEVEL_BUFFERS_INIT;
    buffers.vertex_capacity = info.vertex_count;
    buffers.triangle_capacity = info.triangle_count;
    buffers.points = malloc(info.vertex_count * 3 * sizeof(float));
    buffers.triangles = malloc(info.triangle_count * 3 * sizeof(uint32_t));
    if (buffers.points == NULL || buffers.triangles == NULL) {
        return 1;
    }
    check(rlv_level_update(level, &buffers, &update));
    size_t top = 0;
    for (size_t k = 1; k < update.vertex_count; ++k) {
        top = buffers.points[3 * k + 2] > buffers.points[3 * top + 2] ? k : top;
    }
    RlvLevelHandle handle = {{{0}, reach(&given), RLV_FALLOFF_SMOOTH}, {0}, {0, 0, 1}, 0, 0};
    for (int axis = 0; axis < 3; ++axis) {
        handle.region.center[axis] = buffers.points[3 * top + axis];
    }
    handle.translation[2] = handle.region.radius / 2.0f;
    RlvLevelEdit edit = RLV_LEVEL_EDIT_INIT;
    edit.handles = &handle;
    edit.handle_count = 1;
    size_t reached = 0;
    check(rlv_level_edit(level, &edit, &reached));
    printf("moved %zu of %zu vertices, at a level of %zu triangles\n", reached, info.vertex_count, info.triangle_count);

    check(rlv_level_set_triangles(level, SIZE_MAX));
    check(rlv_level_mesh(level, &finest));
    check(rlv_mesh_write(finest, argv[2]));
    free(buffers.points);
    free(buffers.triangles);
    check(rlv_mesh_release(finest));
    check(rlv_level_release(level));
    check(rlv_progressive_release(whole));
    check(rlv_mesh_release(mesh));
    check(rlv_context_release(context));
    return 0;
}
