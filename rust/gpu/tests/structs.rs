//! The structs that the build script writes from WGSL: their layouts, and that they are written once.

// What the build script uses and these tests do not.
#[allow(dead_code)]
#[path = "../build/layout.rs"]
mod layout;
#[allow(dead_code)]
#[path = "../build/rust.rs"]
mod rust;
#[allow(dead_code)]
#[path = "../build/wgsl.rs"]
mod wgsl;

use std::path::{Path, PathBuf};

use layout::{Layout, Modules};
use relievo_gpu::module::{MODULES, compose};
use relievo_gpu::wgpu::naga;

/// Reads modules, each given by its name and text.
fn read(modules: &[(&str, &str)]) -> Modules {
    Modules(modules.iter().map(|(name, text)| wgsl::Module::read(name, name, text).expect("a module")).collect())
}

/// Returns the layout of the last struct of `text`.
fn layout(text: &str) -> Layout {
    let modules = read(&[("it", text)]);
    let module = &modules.0[0];
    modules.layout(module, module.structs.last().expect("a struct")).expect("a layout")
}

fn places(layout: &Layout) -> Vec<(&str, &str, u32)> {
    layout.fields.iter().map(|field| (&*field.name, &*field.rust, field.offset)).collect()
}

#[test]
fn a_number_goes_into_the_fourth_word_of_a_vector_of_three() {
    let layout = layout("struct S {\n    a: vec3<f32>,\n    b: f32,\n    c: vec3<i32>,\n    d: vec2<u32>,\n}\n");
    let expected = [("a", "[f32; 3]", 0), ("b", "f32", 12), ("c", "[i32; 3]", 16), ("d", "[u32; 2]", 32)];
    assert_eq!((places(&layout), layout.size, layout.align), (expected.to_vec(), 48, 16));
}

#[test]
fn arrays_have_the_stride_of_their_elements() {
    let text = "const FEW: u32 = 3u;\nstruct S {\n    a: u32,\n    b: array<u32, FEW>,\n    c: array<vec3<f32>, 2>,\n    \
                d: array<array<vec2<f32>, 2>, 4>,\n}\n";
    let layout = layout(text);
    let expected = [("a", "u32", 0), ("b", "[u32; 3]", 4), ("c", "[[f32; 4]; 2]", 16), ("d", "[[[f32; 2]; 2]; 4]", 48)];
    assert_eq!((places(&layout), layout.size), (expected.to_vec(), 112));
}

#[test]
fn columns_of_three_rows_have_four_words() {
    let layout = layout("struct S {\n    a: f32,\n    b: mat3x3<f32>,\n    c: mat4x4<f32>,\n    d: mat2x2<f32>,\n}\n");
    let expected =
        [("a", "f32", 0), ("b", "[[f32; 4]; 3]", 16), ("c", "[[f32; 4]; 4]", 64), ("d", "[[f32; 2]; 2]", 128)];
    assert_eq!((places(&layout), layout.size), (expected.to_vec(), 144));
}

#[test]
fn a_struct_in_a_struct_has_its_whole_size_and_the_name_of_its_module() {
    let own = "struct Inner {\n    a: vec3<f32>,\n    b: vec2<f32>,\n}\n";
    let outer = "// import inner\nstruct S {\n    a: Inner,\n    b: u32,\n    c: array<Inner, 2>,\n}\n";
    let modules = read(&[("inner", own), ("outer", outer)]);
    let layout = modules.layout(&modules.0[1], &modules.0[1].structs[0]).expect("a layout");
    let expected = [("a", "super::inner::Inner", 0), ("b", "u32", 32), ("c", "[super::inner::Inner; 2]", 48)];
    assert_eq!((places(&layout), layout.size), (expected.to_vec(), 112));
}

#[test]
fn attributes_set_sizes_and_alignments() {
    let layout = layout("struct S {\n    @size(12) a: atomic<u32>,\n    @align(16) b: u32,\n}\n");
    assert_eq!((places(&layout), layout.size), (vec![("a", "u32", 0), ("b", "u32", 16)], 32));
}

#[test]
fn structs_of_shared_variables_are_written_with_comments_and_padding() {
    let text = "\
// What is shared.
struct Shared {
    // Where it is.
    at: vec3<f32>,
    to: vec3<f32>, // along it
    own: Own,
    most: u32,
}

struct Own {
    count: atomic<u32>,
}

struct Local {
    there: bool,
}

// As long as its buffer.
struct All {
    count: u32,
    shared: array<Shared>,
}

@group(0) @binding(0) var<storage, read_write> all: All;
var<private> local: Local;
";
    let written = rust::write(&read(&[("it", text)])).expect("structs");
    let expected = "\
/// Structs of `shaders/it`.
pub mod it {
/// What is shared.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Shared {
/// Where it is.
pub at: [f32; 3],
/// Not read.
pub padding: u32,
pub to: [f32; 3],
pub own: Own,
pub most: u32,
/// Not read.
pub padding_2: [u32; 3],
}
impl Default for Shared { fn default() -> Self { bytemuck::Zeroable::zeroed() } }
const _: () = assert!(size_of::<Shared>() == 48 && std::mem::offset_of!(Shared, at) == 0 && \
        std::mem::offset_of!(Shared, to) == 16 && std::mem::offset_of!(Shared, own) == 28 && \
        std::mem::offset_of!(Shared, most) == 32);
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Own {
pub count: u32,
}
impl Default for Own { fn default() -> Self { bytemuck::Zeroable::zeroed() } }
const _: () = assert!(size_of::<Own>() == 4 && std::mem::offset_of!(Own, count) == 0);
}
";
    assert_eq!(written, expected);
}

#[test]
fn what_hosts_cannot_share_is_named_with_its_place() {
    let fault = |fields: &str| {
        let text = format!("struct S {{\n{fields}\n}}\nvar<immediate> call: S;\n");
        rust::write(&read(&[("it.wgsl", &text)])).expect_err("a fault")
    };
    assert_eq!(fault("    there: bool,"), "shaders/it.wgsl:2: `bool`: hosts cannot share this type");
    assert_eq!(fault("    a: u32,\n    b: vec2<f16>,"), "shaders/it.wgsl:3: `vec2<f16>`: hosts cannot share this type");
    assert_eq!(
        fault("    a: array<u32, MANY>,"),
        "shaders/it.wgsl:2: `array<u32, MANY>`: its length is a number or a constant of this file"
    );
    assert_eq!(
        fault("    @location(0) a: u32,"),
        "shaders/it.wgsl:2: hosts share no fields with `@location(0) a: u32`"
    );
    assert_eq!(fault("    a: Other,"), "shaders/it.wgsl: no struct `Other` in this module and its imports");
    let open = wgsl::Module::read("it", "it.wgsl", "\nstruct S {\n    a: u32,\n").expect_err("a fault");
    assert_eq!(open, "shaders/it.wgsl:2: a struct ends with a line `}`");
}

fn all() -> Modules {
    let read = |module: &relievo_gpu::module::Module| wgsl::Module::read(module.name, module.file, module.text);
    Modules(MODULES.iter().map(|module| read(module).expect("a module")).collect())
}

#[test]
fn layouts_are_those_of_the_compiler() {
    let modules = all();
    let shared = modules.shared().expect("structs");
    for (module, found) in &shared {
        let composed = compose(&module.name).expect("the module");
        let parsed = naga::front::wgsl::parse_str(&composed.text).expect("valid WGSL");
        let place = format!("`{}` of shaders/{}", found.name, module.file);
        let compiled = parsed.types.iter().find(|(_, it)| it.name.as_deref() == Some(&found.name));
        let (_, compiled) = compiled.unwrap_or_else(|| panic!("no {place}"));
        let naga::TypeInner::Struct { members, span } = &compiled.inner else { panic!("{place} is no struct") };
        let members: Vec<_> = members.iter().map(|it| (it.name.clone().unwrap_or_default(), it.offset)).collect();
        let layout = modules.layout(module, found).expect("a layout");
        let fields: Vec<_> = layout.fields.iter().map(|it| (it.name.clone(), it.offset)).collect();
        assert_eq!((fields, layout.size), (members, *span), "{place}");
    }
    assert!(shared.len() > 60, "{} structs", shared.len());
}

/// Files whose twins of WGSL structs are written by hand.
const BY_HAND: &[&str] = &[
    // A type of the crate's interface with functions of its own, which compares the layouts.
    "surface/src/place.rs",
];

/// A struct in Rust is a twin if it has the same fields, by name and in order; `padding` apart.
#[test]
fn no_struct_is_written_a_second_time_in_rust() {
    let modules = all();
    let names = |(module, found): &(&wgsl::Module, &wgsl::Struct)| {
        let fields = module.fields(found).expect("its fields");
        let names: Vec<String> = fields.into_iter().map(|it| it.name).filter(|it| !it.starts_with("padding")).collect();
        (format!("shaders/{}", module.file), found.name.clone(), names)
    };
    let shared: Vec<_> = modules.shared().expect("structs").iter().map(names).collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut files = Vec::new();
    collect(&root, &mut files);
    assert!(files.len() > 500, "{} files", files.len());
    let mut twins = Vec::new();
    for path in files {
        let file = path.strip_prefix(&root).expect("a file below it").to_string_lossy().replace('\\', "/");
        let text = std::fs::read_to_string(&path).expect("a source");
        if BY_HAND.contains(&&*file) {
            continue;
        }
        for (name, fields) in structs(&text) {
            let twin = shared.iter().find(|(_, _, names)| *names == fields);
            twins.extend(twin.map(|(module, of, _)| format!("rust/{file}: `{name}` is `{of}` of {module}")));
        }
    }
    assert!(twins.is_empty(), "use relievo_gpu::wgsl instead of\n  {}", twins.join("\n  "));
}

/// Returns the names of the structs with `#[repr(C)]` in `text`, and the names of their fields, `padding` apart.
fn structs(text: &str) -> Vec<(&str, Vec<&str>)> {
    let parts = text.split("#[repr(C)]").skip(1);
    let found = parts.filter_map(|part| {
        let (head, rest) = part.split_once('{')?;
        let name = head.split("struct ").nth(1)?.trim();
        // A tuple struct has no `{` of its own.
        if head.contains(';') {
            return None;
        }
        let (body, _) = rest.split_once("\n}")?;
        let lines = body.lines().map(str::trim).filter(|line| !line.starts_with("//"));
        let names = lines.filter_map(|line| line.split_once(':')?.0.split_whitespace().last());
        Some((name, names.filter(|name| !name.starts_with("padding")).collect()))
    });
    found.collect()
}

#[test]
fn fields_of_structs_in_rust_are_read() {
    let text = "#[repr(C)]\n#[derive(Clone)]\npub struct A {\n    /// What: it is.\n    pub(crate) a: [f32; 3],\n    \
                padding: u32,\n    b: u32,\n}\n\n#[repr(C)]\nstruct B(u32);\n\nstruct C {\n    c: u32,\n}\n";
    assert_eq!(structs(text), [("A", vec!["a", "b"])]);
}

/// Adds the Rust sources in `folder` to `files`.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}
