//! The licences of other people's crates: whether they fit ours, and the notices that go with what is linked.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::Value;
use spdx::{Expression, ParseMode};

use crate::stage::{Outcome, cargo, output};

/// Licences under which a crate may be linked into something of ours, as `MIT OR Apache-2.0` asks.
const ACCEPTED: &[&str] = &[
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "ISC",
    "MIT",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];
/// The one place that crates may come from.
const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";
/// The crates that are handed out.
const SHIPPED: [&str; 2] = ["relievo-capi", "relievo-cli"];
/// How files with the text of a licence are called, in small letters.
const FILES: [&str; 5] = ["licen", "copying", "copyright", "unlicense", "notice"];

/// Fails if a crate that is built has a licence that does not fit, or comes from elsewhere than crates.io.
pub fn check() -> Outcome {
    let packages = packages()?;
    let faults: Vec<String> = packages.iter().filter_map(|package| package.fault().err()).collect();
    if !faults.is_empty() {
        return Err(faults.join("; "));
    }
    let text = notices(&packages)?;
    let linked = packages.iter().filter(|package| package.linked).count();
    println!(
        "{} crates, {linked} of them linked, have fitting licences; their notices are {} KiB",
        packages.len(),
        text.len() >> 10
    );
    Ok(())
}

/// Writes the licences of what is linked to a file.
pub fn write(path: &Path) -> Outcome {
    let text = notices(&packages()?)?;
    std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}

/// A crate of somebody else.
struct Package {
    name: String,
    version: String,
    licence: String,
    source: String,
    repository: String,
    authors: String,
    folder: PathBuf,
    /// Whether it becomes part of what is handed out.
    linked: bool,
}

impl Package {
    fn expression(&self) -> Result<Expression, String> {
        Expression::parse_mode(&self.licence, ParseMode::LAX)
            .map_err(|_| format!("{} {} says of its licence only {:?}", self.name, self.version, self.licence))
    }

    fn fault(&self) -> Outcome {
        let Self { name, version, licence, source, .. } = self;
        if source != REGISTRY {
            return Err(format!("{name} {version} is from {source}"));
        }
        let fits = self.expression()?.evaluate(|asked| ACCEPTED.contains(&asked.to_string().as_str()));
        if fits { Ok(()) } else { Err(format!("{name} {version} is licensed {licence}")) }
    }

    /// The texts of its licences: its own files, or where it has none the wording that its expression names.
    fn texts(&self) -> Result<Vec<String>, String> {
        let entries = std::fs::read_dir(&self.folder).map_err(|error| format!("{}: {error}", self.folder.display()))?;
        let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        files.retain(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
            path.is_file() && FILES.iter().any(|start| name.starts_with(start))
        });
        files.sort();
        let read = |path: &PathBuf| std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()));
        let own = files.iter().map(|path| Ok(String::from_utf8_lossy(&read(path)?).trim().to_owned()));
        let own: Vec<String> = own.collect::<Result<_, String>>()?;
        if !own.is_empty() {
            return Ok(own);
        }
        let expression = self.expression()?;
        let named = expression.requirements().filter_map(|asked| asked.req.license.id());
        Ok(named.map(|id| id.text().trim().to_owned()).collect())
    }
}

/// The crates of others that are built for this system.
fn packages() -> Result<Vec<Package>, String> {
    let platform = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    let list = ["metadata", "--format-version", "1", "--locked", "--filter-platform", platform.as_str()];
    let data: Value = serde_json::from_str(&output(cargo().args(list))?).map_err(|error| error.to_string())?;
    let array = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let nodes = array(&data["resolve"]["nodes"]);
    let all = array(&data["packages"]);
    // Crates that only build or test something are not handed out.
    let shipped = all.iter().filter(|package| SHIPPED.contains(&text(&package["name"]).as_str()));
    let mut waiting: Vec<String> = shipped.map(|package| text(&package["id"])).collect();
    let mut linked = BTreeSet::new();
    while let Some(id) = waiting.pop() {
        let Some(node) = nodes.iter().find(|node| node["id"] == id).filter(|_| linked.insert(id.clone())) else {
            continue;
        };
        let normal = |dependency: &Value| array(&dependency["dep_kinds"]).iter().any(|kind| kind["kind"].is_null());
        waiting.extend(array(&node["deps"]).iter().filter(|it| normal(it)).map(|it| text(&it["pkg"])));
    }
    let built: BTreeSet<String> = nodes.iter().map(|node| text(&node["id"])).collect();
    let others = all.iter().filter(|it| !it["source"].is_null() && built.contains(&text(&it["id"])));
    let mut packages: Vec<Package> = others
        .map(|package| Package {
            name: text(&package["name"]),
            version: text(&package["version"]),
            licence: text(&package["license"]),
            source: text(&package["source"]),
            repository: text(&package["repository"]),
            authors: array(&package["authors"]).iter().map(text).collect::<Vec<_>>().join(", "),
            folder: Path::new(&text(&package["manifest_path"])).parent().map(Path::to_owned).unwrap_or_default(),
            linked: linked.contains(&text(&package["id"])),
        })
        .collect();
    packages.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    Ok(packages)
}

/// The crates that are linked, and after them every text of a licence once, with those it is of.
fn notices(packages: &[Package]) -> Result<String, String> {
    let mut out = String::from("Relievo is linked with these crates, under the licences that follow.\n\n");
    let mut texts: Vec<(String, Vec<&str>)> = Vec::new();
    for package in packages.iter().filter(|package| package.linked) {
        let Package { name, version, licence, repository, authors, .. } = package;
        let by = if authors.is_empty() { String::new() } else { format!(", by {authors}") };
        let _ = writeln!(out, "{name} {version}: {licence}{by}. {repository}");
        let own = package.texts()?;
        if own.is_empty() {
            return Err(format!("{name} {version} has no text of its licence, and {licence} has none by itself"));
        }
        for text in own {
            match texts.iter_mut().find(|(known, _)| *known == text) {
                Some((_, names)) => names.push(name),
                None => texts.push((text, vec![name])),
            }
        }
    }
    for (text, names) in texts {
        let _ = write!(out, "\n{}\n{}\n\n{text}\n", "-".repeat(80), names.join(", "));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package(licence: &str, source: &str) -> Package {
        Package {
            name: "one".into(),
            version: "1.0.0".into(),
            licence: licence.into(),
            source: source.into(),
            repository: String::new(),
            authors: String::new(),
            folder: PathBuf::new(),
            linked: true,
        }
    }

    #[test]
    fn licences_fit_or_are_named() {
        for fits in ["MIT", "MIT/Apache-2.0", "GPL-3.0-only OR Zlib", "(MIT OR Apache-2.0) AND Unicode-3.0"] {
            assert_eq!(package(fits, REGISTRY).fault(), Ok(()), "{fits}");
        }
        for misfit in ["GPL-3.0-only", "MIT AND LGPL-2.1-only", "", "free of charge"] {
            assert!(package(misfit, REGISTRY).fault().is_err_and(|fault| fault.contains("one 1.0.0")), "{misfit}");
        }
        assert!(package("MIT", "git+https://example.org/one").fault().is_err());
    }
}
