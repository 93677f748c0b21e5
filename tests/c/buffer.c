/* Buffers on a graphics device: they have the tessellation's points and follow it, their Vulkan objects are real, and where
 * there is no device, or it is lost or too small, that is said. With the argument "none", where no driver can be found:
 * what is said then. */
#include "gpu.h"

typedef void (*GetQueue)(void *device, uint32_t family, uint32_t index, void **queue);

/* The Vulkan loader knows the objects: the queue is the device's, the buffers are as large as they have to be. */
static void check_vulkan(RlvBuffer buffer, RlvBufferInfo info) {
    RlvBufferVulkan vulkan = RLV_BUFFER_VULKAN_INIT;
    RlvResult result = rlv_buffer_vulkan(buffer, &vulkan);
    if (result == RLV_ERROR_UNSUPPORTED) {
        return;
    }
    CHECK(result == RLV_OK);
    void *library = NULL;
    Lookup of_device = check_loader(vulkan.instance, &library);
    GetQueue get_queue = (GetQueue)of_device(check_handle(vulkan.device), "vkGetDeviceQueue");
    GetRequirements get_requirements =
        (GetRequirements)of_device(check_handle(vulkan.device), "vkGetBufferMemoryRequirements");
    CHECK(get_queue != NULL && get_requirements != NULL && vulkan.physical_device != 0);
    void *queue = NULL;
    MemoryRequirements points = {0, 0, 0}, triangles = {0, 0, 0};
    get_queue(check_handle(vulkan.device), vulkan.queue_family, vulkan.queue_index, &queue);
    CHECK(queue == check_handle(vulkan.queue));
    get_requirements(check_handle(vulkan.device), vulkan.points, &points);
    get_requirements(check_handle(vulkan.device), vulkan.triangles, &triangles);
    CHECK(points.size >= 24 * info.point_count && triangles.size >= 12 * info.triangle_count);
    dlclose(library);
}

static RlvDetail make(RlvContext context) {
    RlvMesh plane = check_plane(context, 4, 4);
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    options.tile_size = 16;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    return detail;
}

static RlvTessellation follow(RlvDetail detail, uint32_t coarse) {
    RlvTessellateOptions options = RLV_TESSELLATE_OPTIONS_INIT;
    RlvTessellation tessellation = RLV_NULL;
    options.coarse = coarse;
    options.fine = 16;
    CHECK_OK(rlv_tessellation_create(detail, &options, &tessellation));
    return tessellation;
}

/* The buffer has the points and normals of the tessellation, to the bit. */
static void compare(RlvBuffer buffer, RlvTessellation tessellation) {
    RlvTessellationInfo info = RLV_TESSELLATION_INFO_INIT;
    CHECK_OK(rlv_tessellation_info(tessellation, &info));
    float *expected = malloc(info.point_count * 24), *found = malloc(info.point_count * 24);
    CHECK(expected != NULL && found != NULL);
    CHECK_OK(rlv_tessellation_get_points(tessellation, 0, info.point_count, expected, 24, expected + 3, 24));
    CHECK_OK(rlv_buffer_read(buffer, 0, info.point_count, found, 0));
    CHECK(memcmp(expected, found, info.point_count * 24) == 0);
    CHECK_OK(rlv_buffer_read(buffer, info.point_count - 1, 1, found, 0));
    CHECK(memcmp(expected + 6 * (info.point_count - 1), found, 24) == 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_buffer_read(buffer, info.point_count - 1, 2, found, 0), "not 2 from");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_buffer_read(buffer, 2, SIZE_MAX, found, 0), "points");
    free(expected);
    free(found);
}

static void sculpt(RlvContext context, RlvDetail detail, double x) {
    check_stroke(context, detail, RLV_BRUSH_SCULPT, x, 1.4, 0.3f);
    CHECK_OK(rlv_detail_commit(detail, NULL));
}

int main(int argc, char **argv) {
    RlvContext context = RLV_NULL, serial = RLV_NULL;
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvBuffer buffer = RLV_NULL, untouched = {77};
    RlvBufferInfo info = RLV_BUFFER_INFO_INIT;
    options.threads = 1;
    CHECK_OK(rlv_context_create(&options, &serial));
    RlvDetail detail = make(serial);
    RlvTessellation tessellation = follow(detail, 16);
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_buffer_create(tessellation, &untouched), "no graphics device");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_buffer_create((RlvTessellation){detail.id}, &untouched), "of a detail");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_buffer_create(tessellation, NULL), "out");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_buffer_info((RlvBuffer){0}, &info), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_buffer_update((RlvBuffer){detail.id}, NULL), "of a detail");
    CHECK(untouched.id == 77);
    CHECK_OK(rlv_tessellation_release(tessellation));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_context_release(serial));
    check_on_gpu(argc, argv, &options);
    CHECK_OK(rlv_context_create(&options, &context));

    detail = make(context);
    tessellation = follow(detail, 16);
    CHECK_OK(rlv_buffer_create(tessellation, &buffer));
    CHECK_OK(rlv_buffer_info(buffer, &info));
    CHECK(info.point_count == 65 * 65 && info.triangle_count == 2 * 64 * 64 && info.rebuilt == 1);
    CHECK(info.bytes == 24 * info.point_count + 12 * info.triangle_count);
    compare(buffer, tessellation);
    check_vulkan(buffer, info);

    /* One update: the points that it wrote. Several: all of them. None: nothing. */
    sculpt(context, detail, 1.4);
    CHECK_OK(rlv_tessellation_update(tessellation, NULL));
    CHECK_OK(rlv_buffer_update(buffer, &info));
    CHECK(info.rebuilt == 0 && info.written_count > 0 && info.written_count < info.point_count);
    compare(buffer, tessellation);
    CHECK_OK(rlv_buffer_update(buffer, &info));
    CHECK(info.rebuilt == 0 && info.written_count == 0);
    sculpt(context, detail, 2.4);
    CHECK_OK(rlv_tessellation_update(tessellation, NULL));
    sculpt(context, detail, 3.4);
    CHECK_OK(rlv_tessellation_update(tessellation, NULL));
    CHECK_OK(rlv_buffer_update(buffer, &info));
    CHECK(info.rebuilt == 0 && info.written_count == info.point_count);
    compare(buffer, tessellation);

    /* Other triangles are other buffers. */
    RlvDetail plain = make(context);
    RlvTessellation growing = follow(plain, 2);
    RlvBuffer other = RLV_NULL;
    CHECK_OK(rlv_buffer_create(growing, &other));
    CHECK_OK(rlv_buffer_info(other, &info));
    CHECK(info.point_count == 9 * 9);
    sculpt(context, plain, 2.4);
    CHECK_OK(rlv_tessellation_update(growing, NULL));
    CHECK_OK(rlv_buffer_update(other, &info));
    CHECK(info.rebuilt == 1 && info.point_count > 81 && info.written_count == info.point_count);
    compare(other, growing);
    check_vulkan(other, info);
    CHECK_OK(rlv_tessellation_release(growing));
    CHECK_OK(rlv_detail_release(plain));
    CHECK_OK(rlv_buffer_retain(other));
    check_idle(other.id, "buffer");
    CHECK_OK(rlv_buffer_release(other));
    CHECK_OK(rlv_buffer_release(other));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_buffer_info(other, &info), "not alive");

    /* Lost: said, and what the host has stays with the tessellation. */
    RlvBufferVulkan vulkan = RLV_BUFFER_VULKAN_INIT;
    float point[6];
    CHECK_OK(rlv_context_close_device(context));
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_buffer_update(buffer, &info), "lost");
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_buffer_vulkan(buffer, &vulkan), "lost");
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_buffer_read(buffer, 0, 1, point, 0), "lost");
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_buffer_create(tessellation, &untouched), "lost");
    CHECK_OK(rlv_tessellation_get_points(tessellation, 0, 1, point, 0, NULL, 0));
    CHECK_OK(rlv_buffer_release(buffer));
    CHECK_OK(rlv_tessellation_release(tessellation));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_context_release(context));

    /* No room. */
    options.device_memory_limit = 50000;
    CHECK_OK(rlv_context_create(&options, &context));
    detail = make(context);
    tessellation = follow(detail, 16);
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_buffer_create(tessellation, &untouched), "limit");
    CHECK(untouched.id == 77);
    CHECK_OK(rlv_tessellation_release(tessellation));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
