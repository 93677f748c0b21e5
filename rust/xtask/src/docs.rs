//! `cargo xtask docs`: one page for each noun of the C ABI, made of its header, and a check that nothing is left unsaid.
//!
//! Of every exported function a page says what it does, what it fails at, who owns what it gives, and which calls may run
//! at the same time. The first two are the comment above it; the others follow from the rules of `context.h` and the
//! words that they define. Numbers with a unit have it in the comment beside them.

use std::fmt::Write as _;
use std::path::PathBuf;

use crate::stage::{Outcome, root, target};

/// A part of a header at its top level.
enum Item {
    /// A comment without its marks.
    Comment(String),
    /// A `#define` in one line.
    Definition(String),
    /// A type, as it stands.
    Type(String),
    /// An exported function: its name, and its declaration in one line.
    Function { name: String, declaration: String },
}

/// Words of a comment that say what a function fails at, or that it does not.
const FAILURES: [&str; 5] = ["Fails", "fails", "RLV_ERROR", "refus", "No failure of its own"];
/// Words that say that a call changes an object, which it then needs alone.
const CHANGES: [&str; 6] = ["Mutating", "Mutates", "mutates", "Edits", "edit its detail", "Draws"];
/// Ends of names of functions that the rules of `context.h` say everything about.
const RULED: [&str; 2] = ["_retain", "_release"];

/// Writes the pages to `target/docs` and fails with every function that leaves something unsaid.
pub fn run() -> Outcome {
    let folder = target().join("docs");
    let (pages, faults) = pages()?;
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut index =
        String::from("# The C ABI of Relievo\n\nThe rules of [context](context.md) hold for every noun.\n\n");
    for (noun, page) in &pages {
        let path = folder.join(format!("{noun}.md"));
        std::fs::write(&path, page).map_err(|error| format!("{}: {error}", path.display()))?;
        let title = page.lines().nth(2).unwrap_or_default();
        let _ = writeln!(index, "- [{noun}]({noun}.md): {title}");
    }
    let path = folder.join("index.md");
    std::fs::write(&path, index).map_err(|error| format!("{}: {error}", path.display()))?;
    println!("{} pages in {}", pages.len() + 1, folder.display());
    if faults.is_empty() { Ok(()) } else { Err(format!("left unsaid:\n{}", faults.join("\n"))) }
}

/// The pages by their nouns, and what is left unsaid.
fn pages() -> Result<(Vec<(String, String)>, Vec<String>), String> {
    let folder = root().join("include/relievo");
    let entries = std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut headers: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    headers.retain(|path| path.extension().is_some_and(|extension| extension == "h"));
    headers.sort();
    let (mut pages, mut faults) = (Vec::new(), Vec::new());
    for path in headers {
        let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let noun = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let items = items(&text).ok_or_else(|| format!("{}: it ends within a comment or a type", path.display()))?;
        // A header that only includes others is no noun.
        if items.iter().all(|item| matches!(item, Item::Comment(_) | Item::Definition(_))) {
            continue;
        }
        pages.push((noun.clone(), page(&noun, &items, &mut faults)));
    }
    Ok((pages, faults))
}

/// The parts of a header; `None` if one does not end.
fn items(text: &str) -> Option<Vec<Item>> {
    let mut items = Vec::new();
    let mut rest = text.trim_start();
    while !rest.is_empty() {
        let length = if let Some(inside) = rest.strip_prefix("/*") {
            let end = inside.find("*/")?;
            items.push(Item::Comment(unmarked(&inside[..end])));
            end + 4
        } else if rest.starts_with('#') {
            let ends = rest.match_indices('\n').find(|(at, _)| !rest[..*at].ends_with('\\'));
            let end = ends.map_or(rest.len(), |(at, _)| at);
            if rest.starts_with("#define RLV_") {
                items.push(Item::Definition(one_line(&rest[..end].replace('\\', ""))));
            }
            end
        } else {
            let end = declaration_end(rest)?;
            let declaration = &rest[..end];
            match function_name(declaration) {
                Some(name) => items.push(Item::Function { name, declaration: one_line(declaration) }),
                None => items.push(Item::Type(declaration.to_owned())),
            }
            end
        };
        rest = rest[length..].trim_start();
    }
    Some(items)
}

/// The length of the declaration that `text` starts with, its semicolon included.
fn declaration_end(text: &str) -> Option<usize> {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        let rest = &text[at..];
        if rest.starts_with("/*") {
            at += rest.find("*/")? + 2;
            continue;
        }
        match rest.as_bytes()[0] {
            b'{' => depth += 1,
            b'}' => depth -= 1,
            b';' if depth == 0 => return Some(at + 1),
            _ => {}
        }
        at += rest.chars().next()?.len_utf8();
    }
    None
}

/// The name of the exported function that is declared, if it is one.
fn function_name(declaration: &str) -> Option<String> {
    let start = declaration.strip_prefix("RLV_API")?;
    let at = start.find("rlv_")?;
    Some(start[at..].chars().take_while(|letter| letter.is_alphanumeric() || *letter == '_').collect())
}

/// A comment without the stars at the start of its lines, as paragraphs.
fn unmarked(comment: &str) -> String {
    let lines = comment.lines().map(|line| line.trim().trim_start_matches('*').trim());
    lines.collect::<Vec<_>>().join("\n").trim().to_owned()
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The page of a noun; what it leaves unsaid goes to `faults`.
fn page(noun: &str, items: &[Item], faults: &mut Vec<String>) -> String {
    let mut out = format!("# {noun}\n");
    let mut before: Option<&str> = None;
    let mut about: Option<&str> = None;
    for item in items {
        match item {
            Item::Comment(text) => {
                about.get_or_insert(text);
                if out.lines().count() < 2 {
                    let _ = write!(out, "\n{}\n", text.trim_start_matches("Relievo: "));
                }
                before = Some(text);
                continue;
            }
            Item::Definition(text) => {
                if let Some(text) = before.filter(|text| Some(*text) != about) {
                    let _ = write!(out, "\n{text}\n");
                }
                let _ = write!(out, "\n    {text}\n");
            }
            Item::Type(text) => {
                if let Some(text) = before.filter(|text| Some(*text) != about) {
                    let _ = write!(out, "\n{text}\n");
                }
                let indented = text.lines().map(|line| format!("    {line}\n")).collect::<String>();
                let _ = write!(out, "\n{indented}");
                faults
                    .extend(unitless(text).into_iter().map(|field| format!("{noun}.h: the unit or range of {field}")));
            }
            Item::Function { name, declaration } => {
                let text = before.filter(|text| Some(*text) != about).unwrap_or_default();
                let _ = write!(
                    out,
                    "\n## {name}\n\n    {declaration}\n\n{text}\n{}",
                    ruled(name, declaration, text, about)
                );
                faults.extend(
                    unsaid(name, declaration, text).into_iter().map(|what| format!("{noun}.h: {name}: {what}")),
                );
            }
        }
        before = None;
    }
    out
}

/// What the rules say of a function: ownership and threads.
fn ruled(name: &str, declaration: &str, text: &str, about: Option<&str>) -> String {
    let mut out = String::new();
    if name.ends_with("_retain") {
        out.push_str("- Ownership: adds a reference, which is released by itself.\n");
    } else if name.ends_with("_release") {
        out.push_str("- Ownership: takes a reference away; the last one ends the object.\n");
    } else if let Some(kind) = made(declaration) {
        let _ = writeln!(out, "- Ownership: gives one reference to {kind}; release it.");
    } else {
        out.push_str("- Ownership: what is passed is borrowed for the call.\n");
    }
    let changes = CHANGES.iter().any(|word| text.contains(word) || about.is_some_and(|about| about.contains(word)));
    out.push_str(match changes {
        true => "- Threads: any; it changes an object and needs it alone, else RLV_ERROR_BUSY.\n",
        false => "- Threads: any, and at the same time as other calls that change nothing.\n",
    });
    out
}

/// The kind of handle that a function gives through its last argument.
fn made(declaration: &str) -> Option<&str> {
    let last = declaration.trim_end_matches([')', ';']).rsplit([',', '(']).next()?.trim();
    let (kind, name) = last.split_once(" *")?;
    (name.starts_with("out") && kind.starts_with("Rlv") && !kind.ends_with("Info") && !kind.ends_with("Report"))
        .then_some(kind)
}

/// What the comment of a function leaves unsaid.
fn unsaid(name: &str, declaration: &str, text: &str) -> Vec<&'static str> {
    let text = &one_line(text);
    if RULED.iter().any(|end| name.ends_with(end)) {
        return Vec::new();
    }
    let mut faults = Vec::new();
    if text.is_empty() {
        faults.push("what it does");
    }
    if declaration.contains("RlvResult rlv_") && !FAILURES.iter().any(|word| text.contains(word)) {
        faults.push("what it fails at");
    }
    // A pointer that is given away is the library's.
    if (declaration.contains("const RlvParameter *") || declaration.contains("const char *rlv_"))
        && !text.contains("live")
    {
        faults.push("how long what it points to lives");
    }
    faults
}

/// The numbers of a struct that have no comment beside them or above.
fn unitless(text: &str) -> Vec<String> {
    let Some(name) = text.strip_prefix("typedef struct ").and_then(|rest| rest.split_whitespace().next()) else {
        return Vec::new();
    };
    let (mut faults, mut said, mut open) = (Vec::new(), false, false);
    for line in text.lines().skip(1).map(str::trim) {
        let comment = open || line.contains("/*");
        open = comment && !line.contains("*/");
        let number = ["float ", "double "].iter().any(|kind| line.starts_with(kind));
        // What follows in the same group is of the same kind, such as the upper bounds after the lower ones.
        if number && !comment && !said {
            faults.push(format!("{name}: {}", line.trim_end_matches(';')));
        }
        said = (said || comment) && !line.is_empty();
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_header_leaves_unsaid_is_found() {
        let header = "/* Relievo: balls. */\n#define RLV_BALL_INIT \\\n    {0}\ntypedef struct RlvBall {\n    float radius;\n} RlvBall;\n\
                      /* Makes one. */\nRLV_API RlvResult rlv_ball_create(RlvContext context,\n    RlvBall *out);\n\
                      RLV_API RlvResult rlv_ball_release(RlvBall ball);\n\
                      /* Mutating. Rolls it. Fails uphill. */\nRLV_API RlvResult rlv_ball_roll(RlvBall ball);\n";
        let mut faults = Vec::new();
        let page = page("ball", &items(header).unwrap(), &mut faults);
        assert_eq!(
            faults,
            ["ball.h: the unit or range of RlvBall: float radius", "ball.h: rlv_ball_create: what it fails at"]
        );
        assert!(page.starts_with("# ball\n\nballs.\n") && page.contains("#define RLV_BALL_INIT {0}"), "{page}");
        assert!(page.contains("gives one reference to RlvBall") && page.contains("needs it alone"), "{page}");
        assert!(items("/* without an end").is_none() && items("typedef struct A {").is_none());
    }
}
