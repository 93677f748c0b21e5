//! File names of numbered meshes: `walk.####.obj`, or as in C `walk.%04d.obj` and `walk.%d.obj`.

use relievo_core::{Error, Result};

/// Most digits that a number is padded to.
const MAX_DIGITS: usize = 18;

/// A path with a place for a number in its file name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern<'a> {
    before: &'a str,
    after: &'a str,
    digits: usize,
}

impl<'a> Pattern<'a> {
    /// Reads a pattern. Folders are taken as they are.
    ///
    /// # Errors
    /// Fails with `Invalid` unless the file name has exactly one place for a number, of at most 18 digits.
    pub fn new(path: &'a str) -> Result<Self> {
        let file = path.rfind('/').map_or(0, |slash| slash + 1);
        let mut found: Vec<(usize, usize, usize)> = Vec::new();
        let mut strange = None;
        let mut at = file;
        while let Some(offset) = path[at..].find(['#', '%']) {
            let start = at + offset;
            let rest = &path[start..];
            let length = if rest.starts_with('#') {
                let run = rest.find(|letter| letter != '#').unwrap_or(rest.len());
                found.push((start, run, run));
                run
            } else {
                let digits = rest[1..].find(|letter: char| !letter.is_ascii_digit()).unwrap_or(rest.len() - 1);
                let (width, letter) = (&rest[1..1 + digits], rest[1 + digits..].chars().next());
                if letter == Some('d') && (width.is_empty() || width.starts_with('0')) {
                    // More digits than a number can have are refused below.
                    found.push((
                        start,
                        digits + 2,
                        width.parse().unwrap_or(if width.is_empty() { 1 } else { usize::MAX }),
                    ));
                    digits + 2
                } else {
                    strange = strange.or(letter.map(|letter| format!("%{width}{letter}")));
                    1
                }
            };
            at = start + length;
        }
        const ADVICE: &str =
            "write it as \"walk.####.obj\", \"walk.%04d.obj\" or, without leading zeros, \"walk.%d.obj\"";
        match found[..] {
            [(start, length, digits)] if digits <= MAX_DIGITS => {
                Ok(Self { before: &path[..start], after: &path[start + length..], digits })
            }
            [_] => Err(Error::invalid(format!("the number of a sequence has more than {MAX_DIGITS} digits"))
                .advise("use as many as the files have")),
            [] => Err(Error::invalid(match strange {
                Some(strange) => format!("`{strange}` is no number that files of a sequence can have"),
                None => "a sequence needs a place for the number in its file name".into(),
            })
            .advise(ADVICE)),
            [first, second, ..] => {
                let part = |(start, length, _): (usize, usize, usize)| &path[start..start + length];
                let both = format!("`{}` and `{}`", part(first), part(second));
                Err(Error::invalid(format!("the file name has two places for the number: {both}"))
                    .advise("keep one of them"))
            }
        }
    }

    /// The path of the file with this number.
    pub fn path(&self, number: u64) -> String {
        format!("{}{number:0width$}{}", self.before, self.after, width = self.digits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_padded_as_the_pattern_says() {
        for (pattern, number, path) in [
            ("a/walk.####.obj", 7, "a/walk.0007.obj"),
            ("#.ply", 123, "123.ply"),
            ("a/walk.%04d.obj", 7, "a/walk.0007.obj"),
            ("walk%d.obj", 12, "walk12.obj"),
            ("walk%0d.obj", 12, "walk12.obj"),
            ("walk%03d.obj", 12345, "walk12345.obj"),
            ("a#1/50%/half%off_##.obj", 3, "a#1/50%/half%off_03.obj"),
            ("größe%02dé.obj", 3, "größe03é.obj"),
        ] {
            assert_eq!(Pattern::new(pattern).unwrap().path(number), path, "{pattern}");
        }
    }

    #[test]
    fn patterns_that_name_no_number_or_two_are_refused_with_advice() {
        for (pattern, says) in [
            ("walk.obj", "needs a place"),
            ("####/walk.obj", "needs a place"),
            ("walk.%4d.obj", "`%4d`"),
            ("walk.%i.obj", "`%i`"),
            ("walk%", "needs a place"),
            ("walk.%04d.##.obj", "`%04d` and `##`"),
            ("#_#.obj", "`#` and `#`"),
            ("%d%d.obj", "two places"),
            ("%099999999999999999999999d.obj", "more than 18 digits"),
            ("%0999d.obj", "more than 18 digits"),
        ] {
            let error = Pattern::new(pattern).unwrap_err();
            assert!(error.what.contains(says) && !error.remedy.is_empty(), "{pattern}: {error}");
        }
    }
}
