/* Details: options, budget, commit, changed tiles, blocks for undo, poses. */
#include "ball.h"

static void log_text(void *user, uint32_t level, const char *text) {
    CHECK(level == RLV_LOG_WARNING);
    strncpy(user, text, 199);
}

/* The height of the displaced surface in the middle of a tile. */
static float height(RlvDetail detail, uint32_t tile) {
    float out[3] = {0, 0, 0};
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    arrays.positions = out;
    check_evaluate(detail, tile, 0.5f, 0.5f, arrays);
    return out[2];
}

/* What is at a place of a tile. */
typedef struct Sample {
    float position[3], normal[3], vector[3], trace[3], displacement;
} Sample;

static Sample sample(RlvDetail detail, uint32_t tile, float u, float v) {
    Sample out = {{0}, {0}, {0}, {0}, 7.0f};
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    RlvChannelInfo info = RLV_CHANNEL_INFO_INIT;
    arrays.positions = out.position;
    arrays.normals = out.normal;
    arrays.vectors = out.vector;
    arrays.displacements = &out.displacement;
    CHECK_OK(rlv_detail_channel_info(detail, RLV_CHANNEL_TRACES, &info));
    arrays.traces = info.is_there ? out.trace : NULL;
    check_evaluate(detail, tile, u, v, arrays);
    return out;
}

/* Vectors that are the same everywhere move the plane, and come and go by blocks. */
static void vectors(RlvSurface surface) {
    RlvDetail detail = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvVectorOptions how = RLV_VECTOR_OPTIONS_INIT;
    RlvChannelInfo info = RLV_CHANNEL_INFO_INIT;
    RlvDetailTileInfo tile = RLV_DETAIL_TILE_INFO_INIT;
    RlvDetailChanges changes = RLV_DETAIL_CHANGES_INIT;
    RlvDetailFolds folds = RLV_DETAIL_FOLDS_INIT;
    unsigned char block[600], back[600];
    size_t size = 0;
    options.tile_size = 8;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_detail_folds(detail, &folds));
    CHECK(folds.tile == UINT32_MAX && folds.triangle_count == 0 && folds.folded_count == 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_folds(detail, NULL), "out");
    CHECK_OK(rlv_detail_channel_info(detail, RLV_CHANNEL_VECTORS, &info));
    CHECK(info.is_there == 0 && info.bytes == 0 && info.texel_size == 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_tile_info(detail, RLV_CHANNEL_VECTORS, 0, &tile), "vector");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_channel_info(detail, 4, &info), "channel 4");
    how.tile_size = 9;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_add_vectors(detail, &how), "9");
    how.tile_size = 8;
    CHECK_OK(rlv_detail_add_vectors(detail, &how));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_add_vectors(detail, &how), "already");
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK(sample(detail, 12, 0.3f, 0.6f).vector[0] == 0.0f);
    /* 0.25 along the tangent by u and -0.5 along the normal. */
    for (size_t texel = 0; texel < 100; ++texel) {
        const unsigned char value[6] = {0x00, 0x34, 0, 0, 0x00, 0xb8};
        memcpy(block + 6 * texel, value, 6);
    }
    for (uint32_t index = 0; index < 25; ++index) {
        CHECK_OK(rlv_detail_write_block(detail, RLV_CHANNEL_VECTORS, index, block, sizeof(block)));
    }
    CHECK_OK(rlv_detail_commit(detail, &changes));
    CHECK(changes.tile_count == 25 && changes.low[2] < -0.49f);
    const Sample moved = sample(detail, 12, 0.3f, 0.6f);
    CHECK_NEAR(moved.position[0], 2.55, 1e-5);
    CHECK_NEAR(moved.position[1], 2.6, 1e-5);
    CHECK_NEAR(moved.position[2], -0.5, 1e-5);
    CHECK_NEAR(moved.vector[0], 0.25, 1e-5);
    CHECK_NEAR(moved.vector[2], -0.5, 1e-5);
    CHECK_NEAR(moved.normal[2], 1.0, 1e-5);
    CHECK(moved.displacement == 0.0f);
    CHECK_OK(rlv_detail_channel_info(detail, RLV_CHANNEL_VECTORS, &info));
    CHECK(info.is_there == 1 && info.allocated_count == 25 && info.bytes == 25 * 600 && info.full_bytes == 25 * 600);
    CHECK(info.texel_size == 6 && info.budget > 1 << 20);
    CHECK_OK(rlv_detail_read_block(detail, RLV_CHANNEL_VECTORS, 3, back, sizeof(back), &size));
    /* All but the ring, which is made anew. */
    for (size_t row = 1; row < 9; ++row) {
        CHECK(size == 600 && memcmp(block + 6 * (10 * row + 1), back + 6 * (10 * row + 1), 48) == 0);
    }
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_write_block(detail, RLV_CHANNEL_VECTORS, 3, block, 200), "200 bytes");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_write_block(detail, 77, 3, block, 600), "channel 77");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_write_block(detail, RLV_CHANNEL_COLOR, 3, block, 600), "colours");
    CHECK_OK(rlv_detail_release(detail));
}

/* Imprints leave traces, whose age grows with time. */
static void traces(RlvSurface surface, RlvCollider collider) {
    RlvDetail detail = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvTessellateOptions cells = RLV_TESSELLATE_OPTIONS_INIT;
    RlvTessellation triangles = RLV_NULL;
    RlvMesh mesh = RLV_NULL;
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    float trace[3];
    uint32_t index = 0;
    options.tile_size = 16;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    arrays.traces = trace;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_evaluate_detail(detail, &arrays), "traces");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_evaluate_surface(surface, &arrays), "traces");
    CHECK_OK(rlv_detail_add_traces(detail, 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_add_traces(detail, 0), "already");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_advance(detail, NAN), "time");
    CHECK_OK(rlv_detail_advance(detail, 2.0));
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    const Sample pushed = sample(detail, 12, 0.5f, 0.5f), bare = sample(detail, 0, 0.5f, 0.5f);
    CHECK_NEAR(pushed.trace[0], 1.0, 1e-6);
    CHECK_NEAR(pushed.trace[1], -pushed.displacement, 0.02);
    CHECK(pushed.trace[1] > 0.15f && pushed.trace[2] == 0.0f);
    CHECK(bare.trace[0] == 0.0f && bare.trace[1] == 0.0f && bare.trace[2] == -1.0f);
    cells.coarse = cells.fine = 16;
    CHECK_OK(rlv_tessellation_create(detail, &cells, &triangles));
    CHECK_OK(rlv_detail_advance(detail, 5.5));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK(sample(detail, 12, 0.5f, 0.5f).trace[2] == 3.5f);
    /* Going back in time is no fault without decay. */
    CHECK_OK(rlv_detail_advance(detail, 5.0));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_tessellation_update(triangles, NULL));
    RlvTessellationInfo info = RLV_TESSELLATION_INFO_INIT;
    CHECK_OK(rlv_tessellation_info(triangles, &info));
    float *all = malloc(info.point_count * 12), *ages = malloc(info.point_count * 4);
    CHECK(all != NULL && ages != NULL);
    CHECK_OK(rlv_tessellation_get_traces(triangles, 0, info.point_count, all, 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tessellation_get_traces(triangles, 1, info.point_count, all, 0), "more than");
    CHECK_OK(rlv_tessellation_mesh(triangles, &mesh));
    CHECK_OK(rlv_mesh_find_attribute(mesh, "age", &index));
    CHECK_OK(rlv_mesh_get_attribute(mesh, index, ages, info.point_count, NULL, 0));
    size_t old = 0;
    for (size_t point = 0; point < info.point_count; ++point) {
        CHECK(ages[point] == all[3 * point + 2] && (ages[point] == -1.0f) == (all[3 * point] == 0.0f));
        old += ages[point] == 3.0f;
    }
    CHECK(old > 20);
    /* Finer faces keep traces with the displacement. */
    const uint32_t finer[2] = {12, 32};
    CHECK_OK(rlv_detail_set_face_sizes(detail, finer, 1, 0));
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_NEAR(sample(detail, 12, 0.5f, 0.5f).trace[0], 1.0, 1e-3);
    free(all);
    free(ages);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_tessellation_release(triangles));
    CHECK_OK(rlv_detail_release(detail));
}

/* Edits fade linearly and give their tiles back. */
static void decay(RlvSurface surface, RlvCollider collider) {
    RlvDetail detail = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvDecayOptions times = RLV_DECAY_OPTIONS_INIT;
    RlvDetailInfo info = RLV_DETAIL_INFO_INIT;
    options.tile_size = 16;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    times.duration = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_set_decay(detail, &times), "fade");
    times.duration = 2.0f;
    times.delay = -1.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_set_decay(detail, &times), "fade");
    times.delay = 1.0f;
    CHECK_OK(rlv_detail_set_decay(detail, &times));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_set_decay(detail, &times), "already");
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    const float fresh = height(detail, 12);
    CHECK(fresh < -0.15f);
    CHECK_OK(rlv_detail_advance(detail, 1.0));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK(height(detail, 12) == fresh);
    CHECK_OK(rlv_detail_info(detail, &info));
    CHECK(info.time == 1.0 && info.stamp_bytes > 0 && info.allocated_count > 0);
    CHECK_OK(rlv_detail_advance(detail, 2.0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_advance(detail, 1.5), "before");
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_NEAR(height(detail, 12), 0.5 * fresh, 1e-3);
    CHECK_OK(rlv_detail_advance(detail, 3.5));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_detail_info(detail, &info));
    CHECK(height(detail, 12) == 0.0f && info.allocated_count == 0 && info.stamp_bytes == 0);
    CHECK_OK(rlv_detail_release(detail));
}

/* A box pressed in beyond its middle is folded; one with a shallow dent is not. */
static void folds(RlvContext context) {
    const float heights[2] = {-0.05f, -2.0f};
    RlvMesh box = check_box(context, 0.0f, 1.0f, 0.0f, 1.0f);
    RlvSurface surface = RLV_NULL;
    CHECK_OK(rlv_surface_create(context, box, NULL, &surface));
    for (int k = 0; k < 2; ++k) {
        const RlvStrokePoint top = {{0.5, 0.5, 0.9}, 1.0, -1.0};
        RlvDetail detail = RLV_NULL;
        RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
        RlvBrushOptions kind = RLV_BRUSH_OPTIONS_INIT;
        RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
        RlvBrush brush = RLV_NULL;
        RlvDetailFolds found = RLV_DETAIL_FOLDS_INIT;
        options.tile_size = 16;
        kind.action = RLV_BRUSH_SCULPT;
        kind.height = heights[k];
        settings.radius = 0.3f;
        CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
        CHECK_OK(rlv_brush_create(context, &kind, &settings, &brush));
        CHECK_OK(rlv_stroke_run(detail, brush, &top, 1, 0, NULL));
        CHECK_OK(rlv_detail_commit(detail, NULL));
        CHECK_OK(rlv_detail_folds(detail, &found));
        CHECK(found.triangle_count > 0 && found.triangle_count % (2 * 16 * 16) == 0);
        CHECK(k == 0 ? found.folded_count == 0 && found.tile == UINT32_MAX
                     : found.folded_count > 0 && found.folded_count <= found.triangle_count && found.tile < 6);
        CHECK_OK(rlv_brush_release(brush));
        CHECK_OK(rlv_detail_release(detail));
    }
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(box));
}

int main(void) {
    char last[200] = "";
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL, untouched = {77};
    RlvCollider collider = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh plane = check_plane(context, 5, 5), ball = check_ball(context, 0.3);
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));

    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    const uint32_t sizes[2] = {24, 8};
    options.tile_size = 16;
    options.budget = 1 << 20;
    options.face_sizes = sizes;
    options.face_size_count = 1;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    RlvDetailInfo info = RLV_DETAIL_INFO_INIT;
    CHECK_OK(rlv_detail_info(detail, &info));
    CHECK(info.tile_count == 25 && info.allocated_count == 0 && info.bytes == 0 && info.budget == 1 << 20);
    CHECK(info.full_bytes == 24 * 18 * 18 * 2 + 10 * 10 * 2);
    RlvDetailTileInfo tile = RLV_DETAIL_TILE_INFO_INIT;
    CHECK_OK(rlv_detail_tile_info(detail, RLV_CHANNEL_DISPLACEMENT, 24, &tile));
    CHECK(tile.size == 8 && tile.is_allocated == 0 && tile.version == 0 && tile.block_size == 200);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_tile_info(detail, RLV_CHANNEL_DISPLACEMENT, 25, &tile), "25");

    /* A dent in the middle of tile 12; nothing is seen before the commit. */
    const double place[12] = CHECK_MOVED(2.5, 2.5, 0.1);
    CHECK_OK(rlv_collider_create_mesh(context, ball, place, &collider));
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, NULL));
    CHECK(height(detail, 12) == 0.0f);
    RlvDetailChanges changes = RLV_DETAIL_CHANGES_INIT;
    CHECK_OK(rlv_detail_commit(detail, &changes));
    CHECK_NEAR(height(detail, 12), -0.2, 0.02);
    CHECK_OK(rlv_detail_info(detail, &info));
    CHECK(info.allocated_count >= 1 && info.bytes == info.allocated_count * 648 && info.revision > 0);
    CHECK(changes.revision == info.revision && changes.tile_count == info.allocated_count);
    uint32_t changed[25];
    size_t count = 0;
    CHECK_OK(rlv_detail_changed_tiles(detail, NULL, 0, &count));
    CHECK(count == changes.tile_count);
    size_t needed = 77;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_changed_tiles(detail, changed, count - 1, &needed), "room for");
    CHECK(needed == count);
    CHECK_OK(rlv_detail_changed_tiles(detail, changed, 25, &count));
    int found = 0;
    for (size_t index = 0; index < count; ++index) {
        found |= changed[index] == 12;
        CHECK(index == 0 || changed[index - 1] < changed[index]);
    }
    CHECK(found);
    CHECK_OK(rlv_detail_tile_info(detail, RLV_CHANNEL_DISPLACEMENT, 12, &tile));
    CHECK(tile.is_allocated == 1 && tile.low[2] <= -0.15f && tile.version > 0);

    /* Undo by blocks. */
    unsigned char blocks[25][648];
    size_t length[25];
    for (uint32_t index = 0; index < 25; ++index) {
        CHECK_OK(rlv_detail_read_block(detail, RLV_CHANNEL_DISPLACEMENT, index, blocks[index], sizeof(blocks[index]), &length[index]));
        CHECK(length[index] == 0 || length[index] == 648);
    }
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_read_block(detail, RLV_CHANNEL_DISPLACEMENT, 12, blocks[0], 647, &needed), "room for");
    CHECK(needed == 648);
    const double deeper[12] = CHECK_MOVED(2.5, 2.5, -0.2);
    CHECK_OK(rlv_collider_set_transform(collider, deeper));
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK(height(detail, 12) < -0.4f);
    for (uint32_t index = 0; index < 25; ++index) {
        CHECK_OK(rlv_detail_write_block(detail, RLV_CHANNEL_DISPLACEMENT, index, blocks[index], length[index]));
    }
    CHECK(height(detail, 12) < -0.4f);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    for (uint32_t index = 0; index < 25; ++index) {
        unsigned char block[648];
        CHECK_OK(rlv_detail_read_block(detail, RLV_CHANNEL_DISPLACEMENT, index, block, sizeof(block), &count));
        CHECK(count == length[index] && memcmp(block, blocks[index], count) == 0);
    }
    CHECK_NEAR(height(detail, 12), -0.2, 0.02);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_write_block(detail, RLV_CHANNEL_DISPLACEMENT, 12, blocks[12], 647), "647 bytes");
    memset(blocks[12], 0xff, 648);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_write_block(detail, RLV_CHANNEL_DISPLACEMENT, 12, blocks[12], 648), "not finite");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_write_block(detail, RLV_CHANNEL_DISPLACEMENT, 12, NULL, 648), "NULL");

    /* Finer tiles keep the dent. */
    const uint32_t finer[2] = {12, 32};
    CHECK_OK(rlv_detail_set_face_sizes(detail, finer, 1, 0));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_detail_tile_info(detail, RLV_CHANNEL_DISPLACEMENT, 12, &tile));
    CHECK(tile.size == 32 && tile.block_size == 34 * 34 * 2);
    CHECK_NEAR(height(detail, 12), -0.2, 0.02);
    const uint32_t wrong[4] = {12, 33, 25, 8};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_set_face_sizes(detail, wrong, 1, 0), "33");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_set_face_sizes(detail, wrong + 2, 1, 0), "face 25");

    /* A new pose and transform carry the dent along, from the commit on. */
    float points[36][3];
    for (int point = 0; point < 36; ++point) {
        points[point][0] = (float)(point % 6);
        points[point][1] = (float)(point / 6);
        points[point][2] = 3.0f;
    }
    CHECK_OK(rlv_detail_set_points(detail, points[0], 36, 0));
    CHECK_OK(rlv_detail_set_transform(detail, place));
    CHECK_NEAR(height(detail, 12), -0.2, 0.02);
    CHECK_OK(rlv_detail_commit(detail, &changes));
    CHECK(changes.moved == 1 && changes.tile_count == 0);
    CHECK_NEAR(height(detail, 12), 2.8, 0.02);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_set_points(detail, points[0], 35, 0), "35 points");
    const double flat[12] = {0};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_set_transform(detail, flat), "transform");
    CHECK_OK(rlv_detail_release(detail));

    /* A budget for one tile: the edit goes on, the refusal is reported and logged. */
    CHECK_OK(rlv_context_set_log(context, log_text, last));
    options.face_size_count = 0;
    options.budget = 1;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
    CHECK_OK(rlv_collider_set_transform(collider, place));
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, &report));
    CHECK(report.refused_tiles >= 1 && report.bytes == 0 && strstr(last, "budget of 1 bytes: face") != NULL);
    uint32_t faces[25];
    size_t face_count = 0;
    CHECK_OK(rlv_detail_refused_faces(detail, faces, 25, &face_count));
    CHECK(face_count >= 1 && faces[0] < 25);
    needed = 77;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_refused_faces(detail, faces, face_count - 1, &needed), "faces");
    CHECK(needed == face_count);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK(height(detail, 12) == 0.0f);
    CHECK_OK(rlv_detail_set_budget(detail, 1 << 20));
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, &report));
    CHECK(report.refused_tiles == 0 && report.bytes > 0);
    CHECK_OK(rlv_detail_refused_faces(detail, NULL, 0, &face_count));
    CHECK(face_count == 0);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_NEAR(height(detail, 12), -0.2, 0.02);

    /* Tiles leave memory, and are read all the same. */
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_detail_set_paging(detail, 1, "no/such/folder"), "folder");
    CHECK_OK(rlv_detail_set_paging(detail, 1, NULL));
    CHECK_OK(rlv_detail_set_budget(detail, 1));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    RlvChannelInfo paged = RLV_CHANNEL_INFO_INIT;
    CHECK_OK(rlv_detail_channel_info(detail, RLV_CHANNEL_DISPLACEMENT, &paged));
    CHECK(paged.paged_count == paged.allocated_count && paged.paged_count > 0 && paged.bytes == 0);
    CHECK_NEAR(height(detail, 12), -0.2, 0.02);
    CHECK_OK(rlv_detail_set_paging(detail, 0, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_detail_channel_info(detail, RLV_CHANNEL_DISPLACEMENT, &paged));
    CHECK(paged.paged_count == 0 && paged.bytes > 1);

    vectors(surface);
    traces(surface, collider);
    decay(surface, collider);

    /* Refusals. */
    options.tile_size = 20;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_create(surface, &options, NULL, &untouched), "20");
    options.tile_size = 16;
    const uint32_t beyond[2] = {25, 8};
    options.face_sizes = beyond;
    options.face_size_count = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_create(surface, &options, NULL, &untouched), "face 25");
    CHECK(untouched.id == 77);

    CHECK_OK(rlv_detail_release(detail));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_info(detail, &info), "not alive");
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_mesh_release(ball));
    folds(context);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
