/* Evaluation: a plane of unit quads is reproduced exactly inside, with its derivatives and normals. */
#include "check.h"

int main(void) {
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh plane = check_plane(context, 4, 4);
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_mesh_release(plane));

    enum { COUNT = 5 };
    static const struct {
        uint32_t tile;
        float uv[2];
    } places[COUNT] = {{5, {0.5f, 0.5f}}, {5, {0, 0}}, {6, {0.25f, 1}}, {9, {1, 0.75f}}, {10, {0.125f, 0.625f}}};
    float positions[COUNT][4], normals[COUNT][3], du[COUNT][3], dv[COUNT][3], duu[COUNT][3];
    memset(positions, 0, sizeof(positions));
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    arrays.count = COUNT;
    arrays.tiles = &places[0].tile;
    arrays.tile_stride = sizeof(places[0]);
    arrays.uvs = places[0].uv;
    arrays.uv_stride = sizeof(places[0]);
    arrays.positions = positions[0];
    arrays.position_stride = sizeof(positions[0]);
    arrays.normals = normals[0];
    arrays.du = du[0];
    arrays.dv = dv[0];
    arrays.duu = duu[0];
    CHECK_OK(rlv_evaluate_surface(surface, &arrays));
    for (int index = 0; index < COUNT; ++index) {
        float x = (float)(places[index].tile % 4) + places[index].uv[0];
        float y = (float)(places[index].tile / 4) + places[index].uv[1];
        CHECK_NEAR(positions[index][0], x, 1e-5);
        CHECK_NEAR(positions[index][1], y, 1e-5);
        CHECK_NEAR(positions[index][2], 0, 1e-6);
        CHECK(positions[index][3] == 0.0f);
        CHECK_NEAR(normals[index][2], 1, 1e-6);
        CHECK_NEAR(du[index][0], 1, 1e-5);
        CHECK_NEAR(dv[index][1], 1, 1e-5);
        CHECK_NEAR(duu[index][0], 0, 1e-4);
    }

    /* A place off the surface fails and writes nothing. */
    uint32_t tiles[2] = {5, 16};
    float uvs[4] = {0.5f, 0.5f, 0.5f, 0.5f};
    float out[6] = {7, 7, 7, 7, 7, 7};
    RlvEvaluateArrays bad = RLV_EVALUATE_ARRAYS_INIT;
    bad.count = 2;
    bad.tiles = tiles;
    bad.uvs = uvs;
    bad.positions = out;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_evaluate_surface(surface, &bad), "place 1: tile: tile 16");
    tiles[1] = 6;
    uvs[2] = 1.5f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_evaluate_surface(surface, &bad), "place 1: (1.5");
    uvs[2] = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_evaluate_surface(surface, &bad), "place 1");
    CHECK(out[0] == 7.0f && out[5] == 7.0f);
    bad.uvs = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_evaluate_surface(surface, &bad), "uvs");
    bad.uvs = uvs;
    bad.position_stride = 4;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_evaluate_surface(surface, &bad), "positions");
    bad.count = 0;
    bad.tiles = NULL;
    bad.uvs = NULL;
    CHECK_OK(rlv_evaluate_surface(surface, &bad));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_evaluate_surface(surface, NULL), "NULL");
    RlvSurface wrong = {context.id};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_evaluate_surface(wrong, &arrays), "of a context");

    /* Colours over a footprint: a black disc of radius 0.4 in a white tile is grey from afar, and the same everywhere
     * else; what is no number is no footprint. */
    RlvDetail detail = RLV_NULL;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    RlvBrushOptions kind = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvBrush brush = RLV_NULL;
    RlvStrokePoint point;
    memset(&point, 0, sizeof point);
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    kind.falloff = RLV_FALLOFF_CONSTANT;
    kind.color[0] = kind.color[1] = kind.color[2] = 0.0f;
    settings.radius = 0.4f;
    CHECK_OK(rlv_brush_create(context, &kind, &settings, &brush));
    point.position[0] = point.position[1] = 2.5;
    point.pressure = 1.0f;
    CHECK_OK(rlv_stroke_run(detail, brush, &point, 1, 0, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    const uint32_t at_tiles[4] = {10, 10, 10, 0};
    const float at[4][2] = {{0.5f, 0.5f}, {0.5f, 0.5f}, {0.5f, 0.5f}, {0.5f, 0.5f}};
    const float footprints[4][4] = {{1, 0, 0, 1}, {NAN, 0, 0, INFINITY}, {0.01f, 0, 0, 0.01f}, {1, 0, 0, 1}};
    float colors[4][4];
    RlvEvaluateArrays looked = RLV_EVALUATE_ARRAYS_INIT;
    looked.count = 4;
    looked.tiles = at_tiles;
    looked.uvs = at[0];
    looked.colors = colors[0];
    looked.footprints = footprints[0];
    CHECK_OK(rlv_evaluate_detail(detail, &looked));
    CHECK(colors[0][0] > 0.3 && colors[0][0] < 0.6);
    CHECK_NEAR(colors[1][0], 0, 1e-6);
    CHECK_NEAR(colors[2][0], 0, 1e-6);
    CHECK_NEAR(colors[3][0], 1, 1e-6);
    looked.footprint_stride = 4;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_evaluate_detail(detail, &looked), "footprints");
    CHECK_OK(rlv_brush_release(brush));
    CHECK_OK(rlv_detail_release(detail));

    /* Colours of half floats are brighter than 1, wherever they are looked at or kept. */
    RlvChannelInfo channel = RLV_CHANNEL_INFO_INIT;
    RlvDetail again = RLV_NULL;
    unsigned char block[8 * 130 * 130];
    size_t size = 0;
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    paint.format = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_add_paint(detail, &paint), "format 2");
    paint.format = RLV_COLOR_RGBA8;
    paint.color[1] = 300.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_add_paint(detail, &paint), "from 0 to 1");
    paint.format = RLV_COLOR_RGBA16F;
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_add_paint(detail, &paint), "colours");
    kind.color[0] = 10000.0f;
    kind.color[1] = 0.25f;
    CHECK_OK(rlv_brush_create(context, &kind, &settings, &brush));
    CHECK_OK(rlv_stroke_run(detail, brush, &point, 1, 0, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    looked.footprint_stride = 0;
    CHECK_OK(rlv_evaluate_detail(detail, &looked));
    CHECK(colors[0][0] > 3000 && colors[0][0] < 7000);
    CHECK_NEAR(colors[2][0], 10000, 1e-3);
    CHECK_NEAR(colors[2][1], 0.25, 1e-6);
    CHECK_NEAR(colors[3][1], 300, 1e-3);
    CHECK_OK(rlv_detail_channel_info(detail, RLV_CHANNEL_COLOR, &channel));
    CHECK(channel.is_there == 1 && channel.texel_size == 8 && channel.allocated_count == 1);
    CHECK_OK(rlv_detail_read_block(detail, RLV_CHANNEL_COLOR, 10, block, sizeof block, &size));
    CHECK(size == sizeof block);
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &again));
    CHECK_OK(rlv_detail_add_paint(again, &paint));
    CHECK_OK(rlv_detail_write_block(again, RLV_CHANNEL_COLOR, 10, block, size));
    CHECK_OK(rlv_detail_commit(again, NULL));
    memset(colors, 0, sizeof colors);
    CHECK_OK(rlv_evaluate_detail(again, &looked));
    CHECK_NEAR(colors[2][0], 10000, 1e-3);
    CHECK_OK(rlv_brush_release(brush));
    CHECK_OK(rlv_detail_release(again));
    CHECK_OK(rlv_detail_release(detail));

    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
