//! Makes a copy of the workspace with mutants in it, and builds its tests.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use super::edits::Site;
use super::list::Mutant;
use super::weave::{Mark, byte, culprit, module, weave};
use crate::stage::{cargo, output, root, shown, target};
use crate::suite::surroundings;

/// A program with tests.
#[derive(Clone, PartialEq)]
pub struct Test {
    /// The crate, as `SHARDS` names it.
    pub package: String,
    /// The folder of the crate, where the program runs.
    pub folder: PathBuf,
    pub program: PathBuf,
}

/// A copy of the workspace.
pub struct Tree {
    folder: PathBuf,
    /// The files, from the folder of the workspace.
    files: Vec<String>,
    /// The numbers of mutants are below it.
    count: usize,
}

/// A mutant that is not run, and why.
pub enum Left {
    /// It does not compile.
    Unviable(String),
    /// Its code is no choice while the program runs.
    Unwoven(String),
}

fn fault(path: &Path, error: impl std::fmt::Display) -> String {
    format!("{}: {error}", path.display())
}

/// Returns a number that differs where the code does, except this program's.
pub fn digest() -> Result<u64, String> {
    let mut hasher = DefaultHasher::new();
    let counts = |name: &&String| {
        let extension = Path::new(name).extension().unwrap_or_default();
        let is_code = ["rs", "toml", "wgsl", "cpp", "h", "lock"].iter().any(|it| extension == *it);
        is_code && !name.starts_with("rust/xtask")
    };
    for name in files()?.iter().filter(counts) {
        let path = root().join(name);
        (name, std::fs::read(&path).map_err(|error| fault(&path, error))?).hash(&mut hasher);
    }
    Ok(hasher.finish())
}

/// The files of the workspace that Git knows or would add.
fn files() -> Result<Vec<String>, String> {
    let mut git = Command::new("git");
    git.args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"]).current_dir(root());
    let list = output(&mut git)?;
    let names = list.split('\0').filter(|name| !name.is_empty() && root().join(name).is_file());
    Ok(names.map(str::to_owned).collect())
}

impl Tree {
    /// Makes the copy below the folder that Cargo builds into, for mutants of numbers below `count`, and begins its build
    /// with what Cargo has built.
    pub fn new(count: usize) -> Result<Self, String> {
        let tree = Self { folder: target().join("mutants/tree"), files: files()?, count };
        let built = tree.target().join("release");
        if !built.exists() {
            println!("copying the build to {}", built.display());
            copy_build(&target().join("release"), &built)?;
        }
        Ok(tree)
    }

    fn target(&self) -> PathBuf {
        self.folder.with_file_name("build")
    }

    /// Writes the files with their mutants, and so that only the tests of `packages` are built. Returns where the mutants
    /// are, by file, and the ones that cannot be woven.
    fn write(
        &self,
        mutants: &BTreeMap<u32, &Mutant>,
        packages: &[&str],
    ) -> Result<(BTreeMap<String, Vec<Mark>>, Vec<(u32, Left)>), String> {
        let crates: BTreeSet<String> = mutants.values().filter_map(|mutant| library(&mutant.file)).collect();
        let programs: Vec<&str> = packages.iter().flat_map(|package| self.programs(package)).collect();
        let is_new = !self.folder.exists();
        let mut marks = BTreeMap::new();
        let mut left = Vec::new();
        for name in &self.files {
            let path = root().join(name);
            let bytes = std::fs::read(&path).map_err(|error| fault(&path, error))?;
            let mut changed = None;
            let inside: Vec<_> = mutants.iter().filter(|(_, mutant)| mutant.file == *name).collect();
            if !inside.is_empty() || crates.contains(name) {
                let text = std::str::from_utf8(&bytes).map_err(|error| fault(&path, error))?;
                let site = |(number, mutant): &(&u32, &&Mutant)| {
                    let start = byte(text, mutant.start).ok_or_else(|| fault(&path, "it has no such place"))?;
                    let (genre, replacement) = (mutant.genre.clone(), mutant.replacement.clone());
                    Ok(Site { number: **number, genre, replacement, start })
                };
                let sites: Vec<Site> = inside.iter().map(site).collect::<Result<_, String>>()?;
                let mut woven = weave(text, &sites).map_err(|error| fault(&path, error))?;
                if crates.contains(name) {
                    woven.text.push_str(&module(self.count));
                }
                left.extend(woven.refused.iter().map(|(number, why)| (*number, Left::Unwoven((*why).to_owned()))));
                marks.insert(name.clone(), woven.marks);
                changed = Some(woven.text.into_bytes());
            } else if let Some(package) = package(name) {
                let text = String::from_utf8_lossy(&bytes);
                if !packages.contains(&package) {
                    // Another crate's tests may have the same name.
                    let has_same = self.programs(package).iter().any(|name| programs.contains(name));
                    let untested = || text.replacen("[package]\n", "[package]\nautotests = false\n", 1);
                    changed = has_same.then(|| untested().into_bytes());
                } else if self.has_units(package) {
                    changed = Some(with_units(&text, package).into_bytes());
                }
            }
            let changed = changed.filter(|changed| *changed != bytes);
            put(&path, &self.folder.join(name), changed.as_deref().unwrap_or(&bytes), changed.is_some())?;
        }
        if is_new {
            self.date_folders()?;
        }
        Ok((marks, left))
    }

    /// Gives folders the times of the source's: build scripts run again after a change of some.
    fn date_folders(&self) -> Result<(), String> {
        let folders: BTreeSet<&Path> = self.files.iter().flat_map(|name| Path::new(name).ancestors().skip(1)).collect();
        for folder in folders {
            let copy = self.folder.join(folder);
            let time = std::fs::metadata(root().join(folder)).and_then(|it| it.modified());
            time.and_then(|time| std::fs::File::open(&copy)?.set_modified(time))
                .map_err(|error| fault(&copy, error))?;
        }
        Ok(())
    }

    /// Writes the files with their mutants and builds the tests of `tested`, which are among `packages`, until all mutants
    /// in them compile. `leave` hears of the others, which go.
    pub fn build(
        &self,
        mutants: &mut BTreeMap<u32, &Mutant>,
        packages: &[&str],
        tested: &[&str],
        mut leave: impl FnMut(u32, Left) -> Result<(), String>,
    ) -> Result<Vec<Test>, String> {
        loop {
            let (marks, left) = self.write(mutants, packages)?;
            if !left.is_empty() {
                for (number, why) in left {
                    mutants.remove(&number);
                    leave(number, why)?;
                }
                continue;
            }
            let mut build = cargo();
            build.args(["test", "--release", "--no-run", "--message-format", "json"]);
            build.arg("--workspace");
            for package in tested {
                let units = self.has_units(package).then(|| units(package));
                for name in self.programs(package).into_iter().map(str::to_owned).chain(units) {
                    build.args(["--test", &name]);
                }
            }
            build.current_dir(&self.folder).env("CARGO_TARGET_DIR", self.target());
            surroundings(&mut build);
            let line = shown(&build);
            println!("{line}");
            let ended = build.stderr(Stdio::inherit()).output().map_err(|error| fault(&self.folder, error))?;
            let text = String::from_utf8_lossy(&ended.stdout);
            let messages = || text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
            if ended.status.success() {
                return Ok(messages().filter_map(|message| test(&message, tested)).collect());
            }
            let mut causes = BTreeMap::new();
            let mut unknown = String::new();
            for message in messages().map(|it| it["message"].clone()).filter(|it| it["level"] == "error") {
                match blame(&message, &marks) {
                    Some((number, why)) => drop(causes.entry(number).or_insert(why)),
                    None => unknown.push_str(message["rendered"].as_str().unwrap_or_default()),
                }
            }
            if causes.is_empty() {
                return Err(format!("`{line}` ended with {}\n{unknown}", ended.status));
            }
            for (number, why) in causes {
                mutants.remove(&number);
                leave(number, why)?;
            }
        }
    }

    /// Returns the names of the programs with tests of a crate.
    fn programs(&self, package: &str) -> Vec<&str> {
        let folder = format!("rust/{package}/tests/");
        let name = |file: &'_ String| -> Option<usize> {
            let rest = file.strip_prefix(&folder)?;
            let name = rest.strip_suffix("/main.rs").or_else(|| rest.strip_suffix(".rs"))?;
            (!name.contains('/')).then_some(name.len())
        };
        self.files.iter().filter_map(|file| Some(&file[folder.len()..folder.len() + name(file)?])).collect()
    }

    /// Returns whether a crate has tests within its library.
    fn has_units(&self, package: &str) -> bool {
        let folder = format!("rust/{package}/src/");
        let mut files = self.files.iter().filter(|name| name.starts_with(&folder) && name.ends_with(".rs"));
        files.any(|name| std::fs::read_to_string(root().join(name)).is_ok_and(|text| text.contains("#[test]")))
    }
}

/// Reads a message of Cargo about a program with tests of one of the crates.
fn test(message: &Value, packages: &[&str]) -> Option<Test> {
    let folder = PathBuf::from(message["manifest_path"].as_str()?).parent()?.to_owned();
    let package = packages.iter().find(|package| folder.ends_with(Path::new("rust").join(package)))?;
    let program = message["executable"].as_str().filter(|_| message["profile"]["test"] == true)?;
    Some(Test { package: (*package).to_owned(), folder, program: program.into() })
}

/// Returns the root of the library that a file belongs to.
fn library(file: &str) -> Option<String> {
    let (folder, _) = file.split_once("/src/")?;
    Some(format!("{folder}/src/lib.rs"))
}

/// Returns the crate whose manifest a file is.
fn package(file: &str) -> Option<&str> {
    file.strip_prefix("rust/")?.strip_suffix("/Cargo.toml")
}

/// Returns the name of the program with the tests within a crate's library.
fn units(package: &str) -> String {
    format!("{package}_units")
}

/// Returns a manifest with the tests within the library as a program of its own: Cargo has no name for those of one crate
/// where it builds with the features of all.
fn with_units(manifest: &str, package: &str) -> String {
    format!("{manifest}\n[[test]]\nname = \"{}\"\npath = \"src/lib.rs\"\n", units(package))
}

/// Writes a file where the one that is there differs. One that is new has the time of the source, if it is like it, so that
/// Cargo takes over what is built of it.
fn put(source: &Path, path: &Path, bytes: &[u8], is_changed: bool) -> Result<(), String> {
    let before = std::fs::read(path).ok();
    if before.as_deref() == Some(bytes) {
        return Ok(());
    }
    let write = || {
        std::fs::create_dir_all(path.parent().unwrap_or(path))?;
        std::fs::write(path, bytes)?;
        let metadata = std::fs::metadata(source)?;
        std::fs::set_permissions(path, metadata.permissions())?;
        if before.is_none() && !is_changed {
            std::fs::File::options().append(true).open(path)?.set_modified(metadata.modified()?)?;
        }
        Ok(())
    };
    write().map_err(|error: std::io::Error| fault(path, error))
}

/// Copies a build. Libraries and programs are links to the same bytes, as Cargo and the compiler replace such files;
/// others are copies, as they are written again in place.
fn copy_build(from: &Path, to: &Path) -> Result<(), String> {
    let Ok(entries) = std::fs::read_dir(from) else { return Ok(()) };
    std::fs::create_dir_all(to).map_err(|error| fault(to, error))?;
    for path in entries.flatten().map(|entry| entry.path()) {
        let copy = to.join(path.file_name().unwrap_or_default());
        let is_output = from.ends_with("deps") && path.extension().is_none_or(|extension| extension != "d");
        if path.is_dir() {
            let wanted = ["deps", "build", ".fingerprint"].iter().any(|name| path.ends_with(name));
            if wanted || !from.ends_with("release") {
                copy_build(&path, &copy)?;
            }
        } else if is_output {
            std::fs::hard_link(&path, &copy).map_err(|error| fault(&copy, error))?;
        } else if !from.ends_with("release") {
            let write = || {
                std::fs::copy(&path, &copy)?;
                let time = std::fs::metadata(&path)?.modified()?;
                std::fs::File::open(&copy)?.set_modified(time)
            };
            write().map_err(|error: std::io::Error| fault(&copy, error))?;
        }
    }
    Ok(())
}

/// Returns the mutant that an error of the compiler is about.
fn blame(error: &Value, marks: &BTreeMap<String, Vec<Mark>>) -> Option<(u32, Left)> {
    let why = error["message"].as_str().unwrap_or_default().to_owned();
    let spans = error["spans"].as_array()?;
    let (primary, others): (Vec<&Value>, Vec<&Value>) = spans.iter().partition(|span| span["is_primary"] == true);
    let place = |span: &Value| {
        let number = |key: &str| usize::try_from(span[key].as_u64()?).ok();
        Some((span["file_name"].as_str()?.to_owned(), number("byte_start")?..number("byte_end")?))
    };
    let places: Vec<(String, Range<usize>)> = primary.into_iter().chain(others).filter_map(place).collect();
    let mark = places.iter().find_map(|(file, place)| culprit(marks.get(file)?, std::slice::from_ref(place)))?;
    // The types of both values differ.
    let is_mutated = mark.is_mutated || why.contains("incompatible types");
    Some((mark.number, if is_mutated { Left::Unviable(why) } else { Left::Unwoven(why) }))
}
