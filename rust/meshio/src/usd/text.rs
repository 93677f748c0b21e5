//! Bounds of a layer in text before it is parsed: how deep blocks nest, and what its paths and values will take.
//!
//! The parser calls itself for every level of blocks, and keeps the whole path of every prim and property, so that a
//! small file can ask for any amount of either.

use logos::Logos;
use openusd::usda::token::Token;
use relievo_core::{Error, Result};

use crate::budget::Budget;
use crate::text::at_line;

/// Most blocks that may be inside one another.
const DEPTH: usize = 128;
/// Bytes counted for a number, which may be a double of a list that grows.
const NUMBER: u64 = 24;
/// Bytes counted for any other word besides its letters: a prim, a property or an entry of one.
const WORD: u64 = 160;

/// Fails if blocks nest deeper than [`DEPTH`], or what the parser makes of the text needs more than the budget has.
pub(crate) fn bound(text: &str, budget: &mut Budget) -> Result<()> {
    let mut blocks: Vec<usize> = Vec::new();
    // Bytes of the path inside the current block, and of the name that the next one adds to it.
    let (mut path, mut name) = (0, 0);
    let mut naming = false;
    let mut last = None;
    for (token, span) in Token::lexer(text).spanned() {
        let line = || 1 + text.as_bytes()[..span.start].iter().filter(|byte| **byte == b'\n').count() as u64;
        let Ok(token) = token else {
            return Err(at_line(Error::invalid("the text is not understood"), line()).advise("export the file again"));
        };
        let string = last.take();
        match token {
            Token::Punctuation('{' | '(' | '[') => {
                if blocks.len() == DEPTH {
                    return Err(at_line(Error::unsupported(format!("more than {DEPTH} blocks are nested")), line())
                        .advise("flatten the stage"));
                }
                name = name.max(string.unwrap_or(0));
                blocks.push(path);
                if text.as_bytes().get(span.start) == Some(&b'{') {
                    path += name + 1;
                    name = 0;
                }
            }
            Token::Punctuation('}' | ')' | ']') => path = blocks.pop().unwrap_or(0),
            Token::Punctuation(_) => {}
            Token::Number(_) => budget.charge(NUMBER)?,
            Token::Def | Token::Over | Token::Class | Token::VariantSet => {
                naming = true;
                budget.charge(WORD + path as u64)?;
            }
            Token::String(letters) => {
                if std::mem::take(&mut naming) {
                    name = letters.len();
                }
                last = Some(letters.len());
                budget.charge(WORD + (path + letters.len()) as u64)?;
            }
            _ => budget.charge(WORD + (path + span.len()) as u64)?,
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bound(text: &str) -> Result<()> {
        super::bound(text, &mut Budget::new(1 << 24))
    }

    #[test]
    fn nesting_is_bounded_whatever_strings_and_comments_hold() {
        let nest = |count: usize| format!("#usda 1.0\n{}{}", "def \"a\" { ".repeat(count), "}".repeat(count));
        assert_eq!(bound(&nest(DEPTH)), Ok(()));
        assert!(bound(&nest(DEPTH + 1)).unwrap_err().what.contains("nested"));
        let hidden = "def \"a\" { string b = \"}\" # }\n".repeat(DEPTH + 1);
        assert!(bound(&format!("#usda 1.0\n{hidden}")).unwrap_err().what.contains("nested"));
        assert!(bound(&format!("#usda 1.0\n(a = {}", "[".repeat(DEPTH + 1))).is_err());
    }

    #[test]
    fn long_names_above_many_prims_are_counted() {
        let text = |length: usize| {
            format!(
                "#usda 1.0\ndef \"{}\" (\n    doc = \"x\"\n) {{ {} }}",
                "a".repeat(length),
                "def \"b\" {} ".repeat(1000)
            )
        };
        assert_eq!(bound(&text(100)), Ok(()));
        assert_eq!(bound(&text(100_000)).unwrap_err().kind, relievo_core::ErrorKind::Memory);
    }
}
