/* Crowd streams: a crowd whose clusters are read by its cuts draws what a whole one draws once they are there; an index buffer
 * that mirrors the slots has the triangles of all draws; and what is refused. */
#include "bumps.h"

enum { SIDE = 25, POINTS = SIDE * SIDE, AGENTS = 12, MOST = 4096, ROOM = 1 << 16 };

static RlvCrowdDraw draws[MOST];
static uint32_t clusters[MOST][2], mirror[ROOM][3], triangles[ROOM][3], materials[ROOM];
static RlvCrowdStreamCluster read_clusters[MOST];

/* A bumpy sheet of two triangles a square, as OBJ, built and written. */
static RlvCrowdModel make(RlvContext context, const char *path) {
    RlvCrowdBuildSettings settings = RLV_CROWD_BUILD_SETTINGS_INIT;
    RlvCrowdModel model = RLV_NULL;
    check_write_bumps("crowd_stream.obj", SIDE);
    settings.cluster_triangles = 40;
    CHECK_OK(rlv_crowd_model_build(context, "crowd_stream.obj", NULL, 0, &settings, NULL, NULL, &model));
    CHECK_OK(rlv_crowd_model_write(model, path));
    return model;
}

static void place(RlvCrowd crowd) {
    static RlvCrowdAgent agents[AGENTS];
    for (int at = 0; at < AGENTS; ++at) {
        agents[at].transform[0] = agents[at].transform[4] = agents[at].transform[8] = 1.0;
        agents[at].transform[9] = 5.0 * (at % 4) - 10.0;
        agents[at].transform[10] = -2.0;
        agents[at].transform[11] = -6.0 - 20.0 * (at / 4);
    }
    CHECK_OK(rlv_crowd_add(crowd, agents, AGENTS, 0, NULL));
}

static RlvCrowdView view_of(float tolerance) {
    RlvCrowdView view = RLV_CROWD_VIEW_INIT;
    view.width = 1280;
    view.height = 720;
    view.tolerance = tolerance;
    return view;
}

/* Copies the clusters that were read into the index buffer. Returns how many there were. */
static uint32_t copy(RlvCrowd crowd) {
    RlvCrowdStreamInfo info = RLV_CROWD_STREAM_INFO_INIT;
    CHECK_OK(rlv_crowd_stream_info(crowd, &info));
    CHECK(info.slot_count * info.slot_triangles <= ROOM && info.read <= MOST && info.resident <= info.slot_count);
    CHECK_OK(rlv_crowd_stream_get_read(crowd, read_clusters, MOST, 0));
    for (uint32_t at = 0; at < info.read; ++at) {
        const RlvCrowdStreamCluster *found = &read_clusters[at];
        CHECK(found->triangle_count <= info.slot_triangles);
        CHECK_OK(rlv_crowd_stream_get_triangles(crowd, found->slot, mirror[found->slot * info.slot_triangles], materials,
                                                info.slot_triangles));
    }
    return info.read;
}

/* Cuts, mirrors, and checks that the draws have the triangles of their clusters. */
static RlvCrowdFrame draw(RlvCrowd crowd, RlvCrowdModel whole, const RlvCrowdView *view) {
    RlvCrowdFrame frame = RLV_CROWD_FRAME_INIT;
    RlvCrowdBuffers buffers = RLV_CROWD_BUFFERS_INIT;
    RlvCrowdModelInfo info = RLV_CROWD_MODEL_INFO_INIT;
    static RlvCrowdCluster all[MOST];
    CHECK_OK(rlv_crowd_cut(crowd, view, &frame));
    copy(crowd);
    buffers.draws = draws;
    buffers.clusters = clusters[0];
    buffers.draw_capacity = MOST;
    CHECK_OK(rlv_crowd_get(crowd, &buffers));
    CHECK_OK(rlv_crowd_model_info(whole, &info));
    CHECK(info.triangle_count <= ROOM && info.cluster_count <= MOST);
    CHECK_OK(rlv_crowd_model_get_triangles(whole, triangles[0], NULL, ROOM));
    CHECK_OK(rlv_crowd_model_get_clusters(whole, all, MOST, 0));
    uint64_t count = 0;
    for (uint32_t at = 0; at < frame.draw_count; ++at) {
        const RlvCrowdCluster *cluster = &all[clusters[at][1]];
        CHECK(draws[at].index_count == 3 * cluster->triangle_count);
        CHECK(memcmp(&mirror[0][0] + draws[at].first_index, triangles[cluster->first_triangle], 12 * cluster->triangle_count) == 0);
        count += (uint64_t)cluster->triangle_count * draws[at].instance_count;
    }
    CHECK(count == frame.triangles && frame.agent_count > 0);
    return frame;
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvCrowd crowd = RLV_NULL, whole = RLV_NULL;
    RlvCrowdModel model = RLV_NULL, streamed = RLV_NULL;
    RlvCrowdFrame goal = RLV_CROWD_FRAME_INIT, frame;
    RlvCrowdStreamInfo info = RLV_CROWD_STREAM_INFO_INIT;
    RlvCrowdStreamSettings settings = RLV_CROWD_STREAM_SETTINGS_INIT;
    const RlvCrowdStreamFile file = {"crowd_stream.rcrowd"}, absent = {"crowd_stream.absent"}, none = {NULL};
    CHECK_OK(rlv_context_create(NULL, &context));
    model = make(context, file.path);
    CHECK_OK(rlv_crowd_create(context, &model, 1, &whole));
    place(whole);
    const RlvCrowdView fine = view_of(0.25f), coarse = view_of(20.0f);
    CHECK_OK(rlv_crowd_cut(whole, &fine, &goal));

    settings.most_read = 8;
    CHECK_OK(rlv_crowd_stream_open(context, &file, 1, &settings, &crowd));
    CHECK(copy(crowd) > 0);
    place(crowd);
    /* What is drawn becomes finer until it is the cut. */
    uint64_t before = 0;
    int frames = 0;
    do {
        frame = draw(crowd, model, &fine);
        CHECK_OK(rlv_crowd_stream_info(crowd, &info));
        CHECK(info.read <= 8 && info.wanted_triangles == goal.triangles && frame.triangles >= before);
        before = frame.triangles;
    } while (info.missing > 0 && ++frames < 1000);
    CHECK(frames > 3 && frames < 1000 && frame.triangles == goal.triangles && frame.draw_count == goal.draw_count);
    draw(crowd, model, &coarse);

    /* The model has vertices, but no triangles. */
    CHECK_OK(rlv_crowd_stream_model(crowd, 0, &streamed));
    RlvCrowdVertices vertices = RLV_CROWD_VERTICES_INIT;
    static float points[POINTS][3], others[POINTS][3];
    RlvCrowdModelInfo size = RLV_CROWD_MODEL_INFO_INIT;
    CHECK_OK(rlv_crowd_model_info(streamed, &size));
    CHECK(size.vertex_count <= POINTS);
    vertices.capacity = POINTS;
    vertices.points = points[0];
    CHECK_OK(rlv_crowd_model_get_vertices(streamed, &vertices));
    vertices.points = others[0];
    CHECK_OK(rlv_crowd_model_get_vertices(model, &vertices));
    CHECK(memcmp(points, others, sizeof points) == 0);
    RlvMesh mesh = RLV_NULL;
    RlvBytes bytes;
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_crowd_model_get_triangles(streamed, triangles[0], NULL, ROOM), "read while");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_crowd_model_write(streamed, "crowd_stream.none"), "read while");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_crowd_model_write_bytes(streamed, &bytes), "read while");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_crowd_model_mesh(streamed, 0.0f, 0, 0, &mesh), "read while");
    RlvCrowd other = RLV_NULL;
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_crowd_create(context, &streamed, 1, &other), "read while");
    CHECK_OK(rlv_crowd_model_release(streamed));

    /* A small budget is held, and draws less. */
    CHECK_OK(rlv_crowd_release(crowd));
    settings.budget = 16 * 500;
    settings.most_read = UINT32_MAX;
    CHECK_OK(rlv_crowd_stream_open(context, &file, 1, &settings, &crowd));
    copy(crowd);
    place(crowd);
    frame = draw(crowd, model, &fine);
    CHECK_OK(rlv_crowd_stream_info(crowd, &info));
    CHECK(info.slot_count * info.slot_triangles <= 500 && info.missing > 0 && frame.triangles < goal.triangles);

    /* What is refused. */
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_crowd_stream_open(context, &absent, 1, NULL, &other), absent.path);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_stream_open(context, &none, 1, NULL, &other), "files");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_stream_open(context, &file, 0, NULL, &other), "model");
    settings.budget = 16;
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_crowd_stream_open(context, &file, 1, &settings, &other), "budget");
    settings.budget = 1 << 20;
    settings.most_read = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_stream_open(context, &file, 1, &settings, &other), "one at least");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_stream_info(whole, &info), "no stream");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_stream_model(crowd, 1, &streamed), "model 1");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_stream_get_triangles(crowd, UINT32_MAX, triangles[0], NULL, ROOM), "slot");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_stream_get_triangles(crowd, 0, triangles[0], NULL, 0), "triangles");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_stream_get_read(crowd, read_clusters, 0, 0), "clusters");
    CHECK_OK(rlv_crowd_release(crowd));
    CHECK_OK(rlv_crowd_release(whole));
    CHECK_OK(rlv_crowd_model_release(model));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
