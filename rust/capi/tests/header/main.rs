//! The headers and the Rust side declare the same.
//!
//! `comparison.rs` has the declarations of the headers as the C compiler reads them, as calls of the macros below. It
//! compiles only if every function, callback and field has the same types here, and every constant and structure the
//! same value, size and alignment. `cargo xtask bindings` writes it.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use relievo_core::parameter::{Parameter, ParameterKind, Switch};

/// Name of a field, its offset here and its offset in C.
pub type Offsets = Vec<(&'static str, usize, usize)>;

/// What the `RLV_..._INIT` of a structure of numbers has.
pub struct Initial {
    /// The header's file.
    pub header: &'static str,
    /// The structure's name.
    pub name: &'static str,
    /// The macro's name.
    pub initializer: &'static str,
    /// Declaration and value of every field but `struct_size`.
    pub fields: &'static [(&'static str, f64)],
}

macro_rules! constant {
    ($name:ident = $value:expr) => {
        const _: () = assert!($name as i128 == $value);
    };
}

macro_rules! alias {
    ($name:ident = $type:ty) => {
        const _: fn($name) -> $type = |same| same;
    };
}

macro_rules! function {
    ($name:ident: $type:ty) => {
        const _: $type = $name;
    };
}

macro_rules! layout {
    ($name:ident: $size:literal, $align:literal) => {
        const _: () = assert!(size_of::<$name>() == $size && align_of::<$name>() == $align);
    };
}

macro_rules! fields {
    ($list:ident, $name:ident { $($field:ident: $type:ty = $offset:literal,)* }) => {{
        let whole = std::mem::MaybeUninit::<$name>::zeroed();
        // SAFETY: fields are numbers, pointers, optional functions and arrays of them, all of which may be zero.
        let whole = unsafe { whole.assume_init_ref() };
        $({
            // The fields of settings are those of the Rust structure behind `struct_size`, to which the C one
            // dereferences.
            let field = crate::DeclaredAs::<$type>::checked(&whole.$field);
            let offset = std::ptr::from_ref(field).addr() - std::ptr::from_ref(whole).addr();
            $list.push((concat!(stringify!($name), ".", stringify!($field)), offset, $offset));
        })*
    }};
}

#[rustfmt::skip]
mod comparison;
mod conventions;

/// A type that C declares as `T`: `T` itself, and a switch, which is transparent.
trait DeclaredAs<T> {
    fn checked(&self) -> &Self {
        self
    }
}

impl<T> DeclaredAs<T> for T {}
impl DeclaredAs<u32> for Switch {}

fn folder(inside: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(inside)
}

#[test]
fn fields_are_where_c_has_them() {
    let mut offsets = Offsets::new();
    comparison::offsets(&mut offsets);
    assert!(offsets.len() > 500, "{} fields", offsets.len());
    let wrong: Vec<_> = offsets.iter().filter(|(_, here, in_c)| here != in_c).collect();
    assert!(wrong.is_empty(), "name, offset here, offset in C: {wrong:?}");
}

/// The texts of the Rust files of a folder and those below it.
fn sources(folder: &Path) -> String {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let text = |path: &PathBuf| if path.is_dir() { sources(path) } else { std::fs::read_to_string(path).unwrap() };
    paths.iter().map(text).collect()
}

#[test]
fn names_of_constants_are_those_of_the_headers() {
    let known: BTreeSet<&str> = comparison::NAMES.iter().copied().collect();
    let text = sources(&folder("src"));
    let is_word = |letter: char| letter.is_ascii_uppercase() || letter.is_ascii_digit() || letter == '_';
    let names = text.match_indices("RLV_").map(|(at, _)| text[at..].split(|letter| !is_word(letter)).next().unwrap());
    // A name that ends with a line stands for all names that begin with it.
    let exists =
        |name: &str| known.contains(name) || name.ends_with('_') && known.iter().any(|it| it.starts_with(name));
    let unknown: BTreeSet<&str> = names.filter(|name| !exists(name)).collect();
    assert!(unknown.is_empty(), "the headers have no {unknown:?}");
}

/// The structures whose fields are tables of parameters in Rust.
const SETTINGS: [(&str, &[Parameter]); 4] = [
    ("RlvImprintSettings", relievo_detail::ImprintSettings::PARAMETERS),
    ("RlvToolSettings", relievo_detail::tool::ToolSettings::PARAMETERS),
    ("RlvBrushSettings", relievo_detail::StrokeSettings::PARAMETERS),
    ("RlvStampSettings", relievo_detail::StampSettings::PARAMETERS),
];

fn initial(name: &str) -> &'static Initial {
    comparison::INITIAL.iter().find(|it| it.name == name).unwrap_or_else(|| panic!("{name} has no initial numbers"))
}

/// How a header declares a parameter.
fn declaration(parameter: &Parameter) -> String {
    format!("{} {}", if parameter.kind == ParameterKind::F32 { "float" } else { "uint32_t" }, parameter.name)
}

/// The line of the header that declares a parameter.
fn header_line(parameter: &Parameter) -> String {
    let Parameter { min, max, unit, help, .. } = parameter;
    let comment = format!("/* {} {min} to {max} {unit}", help.trim_end());
    format!("    {}; {} */", declaration(parameter), comment.trim_end())
}

/// What to write in a header so that a structure has these parameters; empty if it has.
fn corrections(Initial { name, initializer, fields, .. }: &Initial, parameters: &[Parameter]) -> String {
    let mut wrong = String::new();
    let declared: Vec<&str> = fields.iter().map(|(declaration, _)| *declaration).collect();
    let expected: Vec<String> = parameters.iter().map(declaration).collect();
    for (index, parameter) in parameters.iter().enumerate() {
        if !declared.contains(&expected[index].as_str()) {
            let before = index.checked_sub(1).map_or("uint32_t struct_size", |before| &expected[before]);
            let line = header_line(parameter);
            writeln!(wrong, "{name} lacks after `{before};` the line\n{line}").unwrap();
        }
    }
    for extra in declared.iter().filter(|declaration| !expected.iter().any(|it| it == *declaration)) {
        writeln!(wrong, "{name} has `{extra};`, which is no parameter: take the line out").unwrap();
    }
    if wrong.is_empty() && declared != expected {
        writeln!(wrong, "{name} has its fields in another order: write `{};`", expected.join("; ")).unwrap();
    }
    let values = fields.iter().map(|(_, value)| *value as f32);
    if !values.eq(parameters.iter().map(|parameter| parameter.default as f32)) {
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
    for (name, parameters) in SETTINGS {
        let initial = initial(name);
        for line in corrections(initial, parameters).lines() {
            let place = if line.starts_with(' ') { "" } else { &format!("include/relievo/{}: ", initial.header) };
            writeln!(wrong, "{place}{line}").unwrap();
        }
    }
    assert!(
        wrong.is_empty(),
        "parameters changed; in the headers, and in tests/fuzz/src/bin/fuzz_capi.rs:\n{wrong}then run `cargo xtask bindings`"
    );
}

#[test]
fn a_parameter_that_a_header_lacks_is_named_with_its_line() {
    let (name, parameters) = SETTINGS[1];
    let initial = initial(name);
    let mut more = parameters.to_vec();
    more.push(Parameter {
        name: "grip",
        help: "Share of the force along it.",
        default: 0.25,
        max: 1.0,
        ..parameters[0]
    });
    let said = corrections(initial, &more);
    assert!(
        said.contains("after `float max_depth;` the line\n    float grip; /* Share of the force along it. "),
        "{said}"
    );
    assert!(said.contains("RLV_TOOL_SETTINGS_INIT is {sizeof(RlvToolSettings), 1.0f, 1.0f, 0.25f}"), "{said}");
    let said = corrections(initial, &parameters[..1]);
    assert!(said.contains("has `float max_depth;`, which is no parameter"), "{said}");
    let swapped = [parameters[1], parameters[0]];
    assert!(corrections(initial, &swapped).contains("another order: write `float max_depth; float stiffness;`"));
}
