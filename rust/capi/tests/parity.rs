//! The hand-written headers and the Rust side say the same: every function's signature, every constant's value, every
//! struct's size, fields and offsets. Where settings that Rust defines have changed, the failure says which lines of
//! which header to write.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use relievo_core::parameter::{Parameter, ParameterKind};

fn folder(inside: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(inside)
}

/// The files of a folder and those below it.
fn texts(folder: &Path, extension: &str) -> String {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let text = |path: &PathBuf| match path.is_dir() {
        true => texts(path, extension),
        false if path.extension().is_some_and(|found| found == extension) => std::fs::read_to_string(path).unwrap(),
        false => String::new(),
    };
    paths.iter().map(text).collect()
}

/// The headers without comments, preprocessor lines and line breaks.
fn headers() -> String {
    let mut text = texts(&folder("../../include/relievo"), "h");
    while let Some(start) = text.find("/*") {
        let end = start + text[start..].find("*/").unwrap() + 2;
        text.replace_range(start..end, " ");
    }
    let mut plain = String::new();
    let mut continued = false;
    for line in text.lines() {
        let directive = continued || line.trim_start().starts_with('#');
        continued = directive && line.ends_with('\\');
        if !directive {
            plain.push_str(line);
            plain.push(' ');
        }
    }
    plain
}

/// A C declaration `const float *points` or `float low[3]` as the Rust type of a parameter.
fn rust_type(declaration: &str) -> String {
    let declaration = declaration.replace('*', " * ");
    let mut words: Vec<&str> = declaration.split_whitespace().collect();
    let array = words.last().is_some_and(|word| word.contains('['));
    words.pop();
    let constant = words.first() == Some(&"const");
    if constant {
        words.remove(0);
    }
    let base = match words[0] {
        "float" => "f32",
        "double" => "f64",
        "uint8_t" => "u8",
        "uint16_t" => "u16",
        "uint32_t" => "u32",
        "uint64_t" => "u64",
        "int32_t" => "i32",
        "size_t" => "usize",
        "char" => "c_char",
        "void" => "c_void",
        other => other,
    };
    let stars = words.iter().filter(|word| **word == "*").count() + usize::from(array);
    match (stars, constant) {
        (0, _) => base.to_string(),
        (1, true) => format!("*const {base}"),
        (1, false) => format!("*mut {base}"),
        (2, true) => format!("*mut *const {base}"),
        _ => panic!("cannot read {declaration}"),
    }
}

fn split_arguments(list: &str) -> Vec<&str> {
    list.split(',').map(str::trim).filter(|argument| !argument.is_empty() && *argument != "void").collect()
}

#[test]
fn signatures_agree() {
    let headers = headers();
    let declared: BTreeMap<String, Vec<String>> = headers
        .split("RLV_API ")
        .skip(1)
        .map(|declaration| {
            let (head, rest) = declaration.split_once('(').unwrap();
            let name = head.split_whitespace().last().unwrap().trim_start_matches('*');
            let (list, _) = rest.split_once(')').unwrap();
            (name.to_string(), split_arguments(list).into_iter().map(rust_type).collect())
        })
        .collect();
    let source = texts(&folder("src"), "rs");
    let mut defined = BTreeMap::new();
    for definition in source.split("fn rlv_").skip(1) {
        let (name, rest) = definition.split_once('(').unwrap();
        let (list, _) = rest.split_once([')', '{']).unwrap();
        let arguments = split_arguments(list)
            .into_iter()
            .map(|argument| argument.split_once(':').unwrap().1.split_whitespace().collect::<Vec<_>>().join(" "));
        assert!(defined.insert(format!("rlv_{name}"), arguments.collect::<Vec<_>>()).is_none(), "{name} twice");
    }
    assert!(declared.len() > 10);
    assert_eq!(declared, defined);
    let listed = std::fs::read_to_string(folder("../../tests/c/symbols.txt")).unwrap();
    let listed: BTreeSet<&str> = listed.lines().collect();
    let defined: BTreeSet<&str> = defined.keys().map(String::as_str).collect();
    assert_eq!(listed, defined, "tests/c/symbols.txt lists the exported functions");
}

/// Name and fields of every struct of the headers that is not a handle.
fn header_structs(headers: &str) -> BTreeMap<String, Vec<String>> {
    let bodies = headers.split("typedef struct ").skip(1).filter_map(|text| {
        let (name, rest) = text.split_once('{')?;
        let (body, _) = rest.split_once('}')?;
        let fields: Vec<String> = body
            .split(';')
            .filter_map(|field| field.split_whitespace().last())
            .map(|field| field.trim_start_matches('*').split('[').next().unwrap().to_string())
            .collect();
        Some((name.trim().to_string(), fields))
    });
    bodies.filter(|(_, fields)| *fields != ["id"]).collect()
}

#[test]
fn layouts_and_values_agree() {
    let headers = headers();
    let structs = header_structs(&headers);
    let layouts = relievo::layouts();
    let names: BTreeSet<&str> = layouts.iter().map(|layout| layout.name).collect();
    assert_eq!(structs.keys().map(String::as_str).collect::<BTreeSet<_>>(), names);
    let mut probe = String::from("#include <relievo/relievo.h>\n#include <assert.h>\n");
    for layout in &layouts {
        let name = layout.name;
        writeln!(probe, "static_assert(sizeof({name}) == {}, \"{name}\");", layout.size).unwrap();
        let fields: Vec<&str> = layout.fields.iter().map(|(field, _, _)| field.trim_end_matches('_')).collect();
        assert_eq!(structs[name], fields, "{name}");
        for (field, offset, size) in &layout.fields {
            let field = field.trim_end_matches('_');
            writeln!(probe, "static_assert(offsetof({name}, {field}) == {offset}, \"{name}.{field}\");").unwrap();
            writeln!(probe, "static_assert(sizeof((({name} *)0)->{field}) == {size}, \"{name}.{field}\");").unwrap();
        }
    }
    let constants = relievo::constants();
    for (name, value) in &constants {
        writeln!(probe, "static_assert((long long){name} == {value}, \"{name}\");").unwrap();
    }
    // Every enumerator of the headers is compared.
    let known: BTreeSet<&str> = constants.iter().map(|(name, _)| *name).collect();
    for piece in headers.split("enum").skip(1) {
        let Some((_, rest)) = piece.split_once('{') else { continue };
        let (body, _) = rest.split_once('}').unwrap();
        for enumerator in body.split(',').map(|item| item.split('=').next().unwrap().trim()) {
            assert!(enumerator.is_empty() || known.contains(enumerator), "{enumerator} is not compared with Rust");
        }
    }
    let work = tempfile::tempdir().unwrap();
    let source = work.path().join("probe.c");
    std::fs::write(&source, probe).unwrap();
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
    let output = Command::new(compiler)
        .args(["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"])
        .arg(format!("-I{}", folder("../../include").display()))
        .arg(&source)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// The structs whose fields are tables of parameters in Rust: header, name in C, fields.
const SETTINGS: [(&str, &str, &[Parameter]); 4] = [
    ("imprint.h", "RlvImprintSettings", relievo_detail::ImprintSettings::PARAMETERS),
    ("collider.h", "RlvToolSettings", relievo_detail::tool::ToolSettings::PARAMETERS),
    ("brush.h", "RlvBrushSettings", relievo_detail::StrokeSettings::PARAMETERS),
    ("brush.h", "RlvStampSettings", relievo_detail::StampSettings::PARAMETERS),
];

/// The line of the header that declares a parameter.
fn header_line(parameter: &Parameter) -> String {
    let kind = if parameter.kind == ParameterKind::F32 { "float" } else { "uint32_t" };
    let Parameter { name, min, max, unit, help, .. } = parameter;
    format!("    {kind} {name}; /* {help} {min} to {max} {unit}", help = help.trim_end()).trim_end().to_string() + " */"
}

/// Name of the macro that initialises a struct: `RlvToolSettings` has `RLV_TOOL_SETTINGS_INIT`.
fn initializer(name: &str) -> String {
    let mut made = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !made.is_empty() {
            made.push('_');
        }
        made.push(letter.to_ascii_uppercase());
    }
    made + "_INIT"
}

/// What to write in a header whose text is `text`, so that the struct `name` has these parameters; empty if it has.
fn corrections(text: &str, name: &str, parameters: &[Parameter]) -> String {
    let mut wrong = String::new();
    let body = text.split_once(&format!("typedef struct {name} {{")).unwrap().1;
    let (body, after) = body.split_once('}').unwrap();
    let declared: Vec<String> = body
        .lines()
        .filter_map(|line| line.split_once(';'))
        .map(|(declaration, _)| declaration.split_whitespace().collect::<Vec<_>>().join(" "))
        .skip(1)
        .collect();
    let declaration = |parameter: &Parameter| header_line(parameter).split_once(';').unwrap().0.trim().to_string();
    let expected: Vec<String> = parameters.iter().map(declaration).collect();
    for (index, parameter) in parameters.iter().enumerate().filter(|(index, _)| !declared.contains(&expected[*index])) {
        let before = index.checked_sub(1).map_or("uint32_t struct_size", |before| &expected[before]);
        let line = header_line(parameter);
        writeln!(wrong, "{name} lacks after `{before};` the line\n{line}").unwrap();
    }
    for extra in declared.iter().filter(|declaration| !expected.contains(declaration)) {
        writeln!(wrong, "{name} has `{extra};`, which is no parameter: take the line out").unwrap();
    }
    if wrong.is_empty() && declared != expected {
        writeln!(wrong, "{name} has its fields in another order: write `{};`", expected.join("; ")).unwrap();
    }
    let initializer = initializer(name);
    let values = after.split_once(&format!("#define {initializer} ")).unwrap().1.split_once('}').unwrap().0;
    let given = values.split(',').skip(1).map(|value| value.trim().trim_end_matches('f').parse::<f32>().unwrap());
    if !given.eq(parameters.iter().map(|parameter| parameter.default as f32)) {
        let defaults: Vec<String> = parameters
            .iter()
            .map(|parameter| match parameter.kind {
                ParameterKind::F32 => format!("{:?}f", parameter.default as f32),
                _ => parameter.default.to_string(),
            })
            .collect();
        writeln!(wrong, "{initializer} is {{sizeof({name}), {}}}", defaults.join(", ")).unwrap();
    }
    wrong
}

#[test]
fn settings_of_the_headers_are_the_parameters() {
    let mut wrong = String::new();
    for (header, name, parameters) in SETTINGS {
        let text = std::fs::read_to_string(folder("../../include/relievo").join(header)).unwrap();
        for line in corrections(&text, name, parameters).lines() {
            let place = if line.starts_with(' ') { String::new() } else { format!("include/relievo/{header}: ") };
            writeln!(wrong, "{place}{line}").unwrap();
        }
    }
    assert!(wrong.is_empty(), "parameters changed; in the headers, and in tests/fuzz/src/bin/fuzz_capi.rs:\n{wrong}");
}

#[test]
fn a_parameter_that_a_header_lacks_is_named_with_its_line() {
    let (header, name, parameters) = SETTINGS[1];
    let text = std::fs::read_to_string(folder("../../include/relievo").join(header)).unwrap();
    let mut more = parameters.to_vec();
    more.push(Parameter {
        name: "grip",
        help: "Share of the force along it.",
        default: 0.25,
        max: 1.0,
        ..parameters[0]
    });
    let said = corrections(&text, name, &more);
    assert!(
        said.contains("after `float max_depth;` the line\n    float grip; /* Share of the force along it. "),
        "{said}"
    );
    assert!(said.contains("RLV_TOOL_SETTINGS_INIT is {sizeof(RlvToolSettings), 1.0f, 1.0f, 0.25f}"), "{said}");
    let said = corrections(&text, name, &parameters[..1]);
    assert!(said.contains("has `float max_depth;`, which is no parameter"), "{said}");
    let swapped = [parameters[1], parameters[0]];
    assert!(corrections(&text, name, &swapped).contains("another order: write `float max_depth; float stiffness;`"));
}
