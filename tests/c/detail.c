/* Details: options, budget, commit, changed tiles, blocks for undo, poses. */
#include "ball.h"

static void log_text(void *user, uint32_t level, const char *text) {
    CHECK(level == RLV_LOG_WARNING);
    strncpy(user, text, 199);
}

/* The height of the displaced surface in the middle of a tile. */
static float height(RlvDetail detail, uint32_t tile) {
    static const float uv[2] = {0.5f, 0.5f};
    float out[3] = {0, 0, 0};
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    arrays.count = 1;
    arrays.tiles = &tile;
    arrays.uvs = uv;
    arrays.positions = out;
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
    return out[2];
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
    CHECK_OK(rlv_detail_tile_info(detail, 24, &tile));
    CHECK(tile.size == 8 && tile.is_allocated == 0 && tile.version == 0 && tile.block_size == 200);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_tile_info(detail, 25, &tile), "25");

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
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_changed_tiles(detail, changed, count - 1, &count), "room for");
    CHECK_OK(rlv_detail_changed_tiles(detail, changed, 25, &count));
    int found = 0;
    for (size_t index = 0; index < count; ++index) {
        found |= changed[index] == 12;
        CHECK(index == 0 || changed[index - 1] < changed[index]);
    }
    CHECK(found);
    CHECK_OK(rlv_detail_tile_info(detail, 12, &tile));
    CHECK(tile.is_allocated == 1 && tile.low[2] <= -0.15f && tile.version > 0);

    /* Undo by blocks. */
    unsigned char blocks[25][648];
    size_t length[25];
    for (uint32_t index = 0; index < 25; ++index) {
        CHECK_OK(rlv_detail_read_block(detail, index, blocks[index], sizeof(blocks[index]), &length[index]));
        CHECK(length[index] == 0 || length[index] == 648);
    }
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_read_block(detail, 12, blocks[0], 647, &count), "room for");
    const double deeper[12] = CHECK_MOVED(2.5, 2.5, -0.2);
    CHECK_OK(rlv_collider_set_transform(collider, deeper));
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK(height(detail, 12) < -0.4f);
    for (uint32_t index = 0; index < 25; ++index) {
        CHECK_OK(rlv_detail_write_block(detail, index, blocks[index], length[index]));
    }
    CHECK(height(detail, 12) < -0.4f);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    for (uint32_t index = 0; index < 25; ++index) {
        unsigned char block[648];
        CHECK_OK(rlv_detail_read_block(detail, index, block, sizeof(block), &count));
        CHECK(count == length[index] && memcmp(block, blocks[index], count) == 0);
    }
    CHECK_NEAR(height(detail, 12), -0.2, 0.02);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_write_block(detail, 12, blocks[12], 647), "647 bytes");
    memset(blocks[12], 0xff, 648);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_write_block(detail, 12, blocks[12], 648), "not finite");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_write_block(detail, 12, NULL, 648), "NULL");

    /* Finer tiles keep the dent. */
    const uint32_t finer[2] = {12, 32};
    CHECK_OK(rlv_detail_set_face_sizes(detail, finer, 1, 0));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_detail_tile_info(detail, 12, &tile));
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
    CHECK(report.refused_tiles >= 1 && report.bytes == 0 && strstr(last, "budget of 1 bytes") != NULL);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK(height(detail, 12) == 0.0f);
    CHECK_OK(rlv_detail_set_budget(detail, 1 << 20));
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, &report));
    CHECK(report.refused_tiles == 0 && report.bytes > 0);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_NEAR(height(detail, 12), -0.2, 0.02);

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
    CHECK_OK(rlv_context_release(context));
    return 0;
}
