/* Brushes: what they are made of is checked, and their tables describe their structs. */
#include "check.h"

static void tables(void) {
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvStampSettings stamp = RLV_STAMP_SETTINGS_INIT;
    const RlvParameter *params = NULL;
    size_t count = 0, i;
    CHECK_OK(rlv_brush_params(&params, &count));
    CHECK(count == sizeof settings / 4 - 1);
    for (i = 0; i < count; i++) {
        const char *field = (const char *)&settings + params[i].offset;
        float real;
        uint32_t whole;
        memcpy(&real, field, 4);
        memcpy(&whole, field, 4);
        CHECK(params[i].value == (params[i].kind == RLV_PARAMETER_F32 ? (double)real : (double)whole) ||
              fabs(params[i].value - (double)real) < 1e-6);
        CHECK(params[i].min <= params[i].value && params[i].value <= params[i].max && strlen(params[i].help) > 0);
    }
    CHECK_OK(rlv_brush_stamp_params(&params, &count));
    CHECK(count == sizeof stamp / 4 - 1 && strcmp(params[0].name, "angle") == 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_params(NULL, &count), "params");
}

static void refusals(RlvContext context) {
    RlvBrushOptions options = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvBrush brush = RLV_NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_create(context, NULL, NULL, &brush), "RlvBrushOptions");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_create(context, &options, NULL, NULL), "out");
    options.action = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_create(context, &options, NULL, &brush), "action");
    options.action = RLV_BRUSH_SCULPT;
    options.mode = 99;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_create(context, &options, NULL, &brush), "mode");
    options.mode = RLV_SCULPT_CLAY;
    options.falloff = 5;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_create(context, &options, NULL, &brush), "falloff");
    options.falloff = RLV_FALLOFF_SPHERE;
    options.height = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_create(context, &options, NULL, &brush), "height");
    options.height = 0.1f;
    settings.radius = -1.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_create(context, &options, &settings, &brush), "radius");
    settings.radius = 0.5f;
    CHECK_OK(rlv_brush_create(context, &options, &settings, &brush));
    settings.spacing = 0.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_set(brush, &options, &settings), "spacing");
    settings.spacing = 0.5f;
    CHECK_OK(rlv_brush_set(brush, &options, &settings));
    CHECK_OK(rlv_brush_retain(brush));
    CHECK_OK(rlv_brush_release(brush));
    CHECK_OK(rlv_brush_release(brush));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_release(brush), "brush");
}

static void parts(RlvContext context) {
    const double curve[] = {0.0, 0.2, 0.5, 0.9, 1.0, 1.0}, back[] = {0.5, 0.0, 0.4, 1.0};
    const float pixels[12] = {0.0f, 0.5f, 1.0f, 0.25f, 0.5f, 0.75f, 1.0f, 0.0f, 0.1f, 0.2f, 0.3f, 0.4f};
    RlvBrushOptions options = RLV_BRUSH_OPTIONS_INIT;
    RlvStampOptions stamp = RLV_STAMP_OPTIONS_INIT;
    RlvStampSettings settings = RLV_STAMP_SETTINGS_INIT;
    RlvBrush brush = RLV_NULL;
    CHECK_OK(rlv_brush_create(context, &options, NULL, &brush));
    CHECK_OK(rlv_brush_set_curve(brush, RLV_CURVE_SIZE, curve, 3));
    CHECK_OK(rlv_brush_set_curve(brush, RLV_CURVE_ANGLE, NULL, 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_set_curve(brush, 3, curve, 3), "curve");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_set_curve(brush, RLV_CURVE_STRENGTH, back, 2), "curve");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_set_curve(brush, RLV_CURVE_STRENGTH, NULL, 2), "points");

    stamp.pixels = pixels;
    stamp.width = 4;
    stamp.height = 3;
    stamp.channels = 1;
    CHECK_OK(rlv_brush_set_stamp(brush, &stamp, &settings));
    settings.repeat = 0.5f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_set_stamp(brush, &stamp, &settings), "repeat");
    stamp.width = 40000;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_set_stamp(brush, &stamp, NULL), "stamp");
    stamp.width = 4;
    stamp.channels = 5;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_set_stamp(brush, &stamp, NULL), "stamp");
    stamp.channels = 1;
    stamp.channel = 4;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_set_stamp(brush, &stamp, NULL), "channel");
    stamp.channel = 0;
    stamp.pixels = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_brush_set_stamp(brush, &stamp, NULL), "pixels");
    CHECK_OK(rlv_brush_set_stamp(brush, NULL, NULL));
    CHECK_OK(rlv_brush_release(brush));
}

int main(void) {
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    tables();
    refusals(context);
    parts(context);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
