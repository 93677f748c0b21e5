/* Contexts on the host's own Vulkan device: the host copies our buffers by its command buffers, and finds the processor's
 * points; we write to its buffers; semaphores order both; its lock guards the queue; nothing of it is destroyed. With
 * the argument "none", where no driver can be found: what is said of objects that are none. */
#define _POSIX_C_SOURCE 200809L
#include "ball.h"
#include "device.h"
#include "gpu.h"

enum { CELLS = 16, SUBMITS = 200 };

typedef struct Scene {
    RlvContext context;
    RlvDetail detail;
    RlvTessellation tessellation;
    RlvTessellationInfo info;
    double voxel;
} Scene;

/* A plane of 4 x 4 that a sphere was pressed into, and its triangles. */
static Scene press(RlvContext context) {
    const double at[12] = CHECK_MOVED(2.0, 2.0, 0.85);
    RlvDetailOptions detail = RLV_DETAIL_OPTIONS_INIT;
    RlvTessellateOptions cells = RLV_TESSELLATE_OPTIONS_INIT;
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
    RlvMesh plane = check_plane(context, 4, 4), ball = check_ball(context, 1.0);
    RlvSurface surface = RLV_NULL;
    RlvCollider collider = RLV_NULL;
    Scene scene = {.context = context, .info = RLV_TESSELLATION_INFO_INIT};
    detail.tile_size = 16;
    cells.coarse = cells.fine = CELLS;
    settings.voxels = 1 << 18;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, &detail, NULL, &scene.detail));
    CHECK_OK(rlv_collider_create_mesh(context, ball, at, &collider));
    CHECK_OK(rlv_imprint_run(scene.detail, collider, &settings, NULL, &report));
    CHECK(report.changed_coefficients > 100);
    scene.voxel = report.voxel_diagonal;
    CHECK_OK(rlv_detail_commit(scene.detail, NULL));
    CHECK_OK(rlv_tessellation_create(scene.detail, &cells, &scene.tessellation));
    CHECK_OK(rlv_tessellation_info(scene.tessellation, &scene.info));
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_mesh_release(plane));
    return scene;
}

/* Positions and normals of the scene's points, 6 floats each. */
static float *points_of(const Scene *scene) {
    float *points = malloc(24 * scene->info.point_count);
    CHECK(points != NULL);
    CHECK_OK(rlv_tessellation_get_points(scene->tessellation, 0, scene->info.point_count, points, 24, points + 3, 24));
    return points;
}

static void end(Scene *scene) {
    CHECK_OK(rlv_tessellation_release(scene->tessellation));
    CHECK_OK(rlv_detail_release(scene->detail));
    CHECK_OK(rlv_context_release(scene->context));
}

/* Heights differ from the processor's by units in the last place of a half, 2^-13 at a depth of 0.15, and by a voxel where a
 * ray grazes one, which few do. */
static void compare_with_processor(const Scene *scene, const float *points) {
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvContext context = RLV_NULL;
    options.threads = 1;
    CHECK_OK(rlv_context_create(&options, &context));
    Scene reference = press(context);
    CHECK(reference.info.point_count == scene->info.point_count);
    float *expected = points_of(&reference), deepest = 0.0f;
    size_t apart = 0;
    for (size_t point = 0; point < scene->info.point_count; ++point) {
        for (size_t axis = 0; axis < 3; ++axis) {
            double error = fabs((double)points[6 * point + axis] - (double)expected[6 * point + axis]);
            CHECK(error <= reference.voxel);
            apart += error > 4.0 / 8192.0;
        }
        deepest = fminf(deepest, points[6 * point + 2]);
    }
    CHECK(apart * 100 < scene->info.point_count);
    CHECK(deepest < -0.13f && deepest > -0.17f);
    free(expected);
    end(&reference);
}

/* Our buffer, copied by the host behind our semaphore, is what the tessellation has, to the bit. */
static void copy_ours(HostDevice *host, const Scene *scene) {
    VkSemaphore timeline = host_semaphore(host, VK_SEMAPHORE_TYPE_TIMELINE);
    HostBuffer staging = host_buffer(host, 24 * scene->info.point_count);
    RlvBufferVulkan objects = RLV_BUFFER_VULKAN_INIT;
    RlvBuffer buffer = RLV_NULL;
    CHECK_OK(rlv_buffer_create(scene->tessellation, &buffer));
    CHECK_OK(rlv_buffer_vulkan(buffer, &objects));
    CHECK(objects.instance == host_handle(host->instance) && objects.device == host_handle(host->device));
    CHECK(objects.queue == host_handle(host->queue) && objects.physical_device == host_handle(host->physical));
    CHECK(objects.queue_family == host->family && objects.queue_index == 0);
    CHECK_OK(rlv_vulkan_signal(scene->context, (uint64_t)timeline, 3));
    host_copy(host, (VkBuffer)objects.points, &staging, staging.bytes, timeline, 3, VK_NULL_HANDLE);
    float *expected = points_of(scene);
    CHECK(memcmp(staging.seen, expected, staging.bytes) == 0);
    compare_with_processor(scene, staging.seen);
    free(expected);
    CHECK_OK(rlv_buffer_release(buffer));
    host_free(host, &staging);
    host_end_semaphore(host, timeline);
}

/* Submits again and again under the lock, while the library does. */
static void *submit(void *user) {
    HostDevice *host = user;
    for (int k = 0; k < SUBMITS; ++k) {
        pthread_mutex_lock(&host->mutex);
        CHECK(host->held == 0);
        CHECK_VK(vkQueueSubmit(host->queue, 0, NULL, VK_NULL_HANDLE));
        pthread_mutex_unlock(&host->mutex);
    }
    return NULL;
}

/* The host's buffers take the points, follow the tessellation, and are refused where they are too small. */
static void write_theirs(HostDevice *host, const Scene *scene) {
    VkSemaphore ours = host_semaphore(host, VK_SEMAPHORE_TYPE_BINARY), theirs = host_semaphore(host, VK_SEMAPHORE_TYPE_BINARY);
    const size_t point_bytes = 24 * scene->info.point_count, triangle_bytes = 12 * scene->info.triangle_count;
    HostBuffer points = host_buffer(host, point_bytes + 1000), triangles = host_buffer(host, triangle_bytes);
    HostBuffer staging = host_buffer(host, point_bytes);
    RlvVulkanBuffers given = RLV_VULKAN_BUFFERS_INIT;
    RlvBufferInfo info = RLV_BUFFER_INFO_INIT;
    RlvBufferVulkan objects = RLV_BUFFER_VULKAN_INIT;
    RlvContextInfo before = RLV_CONTEXT_INFO_INIT, after = RLV_CONTEXT_INFO_INIT;
    RlvBuffer buffer = {77};
    given.points = (uint64_t)points.buffer;
    given.triangles = (uint64_t)triangles.buffer;
    given.point_bytes = point_bytes - 1;
    given.triangle_bytes = triangle_bytes;
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_vulkan_create_buffer(scene->tessellation, &given, &buffer), "point_bytes");
    given.point_bytes = points.bytes;
    given.triangle_bytes = triangle_bytes - 12;
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_vulkan_create_buffer(scene->tessellation, &given, &buffer), "triangle_bytes");
    given.triangle_bytes = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_create_buffer(scene->tessellation, &given, &buffer), "given with 3 bytes");
    given.triangle_bytes = triangle_bytes;
    given.points = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_create_buffer(scene->tessellation, &given, &buffer), "points: the VkBuffer is NULL");
    CHECK(buffer.id == 77);
    given.points = (uint64_t)points.buffer;
    CHECK_OK(rlv_context_info(scene->context, &before));
    CHECK_OK(rlv_vulkan_create_buffer(scene->tessellation, &given, &buffer));
    CHECK_OK(rlv_context_info(scene->context, &after));
    CHECK(after.device_memory == before.device_memory);
    CHECK_OK(rlv_buffer_info(buffer, &info));
    CHECK(info.point_count == scene->info.point_count && info.triangle_count == scene->info.triangle_count);
    CHECK_OK(rlv_buffer_vulkan(buffer, &objects));
    CHECK(objects.points == given.points && objects.triangles == given.triangles);
    float *expected = points_of(scene), *read = malloc(point_bytes);
    CHECK(read != NULL);
    CHECK(memcmp(points.seen, expected, point_bytes) == 0);
    CHECK_OK(rlv_buffer_read(buffer, 0, info.point_count, read, 0));
    CHECK(memcmp(read, expected, point_bytes) == 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_buffer_read(buffer, 0, info.point_count + 1, read, 0), "points");
    const uint32_t *corners = triangles.seen;
    for (size_t corner = 0; corner < 3 * info.triangle_count; ++corner) {
        CHECK(corners[corner] < info.point_count);
    }
    free(expected);

    /* An update writes what changed, while the host submits under its lock; binary semaphores lead there and back. */
    pthread_t thread;
    int locked = host->locked;
    check_stroke(scene->context, scene->detail, RLV_BRUSH_SCULPT, 1.4, 1.4, 0.3f);
    CHECK_OK(rlv_detail_commit(scene->detail, NULL));
    CHECK_OK(rlv_tessellation_update(scene->tessellation, NULL));
    CHECK(pthread_create(&thread, NULL, submit, host) == 0);
    CHECK_OK(rlv_buffer_update(buffer, &info));
    CHECK(info.rebuilt == 0 && info.written_count > 0 && info.written_count < info.point_count);
    CHECK_OK(rlv_vulkan_signal(scene->context, (uint64_t)ours, 0));
    CHECK(pthread_join(thread, NULL) == 0);
    CHECK(host->locked > locked && host->held == 0);
    host_copy(host, points.buffer, &staging, point_bytes, ours, 0, theirs);
    CHECK_OK(rlv_vulkan_wait(scene->context, (uint64_t)theirs, 0));
    expected = points_of(scene);
    CHECK(memcmp(staging.seen, expected, point_bytes) == 0);
    CHECK_OK(rlv_buffer_read(buffer, 0, info.point_count, read, 0));
    CHECK(memcmp(read, expected, point_bytes) == 0);
    free(expected);
    free(read);
    CHECK_OK(rlv_buffer_release(buffer));
    host_free(host, &points);
    host_free(host, &triangles);
    host_free(host, &staging);
    host_end_semaphore(host, ours);
    host_end_semaphore(host, theirs);
}

/* Timeline semaphores: our work comes behind the host's signal, and another one says when it is done. */
static void wait_for_host(HostDevice *host, const Scene *scene) {
    VkSemaphore gate = host_semaphore(host, VK_SEMAPHORE_TYPE_TIMELINE), done = host_semaphore(host, VK_SEMAPHORE_TYPE_TIMELINE);
    const VkSemaphoreSignalInfo signal = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO, .semaphore = gate, .value = 5};
    const uint64_t value = 9;
    const VkSemaphoreWaitInfo wait = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
                                      .semaphoreCount = 1,
                                      .pSemaphores = &done,
                                      .pValues = &value};
    uint64_t reached = 0;
    int locked = host->locked;
    CHECK_VK(vkSignalSemaphore(host->device, &signal));
    CHECK_OK(rlv_vulkan_wait(scene->context, (uint64_t)gate, 5));
    CHECK_OK(rlv_vulkan_signal(scene->context, (uint64_t)done, value));
    CHECK(host->locked == locked + 2);
    CHECK_VK(vkWaitSemaphores(host->device, &wait, UINT64_MAX));
    CHECK_VK(vkGetSemaphoreCounterValue(host->device, done, &reached));
    CHECK(reached == value);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_wait(scene->context, 0, 1), "semaphore");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_signal(scene->context, 0, 1), "semaphore");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_signal((RlvContext){0}, (uint64_t)done, 1), "NULL");
    host_end_semaphore(host, gate);
    host_end_semaphore(host, done);
}

/* Whatever is missing or wrong is said, and the host hears of no release. */
static void refuse(HostDevice *host) {
    RlvContext context = {77};
    RlvVulkanDevice given = host_described(host);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_create_context(NULL, NULL, &context), "RlvVulkanDevice");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_create_context(&given, NULL, NULL), "out");
    given.api_version = VK_API_VERSION_1_0;
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_vulkan_create_context(&given, NULL, &context), "1.1");
    given = host_described(host);
    given.device = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_create_context(&given, NULL, &context), "device");
    given = host_described(host);
    given.loader = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_create_context(&given, NULL, &context), "vkGetInstanceProcAddr");
    given = host_described(host);
    given.unlock = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_create_context(&given, NULL, &context), "lock");
    given = host_described(host);
    given.queue_family = 99;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_create_context(&given, NULL, &context), "queue_family");
    given = host_described(host);
    given.queue_index = 99;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_create_context(&given, NULL, &context), "queue_index");
    given = host_described(host);
    given.physical_device += 8;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_create_context(&given, NULL, &context), "physical_device");
    CHECK(context.id == 77 && host->released == 0);
}

/* What can be said without a driver. */
static int without(void) {
    RlvVulkanDevice given = RLV_VULKAN_DEVICE_INIT;
    RlvVulkanBuffers buffers = RLV_VULKAN_BUFFERS_INIT;
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvContext context = {77};
    RlvBuffer buffer = {77};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_create_context(&given, NULL, &context), "instance");
    CHECK(context.id == 77);
    options.threads = 1;
    CHECK_OK(rlv_context_create(&options, &context));
    Scene scene = press(context);
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_vulkan_create_buffer(scene.tessellation, &buffers, &buffer), "no graphics device");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_vulkan_wait(context, 8, 1), "no graphics device");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_vulkan_signal(context, 8, 1), "no graphics device");
    CHECK(buffer.id == 77);
    end(&scene);
    return 0;
}

int main(int argc, char **argv) {
    HostDevice host;
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvContextInfo info = RLV_CONTEXT_INFO_INIT;
    RlvContext context = RLV_NULL, second = RLV_NULL;
    if (argc > 1 && strcmp(argv[1], "none") == 0) {
        return without();
    }
    if (!host_open(&host)) {
        check_skipped();
    }
    refuse(&host);
    RlvVulkanDevice given = host_described(&host);
    options.threads = 1;
    CHECK_OK(rlv_vulkan_create_context(&given, &options, &context));
    CHECK_OK(rlv_context_info(context, &info));
    CHECK(info.device == RLV_DEVICE_GPU && info.threads == 1 && strlen(info.adapter) > 0 && strlen(info.fallback) == 0);

    /* A second context on the queue needs the same lock. */
    given.lock = host_unlock;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_vulkan_create_context(&given, &options, &second), "another lock");
    given = host_described(&host);
    CHECK_OK(rlv_vulkan_create_context(&given, &options, &second));

    Scene scene = press(context);
    copy_ours(&host, &scene);
    write_theirs(&host, &scene);
    wait_for_host(&host, &scene);
    CHECK(host.released == 0);
    end(&scene);
    CHECK(host.released == 1);

    /* Let go: the processor takes over, and the device is as it was. */
    CHECK_OK(rlv_context_close_device(second));
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_vulkan_signal(second, 8, 1), "lost");
    CHECK_OK(rlv_context_info(second, &info));
    CHECK(info.device == RLV_DEVICE_CPU);
    CHECK_OK(rlv_context_release(second));
    CHECK(host.released == 2 && host.held == 0);
    CHECK_VK(vkDeviceWaitIdle(host.device));
    host_close(&host);
    return 0;
}
