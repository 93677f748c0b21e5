//! The language of annotations, and the code that they become.

use relievo_shaderlab::{Accumulation, Declared, Language, Shader, Source, Stage};

use super::{augment, fault};

/// A shader in WGSL whose statement after `let a` and whose last factor are given.
fn wgsl(note: &str, factor: &str) -> String {
    format!(
        "@fragment fn fs(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {{\n    let a = uv.x * 2.0;\n    {note}\n    \
         return vec4<f32>(a {factor}, uv, 1.0);\n}}\n"
    )
}

fn glsl(note: &str, factor: &str) -> String {
    format!(
        "#version 450\nlayout(location = 0) in vec2 uv;\nlayout(location = 0) out vec4 color;\nvoid main() {{\n    \
         float a = uv.x * 2.0;\n    {note}\n    color = vec4(a {factor}, uv, 1.0);\n}}\n"
    )
}

#[test]
fn every_form_of_an_annotation_is_understood() {
    let notes = [
        "//. vector a; uv.y; 1.0",
        "//.vector a;uv.y;1.0;",
        "/*. vector a; uv.y; 1.0 */",
        "/*.vector\n a;\n uv.y; 1.0*/",
        "//. vector max(a, 0.5); uv.y; 1.0 // why",
        "//. vector a; uv.y /* the height */; 1.0",
    ];
    for note in notes {
        for (text, language) in [(wgsl(note, ""), Language::Wgsl), (glsl(note, ""), Language::Glsl)] {
            let (_, augmented) = augment(&text, language).unwrap_or_else(|faults| panic!("{faults}"));
            assert_eq!(augmented.features.len(), 2, "{note}");
            assert_eq!(augmented.features[1].expression, "uv.y");
            assert_eq!(augmented.accumulation, Accumulation::Average);
            assert!(!augmented.uses_confidence);
            assert_eq!(augmented.sites.len(), 1);
            assert!(augmented.text.contains("pel_take("), "{}", augmented.text);
        }
    }
    for (way, name) in Accumulation::ALL {
        let note = format!("//. accumulation {name}\n//. vector a; 1.0");
        let (_, augmented) = augment(&wgsl(&note, "/*. * confidence */"), Language::Wgsl).unwrap();
        assert_eq!(augmented.accumulation, way);
        assert!(augmented.uses_confidence);
        let (_, augmented) = augment(&glsl(&note, "/*. * (1.0 - confidence) */"), Language::Glsl).unwrap();
        assert_eq!(augmented.accumulation, way);
        assert!(augmented.text.contains("* (1.0 - pel_confidence())"));
    }
}

#[test]
fn vertices_are_classified_by_their_index() {
    let body = "    let h = p.z;\n    //. vector h; 1.0\n    return vec4<f32>(p, 1.0);\n}\n";
    let place = "pel_begin_vertex(vec2<u32>(pel_index, pel_instance));";
    for (arguments, place) in [
        ("@location(0) p: vec3<f32>", place),
        ("@builtin(vertex_index) i: u32, @location(0) p: vec3<f32>", "pel_begin_vertex(vec2<u32>(i, pel_instance));"),
        ("@location(0) p: vec3<f32>, @builtin(instance_index) n: u32", "pel_begin_vertex(vec2<u32>(pel_index, n));"),
    ] {
        let text = format!("@vertex fn vs({arguments}) -> @builtin(position) vec4<f32> {{\n{body}");
        let (_, augmented) = augment(&text, Language::Wgsl).unwrap_or_else(|faults| panic!("{faults}"));
        assert!(augmented.text.contains(place), "{}", augmented.text);
        assert_eq!(augmented.sites[0].function, "vs");
        assert!(augmented.text.contains("return pel_end_vs( vec4<f32>(p, 1.0));"), "{}", augmented.text);
    }
    let text = "#version 450\nlayout(location = 0) in vec3 p;\nvoid main() {\n    float h = p.z;\n    //. vector h; 1.0\n    \
        gl_Position = vec4(p, 1.0);\n}\n";
    let shader = Shader::new(Source::new("test", text, Language::Glsl, Stage::Vertex)).unwrap();
    let augmented = shader.augment().unwrap_or_else(|faults| panic!("{faults}"));
    assert!(
        augmented.text.contains("pel_begin_vertex(uvec2(gl_VertexIndex, gl_InstanceIndex));"),
        "{}",
        augmented.text
    );
    // The log is a storage buffer that the vertex stage writes.
    assert!(augmented.wgsl(&shader).unwrap().contains("var<storage, read_write>"));
}

#[test]
fn ordinary_comments_are_left_alone() {
    for note in ["//... vector", "// . vector a; 1.0", "/*...*/", "/* //. vector a; 1.0 */", "//"] {
        assert_eq!(fault(&wgsl(note, ""), Language::Wgsl).0, "the shader takes no vector", "{note}");
    }
}

#[test]
fn faults_point_at_the_users_own_text() {
    let cases = [
        ("//. vector a", "a vector needs a feature and a weight", "vector a"),
        ("//. vector a;; 1.0", "an expression is missing", "vector a;; 1.0"),
        ("//. vecto a; 1.0", "the annotation has no known word", "vecto a; 1.0"),
        ("//. vector (a; 1.0", "`(` is not closed in this annotation", "("),
        ("//. vector a); 1.0", "`)` closes nothing in this annotation", ")"),
        ("//. vector a = 2.0; 1.0", "a feature cannot change a variable", "="),
        ("//. accumulation median\n//. vector a; 1.0", "`median` is no accumulation", "median"),
        ("//. vector a; 1.0\n//. vector a; a; 1.0", "this vector has 2 features, another 1", "//. vector a; a; 1.0"),
        ("//. name", "nothing follows `name`", "name"),
        ("//. vector a; 1.0 }", "`}` closes nothing in this annotation", "}"),
    ];
    for (note, what, place) in cases {
        assert_eq!(fault(&wgsl(note, ""), Language::Wgsl), (what.to_owned(), place.to_owned()), "{note}");
        assert_eq!(fault(&glsl(note, ""), Language::Glsl), (what.to_owned(), place.to_owned()), "{note}");
    }
    // What only the front end finds.
    let (what, place) = fault(&wgsl("//. vector a; missing; 1.0", ""), Language::Wgsl);
    assert!(what.contains("missing") && place == "missing", "{what}: {place}");
    let (what, place) = fault(&glsl("//. vector a; missing; 1.0", ""), Language::Glsl);
    assert!(place == "missing", "{what}: {place}");
    // A vector and an integer are no features.
    for wrong in ["uv", "i32(a)", "a > 1.0"] {
        let (what, place) = fault(&wgsl(&format!("//. vector {wrong}; 1.0"), ""), Language::Wgsl);
        assert!(wrong.contains(place.trim()) || place.contains(wrong), "{what}: {place}");
    }
    let (_, place) = fault(&wgsl("", "* b"), Language::Wgsl);
    assert_eq!(place, "b");
    assert_eq!(fault("fn f() { let pel_a = 1.0; }", Language::Wgsl).1, "pel_a");
    assert_eq!(fault("fn f() {} /* open", Language::Wgsl), ("the comment has no end".into(), "/*".into()));
}

#[test]
fn vectors_stand_between_statements_only() {
    let branch = "    if (a > 0.5)\n        //. vector a; 1.0\n        color = vec4(0.0);\n";
    let text = glsl("", "").replace("    color", &format!("{branch}    color"));
    assert_eq!(fault(&text, Language::Glsl).0, "a vector is taken within a statement");
    let text =
        "@fragment fn fs() -> @location(0) vec4<f32> { let a = /*. vector 1.0; 1.0 */ 2.0; return vec4<f32>(a); }";
    assert_eq!(fault(text, Language::Wgsl).0, "a vector is taken within a statement");
    assert_eq!(fault("//. vector 1.0; 1.0\nfn f() {}", Language::Wgsl).0, "a vector is taken outside of functions");
    let text = "fn f() { let a = 1.0;\n//. vector a; 1.0\n}\n@fragment fn fs() -> @location(0) vec4<f32> { return vec4<f32>(); }";
    assert_eq!(fault(text, Language::Wgsl).0, "no entry point of the shader takes a vector");
    assert_eq!(
        fault("#version 450\n#define A 1 //. vector 1; 1\nvoid main() {}\n", Language::Glsl).0,
        "an annotation stands on a line of the preprocessor"
    );
}

#[test]
fn entry_points_of_every_form_know_their_pixel() {
    let body = "let a = 1.0;\n//. vector a; 1.0\n";
    let color = "return vec4<f32>(a);";
    let forms = [
        format!("@fragment fn fs() -> @location(0) vec4<f32> {{ {body}{color} }}"),
        format!("@fragment fn fs(@builtin(position) p: vec4<f32>) -> @location(0) vec4<f32> {{ {body}{color} }}"),
        format!(
            "struct In {{ @location(0) uv: vec2<f32>, @builtin(position) at: vec4<f32> }}\n\
                 @fragment fn fs(in: In) -> @location(0) vec4<f32> {{ {body}{color} }}"
        ),
        format!(
            "fn f() -> f32 {{ {body}return a; }}\n@fragment fn fs(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {{\
                 if uv.x > 0.5 {{ return vec4<f32>(f()); }} return vec4<f32>(0.0); }}\n\
                 @vertex fn vs() -> @builtin(position) vec4<f32> {{ return vec4<f32>(0.0); }}"
        ),
        format!("@compute @workgroup_size(8, 8) fn cs() {{ {body} }}"),
        format!("@compute @workgroup_size(8, 8) fn cs(@builtin(global_invocation_id) id: vec3<u32>) {{ {body} }}"),
        format!("@vertex fn vs() -> @builtin(position) vec4<f32> {{ {body}{color} }}"),
    ];
    for text in forms {
        let (_, augmented) = augment(&text, Language::Wgsl).unwrap_or_else(|faults| panic!("{faults}"));
        assert_eq!(
            augmented.text.matches("pel_begin(vec2").count()
                + augmented.text.matches("pel_begin_vertex(vec2").count()
                + augmented.text.matches("pel_begin(pel_").count()
                + augmented.text.matches("pel_begin(id").count(),
            1,
            "{}",
            augmented.text
        );
    }
    // The two buffers stay clear of those of the shader.
    let text = format!("@group(1) @binding(7) var<uniform> u: vec4<f32>;\n{}", wgsl("//. vector a; u.x; 1.0", ""));
    let (_, augmented) = augment(&text, Language::Wgsl).unwrap();
    assert_eq!((augmented.group, augmented.binding), (2, 0));
    let text = format!("@group(3) @binding(7) var<uniform> u: vec4<f32>;\n{}", wgsl("//. vector a; u.x; 1.0", ""));
    let (_, augmented) = augment(&text, Language::Wgsl).unwrap();
    assert_eq!((augmented.group, augmented.binding), (3, 8));
}

#[test]
fn float_variables_are_found_with_type_place_and_scope() {
    let text = "struct P { radius: f32 }\n@group(0) @binding(0) var<uniform> p: P;\nvar<private> shade: f32 = 1.0;\n\
        fn weigh(distance: f32, count: i32) -> f32 {\n    //. name Weight\n    //. desc How much it counts\n    \
        let w = distance * p.radius;\n    return w;\n}\n\
        @fragment fn fs(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {\n    var sum = 0.0;\n    let n = 3u;\n    \
        for (var t = 0.0; t < 1.0; t += 0.25) {\n        let v = uv * t;\n        { let v = weigh(t, 1); sum += v; }\n        \
        sum += v.x;\n    }\n    var late: vec3<f32>;\n    late = vec3<f32>(sum);\n    return vec4<f32>(late, shade);\n}\n";
    let shader =
        Shader::new(Source::new("test", text, Language::Wgsl, Stage::Fragment)).unwrap_or_else(|it| panic!("{it}"));
    let found: Vec<_> = shader.variables();
    let names: Vec<_> = found.iter().map(|it| (it.name.as_str(), it.components, it.function.as_deref())).collect();
    let expected = [
        ("shade", 1, None),
        ("distance", 1, Some("weigh")),
        ("w", 1, Some("weigh")),
        ("uv", 2, Some("fs")),
        ("sum", 1, Some("fs")),
        ("t", 1, Some("fs")),
        ("v", 2, Some("fs")),
        ("v", 1, Some("fs")),
        ("late", 3, Some("fs")),
    ];
    assert_eq!(names, expected);
    assert_eq!(found[2].label.as_deref(), Some("Weight"));
    assert_eq!(found[2].description.as_deref(), Some("How much it counts"));
    assert_eq!(found[1].declared, Declared::Parameter);
    assert!(!found[8].is_initialized && found[4].is_initialized);
    assert!(text[found[7].scope.clone()].ends_with('}'));
    assert!(found[7].scope.end < found[6].scope.end);
    for (index, variable) in found.iter().enumerate() {
        assert_eq!(&text[variable.place.clone()], variable.name);
        let marked = shader.with_vector(&[index], "1.0").unwrap_or_else(|it| panic!("{it}"));
        let (_, augmented) = augment(&marked, Language::Wgsl).unwrap_or_else(|it| panic!("{it}\n{marked}"));
        assert_eq!(augmented.features.len(), variable.components as usize);
        // Without the line of the annotation the text is the old one.
        let without: Vec<_> = marked.lines().filter(|line| !line.trim_start().starts_with("//. vector")).collect();
        assert_eq!(without.concat().replace(' ', ""), text.lines().collect::<String>().replace(' ', ""));
    }
    // A vector of several is taken where the last of them is declared, and the name of a variable is that of the feature.
    let marked = shader.with_vector(&[3, 4, 5], "t").unwrap();
    let (_, augmented) = augment(&marked, Language::Wgsl).unwrap();
    assert_eq!(augmented.sites[0].function, "fs");
    let marked = shader.with_vector(&[2], "1.0").unwrap();
    assert_eq!(augment(&marked, Language::Wgsl).unwrap().1.features[0].name, "Weight");
    // The inner `v` and `w` have no scope in common.
    assert!(shader.with_vector(&[2, 7], "1.0").is_err());
    assert!(shader.with_vector(&[], "1.0").is_err() && shader.with_vector(&[99], "1.0").is_err());
}

#[test]
fn float_variables_of_glsl_are_found() {
    let text = "#version 450\nlayout(location = 0) in vec2 uv;\nlayout(location = 0) out vec4 color;\n\
        float f(in float x, vec3 y) { return x + y.x; }\nvoid main() {\n    float a = 1.0, b, c = f(uv.x, vec3(0.0));\n    \
        int n = 3;\n    for (float t = 0.0; t < 1.0; t += 0.5) {\n        vec3 p = vec3(t);\n        c += p.x;\n    }\n    \
        const float K = 2.0;\n    b = K;\n    color = vec4(a, b, c, 1.0);\n}\n";
    let shader =
        Shader::new(Source::new("test", text, Language::Glsl, Stage::Fragment)).unwrap_or_else(|it| panic!("{it}"));
    let found = shader.variables();
    let names: Vec<_> = found.iter().map(|it| (it.name.as_str(), it.components, it.function.as_deref())).collect();
    let main = Some("main");
    let expected = [
        ("uv", 2, None),
        ("color", 4, None),
        ("x", 1, Some("f")),
        ("y", 3, Some("f")),
        ("a", 1, main),
        ("b", 1, main),
        ("c", 1, main),
        ("t", 1, main),
        ("p", 3, main),
    ];
    assert_eq!(names, expected);
    for index in 0..found.len() {
        let marked = shader.with_vector(&[index], "1.0").unwrap_or_else(|it| panic!("{it}"));
        augment(&marked, Language::Glsl).unwrap_or_else(|it| panic!("{it}\n{marked}"));
    }
}
