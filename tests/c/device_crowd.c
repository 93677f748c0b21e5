/* Crowds on a graphics device: draws are those of the processor from several places, also after agents moved and came; Vulkan
 * objects are real, and where there is no device, or it is lost or too small, that is said. With the argument "none", where no
 * driver can be found: what is said then. */
#include "bumps.h"
#include "gpu.h"

enum { SIDE = 25, AGENTS = 40, MOST = 4096 };

/* What a cut draws. */
typedef struct Kept {
    RlvCrowdDraw draws[MOST];
    uint32_t clusters[MOST][2];
    RlvCrowdInstance instances[AGENTS + 1];
    float matrices[MOST][12];
    uint32_t first_weights[AGENTS + 1];
    float blends[MOST];
    RlvCrowdImpostor impostors[AGENTS + 1];
    RlvCrowdPicture pictures[AGENTS + 1];
    RlvCrowdTexel texels[(AGENTS + 1) * RLV_CROWD_PICTURE_SIDE * RLV_CROWD_PICTURE_SIDE];
} Kept;

static Kept on_processor, on_device;

/* A bumpy sheet of two triangles a square, as OBJ. */
static RlvCrowdModel make(RlvContext context) {
    RlvCrowdBuildSettings settings = RLV_CROWD_BUILD_SETTINGS_INIT;
    RlvCrowdModel model = RLV_NULL;
    check_write_bumps("device_crowd.obj", SIDE);
    settings.cluster_triangles = 40;
    CHECK_OK(rlv_crowd_model_build(context, "device_crowd.obj", NULL, 0, &settings, NULL, NULL, &model));
    return model;
}

static RlvCrowdBuffers room_in(Kept *kept) {
    RlvCrowdBuffers buffers = RLV_CROWD_BUFFERS_INIT;
    buffers.draws = kept->draws;
    buffers.draw_capacity = MOST;
    buffers.clusters = kept->clusters[0];
    buffers.instances = kept->instances;
    buffers.instance_capacity = AGENTS + 1;
    buffers.matrices = kept->matrices[0];
    buffers.matrix_capacity = MOST;
    buffers.first_weights = kept->first_weights;
    buffers.blends = kept->blends;
    return buffers;
}

/* Both draw the same, and matrices of the same agents are equal. */
static void compare(RlvCrowd crowd, RlvDeviceCrowd device, const RlvCrowdView *view) {
    RlvCrowdFrame frame = RLV_CROWD_FRAME_INIT;
    RlvDeviceCrowdInfo info = RLV_DEVICE_CROWD_INFO_INIT;
    const RlvCrowdBuffers here = room_in(&on_processor), there = room_in(&on_device);
    CHECK_OK(rlv_crowd_cut(crowd, view, &frame));
    CHECK_OK(rlv_device_crowd_cut(device, view, &info));
    CHECK(info.agent_count == frame.agent_count && info.draw_count == frame.draw_count && info.draw_count > 0);
    CHECK(info.matrix_count == 1 && info.weight_count == 0);
    CHECK_OK(rlv_crowd_get(crowd, &here));
    CHECK_OK(rlv_device_crowd_get(device, &there));
    CHECK(memcmp(on_processor.draws, on_device.draws, info.draw_count * sizeof on_device.draws[0]) == 0);
    CHECK(memcmp(on_processor.clusters, on_device.clusters, info.draw_count * sizeof on_device.clusters[0]) == 0);
    CHECK(memcmp(on_processor.instances, on_device.instances, info.agent_count * sizeof on_device.instances[0]) == 0);
    for (uint32_t at = 0; at < info.draw_count; ++at) {
        CHECK(fabsf(on_processor.blends[at] - on_device.blends[at]) < 1e-5f);
    }
    for (uint32_t at = 0; at < info.agent_count; ++at) {
        const float *one = on_processor.matrices[on_processor.instances[at].first_matrix];
        CHECK(memcmp(one, on_device.matrices[on_device.instances[at].first_matrix], 48) == 0);
        CHECK(on_device.first_weights[at] == 0);
    }
}

static RlvCrowdImpostors quads_in(Kept *kept) {
    RlvCrowdImpostors quads = RLV_CROWD_IMPOSTORS_INIT;
    quads.impostors = kept->impostors;
    quads.impostor_capacity = AGENTS + 1;
    quads.pictures = kept->pictures;
    quads.picture_capacity = AGENTS + 1;
    quads.texels = kept->texels;
    quads.texel_capacity = sizeof kept->texels / sizeof kept->texels[0];
    return quads;
}

/* From far away all agents are the same quads with the same pictures. */
static void compare_impostors(RlvCrowd crowd, RlvDeviceCrowd device, RlvCrowdView view) {
    RlvCrowdFrame frame = RLV_CROWD_FRAME_INIT;
    RlvDeviceCrowdInfo info = RLV_DEVICE_CROWD_INFO_INIT;
    RlvCrowdImpostors here = quads_in(&on_processor), there = quads_in(&on_device);
    view.eye[2] = 2000.0;
    view.impostors = 1;
    CHECK_OK(rlv_crowd_cut(crowd, &view, &frame));
    CHECK_OK(rlv_device_crowd_cut(device, &view, &info));
    CHECK(info.agent_count == 0 && info.draw_count == 0 && info.impostor_count == AGENTS + 1);
    CHECK(info.impostor_count == frame.impostor_count && info.picture_count == frame.picture_count);
    CHECK_OK(rlv_crowd_get_impostors(crowd, &here));
    CHECK_OK(rlv_device_crowd_get_impostors(device, &there));
    CHECK(memcmp(on_processor.impostors, on_device.impostors, info.impostor_count * sizeof on_device.impostors[0]) == 0);
    const size_t texels = (size_t)info.picture_count * RLV_CROWD_PICTURE_SIDE * RLV_CROWD_PICTURE_SIDE;
    CHECK(texels > 0 && memcmp(on_processor.texels, on_device.texels, texels * sizeof on_device.texels[0]) == 0);
    there.impostor_capacity = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_crowd_get_impostors(device, &there), "impostors");
}

/* A row of sheets, one behind the other: the first hides most of the others, in either cut. */
static void check_occlusion(RlvCrowd crowd, RlvDeviceCrowd device, RlvCrowdView view) {
    RlvCrowdFrame frame = RLV_CROWD_FRAME_INIT;
    RlvDeviceCrowdInfo all = RLV_DEVICE_CROWD_INFO_INIT, fewer = RLV_DEVICE_CROWD_INFO_INIT;
    RlvCrowdAgent row[AGENTS + 1], before[AGENTS + 1];
    for (int agent = 0; agent <= AGENTS; ++agent) {
        row[agent] = check_agent(0.01 * agent, -0.5 * agent);
        before[agent] = check_agent(3.0 * (agent % 5) - 7.0, -6.0 * (agent / 5));
    }
    CHECK_OK(rlv_crowd_set(crowd, 0, row, AGENTS + 1, 0));
    view.eye[0] = view.target[0] = 1.2;
    view.eye[1] = view.target[1] = 1.2;
    view.eye[2] = 4.0;
    CHECK_OK(rlv_device_crowd_cut(device, &view, &all));
    CHECK(all.hidden == 0 && all.agent_count == AGENTS + 1);
    view.occlusion = 1;
    CHECK_OK(rlv_crowd_cut(crowd, &view, &frame));
    CHECK_OK(rlv_device_crowd_cut(device, &view, &fewer));
    CHECK(frame.hidden > 20 && fewer.hidden > 20 && fewer.hidden <= frame.hidden);
    CHECK(fewer.agent_count + fewer.hidden == all.agent_count && fewer.draw_count < all.draw_count);
    CHECK(fewer.occluder_triangles > 0 && fewer.hidden_triangles > 0);
    CHECK_OK(rlv_crowd_set(crowd, 0, before, AGENTS + 1, 0));
}

/* Models whose bones are blended in one way are culled by occlusion, also as dual quaternions, in two ways not. */
static void check_blends(RlvContext context, RlvCrowdModel model, RlvCrowdView view) {
    RlvCrowdModel models[2] = {model, RLV_NULL};
    RlvCrowdAgent agents[2] = {check_agent(0.0, 0.0), check_agent(0.0, -4.0)};
    RlvDeviceCrowdInfo info = RLV_DEVICE_CROWD_INFO_INIT;
    RlvCrowdBuffers buffers = RLV_CROWD_BUFFERS_INIT;
    CHECK_OK(rlv_crowd_model_with_blend(model, RLV_CROWD_BLEND_DUAL_QUATERNION, &models[1]));
    for (int both = 0; both < 2; ++both) {
        RlvCrowd crowd = RLV_NULL;
        RlvDeviceCrowd device = RLV_NULL;
        float rows[2][20] = {{0.0f}};
        agents[1].model = (uint32_t)both;
        CHECK_OK(rlv_crowd_create(context, models + 1 - both, 1 + (size_t)both, &crowd));
        CHECK_OK(rlv_crowd_add(crowd, agents, 2, 0, NULL));
        CHECK_OK(rlv_device_crowd_create(crowd, &device));
        view.eye[0] = view.target[0] = 1.2;
        view.eye[1] = view.target[1] = 1.2;
        view.eye[2] = 4.0;
        view.occlusion = 0;
        CHECK_OK(rlv_device_crowd_cut(device, &view, &info));
        CHECK(info.agent_count == 2 && info.matrix_count == 1 + (uint32_t)both);
        /* Models at rest: nothing is stretched or turned. */
        buffers.dual_rows = rows[0];
        buffers.matrix_capacity = info.matrix_count;
        CHECK_OK(rlv_device_crowd_get(device, &buffers));
        for (uint32_t k = 0; k < 20 * info.matrix_count; ++k) {
            CHECK(rows[k / 20][k % 20] == (k % 5 == 0));
        }
        view.occlusion = 1;
        if (both) {
            CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_device_crowd_cut(device, &view, &info), "rlv_crowd_model_with_blend");
        } else {
            CHECK_OK(rlv_device_crowd_cut(device, &view, &info));
        }
        CHECK_OK(rlv_device_crowd_release(device));
        CHECK_OK(rlv_crowd_release(crowd));
    }
    CHECK_OK(rlv_crowd_model_release(models[1]));
}

int main(int argc, char **argv) {
    RlvContext context = RLV_NULL, serial = RLV_NULL;
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvCrowd crowd = RLV_NULL;
    RlvDeviceCrowd device = RLV_NULL, untouched = {77};
    RlvCrowdAgent agents[AGENTS];
    options.threads = 1;
    CHECK_OK(rlv_context_create(&options, &serial));
    RlvCrowdModel model = make(serial);
    CHECK_OK(rlv_crowd_create(serial, &model, 1, &crowd));
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_device_crowd_create(crowd, &untouched), "no graphics device");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_crowd_create((RlvCrowd){0}, &untouched), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_crowd_create(crowd, NULL), "out");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_crowd_cut((RlvDeviceCrowd){crowd.id}, NULL, NULL), "of a crowd");
    CHECK(untouched.id == 77);
    CHECK_OK(rlv_crowd_release(crowd));
    CHECK_OK(rlv_crowd_model_release(model));
    CHECK_OK(rlv_context_release(serial));
    check_on_gpu(argc, argv, &options);
    CHECK_OK(rlv_context_create(&options, &context));
    model = make(context);
    CHECK_OK(rlv_crowd_create(context, &model, 1, &crowd));
    for (int agent = 0; agent < AGENTS; ++agent) {
        agents[agent] = check_agent(3.0 * (agent % 5) - 7.0, -6.0 * (agent / 5));
    }
    CHECK_OK(rlv_crowd_add(crowd, agents, AGENTS, 0, NULL));
    CHECK_OK(rlv_device_crowd_create(crowd, &device));
    RlvCrowdBuffers buffers = room_in(&on_device);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_crowd_get(device, &buffers), "rlv_device_crowd_cut");
    RlvCrowdImpostors quads = quads_in(&on_device);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_crowd_get_impostors(device, &quads), "rlv_device_crowd_cut");
    RlvCrowdView view = RLV_CROWD_VIEW_INIT;
    view.width = 320;
    view.height = 240;
    view.target[2] = -1000.0;
    for (int step = 0; step < 4; ++step) {
        view.eye[2] = 20.0 - 12.0 * step;
        compare(crowd, device, &view);
        agents[7].transform[9] += 0.5;
        CHECK_OK(rlv_crowd_set(crowd, 7, agents + 7, 1, 0));
    }
    CHECK_OK(rlv_crowd_add(crowd, agents, 1, 0, NULL));
    compare(crowd, device, &view);
    buffers.draw_capacity = 1;
    on_device.draws[0].index_count = 12345;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_crowd_get(device, &buffers), "draws");
    CHECK(on_device.draws[0].index_count == 12345);
    check_occlusion(crowd, device, view);
    /* With the sun behind the camera there are more agents, the same on both. */
    const RlvCrowdSun sun = {{0.1, 0.2, 1.0}, 0.01};
    RlvDeviceCrowdInfo fewer = RLV_DEVICE_CROWD_INFO_INIT, more = RLV_DEVICE_CROWD_INFO_INIT;
    CHECK_OK(rlv_device_crowd_cut(device, &view, &fewer));
    view.suns = &sun;
    view.sun_count = 1;
    compare(crowd, device, &view);
    CHECK_OK(rlv_device_crowd_cut(device, &view, &more));
    CHECK(more.agent_count > fewer.agent_count);
    view.sun_count = 0;
    view.geomorph = 1;
    view.tolerance = 2.0f;
    compare(crowd, device, &view);
    view.geomorph = 0;
    compare_impostors(crowd, device, view);
    check_blends(context, model, view);
    view.tolerance = -1.0f;
    CHECK_OK(rlv_device_crowd_get_impostors(device, &quads));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_crowd_cut(device, &view, NULL), "pixels");
    /* Nothing is left of the cut before. */
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_crowd_get(device, &buffers), "failed");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_crowd_get_impostors(device, &quads), "failed");
    view.tolerance = 0.5f;
    RlvDeviceCrowdVulkan vulkan = RLV_DEVICE_CROWD_VULKAN_INIT;
    const RlvResult result = rlv_device_crowd_vulkan(device, &vulkan);
    CHECK(result == RLV_ERROR_UNSUPPORTED || (result == RLV_OK && vulkan.device != 0 && vulkan.queue != 0 &&
                                              vulkan.draws != 0 && vulkan.clusters != 0 && vulkan.instances != 0 &&
                                              vulkan.counts != 0 && vulkan.matrices != 0 && vulkan.weights != 0 &&
                                              vulkan.blends != 0));
    CHECK_OK(rlv_device_crowd_retain(device));
    check_idle(device.id, "device crowd");
    CHECK_OK(rlv_device_crowd_release(device));

    /* Lost: said. */
    CHECK_OK(rlv_context_close_device(context));
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_device_crowd_cut(device, &view, NULL), "lost");
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_device_crowd_vulkan(device, &vulkan), "lost");
    CHECK_FAILS(RLV_ERROR_DEVICE, rlv_device_crowd_create(crowd, &untouched), "lost");
    CHECK_OK(rlv_device_crowd_release(device));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_device_crowd_cut(device, &view, NULL), "not alive");
    CHECK_OK(rlv_crowd_release(crowd));
    CHECK_OK(rlv_crowd_model_release(model));
    CHECK_OK(rlv_context_release(context));

    /* No room. */
    options.device_memory_limit = 4000;
    CHECK_OK(rlv_context_create(&options, &context));
    model = make(context);
    CHECK_OK(rlv_crowd_create(context, &model, 1, &crowd));
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_device_crowd_create(crowd, &untouched), "limit");
    CHECK(untouched.id == 77);
    CHECK_OK(rlv_crowd_release(crowd));
    CHECK_OK(rlv_crowd_model_release(model));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
