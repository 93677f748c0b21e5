/* What a host may hand over by mistake to crowds: NULL, handles that are dead, of another noun or made up, descriptors of other
 * sizes, numbers that are none, and threads at once. All is an error by the rules of the headers, or done. */
#include "bumps.h"
#include "garbage.h"

#include <pthread.h>

enum { SIDE = 12, POINTS = SIDE * SIDE, AGENTS = 3, ROUNDS = 12, MOST = 4096 };
static const char *const PATH = "crowd_garbage.obj";
static const RlvCrowdAgent AHEAD = {0, 0, 0.0, {1, 0, 0, 0, 1, 0, 0, 0, 1, -0.5, -0.5, -4}};

static RlvContext known;

static RlvResult build_model(uint64_t id) { RlvCrowdModel out; return rlv_crowd_model_build((RlvContext){id}, PATH, NULL, 0, NULL, NULL, NULL, &out); }
static RlvResult refit(uint64_t id) { RlvCrowdModel out; return rlv_crowd_model_refit((RlvCrowdModel){id}, PATH, NULL, 0, NULL, NULL, NULL, NULL, &out); }
static RlvResult blend_model(uint64_t id) { RlvCrowdModel out; return rlv_crowd_model_with_blend((RlvCrowdModel){id}, RLV_CROWD_BLEND_LINEAR, &out); }
static RlvResult read_model(uint64_t id) { RlvCrowdModel out; return rlv_crowd_model_read((RlvContext){id}, PATH, &out); }
static RlvResult write_model(uint64_t id) { return rlv_crowd_model_write((RlvCrowdModel){id}, "crowd_garbage.rcrowd"); }
static RlvResult read_bytes(uint64_t id) { RlvCrowdModel out; return rlv_crowd_model_read_bytes((RlvContext){id}, (const uint8_t *)"a", 1, &out); }
static RlvResult write_bytes(uint64_t id) { RlvBytes out; return rlv_crowd_model_write_bytes((RlvCrowdModel){id}, &out); }
static RlvResult retain_model(uint64_t id) { return rlv_crowd_model_retain((RlvCrowdModel){id}); }
static RlvResult release_model(uint64_t id) { return rlv_crowd_model_release((RlvCrowdModel){id}); }
static RlvResult model_info(uint64_t id) { RlvCrowdModelInfo out = RLV_CROWD_MODEL_INFO_INIT; return rlv_crowd_model_info((RlvCrowdModel){id}, &out); }
static RlvResult model_clip(uint64_t id) { RlvCrowdClip out = RLV_CROWD_CLIP_INIT; return rlv_crowd_model_clip((RlvCrowdModel){id}, 0, &out); }
static RlvResult material(uint64_t id) { RlvCrowdMaterial out = RLV_CROWD_MATERIAL_INIT; return rlv_crowd_model_material((RlvCrowdModel){id}, 0, &out); }
static RlvResult vertices(uint64_t id) { RlvCrowdVertices out = RLV_CROWD_VERTICES_INIT; return rlv_crowd_model_get_vertices((RlvCrowdModel){id}, &out); }
static RlvResult collapses(uint64_t id) { RlvCrowdCollapse out; return rlv_crowd_model_get_collapses((RlvCrowdModel){id}, &out, 1, 0); }
static RlvResult offsets(uint64_t id) { RlvCrowdOffset out; return rlv_crowd_model_get_offsets((RlvCrowdModel){id}, &out, 1, 0); }
static RlvResult triangles(uint64_t id) { uint32_t out[3]; return rlv_crowd_model_get_triangles((RlvCrowdModel){id}, out, NULL, 1); }
static RlvResult clusters(uint64_t id) { RlvCrowdCluster out; return rlv_crowd_model_get_clusters((RlvCrowdModel){id}, &out, 1, 0); }
static RlvResult model_mesh(uint64_t id) { RlvMesh out; return rlv_crowd_model_mesh((RlvCrowdModel){id}, 0.0f, 0, 0, &out); }
static RlvResult create_of(uint64_t id) { RlvCrowd out; return rlv_crowd_create(known, &(RlvCrowdModel){id}, 1, &out); }
static RlvResult retain(uint64_t id) { return rlv_crowd_retain((RlvCrowd){id}); }
static RlvResult release(uint64_t id) { return rlv_crowd_release((RlvCrowd){id}); }
static RlvResult add(uint64_t id) { return rlv_crowd_add((RlvCrowd){id}, &AHEAD, 1, 0, NULL); }
static RlvResult set(uint64_t id) { return rlv_crowd_set((RlvCrowd){id}, 0, &AHEAD, 1, 0); }
static RlvResult weigh(uint64_t id) { return rlv_crowd_set_weights((RlvCrowd){id}, 0, NULL, 0); }
static RlvResult get(uint64_t id) { RlvCrowdBuffers out = RLV_CROWD_BUFFERS_INIT; return rlv_crowd_get((RlvCrowd){id}, &out); }
static RlvResult impostors(uint64_t id) { RlvCrowdImpostors out = RLV_CROWD_IMPOSTORS_INIT; return rlv_crowd_get_impostors((RlvCrowd){id}, &out); }
static RlvResult create_there(uint64_t id) { RlvDeviceCrowd out; return rlv_device_crowd_create((RlvCrowd){id}, &out); }
static RlvResult retain_there(uint64_t id) { return rlv_device_crowd_retain((RlvDeviceCrowd){id}); }
static RlvResult release_there(uint64_t id) { return rlv_device_crowd_release((RlvDeviceCrowd){id}); }
static RlvResult get_there(uint64_t id) { RlvCrowdBuffers out = RLV_CROWD_BUFFERS_INIT; return rlv_device_crowd_get((RlvDeviceCrowd){id}, &out); }
static RlvResult impostors_there(uint64_t id) { RlvCrowdImpostors out = RLV_CROWD_IMPOSTORS_INIT; return rlv_device_crowd_get_impostors((RlvDeviceCrowd){id}, &out); }
static RlvResult vulkan(uint64_t id) { RlvDeviceCrowdVulkan out = RLV_DEVICE_CROWD_VULKAN_INIT; return rlv_device_crowd_vulkan((RlvDeviceCrowd){id}, &out); }
static RlvResult job_build(uint64_t id) { RlvJob out; return rlv_job_crowd((RlvContext){id}, PATH, NULL, 0, NULL, &out); }
static RlvResult job_refit(uint64_t id) { RlvJob out; return rlv_job_crowd_refit((RlvCrowdModel){id}, PATH, NULL, 0, NULL, &out); }
static RlvResult job_blend(uint64_t id) { RlvJob out; return rlv_job_crowd_model_with_blend((RlvCrowdModel){id}, RLV_CROWD_BLEND_LINEAR, &out); }
static RlvResult job_read(uint64_t id) { RlvJob out; return rlv_job_crowd_model_read((RlvContext){id}, PATH, &out); }
static RlvResult job_write(uint64_t id) { RlvJob out; return rlv_job_crowd_model_write((RlvCrowdModel){id}, "crowd_garbage.rcrowd", &out); }
static RlvResult job_model(uint64_t id) { RlvCrowdModel out; return rlv_job_crowd_model((RlvJob){id}, &out); }
static RlvResult job_report(uint64_t id) { RlvCrowdRefitReport out = RLV_CROWD_REFIT_REPORT_INIT; return rlv_job_crowd_refit_report((RlvJob){id}, &out); }

static RlvCrowdView view_of(void) {
    RlvCrowdView view = RLV_CROWD_VIEW_INIT;
    view.width = view.height = 64;
    return view;
}

static RlvResult cut(uint64_t id) { const RlvCrowdView view = view_of(); return rlv_crowd_cut((RlvCrowd){id}, &view, NULL); }
static RlvResult cut_there(uint64_t id) { const RlvCrowdView view = view_of(); return rlv_device_crowd_cut((RlvDeviceCrowd){id}, &view, NULL); }

/* The nouns whose handles a function takes. */
enum { CONTEXT, JOB, MODEL, CROWD, ON_DEVICE, NOUNS };

static const HandleFunction FUNCTIONS[] = {
    {build_model, CONTEXT},    {refit, MODEL},              {read_model, CONTEXT},     {write_model, MODEL},
    {read_bytes, CONTEXT},     {write_bytes, MODEL},        {retain_model, MODEL},     {release_model, MODEL},
    {model_info, MODEL},       {model_clip, MODEL},         {material, MODEL},         {vertices, MODEL},
    {collapses, MODEL},        {offsets, MODEL},            {triangles, MODEL},        {clusters, MODEL},
    {model_mesh, MODEL},       {create_of, MODEL},          {retain, CROWD},           {release, CROWD},
    {add, CROWD},              {set, CROWD},                {weigh, CROWD},            {cut, CROWD},
    {get, CROWD},              {impostors, CROWD},          {create_there, CROWD},     {retain_there, ON_DEVICE},
    {release_there, ON_DEVICE}, {cut_there, ON_DEVICE},     {get_there, ON_DEVICE},    {impostors_there, ON_DEVICE},
    {vulkan, ON_DEVICE},       {job_build, CONTEXT},        {job_refit, MODEL},        {job_read, CONTEXT},
    {job_write, MODEL},        {job_model, JOB},            {job_report, JOB},         {blend_model, MODEL},
    {job_blend, MODEL},
};

typedef struct Objects {
    RlvCrowdModel model;
    RlvCrowd crowd;
    RlvJob job;
} Objects;

static Objects make(RlvContext context) {
    Objects made = {RLV_NULL, RLV_NULL, RLV_NULL};
    RlvCrowdBuildSettings settings = RLV_CROWD_BUILD_SETTINGS_INIT;
    const RlvCrowdAgent agents[AGENTS] = {AHEAD, AHEAD, AHEAD};
    settings.cluster_triangles = 40;
    CHECK_OK(rlv_crowd_model_build(context, PATH, NULL, 0, &settings, NULL, NULL, &made.model));
    CHECK_OK(rlv_crowd_create(context, &made.model, 1, &made.crowd));
    CHECK_OK(rlv_crowd_add(made.crowd, agents, AGENTS, 0, NULL));
    CHECK_OK(rlv_job_crowd_refit(made.model, PATH, NULL, 0, &settings, &made.job));
    CHECK_OK(rlv_job_wait(made.job, -1.0, NULL));
    return made;
}

static void drop(Objects objects) {
    CHECK_OK(rlv_job_release(objects.job));
    CHECK_OK(rlv_crowd_release(objects.crowd));
    CHECK_OK(rlv_crowd_model_release(objects.model));
}

static void check_handles(RlvContext context, Objects objects) {
    const Objects dead = make(context);
    drop(dead);
    /* What is on a device is the business of c_device_crowd. */
    const uint64_t alive[NOUNS] = {context.id, objects.job.id, objects.model.id, objects.crowd.id, 0};
    const uint64_t others[] = {0, 1, UINT64_MAX, dead.model.id, dead.crowd.id, dead.job.id, objects.model.id ^ (UINT64_C(1) << 40),
                               objects.crowd.id + 1};
    for (size_t k = 0; k < sizeof FUNCTIONS / sizeof *FUNCTIONS; ++k) {
        check_handle_function(FUNCTIONS[k], alive, NOUNS, others, sizeof others / sizeof *others);
    }
}

static void check_null(RlvContext context, Objects objects) {
    const RlvCrowdModel model = objects.model;
    const RlvCrowd crowd = objects.crowd;
    const RlvCrowdClipName none = {NULL}, wild = {"\xff"};
    RlvCrowdBuffers room = RLV_CROWD_BUFFERS_INIT;
    RlvCrowdImpostors squares = RLV_CROWD_IMPOSTORS_INIT;
    RlvCrowdModel made = {77};
    RlvCrowd other = {77};
    RlvDeviceCrowd there = {77};
    RlvJob job = {77};
    const RlvParameter *params;
    size_t count;
    CHECK(rlv_crowd_params(NULL, &count) == RLV_ERROR_INVALID && rlv_crowd_params(&params, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_build(context, "\xff", NULL, 0, NULL, NULL, NULL, &made) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_build(context, PATH, &wild, 1, NULL, NULL, NULL, &made) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_refit(model, PATH, &none, 1, NULL, NULL, NULL, NULL, &made) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_refit(model, PATH, NULL, SIZE_MAX, NULL, NULL, NULL, NULL, &made) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_refit(model, PATH, NULL, 0, NULL, NULL, NULL, NULL, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_read(context, NULL, &made) == RLV_ERROR_INVALID && rlv_crowd_model_read(context, PATH, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_write(model, NULL) == RLV_ERROR_INVALID && rlv_crowd_model_write_bytes(model, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_read_bytes(context, NULL, 0, &made) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_read_bytes(context, NULL, SIZE_MAX, &made) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_info(model, NULL) == RLV_ERROR_INVALID && rlv_crowd_model_clip(model, 0, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_material(model, 0, NULL) == RLV_ERROR_INVALID && rlv_crowd_model_get_vertices(model, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_get_collapses(model, NULL, POINTS, 0) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_get_collapses(model, &(RlvCrowdCollapse){0, 0}, 1, 3) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_get_clusters(model, NULL, SIZE_MAX, 0) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_mesh(model, 0.0f, 0, 0, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_model_mesh(model, 0.0f, UINT32_MAX, 0, &(RlvMesh){0}) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_create(context, NULL, 1, &other) == RLV_ERROR_INVALID && rlv_crowd_create(context, &model, 0, &other) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_create(context, &model, 1, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_create(context, NULL, SIZE_MAX, &other) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_add(crowd, NULL, 1, 0, NULL) == RLV_ERROR_INVALID && rlv_crowd_set(crowd, 0, NULL, 1, 0) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_add(crowd, &AHEAD, 1, 3, NULL) == RLV_ERROR_INVALID && rlv_crowd_add(crowd, &AHEAD, SIZE_MAX, 0, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_set(crowd, UINT32_MAX, &AHEAD, 1, 0) == RLV_ERROR_INVALID && rlv_crowd_set(crowd, 0, &AHEAD, SIZE_MAX, 0) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_set_weights(crowd, 0, NULL, SIZE_MAX) == RLV_ERROR_INVALID && rlv_crowd_set_weights(crowd, AGENTS, NULL, 0) == RLV_ERROR_INVALID);
    CHECK(rlv_crowd_cut(crowd, NULL, NULL) == RLV_ERROR_INVALID);
    CHECK_OK(cut(crowd.id));
    CHECK(rlv_crowd_get(crowd, NULL) == RLV_ERROR_INVALID && rlv_crowd_get_impostors(crowd, NULL) == RLV_ERROR_INVALID);
    /* Nothing wanted is nothing written; and no array is as long as memory. */
    CHECK_OK(rlv_crowd_get(crowd, &room));
    CHECK_OK(rlv_crowd_get_impostors(crowd, &squares));
    room.draws = &(RlvCrowdDraw){0, 0, 0, 0, 0};
    room.draw_capacity = SIZE_MAX;
    squares.pictures = &(RlvCrowdPicture){0, 0, 0.0f, {0.0f}, {0.0f}};
    squares.picture_capacity = SIZE_MAX;
    CHECK(rlv_crowd_get(crowd, &room) == RLV_ERROR_INVALID && rlv_crowd_get_impostors(crowd, &squares) == RLV_ERROR_INVALID);
    /* The context has no device. */
    CHECK(rlv_device_crowd_create(crowd, &there) == RLV_ERROR_UNSUPPORTED && rlv_device_crowd_create(crowd, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_job_crowd(context, NULL, NULL, 0, NULL, &job) == RLV_ERROR_INVALID && rlv_job_crowd(context, PATH, NULL, 0, NULL, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_job_crowd_refit(model, NULL, NULL, 0, NULL, &job) == RLV_ERROR_INVALID);
    CHECK(rlv_job_crowd_refit(model, PATH, NULL, 0, NULL, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_job_crowd_refit(model, PATH, &wild, 1, NULL, &job) == RLV_ERROR_INVALID);
    CHECK(rlv_job_crowd_model(objects.job, NULL) == RLV_ERROR_INVALID && rlv_job_crowd_refit_report(objects.job, NULL) == RLV_ERROR_INVALID);
    CHECK(made.id == 77 && other.id == 77 && there.id == 77 && job.id == 77);
}

static void check_sizes(RlvContext context, Objects objects) {
    const uint32_t wrong[] = {0, 3, 65537, UINT32_MAX};
    CHECK_OK(cut(objects.crowd.id));
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k) {
        RlvCrowdBuildSettings settings = RLV_CROWD_BUILD_SETTINGS_INIT;
        RlvCrowdRefitReport report = RLV_CROWD_REFIT_REPORT_INIT;
        RlvCrowdModelInfo info = RLV_CROWD_MODEL_INFO_INIT;
        RlvCrowdClip clip = RLV_CROWD_CLIP_INIT;
        RlvCrowdVertices arrays = RLV_CROWD_VERTICES_INIT;
        RlvCrowdView view = view_of(), usual = view_of();
        RlvCrowdFrame frame = RLV_CROWD_FRAME_INIT;
        RlvCrowdBuffers room = RLV_CROWD_BUFFERS_INIT;
        RlvCrowdImpostors squares = RLV_CROWD_IMPOSTORS_INIT;
        RlvCrowdModel made = RLV_NULL;
        RlvJob job = RLV_NULL;
        settings.struct_size = report.struct_size = info.struct_size = clip.struct_size = arrays.struct_size = wrong[k];
        view.struct_size = frame.struct_size = room.struct_size = squares.struct_size = wrong[k];
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_build(context, PATH, NULL, 0, &settings, NULL, NULL, &made), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_refit(objects.model, PATH, NULL, 0, &settings, NULL, NULL, NULL, &made), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_refit(objects.model, PATH, NULL, 0, NULL, NULL, NULL, &report, &made), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_crowd(context, PATH, NULL, 0, &settings, &job), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_crowd_refit(objects.model, PATH, NULL, 0, &settings, &job), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_crowd_refit_report(objects.job, &report), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_info(objects.model, &info), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_clip(objects.model, 0, &clip), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_get_vertices(objects.model, &arrays), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get(objects.crowd, &room), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get_impostors(objects.crowd, &squares), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(objects.crowd, &view, NULL), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(objects.crowd, &usual, &frame), "struct_size");
        CHECK(made.id == 0 && job.id == 0);
    }
}

/* The view is cut or refused, and what it draws is finite. */
static void check_bounded(RlvCrowd crowd, const RlvCrowdView *view, RlvResult wanted) {
    static RlvCrowdInstance instances[AGENTS];
    static float matrices[MOST][12], blends[MOST];
    RlvCrowdFrame frame = RLV_CROWD_FRAME_INIT;
    RlvCrowdBuffers room = RLV_CROWD_BUFFERS_INIT;
    const RlvResult result = rlv_crowd_cut(crowd, view, &frame);
    CHECK(result == wanted && (result == RLV_OK || rlv_error_last()[0] != 0));
    if (result != RLV_OK) {
        CHECK(frame.agent_count == 0);
        return;
    }
    CHECK(frame.agent_count <= AGENTS && frame.matrix_count <= MOST && frame.draw_count <= MOST);
    room.instances = instances;
    room.instance_capacity = AGENTS;
    room.matrices = matrices[0];
    room.matrix_capacity = MOST;
    room.blends = blends;
    room.draw_capacity = MOST;
    CHECK_OK(rlv_crowd_get(crowd, &room));
    for (uint32_t k = 0; k < frame.matrix_count; ++k) {
        CHECK(isfinite(matrices[k][0]) && isfinite(matrices[k][11]));
    }
    for (uint32_t k = 0; k < frame.draw_count; ++k) {
        CHECK(blends[k] >= 0.0f && blends[k] <= 1.0f);
    }
}

static void check_numbers(RlvContext context, Objects objects) {
    const double none[] = {NAN, INFINITY, -INFINITY};
    const RlvCrowd crowd = objects.crowd;
    for (int k = 0; k < 3; ++k) {
        RlvCrowdAgent agent = AHEAD;
        RlvCrowdBuildSettings settings = RLV_CROWD_BUILD_SETTINGS_INIT;
        RlvCrowdModel made = RLV_NULL;
        const float weight = (float)none[k];
        uint32_t first = 77;
        agent.phase = none[k];
        CHECK(rlv_crowd_add(crowd, &agent, 1, 0, &first) == RLV_ERROR_INVALID && rlv_crowd_set(crowd, 0, &agent, 1, 0) == RLV_ERROR_INVALID);
        for (int at = 0; at < 12; ++at) {
            agent = AHEAD;
            agent.transform[at] = none[k];
            CHECK(rlv_crowd_add(crowd, &agent, 1, 0, &first) == RLV_ERROR_INVALID);
        }
        CHECK(rlv_crowd_set_weights(crowd, 0, &weight, 1) == RLV_ERROR_INVALID && first == 77);
        settings.pose_rate = weight;
        CHECK(rlv_crowd_model_build(context, PATH, NULL, 0, &settings, NULL, NULL, &made) == RLV_ERROR_INVALID);
        CHECK(rlv_crowd_model_refit(objects.model, PATH, NULL, 0, &settings, NULL, NULL, NULL, &made) == RLV_ERROR_INVALID);
        CHECK(rlv_crowd_model_mesh(objects.model, k == 1 ? NAN : -INFINITY, 0, 0, &(RlvMesh){0}) == RLV_ERROR_INVALID && made.id == 0);

        double *places[5];
        RlvCrowdView view = view_of();
        places[0] = &view.eye[1], places[1] = &view.target[2], places[2] = &view.up[0], places[3] = &view.fov, places[4] = &view.time;
        for (int at = 0; at < 5; ++at) {
            const double before = *places[at];
            *places[at] = none[k];
            check_bounded(crowd, &view, RLV_ERROR_INVALID);
            *places[at] = before;
        }
        view.tolerance = weight;
        check_bounded(crowd, &view, RLV_ERROR_INVALID);
    }
    RlvCrowdAgent flat = AHEAD;
    flat.transform[0] = 0.0;
    CHECK(rlv_crowd_add(crowd, &flat, 1, 0, NULL) == RLV_ERROR_INVALID);
    RlvCrowdView view = view_of();
    view.tolerance = 0.0f;
    check_bounded(crowd, &view, RLV_ERROR_INVALID);
    view = view_of(), view.up[1] = 0.0;
    check_bounded(crowd, &view, RLV_ERROR_INVALID);
    view = view_of(), view.target[2] = 0.0;
    check_bounded(crowd, &view, RLV_ERROR_INVALID);
    view = view_of(), view.fov = 0.0;
    check_bounded(crowd, &view, RLV_ERROR_INVALID);
    view = view_of(), view.width = 0;
    check_bounded(crowd, &view, RLV_ERROR_INVALID);
    view = view_of(), view.occlusion = UINT32_MAX;
    check_bounded(crowd, &view, RLV_ERROR_INVALID);
    view = view_of(), view.width = view.height = UINT32_MAX, view.occlusion = 1;
    check_bounded(crowd, &view, RLV_ERROR_INVALID);
    /* Pictures of any size without culling by occlusion, and any time. */
    view.occlusion = 0;
    check_bounded(crowd, &view, RLV_OK);
    view = view_of(), view.time = 1e300;
    check_bounded(crowd, &view, RLV_OK);
    view = view_of(), view.tolerance = 1e-30f, view.geomorph = 1;
    check_bounded(crowd, &view, RLV_OK);
    view = view_of(), view.tolerance = 1e30f, view.geomorph = view.impostors = view.occlusion = 1;
    check_bounded(crowd, &view, RLV_OK);
    view = view_of(), view.eye[2] = 1e30;
    check_bounded(crowd, &view, RLV_OK);
}

/* Cuts and moves agents as if it were alone. */
static void *change(void *user) {
    const Objects *objects = user;
    for (int round = 0; round < ROUNDS; ++round) {
        const RlvCrowdView view = view_of();
        RlvCrowdBuffers room = RLV_CROWD_BUFFERS_INIT;
        const RlvResult results[4] = {rlv_crowd_set(objects->crowd, 1, &AHEAD, 1, 0), rlv_crowd_set_weights(objects->crowd, 1, NULL, 0),
                                      rlv_crowd_cut(objects->crowd, &view, NULL), rlv_crowd_get(objects->crowd, &room)};
        for (int k = 0; k < 4; ++k) {
            CHECK(results[k] == RLV_OK || results[k] == RLV_ERROR_BUSY || (k == 3 && results[k] == RLV_ERROR_INVALID));
        }
    }
    return NULL;
}

/* Reads the model meanwhile. */
static void *look(void *user) {
    const Objects *objects = user;
    for (int round = 0; round < ROUNDS; ++round) {
        RlvMesh mesh = RLV_NULL;
        RlvCrowdModel made = RLV_NULL;
        CHECK_OK(rlv_crowd_model_mesh(objects->model, 0.01f, 0, 0, &mesh));
        CHECK_OK(rlv_mesh_release(mesh));
        if (round % 4 == 0) {
            CHECK_OK(rlv_crowd_model_refit(objects->model, PATH, NULL, 0, NULL, NULL, NULL, NULL, &made));
            CHECK_OK(rlv_crowd_model_release(made));
        }
    }
    return NULL;
}

static void check_threads(Objects objects) {
    pthread_t threads[4];
    for (int k = 0; k < 4; ++k) {
        CHECK(pthread_create(&threads[k], NULL, k < 2 ? change : look, &objects) == 0);
    }
    for (int k = 0; k < 4; ++k) {
        CHECK(pthread_join(threads[k], NULL) == 0);
    }
    CHECK_OK(cut(objects.crowd.id));
}

int main(void) {
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    options.threads = 2;
    CHECK_OK(rlv_context_create(&options, &known));
    check_write_bumps(PATH, SIDE);
    const Objects objects = make(known);
    check_handles(known, objects);
    check_null(known, objects);
    check_sizes(known, objects);
    check_numbers(known, objects);
    check_threads(objects);
    drop(objects);
    CHECK(remove(PATH) == 0);
    CHECK_OK(rlv_context_release(known));
    return 0;
}
