//! Prose uses the plain phrases of the house, and every shared type has its term in the glossary.
//!
//! The phrases are looked for in C and C++ headers, documentation, the plugins, and the comments of all crates and shaders.
//! Lines of a paragraph are joined first, so that a phrase is found where it wraps.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Phrases to avoid, lower case, and what to write instead.
const PHRASES: [(&str, &str); 9] = [
    ("those that", "the noun: \"particles that …\""),
    ("those who", "the noun: \"hosts that …\""),
    ("are none", "\"no … exists\", or \"invalid …\""),
    ("is told", "what reports it: \"… reports …\", \"… gets …\""),
    ("are told", "what reports them: \"… reports …\", \"… get …\""),
    ("what is kept", "the noun: \"the … that … keeps\""),
    ("let go of", "\"release\" or \"close\""),
    ("lets go of", "\"releases\" or \"closes\""),
    ("knows nothing", "\"does not depend on …\" or \"does not have …\""),
];

/// Names that say nothing of what a module computes.
const MODULES: [&str; 2] = ["utils", "helpers"];

/// Folders of `rust` with programs, and the C ABI with its own names: their types are public to no other crate.
const PROGRAMS: [&str; 8] = ["bench", "bindings", "capi", "cli", "comparison", "testing", "view", "xtask"];

/// Place of a phrase in a text.
#[derive(Debug, PartialEq)]
struct Finding {
    line: usize,
    phrase: &'static str,
    instead: &'static str,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Returns the files under a folder with one of the extensions, in order.
fn files(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
            let entry = entry.expect("entries of folders can be read");
            let (path, kind) = (entry.path(), entry.file_type().expect("entries have a type"));
            if kind.is_dir() && entry.file_name() != "target" {
                folders.push(path);
            } else if path.extension().is_some_and(|e| extensions.iter().any(|one| e == *one)) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Returns the prose of a line of a file with this extension: of Rust and WGSL the comment, else all without the mark of
/// one; `None` for a line that separates paragraphs.
fn prose<'a>(line: &'a str, extension: &str) -> Option<&'a str> {
    let line = line.trim();
    if extension == "rs" || extension == "wgsl" {
        return ["///", "//!", "//"].iter().find_map(|mark| line.strip_prefix(mark));
    }
    let marks: &[&str] = match extension {
        "h" | "hpp" => &["/**", "/*", "*", "///", "//"],
        "py" => &["#"],
        "cpp" => &["///", "//"],
        _ => &[],
    };
    let text = marks.iter().find_map(|mark| line.strip_prefix(mark)).unwrap_or(line);
    Some(text).filter(|text| !text.trim().is_empty())
}

/// Finds phrases in a text, also where they wrap. "None", as Python's, is not "none".
fn phrases(text: &str, extension: &str) -> Vec<Finding> {
    let mut found = Vec::new();
    // Words of a paragraph with their lines.
    let mut words: Vec<(&str, usize)> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        match prose(line, extension) {
            Some(prose) if !prose.trim().is_empty() => {
                words.extend(prose.split_whitespace().map(|word| (word, index + 1)));
            }
            _ => search(&std::mem::take(&mut words), &mut found),
        }
    }
    search(&words, &mut found);
    found
}

/// Adds the phrases in a paragraph's words. Marks may stand before the first word and after the last, and the first may
/// begin with a capital.
fn search(words: &[(&str, usize)], found: &mut Vec<Finding>) {
    for (start, &(first, line)) in words.iter().enumerate() {
        let first = first.trim_start_matches(|letter: char| !letter.is_alphanumeric() && letter != '_');
        for &(phrase, instead) in &PHRASES {
            let is_begun = |word: &str| {
                first.get(1..) == word.get(1..) && first.get(..1).map(str::to_lowercase).as_deref() == word.get(..1)
            };
            let mut parts = phrase.split(' ');
            if !parts.next().is_some_and(is_begun) {
                continue;
            }
            let count = parts.clone().count();
            let is_continued = parts.enumerate().all(|(index, part)| {
                let rest = words.get(start + 1 + index).and_then(|(word, _)| word.strip_prefix(part));
                rest.is_some_and(|rest| {
                    rest.is_empty()
                        || index + 1 == count
                            && !rest.starts_with(|letter: char| letter.is_alphanumeric() || letter == '_')
                })
            });
            if is_continued {
                found.push(Finding { line, phrase, instead });
            }
        }
    }
}

/// Returns the folder of `rust` or `rust/native` that a file of Rust is in.
fn crate_of(path: &Path) -> String {
    let inside = path.strip_prefix(root().join("rust")).expect("files of Rust are in rust");
    let folder = |index| inside.iter().nth(index).and_then(|part| part.to_str()).unwrap_or_default();
    if folder(0) == "native" { format!("native/{}", folder(1)) } else { folder(0).to_owned() }
}

fn checked() -> Vec<PathBuf> {
    let root = root();
    let mut checked = vec![root.join("README.md"), root.join("CHANGELOG.md")];
    checked.extend(files(&root.join("include"), &["h", "hpp"]));
    checked.extend(files(&root.join("docs"), &["md"]));
    checked.extend(files(&root.join("plugins"), &["py", "md", "cpp"]));
    checked.extend(files(&root.join("rust"), &["rs", "wgsl"]));
    checked.extend(files(&root.join("shaders"), &["wgsl"]));
    checked
}

#[test]
fn prose_is_plain() {
    let mut report = String::new();
    for path in checked() {
        let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        for Finding { line, phrase, instead } in phrases(&text, extension) {
            let path = path.strip_prefix(root()).unwrap_or(&path).display();
            report += &format!("{path}:{line}: \"{phrase}\": write {instead}\n");
        }
    }
    assert!(report.is_empty(), "phrases that the house does not write:\n{report}");
}

#[test]
fn modules_are_named_by_what_they_compute() {
    let root = root();
    let sources = ["rust", "plugins", "cpp", "shaders"]
        .map(|folder| files(&root.join(folder), &["rs", "py", "cpp", "h", "wgsl"]));
    let vague: Vec<_> = sources
        .into_iter()
        .flatten()
        .filter(|path| {
            let inside = path.strip_prefix(&root).unwrap_or(path).with_extension("");
            inside.iter().any(|part| MODULES.iter().any(|name| part == *name))
        })
        .collect();
    assert!(vague.is_empty(), "name these by a noun of the field: {vague:?}");
}

/// Returns the name of a public type that a line declares at the top level.
fn declared(line: &str) -> Option<&str> {
    let rest = line.strip_prefix("pub ")?;
    let rest = ["struct ", "enum ", "trait ", "type "].iter().find_map(|kind| rest.strip_prefix(kind))?;
    rest.split(|letter: char| !letter.is_alphanumeric() && letter != '_').next().filter(|name| !name.is_empty())
}

/// Splits a name of a type into lower-case words, as the glossary writes terms.
fn term(name: &str) -> String {
    let mut term = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !term.is_empty() {
            term.push(' ');
        }
        term.extend(letter.to_lowercase());
    }
    term
}

#[test]
fn shared_types_are_in_the_glossary() {
    let glossary = fs::read_to_string(root().join("docs/glossary.md")).expect("the glossary can be read");
    let terms: BTreeSet<&str> = glossary
        .lines()
        .filter_map(|line| line.strip_prefix("| ")?.split(" |").next())
        .flat_map(|terms| terms.split(", "))
        .map(str::trim)
        .collect();
    let mut crates: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for path in files(&root().join("rust"), &["rs"]) {
        let folder = crate_of(&path);
        if PROGRAMS.contains(&folder.as_str()) || path.iter().any(|part| part == "tests") {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        for name in text.lines().filter_map(declared) {
            crates.entry(name.to_owned()).or_default().insert(folder.clone());
        }
    }
    assert!(crates.len() > 100, "public types are found: {}", crates.len());
    let missing: Vec<_> =
        crates.iter().filter(|(name, crates)| crates.len() > 2 && !terms.contains(term(name).as_str())).collect();
    assert!(missing.is_empty(), "docs/glossary.md lacks types that more than two crates define:\n{missing:#?}");
}

#[test]
fn phrases_are_found_where_they_wrap() {
    let found = |text, extension| -> Vec<_> {
        phrases(text, extension).into_iter().map(|Finding { line, phrase, .. }| (line, phrase)).collect()
    };
    assert_eq!(
        found("/* Fails at handles that are none, those\n * that fail. */", "h"),
        [(1, "are none"), (1, "those that")]
    );
    assert_eq!(found("Those who read.\n\nA host\nis told.", "md"), [(1, "those who"), (4, "is told")]);
    assert_eq!(
        found("    \"\"\"(Lets go of) it; `points` are None.\"\"\"\n# What is\n# kept", "py"),
        [(1, "lets go of"), (2, "what is kept")]
    );
    // Code is no prose, a paragraph ends a phrase, and other words are no phrase.
    for extension in ["rs", "wgsl"] {
        assert_eq!(found("let x = \"is told\";\n/// are\n///\n/// none\n// is\nlet told = 1;", extension), []);
        assert_eq!(found("let x = 1;\n// Those\n// that", extension), [(2, "those that")]);
    }
    assert_eq!(found("are nonetheless, let. Go of; this told is_told", "md"), []);
    assert_eq!(found("/// Knows\n/// nothing.", "rs"), [(1, "knows nothing")]);
    assert_eq!(term("AnyMeshLevel"), "any mesh level");
    assert_eq!(declared("pub struct Mesh<'a> {"), Some("Mesh"));
    assert_eq!(declared("    pub struct Mesh;"), None);
}
