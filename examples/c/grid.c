/* Makes a level set of a closed mesh, rounds and thickens it, writes it as an OpenVDB file, reads it back and meshes it.
 *
 *     grid MESH FILE.vdb RESULT.obj VOXEL
 */
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
    RlvContext context = RLV_NULL;
    RlvMesh mesh = RLV_NULL, result = RLV_NULL;
    RlvGrid level_set = RLV_NULL, smooth = RLV_NULL, thick = RLV_NULL, read = RLV_NULL;
    RlvGridSettings settings = RLV_GRID_SETTINGS_INIT;
    RlvGridInfo info = RLV_GRID_INFO_INIT;
    RlvMeshInfo faces = RLV_MESH_INFO_INIT;
    if (argc != 5) {
        fprintf(stderr, "usage: grid MESH FILE.vdb RESULT.obj VOXEL\n");
        return 2;
    }
    check(rlv_context_create(NULL, &context));
    check(rlv_mesh_read(context, argv[1], &mesh));
    settings.voxel = (float)atof(argv[4]);
    check(rlv_grid_from_mesh(mesh, &settings, NULL, NULL, &level_set));
    settings.iterations = 2;
    check(rlv_grid_change(level_set, RLV_GRID_MEAN, &settings, NULL, NULL, &smooth));
    settings.distance = 2.0f * settings.voxel;
    check(rlv_grid_change(smooth, RLV_GRID_OFFSET, &settings, NULL, NULL, &thick));
    check(rlv_grid_set_name(thick, "surface"));
    check(rlv_grid_write(&thick, 1, argv[2], RLV_GRID_PACK_BLOSC));

    check(rlv_grid_file_info(context, argv[2], 0, &info));
    check(rlv_grid_read(context, argv[2], "surface", NULL, NULL, NULL, &read));
    settings.adaptivity = 0.05f;
    check(rlv_grid_mesh(read, &settings, NULL, NULL, &result));
    check(rlv_mesh_info(result, &faces));
    check(rlv_mesh_write(result, argv[3]));
    printf("%s: %llu active voxels; %s: %zu faces\n", info.name, (unsigned long long)info.active_voxels, argv[3],
           faces.face_count);

    check(rlv_mesh_release(result));
    check(rlv_grid_release(read));
    check(rlv_grid_release(thick));
    check(rlv_grid_release(smooth));
    check(rlv_grid_release(level_set));
    check(rlv_mesh_release(mesh));
    check(rlv_context_release(context));
    return 0;
}
