//! Tokens of GLSL and WGSL with their bytes.
//!
//! The lexer exists for comments, which every front end drops, and for the few facts about brackets and declarations that
//! the augmentation needs. It accepts every text but one with an open block comment, or one that is nested or long enough
//! to exhaust the stack of a recursive parser.

use crate::fault::{Checked, Fault, Span};
use crate::source::{Language, MAX_BYTES};

/// The kind of a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A name or a keyword.
    Word,
    /// A number.
    Number,
    /// An operator or a bracket.
    Symbol,
    /// A comment up to the end of its line.
    LineComment,
    /// A comment between `/*` and `*/`.
    BlockComment,
    /// A line of the preprocessor with its comments.
    Directive,
}

/// A token.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Token {
    pub kind: Kind,
    pub span: Span,
}

impl Token {
    /// Returns the text of the token.
    pub fn text<'a>(&self, text: &'a str) -> &'a str {
        &text[self.span.clone()]
    }

    /// Returns whether the token is a comment.
    pub fn is_comment(&self) -> bool {
        matches!(self.kind, Kind::LineComment | Kind::BlockComment)
    }
}

/// Operators of two and three characters, the longest first.
const OPERATORS: [&str; 21] = [
    "<<=", ">>=", "==", "!=", "<=", ">=", "->", "++", "--", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "&&", "||",
    "<<", "^^",
];

/// Deepest nesting of brackets.
const MAX_NESTING: usize = 200;

/// Most tokens between two of `;`, `{` and `}`.
const MAX_STATEMENT: usize = 4096;

/// Most words `else`, each of which a parser may nest in the one before.
const MAX_ELSE: usize = 2000;

/// Returns the tokens of a text in order.
pub(crate) fn tokens(text: &str, language: Language) -> Checked<Vec<Token>> {
    if text.len() > MAX_BYTES {
        let fault = Fault::new(0..0, format!("the shader has more than {MAX_BYTES} bytes"));
        return Err(vec![fault.advise("split it, or remove what is not used")]);
    }
    let mut lexer = Lexer { text, language, at: 0, starts_line: true };
    let mut found = Vec::new();
    while let Some(token) = lexer.next().map_err(|fault| vec![fault])? {
        found.push(token);
    }
    check_depth(text, &found).map_err(|fault| vec![fault])?;
    Ok(found)
}

struct Lexer<'a> {
    text: &'a str,
    language: Language,
    at: usize,
    /// Whether only white space precedes on this line.
    starts_line: bool,
}

/// Returns whether a character ends a line.
fn is_break(language: Language, it: char) -> bool {
    match language {
        Language::Glsl => matches!(it, '\n' | '\r'),
        Language::Wgsl => matches!(it, '\n' | '\r' | '\x0b' | '\x0c' | '\u{85}' | '\u{2028}' | '\u{2029}'),
    }
}

impl Lexer<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    /// Returns the next token, or `None` at the end.
    fn next(&mut self) -> Result<Option<Token>, Fault> {
        loop {
            let Some(first) = self.rest().chars().next() else { return Ok(None) };
            if first == ' ' {
                self.at += 1;
                continue;
            }
            if is_break(self.language, first) {
                self.starts_line = true;
            } else if !first.is_whitespace() && first != '\u{feff}' {
                break;
            }
            self.at += first.len_utf8();
        }
        let start = self.at;
        let kind = if self.rest().starts_with("//") {
            self.at = self.line_end(start);
            Kind::LineComment
        } else if self.rest().starts_with("/*") {
            self.at = self.block_end(start)?;
            Kind::BlockComment
        } else if self.language == Language::Glsl && self.starts_line && self.rest().starts_with('#') {
            self.at = self.directive_end(start)?;
            Kind::Directive
        } else {
            self.plain()
        };
        // A block comment leaves a line as it was: a directive may follow it.
        if kind != Kind::BlockComment {
            self.starts_line = false;
        }
        Ok(Some(Token { kind, span: start..self.at }))
    }

    /// Takes a word, a number or an operator.
    fn plain(&mut self) -> Kind {
        let rest = self.rest();
        let is_part = |it: char| it.is_ascii_alphanumeric() || it == '_' || (!it.is_ascii() && it.is_alphanumeric());
        let first = rest.chars().next().unwrap_or(' ');
        let second = rest[first.len_utf8()..].chars().next();
        let (kind, length) = if first.is_ascii_digit() || (first == '.' && second.is_some_and(|it| it.is_ascii_digit()))
        {
            let mut previous = ' ';
            let is_hexadecimal = rest.starts_with("0x") || rest.starts_with("0X");
            let length = rest.find(|it: char| {
                let is_exponent = match is_hexadecimal {
                    true => matches!(previous, 'p' | 'P'),
                    false => matches!(previous, 'e' | 'E'),
                };
                let goes_on = is_part(it) || it == '.' || (matches!(it, '+' | '-') && is_exponent);
                previous = it;
                !goes_on
            });
            (Kind::Number, length.unwrap_or(rest.len()))
        } else if is_part(first) {
            (Kind::Word, word_end(rest, is_part))
        } else {
            // Most symbols are followed by what ends no operator.
            let may_go_on = second.is_some_and(|it| matches!(it, '<' | '>' | '=' | '&' | '|' | '^' | '+' | '-'));
            let operator = OPERATORS.iter().find(|operator| may_go_on && rest.starts_with(**operator));
            (Kind::Symbol, operator.map_or(first.len_utf8(), |operator| operator.len()))
        };
        self.at += length;
        kind
    }

    /// Returns the end of the line from `start` on; in GLSL a backslash before the end continues the line.
    fn line_end(&self, start: usize) -> usize {
        let mut at = start;
        loop {
            let Some(found) = self.text[at..].find(|it| is_break(self.language, it)) else { return self.text.len() };
            let end = at + found;
            if self.language == Language::Wgsl || !self.text[start..end].ends_with('\\') {
                return end;
            }
            at = end + if self.text[end..].starts_with("\r\n") { 2 } else { 1 };
        }
    }

    /// Returns the end of the block comment that starts at `start`. Those of WGSL nest.
    fn block_end(&self, start: usize) -> Result<usize, Fault> {
        let (mut at, mut depth) = (start + 2, 1_usize);
        while depth > 0 {
            let rest = &self.text[at..];
            let close = rest.find("*/");
            let open = rest.find("/*").filter(|_| self.language == Language::Wgsl);
            match (open, close) {
                (Some(open), Some(close)) if open < close => (at, depth) = (at + open + 2, depth + 1),
                (_, Some(close)) => (at, depth) = (at + close + 2, depth - 1),
                (_, None) => {
                    let fault = Fault::new(start..start + 2, "the comment has no end");
                    return Err(fault.advise("close it with */"));
                }
            }
        }
        Ok(at)
    }

    /// Returns the end of the line of the preprocessor that starts at `start`.
    fn directive_end(&self, start: usize) -> Result<usize, Fault> {
        let mut at = start;
        let end = loop {
            let end = self.line_end(at);
            // A block comment that begins on the line may end on a later one.
            let line = &self.text[at..end];
            let block = line.find("/*").filter(|block| line.find("//").is_none_or(|it| it > *block));
            match block {
                Some(block) => at = self.block_end(at + block)?,
                None => break end,
            }
        };
        let directive = &self.text[start..end];
        if let Some(found) = directive.find("/*.").or_else(|| directive.find("//.")).filter(|_| !is_dots(directive)) {
            let fault = Fault::new(start + found..end, "an annotation stands on a line of the preprocessor");
            return Err(fault.advise("move it to a line of its own"));
        }
        Ok(end)
    }
}

/// Returns the end of the word at the start of a text.
fn word_end(text: &str, is_part: impl Fn(char) -> bool) -> usize {
    let plain = text.bytes().position(|it| !it.is_ascii_alphanumeric() && it != b'_').unwrap_or(text.len());
    match text.as_bytes().get(plain) {
        Some(next) if !next.is_ascii() => text.find(|it: char| !is_part(it)).unwrap_or(text.len()),
        _ => plain,
    }
}

/// Returns whether the first annotation of a directive is an ellipsis.
fn is_dots(directive: &str) -> bool {
    directive.contains("/*..") || directive.contains("//..")
}

/// Refuses what recursive parsers cannot read without exhausting their stack.
fn check_depth(text: &str, tokens: &[Token]) -> Result<(), Fault> {
    let (mut depth, mut length, mut branches) = (0_usize, 0_usize, 0_usize);
    for token in tokens.iter().filter(|token| !token.is_comment()) {
        length += 1;
        match token.text(text) {
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" => depth = depth.saturating_sub(1),
            "else" => branches += 1,
            _ => {}
        }
        if branches > MAX_ELSE {
            let fault = Fault::new(token.span.clone(), format!("the shader has more than {MAX_ELSE} words `else`"));
            return Err(fault.advise("use a switch or a table"));
        }
        if matches!(token.text(text), "{" | "}" | ";") {
            length = 0;
        }
        if depth > MAX_NESTING {
            let fault = Fault::new(token.span.clone(), format!("brackets are nested more than {MAX_NESTING} deep"));
            return Err(fault.advise("split the expression or the function"));
        }
        if length > MAX_STATEMENT {
            let fault = Fault::new(token.span.clone(), format!("a statement has more than {MAX_STATEMENT} tokens"));
            return Err(fault.advise("split it into several statements"));
        }
    }
    Ok(())
}
