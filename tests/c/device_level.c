/* Levels on a graphics device: they are those of the processor at every deviation and for a view, edited, taken back and made
 * again, with attributes; their Vulkan objects are real, and where there is no device, or it is lost or too small, that is
 * said. With the argument "none", where no driver can be found: what is said then. */
#include "ball.h"
#include "gpu.h"

typedef struct Kept {
    RlvLevelBuffers buffers;
    RlvLevelUpdate update;
    float *points, *normals, *values;
    uint32_t *triangles, *wedges, *faces;
} Kept;

static Kept make_room(RlvProgressive whole) {
    RlvProgressiveInfo info = RLV_PROGRESSIVE_INFO_INIT;
    Kept kept = {RLV_LEVEL_BUFFERS_INIT, RLV_LEVEL_UPDATE_INIT, NULL, NULL, NULL, NULL, NULL, NULL};
    CHECK_OK(rlv_progressive_info(whole, &info));
    CHECK(info.wedge_width == 1 && info.face_width == 0);
    kept.buffers.points = kept.points = malloc(info.vertex_count * 12);
    kept.buffers.normals = kept.normals = malloc(info.vertex_count * 12);
    kept.buffers.triangles = kept.triangles = malloc(info.triangle_count * 12);
    kept.buffers.wedges = kept.wedges = malloc(info.triangle_count * 12);
    kept.buffers.wedge_values = kept.values = malloc(info.wedge_count * 4);
    CHECK(kept.points != NULL && kept.normals != NULL && kept.triangles != NULL && kept.wedges != NULL);
    CHECK(kept.values != NULL);
    kept.buffers.vertex_capacity = info.vertex_count;
    kept.buffers.triangle_capacity = info.triangle_count;
    kept.buffers.wedge_capacity = info.wedge_count;
    return kept;
}

static void release_room(Kept *kept) {
    free(kept->points);
    free(kept->normals);
    free(kept->triangles);
    free(kept->wedges);
    free(kept->values);
}

/* What tells meshes apart: six times the volume, the greatest height, and the values summed up over all corners. */
typedef struct Measure {
    size_t vertices, triangles;
    double volume, top, values;
} Measure;

static Measure measure(const Kept *kept) {
    Measure made = {kept->update.vertex_count, kept->update.triangle_count, 0, -9, 0};
    for (size_t k = 0; k < made.triangles; ++k) {
        const float *p[3];
        for (int side = 0; side < 3; ++side) {
            CHECK(kept->triangles[3 * k + side] < made.vertices && kept->wedges[3 * k + side] < kept->update.wedge_count);
            p[side] = kept->points + 3 * kept->triangles[3 * k + side];
            made.values += kept->values[kept->wedges[3 * k + side]];
        }
        made.volume += p[0][0] * ((double)p[1][1] * p[2][2] - (double)p[1][2] * p[2][1]) +
                       p[0][1] * ((double)p[1][2] * p[2][0] - (double)p[1][0] * p[2][2]) +
                       p[0][2] * ((double)p[1][0] * p[2][1] - (double)p[1][1] * p[2][0]);
    }
    for (size_t k = 0; k < made.vertices; ++k) {
        const float *n = kept->normals + 3 * k;
        CHECK_NEAR(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1.0, 1e-4);
        made.top = kept->points[3 * k + 2] > made.top ? kept->points[3 * k + 2] : made.top;
    }
    return made;
}

/* Both are the same mesh. */
static Measure compare(RlvDeviceLevel device, RlvLevel level, Kept *room, double tolerance) {
    RlvDeviceLevelInfo info = RLV_DEVICE_LEVEL_INFO_INIT;
    CHECK_OK(rlv_device_level_info(device, &info));
    CHECK_OK(rlv_device_level_read(device, &room->buffers, &room->update));
    const Measure made = measure(room);
    CHECK(info.vertex_count == made.vertices && info.triangle_count == made.triangles);
    CHECK(info.wedge_count >= room->update.wedge_count && room->update.changed_vertex_count == made.vertices);
    room->buffers.is_whole = 1;
    CHECK_OK(rlv_level_update(level, &room->buffers, &room->update));
    const Measure expected = measure(room);
    CHECK(made.vertices == expected.vertices && made.triangles == expected.triangles);
    CHECK_NEAR(made.volume, expected.volume, tolerance);
    CHECK_NEAR(made.top, expected.top, tolerance);
    CHECK_NEAR(made.values, expected.values, 1e-9);
    return made;
}

static RlvProgressive make(RlvContext context) {
    RlvMesh ball = check_ball_of(context, 1.0, 24, 48);
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    RlvProgressive whole = RLV_NULL;
    RlvProgressiveOptions options = RLV_PROGRESSIVE_OPTIONS_INIT;
    RlvAttributeArrays heights = RLV_ATTRIBUTE_ARRAYS_INIT;
    CHECK_OK(rlv_mesh_info(ball, &info));
    float *points = malloc(info.point_count * 12);
    CHECK(points != NULL);
    CHECK_OK(rlv_mesh_get_points(ball, points, info.point_count, 0));
    heights.name = "height";
    heights.domain = RLV_DOMAIN_POINT;
    heights.type = RLV_TYPE_F32;
    heights.width = 1;
    heights.values = points + 2;
    heights.value_count = info.point_count;
    heights.value_stride = 12;
    CHECK_OK(rlv_mesh_add_attribute(ball, &heights));
    options.keeps_attributes = 1;
    options.base_triangles = 40;
    CHECK_OK(rlv_progressive_create(ball, &options, NULL, NULL, &whole));
    free(points);
    CHECK_OK(rlv_mesh_release(ball));
    return whole;
}

static void check_edits(RlvDeviceLevel device, RlvLevel level, Kept *room) {
    const RlvLevelHandle handle = {{{0, 0, 1}, 0.8f, RLV_FALLOFF_SMOOTH}, {0, 0, 0.5f}, {0, 0, 1}, 0.3f, 0};
    RlvLevelEdit edit = RLV_LEVEL_EDIT_INIT;
    RlvDeviceLevelInfo info = RLV_DEVICE_LEVEL_INFO_INIT;
    size_t reached = 77, expected = 0;
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_device_level_undo(device), "no edit to take back");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_level_edit(device, &edit, &reached), "no vertex");
    edit.handles = &handle;
    edit.handle_count = 1;
    CHECK_OK(rlv_device_level_set_triangles(device, 500));
    CHECK_OK(rlv_level_set_triangles(level, 500));
    const double before = compare(device, level, room, 1e-9).volume;
    CHECK_OK(rlv_device_level_edit(device, &edit, &reached));
    CHECK_OK(rlv_level_edit(level, &edit, &expected));
    CHECK(reached == expected && reached > 10);
    CHECK(compare(device, level, room, 1e-4).top > 1.3);
    CHECK_OK(rlv_device_level_set_triangles(device, SIZE_MAX));
    CHECK_OK(rlv_level_set_triangles(level, SIZE_MAX));
    CHECK(compare(device, level, room, 1e-4).top > 1.3);
    CHECK_OK(rlv_device_level_undo(device));
    CHECK_OK(rlv_level_undo(level));
    CHECK(compare(device, level, room, 1e-9).top == 1.0);
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_device_level_undo(device), "no edit to take back");
    CHECK_OK(rlv_device_level_redo(device));
    CHECK_OK(rlv_level_redo(level));
    CHECK(compare(device, level, room, 1e-4).top > 1.3);
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_device_level_redo(device), "no edit to make again");
    CHECK_OK(rlv_device_level_info(device, &info));
    CHECK(info.undo_count == 1 && info.redo_count == 0);
    CHECK_OK(rlv_device_level_undo(device));
    CHECK_OK(rlv_level_undo(level));
    CHECK_OK(rlv_device_level_set_triangles(device, 500));
    CHECK_OK(rlv_level_set_triangles(level, 500));
    CHECK(compare(device, level, room, 1e-9).volume == before);
}

/* Everything goes up and turns by half of what its last key says, and is as it was in the end. */
static void check_motions(RlvDeviceLevel device, RlvLevel level, Kept *room) {
    const RlvLevelKey keys[2] = {{0, {0, 0, 0}, {0, 0, 1}, 0, 0}, {2, {0, 0, 1}, {0, 0, 1}, 0.5f, 0}};
    const RlvLevelTrack track = {{{0, 0, 0}, 9, RLV_FALLOFF_CONSTANT}, keys, 2, 0};
    RlvLevelMotion motion = RLV_LEVEL_MOTION_INIT;
    size_t reached = 0, expected = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_level_add_motion(device, NULL), "NULL");
    motion.tracks = &track;
    motion.track_count = 1;
    CHECK_OK(rlv_device_level_add_motion(device, &motion));
    CHECK_OK(rlv_level_add_motion(level, &motion));
    CHECK_OK(rlv_device_level_set_triangles(device, 700));
    CHECK_OK(rlv_level_set_triangles(level, 700));
    const double top = compare(device, level, room, 1e-9).top;
    CHECK_OK(rlv_device_level_set_time(device, 1, &reached));
    CHECK_OK(rlv_level_set_time(level, 1, &expected));
    CHECK(reached == expected && reached > 100);
    CHECK_NEAR(compare(device, level, room, 1e-4).top, top + 0.5, 1e-5);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_level_set_time(device, NAN, NULL), "time");
    CHECK_OK(rlv_device_level_set_time(device, 2, NULL));
    CHECK_OK(rlv_device_level_clear_motions(device));
    CHECK_OK(rlv_level_clear_motions(level));
    CHECK(compare(device, level, room, 1e-9).top == top);
    CHECK_OK(rlv_device_level_set_time(device, 2, &reached));
    CHECK(reached == 0);
}

int main(int argc, char **argv) {
    RlvContext context = RLV_NULL, serial = RLV_NULL;
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvDeviceLevel device = RLV_NULL, other = RLV_NULL, untouched = {77};
    RlvLevel level = RLV_NULL;
    options.threads = 1;
    CHECK_OK(rlv_context_create(&options, &serial));
    RlvProgressive whole = make(serial);
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_device_level_create(whole, &untouched), "no graphics device");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_level_create((RlvProgressive){0}, &untouched), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_level_create(whole, NULL), "out");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_level_undo((RlvDeviceLevel){whole.id}), "of a progressive mesh");
    CHECK(untouched.id == 77);
    CHECK_OK(rlv_progressive_release(whole));
    CHECK_OK(rlv_context_release(serial));
    check_on_gpu(argc, argv, &options);
    CHECK_OK(rlv_context_create(&options, &context));
    whole = make(context);
    Kept room = make_room(whole);
    CHECK_OK(rlv_level_create(whole, &level));
    CHECK_OK(rlv_device_level_create(whole, &device));
    CHECK_OK(rlv_device_level_create(whole, &other));
    compare(device, level, &room, 1e-9);
    const float errors[3] = {0.1f, 0.01f, 0.0f};
    for (int k = 0; k < 3; ++k) {
        CHECK_OK(rlv_device_level_set_error(device, errors[k]));
        CHECK_OK(rlv_level_set_error(level, errors[k]));
        compare(device, level, &room, 1e-9);
    }
    CHECK_OK(rlv_device_level_set_triangles(device, 777));
    CHECK_OK(rlv_level_set_triangles(level, 777));
    compare(device, level, &room, 1e-9);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_level_set_error(device, -1.0f), "error");
    RlvLevelView view = RLV_LEVEL_VIEW_INIT;
    view.eye[2] = 1.5f;
    view.pixels = 100.0f;
    CHECK_OK(rlv_device_level_set_view(device, &view));
    CHECK_OK(rlv_level_set_triangles(level, SIZE_MAX));
    CHECK_OK(rlv_level_set_view(level, &view));
    CHECK(compare(device, level, &room, 1e-9).triangles < room.buffers.triangle_capacity);
    view.tolerance = 0.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_level_set_view(device, &view), "tolerance");
    float planes[7][4] = {{0, 0, 1, 9}, {0, 0, 1, 9}, {0, 0, 1, 9}, {0, 0, 1, 9}, {0, 0, 1, 9}, {0, 0, 1, 9}, {0, 0, 1, 9}};
    view.tolerance = 1.0f;
    view.planes = planes[0];
    view.plane_count = 7;
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_device_level_set_view(device, &view), "7 planes");
    check_edits(device, level, &room);
    check_motions(device, level, &room);

    /* The other one knows of none of that. */
    RlvDeviceLevelInfo info = RLV_DEVICE_LEVEL_INFO_INIT;
    CHECK_OK(rlv_device_level_info(other, &info));
    CHECK(info.triangle_count <= 40 && info.undo_count == 0 && info.redo_count == 0);
    CHECK_OK(rlv_device_level_retain(other));
    check_idle(other.id, "device level");
    CHECK_OK(rlv_device_level_release(other));
    CHECK_OK(rlv_device_level_release(other));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_level_info(other, &info), "not alive");
    room.buffers.vertex_capacity = 10;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_level_read(device, &room.buffers, NULL), "room for 10");
    RlvDeviceLevelVulkan vulkan = RLV_DEVICE_LEVEL_VULKAN_INIT;
    const RlvResult result = rlv_device_level_vulkan(device, &vulkan);
    CHECK(result == RLV_ERROR_UNSUPPORTED || (result == RLV_OK && vulkan.device != 0 && vulkan.queue != 0 &&
                                              vulkan.vertices != 0 && vulkan.triangles != 0 && vulkan.arguments != 0 &&
                                              vulkan.wedges != 0 && vulkan.wedge_values != 0));

    /* Lost: said. */
    CHECK_OK(rlv_context_close_device(context));
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_device_level_info(device, &info), "lost");
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_device_level_set_error(device, 0.0f), "lost");
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_device_level_undo(device), "lost");
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_device_level_vulkan(device, &vulkan), "lost");
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_device_level_create(whole, &untouched), "lost");
    CHECK_OK(rlv_device_level_release(device));
    CHECK_OK(rlv_level_release(level));
    CHECK_OK(rlv_progressive_release(whole));
    CHECK_OK(rlv_context_release(context));
    release_room(&room);

    /* No room. */
    options.device_memory_limit = 4000;
    CHECK_OK(rlv_context_create(&options, &context));
    whole = make(context);
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_device_level_create(whole, &untouched), "limit");
    CHECK(untouched.id == 77);
    CHECK_OK(rlv_progressive_release(whole));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
