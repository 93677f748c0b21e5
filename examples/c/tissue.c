/* A ball presses a block of gel. Builds the model, simulates it step by step, and writes meshes of its surface.
 *
 *   cc tissue.c $(pkg-config --cflags --libs relievo) -lm -o tissue && ./tissue OUT [FRAMES] */
#include <relievo/relievo.h>

#include <stdio.h>
#include <stdlib.h>

static void check(RlvResult result) {
    if (result != RLV_OK) {
        fprintf(stderr, "%s\n", rlv_error_last());
        exit(1);
    }
}

/* A closed box from (0, 0, 0) to (0.12, 0.12, 0.06). */
static RlvMesh box(RlvContext context) {
    static const uint32_t corners[24] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6};
    float points[24];
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    RlvMesh mesh = RLV_NULL;
    for (int at = 0; at < 8; ++at) {
        points[3 * at] = at & 1 ? 0.12f : 0.0f;
        points[3 * at + 1] = at & 2 ? 0.12f : 0.0f;
        points[3 * at + 2] = at & 4 ? 0.06f : 0.0f;
    }
    arrays.points = points;
    arrays.point_count = 8;
    arrays.face_size = 4;
    arrays.face_count = 6;
    arrays.corners = corners;
    arrays.corner_count = 24;
    check(rlv_mesh_create(context, &arrays, &mesh));
    return mesh;
}

int main(int argc, char **argv) {
    if (argc < 2) {
        fprintf(stderr, "usage: tissue OUT [FRAMES]\n");
        return 2;
    }
    const int frames = argc > 2 ? atoi(argv[2]) : 6;
    RlvContext context = RLV_NULL;
    check(rlv_context_create(NULL, &context));

    /* The model: voxels of 6 mm, and a fine surface that follows them. */
    RlvMesh surface = box(context), fine = RLV_NULL;
    RlvTissueMaterial gel = RLV_TISSUE_MATERIAL_INIT;
    RlvTissueVolume block = RLV_TISSUE_VOLUME_INIT;
    RlvTissueSurface skin = RLV_TISSUE_SURFACE_INIT;
    RlvTissueDescription description = RLV_TISSUE_DESCRIPTION_INIT;
    RlvTissue tissue = RLV_NULL;
    check(rlv_mesh_split(surface, 0.004, &fine));
    gel.name = "gel";
    gel.young = 8000.0f;
    gel.poisson = 0.45f;
    block.name = "block";
    block.mesh = surface;
    skin.purpose = RLV_TISSUE_BIND;
    skin.name = "skin";
    skin.mesh = fine;
    for (int axis = 0; axis < 3; ++axis) {
        description.cell[axis] = 0.006f;
    }
    description.materials = &gel;
    description.material_count = 1;
    description.volumes = &block;
    description.volume_count = 1;
    description.surfaces = &skin;
    description.surface_count = 1;
    check(rlv_tissue_build(context, &description, NULL, NULL, NULL, &tissue));

    /* Its lower side is held. */
    RlvTissueInfo info = RLV_TISSUE_INFO_INIT;
    RlvTissueSet set = RLV_TISSUE_SET_INIT;
    uint32_t index = 0;
    check(rlv_tissue_info(tissue, &info));
    check(rlv_tissue_find_set(tissue, "z-", &index));
    check(rlv_tissue_set(tissue, index, &set));
    uint32_t *nodes = malloc(set.count * sizeof *nodes);
    if (nodes == NULL) {
        return 1;
    }
    check(rlv_tissue_get_set(tissue, index, nodes, set.count));
    check(rlv_tissue_hold(tissue, nodes, set.count, 0, 7));
    free(nodes);

    /* A ball of 30 mm comes down. */
    const double times[2] = {0.0, 0.1};
    const float path[6] = {0.06f, 0.06f, 0.095f, 0.06f, 0.06f, 0.07f};
    RlvTissueOptions options = RLV_TISSUE_OPTIONS_INIT;
    RlvTissueCollider ball = RLV_TISSUE_COLLIDER_INIT;
    RlvTissueSimulation simulation = RLV_NULL;
    options.damping = 10.0f;
    ball.body = RLV_TISSUE_BALL;
    ball.radius = 0.03f;
    ball.friction = 0.3f;
    ball.times = times;
    ball.translations = path;
    ball.key_count = 2;
    check(rlv_tissue_simulate(tissue, &options, &simulation));
    check(rlv_tissue_simulation_add_collider(simulation, &ball));
    float *von_mises = malloc(info.element_count * sizeof *von_mises);
    if (von_mises == NULL) {
        return 1;
    }
    RlvTissueArrays arrays = RLV_TISSUE_ARRAYS_INIT;
    arrays.element_count = info.element_count;
    arrays.von_mises = von_mises;
    for (int frame = 1; frame <= frames; ++frame) {
        char path_of_frame[1024];
        RlvMesh mesh = RLV_NULL;
        check(rlv_tissue_simulation_advance(simulation, 1.0 / 48.0, NULL, NULL));
        check(rlv_tissue_simulation_get(simulation, &arrays));
        float most = 0.0f;
        for (size_t element = 0; element < info.element_count; ++element) {
            most = von_mises[element] > most ? von_mises[element] : most;
        }
        check(rlv_tissue_simulation_mesh(simulation, 0, &mesh));
        snprintf(path_of_frame, sizeof path_of_frame, "%s.%04d.ply", argv[1], frame);
        check(rlv_mesh_write(mesh, path_of_frame));
        check(rlv_mesh_release(mesh));
        printf("frame %d: a stress of up to %.0f Pa in %d elements\n", frame, most, (int)info.element_count);
    }
    free(von_mises);
    check(rlv_tissue_simulation_release(simulation));
    check(rlv_tissue_release(tissue));
    check(rlv_mesh_release(fine));
    check(rlv_mesh_release(surface));
    check(rlv_context_release(context));
    return 0;
}
