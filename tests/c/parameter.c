/* The tables of parameters are the settings structs: offsets, defaults, ranges and texts. */
#include "check.h"

static void same(const RlvParameter *params, size_t count, const void *settings, size_t size) {
    CHECK(count > 0 && size == 4 + 4 * count);
    for (size_t index = 0; index < count; ++index) {
        const RlvParameter *param = &params[index];
        const char *field = (const char *)settings + param->offset;
        float number;
        uint32_t whole;
        CHECK(param->offset == 4 + 4 * index && param->min <= param->value && param->value <= param->max);
        CHECK(strlen(param->name) > 0 && strlen(param->help) > 10 && param->unit != NULL);
        memcpy(&number, field, 4);
        memcpy(&whole, field, 4);
        if (param->kind == RLV_PARAMETER_F32) {
            CHECK_NEAR(number, param->value, 1e-6 * fabs(param->value));
        } else {
            CHECK((double)whole == param->value);
        }
    }
}

int main(void) {
    const RlvParameter *params = NULL;
    size_t count = 0;
    RlvImprintSettings imprint = RLV_IMPRINT_SETTINGS_INIT;
    CHECK_OK(rlv_imprint_params(&params, &count));
    same(params, count, &imprint, sizeof(imprint));
    CHECK(strcmp(params[0].name, "voxels") == 0 && params[0].kind == RLV_PARAMETER_U32);
    const RlvParameter *first = params;
    CHECK_OK(rlv_imprint_params(&params, &count));
    CHECK(params == first);

    RlvToolSettings tool = RLV_TOOL_SETTINGS_INIT;
    CHECK_OK(rlv_collider_press_params(&params, &count));
    same(params, count, &tool, sizeof(tool));
    CHECK(strcmp(params[1].name, "max_depth") == 0 && strcmp(params[1].unit, "world units") == 0);

    CHECK_FAILS(RLV_ERROR_INVALID, rlv_imprint_params(NULL, &count), "params");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_collider_press_params(&params, NULL), "count");
    return 0;
}
