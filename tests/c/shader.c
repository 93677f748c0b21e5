/* Shaders: the shader of a foreign plugin is augmented, its log is written and read as the host would, membership in closed
 * form, and what is refused. */
#include "check.h"

enum { ROOM = 1 << 16 };

/* A shader of a plugin for WebGL that casts rays through a scan. It does not know this library. */
static const char PLUGIN[] =
    "#version 300 es\n"
    "precision highp float;\n"
    "uniform sampler2D slices;\n"
    "uniform float threshold;\n"
    "in vec2 place;\n"
    "out vec4 color;\n"
    "float density(vec3 at) { return texture(slices, at.xy + 0.1 * at.z).r; }\n"
    "void main() {\n"
    "    float light = 0.0;\n"
    "    for (int i = 0; i < 16; ++i) {\n"
    "        vec3 at = vec3(place, float(i) / 16.0);\n"
    "        //. name Density\n"
    "        //. desc Mass of a voxel\n"
    "        float value = density(at);\n"
    "        float slope = density(at + vec3(0.01, 0.0, 0.0)) - value;\n"
    "        light += value > threshold ? slope : 0.0;\n"
    "    }\n"
    "    color = vec4(vec3(light) /*. * confidence */, 1.0);\n"
    "}\n";

static RlvShader create(const char *text, uint32_t language) {
    RlvShaderOptions options = RLV_SHADER_OPTIONS_INIT;
    RlvShader shader = RLV_NULL;
    options.language = language;
    options.name = "plugin";
    CHECK_OK(rlv_shader_create(text, &options, &shader));
    return shader;
}

/* The index of the variable called name. */
static uint32_t find(RlvShader shader, const char *name, RlvShaderVariable *out) {
    size_t count = 0;
    CHECK_OK(rlv_shader_variable_count(shader, &count));
    for (size_t index = 0; index < count; ++index) {
        CHECK_OK(rlv_shader_variable(shader, index, out));
        if (strcmp(out->name, name) == 0) {
            return (uint32_t)index;
        }
    }
    CHECK(0);
    return 0;
}

static uint32_t bits(float value) {
    uint32_t word;
    memcpy(&word, &value, sizeof word);
    return word;
}

static void check_plugin(void) {
    static char text[ROOM], wgsl[ROOM];
    RlvShader plain = create(PLUGIN, RLV_SHADER_GLSL), marked = RLV_NULL;
    RlvShaderVariable variable = RLV_SHADER_VARIABLE_INIT;
    RlvShaderLayout layout = RLV_SHADER_LAYOUT_INIT;
    RlvShaderFeature feature = RLV_SHADER_FEATURE_INIT;
    uint32_t chosen[2], taken = 0;
    size_t length = 0, full = 0;
    chosen[1] = find(plain, "slope", &variable);
    CHECK(variable.line == 15 && variable.column == 15 && variable.components == 1 && variable.is_initialized == 1);
    chosen[0] = find(plain, "value", &variable);
    CHECK(variable.declared == RLV_SHADER_LOCAL && strcmp(variable.function, "main") == 0);
    CHECK(strcmp(variable.label, "Density") == 0 && strcmp(variable.description, "Mass of a voxel") == 0);
    CHECK(variable.scope_end < strlen(PLUGIN) && strncmp(PLUGIN + variable.scope_start, "value", 5) == 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_layout(plain, &layout), "rlv_shader_mark");
    CHECK_OK(rlv_shader_mark(plain, chosen, 2, "step(threshold, value)", &marked));
    CHECK_OK(rlv_shader_layout(marked, &layout));
    CHECK(layout.feature_count == 2 && layout.accumulation == RLV_SHADER_AVERAGE && layout.site_count == 1);
    CHECK(layout.uses_confidence == 1 && layout.log_binding == layout.examples_binding + 1);
    CHECK_OK(rlv_shader_feature(marked, 0, &feature));
    CHECK(strcmp(feature.name, "Density") == 0 && strcmp(feature.expression, "value") == 0);
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_shader_feature(marked, 2, &feature), "feature 2");

    /* The mark is a comment of the text that a host without this library compiles. */
    CHECK_OK(rlv_shader_text(marked, RLV_SHADER_MARKED, text, ROOM, &length));
    CHECK(length == strlen(text) && strstr(text, "//. vector value; slope; step(threshold, value)\n") != NULL);
    CHECK_OK(rlv_shader_text(marked, RLV_SHADER_AUGMENTED, NULL, 0, &full));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_text(marked, RLV_SHADER_AUGMENTED, text, full, &length), "text");
    CHECK_OK(rlv_shader_text(marked, RLV_SHADER_AUGMENTED, text, full + 1, &length));
    CHECK(length == full && strstr(text, "pel_take(step(threshold, value))") != NULL);
    CHECK_OK(rlv_shader_text(marked, RLV_SHADER_AUGMENTED_WGSL, wgsl, ROOM, &length));
    char binding[64];
    snprintf(binding, sizeof binding, "@group(%u) @binding(%u)", layout.group, layout.log_binding);
    CHECK(strstr(wgsl, binding) != NULL && strstr(wgsl, "@fragment") != NULL);

    /* A log as the shader writes it: two vectors of the weights 1 and 3. */
    const uint32_t log[] = {2, 5, bits(4), bits(0.5f + 3 * 0.25f), bits(0.1f + 3 * 0.3f)};
    float vector[2];
    CHECK(layout.log_head + layout.feature_count == 5);
    CHECK_OK(rlv_shader_unpack_log(marked, log, 5, vector, 2, &taken));
    CHECK_NEAR(vector[0], 0.3125, 1e-6);
    CHECK_NEAR(vector[1], 0.25, 1e-6);
    CHECK(taken == 5);
    const uint32_t nothing[5] = {0};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_unpack_log(marked, nothing, 5, vector, 2, NULL), "no vector");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_unpack_log(marked, log, 4, vector, 2, NULL), "4 words");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_unpack_log(marked, log, 5, vector, 1, NULL), "vector");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_unpack_log(plain, log, 5, vector, 2, NULL), "no vector");
    check_idle(plain.id, "shader");
    CHECK_OK(rlv_shader_release(plain));
    /* The marked shader is one of its own. */
    CHECK_OK(rlv_shader_retain(marked));
    CHECK_OK(rlv_shader_release(marked));
    CHECK_OK(rlv_shader_layout(marked, &layout));
    CHECK_OK(rlv_shader_release(marked));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_layout(marked, &layout), "");
}

/* One positive and one negative example on a line: the membership has a closed form. */
static void check_membership(void) {
    const struct {
        uint32_t kind;
        float vector[2];
    } pixels[2] = {{RLV_SHADER_POSITIVE, {0, 0}}, {RLV_SHADER_NEGATIVE, {4, 0}}};
    const float vectors[4][2] = {{0, 0}, {4, 0}, {1, 0}, {NAN, 0}};
    const uint32_t expected_words[] = {RLV_SHADER_CLASSIFY, 7, 9, 2, bits(3), bits(1), bits(1), bits(1), 0, 0, 0, bits(4), 0};
    RlvShaderExamples examples = RLV_SHADER_EXAMPLES_INIT;
    float found[4];
    uint32_t words[13];
    size_t count = 0;
    examples.feature_count = 2;
    CHECK_OK(rlv_shader_membership(&examples, vectors[0], 4, 0, found));
    CHECK(found[0] == 0.5f && found[2] == 0.5f);
    examples.count = 2;
    examples.classes = &pixels[0].kind;
    examples.vectors = pixels[0].vector;
    examples.class_stride = examples.vector_stride = sizeof pixels[0];
    examples.exponent = 3;
    CHECK_OK(rlv_shader_membership(&examples, vectors[0], 4, 0, found));
    CHECK(found[0] == 1.0f && found[1] == 0.0f && found[3] == 0.5f);
    CHECK_NEAR(found[2], 27.0 / 28.0, 1e-6);
    CHECK_OK(rlv_shader_pack_examples(&examples, RLV_SHADER_CLASSIFY, 7, 9, NULL, 0, &count));
    CHECK(count == 13);
    CHECK_OK(rlv_shader_pack_examples(&examples, RLV_SHADER_CLASSIFY, 7, 9, words, 13, &count));
    CHECK(memcmp(words, expected_words, sizeof words) == 0);
    count = 77;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_pack_examples(&examples, RLV_SHADER_MASK, 7, 9, words, 12, &count), "words");
    CHECK(count == 13);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_pack_examples(&examples, 5, 7, 9, words, 13, &count), "mode");
    CHECK_OK(rlv_shader_pack_examples(&examples, RLV_SHADER_CLASSIFY_VERTEX, 7, 9, words, 13, &count));
    CHECK(words[0] == 3 && words[1] == 7 && words[2] == 9);
    CHECK_OK(rlv_shader_pack_examples(&examples, RLV_SHADER_VERTICES, 7, 9, words, 13, &count));
    CHECK(words[0] == 4);
    /* Scaled by the range of 4, distances are a quarter: the ratio stays. */
    examples.is_scaled = 1;
    CHECK_OK(rlv_shader_membership(&examples, vectors[0], 4, 0, found));
    CHECK_NEAR(found[2], 27.0 / 28.0, 1e-6);

    examples.exponent = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_membership(&examples, vectors[0], 4, 0, found), "exponent");
    examples.exponent = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_membership(&examples, vectors[0], 4, 4, found), "stride");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_membership(&examples, NULL, 4, 0, found), "vectors");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_membership(NULL, vectors[0], 4, 0, found), "NULL");
    examples.vectors = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_membership(&examples, vectors[0], 4, 0, found), "vectors");
    examples.vectors = vectors[2];
    examples.vector_stride = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_membership(&examples, vectors[0], 4, 0, found), "finite");
    const uint32_t wrong[2] = {1, 2};
    examples.classes = wrong;
    examples.class_stride = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_membership(&examples, vectors[0], 4, 0, found), "class");
    examples.count = 5000;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_membership(&examples, vectors[0], 4, 0, found), "5000");
    examples.count = 0;
    examples.feature_count = 65;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_membership(&examples, vectors[0], 4, 0, found), "65");
    examples.struct_size = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_membership(&examples, vectors[0], 4, 0, found), "struct_size");
}

static void check_refusals(void) {
    RlvShader shader = RLV_NULL, marked = RLV_NULL;
    RlvShaderOptions options = RLV_SHADER_OPTIONS_INIT;
    RlvShaderVariable variable = RLV_SHADER_VARIABLE_INIT;
    const uint32_t beyond = 99;
    size_t length = 0;
    options.language = RLV_SHADER_WGSL;
    options.name = "dust.wgsl";
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_create("fn f() {\n    let a = ;\n}\n", &options, &shader), "dust.wgsl:2:13");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_create("fn f() {\n    //. vectr a; 1.0\n}\n", &options, &shader), "vector");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_create("\xff", &options, &shader), "UTF-8");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_create(NULL, &options, &shader), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_create("", &options, NULL), "out");
    options.language = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_create("", &options, &shader), "language");
    options.language = RLV_SHADER_WGSL;
    options.stage = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_create("", &options, &shader), "stage");
    CHECK(shader.id == 0);
    shader = create("@fragment fn fs(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {\n"
                    "    let a = uv.x;\n    return vec4<f32>(a);\n}\n", RLV_SHADER_WGSL);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_mark(shader, NULL, 0, NULL, &marked), "no variable");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_mark(shader, &beyond, 1, NULL, &marked), "99");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_mark(shader, &beyond, 65, NULL, &marked), "65");
    const uint32_t chosen = find(shader, "a", &variable);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_mark(shader, &chosen, 1, "missing", &marked), "missing");
    CHECK(marked.id == 0);
    CHECK_OK(rlv_shader_mark(shader, &chosen, 1, NULL, &marked));
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_shader_variable(shader, 2, &variable), "variable 2");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_text(shader, RLV_SHADER_AUGMENTED, NULL, 0, &length), "no vector");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_shader_text(marked, 3, NULL, 0, &length), "kind");
    CHECK_OK(rlv_shader_release(shader));
    CHECK_OK(rlv_shader_release(marked));
}

int main(void) {
    check_plugin();
    check_membership();
    check_refusals();
    return 0;
}
