//! Texts without comments and white space, which a front end reads in less time.

use crate::edit::SpanMap;
use crate::lexer::Token;

/// Returns the text of a WGSL shader without comments, and with white space only where two tokens need it between them, and
/// the map from the result to the text. `tokens` are those of the text. White space beyond ASCII stays: what counts as such
/// is for the front end to say.
pub(crate) fn compact(text: &str, tokens: &[Token]) -> (String, SpanMap) {
    let (mut out, mut map) = (String::with_capacity(text.len()), SpanMap::default());
    // The ends of the last token and of the last one that is code.
    let (mut end, mut code) = (0, 0);
    for token in tokens {
        let Token { span, .. } = token;
        let white = &text[end..span.start];
        if !white.is_ascii() {
            map.copy(out.len(), end..text.len());
            out.push_str(white);
        }
        end = span.end;
        if token.is_comment() {
            continue;
        }
        if code < span.start {
            let last = out.bytes().last();
            if last.is_some_and(|last| needs_space(last, text.as_bytes()[span.start])) {
                out.push(' ');
            }
            code = 0;
        }
        if code == 0 {
            map.copy(out.len(), span.start..text.len());
        }
        out.push_str(&text[span.clone()]);
        code = span.end;
    }
    let white = &text[end..];
    map.copy(out.len(), end..text.len());
    if !white.is_ascii() {
        out.push_str(white);
    }
    (out, map)
}

/// Returns whether two tokens with white space between them need it, from the last byte of the first and the first byte of
/// the second.
fn needs_space(last: u8, first: u8) -> bool {
    let is_alone = |it: u8| matches!(it, b'{' | b'}' | b'(' | b')' | b'[' | b']' | b';' | b',');
    // A point and bytes beyond ASCII continue words and numbers.
    let is_word = |it: u8| it.is_ascii_alphanumeric() || matches!(it, b'_' | b'.') || !it.is_ascii();
    // A sign continues the exponent of a number.
    let is_sign = matches!(first, b'+' | b'-');
    !is_alone(last) && !is_alone(first) && (is_word(last) == is_word(first) || (is_word(last) && is_sign))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::lexer::tokens;
    use crate::source::Language;

    fn compacted(text: &str) -> Option<(String, SpanMap)> {
        Some(compact(text, &tokens(text, Language::Wgsl).ok()?))
    }

    #[test]
    fn white_space_stays_where_tokens_would_join() {
        let of = |text| compacted(text).unwrap().0;
        let text = "fn  f( a : i32 ) -> i32 { // one\n    return a - - 1 + a /* two */ / 2;\n}\n";
        assert_eq!(of(text), "fn f(a:i32)->i32{return a - -1 +a/2;}");
        assert_eq!(of("1e - 2 a . b x > = y\u{a0}/* c */ z"), "1e -2 a . b x> =y\u{a0} z");
        assert_eq!(of("a/**/b + +c"), "a b + +c");
        assert_eq!(of(" // only\n"), "");
    }

    proptest! {
        /// Both texts have the same code tokens, and the map leads from each to its place.
        #[test]
        fn tokens_and_their_places_stay(text in "[a1e0x._+<>=/*&|(){};, \n\u{a0}ä-]{0,60}") {
            if let Some((short, map)) = compacted(&text) {
                let code = |text: &str| {
                    let list = tokens(text, Language::Wgsl).unwrap();
                    list.into_iter().filter(|token| !token.is_comment()).map(|token| token.span).collect::<Vec<_>>()
                };
                let (long, less) = (code(&text), code(&short));
                prop_assert_eq!(long.len(), less.len(), "{:?} {:?}", text, short);
                for (long, less) in long.into_iter().zip(less) {
                    prop_assert_eq!(&text[long.clone()], &short[less.clone()], "{:?}", short);
                    prop_assert_eq!(map.source(less), long);
                }
            }
        }
    }
}
