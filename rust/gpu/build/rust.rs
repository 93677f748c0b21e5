//! The structs in Rust.

use std::fmt::Write as _;

use super::layout::{Layout, Modules};

/// Returns a Rust module for each WGSL module with structs that hosts share, with a struct of the same name and fields for
/// each. What WGSL leaves free between fields and at the end are fields `padding`, `padding_2`, …
///
/// # Errors
/// Names the file and line of what hosts cannot share.
pub fn write(modules: &Modules) -> Result<String, String> {
    let shared = modules.shared()?;
    let mut text = String::new();
    for of_module in shared.chunk_by(|(a, _), (b, _)| a.name == b.name) {
        let Some((module, _)) = of_module.first() else { continue };
        let _ = writeln!(text, "/// Structs of `shaders/{}`.\npub mod {} {{", module.file, module.name);
        for (_, found) in of_module {
            comment(&mut text, &found.comment);
            declare(&mut text, &found.name, &modules.layout(module, found)?);
        }
        text.push_str("}\n");
    }
    Ok(text)
}

fn comment(text: &mut String, lines: &[String]) {
    for line in lines {
        let _ = writeln!(text, "/// {line}");
    }
}

fn declare(text: &mut String, name: &str, layout: &Layout) {
    let mut fields = String::new();
    let mut checks = format!("size_of::<{name}>() == {}", layout.size);
    let (mut end, mut paddings) = (0, 0);
    let mut pad = |fields: &mut String, bytes: u32| {
        if bytes > 0 {
            paddings += 1;
            let number = if paddings == 1 { String::new() } else { format!("_{paddings}") };
            let words = if bytes == 4 { "u32".to_owned() } else { format!("[u32; {}]", bytes / 4) };
            let _ = writeln!(fields, "/// Not read.\npub padding{number}: {words},");
        }
    };
    for field in &layout.fields {
        pad(&mut fields, field.offset - end);
        comment(&mut fields, &field.comment);
        let _ = writeln!(fields, "pub {}: {},", field.name, field.rust);
        let _ = write!(checks, " && std::mem::offset_of!({name}, {}) == {}", field.name, field.offset);
        end = field.offset + field.size;
    }
    pad(&mut fields, layout.size - end);
    // A struct in another may hold an f32.
    let is_whole =
        layout.fields.iter().all(|field| !field.rust.contains("f32") && !field.rust.contains(char::is_uppercase));
    let more = if is_whole { ", Eq, Hash" } else { "" };
    let _ = writeln!(
        text,
        "#[repr(C)]\n#[derive(Clone, Copy, Debug, PartialEq{more}, bytemuck::Pod, bytemuck::Zeroable)]\n\
         pub struct {name} {{\n{fields}}}\nimpl Default for {name} {{ fn default() -> Self {{ bytemuck::Zeroable::zeroed() }} }}\n\
         const _: () = assert!({checks});"
    );
}
