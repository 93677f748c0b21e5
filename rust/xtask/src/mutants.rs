//! `cargo xtask mutants`: changes the code of kernels at places that are drawn by a stated seed, and counts the changes
//! that a test notices (mutation testing; DeMillo, Lipton and Sayward 1978). It takes hours, and is no part of the tests.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::stage::{Outcome, call, cargo, output, shown, target};
use crate::suite::surroundings;

/// cargo-mutants as crates.io has it.
const VERSION: &str = "27.1.0";
/// The share of mutants that tests should catch.
const GOAL: f64 = 0.95;
/// Exit codes of cargo-mutants after a whole run: all are caught, some are missed, some run too long.
const WHOLE: [i32; 3] = [0, 2, 3];

/// Crates whose code is changed, and the crates whose tests are run: their own, and those above that test the same code.
const SHARDS: [(&str, &[&str]); 6] = [
    ("tiles", &["tiles", "detail", "bake"]),
    ("detail", &["detail", "scene"]),
    ("lod", &["lod"]),
    ("fluid", &["fluid", "simulation"]),
    ("document", &["document", "bake"]),
    ("ptex", &["ptex"]),
];
/// Shards to draw from where none is named.
const USUAL: [&str; 5] = ["tiles", "detail", "lod", "fluid", "document"];

/// Mutants of a shard: how many exist, and by their names what became of the drawn ones.
#[derive(Default)]
struct Shard {
    name: &'static str,
    total: usize,
    drawn: Vec<String>,
    caught: usize,
    missed: Vec<String>,
    timeout: usize,
    unviable: usize,
}

/// Draws `count` mutants of the crates in `names`, or of the usual ones, by `seed`, runs the tests on each, and prints a
/// table. Fails if fewer than the goal are caught; mutants that do not compile do not count.
pub fn run(names: &[String], count: usize, seed: u64) -> Outcome {
    let names: Vec<&str> = if names.is_empty() { USUAL.to_vec() } else { names.iter().map(String::as_str).collect() };
    let program = install()?;
    let mut shards = Vec::new();
    let mut all = Vec::new();
    for name in names {
        let known = SHARDS.iter().find(|(shard, _)| *shard == name);
        let (name, _) = known.ok_or_else(|| format!("{name} is no shard; use {}", SHARDS.map(|it| it.0).join(", ")))?;
        let mutants = list(&program, name)?;
        all.extend(mutants.iter().map(|mutant| (shards.len(), mutant.clone())));
        shards.push(Shard { name, total: mutants.len(), ..Shard::default() });
    }
    for (shard, mutant) in draw(all, count, seed) {
        shards[shard].drawn.push(mutant);
    }
    for shard in shards.iter_mut().filter(|shard| !shard.drawn.is_empty()) {
        test(&program, shard)?;
    }
    let (table, share) = table(&shards);
    println!("\nseed {seed}\n{table}");
    if share < GOAL { Err(format!("{:.1} % are caught, below {:.0} %", share * 100.0, GOAL * 100.0)) } else { Ok(()) }
}

/// Installs cargo-mutants below the folder that Cargo builds into, if it is not there. Returns its path.
fn install() -> Result<PathBuf, String> {
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

/// A command of cargo-mutants on a crate of ours.
fn mutants(program: &Path, package: &str) -> Command {
    // It calls Cargo, and inherits nothing of what Cargo says about this program.
    let base = cargo();
    let mut command = Command::new(program);
    command.arg("mutants").args(["--package", &format!("relievo-{package}")]);
    command.current_dir(base.get_current_dir().unwrap_or(Path::new(".")));
    for (name, value) in base.get_envs() {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
    command
}

/// Lists the mutants of a crate by their names, which have the file, the place and the change.
fn list(program: &Path, package: &str) -> Result<Vec<String>, String> {
    let lines = output(mutants(program, package).arg("--list"))?;
    Ok(lines.lines().map(str::to_owned).collect())
}

/// Draws `count` of `items` without replacement, all if they are fewer, and returns them in their order.
fn draw<T>(items: Vec<T>, count: usize, seed: u64) -> Vec<T> {
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

/// Returns the configuration of cargo-mutants that examines these mutants alone.
fn configuration(names: &[String]) -> String {
    let patterns = names.iter().map(|name| {
        let mut pattern = String::from("^");
        for letter in name.chars() {
            if r"\.+*?()|[]{}^$#&-~".contains(letter) {
                pattern.push('\\');
            }
            pattern.push(letter);
        }
        // A string of JSON is one of TOML.
        Value::from(pattern + "$").to_string()
    });
    format!("examine_re = [\n{}]\n", patterns.map(|pattern| format!("    {pattern},\n")).collect::<String>())
}

/// Runs the tests on each drawn mutant of a shard, in a copy of the workspace, and reads what became of it.
fn test(program: &Path, shard: &mut Shard) -> Outcome {
    let folder = target().join("mutants").join(shard.name);
    let failed = |path: &Path, error: std::io::Error| format!("{}: {error}", path.display());
    std::fs::create_dir_all(&folder).map_err(|error| failed(&folder, error))?;
    let file = folder.join("mutants.toml");
    std::fs::write(&file, configuration(&shard.drawn)).map_err(|error| failed(&file, error))?;
    let mut run = mutants(program, shard.name);
    run.args(["--profile", "release", "--config"]).arg(&file).arg("--output").arg(&folder);
    for package in SHARDS.iter().find(|(name, _)| *name == shard.name).map_or(&[][..], |(_, tests)| tests) {
        run.args(["--test-package", &format!("relievo-{package}")]);
    }
    surroundings(&mut run);
    let line = shown(&run);
    println!("\n{line}");
    let status = run.status().map_err(|error| format!("cannot start `{line}`: {error}"))?;
    if !status.code().is_some_and(|code| WHOLE.contains(&code)) {
        return Err(format!("`{line}` ended with {status}"));
    }
    let names = |name: &str| -> Result<Vec<String>, String> {
        let path = folder.join("mutants.out").join(name);
        let text = std::fs::read_to_string(&path).map_err(|error| failed(&path, error))?;
        Ok(text.lines().map(str::to_owned).collect())
    };
    shard.caught = names("caught.txt")?.len();
    shard.missed = names("missed.txt")?;
    shard.timeout = names("timeout.txt")?.len();
    shard.unviable = names("unviable.txt")?.len();
    let ended = shard.caught + shard.missed.len() + shard.timeout + shard.unviable;
    if ended == shard.drawn.len() {
        Ok(())
    } else {
        Err(format!("{} of {} drawn mutants of {} were run", ended, shard.drawn.len(), shard.name))
    }
}

/// Returns a table of shards with the names of missed mutants below it, and the share that is caught. A mutant that runs
/// too long is noticed too.
fn table(shards: &[Shard]) -> (String, f64) {
    let mut text = format!(
        "{:<10} {:>8} {:>6} {:>7} {:>7} {:>9} {:>9} {:>7}\n",
        "crate", "mutants", "drawn", "caught", "missed", "timeouts", "unviable", "share"
    );
    let mut row = |name: &str, counts: [usize; 6]| {
        let [total, drawn, caught, missed, timeout, unviable] = counts;
        let noticed = caught + timeout;
        let share = if noticed + missed == 0 { 1.0 } else { noticed as f64 / (noticed + missed) as f64 };
        let percent = format!("{:.1} %", share * 100.0);
        let _ = writeln!(
            text,
            "{name:<10} {total:>8} {drawn:>6} {caught:>7} {missed:>7} {timeout:>9} {unviable:>9} {percent:>7}"
        );
        share
    };
    let mut sums = [0; 6];
    for shard in shards {
        let Shard { total, caught, timeout, unviable, .. } = *shard;
        let counts = [total, shard.drawn.len(), caught, shard.missed.len(), timeout, unviable];
        sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        row(shard.name, counts);
    }
    let share = row("all", sums);
    for missed in shards.iter().flat_map(|shard| &shard.missed) {
        let _ = writeln!(text, "missed: {missed}");
    }
    (text, share)
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
    fn a_configuration_has_each_name_as_a_pattern_of_itself() {
        let name = "rust/ptex/src/a.rs:3:5: replace f -> Result<Vec<u8>> with Ok(vec![\"a\"])".to_owned();
        let escaped = r#""^rust/ptex/src/a\\.rs:3:5: replace f \\-> Result<Vec<u8>> with Ok\\(vec!\\[\"a\"\\]\\)$""#;
        assert_eq!(configuration(&[name]), format!("examine_re = [\n    {escaped},\n]\n"));
    }

    #[test]
    fn a_table_counts_timeouts_as_noticed_and_leaves_out_what_does_not_compile() {
        let shard = |name, caught, missed: &[&str], timeout, unviable| Shard {
            name,
            total: 90,
            drawn: vec![String::new(); caught + missed.len() + timeout + unviable],
            caught,
            missed: missed.iter().map(|&name| name.to_owned()).collect(),
            timeout,
            unviable,
        };
        let (text, share) = table(&[shard("tiles", 16, &["a.rs:1:1: replace f"], 2, 3), shard("lod", 1, &[], 0, 0)]);
        assert!((share - 19.0 / 20.0).abs() < 1e-12, "{share}");
        let last: Vec<_> = text.lines().find(|line| line.starts_with("all")).unwrap().split_whitespace().collect();
        assert_eq!(last, ["all", "180", "23", "17", "1", "2", "3", "95.0", "%"]);
        assert!(text.ends_with("missed: a.rs:1:1: replace f\n"), "{text}");
        assert!((table(&[]).1 - 1.0).abs() < f64::EPSILON);
    }
}
