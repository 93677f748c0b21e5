//! Reference pages of the C ABI, one for each header, and a check that nothing is left undocumented.
//!
//! A page says of each exported function what it does, how it fails, who owns its results, and which calls may run at
//! the same time. The first two are the comment above it; the others follow from the rules of `context.h` and the words
//! that they define. Numbers with a unit have it in the comment beside them.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::types::{NUMBERS, Signature, Type};
use super::value::Value;
use super::{Abi, Item, Kind, Noun, Structure};

/// Words with which a comment says how a function fails, or that it does not.
const FAILURES: [&str; 5] = ["Fails", "fails", "RLV_ERROR", "refus", "No failure of its own"];
/// Words with which a comment says that a call changes an object, which it then needs alone.
const CHANGES: [&str; 6] = ["Mutating", "Mutates", "mutates", "Edits", "edit its detail", "Draws"];
/// Ends of names of functions about which the rules of `context.h` say everything.
const RULED: [&str; 2] = ["_retain", "_release"];

/// The pages, name and text, with an index; then what is undocumented.
pub fn pages(abi: &Abi) -> (Vec<(String, String)>, Vec<String>) {
    let (mut pages, mut faults) = (Vec::new(), Vec::new());
    let mut index =
        String::from("# The C ABI of Relievo\n\nThe rules of [context](context.md) hold for every noun.\n\n");
    let handles = handles(abi);
    let mut nouns: Vec<&Noun> = abi.nouns.iter().collect();
    nouns.sort_by_key(|noun| &noun.name);
    for noun in nouns {
        let title = title(noun);
        let _ = writeln!(index, "- [{0}]({0}.md): {1}", noun.name, title.lines().next().unwrap_or_default());
        pages.push((format!("{}.md", noun.name), page(noun, title, &handles)));
        faults.extend(noun.items.iter().flat_map(|item| undocumented(item, noun)));
    }
    pages.push(("index.md".into(), index));
    (pages, faults)
}

fn title(noun: &Noun) -> &str {
    noun.about.trim_start_matches("Relievo: ")
}

/// The names of the handles: structures of an id and nothing else.
fn handles(abi: &Abi) -> BTreeSet<&str> {
    let is_handle = |item: &&Item| match &item.kind {
        Kind::Structure(structure) => matches!(structure.fields.as_slice(), [field] if field.name == "id"),
        _ => false,
    };
    abi.items().filter(is_handle).map(|item| item.name.as_str()).collect()
}

fn page(noun: &Noun, title: &str, handles: &BTreeSet<&str>) -> String {
    let mut out = format!("# {}\n\n{title}\n", noun.name);
    for item in &noun.items {
        let Item { name, doc, .. } = item;
        let said = if doc.is_empty() { String::new() } else { format!("\n{doc}\n") };
        // A line without a comment belongs to the one before.
        let begun = if doc.is_empty() { String::new() } else { format!("\n## {name}\n{said}") };
        let _ = match &item.kind {
            Kind::Constant(value) => write!(out, "{begun}\n    #define {name} {value}\n"),
            Kind::Macro(text) => write!(out, "{begun}\n    {}\n", format!("#define {name} {text}").trim_end()),
            Kind::Alias(kind) => write!(out, "{begun}\n    typedef {};\n", kind.c(name)),
            Kind::Callback(signature) => {
                write!(out, "\n## {name}\n\n    typedef {};\n{said}", signature.c(&format!("(*{name})")))
            }
            Kind::Enumeration(values) => {
                let heading = if name.is_empty() { String::new() } else { format!("\n## {name}\n") };
                let rows = values.iter().map(|it| format!("| {} | {} | {} |\n", it.name, it.value, cell(&it.doc)));
                write!(
                    out,
                    "{heading}{said}\n| value | number | meaning |\n|---|---|---|\n{}",
                    rows.collect::<String>()
                )
            }
            Kind::Structure(structure) => write!(out, "\n## {name}\n{said}\n{}", table(structure)),
            Kind::Function(signature) => {
                write!(
                    out,
                    "\n## {name}\n\n    {};\n{said}\n{}",
                    signature.c(name),
                    ruled(item, signature, noun, handles)
                )
            }
        };
    }
    out
}

/// The fields of a structure, with their initial values where it has any.
fn table(structure: &Structure) -> String {
    let mut out = String::from("| field | initially | meaning |\n|---|---|---|\n");
    for (index, field) in structure.fields.iter().enumerate() {
        let initial = structure.initial.as_ref().and_then(|values| values.get(index)).map(c).unwrap_or_default();
        let _ = writeln!(out, "| `{}` | {initial} | {} |", field.kind.c(&field.name), cell(&field.doc));
    }
    out
}

/// A value as C writes it.
fn c(value: &Value) -> String {
    match value {
        Value::SizeOf(name) => format!("sizeof({name})"),
        Value::Null => "NULL".into(),
        Value::Integer(value) => value.to_string(),
        Value::Real(text) => text.clone(),
        Value::List(values) => format!("{{{}}}", values.iter().map(c).collect::<Vec<_>>().join(", ")),
    }
}

/// A comment in the cell of a table.
fn cell(text: &str) -> String {
    one_line(text).replace('|', "\\|")
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What the rules say of a function: ownership and threads.
fn ruled(item: &Item, signature: &Signature, noun: &Noun, handles: &BTreeSet<&str>) -> String {
    let mut out = String::new();
    if item.name.ends_with("_retain") {
        out.push_str("- Ownership: adds a reference, which is released by itself.\n");
    } else if item.name.ends_with("_release") {
        out.push_str("- Ownership: takes a reference away; the last one ends the object.\n");
    } else if let Some(kind) = made(signature).filter(|kind| handles.contains(kind)) {
        let _ = writeln!(out, "- Ownership: gives one reference to {kind}; release it.");
    } else {
        out.push_str("- Ownership: what is passed is borrowed for the call.\n");
    }
    let changes = CHANGES.iter().any(|word| item.doc.contains(word) || noun.about.contains(word));
    out.push_str(match changes {
        true => "- Threads: any; it changes an object and needs it alone, else RLV_ERROR_BUSY.\n",
        false => "- Threads: any, and at the same time as other calls that change nothing.\n",
    });
    out
}

/// The type that a function writes through its last argument.
fn made(signature: &Signature) -> Option<&str> {
    let (name, Type::Pointer(to, false)) = signature.arguments.last()? else { return None };
    match &**to {
        Type::Named(kind) if name.starts_with("out") => Some(kind),
        _ => None,
    }
}

/// What the comments of a declaration leave unsaid.
fn undocumented(item: &Item, noun: &Noun) -> Vec<String> {
    let missing = match &item.kind {
        Kind::Function(signature) => unsaid(item, signature),
        Kind::Structure(structure) => unitless(structure),
        _ => Vec::new(),
    };
    missing.into_iter().map(|what| format!("{}.h:{}: {}: {what}", noun.name, item.line, item.name)).collect()
}

fn unsaid(item: &Item, signature: &Signature) -> Vec<String> {
    let text = one_line(&item.doc);
    if RULED.iter().any(|end| item.name.ends_with(end)) {
        return Vec::new();
    }
    let mut faults = Vec::new();
    if text.is_empty() {
        faults.push("what it does".to_owned());
    }
    if signature.result == Type::Named("RlvResult".into()) && !FAILURES.iter().any(|word| text.contains(word)) {
        faults.push("what it fails at".to_owned());
    }
    // A pointer that is given away is the library's.
    let lent = |kind: &Type| matches!(kind, Type::Pointer(to, false) if matches!(**to, Type::Pointer(_, true)));
    let gives =
        matches!(signature.result, Type::Pointer(_, true)) || signature.arguments.iter().any(|(_, kind)| lent(kind));
    if gives && !text.contains("live") {
        faults.push("how long what it points to lives".to_owned());
    }
    faults
}

/// The numbers with a fraction that have no comment beside them. A number after a commented one of the same type is of
/// the same kind, such as the upper bounds after the lower ones.
fn unitless(structure: &Structure) -> Vec<String> {
    let (mut faults, mut before) = (Vec::new(), None);
    for field in &structure.fields {
        if !field.doc.is_empty() {
            before = Some(&field.kind);
        } else if before != Some(&field.kind) {
            before = None;
        }
        if is_fraction(&field.kind) && before.is_none() {
            faults.push(format!("the unit or range of {}", field.kind.c(&field.name)));
        }
    }
    faults
}

fn is_fraction(kind: &Type) -> bool {
    match kind {
        Type::Number(number) => NUMBERS[..2].contains(number),
        Type::Array(of, _) => is_fraction(of),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::abi::Field;

    #[test]
    fn gaps_in_the_documentation_are_found() {
        let float = || Type::Number(NUMBERS[0]);
        let typed = |name: &str, kind, doc: &str| Field { name: name.into(), kind, offset: 0, doc: doc.into() };
        let field = |name: &str, doc: &str| typed(name, float(), doc);
        let structure = |fields| Kind::Structure(Structure { size: 4, align: 4, fields, initial: None });
        let handle = |constant| Type::Pointer(Box::new(Type::Named("RlvBall".into())), constant);
        let call = |arguments: Vec<(&str, Type)>| {
            let arguments = arguments.into_iter().map(|(name, kind)| (name.to_owned(), kind)).collect();
            Kind::Function(Signature { arguments, result: Type::Named("RlvResult".into()) })
        };
        let item = |name: &str, doc: &str, kind| Item { name: name.into(), doc: doc.into(), line: 3, kind };
        let ball = || Type::Named("RlvBall".into());
        let items = vec![
            item("RLV_BALL_GROUND", "The floor.", Kind::Constant(0)),
            item("RlvBall", "", structure(vec![typed("id", Type::Number(NUMBERS[5]), "")])),
            item("RlvBallInfo", "", structure(vec![field("radius", "")])),
            item("RlvBox", "", structure(vec![field("low", "metres | feet"), field("high", "")])),
            item("rlv_ball_create", "Makes one.", call(vec![("out", handle(false))])),
            item("rlv_ball_release", "", call(vec![("ball", ball())])),
            item("rlv_ball_roll", "Mutating. Rolls it. Fails uphill.", call(vec![("ball", ball())])),
            item("rlv_ball_list", "Lists. Fails.", call(vec![("out", Type::Pointer(Box::new(handle(true)), false))])),
        ];
        let noun = Noun { name: "ball".into(), about: "Relievo: balls.\nMore.".into(), items };
        let (pages, faults) = pages(&Abi { nouns: vec![noun] });
        assert_eq!(
            faults,
            [
                "ball.h:3: RlvBallInfo: the unit or range of float radius",
                "ball.h:3: rlv_ball_create: what it fails at",
                "ball.h:3: rlv_ball_list: how long what it points to lives"
            ]
        );
        let [(name, page), (_, index)] = pages.as_slice() else { panic!() };
        assert!(name == "ball.md" && index.contains("- [ball](ball.md): balls.\n"), "{index}");
        assert!(
            page.starts_with(
                "# ball\n\nballs.\nMore.\n\n## RLV_BALL_GROUND\n\nThe floor.\n\n    #define RLV_BALL_GROUND 0\n"
            ),
            "{page}"
        );
        assert!(page.contains("| `float low` |  | metres \\| feet |"), "{page}");
        assert!(page.contains("gives one reference to RlvBall") && page.contains("needs it alone"), "{page}");
    }
}
