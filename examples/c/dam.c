/* A block of water falls into a basin. Simulates some frames, writes a mesh of the surface of the last one, and looks down on
 * the water with rays, without the mesh.
 *
 *   cc dam.c $(pkg-config --cflags --libs relievo) -o dam && ./dam OUT.ply [FRAMES] */
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
    if (argc < 2) {
        fprintf(stderr, "usage: dam OUT.ply [FRAMES]\n");
        return 2;
    }
    const int frames = argc > 2 ? atoi(argv[2]) : 12;
    const double low[3] = {0, 0, 0}, block[3] = {0.4, 0.24, 0.48}, basin[3] = {1.2, 0.24, 0.8};
    RlvContext context = RLV_NULL;
    RlvFluid fluid = RLV_NULL;
    RlvFluidOptions options = RLV_FLUID_OPTIONS_INIT;
    options.spacing = 0.04f;
    check(rlv_context_create(NULL, &context));
    check(rlv_fluid_create(context, &options, &fluid));
    check(rlv_fluid_set_basin(fluid, low, basin));
    check(rlv_fluid_add_box(fluid, low, block, NULL));

    RlvFluidInfo info = RLV_FLUID_INFO_INIT;
    check(rlv_fluid_info(fluid, &info));
    float *points = malloc(info.particle_count * 3 * sizeof(float));
    if (points == NULL) {
        return 1;
    }
    RlvFluidArrays arrays = RLV_FLUID_ARRAYS_INIT;
    arrays.capacity = info.particle_count;
    arrays.points = points;
    for (int frame = 1; frame <= frames; ++frame) {
        RlvFluidReport report = RLV_FLUID_REPORT_INIT;
        check(rlv_fluid_advance(fluid, 1.0 / 24.0, NULL, NULL, &report));
        check(rlv_fluid_get(fluid, &arrays));
        float front = 0.0f;
        for (size_t k = 0; k < info.particle_count; ++k) {
            front = points[3 * k] > front ? points[3 * k] : front;
        }
        printf("frame %d: %d steps, at most %.2f %% too dense, the front is at %.2f m\n", frame, (int)report.steps,
               100.0 * report.max_excess, front);
    }

    RlvIsosurface surface = RLV_NULL;
    RlvMesh mesh = RLV_NULL;
    RlvMeshInfo made = RLV_MESH_INFO_INIT;
    RlvIsosurfaceMeshOptions how = RLV_ISOSURFACE_MESH_OPTIONS_INIT;
    how.iterations = 4;
    check(rlv_fluid_isosurface(fluid, NULL, &surface));
    check(rlv_isosurface_mesh(surface, &how, NULL, NULL, &mesh));
    check(rlv_mesh_info(mesh, &made));
    check(rlv_mesh_write(mesh, argv[1]));
    printf("%d particles, %d triangles\n", (int)info.particle_count, (int)made.triangle_count);

    /* Rays one by one, as a renderer casts them on its own threads. */
    RlvIsosurfaceTable table = RLV_ISOSURFACE_TABLE_INIT;
    check(rlv_isosurface_table(surface, &table));
    for (int k = 0; k < 6; ++k) {
        RlvIsosurfaceHit hit;
        const RlvIsosurfaceRay ray = {{0.1f + 0.2f * (float)k, 0.12f, 2.0f}, {0, 0, -1}, 0, 0, 0};
        if (table.intersect(table.data, &ray, &hit)) {
            printf("at %.1f m the water is %.2f m high\n", ray.origin[0], hit.position[2]);
        }
    }
    free(points);
    check(rlv_mesh_release(mesh));
    check(rlv_isosurface_release(surface));
    check(rlv_fluid_release(fluid));
    check(rlv_context_release(context));
    return 0;
}
