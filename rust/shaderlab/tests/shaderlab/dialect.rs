//! Older dialects of GLSL.

use relievo_shaderlab::{Language, Shader, Source, Stage};

use super::fault;

fn read(text: &str, stage: Stage) -> Shader {
    let shader = Shader::new(Source::new("test", text, Language::Glsl, stage));
    let shader = shader.unwrap_or_else(|faults| panic!("{faults}"));
    let augmented = shader.augment().unwrap_or_else(|faults| panic!("{faults}\n{}", shader.text()));
    assert!(augmented.text.contains("pel_begin("));
    augmented.wgsl(&shader).unwrap_or_else(|faults| panic!("{faults}"));
    shader
}

#[test]
fn the_listing_of_the_paper_is_read() {
    read(
        "uniform sampler2D tex;\nvarying vec2 co;\nvoid main() {\n    vec4 color = texture2D(tex, co.st);\n    \
         //.vector color.r; co.s; co.t; 1.0\n    gl_FragColor = vec4(vec3(color.r),\n\n        1.0 /*. - confidence */);\n}\n",
        Stage::Fragment,
    );
}

#[test]
fn webgl_of_both_versions_is_read() {
    read(
        "#ifdef GL_OES_standard_derivatives\n#extension GL_OES_standard_derivatives : enable\n#endif\n#ifdef GL_ES\nprecision mediump float;\n#endif\n\
         uniform vec2 u_resolution;\nuniform float u_time;\n// the photograph\nuniform sampler2D texture;\nvarying highp vec2 v_uv;\n\
         #define LOOK(p) texture2D(texture, p)\nvoid main() {\n    vec4 c = LOOK(v_uv);\n    float l = dot(c.rgb, vec3(0.3));\n    \
         //. vector l; texture2D(texture, v_uv + u_resolution).r; 1.0\n    gl_FragColor = vec4(l * sin(u_time)) /*. * confidence */;\n}\n",
        Stage::Fragment,
    );
    read(
        "#version 300 es\nprecision highp float;\nuniform mat4 m;\nuniform Block { vec4 a; float b; };\nin vec2 uv;\nout vec4 o;\n\
         void main() {\n    float f = uv.x * b;\n    //. vector f; 1.0\n    o = m * a * f;\n}\n",
        Stage::Fragment,
    );
    read(
        "attribute vec3 p;\nuniform mat4 m;\nvarying vec2 uv;\nvoid main() {\n    float h = p.z;\n    //. vector h; 1.0\n    \
         uv = p.xy;\n    gl_Position = m * vec4(p, 1.0);\n}\n",
        Stage::Vertex,
    );
}

#[test]
fn present_versions_keep_their_bindings() {
    let shader = read(
        "#version 450\n#extension GL_ARB_separate_shader_objects : enable\nlayout (push_constant) uniform Push { mat4 m; } push;\n\
         layout (set = 1, binding = 3) uniform sampler2D photo;\nlayout (location = 0) in vec3 p;\nlayout (std430) buffer Heap { float h[]; };\n\
         out gl_PerVertex {\n    vec4 gl_Position;\n};\nvoid main() {\n    float a = p.x + h[2] + textureLod(photo, p.xy, 0.0).r;\n    \
         //. vector a; 1.0\n    gl_Position = push.m * vec4(p, a);\n}\n",
        Stage::Vertex,
    );
    assert!(shader.text().contains("layout (push_constant) uniform Push"), "{}", shader.text());
    assert!(shader.text().contains("layout(set = 1, binding = 3) uniform texture2D"), "{}", shader.text());
    assert!(shader.text().contains("layout (binding = 1, std430) buffer Heap"), "{}", shader.text());
}

#[test]
fn shadertoy_is_read() {
    let shader = read(
        "void mainImage(out vec4 fragColor, in vec2 fragCoord) {\n    vec2 uv = fragCoord / iResolution.xy;\n    \
         vec3 col = 0.5 + 0.5 * cos(iTime + uv.xyx + vec3(0, 2, 4));\n    col *= texture(iChannel0, uv).rgb;\n    \
         //. vector col.r; col.g; 1.0\n    fragColor = vec4(col /*. * confidence */, 1.0);\n}\n",
        Stage::Fragment,
    );
    assert!(shader.text().contains("void main()"));
}

#[test]
fn what_the_front_end_lacks_is_rewritten() {
    // A byte order mark, sizes left out, `const in`, a function whose branches return, and words in directives.
    let shader = read(
        "\u{feff}uniform vec2 resolution;\nconst vec2 A[] = vec2[](vec2(0.0, 1.0), vec2(max(1.0, 2.0), 0.5), vec2(3.0));\n\
         float pick(const in float x) {\n    if (x > 0.5) return A[1].x;\n    else return A[2].y;\n}\n\
         float look(float x) {\n    if (x > 0.5) { return 1.0; } else { return 2.0; }\n}\nvoid main() {\n    \
         float[] b = float[2](pick(0.2), 2.0);\n    float a = b[0] + look(resolution.x);\n    //. vector a; 1.0\n    \
         gl_FragColor = vec4(a);\n}\n",
        Stage::Fragment,
    );
    assert!(
        shader.text().contains("A[3] = vec2[3](") && shader.text().contains("float[2] b = float[2]("),
        "{}",
        shader.text()
    );
    // Indices have a sign, and members of blocks an offset.
    let shader = read(
        "#version 450\nlayout(push_constant) uniform Push {\n    layout(offset = 24) float k;\n    vec3 p;\n    \
         layout(offset = 96) vec4 q;\n} push;\nlayout(location = 0) out int index;\nvoid main() {\n    \
         int place = gl_VertexIndex;\n    index = gl_InstanceIndex;\n    float a = push.k + push.q.x;\n    //. vector a; 1.0\n    \
         gl_Position = vec4(push.p, float(place));\n}\n",
        Stage::Vertex,
    );
    let expected = "vec4 pel_gap0[1]; float pel_gap1; float pel_gap2;  float k;";
    assert!(shader.text().contains(expected), "{}", shader.text());
    // 24 + 4 bytes, then p at 32, which ends at 44: one float to 48, and three vectors to 96.
    assert!(shader.text().contains("float pel_gap3; vec4 pel_gap4[3];  vec4 q;"), "{}", shader.text());
    // Textures of other kinds.
    read(
        "#version 450\nlayout(binding = 0) uniform sampler2DMS samples;\nlayout(binding = 1) uniform usampler2D labels;\n\
         layout(binding = 2) uniform sampler2DShadow shadows;\nlayout(location = 0) out vec4 color;\nvoid main() {\n    \
         float a = texelFetch(samples, ivec2(1), 0).r + float(texelFetch(labels, ivec2(1), 0).r);\n    \
         a += texture(shadows, vec3(0.5));\n    //. vector a; 1.0\n    color = vec4(a);\n}\n",
        Stage::Fragment,
    );
    // Swizzles of scalars.
    let shader = read(
        "#version 450\nlayout(location = 0) in vec4 c;\nlayout(location = 0) out vec4 color;\nvoid main() {\n    \
         float a = c.x;\n    vec3 b = max(dot(c, c.yxzw), a).rrr + a.xxx + (a + 1.0).xxx;\n    //. vector b.x; 1.0\n    \
         color = vec4(b.xy, a.xx);\n}\n",
        Stage::Fragment,
    );
    assert!(shader.text().contains("vec3(max(dot(c, c.yxzw), a))"), "{}", shader.text());
    // An entry point that another host sees alone, and a channel in a macro.
    read(
        "#define LOOK(p) texture(iChannel1, p)\nvoid mainImage(out vec4 o, in vec2 p) {\n    float t = LOOK(p).r;\n    \
         //. vector t; 1.0\n    o = vec4(t);\n}\n#ifdef HOST\nout vec4 color;\nvoid main() { mainImage(color, gl_FragCoord.xy); }\n\
         #endif\n",
        Stage::Fragment,
    );
    // An entry point of the author's own host.
    let shader = read(
        "void mainImage(out vec4 o, in vec2 p) {\n    float t = iTime + p.x;\n    //. vector t; 1.0\n    o = vec4(t);\n}\n\
         out vec4 color;\nvoid main() { mainImage(color, gl_FragCoord.xy); }\n",
        Stage::Fragment,
    );
    assert!(!shader.text().contains("iMouse"), "{}", shader.text());
}

#[test]
fn combined_samplers_are_passed_to_functions() {
    let shader = read(
        "uniform sampler2D a;\nuniform sampler2D b;\nvarying vec2 uv;\n\
         vec4 look(in sampler2D t, vec2 p) { return texture2D(t, p); }\n\
         vec4 twice(float k, sampler2D t) { return k * look(t, uv) + texture2D(t, uv.yx); }\nvoid main() {\n    \
         vec4 c = look(a, uv) + twice(2.0, b);\n    //. vector c.r; 1.0\n    gl_FragColor = c;\n}\n",
        Stage::Fragment,
    );
    assert!(shader.text().contains("look(pel_texture_a, pel_sampler_a, uv)"), "{}", shader.text());
    assert!(shader.text().contains("look(pel_texture_t, pel_sampler_t, uv)"), "{}", shader.text());
}

#[test]
fn faults_of_old_shaders_point_at_the_users_text() {
    let text = "uniform sampler2D a;\nvarying vec2 uv;\nfloat f(sampler2D t);\nvoid main() {}\n";
    assert_eq!(
        fault(text, Language::Glsl),
        ("a combined sampler is a parameter of a function without a body".into(), "sampler2D".into())
    );
    let text =
        "uniform sampler2D a;\nvarying vec2 uv;\nvoid main() {\n    gl_FragColor = texture2D(a, uv) + missing;\n}\n";
    assert_eq!(fault(text, Language::Glsl).1, "missing");
}

#[test]
fn bytes_of_the_result_come_from_the_users_text() {
    let text =
        "void mainImage(out vec4 o, in vec2 p) {\n    float a = p.x;\n    //. vector a; 1.0\n    o = vec4(a);\n}\n";
    let shader = read(text, Stage::Fragment);
    let augmented = shader.augment().unwrap();
    for at in 0..augmented.text.len() {
        let from = augmented.map.source(at..at + 1);
        assert!(from.start <= from.end && from.end <= text.len(), "{at}: {from:?}");
    }
    let at = augmented.text.find("o = vec4(a)").unwrap();
    assert_eq!(&text[augmented.map.source(at..at + 11)], "o = vec4(a)");
}
