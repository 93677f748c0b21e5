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
