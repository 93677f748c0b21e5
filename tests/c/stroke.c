/* Strokes: what is drawn bit by bit is what is drawn at once, an eraser gives back all memory, bad points do
 * nothing. */
#include "check.h"

enum { POINTS = 24 };

static void way(RlvStrokePoint *points) {
    for (int k = 0; k < POINTS; ++k) {
        points[k].position[0] = 0.5 + 0.2 * k;
        points[k].position[1] = 3.0 + sin(0.4 * k);
        points[k].position[2] = 0.02;
        points[k].pressure = 0.3 + 0.02 * k;
        points[k].time = 0.02 * k;
    }
}

static int same(RlvDetail one, RlvDetail other, uint32_t tile) {
    static unsigned char blocks[2][70000];
    size_t sizes[2] = {0, 0};
    CHECK_OK(rlv_detail_read_block(one, RLV_CHANNEL_DISPLACEMENT, tile, blocks[0], sizeof blocks[0], &sizes[0]));
    CHECK_OK(rlv_detail_read_block(other, RLV_CHANNEL_DISPLACEMENT, tile, blocks[1], sizeof blocks[1], &sizes[1]));
    return sizes[0] == sizes[1] && memcmp(blocks[0], blocks[1], sizes[0]) == 0;
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvDetail whole = RLV_NULL, drawn = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvDetailInfo info = RLV_DETAIL_INFO_INIT;
    RlvBrushOptions kind = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvStrokeReport report = RLV_STROKE_REPORT_INIT;
    RlvStrokePoint points[POINTS];
    RlvBrush brush = RLV_NULL;
    RlvStroke stroke = RLV_NULL;
    uint64_t dabs = 0;
    int k;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh plane = check_plane(context, 6, 6);
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    options.tile_size = 32;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &whole));
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &drawn));
    kind.action = RLV_BRUSH_SCULPT;
    kind.mode = RLV_SCULPT_DRAW;
    kind.height = 0.1f;
    settings.radius = 0.4f;
    settings.jitter_angle = 1.0f;
    settings.jitter_position = 0.1f;
    settings.rate = 20.0f;
    CHECK_OK(rlv_brush_create(context, &kind, &settings, &brush));
    way(points);

    CHECK_OK(rlv_stroke_run(whole, brush, points, POINTS, 0, &report));
    CHECK(report.dabs > 40 && report.missed_dabs == 0 && report.changed_tiles > 5 && report.bytes > 0);
    CHECK_OK(rlv_stroke_begin(drawn, brush, &stroke));
    for (k = 0; k < POINTS; k += 4) {
        RlvStrokeReport part = RLV_STROKE_REPORT_INIT;
        CHECK_OK(rlv_stroke_extend(stroke, points + k, 4, sizeof points[0], &part));
        dabs += part.dabs;
        /* What was drawn so far can be seen. */
        CHECK_OK(rlv_detail_commit(drawn, NULL));
    }
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_stroke_extend(stroke, points, 1, 0, NULL), "time");
    CHECK_OK(rlv_stroke_end(stroke, NULL));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_stroke_end(stroke, NULL), "ended");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_stroke_extend(stroke, points, 1, 0, NULL), "ended");
    CHECK_OK(rlv_stroke_release(stroke));
    CHECK(dabs == report.dabs);
    CHECK_OK(rlv_detail_commit(whole, NULL));
    CHECK_OK(rlv_detail_commit(drawn, NULL));
    CHECK(check_displacement(whole, 14, 0.5f, 0.5f) != 0.0f || check_displacement(whole, 20, 0.5f, 0.5f) != 0.0f);
    for (k = 0; k < 36; ++k) {
        CHECK(same(whole, drawn, (uint32_t)k));
    }

    /* At half the texels faces without a tile get tiles of that size. */
    {
        RlvDetail rough = RLV_NULL;
        RlvDetailTileInfo tile = RLV_DETAIL_TILE_INFO_INIT;
        CHECK_OK(rlv_detail_create(surface, &options, NULL, &rough));
        settings.level = 1;
        CHECK_OK(rlv_brush_set(brush, &kind, &settings));
        CHECK_OK(rlv_stroke_run(rough, brush, points, POINTS, 0, &report));
        CHECK_OK(rlv_detail_commit(rough, NULL));
        CHECK_OK(rlv_detail_tile_info(rough, RLV_CHANNEL_DISPLACEMENT, 20, &tile));
        CHECK(report.changed_tiles > 5 && tile.is_allocated == 1 && tile.size == 16);
        settings.level = 3;
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_set(brush, &kind, &settings), "level");
        settings.level = 0;
        CHECK_OK(rlv_detail_release(rough));
    }

    /* Off the surface nothing happens, and that is said. */
    for (k = 0; k < POINTS; ++k) {
        points[k].position[2] = 50.0;
    }
    CHECK_OK(rlv_stroke_run(whole, brush, points, POINTS, 0, &report));
    CHECK(report.dabs == 0 && report.missed_dabs > 40 && report.changed_tiles == 0);
    way(points);

    /* A budget smaller than a tile refuses all of it, and says which faces. */
    RlvDetail poor = RLV_NULL;
    RlvDetailOptions little = RLV_DETAIL_OPTIONS_INIT;
    RlvDetailInfo kept = RLV_DETAIL_INFO_INIT;
    size_t refused = 0;
    little.budget = 10;
    CHECK_OK(rlv_detail_create(surface, &little, NULL, &poor));
    CHECK_OK(rlv_stroke_run(poor, brush, points, POINTS, 0, &report));
    CHECK(report.refused_tiles > 5 && report.changed_tiles == 0 && report.bytes == 0);
    CHECK_OK(rlv_detail_refused_faces(poor, NULL, 0, &refused));
    CHECK(refused > 5 && refused <= report.refused_tiles);
    CHECK_OK(rlv_detail_commit(poor, NULL));
    CHECK_OK(rlv_detail_info(poor, &kept));
    CHECK(kept.allocated_count == 0 && kept.bytes == 0);
    CHECK_OK(rlv_detail_release(poor));

    points[3].pressure = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_stroke_run(whole, brush, points, POINTS, 0, NULL), "pressure");
    points[3].pressure = 1.0;
    points[3].time = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_stroke_run(whole, brush, points, POINTS, 0, NULL), "time");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_stroke_run(whole, brush, points, 0, 0, NULL), "points");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_stroke_run(whole, brush, NULL, 3, 0, NULL), "points");

    /* An eraser over all of it leaves nothing. */
    kind.mode = RLV_SCULPT_ERASE;
    kind.falloff = RLV_FALLOFF_CONSTANT;
    settings.radius = 9.0f;
    settings.rate = settings.jitter_angle = settings.jitter_position = 0.0f;
    CHECK_OK(rlv_brush_set(brush, &kind, &settings));
    points[0].position[0] = points[0].position[1] = 3.0;
    points[0].pressure = 1.0;
    CHECK_OK(rlv_stroke_run(whole, brush, points, 1, 0, &report));
    CHECK(report.freed_tiles > 5 && report.bytes == 0);
    CHECK_OK(rlv_detail_commit(whole, NULL));
    CHECK_OK(rlv_detail_info(whole, &info));
    CHECK(info.allocated_count == 0 && info.bytes == 0);

    /* A stamp of vectors and a pinch want vector displacement; the eraser takes that away too. */
    {
        const float pixel[3] = {0.25f, 0.0f, 0.5f};
        RlvStampOptions stamp = RLV_STAMP_OPTIONS_INIT;
        RlvStampSettings numbers = RLV_STAMP_SETTINGS_INIT;
        RlvVectorOptions vectors = RLV_VECTOR_OPTIONS_INIT;
        RlvChannelInfo channel = RLV_CHANNEL_INFO_INIT;
        kind.mode = RLV_SCULPT_VECTOR;
        kind.height = 1.0f;
        settings.radius = 0.8f;
        CHECK_OK(rlv_brush_set(brush, &kind, &settings));
        stamp.width = stamp.height = 1;
        stamp.channels = 3;
        stamp.pixels = pixel;
        numbers.mid = 0.0f;
        numbers.scale = 1.0f;
        CHECK_OK(rlv_brush_set_stamp(brush, &stamp, &numbers));
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_stroke_run(whole, brush, points, 1, 0, NULL), "vector displacement");
        vectors.tile_size = 32;
        CHECK_OK(rlv_detail_add_vectors(whole, &vectors));
        CHECK_OK(rlv_stroke_run(whole, brush, points, 1, 0, &report));
        CHECK(report.dabs == 1 && report.changed_tiles > 0 && report.bytes > 0);
        CHECK_OK(rlv_brush_set_stamp(brush, NULL, NULL));
        kind.mode = RLV_SCULPT_PINCH;
        kind.falloff = RLV_FALLOFF_SMOOTH;
        CHECK_OK(rlv_brush_set(brush, &kind, &settings));
        points[0].position[2] = 0.5;
        CHECK_OK(rlv_stroke_run(whole, brush, points, 1, 0, &report));
        CHECK(report.dabs == 1 && report.changed_texels > 10);
        CHECK_OK(rlv_detail_commit(whole, NULL));
        CHECK_OK(rlv_detail_channel_info(whole, RLV_CHANNEL_VECTORS, &channel));
        CHECK(channel.is_there == 1 && channel.allocated_count > 0);
        kind.mode = RLV_SCULPT_ERASE;
        kind.falloff = RLV_FALLOFF_CONSTANT;
        settings.radius = 9.0f;
        CHECK_OK(rlv_brush_set(brush, &kind, &settings));
        CHECK_OK(rlv_stroke_run(whole, brush, points, 1, 0, &report));
        CHECK(report.freed_tiles > 0 && report.bytes == 0);
    }

    CHECK_OK(rlv_brush_release(brush));
    CHECK_OK(rlv_detail_release(whole));
    CHECK_OK(rlv_detail_release(drawn));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
