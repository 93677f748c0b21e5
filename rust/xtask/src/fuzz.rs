//! Fuzz targets: libFuzzer on stable Rust. `tests/fuzz/instrument` wraps the compiler and adds the coverage passes to
//! our own crates only.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::thread;
use std::time::Instant;

use crate::stage::{Outcome, call, cargo, root, target};

/// Memory a target may use, in MiB: more than any input of `LENGTH` bytes justifies.
const MEMORY: u32 = 2048;
/// Seconds one input may take.
const TIMEOUT: u32 = 10;
/// Bytes of the longest input.
const LENGTH: u32 = 32 << 10;

/// Builds every target.
pub fn build() -> Outcome {
    let fuzz = root().join("tests/fuzz");
    let mut command = cargo();
    command
        .args(["build", "--release", "--manifest-path"])
        .arg(fuzz.join("Cargo.toml"))
        .env("RUSTC_WRAPPER", fuzz.join("instrument"))
        .env("CARGO_TARGET_DIR", target());
    call(&mut command)
}

/// Runs the targets called `names`, or all, `seconds` each and as many at a time as there are cores. Each starts from
/// its seeds in `tests/fuzz/seeds` and what earlier runs found.
pub fn run(names: &[String], seconds: u32, seed: Option<u32>) -> Outcome {
    let known = targets()?;
    if let Some(name) = names.iter().find(|name| !known.contains(name)) {
        return Err(format!("there is no fuzz target `{name}`; there are {}", known.join(", ")));
    }
    let chosen = if names.is_empty() { &known } else { names };
    let waiting = Mutex::new(chosen.iter().rev().collect::<Vec<_>>());
    let failed = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while let Some(name) = lock(&waiting).pop() {
                    let start = Instant::now();
                    let outcome = fuzz(name, seconds, seed);
                    let time = start.elapsed().as_secs();
                    match outcome {
                        Ok(summary) => println!("fuzz {name}: {summary}, {time} s"),
                        Err(message) => {
                            eprintln!("fuzz {name}: FAILED after {time} s\n{message}");
                            lock(&failed).push(name.clone());
                        }
                    }
                }
            });
        }
    });
    let mut failed = failed.into_inner().unwrap_or_default();
    failed.sort();
    if failed.is_empty() { Ok(()) } else { Err(format!("an input breaks {}", failed.join(", "))) }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// The targets: one per file of `src/bin`, called `fuzz_NAME.rs`.
fn targets() -> Result<Vec<String>, String> {
    let folder = root().join("tests/fuzz/src/bin");
    let entries = fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let names = entries.flatten().filter_map(|entry| {
        let name = entry.file_name().into_string().ok()?;
        Some(name.strip_prefix("fuzz_")?.strip_suffix(".rs")?.to_owned())
    });
    let mut names: Vec<_> = names.collect();
    names.sort();
    Ok(names)
}

/// Runs one target and returns how many inputs it tried, or the end of its log.
fn fuzz(name: &str, seconds: u32, seed: Option<u32>) -> Result<String, String> {
    let work = target().join("fuzz").join(name);
    let corpus = work.join("corpus");
    fs::create_dir_all(&corpus).map_err(|error| format!("{}: {error}", corpus.display()))?;
    let log = work.join("log");
    let open = || File::create(&log).map_err(|error| format!("{}: {error}", log.display()));
    let mut command = Command::new(target().join("release").join(format!("fuzz_{name}")));
    command
        .current_dir(&work)
        .arg(format!("-max_total_time={seconds}"))
        .arg(format!("-timeout={TIMEOUT}"))
        .arg(format!("-rss_limit_mb={MEMORY}"))
        .arg(format!("-max_len={LENGTH}"))
        .arg(format!("-artifact_prefix={}/", work.display()))
        .arg("-print_final_stats=1")
        .arg(&corpus)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(open()?);
    if let Some(seed) = seed {
        command.arg(format!("-seed={seed}"));
    }
    let seeds: PathBuf = root().join("tests/fuzz/seeds").join(name);
    if seeds.is_dir() {
        command.arg(seeds);
    }
    let status = command.status().map_err(|error| format!("cannot start the target: {error}"))?;
    let text = read(&log);
    if !status.success() {
        let end: Vec<_> = text.lines().rev().take(40).collect();
        let end: Vec<_> = end.into_iter().rev().collect();
        return Err(format!("{}\nthe input is in {}", end.join("\n"), work.display()));
    }
    let executed = text.lines().find_map(|line| line.strip_prefix("stat::number_of_executed_units:"));
    Ok(format!("{} inputs", executed.map_or("?", str::trim)))
}

fn read(path: &Path) -> String {
    fs::read(path).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default()
}
