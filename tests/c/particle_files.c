/* Files of particles: what a fluid has is the same after it was written and read in every format, and makes the same surface; what
 * a surface needs keeps which particles are blind; hostile files and arrays are refused. */
#include "check.h"

enum { DAM = 512 };
static const double low[3] = {0, 0, 0}, high[3] = {0.16, 0.16, 0.16}, far_end[3] = {0.32, 0.16, 0.32};

static RlvFluid dam(RlvContext context) {
    static float heat[DAM];
    RlvFluid fluid = RLV_NULL;
    RlvAttributeArrays channel = RLV_ATTRIBUTE_ARRAYS_INIT;
    CHECK_OK(rlv_fluid_create(context, NULL, &fluid));
    CHECK_OK(rlv_fluid_set_basin(fluid, low, far_end));
    CHECK_OK(rlv_fluid_add_box(fluid, low, high, NULL));
    for (int k = 0; k < DAM; ++k) {
        heat[k] = 0.25f * (float)k;
    }
    channel.domain = RLV_DOMAIN_POINT;
    channel.type = RLV_TYPE_F32;
    channel.name = "heat";
    channel.width = 1;
    channel.values = heat;
    channel.value_count = DAM;
    CHECK_OK(rlv_fluid_set_channel(fluid, &channel));
    CHECK_OK(rlv_fluid_advance(fluid, 0.03, NULL, NULL, NULL));
    return fluid;
}

static RlvParticlesInfo info_of(RlvParticles particles) {
    RlvParticlesInfo info = RLV_PARTICLES_INFO_INIT;
    CHECK_OK(rlv_particles_info(particles, &info));
    return info;
}

/* The values of a channel of so many numbers. */
static void values_of(RlvParticles particles, const char *name, uint32_t width, float *values, size_t capacity) {
    RlvAttributeInfo info = RLV_ATTRIBUTE_INFO_INIT;
    uint32_t index = 77;
    CHECK_OK(rlv_particles_find_channel(particles, name, &index));
    CHECK_OK(rlv_particles_channel_info(particles, index, &info));
    CHECK(info.width == width && info.value_count == info_of(particles).count && strcmp(info.name, name) == 0);
    CHECK(info.domain == RLV_DOMAIN_POINT && info.type == RLV_TYPE_F32);
    CHECK_OK(rlv_particles_get_channel(particles, index, values, capacity, 0));
}

/* Of the fluid itself and of all formats. */
static void check_formats(RlvContext context) {
    static const char *const paths[5] = {"files.rlvfluid", "files.bgeo", "files.vtk", "files.ply", "files.vdb"};
    static float points[DAM][3], velocities[DAM][3], found[DAM][4], values[DAM][3];
    static uint32_t numbers[DAM];
    RlvFluid fluid = dam(context), other = RLV_NULL;
    RlvParticles particles = RLV_NULL, back = RLV_NULL;
    RlvFluidArrays arrays = RLV_FLUID_ARRAYS_INIT;
    arrays.capacity = DAM;
    arrays.points = points[0];
    arrays.velocities = velocities[0];
    CHECK_OK(rlv_fluid_get(fluid, &arrays));
    CHECK_OK(rlv_fluid_particles(fluid, &particles));
    RlvParticlesInfo info = info_of(particles);
    CHECK(info.count == DAM && info.channel_count == 2 && info.has_numbers == 1 && info.has_time == 1);
    CHECK_NEAR(info.time, 0.03, 1e-6);
    CHECK(info.spacing == 0.02f);
    for (int k = 0; k < 5; ++k) {
        CHECK_OK(rlv_particles_write(particles, paths[k]));
        CHECK_OK(rlv_particles_read(context, paths[k], &back));
        CHECK(info_of(back).count == DAM);
        CHECK_OK(rlv_particles_get_points(back, found[0], DAM, sizeof found[0]));
        /* Points of OpenVDB are places in voxels, and not all files have numbers. */
        const double tolerance = k == 4 ? 1e-6 : 0.0;
        if (info_of(back).has_numbers) {
            CHECK_OK(rlv_particles_get_numbers(back, numbers, DAM, 0));
            values_of(back, "velocity", 3, values[0], DAM);
            for (uint32_t at = 0; at < DAM; ++at) {
                CHECK(numbers[at] == at && memcmp(values[at], velocities[at], sizeof values[at]) == 0);
                for (int axis = 0; axis < 3; ++axis) {
                    CHECK_NEAR(found[at][axis], points[at][axis], tolerance);
                }
            }
            values_of(back, "heat", 1, values[0], DAM);
            CHECK(values[0][1] == 0.25f && values[0][2] == 0.5f);
        }
        if (k == 0) {
            info = info_of(back);
            CHECK(info.has_numbers == 1 && info.has_time == 1 && info.spacing == 0.02f && info.channel_count == 2);
            /* Particles of a file go on as a fluid. */
            CHECK_OK(rlv_fluid_create(context, NULL, &other));
            CHECK_OK(rlv_fluid_set_basin(other, low, far_end));
            CHECK_OK(rlv_fluid_add_particles(other, back));
            arrays.points = found[0];
            arrays.point_stride = sizeof found[0];
            arrays.velocities = values[0];
            CHECK_OK(rlv_fluid_get(other, &arrays));
            for (int at = 0; at < DAM; ++at) {
                CHECK(memcmp(found[at], points[at], sizeof points[at]) == 0);
            }
            CHECK(memcmp(values, velocities, sizeof values) == 0);
            uint32_t index = 77;
            CHECK_OK(rlv_fluid_find_channel(other, "heat", &index));
            CHECK(rlv_fluid_find_channel(other, "velocity", &index) == RLV_ERROR_NOT_FOUND);
            CHECK_OK(rlv_fluid_advance(other, 0.01, NULL, NULL, NULL));
            CHECK_OK(rlv_fluid_release(other));
        }
        CHECK_OK(rlv_particles_release(back));
        remove(paths[k]);
    }
    CHECK_OK(rlv_particles_release(particles));
    CHECK_OK(rlv_fluid_release(fluid));
}

static RlvMesh mesh_of(RlvIsosurface surface) {
    RlvMesh mesh = RLV_NULL;
    CHECK_OK(rlv_isosurface_mesh(surface, NULL, NULL, NULL, &mesh));
    return mesh;
}

/* What a surface needs is written with its flags and read again: rays meet the same. */
static void check_kept(RlvContext context) {
    enum { SIDE = 20, COUNT = SIDE * SIDE * SIDE };
    static float points[COUNT][3], flags[COUNT];
    static uint8_t classes[COUNT];
    RlvParticlesArrays arrays = RLV_PARTICLES_ARRAYS_INIT;
    RlvParticles all = RLV_NULL, kept = RLV_NULL, back = RLV_NULL;
    RlvIsosurface whole = RLV_NULL, part = RLV_NULL;
    RlvIsosurfaceClasses told = RLV_ISOSURFACE_CLASSES_INIT;
    RlvMeshInfo meant = RLV_MESH_INFO_INIT, found = RLV_MESH_INFO_INIT;
    for (int k = 0; k < COUNT; ++k) {
        points[k][0] = 0.02f * (float)(k % SIDE);
        points[k][1] = 0.02f * (float)(k / SIDE % SIDE);
        points[k][2] = 0.02f * (float)(k / SIDE / SIDE);
    }
    arrays.count = COUNT;
    arrays.points = points[0];
    arrays.spacing = 0.02f;
    CHECK_OK(rlv_particles_create(context, &arrays, &all));
    CHECK(info_of(all).has_numbers == 0 && info_of(all).has_time == 0);
    CHECK_OK(rlv_particles_isosurface(all, NULL, &whole));
    CHECK_OK(rlv_isosurface_classify(whole, -1.0f, classes, COUNT, 0, NULL, NULL, &told));
    CHECK(told.hidden_count > COUNT / 10 && told.blind_count > 0);
    CHECK_OK(rlv_particles_keep(all, classes, COUNT, 0, &kept));
    CHECK(info_of(kept).count == COUNT - told.hidden_count);
    CHECK_OK(rlv_particles_write(kept, "kept.bgeo"));
    CHECK_OK(rlv_particles_read(context, "kept.bgeo", &back));
    values_of(back, "blind", 1, flags, COUNT);
    size_t blind = 0;
    for (size_t k = 0; k < info_of(back).count; ++k) {
        CHECK(flags[k] == 0 || flags[k] == 1);
        blind += flags[k] == 1;
    }
    CHECK(blind == told.blind_count);
    CHECK_OK(rlv_particles_release(back));
    CHECK_OK(rlv_particles_write(kept, "kept.rlvfluid"));
    CHECK_OK(rlv_particles_read(context, "kept.rlvfluid", &back));
    CHECK_OK(rlv_particles_isosurface(back, NULL, &part));
    const float origin[3] = {0.19f, 0.19f, 1}, direction[3] = {0.01f, 0.02f, -1};
    RlvRayArrays rays = RLV_RAY_ARRAYS_INIT;
    RlvIsosurfaceHit hits[2];
    rays.count = 1;
    rays.origins = origin;
    rays.directions = direction;
    CHECK_OK(rlv_isosurface_cast(whole, &rays, &hits[0], 0));
    CHECK_OK(rlv_isosurface_cast(part, &rays, &hits[1], 0));
    CHECK(hits[0].enters == 1 && hits[1].enters == 1);
    CHECK_NEAR(hits[0].distance, hits[1].distance, 1e-5);
    RlvMesh mesh = mesh_of(whole);
    CHECK_OK(rlv_mesh_info(mesh, &meant));
    CHECK_OK(rlv_mesh_release(mesh));
    mesh = mesh_of(part);
    CHECK_OK(rlv_mesh_info(mesh, &found));
    for (int axis = 0; axis < 3; ++axis) {
        CHECK_NEAR(meant.low[axis], found.low[axis], 1e-5);
        CHECK_NEAR(meant.high[axis], found.high[axis], 1e-5);
    }
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_keep(all, classes, 3, 0, &kept), "8000 particles");
    classes[9] = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_keep(all, classes, COUNT, 0, &kept), "element 9");
    remove("kept.bgeo");
    remove("kept.rlvfluid");
    CHECK_OK(rlv_isosurface_release(whole));
    CHECK_OK(rlv_isosurface_release(part));
    CHECK_OK(rlv_particles_release(all));
    CHECK_OK(rlv_particles_release(kept));
    CHECK_OK(rlv_particles_release(back));
}

static void write_file(const char *path, const void *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    CHECK(file != NULL);
    CHECK(fwrite(bytes, 1, size, file) == size && fclose(file) == 0);
}

static void check_refused(RlvContext context) {
    float points[2][3] = {{0, 0, 0}, {1, 1, 1}};
    uint32_t numbers[2] = {4, 2}, index = 77;
    RlvParticlesArrays arrays = RLV_PARTICLES_ARRAYS_INIT;
    RlvAttributeArrays twice[2] = {RLV_ATTRIBUTE_ARRAYS_INIT, RLV_ATTRIBUTE_ARRAYS_INIT};
    RlvParticles particles = RLV_NULL, none = RLV_NULL;
    CHECK_OK(rlv_particles_create(context, &arrays, &none));
    CHECK(info_of(none).count == 0);
    arrays.count = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_create(context, &arrays, &particles), "points");
    arrays.points = points[0];
    arrays.has_time = 7;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_create(context, &arrays, &particles), "has_time");
    arrays.has_time = 1;
    arrays.time = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_create(context, &arrays, &particles), "time");
    arrays.time = 0.5;
    arrays.spacing = -1.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_create(context, &arrays, &particles), "apart");
    arrays.spacing = 0.0f;
    for (int k = 0; k < 2; ++k) {
        twice[k].name = "heat";
        twice[k].width = 1;
        twice[k].values = points[0];
        twice[k].value_count = 2;
    }
    arrays.channels = twice;
    arrays.channel_count = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_create(context, &arrays, &particles), "two channels");
    twice[0].value_count = 1;
    arrays.channel_count = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_create(context, &arrays, &particles), "heat");
    twice[0].value_count = 2;
    points[1][1] = INFINITY;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_create(context, &arrays, &particles), "particle 1");
    points[1][1] = 1;
    arrays.numbers = numbers;
    CHECK_OK(rlv_particles_create(context, &arrays, &particles));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_get_points(particles, points[0], 1, 0), "room for 1");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_get_numbers(particles, numbers, 1, 0), "room for 1");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_particles_get_numbers(none, numbers, 1, 0), "no numbers");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_particles_find_channel(particles, "head", &index), "heat");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_get_channel(particles, 1, points[0], 2, 0), "channel 1");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_get_channel(particles, 0, NULL, 2, 0), "NULL");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_particles_write(particles, "files.exe"), ".rlvfluid");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_write(particles, NULL), "path");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_particles_write(particles, "no/such/folder.ply"), "no/such");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_particles_read(context, "no_such.bgeo", &none), "no_such");

    /* Files that are cut off, or say more than they have. */
    static uint8_t bytes[4096];
    static const char *const paths[4] = {"cut.rlvfluid", "cut.bgeo", "cut.vtk", "cut.ply"};
    RlvParticles out = {77};
    for (int k = 0; k < 4; ++k) {
        CHECK_OK(rlv_particles_write(particles, paths[k]));
        FILE *file = fopen(paths[k], "rb");
        CHECK(file != NULL);
        const size_t size = fread(bytes, 1, sizeof bytes, file);
        CHECK(fclose(file) == 0 && size > 20 && size < sizeof bytes);
        for (size_t length = 0; length + 8 < size; length += 5) {
            write_file(paths[k], bytes, length);
            if (rlv_particles_read(context, paths[k], &out) == RLV_OK) {
                /* What comes after the places may be left out of a VTK file. */
                CHECK(k == 2 && info_of(out).count == 2);
                CHECK_OK(rlv_particles_release(out));
                out.id = 77;
            }
            CHECK(out.id == 77);
        }
        remove(paths[k]);
    }
    const char json[] = "[\"fileversion\",\"18.0\",\"pointcount\",1000000000]";
    write_file("newer.bgeo", json, sizeof json);
    CHECK(rlv_particles_read(context, "newer.bgeo", &out) != RLV_OK && out.id == 77);
    remove("newer.bgeo");

    CHECK_OK(rlv_particles_retain(particles));
    CHECK_OK(rlv_particles_release(particles));
    CHECK_OK(rlv_particles_release(particles));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_particles_write(particles, "files.ply"), "not alive");
    CHECK_OK(rlv_particles_release(none));
}

int main(void) {
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    check_formats(context);
    check_kept(context);
    check_refused(context);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
