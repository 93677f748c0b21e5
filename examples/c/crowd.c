/* Builds a crowd model of a character or a static model, and prints what a camera draws of many of them while it goes by:
 * the arguments of indexed indirect draws, and counts.
 *
 *   cc crowd.c $(pkg-config --cflags --libs relievo) -lm -o crowd && ./crowd robot.glb [AGENTS] */
#include <relievo/relievo.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(RlvResult result) {
    if (result != RLV_OK) {
        fprintf(stderr, "%s\n", rlv_error_last());
        exit(1);
    }
}

static void *room(size_t count, size_t size) {
    void *made = calloc(count ? count : 1, size);
    if (made == NULL) {
        fprintf(stderr, "there is no memory for the buffers of a frame\n");
        exit(1);
    }
    return made;
}

/* Prints a frame. An engine would copy the four arrays into its buffers, and draw with vkCmdDrawIndexedIndirect. */
static void print_frame(RlvCrowd crowd, const RlvCrowdFrame *frame) {
    RlvCrowdBuffers buffers = RLV_CROWD_BUFFERS_INIT;
    RlvCrowdDraw *draws = room(frame->draw_count, sizeof *draws);
    buffers.draws = draws;
    buffers.draw_capacity = frame->draw_count;
    buffers.clusters = room(frame->draw_count, 2 * sizeof *buffers.clusters);
    buffers.instances = room(frame->agent_count, sizeof *buffers.instances);
    buffers.instance_capacity = frame->agent_count;
    buffers.matrices = room(frame->matrix_count, 12 * sizeof *buffers.matrices);
    buffers.matrix_capacity = frame->matrix_count;
    check(rlv_crowd_get(crowd, &buffers));
    uint64_t triangles = 0;
    for (uint32_t at = 0; at < frame->draw_count; ++at) {
        triangles += (uint64_t)draws[at].index_count / 3 * draws[at].instance_count;
        if (at < 3) {
            printf("  draw %u: %u indices from %u, %u instances from %u, vertices from %d\n", (unsigned)at,
                   (unsigned)draws[at].index_count, (unsigned)draws[at].first_index, (unsigned)draws[at].instance_count,
                   (unsigned)draws[at].first_instance, (int)draws[at].base_vertex);
        }
    }
    printf("  %u draws of %llu triangles\n", (unsigned)frame->draw_count, (unsigned long long)triangles);
    free(draws);
    free(buffers.clusters);
    free(buffers.instances);
    free(buffers.matrices);
}

int main(int argc, char **argv) {
    if (argc < 2) {
        fprintf(stderr, "usage: crowd MODEL [AGENTS]\n");
        return 2;
    }
    const int count = argc > 2 ? atoi(argv[2]) : 1000;
    if (count < 1 || count > 1000000) {
        fprintf(stderr, "give 1 to 1000000 agents\n");
        return 2;
    }
    RlvContext context = RLV_NULL;
    RlvCrowdModel model = RLV_NULL;
    RlvCrowdModelInfo info = RLV_CROWD_MODEL_INFO_INIT;
    RlvCrowdClip clip = RLV_CROWD_CLIP_INIT;
    check(rlv_context_create(NULL, &context));
    check(rlv_crowd_model_build(context, argv[1], NULL, 0, NULL, NULL, NULL, &model));
    check(rlv_crowd_model_info(model, &info));
    check(rlv_crowd_model_clip(model, 0, &clip));
    printf("%s: %u triangles in %u clusters, %u poses of %s\n", argv[1], (unsigned)info.input_triangles,
           (unsigned)info.cluster_count, (unsigned)clip.pose_count, clip.name);

    /* Rows of agents, one size apart, each at another time of its clip. */
    double size = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        size += pow(info.high[axis] - info.low[axis], 2.0);
    }
    size = sqrt(size);
    RlvCrowdAgent *agents = room((size_t)count, sizeof *agents);
    const int side = (int)ceil(sqrt(count));
    for (int at = 0; at < count; ++at) {
        RlvCrowdAgent *agent = &agents[at];
        agent->phase = 0.37 * at;
        agent->transform[0] = agent->transform[4] = agent->transform[8] = 1.0;
        agent->transform[9] = size * (at % side - 0.5 * (side - 1));
        agent->transform[11] = -size * (at / side);
    }
    RlvCrowd crowd = RLV_NULL;
    check(rlv_crowd_create(context, &model, 1, &crowd));
    check(rlv_crowd_add(crowd, agents, (size_t)count, 0, NULL));

    for (int number = 0; number < 3; ++number) {
        RlvCrowdView view = RLV_CROWD_VIEW_INIT;
        RlvCrowdFrame frame = RLV_CROWD_FRAME_INIT;
        view.width = 1280;
        view.height = 720;
        view.eye[0] = 0.5 * size * number;
        view.eye[1] = 0.6 * size;
        view.eye[2] = 3.0 * size;
        memcpy(view.target, view.eye, sizeof view.target);
        view.target[2] = 0.0;
        view.time = number / 24.0;
        check(rlv_crowd_cut(crowd, &view, &frame));
        printf("frame %d: %u agents in view, %u with other clusters than before\n", number,
               (unsigned)frame.agent_count, (unsigned)frame.changed);
        print_frame(crowd, &frame);
    }
    free(agents);
    check(rlv_crowd_release(crowd));
    check(rlv_crowd_model_release(model));
    check(rlv_context_release(context));
    return 0;
}
