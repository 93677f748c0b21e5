/* Lists the graphics devices there are, sculpts on one of them, and says which did it.
 *
 *   cc device.c $(pkg-config --cflags --libs relievo) -o device && ./device            # the best one, or the processor
 *                                                                  ./device llvmpipe   # one by a part of its name
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

/* A plane of one quad, from (0, 0) to (1, 1). */
static RlvDetail make_plane(RlvContext context) {
    static const float points[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    static const uint32_t corners[4] = {0, 1, 2, 3};
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    RlvMesh mesh = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    arrays.points = points[0];
    arrays.point_count = 4;
    arrays.face_size = 4;
    arrays.face_count = 1;
    arrays.corners = corners;
    arrays.corner_count = 4;
    check(rlv_mesh_create(context, &arrays, &mesh));
    check(rlv_surface_create(context, mesh, NULL, &surface));
    check(rlv_detail_create(surface, NULL, NULL, &detail));
    check(rlv_surface_release(surface));
    check(rlv_mesh_release(mesh));
    return detail;
}

int main(int argc, char **argv) {
    static RlvAdapterInfo adapters[16];
    size_t count = 0;
    check(rlv_adapter_list(adapters, 16, &count));
    for (size_t k = 0; k < count; ++k) {
        printf("there is %s (%s, %s)\n", adapters[k].name, adapters[k].backend, adapters[k].driver);
    }

    /* With a name it has to be that one; without, the processor steps in where there is none. */
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    options.device = argc > 1 ? RLV_DEVICE_GPU : RLV_DEVICE_AUTO;
    options.adapter = argc > 1 ? argv[1] : NULL;
    RlvContext context = RLV_NULL;
    check(rlv_context_create(&options, &context));

    /* No call that follows knows of devices. */
    RlvDetail detail = make_plane(context);
    RlvBrushOptions kind = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvStrokePoint points[2] = {{{0.2, 0.5, 0.0}, 1.0, -1.0}, {{0.8, 0.5, 0.0}, 1.0, -1.0}};
    RlvStrokeReport report = RLV_STROKE_REPORT_INIT;
    RlvBrush brush = RLV_NULL;
    kind.action = RLV_BRUSH_SCULPT;
    kind.height = 0.05f;
    settings.radius = 0.1f;
    check(rlv_brush_create(context, &kind, &settings, &brush));
    check(rlv_stroke_run(detail, brush, points, 2, 0, &report));
    check(rlv_detail_commit(detail, NULL));

    RlvContextInfo info = RLV_CONTEXT_INFO_INIT;
    check(rlv_context_info(context, &info));
    printf("%s changed %llu coefficients in %llu dabs\n", info.device == RLV_DEVICE_GPU ? info.adapter : "the processor",
           (unsigned long long)report.changed_texels, (unsigned long long)report.dabs);
    if (info.fallback[0] != 0) {
        printf("because %s\n", info.fallback);
    }
    /* If the device was lost on the way, the processor finished the stroke, and this says why. */
    if (rlv_detail_device_fault(detail) != RLV_OK) {
        printf("the processor took over: %s\n", rlv_error_last());
    }
    check(rlv_brush_release(brush));
    check(rlv_detail_release(detail));
    check(rlv_context_release(context));
    return 0;
}
