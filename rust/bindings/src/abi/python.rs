//! Python's declarations of the C ABI, `plugins/python/librelievo/abi.py`.

use std::fmt::Write as _;

use super::types::{NUMBERS, Signature, Type};
use super::value::Value;
use super::{Abi, Enumerator, Kind};

const HEAD: &str = "\"\"\"The C ABI of Relievo as ctypes sees it: constants, enumerations, structs and functions, named as in the headers.

Made by `cargo xtask bindings` from include/relievo; do not edit. `INIT` holds what the RLV_..._INIT of a struct hold.
\"\"\"

import ctypes
from ctypes import POINTER, Structure, c_char, c_char_p, c_void_p
";

/// The text of the module.
///
/// # Errors
/// `ctypes` or the package has no type for an argument or a field.
pub fn module(abi: &Abi) -> Result<String, String> {
    let mut text = HEAD.to_owned();
    let mut numbers: Vec<&str> = NUMBERS.iter().map(|number| number.python).collect();
    numbers.sort_unstable();
    let _ = writeln!(text, "from ctypes import {}\nfrom enum import IntEnum\n", numbers.join(", "));
    for item in abi.items() {
        match &item.kind {
            Kind::Constant(value) => {
                let _ = writeln!(text, "{} = {value}", item.name);
            }
            Kind::Enumeration(values) if item.name.is_empty() => {
                for Enumerator { name, value, .. } in values {
                    let _ = writeln!(text, "{name} = {value}");
                }
            }
            _ => {}
        }
    }
    for item in abi.items() {
        if let Kind::Enumeration(values) = &item.kind
            && !item.name.is_empty()
        {
            let _ = writeln!(text, "\n\nclass {}(IntEnum):", item.name);
            let prefix = common_prefix(values);
            for Enumerator { name, value, .. } in values {
                let _ = writeln!(text, "    {} = {value}", name.strip_prefix(prefix).unwrap_or(name));
            }
        }
    }
    for number in NUMBERS {
        let _ = writeln!(text, "\n\nclass {0}_p(c_void_p):\n    target = {0}", number.python);
    }
    // What stands in its own block is set off by two lines from the block before and from what follows.
    let mut block = true;
    for item in abi.items() {
        let line = match &item.kind {
            Kind::Alias(kind) => format!("{} = {}", item.name, kind.python()?),
            Kind::Callback(signature) => format!("{} = ctypes.CFUNCTYPE({})", item.name, callback(signature)?),
            Kind::Structure(structure) => {
                let _ = writeln!(text, "\n\nclass {}(Structure):\n    _fields_ = [", item.name);
                for field in &structure.fields {
                    let kind = field.kind.python().map_err(|error| format!("{}.{}: {error}", item.name, field.name))?;
                    let _ = writeln!(text, "        (\"{}\", {kind}),", field.name);
                }
                text.push_str("    ]\n");
                block = true;
                continue;
            }
            _ => continue,
        };
        let _ = writeln!(text, "{}{line}", if block { "\n\n" } else { "\n" });
        block = false;
    }
    text.push_str("\n\nINIT = {\n");
    for item in abi.items() {
        if let Kind::Structure(structure) = &item.kind
            && let Some(values) = &structure.initial
        {
            let _ = writeln!(text, "    {}: {},", item.name, Value::List(values.clone()).python());
        }
    }
    text.push_str("}\n\n# Every function: what it returns, and the names and types of what it takes.\nFUNCTIONS = {\n");
    for item in abi.items() {
        if let Kind::Function(signature) = &item.kind {
            let entry = function(signature).map_err(|error| format!("{}: {error}", item.name))?;
            let _ = writeln!(text, "    \"{}\": {entry},", item.name);
        }
    }
    text.push_str("}\n");
    Ok(text)
}

fn function(signature: &Signature) -> Result<String, String> {
    let pairs = signature.arguments.iter().map(|(name, kind)| Ok(format!("(\"{name}\", {})", kind.python()?)));
    let pairs: Vec<String> = pairs.collect::<Result<_, String>>()?;
    Ok(format!("({}, [{}])", signature.result.python()?, pairs.join(", ")))
}

fn callback(signature: &Signature) -> Result<String, String> {
    let kinds = signature.arguments.iter().map(|(_, kind)| kind);
    let kinds = std::iter::once(&signature.result).chain(kinds).map(Type::python);
    Ok(kinds.collect::<Result<Vec<_>, _>>()?.join(", "))
}

/// What the names of an enumeration begin with, up to an underscore.
fn common_prefix(values: &[Enumerator]) -> &str {
    let first = values.first().map_or("", |value| value.name.as_str());
    let same = |other: &Enumerator| first.bytes().zip(other.name.bytes()).take_while(|(a, b)| a == b).count();
    let length = values.iter().map(same).min().unwrap_or(0);
    first[..length].rfind('_').map_or("", |at| &first[..=at])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::abi::{Field, Item, Noun, Structure};

    #[test]
    fn declarations_are_written_in_the_order_of_their_use() {
        let item = |name: &str, kind| Item { name: name.into(), doc: String::new(), line: 1, kind };
        let value = |name: &str, value| Enumerator { name: name.into(), value, doc: String::new() };
        let number = |rust| Type::Number(NUMBERS.into_iter().find(|number| number.rust == rust).unwrap());
        let field = |name: &str, kind, offset| Field { name: name.into(), kind, offset, doc: String::new() };
        let ball = Structure {
            size: 12,
            align: 4,
            fields: vec![field("radius", number("f32"), 0), field("name", Type::Array(Box::new(Type::Char), 8), 4)],
            initial: Some(vec![Value::Real("1.5".into()), Value::List(vec![Value::Integer(0)])]),
        };
        let pointer = Type::Pointer(Box::new(Type::Named("RlvBall".into())), true);
        let items = vec![
            item("RLV_BALLS", Kind::Constant(7)),
            item("", Kind::Enumeration(vec![value("RLV_OK", 0)])),
            item("RlvSide", Kind::Enumeration(vec![value("RLV_SIDE_UP", 0), value("RLV_SIDE_UPWARD", 1)])),
            item("RlvResult", Kind::Alias(number("i32"))),
            item("RlvBall", Kind::Structure(ball)),
            item(
                "RlvSeen",
                Kind::Callback(Signature { arguments: vec![("ball".into(), pointer.clone())], result: Type::Void }),
            ),
            item(
                "rlv_roll",
                Kind::Function(Signature {
                    arguments: vec![("ball".into(), pointer)],
                    result: Type::Named("RlvResult".into()),
                }),
            ),
        ];
        let abi = Abi { nouns: vec![Noun { name: "ball".into(), about: String::new(), items }] };
        let text = module(&abi).unwrap();
        let parts = [
            "\nRLV_BALLS = 7\nRLV_OK = 0\n\n\nclass RlvSide(IntEnum):\n    UP = 0\n    UPWARD = 1\n\n\n",
            "class c_float_p(c_void_p):\n    target = c_float\n",
            "\n\nRlvResult = c_int32\n\n\nclass RlvBall(Structure):\n    _fields_ = [\n        (\"radius\", c_float),\n        (\"name\", c_char * 8),\n    ]\n",
            "\n\nRlvSeen = ctypes.CFUNCTYPE(None, POINTER(RlvBall))\n",
            "\n\nINIT = {\n    RlvBall: (1.5, (0,),),\n}\n",
            "\n    \"rlv_roll\": (RlvResult, [(\"ball\", POINTER(RlvBall))]),\n}\n",
        ];
        let mut at = 0;
        for part in parts {
            at += text[at..].find(part).unwrap_or_else(|| panic!("no {part} after {at} in\n{text}"));
        }
    }
}
