//! Swizzles of scalars, which GLSL has had since 4.20 and the front end lacks: they become vectors of one value.

use crate::edit::Edit;
use crate::fault::Span;
use crate::lexer::{Kind, Token};

/// Returns the edits that turn the swizzle at `field`, `.rrr`, into a constructor around its operand; `None` where the field is
/// no swizzle of a scalar or its operand is no name, call or bracket.
pub(crate) fn widen(text: &str, tokens: &[Token], field: &Span) -> Option<[Edit; 2]> {
    let names = text.get(field.clone())?.strip_prefix('.')?.trim();
    let kind = ["float", "vec2", "vec3", "vec4"].get(names.len().checked_sub(1)?)?;
    if !names.chars().all(|name| matches!(name, 'x' | 'r' | 's')) {
        return None;
    }
    let is_code = |token: &&Token| !token.is_comment() && token.kind != Kind::Directive;
    let code: Vec<&Token> = tokens.iter().filter(is_code).collect();
    let dot = code.iter().position(|token| token.span.start == field.start)?;
    let start = operand(text, &code[..dot])?;
    Some([Edit::insert(start, format!("{kind}(")), Edit::replace(field.clone(), ")")])
}

/// Returns the byte at which the operand begins that a list of tokens ends with: names, calls and indices with dots between.
fn operand(text: &str, code: &[&Token]) -> Option<usize> {
    let word = |at: usize| code.get(at).map_or("", |token| token.text(text));
    let mut at = code.len().checked_sub(1)?;
    loop {
        while matches!(word(at), ")" | "]") {
            let mut depth = 0_usize;
            loop {
                match word(at) {
                    ")" | "]" => depth += 1,
                    "(" | "[" => depth -= 1,
                    _ => {}
                }
                if depth == 0 {
                    break;
                }
                at = at.checked_sub(1)?;
            }
            // What is called or indexed stands before the bracket.
            let is_called = at > 0 && (code[at - 1].kind == Kind::Word || matches!(word(at - 1), ")" | "]"));
            if !is_called {
                return Some(code[at].span.start);
            }
            at -= 1;
        }
        if code[at].kind == Kind::Symbol {
            return None;
        }
        match at >= 2 && word(at - 1) == "." {
            true => at -= 2,
            false => return Some(code[at].span.start),
        }
    }
}
