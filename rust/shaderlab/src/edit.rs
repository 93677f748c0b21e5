//! Edits of a text that remember which bytes of the result come from which bytes of the text.

use crate::fault::Span;

/// A piece of what an edit inserts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// New text.
    New(String),
    /// Bytes of the user's text.
    Copy(Span),
}

/// Bytes of the user's text and what replaces them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Edit {
    pub span: Span,
    pub parts: Vec<Part>,
}

impl Edit {
    /// Inserts a text before byte `at`.
    pub fn insert(at: usize, text: impl Into<String>) -> Self {
        Self { span: at..at, parts: vec![Part::New(text.into())] }
    }

    /// Replaces bytes by a text.
    pub fn replace(span: Span, text: impl Into<String>) -> Self {
        Self { span, parts: vec![Part::New(text.into())] }
    }
}

/// Which bytes of an edited text come from which bytes of the user's text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SpanMap {
    /// Start in the edited text, bytes of the user's text, and whether these were copied. In order, without gaps.
    pieces: Vec<(usize, Span, bool)>,
}

impl SpanMap {
    /// Returns the map of a text that is not edited.
    pub(crate) fn whole(text: &str) -> Self {
        Self { pieces: vec![(0, 0..text.len(), true)] }
    }

    /// Says that the edited text has, from byte `at` on, a copy of bytes of the user's text. Calls go in the order of `at`.
    pub(crate) fn copy(&mut self, at: usize, from: Span) {
        self.pieces.push((at, from, true));
    }

    /// Returns the bytes of the user's text from which byte `at` of the edited text comes, one byte or all that an edit
    /// replaced, and whether it was copied.
    fn origin(&self, at: usize) -> (Span, bool) {
        let index = self.pieces.partition_point(|(start, ..)| *start <= at);
        match index.checked_sub(1).and_then(|index| self.pieces.get(index)) {
            Some((start, from, true)) => {
                let place = (from.start + (at - start)).min(from.end);
                (place..(place + 1).min(from.end), true)
            }
            Some((_, from, false)) => (from.clone(), false),
            None => (0..0, false),
        }
    }

    /// Returns the bytes of the user's text from which bytes of the edited text come.
    pub fn source(&self, span: Span) -> Span {
        let (first, is_copy) = self.origin(span.start);
        if span.is_empty() && is_copy {
            return first.start..first.start;
        }
        let (last, _) = self.origin(span.end.saturating_sub(1).max(span.start));
        first.start.min(last.start)..last.end.max(first.end)
    }
}

/// Applies edits that do not overlap; edits at the same byte are applied in their order.
pub(crate) fn apply(text: &str, mut edits: Vec<Edit>) -> (String, SpanMap) {
    edits.sort_by_key(|edit| (edit.span.start, edit.span.end));
    let (mut out, mut map, mut at) = (String::with_capacity(text.len() + 1024), SpanMap::default(), 0);
    let mut copy = |out: &mut String, span: Span, from: Span, is_copy: bool, new: &str| {
        map.pieces.push((out.len(), from, is_copy));
        out.push_str(if is_copy { &text[span] } else { new });
    };
    for Edit { span, parts } in edits {
        let start = span.start.max(at);
        copy(&mut out, at..start, at..start, true, "");
        for part in parts {
            match part {
                Part::New(new) => copy(&mut out, 0..0, span.clone(), false, &new),
                Part::Copy(bytes) => copy(&mut out, bytes.clone(), bytes, true, ""),
            }
        }
        at = span.end.max(start);
    }
    copy(&mut out, at..text.len(), at..text.len(), true, "");
    (out, map)
}
