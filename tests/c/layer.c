/* Layers: paint and displacement on layers of their own, seen as they are set, merged and flattened. */
#include "check.h"

static void dab(RlvContext context, RlvDetail detail, const RlvBrushOptions *options) {
    const RlvStrokePoint point = {{1.5, 1.5, 0.0}, 1.0, -1.0};
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvStrokeReport report = RLV_STROKE_REPORT_INIT;
    RlvBrush brush = RLV_NULL;
    settings.radius = 0.4f;
    CHECK_OK(rlv_brush_create(context, options, &settings, &brush));
    CHECK_OK(rlv_stroke_run(detail, brush, &point, 1, 0, &report));
    CHECK(report.dabs == 1 && report.changed_tiles == 1);
    CHECK_OK(rlv_brush_release(brush));
}

static RlvLayerInfo layer_of(RlvDetail detail, size_t index) {
    RlvLayerInfo layer = RLV_LAYER_INFO_INIT;
    CHECK_OK(rlv_layer_info(detail, index, &layer));
    return layer;
}

/* What is set outside of edits is no step of undo: it stays, and redo brings it back where undo takes the layer away. */
static void check_outside_edits(RlvContext context, RlvDetail detail, const RlvBrushOptions *raise) {
    RlvLayerOptions options = RLV_LAYER_OPTIONS_INIT;
    RlvDocument document = RLV_NULL;
    uint32_t added;
    size_t before, count;
    CHECK_OK(rlv_layer_count(detail, &before));
    CHECK_OK(rlv_document_create(detail, NULL, 0, &document));
    CHECK_OK(rlv_document_begin(document, "add a layer"));
    CHECK_OK(rlv_layer_add(detail, "added", &options, &added));
    CHECK_OK(rlv_document_end(document, NULL));
    CHECK_OK(rlv_document_begin(document, "sculpt"));
    dab(context, detail, raise);
    CHECK_OK(rlv_document_end(document, NULL));
    options.opacity = 0.25f;
    options.is_visible = 0;
    CHECK_OK(rlv_layer_set(detail, added, &options));
    CHECK(layer_of(detail, 1).id == added && layer_of(detail, 1).tile_count == 1);
    CHECK_OK(rlv_document_undo(document, NULL));
    CHECK(layer_of(detail, 1).opacity == 0.25f && layer_of(detail, 1).is_visible == 0);
    CHECK(layer_of(detail, 1).tile_count == 0);
    CHECK_OK(rlv_document_undo(document, NULL));
    CHECK_OK(rlv_layer_count(detail, &count));
    CHECK(count == before);
    CHECK_OK(rlv_document_redo(document, NULL));
    CHECK(layer_of(detail, 1).id == added && layer_of(detail, 1).opacity == 0.25f && layer_of(detail, 1).is_visible == 0);
    CHECK_OK(rlv_document_redo(document, NULL));
    CHECK(layer_of(detail, 1).opacity == 0.25f && layer_of(detail, 1).tile_count == 1);
    CHECK_OK(rlv_document_release(document));
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDetailOptions detail_options = RLV_DETAIL_OPTIONS_INIT;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    RlvDetailInfo info = RLV_DETAIL_INFO_INIT;
    RlvLayerOptions options = RLV_LAYER_OPTIONS_INIT;
    RlvLayerInfo layer = RLV_LAYER_INFO_INIT;
    RlvBrushOptions red = RLV_BRUSH_OPTIONS_INIT, raise = RLV_BRUSH_OPTIONS_INIT;
    float height, color[4];
    uint32_t bumps, glaze, nothing;
    size_t count;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh plane = check_plane(context, 3, 3);
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    detail_options.tile_size = paint.tile_size = options.tile_size = 32;
    CHECK_OK(rlv_detail_create(surface, &detail_options, NULL, &detail));
    red.color[1] = red.color[2] = 0.0f;
    raise.action = RLV_BRUSH_SCULPT;
    raise.mode = RLV_SCULPT_DRAW;
    raise.height = 0.05f;

    /* Without colours nothing can be painted, and no layer be of colour. */
    {
        const RlvStrokePoint point = {{1.5, 1.5, 0.0}, 1.0, -1.0};
        RlvBrush brush = RLV_NULL;
        CHECK_OK(rlv_brush_create(context, &red, NULL, &brush));
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_stroke_run(detail, brush, &point, 1, 0, NULL), "no colours");
        CHECK_OK(rlv_brush_release(brush));
        options.kind = RLV_LAYER_COLOR;
        options.blend = RLV_BLEND_NORMAL;
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_layer_add(detail, "glaze", &options, &glaze), "no colours");
    }
    /* Triangles have colours once these are committed. */
    {
        RlvTessellation triangles = RLV_NULL;
        CHECK_OK(rlv_detail_commit(detail, NULL));
        CHECK_OK(rlv_tessellation_create(detail, NULL, &triangles));
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_tessellation_get_colors(triangles, 0, 1, color, 0), "rlv_detail_add_paint");
        paint.color[0] = 0.25f;
        CHECK_OK(rlv_detail_add_paint(detail, &paint));
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_tessellation_get_colors(triangles, 0, 1, color, 0), "commit it and update");
        CHECK_OK(rlv_detail_commit(detail, NULL));
        CHECK_OK(rlv_tessellation_update(triangles, NULL));
        CHECK_OK(rlv_tessellation_get_colors(triangles, 0, 1, color, 0));
        CHECK_NEAR(color[0], 0.25, 0.01);
        CHECK_OK(rlv_tessellation_release(triangles));
    }
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_add_paint(detail, &paint), "already");
    dab(context, detail, &red);
    dab(context, detail, &raise);
    check_look(detail, 4, color, &height);
    CHECK_NEAR(height, 0.05, 0.002);
    CHECK(color[0] > 0.95f && color[1] < 0.05f);
    CHECK_OK(rlv_detail_info(detail, &info));
    CHECK(info.is_painted == 1 && info.painted_count == 1 && info.paint_bytes > 0 && info.allocated_count == 1);

    /* A second layer of each. */
    CHECK_OK(rlv_layer_count(detail, &count));
    CHECK(count == 2);
    CHECK_OK(rlv_layer_add(detail, "glaze", &options, &glaze));
    options.kind = RLV_LAYER_DISPLACEMENT;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_layer_add(detail, "bumps", &options, &bumps), "normal");
    options.blend = RLV_BLEND_ADD;
    options.opacity = 0.5f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_layer_add(detail, "glaze", &options, &bumps), "name");
    CHECK_OK(rlv_layer_add(detail, "bumps", &options, &bumps));
    CHECK_OK(rlv_layer_count(detail, &count));
    CHECK(count == 4 && glaze != bumps);
    CHECK_OK(rlv_layer_info(detail, 1, &layer));
    CHECK(layer.id == bumps && strcmp(layer.name, "bumps") == 0 && layer.opacity == 0.5f && layer.is_active == 1);
    CHECK(layer.kind == RLV_LAYER_DISPLACEMENT && layer.blend == RLV_BLEND_ADD && layer.tile_count == 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_layer_info(detail, 4, &layer), "index");
    red.color[0] = 0.0f;
    red.color[1] = 1.0f;
    dab(context, detail, &red);
    dab(context, detail, &raise);
    check_look(detail, 4, color, &height);
    CHECK_NEAR(height, 0.1, 0.004);
    CHECK(color[0] < 0.05f && color[1] > 0.95f);

    /* Hidden, half seen, gone. */
    options.is_visible = 0;
    CHECK_OK(rlv_layer_set(detail, bumps, &options));
    check_look(detail, 4, color, &height);
    CHECK_NEAR(height, 0.05, 0.002);
    options.is_visible = 1;
    options.opacity = 0.25f;
    CHECK_OK(rlv_layer_set(detail, bumps, &options));
    check_look(detail, 4, color, &height);
    CHECK_NEAR(height, 0.075, 0.004);
    CHECK_OK(rlv_layer_merge(detail, bumps));
    check_look(detail, 4, color, &height);
    CHECK_NEAR(height, 0.075, 0.004);
    CHECK_OK(rlv_layer_rename(detail, glaze, "varnish"));
    CHECK_OK(rlv_layer_set_active(detail, glaze));
    CHECK_OK(rlv_layer_place(detail, glaze, 0));
    check_look(detail, 4, color, &height);
    CHECK(color[0] > 0.95f && color[1] < 0.05f);
    CHECK_OK(rlv_layer_remove(detail, glaze));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_layer_remove(detail, glaze), "layer");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_layer_set_active(detail, 99), "layer");
    CHECK_OK(rlv_layer_flatten(detail));
    CHECK_OK(rlv_layer_count(detail, &count));
    CHECK(count == 2);
    check_look(detail, 4, color, &height);
    CHECK_NEAR(height, 0.075, 0.004);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_layer_add(detail, "a", NULL, &nothing), "RlvLayerOptions");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_layer_add(detail, NULL, &options, &nothing), "name");

    /* Triangles carry the colours. */
    {
        RlvTessellation triangles = RLV_NULL;
        RlvTessellationInfo points = RLV_TESSELLATION_INFO_INIT;
        float *colors, most = 0.0f;
        CHECK_OK(rlv_tessellation_create(detail, NULL, &triangles));
        CHECK_OK(rlv_tessellation_info(triangles, &points));
        colors = malloc(12 * points.point_count);
        CHECK(colors != NULL);
        CHECK_OK(rlv_tessellation_get_colors(triangles, 0, points.point_count, colors, 0));
        for (count = 0; count < points.point_count; ++count) {
            most = colors[3 * count] > most ? colors[3 * count] : most;
        }
        CHECK(most > 0.95f);
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_tessellation_get_colors(triangles, 1, points.point_count, colors, 0), "points");
        free(colors);
        CHECK_OK(rlv_tessellation_release(triangles));
    }
    check_outside_edits(context, detail, &raise);
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
