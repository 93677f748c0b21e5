//! Offsets of the members of blocks, which the front end cannot read: members that fill the gaps take their place.

use crate::edit::Edit;
use crate::lexer::{Kind, Token};

/// Types with their size and alignment in bytes, in both layouts of blocks.
const SIZES: [(&str, u32, u32); 16] = [
    ("float", 4, 4),
    ("int", 4, 4),
    ("uint", 4, 4),
    ("bool", 4, 4),
    ("vec2", 8, 8),
    ("ivec2", 8, 8),
    ("uvec2", 8, 8),
    ("vec3", 12, 16),
    ("ivec3", 12, 16),
    ("uvec3", 12, 16),
    ("vec4", 16, 16),
    ("ivec4", 16, 16),
    ("uvec4", 16, 16),
    ("mat3", 48, 16),
    ("mat4", 64, 16),
    ("mat4x4", 64, 16),
];

/// Returns the edits that replace `layout(offset = N)` of members.
///
/// Members behind one whose size is unknown keep theirs, and are then refused by the front end.
pub(super) fn fill(text: &str, tokens: &[Token]) -> Vec<Edit> {
    let is_code = |token: &&Token| !token.is_comment() && token.kind != Kind::Directive;
    let code: Vec<&Token> = tokens.iter().filter(is_code).collect();
    let word = |at: usize| code.get(at).map_or("", |token| token.text(text));
    let (mut edits, mut gaps) = (Vec::new(), 0);
    let mut end = Some(0_u32);
    let mut start = 0;
    for at in 0..code.len() {
        match word(at) {
            "{" => (start, end) = (at + 1, Some(0)),
            ";" => {
                let stated = match [start, start + 1, start + 2, start + 3, start + 5].map(word) {
                    ["layout", "(", "offset", "=", ")"] => word(start + 4).parse::<u32>().ok(),
                    _ => None,
                };
                let kind = if stated.is_some() { start + 6 } else { start };
                let is_plain = word(kind + 2) == ";";
                let known = SIZES.iter().find(|(name, ..)| is_plain && *name == word(kind));
                end = match (end, known, stated) {
                    (Some(end), Some((_, size, alignment)), Some(offset))
                        if end <= offset && offset % alignment == 0 =>
                    {
                        let span = code[start].span.start..code[start + 5].span.end;
                        edits.push(Edit::replace(span, gap(end, offset, &mut gaps)));
                        offset.checked_add(*size)
                    }
                    (Some(end), Some((_, size, alignment)), None) => {
                        end.checked_next_multiple_of(*alignment).and_then(|start| start.checked_add(*size))
                    }
                    _ => None,
                };
                start = at + 1;
            }
            "}" => start = at + 1,
            _ => {}
        }
    }
    edits
}

/// Returns members that fill the bytes from `start` to `end`, both multiples of four.
fn gap(start: u32, end: u32, count: &mut u32) -> String {
    let mut out = String::new();
    let mut at = start;
    while at + 4 <= end {
        let wide = (end - at) / 16;
        if at.is_multiple_of(16) && wide > 0 {
            out.push_str(&format!("vec4 pel_gap{count}[{wide}]; "));
            at += 16 * wide;
        } else {
            out.push_str(&format!("float pel_gap{count}; "));
            at += 4;
        }
        *count += 1;
    }
    out
}
