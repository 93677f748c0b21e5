//! Arrays without a stated size, which the front end takes for arrays of the host: their size is that of their constructor.

use crate::edit::Edit;
use crate::lexer::{Kind, Token};

/// Returns the edits that write sizes into empty brackets, in each statement with one constructor of an array.
pub(super) fn size(text: &str, tokens: &[Token]) -> Vec<Edit> {
    let is_code = |token: &&Token| !token.is_comment() && token.kind != Kind::Directive;
    let code: Vec<&Token> = tokens.iter().filter(is_code).collect();
    let word = |at: usize| code.get(at).map_or("", |token| token.text(text));
    let mut edits = Vec::new();
    // The places of empty brackets in the statement so far, and the size of its constructor.
    let (mut empty, mut size) = (Vec::new(), None);
    for at in 0..code.len() {
        match word(at) {
            "[" => {
                let end = if word(at + 1) == "]" { at + 1 } else { at + 2 };
                if end == at + 1 {
                    empty.push(code[at].span.end);
                }
                if [word(end), word(end + 1)] == ["]", "("] {
                    size = count(&code[end + 1..], text);
                }
            }
            ";" | "{" | "}" => {
                if let Some(size) = size.take() {
                    edits.extend(empty.iter().map(|place| Edit::insert(*place, format!("{size}"))));
                }
                empty.clear();
            }
            _ => {}
        }
    }
    edits
}

/// Returns how many arguments stand in the brackets that a list of tokens begins with.
fn count(code: &[&Token], text: &str) -> Option<usize> {
    let (mut depth, mut commas) = (0_usize, 0);
    for token in code {
        match token.text(text) {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" if depth <= 1 => return Some(commas + 1),
            ")" | "]" | "}" => depth -= 1,
            "," if depth == 1 => commas += 1,
            _ => {}
        }
    }
    None
}
