/* Documents: undo and redo to the bit, and a file that brings everything back. */
#include "sheet.h"

enum { EDITS = 12, BLOCK = 4 * 34 * 34 };

typedef struct State {
    unsigned char heights[9][BLOCK];
    size_t sizes[9];
    float colors[9][4];
} State;

static void keep(RlvDetail detail, State *state) {
    uint32_t tiles[9];
    float uvs[18];
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    memset(state, 0, sizeof *state);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    for (uint32_t tile = 0; tile < 9; ++tile) {
        CHECK_OK(rlv_detail_read_block(detail, RLV_CHANNEL_DISPLACEMENT, tile, state->heights[tile], BLOCK, &state->sizes[tile]));
        tiles[tile] = tile;
        uvs[2 * tile] = uvs[2 * tile + 1] = 0.4f;
    }
    arrays.count = 9;
    arrays.tiles = tiles;
    arrays.uvs = uvs;
    arrays.colors = state->colors[0];
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
}

static int same(const State *a, const State *b) { return memcmp(a, b, sizeof *a) == 0; }

/* A stroke across the plate, painting or sculpting. */
static void stroke(RlvContext context, RlvDetail detail, int number) {
    RlvBrushOptions options = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvStrokePoint points[2] = {{{0.2, 0, 0}, 1.0, -1.0}, {{2.8, 0, 0}, 1.0, -1.0}};
    RlvBrush brush = RLV_NULL;
    points[0].position[1] = 0.3 + 0.2 * number;
    points[1].position[1] = 2.7 - 0.1 * number;
    options.action = number % 2 == 0 ? RLV_BRUSH_SCULPT : RLV_BRUSH_PAINT;
    options.color[0] = 0.1f * (float)number / 2;
    options.height = 0.05f * (float)(number + 1);
    settings.radius = 0.3f;
    CHECK_OK(rlv_brush_create(context, &options, &settings, &brush));
    CHECK_OK(rlv_stroke_run(detail, brush, points, 2, 0, NULL));
    CHECK_OK(rlv_brush_release(brush));
}

static RlvDetail plate(RlvSurface surface, int painted) {
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    RlvDetail detail = RLV_NULL;
    options.tile_size = paint.tile_size = 32;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    if (painted) {
        CHECK_OK(rlv_detail_add_paint(detail, &paint));
    }
    return detail;
}

/* Opens a file of these bytes on a bare detail, which is as bare afterwards if that fails. */
static RlvResult open_bytes(RlvSurface surface, const char *path, const unsigned char *bytes, size_t count) {
    FILE *file = fopen(path, "wb");
    RlvDetail detail = plate(surface, 0);
    RlvDocument document = {77};
    RlvDetailInfo info = RLV_DETAIL_INFO_INIT;
    CHECK(file != NULL && fwrite(bytes, 1, count, file) == count && fclose(file) == 0);
    const RlvResult result = rlv_document_open(detail, path, 0, &document);
    if (result == RLV_OK) {
        CHECK_OK(rlv_document_release(document));
    } else {
        CHECK(document.id == 77 && strstr(rlv_error_last(), path) != NULL);
        CHECK_OK(rlv_detail_commit(detail, NULL));
        CHECK_OK(rlv_detail_info(detail, &info));
        CHECK(info.allocated_count == 0 && info.painted_count == 0);
    }
    CHECK_OK(rlv_detail_release(detail));
    return result;
}

/* Documents that are newer, cut off or damaged are refused with their name, or open as far as they are whole. */
static void damaged(RlvSurface surface, const char *path) {
    static unsigned char bytes[1 << 20];
    char other[80];
    FILE *file = fopen(path, "rb");
    CHECK(file != NULL);
    const size_t count = fread(bytes, 1, sizeof bytes, file);
    CHECK(count > 100 && count < sizeof bytes && fclose(file) == 0);
    snprintf(other, sizeof other, "damaged-%p.relievo", (void *)&count);
    CHECK(open_bytes(surface, other, bytes, count) == RLV_OK);
    bytes[8] += 1;
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, open_bytes(surface, other, bytes, count), "newer relievo");
    bytes[8] -= 1;
    CHECK_FAILS(RLV_ERROR_INVALID, open_bytes(surface, other, (const unsigned char *)"v 0 0 0", 7), "begin as a document");
    CHECK(open_bytes(surface, other, bytes, 0) != RLV_OK && open_bytes(surface, other, bytes, 30) != RLV_OK);
    /* Cut or changed elsewhere it may open, with what is whole of it. */
    for (size_t part = 1; part < 16; ++part) {
        const size_t at = count * part / 16;
        open_bytes(surface, other, bytes, at);
        bytes[at] ^= 0x55;
        open_bytes(surface, other, bytes, count);
        bytes[at] ^= 0x55;
    }
    CHECK(remove(other) == 0);
}

int main(void) {
    static State states[EDITS + 1], now;
    char path[L_tmpnam + 16];
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL, other = RLV_NULL;
    RlvDocument document = RLV_NULL, again = RLV_NULL;
    RlvDocumentInfo info = RLV_DOCUMENT_INFO_INIT;
    RlvDocumentChanges changes = RLV_DOCUMENT_CHANGES_INIT;
    RlvDetail detail, copy;
    int k;
    snprintf(path, sizeof path, "document-%p.relievo", (void *)&context);
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh plane = check_plane(context, 3, 3), larger = check_plane(context, 4, 3);
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_surface_create(context, larger, NULL, &other));
    detail = plate(surface, 1);
    CHECK_OK(rlv_document_create(detail, NULL, 0, &document));
    keep(detail, &states[0]);
    for (k = 0; k < EDITS; ++k) {
        CHECK_OK(rlv_document_begin(document, "a stroke"));
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_begin(document, NULL), "under way");
        if (k > 0) {
            CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_undo(document, NULL), "under way");
        }
        stroke(context, detail, k);
        CHECK_OK(rlv_document_end(document, &changes));
        CHECK(changes.is_done == 1 && changes.layer_count == 1 && changes.block_count > 2 && changes.bytes > 0);
        keep(detail, &states[k + 1]);
    }
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_end(document, NULL), "begun");
    for (k = EDITS; k > 0; --k) {
        CHECK_OK(rlv_document_undo(document, &changes));
        keep(detail, &now);
        CHECK(changes.is_done == 1 && same(&now, &states[k - 1]));
    }
    CHECK_OK(rlv_document_undo(document, &changes));
    CHECK(changes.is_done == 0);
    CHECK_OK(rlv_document_info(document, &info));
    CHECK(info.undo_count == 0 && info.redo_count == EDITS && info.is_open == 0);
    for (k = 1; k <= EDITS; ++k) {
        CHECK_OK(rlv_document_redo(document, NULL));
    }
    keep(detail, &now);
    CHECK(same(&now, &states[EDITS]));
    CHECK_OK(rlv_document_begin(document, "given up"));
    stroke(context, detail, 5);
    CHECK_OK(rlv_document_abandon(document));
    keep(detail, &now);
    CHECK(same(&now, &states[EDITS]));

    /* To a file, with one more edit and one undone, and back into a bare detail. */
    CHECK_OK(rlv_document_save(document, path));
    CHECK_OK(rlv_document_begin(document, "one more"));
    stroke(context, detail, 3);
    CHECK_OK(rlv_document_end(document, NULL));
    CHECK_OK(rlv_document_undo(document, NULL));
    CHECK_OK(rlv_document_sync(document));
    copy = plate(surface, 0);
    CHECK((rlv_document_open(copy, path, 0, &again)) != RLV_OK);
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_document_open(copy, path, 0, &again));
    keep(copy, &now);
    CHECK(same(&now, &states[EDITS]));
    CHECK_OK(rlv_document_info(again, &info));
    CHECK(info.undo_count == EDITS && info.redo_count == 1);
    for (k = EDITS; k > 0; --k) {
        CHECK_OK(rlv_document_undo(again, NULL));
    }
    keep(copy, &now);
    CHECK(same(&now, &states[0]));
    for (k = 0; k < EDITS; ++k) {
        CHECK_OK(rlv_document_redo(again, NULL));
    }
    CHECK_OK(rlv_document_release(again));

    /* Folded, it is the same without a past. */
    CHECK_OK(rlv_document_compact(context, path, 2));
    CHECK_OK(rlv_document_open(copy, path, 0, &again));
    CHECK_OK(rlv_document_info(again, &info));
    keep(copy, &now);
    CHECK(info.undo_count == 2 && same(&now, &states[EDITS]));
    CHECK_OK(rlv_document_release(again));
    CHECK_OK(rlv_detail_release(copy));

    /* On a mesh twice as fine the same is seen, and the mesh is in the file. */
    {
        char moved[sizeof path];
        RlvTransferOptions how = RLV_TRANSFER_OPTIONS_INIT;
        RlvTransferReport report = RLV_TRANSFER_REPORT_INIT;
        RlvMeshInfo about = RLV_MESH_INFO_INIT;
        RlvMesh finer = check_plane(context, 6, 6), stored = RLV_NULL;
        RlvSurface fine = RLV_NULL;
        RlvDetail there = RLV_NULL;
        float half[49 * 3], height[2];
        const uint32_t tiles[2] = {4, 14};
        const float uvs[4] = {0.25f, 0.25f, 0.5f, 0.5f};
        int left = 0;
        CHECK_OK(rlv_mesh_get_points(finer, half, 49, 0));
        for (k = 0; k < 49 * 3; ++k) {
            half[k] *= 0.5f;
        }
        CHECK_OK(rlv_mesh_set_points(finer, half, 49, 0));
        snprintf(moved, sizeof moved, "moved-%p.relievo", (void *)&context);
        CHECK_FAILS(RLV_ERROR_CANCELLED,
                    rlv_document_transfer(context, finer, path, moved, NULL, check_patience, &left, NULL), "cancel");
        CHECK(!check_removed(moved));
        CHECK_OK(rlv_document_transfer(context, finer, path, moved, NULL, NULL, NULL, &report));
        CHECK(report.layer_count == 2 && report.lost_area == 0.0 && report.uncovered_area == 0.0);
        CHECK_NEAR(report.area, 9.0, 1e-4);
        CHECK_OK(rlv_surface_create(context, finer, NULL, &fine));
        there = plate(fine, 0);
        CHECK_OK(rlv_document_open(there, moved, 0, &again));
        CHECK_OK(rlv_detail_commit(there, NULL));
        RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
        arrays.count = 1;
        arrays.tiles = tiles;
        arrays.uvs = uvs;
        arrays.displacements = height;
        CHECK_OK(rlv_evaluate_detail(detail, &arrays));
        arrays.tiles = tiles + 1;
        arrays.uvs = uvs + 2;
        arrays.displacements = height + 1;
        CHECK_OK(rlv_evaluate_detail(there, &arrays));
        CHECK(height[0] != 0.0f);
        CHECK_NEAR(height[0], height[1], 0.01);
        CHECK_OK(rlv_document_release(again));
        CHECK_OK(rlv_document_mesh(context, moved, &stored));
        CHECK_OK(rlv_mesh_info(stored, &about));
        CHECK(about.face_count == 36 && about.point_count == 49 && about.high[0] == 3.0f);
        /* Back, from the mesh that is named; other meshes and paths are refused. */
        how.from = stored;
        how.reach = 0.01;
        CHECK_OK(rlv_document_transfer(context, plane, moved, moved, &how, NULL, NULL, &report));
        CHECK(report.reach == 0.01);
        how.reach = NAN;
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_transfer(context, finer, path, moved, &how, NULL, NULL, NULL), "faces");
        how.from.id = 0;
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_transfer(context, finer, path, moved, &how, NULL, NULL, NULL), "reach");
        how.from.id = context.id;
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_transfer(context, finer, path, moved, &how, NULL, NULL, NULL), "context");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_transfer(context, finer, path, NULL, NULL, NULL, NULL, NULL), "to_path");
        CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_document_mesh(context, "no/such.relievo", &stored), "no/such");
        CHECK(check_removed(moved));
        CHECK_OK(rlv_detail_release(there));
        CHECK_OK(rlv_surface_release(fine));
        CHECK_OK(rlv_mesh_release(stored));
        CHECK_OK(rlv_mesh_release(finer));
    }

    damaged(surface, path);

    /* Another cage is refused with what differs. */
    copy = plate(other, 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_open(copy, path, 0, &again), "9 faces");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_document_open(copy, "no/such.relievo", 0, &again), "no/such");
    CHECK_OK(rlv_detail_release(copy));
    CHECK(remove(path) == 0);
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_surface_release(other));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_mesh_release(larger));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
