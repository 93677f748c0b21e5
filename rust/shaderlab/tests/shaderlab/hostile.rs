//! Texts that are no shaders: none makes the library panic, hang or write outside of its bindings.

use proptest::prelude::*;
use relievo_shaderlab::{Language, Shader, Source, Stage};

const GOOD: &str = "@group(0) @binding(0) var<uniform> u: vec4<f32>;\n\
    fn weigh(distance: f32) -> f32 { let w = 1.0 / (1.0 + distance); /*. vector w; u.x; distance */ return w; }\n\
    @fragment fn fs(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {\n    for (var i = 0.0; i < 2.0; i += 1.0) {\n        \
    let a = weigh(i) + uv.x;\n        //. vector a; uv.y; 1.0\n    }\n    //. accumulation max\n    \
    return vec4<f32>(1.0 /*. * confidence */);\n}\n";

const OLD: &str = "#version 120\nuniform sampler2D t; // a\nuniform float k, l;\nvarying vec2 uv;\n#define A(x) texture2D(t, x)\n\
    void main() {\n    float a = A(uv).r * k;\n    //. vector a; l; 1.0\n    gl_FragColor = vec4(a /*. * confidence */);\n}\n";

const VERTEX: &str = "struct Out { @location(0) a: f32, @builtin(position) at: vec4<f32> }\n\
    fn lift(p: vec3<f32>) -> f32 { let h = p.z; //. vector h; p.x; 1.0\n return h; }\n\
    @vertex fn vs(@location(0) p: vec3<f32>, @builtin(instance_index) n: u32) -> Out {\n    var out: Out;\n    \
    if p.x > 1.0 { return Out(lift(p), vec4<f32>(p, /*. confidence + */ 1.0)); }\n    for (var i = 0u; i < n; i++) {\n        \
    if i > 3u { return out; }\n    }\n    return out;\n}\n";

const OLD_VERTEX: &str = "attribute vec3 p;\nuniform float k;\nvarying float h;\nvoid main(void) {\n    h = p.z * k;\n    \
    //. vector h; 1.0\n    gl_Position = vec4(p, 1.0);\n    if (k > 1.0) return; else h = 2.0;\n    { return; }\n}\n";

/// Reads and augments a text and looks at all of its variables. Faults are fine, and can be printed.
fn look(text: &str, language: Language) {
    look_at(text, language, Stage::Fragment);
}

/// As [`look`], for a stage.
fn look_at(text: &str, language: Language, stage: Stage) {
    match Shader::new(Source::new("test", text, language, stage)) {
        Err(faults) => assert!(!faults.to_string().is_empty()),
        Ok(shader) => {
            for (index, variable) in shader.variables().iter().enumerate() {
                assert_eq!(&text[variable.place.clone()], variable.name);
                let _ = shader.with_vector(&[index], "1.0");
            }
            match shader.augment() {
                Err(faults) => assert!(!faults.to_string().is_empty()),
                Ok(augmented) => assert!(augmented.text.contains("pel_take")),
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn changed_shaders_are_read_or_refused(at in 0_usize..400, length in 0_usize..12, junk in "[ -~\n.;{}()/*éß]{0,6}", is_old: bool) {
        let (text, language) = if is_old { (OLD, Language::Glsl) } else { (GOOD, Language::Wgsl) };
        let start = at.min(text.len());
        let end = (start + length).min(text.len());
        look(&format!("{}{junk}{}", &text[..start], &text[end..]), language);
    }

    #[test]
    fn changed_vertex_shaders_are_read_or_refused(at in 0_usize..560, length in 0_usize..12, junk in "[ -~\n.;{}()/*éß]{0,6}", is_old: bool) {
        let (text, language) = if is_old { (OLD_VERTEX, Language::Glsl) } else { (VERTEX, Language::Wgsl) };
        let start = at.min(text.len());
        let end = (start + length).min(text.len());
        look_at(&format!("{}{junk}{}", &text[..start], &text[end..]), language, Stage::Vertex);
    }

    #[test]
    fn any_text_is_read_or_refused(text in "\\PC{0,80}", is_old: bool) {
        look(&text, if is_old { Language::Glsl } else { Language::Wgsl });
    }

    #[test]
    fn any_annotation_is_read_or_refused(note in "[a-z.;(){}*/= \n]{0,40}") {
        look(&GOOD.replace("vector a; uv.y; 1.0", &note), Language::Wgsl);
        look(&OLD.replace("vector a; l; 1.0", &note), Language::Glsl);
    }

    #[test]
    fn words_in_any_order_are_read_or_refused(words in prop::collection::vec(prop::sample::select(vec![
        "fn", "f", "(", ")", "{", "}", ";", "var", "let", "=", "float", "for", "struct", "uniform", "sampler2D", "a", "1.0", ",",
        "//. vector a; 1.0\n", "/*. confidence */", "#define", "\n", "\\\n", "in", "out", "mainImage", "void", "main", "[", "]", ":",
        "/*", "*/", "@", "layout", "if", "else", "vec2",
    ]), 0..60), is_old: bool) {
        look(&words.join(" "), if is_old { Language::Glsl } else { Language::Wgsl });
    }
}

#[test]
fn every_truncation_is_read_or_refused() {
    for (text, language) in [(GOOD, Language::Wgsl), (OLD, Language::Glsl)] {
        for end in (0..text.len()).filter(|end| text.is_char_boundary(*end)) {
            look(&text[..end], language);
        }
    }
}

#[test]
fn deep_and_long_texts_are_refused_or_read() {
    let nested = |open: &str, close: &str, count: usize| {
        format!("#version 450\nvoid main() {{ float a = {}1.0{}; }}", open.repeat(count), close.repeat(count))
    };
    for count in [100, 150, 100_000] {
        look(&nested("(", ")", count), Language::Glsl);
        look(&nested("-", "", count), Language::Glsl);
        look(
            &nested("-", "", count).replace("#version 450\nvoid main()", "fn f()").replace("float", "let"),
            Language::Wgsl,
        );
        look(&nested("1.0+", "", count), Language::Glsl);
        look(&nested("true?", ":1.0", count), Language::Glsl);
        look(&format!("fn f() {{ {} }}", "if true { } else ".repeat(count)), Language::Wgsl);
        look(&"/*".repeat(count), Language::Wgsl);
        look(&"{".repeat(count), Language::Glsl);
        look(&"float a(".repeat(count), Language::Glsl);
        look(&"uniform float a; #define b\n".repeat(count), Language::Glsl);
    }
}

#[test]
fn every_return_of_a_vertex_shader_is_augmented() {
    for (text, language, count) in [(VERTEX, Language::Wgsl, 3), (OLD_VERTEX, Language::Glsl, 3)] {
        let shader =
            Shader::new(Source::new("test", text, language, Stage::Vertex)).unwrap_or_else(|it| panic!("{it}"));
        let augmented = shader.augment().unwrap_or_else(|faults| panic!("{faults}"));
        let call = if language == Language::Wgsl { "return pel_end_vs(" } else { "pel_end_vertex(gl_Position);" };
        assert_eq!(augmented.text.matches(call).count(), count, "{}", augmented.text);
        augmented.wgsl(&shader).unwrap_or_else(|faults| panic!("{faults}"));
    }
}

#[test]
fn what_webgpu_lacks_is_refused_when_the_shader_is_to_run() {
    let text = "#version 450\nvoid main() {\n    float size = 2.0;\n    //. vector size; 1.0\n    gl_PointSize = size;\n    \
        gl_Position = vec4(0.0);\n}\n";
    let shader = Shader::new(Source::new("points.vert", text, Language::Glsl, Stage::Vertex)).unwrap();
    let augmented = shader.augment().unwrap_or_else(|faults| panic!("{faults}"));
    assert!(augmented.text.contains("pel_take("), "a host of Vulkan still gets its text");
    for faults in [shader.wgsl().unwrap_err(), augmented.wgsl(&shader).unwrap_err()] {
        assert!(faults.to_string().contains("cannot run on WebGPU"), "{faults}");
    }
}
