/* Grids of OpenVDB: made of meshes and blocks, written and read, changed, combined and meshed; what is hostile is refused. */
#include "check.h"

#define FILE_NAME "c_grid_test.vdb"

static uint32_t count_reports(void *user, float fraction, const char *stage) {
    ++*(int *)user;
    return fraction >= 0.0f && fraction <= 1.0f && stage != NULL ? RLV_PROGRESS_CONTINUE : RLV_PROGRESS_CANCEL;
}

static uint32_t stop(void *user, float fraction, const char *stage) {
    (void)user, (void)fraction, (void)stage;
    return RLV_PROGRESS_CANCEL;
}

static double value_at(RlvGrid grid, double x, double y, double z) {
    const double point[3] = {x, y, z};
    double value = 77.0;
    CHECK_OK(rlv_grid_sample(grid, point, 1, 0, 1, &value, 1));
    return value;
}

/* The volume inside of the surface of a grid. */
static double volume(RlvGrid grid, const RlvGridSettings *settings) {
    RlvMesh mesh = RLV_NULL;
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_grid_mesh(grid, settings, NULL, NULL, &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &info));
    float *points = (float *)malloc(info.point_count * 12);
    uint32_t *triangles = (uint32_t *)malloc(info.triangle_count * 12);
    CHECK(points != NULL && triangles != NULL);
    CHECK_OK(rlv_mesh_get_points(mesh, points, info.point_count, 0));
    CHECK_OK(rlv_mesh_get_triangles(mesh, triangles, info.triangle_count, 0));
    double sum = 0.0;
    for (size_t at = 0; at < info.triangle_count; ++at) {
        const float *a = points + 3 * (size_t)triangles[3 * at], *b = points + 3 * (size_t)triangles[3 * at + 1],
                    *c = points + 3 * (size_t)triangles[3 * at + 2];
        sum += (double)a[0] * ((double)b[1] * c[2] - (double)b[2] * c[1]) +
               (double)a[1] * ((double)b[2] * c[0] - (double)b[0] * c[2]) +
               (double)a[2] * ((double)b[0] * c[1] - (double)b[1] * c[0]);
    }
    free(points), free(triangles);
    CHECK_OK(rlv_mesh_release(mesh));
    return sum / 6.0;
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvContextOptions serial = RLV_CONTEXT_OPTIONS_INIT;
    RlvGrid grid = RLV_NULL, other = RLV_NULL, made = RLV_NULL, untouched = {77};
    RlvGridInfo info = RLV_GRID_INFO_INIT;
    RlvGridSettings settings = RLV_GRID_SETTINGS_INIT;
    const RlvParameter *rows = NULL;
    size_t count = 0;
    serial.threads = 1;
    serial.memory_limit = 1 << 28;
    CHECK_OK(rlv_context_create(&serial, &context));
    CHECK_OK(rlv_grid_params(&rows, &count));
    CHECK(count == 8 && strcmp(rows[0].name, "voxel") == 0 && rows[0].offset == offsetof(RlvGridSettings, voxel));
    CHECK_OK(rlv_grid_available());

    /* A box of 2 by 2 by 1. */
    RlvMesh box = check_box(context, 0.0f, 2.0f, 0.0f, 1.0f), shifted = check_box(context, 1.0f, 3.0f, 0.0f, 1.0f);
    int reports = 0;
    CHECK_OK(rlv_grid_from_mesh(box, &settings, count_reports, &reports, &grid));
    CHECK(reports > 0);
    CHECK_OK(rlv_grid_info(grid, &info));
    CHECK(info.kind == RLV_GRID_FLOAT && info.grid_class == RLV_GRID_LEVEL_SET && info.is_linear && !info.is_empty);
    CHECK(info.active_voxels > 1000 && info.low[0] < 0 && info.high[0] >= 20);
    CHECK_NEAR(info.matrix[0], 0.1, 1e-6);
    CHECK_NEAR(value_at(grid, 1.0, 1.0, 1.1), 0.1, 1e-5);
    CHECK_NEAR(volume(grid, NULL), 4.0, 0.05);

    /* Set operations, an offset, smoothing, other voxels, fog and back. */
    CHECK_OK(rlv_grid_from_mesh(shifted, &settings, NULL, NULL, &other));
    const double expected[3] = {7.0, 1.0, 3.0};
    for (uint32_t operation = 0; operation < 3; ++operation) {
        CHECK_OK(rlv_grid_combine(grid, other, operation, NULL, NULL, &made));
        CHECK_NEAR(volume(made, NULL), expected[operation], 0.15);
        check_idle(made.id, "grid");
        CHECK_OK(rlv_grid_release(made));
    }
    settings.distance = -0.2f;
    CHECK_OK(rlv_grid_change(grid, RLV_GRID_OFFSET, &settings, NULL, NULL, &made));
    CHECK_NEAR(volume(made, NULL), 1.6 * 1.6 * 0.6, 0.15);
    CHECK_OK(rlv_grid_release(made));
    CHECK_OK(rlv_grid_change(grid, RLV_GRID_MEAN, NULL, NULL, NULL, &made));
    CHECK(volume(made, NULL) < 4.0 && volume(made, NULL) > 3.0);
    CHECK_OK(rlv_grid_release(made));
    settings.voxel = 0.08f;
    CHECK_OK(rlv_grid_change(grid, RLV_GRID_RESAMPLE, &settings, NULL, NULL, &made));
    CHECK_OK(rlv_grid_info(made, &info));
    CHECK_NEAR(info.voxel_size[2], 0.08, 1e-6);
    CHECK_OK(rlv_grid_release(made));
    CHECK_OK(rlv_grid_change(grid, RLV_GRID_TO_FOG, NULL, NULL, NULL, &made));
    CHECK(value_at(made, 1.0, 1.0, 0.5) == 1.0 && value_at(made, 1.0, 1.0, 2.0) == 0.0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_change(made, RLV_GRID_OFFSET, NULL, NULL, NULL, &untouched), "level set");
    CHECK_OK(rlv_grid_release(made));

    /* In the background: the same mesh as in the foreground. */
    RlvJob job = RLV_NULL;
    RlvMesh meshed = RLV_NULL;
    CHECK_OK(rlv_job_grid_mesh(grid, NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_mesh(job, &meshed));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_grid(job, &untouched), "grid");
    CHECK_OK(rlv_mesh_release(meshed));
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_job_grid_change(grid, RLV_GRID_MEAN_CURVATURE, NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_grid(job, &made));
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_grid_release(made));

    /* Files: two grids with metadata, one of them read by its name, and a part of one. */
    char text[16];
    CHECK_OK(rlv_grid_set_name(grid, "first"));
    CHECK_OK(rlv_grid_set_name(other, "second"));
    CHECK_OK(rlv_grid_set_metadata(grid, "frame", "int32", "12"));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_set_metadata(grid, "frame", "int32", "many"), "int32");
    const RlvGrid both[2] = {grid, other};
    CHECK_OK(rlv_grid_write(both, 2, FILE_NAME, RLV_GRID_PACK_ZIP));
    CHECK_OK(rlv_grid_file_count(context, FILE_NAME, &count));
    CHECK(count == 2);
    CHECK_OK(rlv_grid_file_info(context, FILE_NAME, 1, &info));
    CHECK(strcmp(info.name, "second") == 0 && info.kind == RLV_GRID_FLOAT && info.memory_bytes > 10000);
    CHECK_OK(rlv_grid_read(context, FILE_NAME, "first", NULL, NULL, NULL, &made));
    CHECK_OK(rlv_grid_metadata(made, "frame", text, sizeof text));
    CHECK(strcmp(text, "12") == 0);
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_grid_metadata(made, "shot", text, sizeof text), "shot");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_grid_file_metadata(context, FILE_NAME, "shot", text, sizeof text), "shot");
    CHECK_OK(rlv_grid_metadata_count(made, &count));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_metadata_entry(made, count, text, sizeof text, text, sizeof text), "index");
    int has_frame = 0;
    for (size_t index = 0; index < count; index++) {
        char kind[16];
        CHECK_OK(rlv_grid_metadata_entry(made, index, text, sizeof text, kind, sizeof kind));
        has_frame += strcmp(text, "frame") == 0 && strcmp(kind, "int32") == 0;
    }
    CHECK(has_frame == 1);
    CHECK_OK(rlv_grid_metadata_entry(made, 0, text, 2, text + 8, 2));
    CHECK(strlen(text) == 1 && strlen(text + 8) == 1);
    const double frustum[6] = {0, 0, 0, 10, 10, 10};
    const double still[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_set_frustum(made, frustum, 0.0, 2.0, still), "frustum");
    CHECK_OK(rlv_grid_set_frustum(made, frustum, 0.5, 2.0, still));
    CHECK_OK(rlv_grid_info(made, &info));
    CHECK(info.is_linear == 0);
    CHECK_OK(rlv_grid_release(made));
    CHECK_OK(rlv_grid_read(context, FILE_NAME, "first", NULL, NULL, NULL, &made));
    CHECK(value_at(made, 0.03, 1.0, 0.5) == value_at(grid, 0.03, 1.0, 0.5));
    CHECK_OK(rlv_grid_release(made));
    const double corner[6] = {-0.3, -0.3, -0.3, 0.1, 0.1, 0.1};
    CHECK_OK(rlv_grid_read(context, FILE_NAME, NULL, corner, NULL, NULL, &made));
    CHECK_OK(rlv_grid_info(made, &info));
    CHECK(info.active_voxels > 10 && info.high[0] <= 1);
    CHECK_OK(rlv_grid_release(made));
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_grid_read(context, FILE_NAME, "third", NULL, NULL, NULL, &untouched), "second");
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_grid_read(context, FILE_NAME, NULL, NULL, stop, NULL, &untouched), "cancel");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_file_info(context, FILE_NAME, 2, &info), "2");

    /* Labels. */
    const int32_t labels[2] = {3, 8};
    RlvGrid labelled = RLV_NULL;
    CHECK_OK(rlv_grid_labels(both, labels, 2, &labelled));
    CHECK(value_at(labelled, 0.5, 0.5, 0.5) == 3.0 && value_at(labelled, 2.5, 2.5, 0.5) == 8.0);
    CHECK_OK(rlv_grid_label_mask(labelled, 8, &made));
    CHECK_OK(rlv_grid_info(made, &info));
    CHECK(info.kind == RLV_GRID_MASK && info.active_voxels > 3000);
    CHECK_OK(rlv_grid_release(made));
    CHECK_OK(rlv_grid_release(labelled));

    /* Blocks of values. */
    const double zero[3] = {0.0, 0.0, 0.0};
    const int32_t low[3] = {-2, 0, 5};
    const uint32_t size[3] = {3, 4, 5};
    double block[60], back[60];
    for (int at = 0; at < 60; ++at) {
        block[at] = at % 4 == 0 ? 0.0 : 0.5 * at;
    }
    RlvGrid doubles = RLV_NULL;
    CHECK_OK(rlv_grid_create(context, RLV_GRID_DOUBLE, zero, 0.5, &doubles));
    CHECK_OK(rlv_grid_set_block(doubles, low, size, block, sizeof block, 0.0));
    CHECK_OK(rlv_grid_get_block(doubles, low, size, back, sizeof back));
    CHECK(memcmp(block, back, sizeof block) == 0);
    CHECK_OK(rlv_grid_info(doubles, &info));
    CHECK(info.active_voxels == 45);
    CHECK_OK(rlv_grid_convert(doubles, RLV_GRID_INT32, &made));
    CHECK_OK(rlv_grid_release(made));
    block[7] = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_set_block(doubles, low, size, block, sizeof block, 0.0), "finite");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_get_block(doubles, low, size, back, sizeof back - 8), "480");
    const double frame[12] = {0.5, 0, 0, 0, 0.5, 0, 0, 0, 2.0, 1, 2, 3}, flat[12] = {1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0};
    CHECK_OK(rlv_grid_set_matrix(doubles, frame));
    CHECK(value_at(doubles, 1.0 - 1.0, 2.0, 3.0 + 12.0) == block[1]);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_set_matrix(doubles, flat), "volume");
    CHECK_OK(rlv_grid_set_class(doubles, RLV_GRID_FOG));

    /* Particles. */
    const float places[6] = {0, 0, 0, 1, 0, 0};
    RlvParticlesArrays arrays = RLV_PARTICLES_ARRAYS_INIT;
    RlvParticles particles = RLV_NULL;
    arrays.points = places, arrays.count = 2, arrays.spacing = 0.25f;
    CHECK_OK(rlv_particles_create(context, &arrays, &particles));
    settings.voxel = 0.04f;
    CHECK_OK(rlv_grid_from_particles(particles, &settings, NULL, NULL, &made));
    CHECK_NEAR(volume(made, NULL), 2.0 * 4.18879 * 0.25 * 0.25 * 0.25, 0.005);
    CHECK_OK(rlv_grid_release(made));

    /* What cannot be. */
    const double nowhere[3] = {0.0, NAN, 0.0};
    double value;
    settings.voxel = -1.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_from_mesh(box, &settings, NULL, NULL, &untouched), "voxel");
    settings.voxel = 1e-4f;
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_grid_from_mesh(box, &settings, NULL, NULL, &untouched), "memory");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_sample(grid, nowhere, 1, 0, 1, &value, 1), "finite");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_change(grid, 9, NULL, NULL, NULL, &untouched), "change");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_combine(grid, doubles, 0, NULL, NULL, &untouched), "kind");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_create(context, RLV_GRID_POINTS, zero, 1.0, &untouched), "kind");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_write(both, 2, FILE_NAME, 3), "writing");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_write(both, 0, FILE_NAME, 0), "grid");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_grid_read(context, "no_such.vdb", NULL, NULL, NULL, NULL, &untouched), "no_such");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_grid_info((RlvGrid){0}, &info), "NULL");
    CHECK(untouched.id == 77);
    CHECK(remove(FILE_NAME) == 0);

    CHECK_OK(rlv_particles_release(particles));
    CHECK_OK(rlv_grid_release(doubles));
    CHECK_OK(rlv_grid_release(other));
    CHECK_OK(rlv_grid_release(grid));
    CHECK_OK(rlv_mesh_release(shifted));
    CHECK_OK(rlv_mesh_release(box));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
