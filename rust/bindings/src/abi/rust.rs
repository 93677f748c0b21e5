//! The declarations as calls of the macros in `rust/capi/tests/header/main.rs`, in which the compiler compares them with
//! the Rust side.

use std::fmt::Write as _;

use super::types::rust_name;
use super::value::Value;
use super::{Abi, Item, Kind, Noun, Structure};

const HEAD: &str = "// Made by `cargo xtask bindings` from include/relievo; do not edit.\n
use std::ffi::{c_char, c_void};\n\n";

/// The text of the module. The Rust side of a header is the module of the same name, or what that exports.
pub fn comparison(abi: &Abi) -> String {
    let mut text = HEAD.to_owned();
    for noun in &abi.nouns {
        let _ = writeln!(text, "use relievo::{}::*;", noun.name);
    }
    text.push_str("\nuse super::{Initial, Offsets};\n\n");
    for item in abi.items() {
        declaration(&mut text, item);
    }
    text.push_str("\npub fn offsets(list: &mut Offsets) {\n");
    for item in abi.items() {
        if let Kind::Structure(structure) = &item.kind {
            fields(&mut text, &item.name, structure);
        }
    }
    text.push_str("}\n\npub const INITIAL: &[Initial] = &[\n");
    for noun in &abi.nouns {
        for item in &noun.items {
            initial(&mut text, noun, item);
        }
    }
    text.push_str("];\n\npub const NAMES: &[&str] = &[\n");
    for name in names(abi) {
        let _ = writeln!(text, "    \"{name}\",");
    }
    text.push_str("];\n");
    text
}

fn declaration(text: &mut String, item: &Item) {
    let name = &item.name;
    let _ = match &item.kind {
        Kind::Constant(value) => writeln!(text, "constant!({name} = {value});"),
        Kind::Enumeration(values) => {
            values.iter().try_for_each(|it| writeln!(text, "constant!({} = {});", it.name, it.value))
        }
        Kind::Alias(kind) => writeln!(text, "alias!({name} = {});", kind.rust()),
        Kind::Callback(signature) => writeln!(text, "alias!({name} = Option<{}>);", signature.rust()),
        Kind::Structure(structure) => writeln!(text, "layout!({name}: {}, {});", structure.size, structure.align),
        Kind::Function(signature) => writeln!(text, "function!({name}: {});", signature.rust()),
        Kind::Macro(_) => Ok(()),
    };
}

fn fields(text: &mut String, name: &str, structure: &Structure) {
    let _ = writeln!(text, "    fields!(list, {name} {{");
    for field in &structure.fields {
        let _ = writeln!(text, "        {}: {} = {},", rust_name(&field.name), field.kind.rust(), field.offset);
    }
    text.push_str("    });\n");
}

/// Writes the initial values of a structure of numbers.
fn initial(text: &mut String, noun: &Noun, item: &Item) {
    let Kind::Structure(structure) = &item.kind else { return };
    let Some([Value::SizeOf(_), values @ ..]) = structure.initial.as_deref() else { return };
    let numbers: Option<Vec<f64>> = values.iter().map(Value::number).collect();
    let Some(numbers) = numbers else { return };
    let (header, name, initializer) = (&noun.name, &item.name, initializer(&item.name));
    let _ = writeln!(
        text,
        "    Initial {{ header: \"{header}.h\", name: \"{name}\", initializer: \"{initializer}\", fields: &["
    );
    for (field, number) in structure.fields.iter().skip(1).zip(numbers) {
        let _ = writeln!(text, "        (\"{}\", {number:?}),", field.kind.c(&field.name));
    }
    text.push_str("    ] },\n");
}

/// Every name in capital letters that the headers define.
fn names(abi: &Abi) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for item in abi.items() {
        match &item.kind {
            Kind::Enumeration(values) => names.extend(values.iter().map(|value| value.name.clone())),
            Kind::Constant(_) => names.push(item.name.clone()),
            Kind::Macro(_) => names.extend(item.name.split('(').next().map(str::to_owned)),
            Kind::Structure(Structure { initial: Some(_), .. }) => names.push(initializer(&item.name)),
            _ => {}
        }
    }
    names.sort_unstable();
    names
}

/// Name of the macro that initialises a structure: `RlvToolSettings` has `RLV_TOOL_SETTINGS_INIT`.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::abi::types::{NUMBERS, Signature, Type};
    use crate::abi::{Enumerator, Field};

    #[test]
    fn each_declaration_becomes_a_comparison() {
        let item = |name: &str, kind| Item { name: name.into(), doc: String::new(), line: 1, kind };
        let number = |at: usize| Type::Number(NUMBERS[at]);
        let pointer = Type::Pointer(Box::new(Type::Named("RlvBallInfo".into())), false);
        let roll = |result| Signature { arguments: vec![("out".into(), pointer.clone())], result };
        let fields = [("struct_size", number(4), 0), ("type", number(0), 4)];
        let fields = fields.map(|(name, kind, offset)| Field { name: name.into(), kind, offset, doc: String::new() });
        let initial = vec![Value::SizeOf("RlvBallInfo".into()), Value::Real("1.5".into())];
        let ball = Structure { size: 8, align: 4, fields: fields.into(), initial: Some(initial) };
        let side = Enumerator { name: "RLV_SIDE_UP".into(), value: 2, doc: String::new() };
        let items = vec![
            item("RLV_BALL_END", Kind::Macro("{0}".into())),
            item("RlvSide", Kind::Enumeration(vec![side])),
            item("RlvBallInfo", Kind::Structure(ball)),
            item("RlvSeen", Kind::Callback(roll(Type::Void))),
            item("rlv_ball_info", Kind::Function(roll(number(6)))),
        ];
        let abi = Abi { nouns: vec![Noun { name: "ball".into(), about: String::new(), items }] };
        let text = comparison(&abi);
        for part in [
            "use relievo::ball::*;\n",
            "\nconstant!(RLV_SIDE_UP = 2);\nlayout!(RlvBallInfo: 8, 4);\n",
            "\nalias!(RlvSeen = Option<unsafe extern \"C\" fn(*mut RlvBallInfo)>);\n",
            "\nfunction!(rlv_ball_info: unsafe extern \"C\" fn(*mut RlvBallInfo) -> i32);\n",
            "    fields!(list, RlvBallInfo {\n        struct_size: u32 = 0,\n        type_: f32 = 4,\n    });\n",
            "initializer: \"RLV_BALL_INFO_INIT\", fields: &[\n        (\"float type\", 1.5),\n",
            "NAMES: &[&str] = &[\n    \"RLV_BALL_END\",\n    \"RLV_BALL_INFO_INIT\",\n    \"RLV_SIDE_UP\",\n];\n",
        ] {
            assert!(text.contains(part), "no {part} in\n{text}");
        }
    }
}
