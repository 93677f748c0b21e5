//! The parameter exploration language: annotations in comments that begin with a dot (Section 4.1).
//!
//! ```text
//! comment      = "//" annotation | "/*" annotation "*/"
//! annotation   = "." ( vector | accumulation | name | desc | code )
//! vector       = "vector" feature { ";" feature } ";" weight [ ";" ]
//! feature      = expression of the shading language that yields a float
//! weight       = expression of the shading language that yields a float
//! accumulation = "accumulation" ( "average" | "weighted average" | "sum" | "min" | "max" | "first" | "last" )
//! name         = "name" text
//! desc         = "desc" text
//! code         = code of the shading language with the word "confidence"
//! ```
//!
//! White space may follow the dot. A comment that begins with two dots is an ordinary comment.

use relievo_core::error::nearest;

use crate::accumulation::Accumulation;
use crate::fault::{Checked, Fault, Span};
use crate::lexer::{Kind, Token, tokens};
use crate::source::Language;

/// Features that a vector may have.
pub const MAX_FEATURES: usize = 64;

/// The word that stands for the membership of the vector taken last.
pub(crate) const CONFIDENCE: &str = "confidence";

/// Words that begin an annotation.
const KEYWORDS: [&str; 4] = ["vector", "accumulation", "name", "desc"];

/// What an annotation says. Spans are bytes of the user's text.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Meaning {
    /// Take a vector.
    Vector { features: Vec<Span>, weight: Span },
    /// Accumulate in this way.
    Accumulation(Accumulation),
    /// Call the next variable by this name.
    Name(String),
    /// Describe the next variable.
    Description(String),
    /// Insert this code; `confidence` has the places of the word.
    Code { code: Span, confidence: Vec<Span> },
}

/// An annotation.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Annotation {
    pub meaning: Meaning,
    /// The whole comment.
    pub span: Span,
    /// The index of its token.
    pub token: usize,
}

/// Returns the annotations of a text with all their faults.
pub(crate) fn annotations(text: &str, language: Language, tokens: &[Token]) -> Checked<Vec<Annotation>> {
    let (mut found, mut faults) = (Vec::new(), Vec::new());
    for (index, token) in tokens.iter().enumerate() {
        let Some(inner) = inner(text, token) else { continue };
        match meaning(text, language, inner) {
            Ok(meaning) => found.push(Annotation { meaning, span: token.span.clone(), token: index }),
            Err(fault) => faults.push(fault),
        }
    }
    if faults.is_empty() { Ok(found) } else { Err(faults) }
}

/// Returns the bytes of an annotation behind its dot, or `None` for an ordinary comment.
fn inner(text: &str, token: &Token) -> Option<Span> {
    let Span { start, end } = token.span;
    let end = match token.kind {
        Kind::LineComment => end,
        Kind::BlockComment => end - 2,
        _ => return None,
    };
    let inside = text.get(start + 2..end)?;
    (inside.starts_with('.') && !inside[1..].starts_with('.')).then_some(start + 3..end)
}

/// Returns a span without the white space at its ends.
fn trimmed(text: &str, span: Span) -> Span {
    let inside = &text[span.clone()];
    let start = span.start + (inside.len() - inside.trim_start().len());
    start..start + inside.trim().len()
}

fn meaning(text: &str, language: Language, inner: Span) -> Result<Meaning, Fault> {
    let whole = trimmed(text, inner);
    let inside = &text[whole.clone()];
    let length = inside.find(|it: char| !it.is_alphanumeric() && it != '_').unwrap_or(inside.len());
    let word = &inside[..length];
    let after = trimmed(text, whole.start + length..whole.end);
    let prose = || match text[after.clone()].trim() {
        "" => Err(Fault::new(whole.clone(), format!("nothing follows `{word}`")).advise("write the text behind it")),
        prose => Ok(prose.split_whitespace().collect::<Vec<_>>().join(" ")),
    };
    match word {
        "vector" => vector(text, language, &whole, after),
        "accumulation" => {
            let found = Accumulation::by_name(&prose()?);
            Ok(Meaning::Accumulation(found.map_err(|error| Fault::new(after, error.what).advise(error.remedy))?))
        }
        "name" => Ok(Meaning::Name(prose()?)),
        "desc" => Ok(Meaning::Description(prose()?)),
        _ => code(text, language, whole.clone(), word),
    }
}

/// Returns the tokens of a part of the text, checked to be code that may be inserted.
fn inserted(text: &str, language: Language, part: &Span) -> Result<Vec<Token>, Fault> {
    let moved = |span: Span| span.start + part.start..span.end + part.start;
    let found = tokens(&text[part.clone()], language).map_err(|faults| match faults.into_iter().next() {
        Some(fault) => Fault { span: moved(fault.span.clone()), ..fault },
        None => Fault::new(part.clone(), "the annotation cannot be read"),
    })?;
    let mut found: Vec<_> = found.into_iter().map(|it| Token { span: moved(it.span.clone()), ..it }).collect();
    if found.last().is_some_and(|token| token.kind == Kind::LineComment) {
        found.pop();
    }
    let mut open: Vec<&Token> = Vec::new();
    for token in &found {
        let it = token.text(text);
        if matches!(token.kind, Kind::LineComment | Kind::Directive) || matches!(it, "#" | "\\" | "@") {
            return Err(Fault::new(token.span.clone(), format!("`{it}` cannot stand in an annotation")));
        }
        match it {
            "(" | "[" | "{" => open.push(token),
            ")" | "]" | "}" => {
                let pair = open.pop().map(|token| token.text(text));
                if !matches!((pair, it), (Some("("), ")") | (Some("["), "]") | (Some("{"), "}")) {
                    return Err(Fault::new(token.span.clone(), format!("`{it}` closes nothing in this annotation")));
                }
            }
            _ => {}
        }
    }
    match open.pop() {
        None => Ok(found),
        Some(token) => {
            let what = format!("`{}` is not closed in this annotation", token.text(text));
            Err(Fault::new(token.span.clone(), what))
        }
    }
}

fn vector(text: &str, language: Language, whole: &Span, list: Span) -> Result<Meaning, Fault> {
    const EXAMPLE: &str = "write the features and the weight with semicolons between them: //. vector a; b; 1.0";
    let tokens = inserted(text, language, &list)?;
    let mut parts: Vec<Option<Span>> = vec![None];
    let mut depth = 0_usize;
    for token in tokens.iter().filter(|token| !token.is_comment()) {
        let it = token.text(text);
        match it {
            ";" if depth == 0 => {
                parts.push(None);
                continue;
            }
            "(" | "[" => depth += 1,
            ")" | "]" => depth = depth.saturating_sub(1),
            "=" | "+=" | "-=" | "*=" | "/=" | "%=" | "&=" | "|=" | "^=" | "<<=" | ">>=" | "++" | "--" => {
                let fault = Fault::new(token.span.clone(), "a feature cannot change a variable");
                return Err(fault.advise("take the value of an expression that changes nothing"));
            }
            ";" | "{" | "}" => {
                return Err(Fault::new(token.span.clone(), format!("`{it}` is no part of an expression")));
            }
            _ => {}
        }
        if let Some(part) = parts.last_mut() {
            let start = part.as_ref().map_or(token.span.start, |part| part.start);
            *part = Some(start..token.span.end);
        }
    }
    if parts.len() > 1 && parts.last().is_some_and(Option::is_none) {
        parts.pop();
    }
    let mut features = Vec::with_capacity(parts.len());
    for part in parts {
        features.push(part.ok_or_else(|| Fault::new(whole.clone(), "an expression is missing").advise(EXAMPLE))?);
    }
    match features.pop() {
        Some(weight) if (1..=MAX_FEATURES).contains(&features.len()) => Ok(Meaning::Vector { features, weight }),
        Some(_) if !features.is_empty() => {
            let what = format!("the vector has {} features, more than {MAX_FEATURES}", features.len());
            Err(Fault::new(whole.clone(), what).advise("take fewer"))
        }
        _ => Err(Fault::new(whole.clone(), "a vector needs a feature and a weight").advise(EXAMPLE)),
    }
}

fn code(text: &str, language: Language, whole: Span, word: &str) -> Result<Meaning, Fault> {
    let tokens = inserted(text, language, &whole)?;
    let is_word = |token: &&Token| token.kind == Kind::Word && token.text(text) == CONFIDENCE;
    let confidence: Vec<_> = tokens.iter().filter(is_word).map(|token| token.span.clone()).collect();
    match (tokens.first(), tokens.last()) {
        (Some(first), Some(last)) if !confidence.is_empty() => {
            Ok(Meaning::Code { code: first.span.start..last.span.end, confidence })
        }
        _ => {
            let advice = match nearest(word, KEYWORDS.into_iter().chain([CONFIDENCE])).filter(|_| !word.is_empty()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => "use vector, accumulation, name, desc, or code with the word confidence".to_owned(),
            };
            Err(Fault::new(whole, "the annotation has no known word").advise(advice))
        }
    }
}
