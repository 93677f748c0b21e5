/* Colours on a graphics device: they have the detail's blocks to the bit and follow its commits, mips are means, their Vulkan
 * objects are real, and where there is no device, or it is lost or too small, that is said. With the argument "none", where no
 * driver can be found: what is said then. */
#include "gpu.h"

/* The Vulkan loader knows the buffers, which are as large as they say together. */
static void check_vulkan(RlvColorBuffer buffer, RlvColorBufferInfo info) {
    RlvColorBufferVulkan vulkan = RLV_COLOR_BUFFER_VULKAN_INIT;
    RlvResult result = rlv_color_buffer_vulkan(buffer, &vulkan);
    if (result == RLV_ERROR_UNSUPPORTED) {
        return;
    }
    CHECK(result == RLV_OK);
    void *library = NULL;
    Lookup of_device = check_loader(vulkan.instance, &library);
    GetRequirements get_requirements =
        (GetRequirements)of_device(check_handle(vulkan.device), "vkGetBufferMemoryRequirements");
    CHECK(get_requirements != NULL && vulkan.physical_device != 0 && vulkan.queue != 0);
    const uint64_t buffers[4] = {vulkan.tiles, vulkan.texels, vulkan.mip_firsts, vulkan.mips};
    uint64_t bytes = 0;
    for (int k = 0; k < 4; ++k) {
        MemoryRequirements needed = {0, 0, 0};
        get_requirements(check_handle(vulkan.device), buffers[k], &needed);
        CHECK(needed.size > 0);
        bytes += needed.size;
    }
    CHECK(bytes >= info.bytes);
    dlclose(library);
}

/* 16 quads with colours, painted nowhere yet. */
static RlvDetail make(RlvContext context, uint32_t format) {
    RlvMesh plane = check_plane(context, 4, 4);
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    paint.tile_size = 16;
    paint.format = format;
    paint.color[0] = 0.25f;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    return detail;
}

static void brush(RlvContext context, RlvDetail detail, double x) {
    check_stroke(context, detail, RLV_BRUSH_PAINT, x, 1.4, 0.3f);
    CHECK_OK(rlv_detail_commit(detail, NULL));
}

/* Every tile is the detail's to the bit, and a colour of a mip lies between the four below it. Returns how many have one. */
static size_t compare(RlvColorBuffer buffer, RlvDetail detail, RlvColorBufferInfo info) {
    static unsigned char expected[18 * 18 * 8], found[18 * 18 * 8], mip[10 * 10 * 8];
    const size_t texel = info.format == RLV_COLOR_RGBA8 ? 4 : 8;
    size_t allocated = 0;
    for (uint32_t tile = 0; tile < info.tile_count; ++tile) {
        size_t size = 0, other = 0;
        CHECK_OK(rlv_detail_read_block(detail, RLV_CHANNEL_COLOR, tile, expected, sizeof expected, &size));
        CHECK_OK(rlv_color_buffer_read(buffer, tile, 0, found, sizeof found, &other));
        CHECK(size == other && memcmp(expected, found, size) == 0);
        if (size > 0) {
            other = 77;
            CHECK_FAILS(RLV_ERROR_INVALID, rlv_color_buffer_read(buffer, tile, 0, found, size - 1, &other), "bytes");
            CHECK(other == size);
        }
        CHECK_OK(rlv_color_buffer_read(buffer, tile, 1, mip, sizeof mip, &other));
        CHECK(other == (size == 0 ? 0 : 10 * 10 * texel));
        allocated += size > 0;
        for (size_t k = 0; texel == 4 && size > 0 && k < 8 * 8 * 4; ++k) {
            const size_t c = k % 4, i = k / 4 % 8, j = k / 32;
            unsigned char low = 255, high = 0;
            for (size_t n = 0; n < 4; ++n) {
                const size_t at = 4 * ((2 * j + n / 2 + 1) * 18 + 2 * i + n % 2 + 1) + c;
                low = found[at] < low ? found[at] : low;
                high = found[at] > high ? found[at] : high;
            }
            const unsigned char mean = mip[4 * ((j + 1) * 10 + i + 1) + c];
            CHECK(low <= mean && mean <= high);
        }
    }
    size_t size = 77;
    CHECK_OK(rlv_color_buffer_read(buffer, 0, 9, NULL, 0, &size));
    CHECK(size == 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_color_buffer_read(buffer, (uint32_t)info.tile_count, 0, NULL, 0, &size), "tile");
    return allocated;
}

int main(int argc, char **argv) {
    RlvContext context = RLV_NULL, serial = RLV_NULL;
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvColorBuffer buffer = RLV_NULL, untouched = {77};
    RlvColorBufferInfo info = RLV_COLOR_BUFFER_INFO_INIT;
    options.threads = 1;
    CHECK_OK(rlv_context_create(&options, &serial));
    RlvDetail detail = make(serial, RLV_COLOR_RGBA8);
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_color_buffer_create(detail, &untouched), "no graphics device");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_color_buffer_create((RlvDetail){0}, &untouched), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_color_buffer_create(detail, NULL), "out");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_color_buffer_info((RlvColorBuffer){0}, &info), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_color_buffer_update((RlvColorBuffer){detail.id}, NULL), "of a detail");
    CHECK(untouched.id == 77);
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_context_release(serial));
    check_on_gpu(argc, argv, &options);
    CHECK_OK(rlv_context_create(&options, &context));

    for (uint32_t format = RLV_COLOR_RGBA8; format <= RLV_COLOR_RGBA16F; ++format) {
        detail = make(context, format);
        CHECK_OK(rlv_color_buffer_create(detail, &buffer));
        CHECK_OK(rlv_color_buffer_info(buffer, &info));
        CHECK(info.format == format && info.tile_count == 16 && info.allocated_count == 0 && info.rebuilt == 1);
        CHECK(info.color[0] > 0.24f && info.color[0] < 0.26f && info.color[3] == 1.0f);
        CHECK(compare(buffer, detail, info) == 0);

        /* What was painted, and then what else was. */
        brush(context, detail, 1.4);
        CHECK_OK(rlv_color_buffer_update(buffer, &info));
        CHECK(info.rebuilt == 1 && info.written_count == info.allocated_count && info.allocated_count > 2);
        CHECK(compare(buffer, detail, info) == info.allocated_count);
        check_vulkan(buffer, info);
        CHECK_OK(rlv_color_buffer_update(buffer, &info));
        CHECK(info.rebuilt == 0 && info.written_count == 0);
        brush(context, detail, 0.4);
        CHECK_OK(rlv_color_buffer_update(buffer, &info));
        CHECK(info.written_count > 0 && info.written_count <= info.allocated_count);
        CHECK(compare(buffer, detail, info) == info.allocated_count);
        CHECK_OK(rlv_color_buffer_retain(buffer));
        check_idle(buffer.id, "color buffer");
        CHECK_OK(rlv_color_buffer_release(buffer));
        if (format == RLV_COLOR_RGBA8) {
            CHECK_OK(rlv_color_buffer_release(buffer));
            CHECK_FAILS(RLV_ERROR_INVALID, rlv_color_buffer_info(buffer, &info), "not alive");
            CHECK_OK(rlv_detail_release(detail));
        }
    }

    /* Nothing painted on. */
    RlvMesh plane = check_plane(context, 2, 2);
    RlvSurface surface = RLV_NULL;
    RlvDetail plain = RLV_NULL;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &plain));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_color_buffer_create(plain, &untouched), "colours");
    CHECK_OK(rlv_detail_release(plain));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));

    /* Lost: said. */
    RlvColorBufferVulkan vulkan = RLV_COLOR_BUFFER_VULKAN_INIT;
    size_t size = 0;
    CHECK_OK(rlv_context_close_device(context));
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_color_buffer_update(buffer, &info), "lost");
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_color_buffer_vulkan(buffer, &vulkan), "lost");
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_color_buffer_create(detail, &untouched), "lost");
    CHECK_OK(rlv_detail_read_block(detail, RLV_CHANNEL_COLOR, 0, NULL, 0, &size));
    CHECK_OK(rlv_color_buffer_release(buffer));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_context_release(context));

    /* No room. */
    options.device_memory_limit = 4000;
    CHECK_OK(rlv_context_create(&options, &context));
    detail = make(context, RLV_COLOR_RGBA8);
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_color_buffer_create(detail, &untouched), "limit");
    CHECK(untouched.id == 77);
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
