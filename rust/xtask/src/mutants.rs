//! `cargo xtask mutants`: changes the code of kernels at places that are drawn by a stated seed, and counts the changes
//! that a test notices (mutation testing; DeMillo, Lipton and Sayward 1978). All changes are in one build, where a variable
//! of the environment chooses one (mutant schemata; Untch, Offutt and Harrold 1993).

mod edits;
mod list;
mod run;
mod tree;
mod weave;

use std::collections::BTreeMap;
use std::fmt::Write as _;

use self::list::{Mutant, draw, install, list};
use self::run::{Known, Results, Verdict, judge, know};
use self::tree::{Left, Tree, digest};
use crate::stage::{Outcome, target};

/// The share of mutants that tests should catch.
const GOAL: f64 = 0.95;

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

/// Mutants of a shard: how many exist, and the drawn ones by their numbers.
#[derive(Default)]
struct Shard {
    name: &'static str,
    tests: &'static [&'static str],
    total: usize,
    drawn: Vec<(u32, Mutant)>,
}

/// Draws `count` mutants of the crates in `names`, or of the usual ones, by `seed`, runs the tests on each, and prints a
/// table. Goes on where a run of the same mutants in the same code was stopped. Fails if fewer than the goal are caught;
/// mutants that do not compile or cannot be woven do not count.
pub fn run(names: &[String], count: usize, seed: u64) -> Outcome {
    let names: Vec<&str> = if names.is_empty() { USUAL.to_vec() } else { names.iter().map(String::as_str).collect() };
    let program = install()?;
    let mut shards = Vec::new();
    let mut all = Vec::new();
    for name in &names {
        let known = SHARDS.iter().find(|(shard, _)| shard == name);
        let (name, tests) =
            known.ok_or_else(|| format!("{name} is no shard; use {}", SHARDS.map(|it| it.0).join(", ")))?;
        let mutants = list(&program, name)?;
        all.extend(mutants.iter().map(|mutant| (shards.len(), mutant.clone())));
        shards.push(Shard { name, tests, total: mutants.len(), drawn: Vec::new() });
    }
    for (number, (shard, mutant)) in (1..).zip(draw(all, count, seed)) {
        shards[shard].drawn.push((number, mutant));
    }
    let folder = target().join("mutants");
    let head = format!("count {count}, seed {seed}, crates {}, code {:016x}", names.join(" "), digest()?);
    let mut results = Results::open(folder.join(format!("results-{}-{count}-{seed}.txt", names.join("-"))), &head)?;
    if shards.iter().flat_map(|shard| &shard.drawn).any(|(_, mutant)| results.of(&mutant.name).is_none()) {
        test(&shards, &mut results)?;
    }
    let (table, share) = table(&shards, &results);
    println!("\nseed {seed}\n{table}");
    if share < GOAL { Err(format!("{:.1} % are caught, below {:.0} %", share * 100.0, GOAL * 100.0)) } else { Ok(()) }
}

/// Builds the mutants into one copy of the workspace, and runs the tests of a shard after the other on mutants that have
/// no result.
fn test(shards: &[Shard], results: &mut Results) -> Outcome {
    let drawn: BTreeMap<u32, &Mutant> =
        shards.iter().flat_map(|shard| &shard.drawn).map(|(number, mutant)| (*number, mutant)).collect();
    let mut packages: Vec<&str> =
        shards.iter().filter(|shard| !shard.drawn.is_empty()).flat_map(|shard| shard.tests).copied().collect();
    packages.sort_unstable();
    packages.dedup();
    let is_left = |verdict: &Verdict| matches!(verdict, Verdict::Unviable(_) | Verdict::Unwoven(_));
    let mut woven = drawn.clone();
    woven.retain(|_, mutant| !results.of(&mutant.name).is_some_and(is_left));
    let tree = Tree::new(drawn.len() + 1)?;
    let mut known: Vec<Known> = Vec::new();
    // What takes the shortest build comes first.
    let mut shards: Vec<&Shard> = shards.iter().collect();
    shards.sort_by_key(|shard| shard.tests.len());
    for shard in shards {
        if shard.drawn.iter().all(|(_, mutant)| results.of(&mutant.name).is_some()) {
            continue;
        }
        let built = tree.build(&mut woven, &packages, shard.tests, |number, left| {
            let verdict = match left {
                Left::Unviable(why) => Verdict::Unviable(why),
                Left::Unwoven(why) => Verdict::Unwoven(why),
            };
            drawn.get(&number).map_or(Ok(()), |mutant| results.add(&mutant.name, verdict))
        })?;
        for test in built {
            if !known.iter().any(|it| it.test == test) {
                known.push(know(test)?);
            }
        }
        let of = |package: &&str| known.iter().filter(|known| known.test.package == **package).collect::<Vec<_>>();
        let tests: Vec<&Known> = shard.tests.iter().flat_map(of).collect();
        for (number, mutant) in &shard.drawn {
            if results.of(&mutant.name).is_none() {
                results.add(&mutant.name, judge(*number, &tests)?)?;
            }
        }
    }
    Ok(())
}

/// Returns a table of shards with the names of missed mutants below it, and the share that is caught. A mutant that runs
/// too long is noticed too.
fn table(shards: &[Shard], results: &Results) -> (String, f64) {
    let mut text = format!(
        "{:<10} {:>8} {:>6} {:>7} {:>7} {:>9} {:>9} {:>8} {:>7}\n",
        "crate", "mutants", "drawn", "caught", "missed", "timeouts", "unviable", "unwoven", "share"
    );
    let mut row = |name: &str, counts: [usize; 7]| {
        let [total, drawn, caught, missed, timeout, unviable, unwoven] = counts;
        let noticed = caught + timeout;
        let share = if noticed + missed == 0 { 1.0 } else { noticed as f64 / (noticed + missed) as f64 };
        let percent = format!("{:.1} %", share * 100.0);
        let _ = writeln!(
            text,
            "{name:<10} {total:>8} {drawn:>6} {caught:>7} {missed:>7} {timeout:>9} {unviable:>9} {unwoven:>8} {percent:>7}"
        );
        share
    };
    let mut sums = [0; 7];
    let mut below = String::new();
    for shard in shards {
        let mut counts = [shard.total, shard.drawn.len(), 0, 0, 0, 0, 0];
        for (_, mutant) in &shard.drawn {
            let name = &mutant.name;
            counts[match results.of(name) {
                Some(Verdict::Caught(_)) => 2,
                Some(Verdict::Missed { is_reached }) => {
                    let note = if *is_reached { "" } else { " (no test runs it)" };
                    let _ = writeln!(below, "missed: {name}{note}");
                    3
                }
                Some(Verdict::Timeout(_)) => 4,
                Some(Verdict::Unviable(_)) => 5,
                Some(Verdict::Unwoven(why)) => {
                    let _ = writeln!(below, "unwoven: {name}: {why}");
                    6
                }
                None => continue,
            }] += 1;
        }
        sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        row(shard.name, counts);
    }
    let share = row("all", sums);
    (text + &below, share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_counts_timeouts_as_noticed_and_leaves_out_what_does_not_compile_or_is_not_woven() {
        let path = std::env::temp_dir().join(format!("relievo-table-{}", std::process::id()));
        let mut results = Results::open(path.clone(), "").unwrap();
        let mut shard = |name, verdicts: Vec<Verdict>| {
            let mut drawn = Vec::new();
            for (number, verdict) in (1..).zip(verdicts) {
                let mutant = Mutant { name: format!("{name}.rs:{number}:1: replace f"), ..Mutant::default() };
                results.add(&mutant.name, verdict).unwrap();
                drawn.push((number, mutant));
            }
            Shard { name, tests: &[], total: 90, drawn }
        };
        let mut verdicts = vec![Verdict::Caught("tiles: a".into()); 16];
        verdicts.push(Verdict::Missed { is_reached: false });
        verdicts.extend(vec![Verdict::Timeout("tiles".into()); 2]);
        verdicts.extend(vec![Verdict::Unviable("no such method".into()); 3]);
        verdicts.push(Verdict::Unwoven("constant".into()));
        let shards = [shard("tiles", verdicts), shard("lod", vec![Verdict::Caught("lod: b".into())])];
        let (text, share) = table(&shards, &results);
        assert!((share - 19.0 / 20.0).abs() < 1e-12, "{share}");
        let last: Vec<_> = text.lines().find(|line| line.starts_with("all")).unwrap().split_whitespace().collect();
        assert_eq!(last, ["all", "180", "24", "17", "1", "2", "3", "1", "95.0", "%"]);
        let below = "missed: tiles.rs:17:1: replace f (no test runs it)\nunwoven: tiles.rs:23:1: replace f: constant\n";
        assert!(text.ends_with(below), "{text}");
        assert!((table(&[], &results).1 - 1.0).abs() < f64::EPSILON);
        std::fs::remove_file(path).unwrap();
    }
}
