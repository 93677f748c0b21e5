/* Surfaces of particles: meshes, in the background too, rays one by one, many at once and from several threads, classes of
 * particles, and what is refused. */
#include "sheet.h"

#include <pthread.h>

/* A block of SIDE³ particles 0.02 apart, from (0.01, 0.01, 0.01) on. */
enum { SIDE = 12, COUNT = SIDE * SIDE * SIDE };

static float points[COUNT][4], velocities[COUNT][3];

static void fill(void) {
    for (int k = 0; k < COUNT; ++k) {
        points[k][0] = 0.02f * (float)(k % SIDE) + 0.01f;
        points[k][1] = 0.02f * (float)(k / SIDE % SIDE) + 0.01f;
        points[k][2] = 0.02f * (float)(k / SIDE / SIDE) + 0.01f;
        points[k][3] = NAN;
        velocities[k][0] = 2.0f;
    }
}

/* Particles alone are spheres of their radius. */
static void check_sphere(RlvContext context) {
    const float place[3] = {1, 2, 3}, motion[3] = {0, 1, 0};
    RlvIsosurfaceParticles one = RLV_ISOSURFACE_PARTICLES_INIT;
    RlvIsosurfaceOptions options = RLV_ISOSURFACE_OPTIONS_INIT;
    RlvIsosurface sphere = RLV_NULL;
    one.count = 1;
    one.points = place;
    one.velocities = motion;
    options.radius = 0.1f;
    options.shutter_close = 0.5f;
    const uint32_t functions[2] = {RLV_ISOSURFACE_BLOBS, RLV_ISOSURFACE_ZHU_BRIDSON};
    for (int k = 0; k < 2; ++k) {
        options.function = functions[k];
        CHECK_OK(rlv_isosurface_create(context, &one, &options, &sphere));
        RlvIsosurfaceTable table = RLV_ISOSURFACE_TABLE_INIT;
        CHECK_OK(rlv_isosurface_table(sphere, &table));
        CHECK(table.low[1] <= 1.9f && table.high[1] >= 2.6f);
        /* From the left, with a direction of length 2, and at a time when it has moved by 0.25. */
        RlvIsosurfaceRay ray = {{0, 2, 3}, {2, 0, 0}, 0, 0, 0};
        RlvIsosurfaceHit hit;
        CHECK(table.intersect(table.data, &ray, &hit) == 1 && hit.enters == 1);
        CHECK_NEAR(hit.distance, 0.45, 1e-4);
        CHECK_NEAR(hit.position[0], 0.9, 1e-4);
        CHECK_NEAR(hit.normal[0], -1, 1e-4);
        CHECK_NEAR(hit.velocity[1], 1, 1e-6);
        ray.time = 0.25f;
        CHECK(table.intersect(table.data, &ray, &hit) == 0 && isinf(hit.distance) && hit.normal[0] == 0.0f);
        ray.origin[1] = 2.25f;
        CHECK(table.intersect(table.data, &ray, &hit) == 1);
        CHECK_NEAR(hit.distance, 0.45, 1e-4);
        /* The far side, from a range that begins inside. */
        ray.min_distance = 0.5f;
        CHECK(table.intersect(table.data, &ray, &hit) == 1 && hit.enters == 0);
        CHECK_NEAR(hit.distance, 0.55, 1e-4);
        ray.max_distance = 0.53f;
        CHECK(table.intersect(table.data, &ray, &hit) == 0);
        /* What is no ray. */
        ray.max_distance = NAN;
        CHECK(table.intersect(table.data, &ray, &hit) == 0);
        ray.max_distance = 0.0f;
        ray.min_distance = NAN;
        CHECK(table.intersect(table.data, &ray, &hit) == 0);
        ray.min_distance = 0.0f;
        CHECK(table.intersect(table.data, &ray, &hit) == 1);
        ray.time = INFINITY;
        CHECK(table.intersect(table.data, &ray, &hit) == 0);
        ray.time = 0.25f;
        ray.direction[0] = 0.0f;
        CHECK(table.intersect(table.data, &ray, &hit) == 0);
        CHECK(table.intersect(NULL, &ray, &hit) == 0 && table.intersect(table.data, NULL, &hit) == 0);
        CHECK(table.intersect(table.data, &ray, NULL) == 0);
        CHECK_OK(rlv_isosurface_release(sphere));
    }
}

enum { RAYS = 200 };

static RlvIsosurfaceRay rays[RAYS];
static RlvIsosurfaceHit hits[RAYS];

/* The same rays for calls of many; those have no distances of their own. */
static RlvRayArrays all_rays(void) {
    RlvRayArrays arrays = RLV_RAY_ARRAYS_INIT;
    arrays.count = RAYS;
    arrays.origins = rays[0].origin;
    arrays.directions = rays[0].direction;
    arrays.times = &rays[0].time;
    arrays.origin_stride = arrays.direction_stride = arrays.time_stride = sizeof rays[0];
    return arrays;
}

/* A renderer of its own that traces all rays one by one. */
static void *trace(void *data) {
    const RlvIsosurfaceTable *table = (const RlvIsosurfaceTable *)data;
    for (int k = 0; k < RAYS; ++k) {
        RlvIsosurfaceHit hit;
        table->intersect(table->data, &rays[k], &hit);
        CHECK(memcmp(&hit, &hits[k], sizeof hit) == 0);
    }
    return NULL;
}

/* The block from surface and blind particles has the hits of all. */
static void check_blind(RlvContext context, RlvIsosurface all, const RlvIsosurfaceOptions *options) {
    static uint8_t classes[COUNT], blind[COUNT];
    static float kept[COUNT][3];
    static RlvIsosurfaceHit expected[RAYS];
    RlvIsosurfaceClasses found = RLV_ISOSURFACE_CLASSES_INIT;
    CHECK_OK(rlv_isosurface_classify(all, -1.0f, classes, COUNT, 0, NULL, NULL, &found));
    CHECK(found.surface_count > 0 && found.blind_count > 0 && found.hidden_count > 0);
    CHECK(found.surface_count + found.blind_count + found.hidden_count == COUNT);
    size_t count = 0, counts[3] = {0, 0, 0};
    for (int k = 0; k < COUNT; ++k) {
        CHECK(classes[k] <= RLV_ISOSURFACE_HIDDEN);
        ++counts[classes[k]];
        if (classes[k] != RLV_ISOSURFACE_HIDDEN) {
            memcpy(kept[count], points[k], sizeof kept[0]);
            blind[count++] = classes[k];
        }
    }
    CHECK(counts[0] == found.surface_count && counts[1] == found.blind_count);
    CHECK_NEAR(found.kept, (double)count / COUNT, 1e-9);
    RlvIsosurfaceParticles particles = RLV_ISOSURFACE_PARTICLES_INIT;
    RlvIsosurface layer = RLV_NULL;
    particles.count = count;
    particles.points = kept[0];
    particles.blind = blind;
    CHECK_OK(rlv_isosurface_create(context, &particles, options, &layer));
    /* From the middle outwards, where nothing is left. */
    for (int k = 0; k < RAYS; ++k) {
        const float z = 1.9f * (float)k / RAYS - 0.95f, angle = 2.4f * (float)k;
        const RlvIsosurfaceRay ray = {{0.16f, 0.16f, 0.16f}, {cosf(angle), sinf(angle), z}, 0, 0, 0};
        rays[k] = ray;
    }
    const RlvRayArrays arrays = all_rays();
    CHECK_OK(rlv_isosurface_cast(all, &arrays, expected, 0));
    CHECK_OK(rlv_isosurface_cast(layer, &arrays, hits, 0));
    for (int k = 0; k < RAYS; ++k) {
        CHECK_NEAR(hits[k].distance, expected[k].distance, 1e-4);
        CHECK(hits[k].enters == 0 && expected[k].enters == 0);
    }
    RlvIsosurfaceTable table = RLV_ISOSURFACE_TABLE_INIT;
    pthread_t threads[4];
    CHECK_OK(rlv_isosurface_table(layer, &table));
    for (int k = 0; k < 4; ++k) {
        CHECK(pthread_create(&threads[k], NULL, trace, &table) == 0);
    }
    for (int k = 0; k < 4; ++k) {
        CHECK(pthread_join(threads[k], NULL) == 0);
    }
    particles.blind_stride = 0;
    blind[3] = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_create(context, &particles, options, &layer), "element 3");
    CHECK_OK(rlv_isosurface_release(layer));
}

/* The volume of a closed mesh. */
static double volume(RlvMesh mesh) {
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(mesh, &info));
    float *places = (float *)malloc(info.point_count * 3 * sizeof(float));
    uint32_t *corners = (uint32_t *)malloc(info.triangle_count * 3 * sizeof(uint32_t));
    CHECK(places != NULL && corners != NULL);
    CHECK_OK(rlv_mesh_get_points(mesh, places, info.point_count, 0));
    CHECK_OK(rlv_mesh_get_triangles(mesh, corners, info.triangle_count, 0));
    double sum = 0;
    for (size_t k = 0; k < info.triangle_count; ++k) {
        const float *a = places + 3 * corners[3 * k], *b = places + 3 * corners[3 * k + 1], *c = places + 3 * corners[3 * k + 2];
        sum += a[0] * ((double)b[1] * c[2] - (double)b[2] * c[1]) + a[1] * ((double)b[2] * c[0] - (double)b[0] * c[2]) +
               a[2] * ((double)b[0] * c[1] - (double)b[1] * c[0]);
    }
    free(places);
    free(corners);
    return sum / 6;
}

static void check_mesh(RlvIsosurface surface) {
    static float colors[COUNT][2];
    RlvMesh mesh = RLV_NULL, again = RLV_NULL, untouched = {77};
    RlvMeshInfo info = RLV_MESH_INFO_INIT, other = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_isosurface_mesh(surface, NULL, NULL, NULL, &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &info));
    /* Closed and one piece without handles: V - E + F = 2. */
    CHECK(2 * info.point_count == info.triangle_count + 4 && info.attribute_count == 2);
    CHECK_NEAR(volume(mesh), pow(0.02 * SIDE, 3), 0.2 * pow(0.02 * SIDE, 3));
    uint32_t velocity = 77;
    float *values = (float *)malloc(info.point_count * 3 * sizeof(float));
    CHECK(values != NULL);
    CHECK_OK(rlv_mesh_find_attribute(mesh, "velocity", &velocity));
    CHECK_OK(rlv_mesh_get_attribute(mesh, velocity, values, info.point_count * 3, NULL, 0));
    for (size_t k = 0; k < info.point_count; ++k) {
        CHECK_NEAR(values[3 * k], 2, 1e-5);
    }
    free(values);

    /* With a channel of the host, smoothed, in the background. */
    for (int k = 0; k < COUNT; ++k) {
        colors[k][0] = 0.5f;
        colors[k][1] = points[k][2];
    }
    RlvAttributeArrays channel = RLV_ATTRIBUTE_ARRAYS_INIT;
    RlvIsosurfaceMeshOptions options = RLV_ISOSURFACE_MESH_OPTIONS_INIT;
    channel.name = "color";
    channel.width = 2;
    channel.values = colors;
    channel.value_count = COUNT;
    options.iterations = 4;
    options.channels = &channel;
    options.channel_count = 1;
    RlvJob job = RLV_NULL;
    CHECK_OK(rlv_job_isosurface(surface, &options, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_mesh(job, &again));
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_mesh_info(again, &other));
    CHECK(other.triangle_count == info.triangle_count && other.attribute_count == 3);
    CHECK_OK(rlv_mesh_find_attribute(again, "color", &velocity));
    CHECK_OK(rlv_mesh_release(again));
    CHECK_OK(rlv_mesh_release(mesh));

    /* Refused, and nothing written. */
    int patience = 0;
    channel.value_count = COUNT - 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_mesh(surface, &options, NULL, NULL, &untouched), "channel `color`");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_mesh(surface, &options, NULL, NULL, NULL), "out");
    channel.value_count = COUNT;
    channel.name = "velocity";
    channel.width = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_mesh(surface, &options, NULL, NULL, &untouched), "velocity");
    channel.name = "mass";
    channel.domain = RLV_DOMAIN_FACE;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_mesh(surface, &options, NULL, NULL, &untouched), "RLV_DOMAIN_POINT");
    options.channels = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_mesh(surface, &options, NULL, NULL, &untouched), "channels");
    options.channel_count = 0;
    options.cell = 1.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_mesh(surface, &options, NULL, NULL, &untouched), "cell size");
    options.cell = 0.0f;
    options.forwards = 2.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_mesh(surface, &options, NULL, NULL, &untouched), "0 to 1");
    CHECK(rlv_isosurface_mesh(surface, NULL, check_patience, &patience, &untouched) == RLV_ERROR_CANCELLED);
    CHECK(untouched.id == 77);
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvIsosurface surface = RLV_NULL, none = RLV_NULL, untouched = {77};
    RlvIsosurfaceParticles particles = RLV_ISOSURFACE_PARTICLES_INIT;
    RlvIsosurfaceOptions options = RLV_ISOSURFACE_OPTIONS_INIT;
    RlvIsosurfaceInfo info = RLV_ISOSURFACE_INFO_INIT;
    uint8_t classes[4];
    CHECK_OK(rlv_context_create(NULL, &context));
    fill();
    check_sphere(context);
    particles.count = COUNT;
    particles.points = points[0];
    particles.point_stride = sizeof points[0];
    particles.velocities = velocities[0];
    for (uint32_t function = 0; function < 4; ++function) {
        options.function = function;
        CHECK_OK(rlv_isosurface_create(context, &particles, &options, &surface));
        CHECK_OK(rlv_isosurface_info(surface, &info));
        CHECK(info.particle_count == COUNT && info.has_velocities == 1 && info.reach >= info.support);
        CHECK_NEAR(info.support, 0.04, 1e-7);
        check_mesh(surface);
        if (function != RLV_ISOSURFACE_ANISOTROPIC) {
            check_blind(context, surface, &options);
        }
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_classify(surface, -1.0f, classes, 4, 0, NULL, NULL, NULL), "classes");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_classify(surface, NAN, NULL, 0, 0, NULL, NULL, NULL), "threshold");
        CHECK_OK(rlv_isosurface_classify(surface, 0.0f, NULL, 0, 0, NULL, NULL, NULL));
        RlvRayArrays arrays = all_rays();
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_cast(surface, NULL, hits, 0), "RlvRayArrays");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_cast(surface, &arrays, NULL, 0), "hits");
        arrays.time_stride = 3;
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_cast(surface, &arrays, hits, 0), "times");
        arrays = (RlvRayArrays)RLV_RAY_ARRAYS_INIT;
        CHECK_OK(rlv_isosurface_cast(surface, &arrays, NULL, 0));
        CHECK_OK(rlv_isosurface_release(surface));
    }

    /* No particles: no hits, no faces. */
    RlvMesh empty = RLV_NULL;
    RlvMeshInfo faces = RLV_MESH_INFO_INIT;
    particles.count = 0;
    CHECK_OK(rlv_isosurface_create(context, &particles, NULL, &none));
    const RlvRayArrays arrays = all_rays();
    CHECK_OK(rlv_isosurface_cast(none, &arrays, hits, 0));
    CHECK(isinf(hits[0].distance) && isinf(hits[1].distance));
    CHECK_OK(rlv_isosurface_mesh(none, NULL, NULL, NULL, &empty));
    CHECK_OK(rlv_mesh_info(empty, &faces));
    CHECK(faces.face_count == 0 && faces.point_count == 0);
    CHECK_OK(rlv_mesh_release(empty));
    CHECK_OK(rlv_isosurface_release(none));

    /* Refused. */
    particles.count = COUNT;
    points[5][1] = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_create(context, &particles, NULL, &untouched), "element 5");
    points[5][1] = 0.0f;
    velocities[7][2] = INFINITY;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_create(context, &particles, NULL, &untouched), "velocities, element 7");
    velocities[7][2] = 0.0f;
    options.function = 4;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_create(context, &particles, &options, &untouched), "function");
    options.function = 0;
    options.radius = 0.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_create(context, &particles, &options, &untouched), "radius");
    options.radius = 0.01f;
    options.shutter_open = 1.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_create(context, &particles, &options, &untouched), "shutter");
    options.shutter_open = 0.0f;
    options.march_steps = 0.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_create(context, &particles, &options, &untouched), "steps");
    options.march_steps = 12.0f;
    options.sharpness = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_create(context, &particles, &options, &untouched), "sharpness");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_create(context, NULL, NULL, &untouched), "RlvIsosurfaceParticles");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_create(context, &particles, NULL, NULL), "out");
    particles.points = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_create(context, &particles, NULL, &untouched), "points");
    particles.points = points[0];
    RlvContextOptions small = RLV_CONTEXT_OPTIONS_INIT;
    RlvContext poor = RLV_NULL;
    small.memory_limit = 1 << 16;
    CHECK_OK(rlv_context_create(&small, &poor));
    CHECK(rlv_isosurface_create(poor, &particles, NULL, &untouched) == RLV_ERROR_MEMORY && untouched.id == 77);
    CHECK_OK(rlv_context_release(poor));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_isosurface_info(none, &info), "not alive");
    CHECK_OK(rlv_context_release(context));
    return 0;
}
