/* Crowds: a bending arm is built, as a call and as a job, written and read, its clusters and poses are taken out, and
 * agents are placed, moved and cut into draws; and what is refused. */
#include "bumps.h"

#include <stddef.h>

enum { RINGS = 25, SIDES = 16, POINTS = RINGS * SIDES, TRIANGLES = 2 * (RINGS - 1) * SIDES, AGENTS = 9 };

static uint32_t cancel(void *user, float fraction, const char *stage) {
    (void)fraction;
    (void)stage;
    return --*(int *)user < 0 ? RLV_PROGRESS_CANCEL : RLV_PROGRESS_CONTINUE;
}

/* A tube along y from -1 to 1 whose upper half turns about z by 90 degrees within a second, while a morph target makes it
 * wider by half, as glTF. Its radius has waves of a height. */
static void write_arm(double wave) {
    static float positions[POINTS][3], offsets[POINTS][3], weights[POINTS][4];
    static uint16_t joints[POINTS][4];
    static uint32_t indices[TRIANGLES][3];
    const float times[2] = {0.0f, 1.0f}, shares[2] = {0.0f, 1.0f}, turns[2][4] = {{0, 0, 0, 1}, {0, 0, 0.70710678f, 0.70710678f}};
    for (int ring = 0; ring < RINGS; ++ring) {
        for (int side = 0; side < SIDES; ++side) {
            const int point = ring * SIDES + side;
            const double angle = 6.283185307179586 * side / SIDES, height = -1.0 + 2.0 * ring / (RINGS - 1);
            const double radius = 0.2 + wave * sin(5.0 * angle) * cos(9.0 * height);
            const double share = fmin(fmax(0.5 + 2.5 * height, 0.0), 1.0);
            positions[point][0] = (float)(radius * cos(angle));
            positions[point][1] = (float)height;
            positions[point][2] = (float)(radius * sin(angle));
            offsets[point][0] = 0.5f * positions[point][0];
            offsets[point][2] = 0.5f * positions[point][2];
            joints[point][1] = 1;
            weights[point][0] = (float)(1.0 - share);
            weights[point][1] = (float)share;
        }
    }
    for (uint32_t ring = 0, at = 0; ring < RINGS - 1; ++ring) {
        for (uint32_t side = 0; side < SIDES; ++side, at += 2) {
            const uint32_t next = (side + 1) % SIDES, low = ring * SIDES, high = low + SIDES;
            const uint32_t made[2][3] = {{low + side, high + side, high + next}, {low + side, high + next, low + next}};
            memcpy(indices[at], made, sizeof made);
        }
    }
    FILE *bytes = fopen("crowd_arm.bin", "wb"), *text = fopen("crowd_arm.gltf", "w");
    CHECK(bytes != NULL && text != NULL);
    const struct {
        const void *data;
        size_t size, count;
        int component;
        const char *type, *more;
    } parts[8] = {
        {positions, sizeof positions, POINTS, 5126, "VEC3", ",\"min\":[-0.3,-1,-0.3],\"max\":[0.3,1,0.3]"},
        {joints, sizeof joints, POINTS, 5123, "VEC4", ""},
        {weights, sizeof weights, POINTS, 5126, "VEC4", ""},
        {indices, sizeof indices, 3 * TRIANGLES, 5125, "SCALAR", ""},
        {times, sizeof times, 2, 5126, "SCALAR", ",\"min\":[0],\"max\":[1]"},
        {turns, sizeof turns, 2, 5126, "VEC4", ""},
        {offsets, sizeof offsets, POINTS, 5126, "VEC3", ",\"min\":[-0.2,0,-0.2],\"max\":[0.2,0,0.2]"},
        {shares, sizeof shares, 2, 5126, "SCALAR", ""},
    };
    size_t total = 0;
    for (int part = 0; part < 8; ++part) {
        CHECK(fwrite(parts[part].data, 1, parts[part].size, bytes) == parts[part].size);
        total += parts[part].size;
    }
    fprintf(text,
            "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
            "\"nodes\":[{\"mesh\":0,\"skin\":0},{\"name\":\"lower\",\"children\":[2]},{\"name\":\"upper\"}],"
            "\"skins\":[{\"joints\":[1,2]}],"
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":1,\"WEIGHTS_0\":2},\"indices\":3,"
            "\"targets\":[{\"POSITION\":6}]}]}],"
            "\"animations\":[{\"name\":\"bend\",\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"rotation\"}},"
            "{\"sampler\":1,\"target\":{\"node\":0,\"path\":\"weights\"}}],"
            "\"samplers\":[{\"input\":4,\"output\":5},{\"input\":4,\"output\":7}]}],"
            "\"buffers\":[{\"uri\":\"crowd_arm.bin\",\"byteLength\":%u}],\"bufferViews\":[",
            (unsigned)total);
    total = 0;
    for (int part = 0; part < 8; ++part) {
        fprintf(text, "%s{\"buffer\":0,\"byteOffset\":%u,\"byteLength\":%u}", part ? "," : "", (unsigned)total,
                (unsigned)parts[part].size);
        total += parts[part].size;
    }
    fprintf(text, "],\"accessors\":[");
    for (int part = 0; part < 8; ++part) {
        fprintf(text, "%s{\"bufferView\":%d,\"componentType\":%d,\"count\":%u,\"type\":\"%s\"%s}", part ? "," : "", part,
                parts[part].component, (unsigned)parts[part].count, parts[part].type, parts[part].more);
    }
    fprintf(text, "]}\n");
    CHECK(fclose(bytes) == 0 && fclose(text) == 0);
}

static RlvCrowdModel build(RlvContext context) {
    RlvCrowdBuildSettings settings = RLV_CROWD_BUILD_SETTINGS_INIT;
    const RlvCrowdClipName clip = {"bend"};
    RlvCrowdModel model = RLV_NULL;
    int calls = 1 << 20;
    settings.cluster_triangles = 40;
    settings.pose_rate = 6.0f;
    CHECK_OK(rlv_crowd_model_build(context, "crowd_arm.gltf", &clip, 1, &settings, cancel, &calls, &model));
    CHECK(calls < 1 << 20);
    return model;
}

/* The same counts from a call, a job and a file. */
static void check_models(RlvContext context, RlvCrowdModel model) {
    RlvCrowdBuildSettings settings = RLV_CROWD_BUILD_SETTINGS_INIT;
    RlvCrowdModelInfo info = RLV_CROWD_MODEL_INFO_INIT, other = RLV_CROWD_MODEL_INFO_INIT;
    RlvCrowdClip clip = RLV_CROWD_CLIP_INIT;
    RlvCrowdModel again = RLV_NULL;
    RlvJob job = RLV_NULL;
    CHECK_OK(rlv_crowd_model_info(model, &info));
    CHECK(info.input_triangles == TRIANGLES && info.vertex_count == POINTS && info.bone_count == 2);
    CHECK(info.clip_count == 1 && info.pose_count == 6 && info.representatives >= 1 && info.representatives <= 6);
    CHECK(info.cluster_count > info.group_count && info.triangle_count > info.input_triangles);
    CHECK(info.largest_error > 0.0f && info.measured == (uint64_t)info.group_count * 6);
    CHECK(info.low[0] < -0.9f && info.high[1] > 0.9f);
    CHECK_OK(rlv_crowd_model_clip(model, 0, &clip));
    CHECK(strcmp(clip.name, "bend") == 0 && clip.pose_count == 6 && clip.rate == 6.0f);

    settings.cluster_triangles = 40;
    settings.pose_rate = 6.0f;
    CHECK_OK(rlv_job_crowd(context, "crowd_arm.gltf", NULL, 0, &settings, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_crowd_model(job, &again));
    CHECK_OK(rlv_crowd_model_info(again, &other));
    CHECK(memcmp(&info, &other, sizeof info) == 0);
    CHECK_OK(rlv_job_release(job));
    check_idle(again.id, "crowd model");
    CHECK_OK(rlv_crowd_model_release(again));

    CHECK_OK(rlv_crowd_model_write(model, "crowd_arm.rcrowd"));
    CHECK_OK(rlv_crowd_model_read(context, "crowd_arm.rcrowd", &again));
    CHECK_OK(rlv_crowd_model_info(again, &other));
    CHECK(memcmp(&info, &other, sizeof info) == 0);
    CHECK_OK(rlv_crowd_model_release(again));

    RlvBytes bytes = RLV_NULL;
    const uint8_t *data = NULL;
    size_t size = 0;
    CHECK_OK(rlv_crowd_model_write_bytes(model, &bytes));
    CHECK_OK(rlv_bytes_get(bytes, &data, &size));
    CHECK_OK(rlv_crowd_model_read_bytes(context, data, size, &again));
    CHECK_OK(rlv_crowd_model_info(again, &other));
    CHECK(memcmp(&info, &other, sizeof info) == 0);
    CHECK_OK(rlv_crowd_model_release(again));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_read_bytes(context, data, size / 2, &again), "bytes");
    CHECK_OK(rlv_bytes_release(bytes));
}

/* A refit of a rougher arm keeps the clusters, and needs a new build; one of the same file, as a job, changes nothing. */
static void check_refits(RlvContext context, RlvCrowdModel model) {
    RlvCrowdBuildSettings settings = RLV_CROWD_BUILD_SETTINGS_INIT;
    RlvCrowdModelInfo info = RLV_CROWD_MODEL_INFO_INIT, other = RLV_CROWD_MODEL_INFO_INIT;
    RlvCrowdRefitReport report = RLV_CROWD_REFIT_REPORT_INIT;
    RlvCrowdModel made = RLV_NULL, small = RLV_NULL, untouched = {77};
    RlvJob job = RLV_NULL;
    int calls = 1 << 20;
    /* One pose, which takes less time. */
    settings.pose_rate = 1.0f;
    CHECK_OK(rlv_crowd_model_info(model, &info));
    write_arm(0.05);
    CHECK_OK(rlv_crowd_model_refit(model, "crowd_arm.gltf", NULL, 0, &settings, cancel, &calls, &report, &made));
    write_arm(0.01);
    CHECK(calls < 1 << 20 && report.grown_groups > info.group_count / 2 && report.grown_groups <= info.group_count);
    CHECK(report.growth >= 1.5 && report.is_rebuild_due == 1);
    CHECK_OK(rlv_crowd_model_info(made, &other));
    CHECK(other.cluster_count == info.cluster_count && other.triangle_count == info.triangle_count);
    CHECK(other.pose_count == 1 && info.pose_count == 6);
    CHECK_OK(rlv_crowd_model_release(made));

    FILE *text = fopen("crowd_other.obj", "w");
    CHECK(text != NULL && fputs("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n", text) >= 0);
    CHECK(fclose(text) == 0);
    CHECK_OK(rlv_job_crowd(context, "crowd_other.obj", NULL, 0, NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_crowd_refit_report(job, &report), "was not started for refitting a crowd model");
    CHECK_OK(rlv_job_crowd_model(job, &small));
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_job_crowd_refit(small, "crowd_other.obj", NULL, 0, NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_crowd_refit_report(job, &report));
    CHECK(report.grown_groups == 0 && report.growth == 1.0 && report.is_rebuild_due == 0);
    CHECK_OK(rlv_job_crowd_model(job, &made));
    CHECK_OK(rlv_crowd_model_info(small, &info));
    CHECK_OK(rlv_crowd_model_info(made, &other));
    CHECK(memcmp(&info, &other, sizeof info) == 0 && made.id != small.id);
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_crowd_model_release(made));
    CHECK_OK(rlv_crowd_model_release(small));

    calls = 1;
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_crowd_model_refit(model, "crowd_arm.gltf", NULL, 0, &settings, cancel, &calls, NULL, &untouched), "");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_refit(model, "crowd_other.obj", NULL, 0, NULL, NULL, NULL, NULL, &untouched), "other triangles");
    CHECK(strstr(rlv_error_last(), "rlv_crowd_model_build") != NULL && strstr(rlv_error_last(), "relievo crowd build") != NULL);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_refit(model, NULL, NULL, 0, NULL, NULL, NULL, NULL, &untouched), "path");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_refit(model, "crowd_arm.gltf", NULL, 0, NULL, NULL, NULL, NULL, NULL), "out");
    report.struct_size = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_refit(model, "crowd_arm.gltf", NULL, 0, NULL, NULL, NULL, &report, &untouched), "struct_size");
    CHECK(untouched.id == 77);
}

/* Vertices are those of the file, clusters follow one another, and meshes have the triangles of their clusters. */
static void check_parts(RlvCrowdModel model) {
    RlvCrowdModelInfo info = RLV_CROWD_MODEL_INFO_INIT;
    RlvCrowdVertices vertices = RLV_CROWD_VERTICES_INIT;
    CHECK_OK(rlv_crowd_model_info(model, &info));
    float *points = malloc(POINTS * 12), *weights = malloc(POINTS * 16);
    uint32_t *bones = malloc(POINTS * 16), *triangles = malloc(info.triangle_count * 12);
    uint32_t *materials = malloc(info.triangle_count * 4);
    RlvCrowdCluster *clusters = malloc(info.cluster_count * sizeof *clusters);
    CHECK(points && weights && bones && triangles && materials && clusters);
    vertices.capacity = POINTS;
    vertices.points = points;
    vertices.bones = bones;
    vertices.weights = weights;
    CHECK_OK(rlv_crowd_model_get_vertices(model, &vertices));
    for (size_t point = 0; point < POINTS; ++point) {
        CHECK_NEAR(points[3 * point + 1], -1.0 + 2.0 * (double)(point / SIDES) / (RINGS - 1), 1e-6);
        CHECK(bones[4 * point] < 2 && bones[4 * point + 1] < 2);
        CHECK_NEAR(weights[4 * point] + weights[4 * point + 1], 1.0, 1e-6);
    }
    vertices.capacity = POINTS - 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_get_vertices(model, &vertices), "400");
    vertices.capacity = POINTS;
    vertices.normals = points;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_get_vertices(model, &vertices), "normals");

    CHECK_OK(rlv_crowd_model_get_triangles(model, triangles, materials, info.triangle_count));
    CHECK_OK(rlv_crowd_model_get_clusters(model, clusters, info.cluster_count, 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_get_triangles(model, triangles, NULL, 5), "triangles");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_get_clusters(model, clusters, 1, 0), "clusters");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_get_clusters(model, NULL, 1, 0), "clusters");
    uint32_t next = 0, input = 0;
    for (uint32_t cluster = 0; cluster < info.cluster_count; ++cluster) {
        CHECK(clusters[cluster].first_triangle == next && clusters[cluster].triangle_count <= 40);
        next += clusters[cluster].triangle_count;
        input += clusters[cluster].made_by == UINT32_MAX ? clusters[cluster].triangle_count : 0;
    }
    CHECK(next == info.triangle_count && input == TRIANGLES);
    for (uint32_t corner = 0; corner < 3 * info.triangle_count; ++corner) {
        CHECK(triangles[corner] < POINTS);
    }

    size_t before = (size_t)-1;
    const float errors[4] = {0.0f, 0.02f, 0.06f, 1e9f};
    for (int at = 0; at < 4; ++at) {
        RlvMeshInfo found = RLV_MESH_INFO_INIT;
        RlvMesh mesh = RLV_NULL;
        CHECK_OK(rlv_crowd_model_mesh(model, errors[at], 0, 5, &mesh));
        CHECK_OK(rlv_mesh_info(mesh, &found));
        CHECK(found.triangle_count < before && (at > 0 || found.triangle_count == TRIANGLES));
        CHECK(found.low[0] >= info.low[0] && found.high[1] <= info.high[1] && found.low[0] < -0.5f);
        before = found.triangle_count;
        CHECK_OK(rlv_mesh_release(mesh));
    }
    free(points);
    free(weights);
    free(bones);
    free(triangles);
    free(materials);
    free(clusters);
}

/* Writes where a vertex goes by the formulas of RlvCrowdBlend. rows has the dual rows of a pose. */
static void blended(const float *rows, const uint32_t *bones, const float *weights, const double *place, double *out) {
    double stretch[9] = {0.0}, turn[4] = {0.0}, dual[4] = {0.0}, moved[3] = {0.0}, length = 0.0;
    int most = 0;
    for (int at = 1; at < 4; ++at) {
        most = weights[at] > weights[most] ? at : most;
    }
    const float *first = rows + 20 * bones[most] + 12;
    for (int at = 0; at < 4; ++at) {
        const float *bone = rows + 20 * bones[at], *own = bone + 12;
        const double product = own[0] * first[0] + own[1] * first[1] + own[2] * first[2] + own[3] * first[3];
        for (int k = 0; k < 9; ++k) {
            stretch[k] += weights[at] * bone[4 * (k / 3) + k % 3];
        }
        for (int k = 0; k < 4; ++k) {
            turn[k] += (product < 0.0 ? -weights[at] : weights[at]) * own[k];
            dual[k] += (product < 0.0 ? -weights[at] : weights[at]) * bone[16 + k];
        }
    }
    for (int k = 0; k < 4; ++k) {
        length += turn[k] * turn[k];
    }
    for (int k = 0; k < 4; ++k) {
        turn[k] /= sqrt(length);
        dual[k] /= sqrt(length);
    }
    for (int k = 0; k < 9; ++k) {
        moved[k / 3] += stretch[k] * place[k % 3];
    }
    double side[3], twice[3], shift[3];
    for (int k = 0; k < 3; ++k) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        side[k] = turn[a] * moved[b] - turn[b] * moved[a] + turn[3] * moved[k];
        shift[k] = 2.0 * (turn[3] * dual[k] - dual[3] * turn[k] + turn[a] * dual[b] - turn[b] * dual[a]);
    }
    for (int k = 0; k < 3; ++k) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        twice[k] = 2.0 * (turn[a] * side[b] - turn[b] * side[a]);
        out[k] = moved[k] + twice[k] + shift[k];
    }
}

/* A model whose bones are blended as dual quaternions has larger errors, and a host that poses its vertices by the dual rows
 * of a frame has them where the library has them. */
static void check_blends(RlvContext context, RlvCrowdModel model) {
    const RlvCrowdAgent agent = check_agent(0.0, -8.0);
    const double time = 5.0 / 6.0;
    RlvCrowdModelInfo info = RLV_CROWD_MODEL_INFO_INIT, other = RLV_CROWD_MODEL_INFO_INIT;
    RlvCrowdVertices vertices = RLV_CROWD_VERTICES_INIT;
    RlvCrowdView view = RLV_CROWD_VIEW_INIT;
    RlvCrowdFrame frame = RLV_CROWD_FRAME_INIT;
    RlvCrowdBuffers buffers = RLV_CROWD_BUFFERS_INIT;
    RlvCrowdModel dual = RLV_NULL, again = RLV_NULL;
    RlvCrowd crowd = RLV_NULL;
    RlvMesh mesh = RLV_NULL, linear = RLV_NULL;
    RlvJob job = RLV_NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_with_blend(model, 2, &dual), "blend");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_with_blend(model, 1, NULL), "out");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_crowd_model_with_blend(model, 2, &job), "blend");
    CHECK(dual.id == 0 && job.id == 0);
    CHECK_OK(rlv_job_crowd_model_with_blend(model, RLV_CROWD_BLEND_DUAL_QUATERNION, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_crowd_model(job, &dual));
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_crowd_model_info(model, &info));
    CHECK_OK(rlv_crowd_model_info(dual, &other));
    CHECK(info.blend == RLV_CROWD_BLEND_LINEAR && other.blend == RLV_CROWD_BLEND_DUAL_QUATERNION);
    CHECK(other.largest_error > info.largest_error && other.triangle_count == info.triangle_count);
    /* Errors hold for both ways from then on. A host with an older header gets no blend. */
    CHECK_OK(rlv_crowd_model_with_blend(dual, RLV_CROWD_BLEND_LINEAR, &again));
    CHECK_OK(rlv_crowd_model_info(again, &info));
    CHECK(info.blend == RLV_CROWD_BLEND_LINEAR && info.largest_error == other.largest_error);
    info.struct_size = offsetof(RlvCrowdModelInfo, blend);
    info.blend = 77;
    CHECK_OK(rlv_crowd_model_info(dual, &info));
    CHECK(info.blend == 77);
    CHECK_OK(rlv_crowd_model_release(again));

    CHECK_OK(rlv_crowd_create(context, &dual, 1, &crowd));
    CHECK_OK(rlv_crowd_add(crowd, &agent, 1, 0, NULL));
    view.width = 320;
    view.height = 240;
    view.time = time;
    CHECK_OK(rlv_crowd_cut(crowd, &view, &frame));
    CHECK(frame.matrix_count == 2);
    float rows[2][20], matrices[2][12], *points = malloc(POINTS * 12), *weights = malloc(POINTS * 16);
    uint32_t *bones = malloc(POINTS * 16), *own = malloc(TRIANGLES * 12), *corners = malloc(TRIANGLES * 12);
    float *found = malloc(POINTS * 12), *matrix_found = malloc(POINTS * 12);
    RlvCrowdOffset *offsets = malloc(POINTS * sizeof *offsets);
    RlvCrowdCluster *clusters = malloc(info.cluster_count * sizeof *clusters);
    uint32_t *all = malloc(info.triangle_count * 12);
    CHECK(points && weights && bones && own && corners && found && matrix_found && offsets && clusters && all);
    buffers.matrices = matrices[0];
    buffers.dual_rows = rows[0];
    buffers.matrix_capacity = 1;
    rows[0][0] = 9.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get(crowd, &buffers), "matrices");
    buffers.matrices = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get(crowd, &buffers), "dual_rows");
    CHECK(rows[0][0] == 9.0f);
    buffers.matrices = matrices[0];
    buffers.matrix_capacity = 2;
    CHECK_OK(rlv_crowd_get(crowd, &buffers));
    /* The upper bone turns about z, and nothing is stretched. */
    for (int bone = 0; bone < 2; ++bone) {
        const double half = 0.5 * atan2(matrices[bone][4], matrices[bone][0]);
        for (int k = 0; k < 12; ++k) {
            CHECK_NEAR(rows[bone][k], k % 5 == 0, 1e-6);
        }
        CHECK_NEAR(rows[bone][14], sin(half), 1e-6);
        CHECK_NEAR(rows[bone][15], cos(half), 1e-6);
    }
    CHECK(rows[1][14] > 0.5f);

    vertices.capacity = POINTS;
    vertices.points = points;
    vertices.bones = bones;
    vertices.weights = weights;
    CHECK_OK(rlv_crowd_model_get_vertices(dual, &vertices));
    CHECK_OK(rlv_crowd_model_get_offsets(dual, offsets, POINTS, 0));
    CHECK_OK(rlv_crowd_model_get_clusters(dual, clusters, info.cluster_count, 0));
    CHECK_OK(rlv_crowd_model_get_triangles(dual, all, NULL, info.triangle_count));
    uint32_t input = 0;
    for (uint32_t cluster = 0; cluster < info.cluster_count; ++cluster) {
        if (clusters[cluster].made_by == UINT32_MAX) {
            memcpy(own + 3 * input, all + 3 * clusters[cluster].first_triangle, 12 * clusters[cluster].triangle_count);
            input += clusters[cluster].triangle_count;
        }
    }
    CHECK_OK(rlv_crowd_model_mesh(dual, 0.0f, 0, 5, &mesh));
    CHECK_OK(rlv_crowd_model_mesh(model, 0.0f, 0, 5, &linear));
    CHECK_OK(rlv_mesh_get_triangles(mesh, corners, TRIANGLES, 0));
    CHECK_OK(rlv_mesh_get_points(mesh, found, POINTS, 0));
    CHECK_OK(rlv_mesh_get_points(linear, matrix_found, POINTS, 0));
    double apart = 0.0;
    for (uint32_t corner = 0; corner < 3 * TRIANGLES; ++corner) {
        const uint32_t vertex = own[corner], at = corners[corner];
        double place[3], moved[3];
        for (int k = 0; k < 3; ++k) {
            place[k] = points[3 * vertex + k] + time * offsets[vertex].offset[k];
        }
        blended(rows[0], bones + 4 * vertex, weights + 4 * vertex, place, moved);
        for (int k = 0; k < 3; ++k) {
            CHECK_NEAR(moved[k], found[3 * at + k], 1e-5);
            apart = fmax(apart, fabs((double)found[3 * at + k] - matrix_found[3 * at + k]));
        }
    }
    CHECK(apart > 0.01);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_mesh_release(linear));
    CHECK_OK(rlv_crowd_release(crowd));
    CHECK_OK(rlv_crowd_model_release(dual));
    free(points);
    free(weights);
    free(bones);
    free(own);
    free(corners);
    free(found);
    free(matrix_found);
    free(offsets);
    free(clusters);
    free(all);
}

/* Returns the agents that a view draws, a bit each, of at most 32. */
static uint32_t drawn_by(RlvCrowd crowd, const RlvCrowdView *view) {
    RlvCrowdFrame frame = RLV_CROWD_FRAME_INIT;
    RlvCrowdBuffers buffers = RLV_CROWD_BUFFERS_INIT;
    RlvCrowdInstance instances[32];
    uint32_t drawn = 0;
    CHECK_OK(rlv_crowd_cut(crowd, view, &frame));
    buffers.instances = instances;
    buffers.instance_capacity = 32;
    CHECK_OK(rlv_crowd_get(crowd, &buffers));
    for (uint32_t at = 0; at < frame.agent_count; ++at) {
        drawn |= 1u << instances[at].agent;
    }
    return drawn;
}

/* Agents before the camera, on either side of what it sees and behind it. Agents are drawn from which shadows fall into view. */
static void check_shadows(RlvContext context, RlvCrowdModel model) {
    const RlvCrowdAgent agents[4] = {check_agent(0.0, -4.0), check_agent(30.0, -4.0), check_agent(-30.0, -4.0), check_agent(0.0, 20.0)};
    RlvCrowdSun suns[2] = {{{0.0, 0.05, 1.0}, 0.005}, {{3.0, 0.15, 0.0}, 0.005}};
    RlvCrowdView view = RLV_CROWD_VIEW_INIT;
    RlvCrowd crowd = RLV_NULL;
    CHECK_OK(rlv_crowd_create(context, &model, 1, &crowd));
    CHECK_OK(rlv_crowd_add(crowd, agents, 4, 0, NULL));
    view.width = 320;
    view.height = 240;
    view.eye[2] = 4.0;
    CHECK(drawn_by(crowd, &view) == 1);
    /* The far sides of the view are beside all agents. */
    view.suns = suns;
    view.sun_count = 1;
    CHECK(drawn_by(crowd, &view) == 15);
    view.suns = suns + 1;
    CHECK(drawn_by(crowd, &view) == 3);
    suns[1].towards[0] = -3.0;
    CHECK(drawn_by(crowd, &view) == 5);
    suns[1].towards[2] = -30.0;
    suns[1].towards[0] = 0.0;
    CHECK(drawn_by(crowd, &view) == 1);
    view.suns = suns;
    view.sun_count = 2;
    CHECK(drawn_by(crowd, &view) == 15);
    /* A host with an older header has no suns. */
    view.struct_size = offsetof(RlvCrowdView, suns);
    CHECK(drawn_by(crowd, &view) == 1);
    view.struct_size = sizeof view;
    view.sun_count = 0;
    view.around = 18.0;
    CHECK(drawn_by(crowd, &view) == 9);

    view.occlusion = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, &view, NULL), "occlusion");
    view.around = 0.0;
    view.sun_count = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, &view, NULL), "occlusion");
    view.occlusion = 0;
    view.around = -1.0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, &view, NULL), "around");
    view.around = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, &view, NULL), "around");
    view.around = 0.0;
    suns[0].angular_radius = -0.1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, &view, NULL), "angular radius");
    suns[0].angular_radius = 0.0;
    suns[0].towards[1] = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, &view, NULL), "direction");
    memset(suns[0].towards, 0, sizeof suns[0].towards);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, &view, NULL), "direction");
    view.suns = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, &view, NULL), "suns");
    CHECK_OK(rlv_crowd_release(crowd));
}

/* An agent with weights of its own is drawn with them, and with more triangles; without them as before. */
static void check_weights(RlvContext context, RlvCrowdModel model) {
    const RlvCrowdAgent agents[2] = {check_agent(-1.0, -20.0), check_agent(1.0, -20.0)};
    RlvCrowdView view = RLV_CROWD_VIEW_INIT;
    RlvCrowdFrame before = RLV_CROWD_FRAME_INIT, after = RLV_CROWD_FRAME_INIT;
    RlvCrowdBuffers buffers = RLV_CROWD_BUFFERS_INIT;
    RlvCrowdModelInfo info = RLV_CROWD_MODEL_INFO_INIT;
    RlvCrowdOffset *offsets = malloc(POINTS * sizeof *offsets);
    RlvCrowd crowd = RLV_NULL;
    CHECK(offsets != NULL);
    CHECK_OK(rlv_crowd_model_info(model, &info));
    CHECK(info.morph_count == 1 && info.offset_count == POINTS);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_get_offsets(model, offsets, POINTS - 1, 0), "offsets");
    CHECK_OK(rlv_crowd_model_get_offsets(model, offsets, POINTS, 0));
    for (uint32_t point = 0; point < POINTS; ++point) {
        const double radius = hypot(offsets[point].offset[0], offsets[point].offset[2]);
        CHECK(offsets[point].vertex == point && offsets[point].morph == 0 && offsets[point].offset[1] == 0.0f);
        CHECK(radius > 0.09 && radius < 0.11);
    }
    free(offsets);

    CHECK_OK(rlv_crowd_create(context, &model, 1, &crowd));
    CHECK_OK(rlv_crowd_add(crowd, agents, 2, 0, NULL));
    view.width = 320;
    view.height = 240;
    view.time = 1.0 / 6.0;
    CHECK_OK(rlv_crowd_cut(crowd, &view, &before));
    CHECK(before.agent_count == 2 && before.weight_count == 1 && before.matrix_count == info.bone_count);
    const float own = 1.5f, wrong[2] = {0.0f, NAN};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_set_weights(crowd, 2, &own, 1), "agent 2");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_set_weights(crowd, 1, wrong, 2), "2 weights for 1");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_set_weights(crowd, 1, wrong + 1, 1), "finite");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_set_weights(crowd, 1, NULL, 1), "weights");
    CHECK_OK(rlv_crowd_set_weights(crowd, 1, &own, 1));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get(crowd, &buffers), "rlv_crowd_cut");
    CHECK_OK(rlv_crowd_cut(crowd, &view, &after));
    CHECK(after.agent_count == 2 && after.weight_count == 2 && after.matrix_count == 2 * info.bone_count);
    CHECK(after.triangles > before.triangles);
    float weights[2] = {9.0f, 9.0f};
    uint32_t firsts[2];
    RlvCrowdInstance instances[2];
    buffers.instances = instances;
    buffers.instance_capacity = 2;
    buffers.first_weights = firsts;
    buffers.weights = weights;
    buffers.weight_capacity = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get(crowd, &buffers), "weights");
    CHECK(weights[0] == 9.0f);
    buffers.weight_capacity = 2;
    CHECK_OK(rlv_crowd_get(crowd, &buffers));
    for (int at = 0; at < 2; ++at) {
        CHECK_NEAR(weights[firsts[at]], instances[at].agent == 1 ? 1.5 : 1.0 / 6.0, 1e-6);
    }
    CHECK_OK(rlv_crowd_set_weights(crowd, 1, NULL, 0));
    CHECK_OK(rlv_crowd_cut(crowd, &view, &after));
    CHECK(after.triangles == before.triangles && after.weight_count == 1);
    check_idle(crowd.id, "crowd");
    CHECK_OK(rlv_crowd_release(crowd));
}

/* Vertices go to others that are removed later, and in most views some are on their way. */
static void check_geomorphs(RlvContext context, RlvCrowdModel model) {
    const RlvCrowdAgent agent = check_agent(0.0, 0.0);
    RlvCrowdView view = RLV_CROWD_VIEW_INIT;
    RlvCrowdFrame frame = RLV_CROWD_FRAME_INIT;
    RlvCrowdBuffers buffers = RLV_CROWD_BUFFERS_INIT;
    RlvCrowdModelInfo info = RLV_CROWD_MODEL_INFO_INIT;
    RlvCrowd crowd = RLV_NULL;
    CHECK_OK(rlv_crowd_model_info(model, &info));
    RlvCrowdCollapse *collapses = malloc(POINTS * sizeof *collapses);
    float *blends = malloc(info.cluster_count * sizeof *blends);
    CHECK(collapses && blends);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_get_collapses(model, collapses, 3, 0), "collapses");
    CHECK_OK(rlv_crowd_model_get_collapses(model, collapses, POINTS, 0));
    uint32_t removed = 0;
    for (uint32_t point = 0; point < POINTS; ++point) {
        const RlvCrowdCollapse it = collapses[point];
        CHECK(it.target < POINTS && (it.group < info.group_count || (it.group == UINT32_MAX && it.target == point)));
        /* What a vertex goes to is removed later, if at all. */
        CHECK(it.group == UINT32_MAX || collapses[it.target].group > it.group);
        removed += it.group != UINT32_MAX;
    }
    CHECK(removed > POINTS / 2);
    CHECK_OK(rlv_crowd_create(context, &model, 1, &crowd));
    CHECK_OK(rlv_crowd_add(crowd, &agent, 1, 0, NULL));
    view.width = 320;
    view.height = 240;
    view.tolerance = 2.0f;
    view.geomorph = 1;
    uint32_t moving = 0;
    for (int step = 0; step < 40; ++step) {
        view.eye[2] = 2.0 + 0.5 * step;
        CHECK_OK(rlv_crowd_cut(crowd, &view, &frame));
        buffers.draw_capacity = info.cluster_count;
        buffers.blends = blends;
        CHECK_OK(rlv_crowd_get(crowd, &buffers));
        for (uint32_t draw = 0; draw < frame.draw_count; ++draw) {
            CHECK(blends[draw] >= 0.0f && blends[draw] <= 1.0f);
            moving += blends[draw] > 0.0f;
        }
    }
    CHECK(moving > 40);
    view.geomorph = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, &view, NULL), "geomorph");
    CHECK_OK(rlv_crowd_release(crowd));
    free(collapses);
    free(blends);
}

/* Far agents are quads that share pictures of equal poses, near ones are not; a picture keeps its number. */
static void check_impostors(RlvContext context, RlvCrowdModel model) {
    enum { TEXELS = RLV_CROWD_PICTURE_SIDE * RLV_CROWD_PICTURE_SIDE };
    RlvCrowdAgent agents[AGENTS];
    RlvCrowdView view = RLV_CROWD_VIEW_INIT;
    RlvCrowdFrame frame = RLV_CROWD_FRAME_INIT;
    RlvCrowdImpostors buffers = RLV_CROWD_IMPOSTORS_INIT;
    RlvCrowdModelInfo info = RLV_CROWD_MODEL_INFO_INIT;
    RlvCrowdImpostor impostors[AGENTS];
    RlvCrowdPicture pictures[AGENTS];
    RlvCrowdTexel *texels = malloc(AGENTS * TEXELS * sizeof *texels);
    RlvCrowd crowd = RLV_NULL;
    CHECK(texels != NULL);
    CHECK_OK(rlv_crowd_model_info(model, &info));
    for (int agent = 0; agent < AGENTS; ++agent) {
        /* All far ones on one side of the view, so that they are seen from one direction. */
        agents[agent] = agent == 0 ? check_agent(0.0, -4.0) : check_agent(3.0 + 0.2 * agent, -300.0);
        agents[agent].phase = agent % 2 / 6.0;
    }
    CHECK_OK(rlv_crowd_create(context, &model, 1, &crowd));
    CHECK_OK(rlv_crowd_add(crowd, agents, AGENTS, 0, NULL));
    view.width = 320;
    view.height = 240;
    CHECK_OK(rlv_crowd_cut(crowd, &view, &frame));
    CHECK(frame.agent_count == AGENTS && frame.impostor_count == 0 && frame.picture_count == 0);
    view.impostors = 1;
    CHECK_OK(rlv_crowd_cut(crowd, &view, &frame));
    CHECK(frame.agent_count == 1 && frame.impostor_count == AGENTS - 1 && frame.picture_count == 2);
    buffers.impostors = impostors;
    buffers.impostor_capacity = AGENTS;
    buffers.pictures = pictures;
    buffers.picture_capacity = 2;
    buffers.texels = texels;
    buffers.texel_capacity = 2 * TEXELS - 1;
    impostors[0].agent = 99;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get_impostors(crowd, &buffers), "texels");
    CHECK(impostors[0].agent == 99);
    buffers.texel_capacity = 2 * TEXELS;
    CHECK_OK(rlv_crowd_get_impostors(crowd, &buffers));
    for (uint32_t at = 0; at < frame.impostor_count; ++at) {
        const RlvCrowdImpostor it = impostors[at];
        CHECK(it.agent == at + 1 && it.picture == at % 2);
        CHECK(it.transform[0] == 1.0f && it.transform[3] == (float)agents[it.agent].transform[9]);
    }
    for (uint32_t picture = 0; picture < 2; ++picture) {
        const RlvCrowdPicture it = pictures[picture];
        uint32_t covered = 0;
        CHECK(it.model == 0 && it.radius > 0.9f && it.radius < 2.0f && it.number != pictures[1 - picture].number);
        /* The viewer is at z above 0. */
        CHECK(it.axes[8] > 0.99f);
        for (uint32_t texel = picture * TEXELS; texel < (picture + 1) * TEXELS; ++texel) {
            const float *normal = texels[texel].normal;
            if (texels[texel].cluster == UINT32_MAX) {
                continue;
            }
            ++covered;
            CHECK(texels[texel].cluster < info.cluster_count && texels[texel].material == 0);
            CHECK_NEAR(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2], 1.0, 1e-4);
        }
        CHECK(covered > TEXELS / 20 && covered < TEXELS / 2);
    }
    const uint64_t known = pictures[0].number;
    view.eye[0] = 0.1;
    CHECK_OK(rlv_crowd_cut(crowd, &view, &frame));
    CHECK_OK(rlv_crowd_get_impostors(crowd, &buffers));
    CHECK(frame.picture_count == 2 && pictures[0].number == known);
    view.impostors = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, &view, NULL), "impostors");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get_impostors(crowd, NULL), "NULL");
    CHECK_OK(rlv_crowd_set(crowd, 0, agents, AGENTS, 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get_impostors(crowd, &buffers), "rlv_crowd_cut");
    CHECK_OK(rlv_crowd_release(crowd));
    free(texels);
}

/* A row of agents from near to far, one of them behind the camera, cut into draws. */
static void check_draws(RlvContext context, RlvCrowdModel model) {
    RlvCrowdAgent agents[AGENTS];
    RlvCrowdView view = RLV_CROWD_VIEW_INIT;
    RlvCrowdFrame frame = RLV_CROWD_FRAME_INIT, distant = RLV_CROWD_FRAME_INIT;
    RlvCrowdBuffers buffers = RLV_CROWD_BUFFERS_INIT;
    RlvCrowdModelInfo info = RLV_CROWD_MODEL_INFO_INIT;
    RlvCrowd crowd = RLV_NULL;
    uint32_t first = 77;
    CHECK_OK(rlv_crowd_model_info(model, &info));
    for (int agent = 0; agent < AGENTS; ++agent) {
        agents[agent] = check_agent(0.0, agent == AGENTS - 1 ? 20.0 : -4.0 * agent);
        agents[agent].phase = agent % 2 / 6.0;
    }
    /* The model twice: vertices and indices of the second follow those of the first. */
    const RlvCrowdModel models[2] = {model, model};
    agents[3].model = 1;
    CHECK_OK(rlv_crowd_create(context, models, 2, &crowd));
    CHECK_OK(rlv_crowd_add(crowd, agents, AGENTS, 0, &first));
    CHECK(first == 0);
    view.width = 320;
    view.height = 240;
    view.eye[2] = 4.0;
    view.target[2] = 0.0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get(crowd, &buffers), "rlv_crowd_cut");
    CHECK_OK(rlv_crowd_cut(crowd, &view, &frame));
    CHECK(frame.agent_count == AGENTS - 1 && frame.changed == AGENTS);
    CHECK(frame.draw_count > 0 && frame.triangles < (uint64_t)TRIANGLES * frame.agent_count);
    /* Two poses of the first model, one of the second. */
    CHECK(frame.matrix_count == 3 * info.bone_count);

    RlvCrowdDraw *draws = malloc(frame.draw_count * sizeof *draws);
    uint32_t *clusters = malloc(frame.draw_count * 8);
    RlvCrowdInstance *instances = malloc(frame.agent_count * sizeof *instances);
    float *matrices = malloc(frame.matrix_count * 48);
    RlvCrowdCluster *known = malloc(info.cluster_count * sizeof *known);
    CHECK(draws && clusters && instances && matrices && known);
    CHECK_OK(rlv_crowd_model_get_clusters(model, known, info.cluster_count, 0));
    buffers.draws = draws;
    buffers.draw_capacity = frame.draw_count;
    buffers.clusters = clusters;
    buffers.instances = instances;
    buffers.instance_capacity = frame.agent_count - 1;
    buffers.matrices = matrices;
    buffers.matrix_capacity = frame.matrix_count;
    memset(draws, 0x55, sizeof *draws);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get(crowd, &buffers), "instances");
    CHECK(draws[0].index_count == 0x55555555);
    buffers.instance_capacity = frame.agent_count;
    CHECK_OK(rlv_crowd_get(crowd, &buffers));
    uint64_t triangles = 0, drawn = 0;
    for (uint32_t draw = 0; draw < frame.draw_count; ++draw) {
        const RlvCrowdDraw it = draws[draw];
        const uint32_t second = clusters[2 * draw], cluster = clusters[2 * draw + 1];
        CHECK(it.index_count == 3 * known[cluster].triangle_count);
        CHECK(it.first_index == 3 * (known[cluster].first_triangle + second * info.triangle_count));
        CHECK(it.base_vertex == (int32_t)(second * info.vertex_count));
        CHECK(it.first_instance + it.instance_count <= frame.agent_count);
        triangles += (uint64_t)it.index_count / 3 * it.instance_count;
        drawn += it.instance_count;
        for (uint32_t at = it.first_instance; at < it.first_instance + it.instance_count; ++at) {
            CHECK(agents[instances[at].agent].model == second);
        }
    }
    CHECK(triangles == frame.triangles && drawn == frame.clusters);
    uint32_t seen = 0;
    for (uint32_t at = 0; at < frame.agent_count; ++at) {
        const RlvCrowdInstance it = instances[at];
        CHECK(it.agent < AGENTS - 1 && it.first_matrix + info.bone_count <= frame.matrix_count);
        CHECK(it.transform[0] == 1.0f && it.transform[11] == (float)agents[it.agent].transform[11]);
        seen |= 1u << it.agent;
        /* The lower bone rests; the upper one has turned about z by 15 degrees in pose 1. */
        const float *rows = matrices + 12 * it.first_matrix;
        CHECK_NEAR(rows[0], 1.0, 1e-6);
        CHECK_NEAR(rows[12 + 4], sin(it.agent % 2 * 0.2617993878), 2e-2);
    }
    CHECK(seen == (1u << (AGENTS - 1)) - 1);

    /* All far away: fewer triangles, and agents of one step share their draws. */
    for (int agent = 0; agent < AGENTS; ++agent) {
        agents[agent] = check_agent(agent, -400.0);
    }
    CHECK_OK(rlv_crowd_set(crowd, 0, agents, AGENTS, 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get(crowd, &buffers), "rlv_crowd_cut");
    CHECK_OK(rlv_crowd_cut(crowd, &view, &distant));
    CHECK(distant.agent_count == AGENTS && distant.triangles < frame.triangles / 4 && distant.draw_count < distant.clusters);
    CHECK_OK(rlv_crowd_cut(crowd, &view, &distant));
    CHECK(distant.changed == 0);

    /* A wide agent before small ones, which it hides from the first cut on. */
    for (int agent = 0; agent < AGENTS; ++agent) {
        agents[agent] = check_agent(0.0, agent == 0 ? 0.0 : -10.0 - agent);
        agents[agent].transform[0] = agents[agent].transform[4] = agents[agent].transform[8] = agent == 0 ? 4.0 : 0.05;
    }
    RlvCrowdFrame culled = RLV_CROWD_FRAME_INIT;
    CHECK_OK(rlv_crowd_set(crowd, 0, agents, AGENTS, 0));
    view.eye[2] = 8.0;
    CHECK_OK(rlv_crowd_cut(crowd, &view, &frame));
    CHECK(frame.agent_count == AGENTS && frame.hidden == 0 && frame.occluder_triangles == 0);
    view.occlusion = 1;
    CHECK_OK(rlv_crowd_cut(crowd, &view, &culled));
    CHECK(culled.hidden == AGENTS - 1 && culled.agent_count == 1 && culled.occluder_triangles > 0);
    CHECK(culled.triangles + culled.hidden_triangles == frame.triangles && culled.draw_count < frame.draw_count);
    view.occlusion = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, &view, NULL), "occlusion");
    view.occlusion = 0;

    const RlvCrowdAgent flat = {0, 0, 0.0, {0.0}};
    agents[5].clip = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_add(crowd, agents, AGENTS, 0, NULL), "agent 5");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_set(crowd, 0, agents, AGENTS, 0), "clip 3");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_add(crowd, &flat, 1, 0, NULL), "inverse");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_set(crowd, 5, agents, AGENTS, 0), "beyond");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_set(crowd, UINT32_MAX, agents, 1, 0), "beyond");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_add(crowd, NULL, 1, 0, NULL), "agents");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_add(crowd, agents, 1, 8, NULL), "stride");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, NULL, NULL), "NULL");
    view.tolerance = 0.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, &view, NULL), "pixels");
    view.tolerance = 0.5f;
    view.width = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, &view, NULL), "pixels");
    view.width = 320;
    view.eye[1] = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, &view, NULL), "");
    /* A cut that fails leaves nothing of the one before. */
    RlvCrowdBuffers empty = RLV_CROWD_BUFFERS_INIT;
    RlvCrowdImpostors quads = RLV_CROWD_IMPOSTORS_INIT;
    for (int wrong = 0; wrong < 3; ++wrong) {
        view.eye[1] = 0.0;
        CHECK_OK(rlv_crowd_cut(crowd, &view, NULL));
        CHECK_OK(rlv_crowd_get(crowd, &empty));
        CHECK_OK(rlv_crowd_get_impostors(crowd, &quads));
        view.eye[1] = wrong == 0 ? NAN : 0.0;
        culled.struct_size = wrong == 2 ? 2 : sizeof culled;
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_cut(crowd, wrong == 1 ? NULL : &view, &culled), "");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get(crowd, &empty), "failed");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get_impostors(crowd, &quads), "failed");
    }
    CHECK_OK(rlv_crowd_retain(crowd));
    CHECK_OK(rlv_crowd_release(crowd));
    CHECK_OK(rlv_crowd_release(crowd));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_get(crowd, &buffers), "");
    free(draws);
    free(clusters);
    free(instances);
    free(matrices);
    free(known);
}

static void check_refusals(RlvContext context, RlvCrowdModel model) {
    RlvCrowdBuildSettings settings = RLV_CROWD_BUILD_SETTINGS_INIT;
    const RlvCrowdClipName wrong = {"bent"}, none = {NULL};
    RlvCrowdModel made = RLV_NULL;
    RlvCrowdModelInfo info = RLV_CROWD_MODEL_INFO_INIT;
    RlvCrowdClip clip = RLV_CROWD_CLIP_INIT;
    RlvCrowdMaterial material = RLV_CROWD_MATERIAL_INIT;
    RlvCrowd crowd = RLV_NULL;
    RlvMesh mesh = RLV_NULL;
    RlvJob job = RLV_NULL;
    const RlvParameter *params = NULL;
    size_t count = 0;
    int calls = 2;
    const char *path = "crowd_arm.gltf";
    CHECK_OK(rlv_crowd_model_info(model, &info));
    CHECK_OK(rlv_crowd_params(&params, &count));
    CHECK(count == 4 && strcmp(params[0].name, "pose_distance") == 0 && params[0].offset == sizeof(uint32_t));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_params(NULL, &count), "params");
    settings.cluster_triangles = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_build(context, path, NULL, 0, &settings, NULL, NULL, &made),
                "cluster_triangles");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_crowd(context, path, NULL, 0, &settings, &job), "cluster_triangles");
    CHECK(rlv_crowd_model_build(context, path, &wrong, 1, NULL, NULL, NULL, &made) != RLV_OK);
    CHECK(strstr(rlv_error_last(), "bend") != NULL);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_build(context, path, &none, 1, NULL, NULL, NULL, &made), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_build(context, path, NULL, 1, NULL, NULL, NULL, &made), "clips");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_build(context, NULL, NULL, 0, NULL, NULL, NULL, &made), "path");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_build(context, path, NULL, 0, NULL, NULL, NULL, NULL), "out");
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_crowd_model_build(context, path, NULL, 0, NULL, cancel, &calls, &made), "");
    CHECK(rlv_crowd_model_build(context, "nothing.glb", NULL, 0, NULL, NULL, NULL, &made) != RLV_OK);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_read(context, path, &made), "crowd model");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_clip(model, 1, &clip), "clip 1");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_material(model, info.material_count, &material), "material");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_mesh(model, -1.0f, 0, 0, &mesh), "error");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_mesh(model, NAN, 0, 0, &mesh), "error");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_mesh(model, 0.0f, 0, 6, &mesh), "pose 6");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_mesh(model, 0.0f, 2, 0, &mesh), "clip 2");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_create(context, NULL, 0, &crowd), "model");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_create(context, &made, 1, &crowd), "");
    info.struct_size = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_crowd_model_info(model, &info), "struct_size");
    CHECK(made.id == 0 && crowd.id == 0 && mesh.id == 0 && job.id == 0);
}

int main(void) {
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    write_arm(0.01);
    RlvCrowdModel model = build(context);
    check_models(context, model);
    check_refits(context, model);
    check_parts(model);
    check_draws(context, model);
    check_blends(context, model);
    check_shadows(context, model);
    check_weights(context, model);
    check_geomorphs(context, model);
    check_impostors(context, model);
    check_refusals(context, model);
    CHECK_OK(rlv_crowd_model_release(model));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
