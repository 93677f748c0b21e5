/* Ptex: what is written is read back, into a detail that had nothing; damaged files and others' are refused. */
#include "sheet.h"

/* The middle of every tile: displacement, vector and colour, as far as a detail has them. */
typedef struct Middle {
    float displacements[9], vectors[9][3], colors[9][4];
} Middle;

static Middle middle(RlvDetail detail, int painted) {
    Middle out;
    uint32_t tiles[9];
    float uvs[9][2];
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    memset(&out, 0, sizeof out);
    for (uint32_t tile = 0; tile < 9; ++tile) {
        tiles[tile] = tile;
        uvs[tile][0] = uvs[tile][1] = 0.45f;
    }
    CHECK_OK(rlv_detail_commit(detail, NULL));
    arrays.count = 9;
    arrays.tiles = tiles;
    arrays.uvs = uvs[0];
    arrays.displacements = out.displacements;
    arrays.vectors = out.vectors[0];
    arrays.colors = painted ? out.colors[0] : NULL;
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
    return out;
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL, other = RLV_NULL;
    RlvDetail detail = RLV_NULL, copy = RLV_NULL, foreign = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    RlvVectorOptions vectors = RLV_VECTOR_OPTIONS_INIT;
    RlvPtexOptions how = RLV_PTEX_OPTIONS_INIT;
    RlvPtexReport report = RLV_PTEX_REPORT_INIT;
    char paths[3][64];
    unsigned char block[600];
    int patience = 0;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh plane = check_plane(context, 3, 3), larger = check_plane(context, 4, 3);
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_surface_create(context, larger, NULL, &other));
    options.tile_size = paint.tile_size = 32;
    vectors.tile_size = 8;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    CHECK_OK(rlv_detail_add_vectors(detail, &vectors));
    CHECK_OK(rlv_detail_add_traces(detail, 0));
    check_stroke(context, detail, RLV_BRUSH_PAINT, 2.6, 1.9, 0.5f);
    check_stroke(context, detail, RLV_BRUSH_SCULPT, 2.6, 1.9, 0.5f);
    for (size_t texel = 0; texel < 100; ++texel) {
        const unsigned char value[6] = {0x00, 0x34, 0x00, 0xb8, 0, 0};
        memcpy(block + 6 * texel, value, 6);
    }
    CHECK_OK(rlv_detail_write_block(detail, RLV_CHANNEL_VECTORS, 4, block, sizeof(block)));
    const Middle before = middle(detail, 1);
    CHECK(before.displacements[4] > 0.1f && before.colors[4][1] < 0.5f && before.vectors[4][0] > 0.2f);

    static const uint32_t channels[3] = {RLV_CHANNEL_DISPLACEMENT, RLV_CHANNEL_COLOR, RLV_CHANNEL_VECTORS};
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &copy));
    CHECK_OK(rlv_detail_add_traces(copy, 0));
    CHECK_OK(rlv_detail_create(other, NULL, NULL, &foreign));
    for (int k = 0; k < 3; ++k) {
        snprintf(paths[k], sizeof paths[k], "ptex-%p-%d.ptx", (void *)&context, k);
        CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_ptex_write(detail, channels[k], paths[k], check_patience, &patience), "cancel");
        patience = 0;
        CHECK(!check_removed(paths[k]));
        CHECK_OK(rlv_ptex_write(detail, channels[k], paths[k], NULL, NULL));
        CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_ptex_read(copy, paths[k], NULL, check_patience, &patience, NULL), "cancel");
        patience = 0;
        CHECK_OK(rlv_ptex_read(copy, paths[k], NULL, NULL, NULL, &report));
        CHECK(report.channel == channels[k] && report.face_count == 9 && report.ignored_numbers == 0);
        CHECK(report.squared_count == 0 && report.deviation < 0.01f);
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_ptex_read(foreign, paths[k], NULL, NULL, NULL, &report), "faces");
    }
    const Middle after = middle(copy, 1);
    for (int tile = 0; tile < 9; ++tile) {
        CHECK_NEAR(after.displacements[tile], before.displacements[tile], 1e-3);
        CHECK_NEAR(after.colors[tile][1], before.colors[tile][1], 1e-6);
        CHECK_NEAR(after.vectors[tile][0], before.vectors[tile][0], 1e-3);
    }
    /* Imprints go on with the sizes of the file. */
    RlvMesh ball = check_ball(context, 0.3);
    RlvCollider collider = RLV_NULL;
    CHECK_OK(rlv_collider_create_mesh(context, ball, NULL, &collider));
    CHECK_OK(rlv_imprint_run(copy, collider, NULL, NULL, NULL));

    /* Displacement read as colours is grey. */
    how.kind = RLV_PTEX_COLOR;
    CHECK_OK(rlv_ptex_read(copy, paths[0], &how, NULL, NULL, &report));
    CHECK(report.channel == RLV_CHANNEL_COLOR);
    how.kind = RLV_PTEX_VECTORS;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_ptex_read(copy, paths[0], &how, NULL, NULL, NULL), "channels");
    how.kind = 4;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_ptex_read(copy, paths[0], &how, NULL, NULL, NULL), "kind 4");
    how.kind = RLV_PTEX_STATED;
    how.budget = 10;
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_ptex_read(copy, paths[0], &how, NULL, NULL, NULL), "allow");
    /* Cut off anywhere, and of another format, files are refused with their name. */
    static char bytes[1 << 16];
    FILE *whole = fopen(paths[2], "rb"), *damaged;
    CHECK(whole != NULL);
    const size_t count = fread(bytes, 1, sizeof bytes, whole);
    CHECK(count > 64 && fclose(whole) == 0);
    for (size_t part = 0; part < 8; ++part) {
        damaged = fopen(paths[2], "wb");
        CHECK(damaged != NULL && fwrite(bytes, 1, count * part / 8, damaged) == count * part / 8 && fclose(damaged) == 0);
        CHECK(rlv_ptex_read(copy, paths[2], NULL, NULL, NULL, NULL) != RLV_OK && strstr(rlv_error_last(), paths[2]) != NULL);
    }
    damaged = fopen(paths[2], "r+b");
    CHECK(damaged != NULL && fwrite("Qtex", 4, 1, damaged) == 1 && fclose(damaged) == 0);
    CHECK(rlv_ptex_read(copy, paths[2], NULL, NULL, NULL, NULL) != RLV_OK && strstr(rlv_error_last(), paths[2]) != NULL);
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_ptex_read(copy, "no/such.ptx", NULL, NULL, NULL, NULL), "no/such");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_ptex_write(detail, RLV_CHANNEL_TRACES, paths[2], NULL, NULL), "traces");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_ptex_write(foreign, RLV_CHANNEL_COLOR, paths[2], NULL, NULL), "colours");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_ptex_write(foreign, 9, paths[2], NULL, NULL), "channel 9");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_ptex_write(foreign, RLV_CHANNEL_DISPLACEMENT, NULL, NULL, NULL), "path");

    for (int k = 0; k < 3; ++k) {
        CHECK(check_removed(paths[k]));
    }
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_detail_release(copy));
    CHECK_OK(rlv_detail_release(foreign));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_surface_release(other));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_mesh_release(larger));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
