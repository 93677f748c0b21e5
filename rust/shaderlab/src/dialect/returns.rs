//! Functions that return in every branch, at whose end the front end demands a return all the same.

use crate::edit::Edit;
use crate::lexer::{Kind, Token};
use crate::outline::Outline;

/// Types that are constructed of one number.
const TYPES: [&str; 14] = [
    "float", "int", "uint", "bool", "vec2", "vec3", "vec4", "ivec2", "ivec3", "ivec4", "mat2", "mat3", "mat4", "uvec2",
];

/// Returns the edits that end functions with a return which is never reached.
pub(super) fn complete(text: &str, tokens: &[Token], outline: &Outline) -> Vec<Edit> {
    let is_code = |token: &&Token| !token.is_comment() && token.kind != Kind::Directive;
    let code: Vec<&Token> = tokens.iter().filter(is_code).collect();
    let mut edits = Vec::new();
    for function in &outline.functions {
        let head = code.partition_point(|token| token.span.start < function.parameters.start);
        let end = code.partition_point(|token| token.span.end < function.body.end);
        let Some(kind) = head.checked_sub(2).and_then(|at| code.get(at)).map(|token| token.text(text)) else {
            continue;
        };
        // Behind a block the end may be reached, as far as the front end knows.
        let ends_with_block = end.checked_sub(1).is_some_and(|at| code[at].text(text) == "}");
        let returns_early = ends_with_block || ends_with_branch(text, &code[head.min(end)..end]);
        if let (true, Some(close)) = (TYPES.contains(&kind) && returns_early, code.get(end)) {
            edits.push(Edit::insert(close.span.start, format!("return {kind}(0); ")));
        }
    }
    edits
}

/// Returns whether the last statement of a function is the branch of an `if` or an `else` without braces.
fn ends_with_branch(text: &str, code: &[&Token]) -> bool {
    let last = code.iter().rev().skip(1).position(|token| matches!(token.text(text), ";" | "{" | "}"));
    let start = last.map_or(0, |behind| code.len() - 1 - behind);
    code.get(start).is_some_and(|token| matches!(token.text(text), "if" | "else"))
}
