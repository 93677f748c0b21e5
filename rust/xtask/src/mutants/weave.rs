//! Writes all mutants of a file into it, each behind a check of its number (mutant schemata; Untch, Offutt and Harrold
//! 1993).

use std::ops::Range;

use super::edits::{Edit, MODULE, Piece, Site, find};

/// The variable of the environment with the number of the mutant that runs; 0 is none.
pub const CHOSEN: &str = "RELIEVO_MUTANT";
/// The variable with the file to which the numbers of mutants go whose code is reached, where none is chosen.
pub const REACHED: &str = "RELIEVO_MUTANT_REACHED";

/// A file with its mutants.
pub struct Woven {
    pub text: String,
    /// Where the code of mutants is in the text.
    pub marks: Vec<Mark>,
    /// Mutants that cannot be chosen while the program runs, each with the reason.
    pub refused: Vec<(u32, &'static str)>,
}

/// Bytes of a woven text that a mutant wrote.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    pub number: u32,
    pub range: Range<usize>,
    /// Only the mutant runs them.
    pub is_mutated: bool,
}

/// Writes mutants into the text of a file.
///
/// # Errors
/// Fails if the text is no Rust.
pub fn weave(source: &str, sites: &[Site]) -> Result<Woven, String> {
    let file = syn::parse_file(source).map_err(|error| error.to_string())?;
    let (edits, refused) = find(&file, sites);
    let mut writer = Writer { source, text: String::new(), marks: Vec::new() };
    writer.write(0..source.len(), &edits.iter().collect::<Vec<_>>());
    Ok(Woven { text: writer.text, marks: writer.marks, refused: refused.into_iter().collect() })
}

struct Writer<'a> {
    source: &'a str,
    text: String,
    marks: Vec<Mark>,
}

impl Writer<'_> {
    /// Writes bytes of the source with the edits in them, which are in their order.
    fn write(&mut self, range: Range<usize>, mut edits: &[&Edit]) {
        let mut at = range.start;
        while let [first, rest @ ..] = edits {
            self.text.push_str(&self.source[at..first.range.start]);
            let inside = rest.iter().take_while(|edit| edit.range.start < first.range.end).count();
            let (inner, after) = rest.split_at(inside);
            let start = self.text.len();
            self.pieces(first.number, &first.pieces, inner);
            self.marks.push(Mark { number: first.number, range: start..self.text.len(), is_mutated: false });
            at = first.range.end;
            edits = after;
        }
        self.text.push_str(&self.source[at..range.end]);
    }

    fn pieces(&mut self, number: u32, pieces: &[Piece], inner: &[&Edit]) {
        for piece in pieces {
            match piece {
                Piece::Text(text) => self.text.push_str(text),
                Piece::Source(range) => {
                    let is_inside = |edit: &Edit| range.start <= edit.range.start && edit.range.end <= range.end;
                    let inside: Vec<&Edit> = inner.iter().copied().filter(|edit| is_inside(edit)).collect();
                    self.write(range.clone(), &inside);
                }
                Piece::Mutated(pieces) => {
                    let start = self.text.len();
                    self.pieces(number, pieces, inner);
                    self.marks.push(Mark { number, range: start..self.text.len(), is_mutated: true });
                }
            }
        }
    }
}

/// Returns the innermost mark around one of the places of an error, the first of which count more.
pub fn culprit<'a>(marks: &'a [Mark], places: &[Range<usize>]) -> Option<&'a Mark> {
    let around = |place: &Range<usize>| {
        let around = marks.iter().filter(|mark| mark.range.start <= place.start && place.end <= mark.range.end);
        around.min_by_key(|mark| mark.range.len())
    };
    places.iter().find_map(around)
}

/// Returns the byte of a line and a column, both from 1; columns are letters.
pub fn byte(text: &str, (line, column): (usize, usize)) -> Option<usize> {
    let start: usize = text.split_inclusive('\n').take(line.checked_sub(1)?).map(str::len).sum();
    let mut letters = text.get(start..)?.char_indices().map(|(at, _)| start + at);
    letters.nth(column.checked_sub(1)?)
}

/// Returns the module with the check, for a crate with mutants of numbers below `count`.
pub fn module(count: usize) -> String {
    const TEXT: &str = r#"
mod MODULE {
    use std::io::Write as _;
    use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

    const UNREAD: u32 = u32::MAX;
    const WATCHED: u32 = u32::MAX - 1;
    static CHOSEN: AtomicU32 = AtomicU32::new(UNREAD);
    static REACHED: [AtomicBool; COUNT] = [const { AtomicBool::new(false) }; COUNT];

    #[inline]
    pub fn is_on(number: u32) -> bool {
        let chosen = CHOSEN.load(Relaxed);
        if chosen < WATCHED { chosen == number } else { slow(number) }
    }

    #[cold]
    #[inline(never)]
    fn slow(number: u32) -> bool {
        let path = std::env::var_os("VARIABLE_OF_REACHED");
        if CHOSEN.load(Relaxed) == UNREAD {
            let chosen = std::env::var("VARIABLE_OF_CHOSEN").ok().and_then(|text| text.parse().ok()).unwrap_or(0);
            CHOSEN.store(if chosen == 0 && path.is_some() { WATCHED } else { chosen }, Relaxed);
        }
        if let Some(path) = path.filter(|_| !REACHED[number as usize].swap(true, Relaxed)) {
            let line = format!("{number}\n");
            let file = std::fs::OpenOptions::new().append(true).create(true).open(path);
            let _ = file.and_then(|mut file| file.write_all(line.as_bytes()));
        }
        CHOSEN.load(Relaxed) == number
    }
}
"#;
    let text = TEXT.replace("MODULE", MODULE).replace("COUNT", &count.to_string());
    text.replace("VARIABLE_OF_REACHED", REACHED).replace("VARIABLE_OF_CHOSEN", CHOSEN)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weaves mutants, each a kind, the text that it begins with, and what is written instead, by numbers from 1. The text
    /// without the folder of the check must be Rust again.
    fn woven(source: &str, mutants: &[(&str, &str, &str)]) -> Woven {
        let site = |(number, (genre, place, replacement)): (u32, &(&str, &str, &str))| Site {
            number,
            genre: (*genre).to_owned(),
            replacement: (*replacement).to_owned(),
            start: source.find(place).unwrap(),
        };
        let sites: Vec<Site> = (1..).zip(mutants).map(site).collect();
        let mut woven = weave(source, &sites).unwrap();
        syn::parse_file(&woven.text).unwrap();
        woven.text = woven.text.replace("crate::relievo_mutants::is_on", "on");
        woven
    }

    #[test]
    fn operators_are_chosen_with_their_operands_and_nested_ones_within_each_other() {
        let source = "fn f(a: u32, b: u32) -> bool { a + b * 2 < 7 }";
        let both = [("BinaryOperator", "+", "-"), ("BinaryOperator", "*", "+"), ("BinaryOperator", "*", "/")];
        let product = "(if on(2) { (b) + (2) } else { ((if on(3) { (b) / (2) } else { (b * 2) })) })";
        let sum = format!("(if on(1) {{ (a) - ({product}) }} else {{ (a + {product}) }})");
        assert_eq!(woven(source, &both).text, format!("fn f(a: u32, b: u32) -> bool {{ {sum} < 7 }}"));
        let source = "fn f(a: &mut u32, b: bool) { *a += 1; if !b { *a = 2 } }";
        let both = [("BinaryOperator", "+=", "-="), ("UnaryOperator", "!", "")];
        let text = "fn f(a: &mut u32, b: bool) { (if on(1) { (*a) -= (1) } else { (*a += 1) }); \
                    if (if on(2) { (b) } else { (!b) }) { *a = 2 } }";
        assert_eq!(woven(source, &both).text, text);
    }

    #[test]
    fn functions_return_another_value_before_all_else() {
        let source = "impl A { fn f(&self) -> Option<u8> { self.a && g() } }";
        let all = [("FnValue", "self.a", "None"), ("FnValue", "self.a", "Some(0)"), ("BinaryOperator", "&&", "||")];
        let text = "impl A { fn f(&self) -> Option<u8> { if on(1) { return None; } if on(2) { return Some(0); } \
                    (if on(3) { (self.a) || (g()) } else { (self.a && g()) }) } }";
        assert_eq!(woven(source, &all).text, text);
    }

    #[test]
    fn arms_are_left_by_a_guard_and_guards_are_chosen() {
        let source = "fn f(a: u8) -> u8 { match a { 0 | 1 => 5, n if n > 7 => 6, _ => 7 } }";
        let all = [
            ("MatchArm", "0 |", ""),
            ("MatchArm", "n if", ""),
            ("MatchArmGuard", "n > 7", "false"),
            ("BinaryOperator", "> 7", ">="),
        ];
        let guard = "(if on(3) { false } else { ((if on(4) { (n) >= (7) } else { (n > 7) })) })";
        let text = format!(
            "fn f(a: u8) -> u8 {{ match a {{ 0 | 1 if !on(1) => 5, n if !on(2) && ({guard}) => 6, _ => 7 }} }}"
        );
        assert_eq!(woven(source, &all).text, text);
    }

    #[test]
    fn fields_are_those_of_the_rest() {
        let source = "fn f(b: u8) -> A { A { a: 1, b, ..A::default() } }";
        let text = "fn f(b: u8) -> A { A { a: (if on(1) { { let whole: A = A::default(); whole.a } } else { (1) }), \
                    b: (if on(2) { { let whole: A = A::default(); whole.b } } else { (b) }), ..A::default() } }";
        assert_eq!(woven(source, &[("StructField", "a: 1", ""), ("StructField", "b, ", "")]).text, text);
    }

    #[test]
    fn what_no_variable_can_change_is_refused_with_the_reason() {
        let source = "const A: u8 = 1 + 2; const fn f() -> u8 { 3 } fn g(a: Option<u8>) -> impl Iterator { \
                      if let Some(_) = a && b { [0; 4 * 5] } else { m!(6 - 7) } }";
        let all = [
            ("BinaryOperator", "+", "-"),
            ("FnValue", "3", "0"),
            ("FnValue", "if let", "::std::iter::empty()"),
            ("BinaryOperator", "&&", "||"),
            ("BinaryOperator", "*", "/"),
            ("BinaryOperator", "- 7", "+"),
        ];
        let woven = woven(source, &all);
        assert_eq!(woven.text, source);
        let has = |word: &str| woven.refused.iter().filter(|(_, why)| why.contains(word)).count();
        assert_eq!([has("constant"), has("impl Trait"), has("`let`"), has("no code")], [3, 1, 1, 1]);
    }

    #[test]
    fn an_error_is_of_the_innermost_mutant_around_it() {
        let source = "fn f(a: u32, b: u32) -> u32 { a + b * 2 }";
        let sites = [("+", "-", 1), ("*", "/", 2)].map(|(place, new, number)| Site {
            number,
            genre: "BinaryOperator".into(),
            replacement: new.into(),
            start: source.find(place).unwrap(),
        });
        let woven = weave(source, &sites).unwrap();
        let at = |text: &str| {
            let start = woven.text.find(text).unwrap();
            culprit(&woven.marks, &[0..1, start..start + text.len()]).map(|mark| (mark.number, mark.is_mutated))
        };
        assert_eq!(at("(b) / (2)"), Some((2, true)));
        assert_eq!(at("b * 2"), Some((2, false)));
        assert_eq!(at("(a) - "), Some((1, true)));
        assert_eq!(at("a + "), Some((1, false)));
        assert_eq!(at("fn f"), None);
    }

    #[test]
    fn places_are_lines_and_letters() {
        let text = "a\nβγ δ\n";
        assert_eq!([byte(text, (2, 4)), byte(text, (1, 1)), byte(text, (9, 1))], [Some(7), Some(0), None]);
    }

    #[test]
    fn the_check_is_rust() {
        let file = syn::parse_file(&module(7)).unwrap();
        assert_eq!(file.items.len(), 1);
        assert!(module(7).contains(&format!("\"{CHOSEN}\"")) && module(7).contains("; 7]"));
    }
}
