/* Adapters and contexts on them: what is listed can be opened, strokes on a device are the processor's but for rounding, and
 * where a device is lost in mid-stroke, or too small, the processor goes on and nothing is lost. With the argument "none",
 * where the environment hides all drivers: what is said then. */
#include "ball.h"
#include "gpu.h"

enum { SIDE = 4, POINTS = 12, TEXELS = 34 * 34 };

static int warned;

static void hear(void *user, uint32_t level, const char *text) {
    (void)user;
    warned += level == RLV_LOG_WARNING && strstr(text, "the processor") != NULL;
}

static RlvDetail make(RlvContext context) {
    RlvMesh plane = check_plane(context, SIDE, SIDE);
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    options.tile_size = 32;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    return detail;
}

/* A stroke that is drawn in two halves; between them the device of cut is closed, if there is one. */
static void draw(RlvContext context, RlvDetail detail, const RlvContext *cut) {
    RlvBrushOptions options = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvStrokePoint points[POINTS];
    RlvBrush brush = RLV_NULL;
    RlvStroke stroke = RLV_NULL;
    RlvStrokeReport report = RLV_STROKE_REPORT_INIT;
    for (int k = 0; k < POINTS; ++k) {
        RlvStrokePoint point = {{0.6 + 0.25 * k, 2.0 + sin(0.5 * k), 0.0}, 1.0, -1.0};
        points[k] = point;
    }
    options.action = RLV_BRUSH_SCULPT;
    options.height = 0.2f;
    settings.radius = 0.5f;
    CHECK_OK(rlv_brush_create(context, &options, &settings, &brush));
    CHECK_OK(rlv_stroke_begin(detail, brush, &stroke));
    CHECK_OK(rlv_stroke_extend(stroke, points, POINTS / 2, 0, NULL));
    if (cut != NULL) {
        CHECK_OK(rlv_context_close_device(*cut));
    }
    CHECK_OK(rlv_stroke_extend(stroke, points + POINTS / 2, POINTS / 2, 0, &report));
    CHECK(report.changed_tiles > 0 && report.refused_tiles == 0);
    CHECK_OK(rlv_stroke_end(stroke, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_stroke_release(stroke));
    CHECK_OK(rlv_brush_release(brush));
}

/* A ball that rolls over the plane, as a job. */
static void roll(RlvContext context, RlvDetail detail) {
    const double from[12] = CHECK_MOVED(0.8, 2.0, 0.3), to[12] = CHECK_MOVED(2.8, 2.0, 0.3);
    RlvMesh mesh = check_ball_of(context, 0.4, 24, 48);
    RlvCollider ball = RLV_NULL;
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
    RlvJob job = RLV_NULL;
    settings.voxels = 1 << 15;
    settings.sub_steps = 6;
    CHECK_OK(rlv_collider_create_mesh(context, mesh, from, &ball));
    CHECK_OK(rlv_job_sweep(detail, ball, from, to, &settings, NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_imprint_report(job, &report));
    CHECK(report.steps == 6 && report.changed_tiles > 0 && report.refused_tiles == 0);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_collider_release(ball));
    CHECK_OK(rlv_mesh_release(mesh));
}

/* A half float as a whole number in the order of the numbers. */
static int ordered(uint16_t half) { return half & 0x8000 ? 0x8000 - (int)half : (int)half; }

/* Both have the same tiles; how many coefficients differ, none by more than most steps of half floats. */
static size_t differing(RlvDetail one, RlvDetail other, int most) {
    static uint16_t blocks[2][TEXELS];
    size_t count = 0, there = 0;
    for (uint32_t tile = 0; tile < SIDE * SIDE; ++tile) {
        size_t sizes[2] = {0, 0};
        CHECK_OK(rlv_detail_read_block(one, RLV_CHANNEL_DISPLACEMENT, tile, blocks[0], sizeof blocks[0], &sizes[0]));
        CHECK_OK(rlv_detail_read_block(other, RLV_CHANNEL_DISPLACEMENT, tile, blocks[1], sizeof blocks[1], &sizes[1]));
        CHECK(sizes[0] == sizes[1]);
        there += sizes[0] > 0;
        for (size_t k = 0; k < sizes[0] / 2; ++k) {
            const int apart = abs(ordered(blocks[0][k]) - ordered(blocks[1][k]));
            CHECK(apart <= most);
            count += apart > 0;
        }
    }
    CHECK(there >= 4);
    return count;
}

static void check_none(void) {
    RlvContext context = {77};
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvContextInfo info = RLV_CONTEXT_INFO_INIT;
    size_t count = 7;
    CHECK_OK(rlv_adapter_list(NULL, 0, &count));
    CHECK(count == 0);
    options.threads = 1;
    options.device = RLV_DEVICE_GPU;
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_context_create(&options, &context), "there is no graphics device");
    CHECK(strstr(rlv_error_last(), "Vulkan driver") != NULL);
    options.adapter = "Quartz";
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_context_create(&options, &context), "there is no graphics device");
    CHECK(context.id == 77);
    options.device = RLV_DEVICE_AUTO;
    CHECK_OK(rlv_context_create(&options, &context));
    CHECK_OK(rlv_context_info(context, &info));
    CHECK(info.device == RLV_DEVICE_CPU && info.adapter[0] == 0);
    CHECK(strstr(info.fallback, "there is no graphics device") != NULL);
    RlvDetail detail = make(context);
    draw(context, detail, NULL);
    CHECK_OK(rlv_detail_device_fault(detail));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_context_release(context));
}

int main(int argc, char **argv) {
    RlvAdapterInfo adapters[16];
    RlvContext context = RLV_NULL, serial = RLV_NULL, untouched = {77};
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvContextInfo info = RLV_CONTEXT_INFO_INIT;
    size_t count = 0, again = 0;
    if (argc > 1 && strcmp(argv[1], "none") == 0) {
        check_none();
        return 0;
    }
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_adapter_list(adapters, 16, NULL), "count");
    CHECK_OK(rlv_adapter_list(NULL, 0, &count));
    if (count == 0) {
        check_skipped();
    }
    CHECK(count <= 16);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_adapter_list(adapters, count - 1, &again), count > 1 ? "room for" : "adapters");
    CHECK(again == count);
    CHECK_OK(rlv_adapter_list(adapters, 16, &again));
    CHECK(again == count);
    for (size_t k = 0; k < count; ++k) {
        CHECK(adapters[k].kind <= RLV_ADAPTER_SOFTWARE && (k == 0 || adapters[k - 1].kind <= adapters[k].kind));
        CHECK(adapters[k].name[0] != 0 && adapters[k].driver[0] != 0 && adapters[k].backend[0] != 0);
        CHECK(adapters[k].buffer_limit >= adapters[k].binding_limit && adapters[k].binding_limit >= 1 << 27);
    }
    const RlvAdapterInfo last = adapters[count - 1];
    CHECK(last.is_usable == 1);

    /* By name; the one that is not there, and garbage. */
    options.threads = 1;
    CHECK_OK(rlv_context_create(&options, &serial));
    options.device = RLV_DEVICE_GPU;
    options.adapter = "no adapter is called so";
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_context_create(&options, &untouched), "is called");
    options.adapter = "\xff\xfe";
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_context_create(&options, &untouched), "UTF-8");
    options.device = 9;
    options.adapter = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_context_create(&options, &untouched), "device");
    CHECK(untouched.id == 77);
    options.device = RLV_DEVICE_AUTO;
    options.adapter = last.name;
    CHECK_OK(rlv_context_create(&options, &context));
    CHECK_OK(rlv_context_info(context, &info));
    CHECK(info.device == RLV_DEVICE_GPU && strcmp(info.adapter, last.name) == 0 && info.fallback[0] == 0);
    CHECK(info.device_memory_limit == 0);

    /* A stroke on it is the processor's but for rounding. */
    RlvDetail here = make(serial), there = make(context);
    draw(serial, here, NULL);
    draw(context, there, NULL);
    CHECK_OK(rlv_detail_device_fault(there));
    CHECK_OK(rlv_context_info(context, &info));
    CHECK(info.device_memory > 0);
    CHECK(differing(here, there, 4) < 500);
    CHECK_OK(rlv_detail_release(there));

    /* So is an imprint, but for rays that graze a voxel. */
    RlvDetail pressed = make(serial);
    there = make(context);
    roll(serial, pressed);
    roll(context, there);
    CHECK_OK(rlv_detail_device_fault(there));
    CHECK(differing(pressed, there, 0x7fff) < 500);
    CHECK_OK(rlv_detail_release(pressed));
    CHECK_OK(rlv_detail_release(there));

    /* Lost in the middle of a stroke. */
    there = make(context);
    CHECK_OK(rlv_context_set_log(context, hear, NULL));
    draw(context, there, &context);
    CHECK(warned == 1);
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_detail_device_fault(there), "lost");
    CHECK(differing(here, there, 4) < 500);
    CHECK_OK(rlv_context_info(context, &info));
    CHECK(info.device == RLV_DEVICE_CPU && strstr(info.fallback, "lost") != NULL);
    CHECK_OK(rlv_context_close_device(context));
    CHECK_OK(rlv_detail_release(there));
    /* What is made afterwards is the processor's, to the bit. */
    there = make(context);
    draw(context, there, NULL);
    CHECK_OK(rlv_detail_device_fault(there));
    CHECK(differing(here, there, 0) == 0);
    CHECK_OK(rlv_detail_release(there));
    CHECK_OK(rlv_context_release(context));

    /* No room for the detail, and none for its tiles. */
    for (uint64_t limit = 1000; limit < 400000; limit *= 20) {
        options.device = RLV_DEVICE_GPU;
        options.device_memory_limit = limit;
        CHECK_OK(rlv_context_create(&options, &context));
        CHECK_OK(rlv_context_set_log(context, hear, NULL));
        warned = 0;
        there = make(context);
        draw(context, there, NULL);
        CHECK(warned == 1);
        CHECK_FAILS(RLV_ERROR_MEMORY, rlv_detail_device_fault(there), "limit");
        CHECK(differing(here, there, 4) < 500);
        CHECK_OK(rlv_context_info(context, &info));
        CHECK(info.device == RLV_DEVICE_GPU && info.device_memory <= limit && info.device_memory_limit == limit);
        CHECK_OK(rlv_detail_release(there));
        CHECK_OK(rlv_context_release(context));
    }
    CHECK_OK(rlv_detail_release(here));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_device_fault(here), "not alive");
    CHECK_OK(rlv_context_release(serial));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_context_close_device(serial), "not alive");
    return 0;
}
