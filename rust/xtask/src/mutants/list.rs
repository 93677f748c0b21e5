//! Lists mutants with cargo-mutants, and draws some of them by a seed.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::stage::{call, cargo, output, target};

/// cargo-mutants as crates.io has it.
const VERSION: &str = "27.1.0";

/// A change of the code, as cargo-mutants lists it.
#[derive(Clone, Debug, Default)]
pub struct Mutant {
    /// The file, the place and the change.
    pub name: String,
    /// The file, from the folder of the workspace.
    pub file: String,
    /// The kind of change.
    pub genre: String,
    /// What is written instead.
    pub replacement: String,
    /// Line and column of the first letter, both from 1; columns are letters.
    pub start: (usize, usize),
}

/// Installs cargo-mutants below the folder that Cargo builds into, if it is not there. Returns its path.
pub fn install() -> Result<PathBuf, String> {
    let folder = target().join("mutants");
    let program = folder.join("bin/cargo-mutants");
    let is_there = Command::new(&program).args(["mutants", "--version"]).output();
    if !is_there.is_ok_and(|it| String::from_utf8_lossy(&it.stdout).trim().ends_with(VERSION)) {
        let version = format!("={VERSION}");
        let mut install = cargo();
        call(install.args(["install", "--locked", "cargo-mutants", "--version", &version, "--root"]).arg(&folder))?;
    }
    Ok(program)
}

/// Lists the mutants of a crate of ours.
pub fn list(program: &Path, package: &str) -> Result<Vec<Mutant>, String> {
    // It calls Cargo, and inherits nothing of what Cargo says about this program.
    let base = cargo();
    let mut command = Command::new(program);
    command.args(["mutants", "--list", "--json", "--package", &format!("relievo-{package}")]);
    command.current_dir(base.get_current_dir().unwrap_or(Path::new(".")));
    for (name, value) in base.get_envs() {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
    parse(&output(&mut command)?)
}

/// Reads a list as cargo-mutants prints it.
fn parse(text: &str) -> Result<Vec<Mutant>, String> {
    let fault = |what: &str| format!("the list of cargo-mutants is not that of version {VERSION}: {what}");
    let list: Vec<Value> = serde_json::from_str(text).map_err(|error| fault(&error.to_string()))?;
    let read = |mutant: &Value| {
        let text = |key: &str| mutant[key].as_str().map(str::to_owned);
        let start = &mutant["span"]["start"];
        let number = |key: &str| usize::try_from(start[key].as_u64()?).ok();
        Some(Mutant {
            name: text("name")?,
            file: text("file")?,
            genre: text("genre")?,
            replacement: text("replacement")?,
            start: (number("line")?, number("column")?),
        })
    };
    list.iter().map(|mutant| read(mutant).ok_or_else(|| fault(&mutant.to_string()))).collect()
}

/// Draws `count` of `items` without replacement, all if they are fewer, and returns them in their order.
pub fn draw<T>(items: Vec<T>, count: usize, seed: u64) -> Vec<T> {
    let mut state = seed;
    let mut numbered: Vec<(u64, usize, T)> =
        items.into_iter().enumerate().map(|(index, item)| (next(&mut state), index, item)).collect();
    numbered.sort_by_key(|(number, index, _)| (*number, *index));
    numbered.truncate(count);
    numbered.sort_by_key(|(_, index, _)| *index);
    numbered.into_iter().map(|(.., item)| item).collect()
}

/// Returns the next number of SplitMix64 (Steele, Lea and Flood 2014).
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut mixed = *state;
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_draws_the_same_items_in_order_and_another_seed_others() {
        let items: Vec<u32> = (0..1000).collect();
        let drawn = draw(items.clone(), 50, 1);
        assert!(drawn.len() == 50 && drawn.is_sorted_by(|a, b| a < b), "{drawn:?}");
        assert_eq!(drawn, draw(items.clone(), 50, 1));
        assert_ne!(drawn, draw(items.clone(), 50, 2));
        assert_eq!(draw(items.clone(), 2000, 1), items);
        // The first number of SplitMix64 from 0.
        assert_eq!(next(&mut 0), 0xe220_a839_7b1d_cdaf);
    }

    #[test]
    fn a_list_is_read_and_one_of_another_form_is_an_error() {
        let text = r#"[{"diff": "", "file": "rust/a.rs", "function": null, "genre": "BinaryOperator",
            "name": "rust/a.rs:24:42: replace - with +", "package": "a", "replacement": "+",
            "span": {"end": {"column": 43, "line": 24}, "start": {"column": 42, "line": 24}}}]"#;
        let list = parse(text).unwrap();
        assert_eq!((list.len(), list[0].start, list[0].replacement.as_str()), (1, (24, 42), "+"));
        assert!(parse(&text.replace("genre", "kind")).is_err_and(|message| message.contains(VERSION)));
    }
}
