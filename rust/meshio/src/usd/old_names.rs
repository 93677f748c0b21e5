//! Names that types of values had before USD 0.7, which stages in text may still have.

use std::borrow::Cow;

use logos::Logos;
use openusd::usda::token::Token;

/// Old names and the names of today, after the table of types of OpenUSD's Scene Description Foundations.
const NAMES: &[(&str, &str)] = &[
    ("Color", "color3d"),
    ("ColorFloat", "color3f"),
    ("EdgeIndex", "int"),
    ("FaceIndex", "int"),
    ("Frame", "frame4d"),
    ("Matrix2d", "matrix2d"),
    ("Matrix3d", "matrix3d"),
    ("Matrix4d", "matrix4d"),
    ("Normal", "normal3d"),
    ("NormalFloat", "normal3f"),
    ("Point", "point3d"),
    ("PointFloat", "point3f"),
    ("PointIndex", "int"),
    ("Quatd", "quatd"),
    ("Quatf", "quatf"),
    ("Quath", "quath"),
    ("Transform", "matrix4d"),
    ("Vec2d", "double2"),
    ("Vec2f", "float2"),
    ("Vec2h", "half2"),
    ("Vec2i", "int2"),
    ("Vec3d", "double3"),
    ("Vec3f", "float3"),
    ("Vec3h", "half3"),
    ("Vec3i", "int3"),
    ("Vec4d", "double4"),
    ("Vec4f", "float4"),
    ("Vec4h", "half4"),
    ("Vec4i", "int4"),
    ("Vector", "vector3d"),
    ("VectorFloat", "vector3f"),
];

/// Returns the text with the names that types have today. A name counts as that of a type where another name follows it,
/// with or without the brackets of an array.
pub(super) fn replaced(text: &str) -> Cow<'_, str> {
    if !NAMES.iter().any(|(old, _)| text.contains(old)) {
        return Cow::Borrowed(text);
    }
    let is_name = |word: &str| word.starts_with(|letter: char| letter.is_ascii_alphabetic() || letter == '_');
    let mut changed = String::new();
    let mut copied = 0;
    // An old name that may be a type, where it is, and whether a bracket was opened behind it.
    let mut found: Option<(std::ops::Range<usize>, &str)> = None;
    let mut is_declared = false;
    for (token, span) in Token::lexer(text).spanned() {
        let word = &text[span.clone()];
        if token.is_ok() && is_name(word) {
            if let Some((place, new)) = found.take() {
                changed += &text[copied..place.start];
                changed += new;
                copied = place.end;
            }
            // A type of a prim stands behind these.
            let known = NAMES.iter().find(|(old, _)| *old == word).filter(|_| !is_declared);
            found = known.map(|(_, new)| (span, *new));
            is_declared = matches!(token, Ok(Token::Def | Token::Over | Token::Class));
        } else if !matches!(word, "[" | "]") {
            found = None;
            is_declared = false;
        }
    }
    if copied == 0 {
        return Cow::Borrowed(text);
    }
    changed += &text[copied..];
    Cow::Owned(changed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_renamed_and_nothing_else_is() {
        let old = "#usda 1.0\ndef Point \"Point a\" { # Point b\n custom PointIndex[] Point = [1]\n Vec2f uv = (0, 1)\n \
                   string note = 'Normal n'\n uniform token Normal = \"Point\"\n rel Vector = </Point>\n}";
        let new = "#usda 1.0\ndef Point \"Point a\" { # Point b\n custom int[] Point = [1]\n float2 uv = (0, 1)\n \
                   string note = 'Normal n'\n uniform token Normal = \"Point\"\n rel Vector = </Point>\n}";
        assert_eq!(replaced(old), new);
        assert!(matches!(replaced("#usda 1.0\ndef Mesh \"Point\" {}"), Cow::Borrowed(_)));
    }
}
