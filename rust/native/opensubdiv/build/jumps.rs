//! What the C++ side refers to in the copy: a jump through a table for every function, and room for every object, both
//! filled when the copy is opened (`src/library.rs`).

use std::collections::BTreeSet;
use std::fmt::Write as _;

use object::read::archive::ArchiveFile;
use object::{Object, ObjectSymbol, SymbolKind};

use crate::copy::MANGLED;

/// A symbol of the copy.
pub struct Symbol {
    name: String,
    /// The size of an object in bytes; functions have none.
    object: Option<u64>,
}

/// The symbols of the copy that the objects in an archive refer to.
pub fn needed(archive: &[u8], copy: &[u8]) -> Result<Vec<Symbol>, String> {
    let failed = |error: object::Error| error.to_string();
    let (mut wanted, mut defined) = (BTreeSet::new(), BTreeSet::new());
    for member in ArchiveFile::parse(archive).map_err(failed)?.members() {
        let data = member.and_then(|member| member.data(archive)).map_err(failed)?;
        for symbol in object::File::parse(data).map_err(failed)?.symbols() {
            let name = symbol.name().map_err(failed)?.to_owned();
            if name.contains(MANGLED[1]) {
                if symbol.is_undefined() {
                    wanted.insert(name)
                } else {
                    defined.insert(name)
                };
            }
        }
    }
    let copy = object::File::parse(copy).map_err(failed)?;
    let find = |name: &String| -> Result<Symbol, String> {
        let found = copy.dynamic_symbols().find(|symbol| symbol.is_definition() && symbol.name() == Ok(name.as_str()));
        let found = found.ok_or_else(|| format!("it lacks {name}"))?;
        let object = (found.kind() == SymbolKind::Data).then(|| found.size());
        Ok(Symbol { name: name.clone(), object })
    };
    wanted.difference(&defined).map(find).collect()
}

/// The names of functions, and names and sizes of objects, in Rust.
pub fn list(symbols: &[Symbol]) -> String {
    let (mut functions, mut objects) = (String::new(), String::new());
    let (mut function_count, mut object_count) = (0, 0);
    for Symbol { name, object } in symbols {
        match object {
            None => {
                function_count += 1;
                let _ = writeln!(functions, "    c\"{name}\",");
            }
            Some(size) => {
                object_count += 1;
                let _ = writeln!(objects, "        (c\"{name}\", {size}, &raw mut {name}),");
            }
        }
    }
    let mut declared = String::new();
    for Symbol { name, .. } in symbols.iter().filter(|symbol| symbol.object.is_some()) {
        let _ = writeln!(declared, "    static mut {name}: u8;");
    }
    format!(
        "const FUNCTIONS: [&CStr; {function_count}] = [\n{functions}];\n\
         unsafe extern \"C\" {{\n    static mut relievo_opensubdiv_functions: [*mut c_void; {function_count}];\n{declared}}}\n\
         fn objects() -> [(&'static CStr, usize, *mut u8); {object_count}] {{\n    [\n{objects}    ]\n}}\n"
    )
}

/// The jumps and the rooms. Their names are hidden, so that a call from our own objects needs no look-up.
pub fn assembly(symbols: &[Symbol]) -> Result<String, String> {
    let jump: fn(usize) -> String = match std::env::var("CARGO_CFG_TARGET_ARCH").as_deref() {
        Ok("x86_64") => |number| format!("endbr64\njmpq *relievo_opensubdiv_functions+8*{number}(%rip)"),
        Ok("aarch64") => |number| {
            let place = format!("relievo_opensubdiv_functions+8*{number}");
            format!("hint #34\nadrp x16, {place}\nldr x16, [x16, :lo12:{place}]\nbr x16")
        },
        _ => return Err("jumps are written for x86-64 and AArch64 alone".into()),
    };
    let mut text = String::from(".section .note.GNU-stack,\"\",%progbits\n.text\n");
    let functions = symbols.iter().filter(|symbol| symbol.object.is_none());
    let mut count = 0;
    for Symbol { name, .. } in functions {
        let code = jump(count);
        let _ = writeln!(text, ".balign 16\n.globl {name}\n.hidden {name}\n.type {name}, %function\n{name}:\n{code}");
        let _ = writeln!(text, ".size {name}, .-{name}");
        count += 1;
    }
    text.push_str(".bss\n");
    let table = ("relievo_opensubdiv_functions", 8 * count as u64);
    let objects = symbols.iter().filter_map(|symbol| symbol.object.map(|size| (symbol.name.as_str(), size)));
    for (name, size) in std::iter::once(table).chain(objects) {
        let _ =
            writeln!(text, ".balign 32\n.globl {name}\n.hidden {name}\n.type {name}, %object\n{name}:\n.skip {size}");
        let _ = writeln!(text, ".size {name}, {size}");
    }
    Ok(text)
}
