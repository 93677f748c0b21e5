//! Combined samplers as parameters of functions: each becomes a texture and a sampler, in the function and where it is called.

use std::collections::BTreeMap;

use super::{SAMPLER, SAMPLERS, TEXTURE};
use crate::edit::Edit;
use crate::fault::Span;
use crate::lexer::{Kind, Token};
use crate::outline::Outline;

/// A parameter that is a combined sampler.
struct Parameter<'a> {
    name: &'a str,
    kind: &'static str,
    texture: &'static str,
    sampler: &'static str,
    /// Its place among the parameters, from 0.
    index: usize,
    /// The declaration.
    span: Span,
}

/// Returns the edits that split combined samplers which are parameters of functions with a body.
///
/// Arguments other than a single name are left alone, and then refused by the front end.
pub(super) fn split(text: &str, tokens: &[Token], outline: &Outline) -> Vec<Edit> {
    let code: Vec<&Token> =
        tokens.iter().filter(|token| !token.is_comment() && token.kind != Kind::Directive).collect();
    let within = |span: &Span| {
        let start = code.partition_point(|token| token.span.start < span.start);
        start..code.partition_point(|token| token.span.start < span.end)
    };
    let mut functions: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    let mut bodies = Vec::new();
    for function in &outline.functions {
        let found = parameters(text, &code[within(&function.parameters)]);
        if !found.is_empty() {
            functions.insert(&function.name, found.iter().map(|parameter| parameter.index).collect());
            bodies.push((within(&function.body), found));
        }
    }
    let pair = |name: &str| format!("{TEXTURE}{name}, {SAMPLER}{name}");
    let mut edits = BTreeMap::new();
    for (body, parameters) in &bodies {
        for Parameter { name, kind, texture, sampler, span, .. } in parameters {
            let declared = format!("{texture} {TEXTURE}{name}, {sampler} {SAMPLER}{name}");
            edits.insert(span.start, Edit::replace(span.clone(), declared));
            for token in code[body.clone()].iter().filter(|token| token.text(text) == *name) {
                edits.insert(token.span.start, Edit::replace(token.span.clone(), format!("{kind}({})", pair(name))));
            }
        }
    }
    for (at, token) in code.iter().enumerate() {
        let Some(indices) = functions.get(token.text(text)) else { continue };
        for argument in arguments(text, &code, at + 1).into_iter().enumerate() {
            if let (index, [argument]) = argument
                && indices.contains(&index)
                && argument.kind == Kind::Word
            {
                let replaced = Edit::replace(argument.span.clone(), pair(argument.text(text)));
                edits.insert(argument.span.start, replaced);
            }
        }
    }
    edits.into_values().collect()
}

/// Returns the parameters of a list that are combined samplers.
fn parameters<'a>(text: &'a str, list: &[&Token]) -> Vec<Parameter<'a>> {
    let parts = list.split(|token| matches!(token.text(text), "(" | "," | ")"));
    let mut found = Vec::new();
    // The first part is empty: it stands before the bracket.
    for (index, part) in parts.skip(1).enumerate() {
        let at = part.iter().position(|token| SAMPLERS.iter().any(|(name, ..)| *name == token.text(text)));
        if let Some(at) = at
            && let (Some(first), [name]) = (part.first(), &part[at + 1..])
            && let Some((kind, texture, sampler)) = SAMPLERS.iter().find(|(kind, ..)| *kind == part[at].text(text))
        {
            let span = first.span.start..name.span.end;
            found.push(Parameter { name: name.text(text), kind, texture, sampler, index, span });
        }
    }
    found
}

/// Returns the tokens of each argument of a call whose opening bracket is at `open`; none if there is no bracket.
fn arguments<'a, 'b>(text: &str, code: &'b [&'a Token], open: usize) -> Vec<&'b [&'a Token]> {
    let mut found = Vec::new();
    if code.get(open).is_none_or(|token| token.text(text) != "(") {
        return found;
    }
    let (mut depth, mut start) = (0_usize, open + 1);
    // A call longer than a statement may be is none.
    for at in open..code.len().min(open + 4096) {
        match code[at].text(text) {
            "(" | "[" | "{" => depth += 1,
            "," if depth == 1 => {
                found.push(&code[start..at]);
                start = at + 1;
            }
            ")" | "]" | "}" if depth <= 1 => {
                found.push(&code[start..at]);
                return found;
            }
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
    }
    Vec::new()
}
