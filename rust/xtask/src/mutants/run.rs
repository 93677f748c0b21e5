//! Runs tests on mutants, one at a time, and keeps what became of each.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Write as _;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::tree::Test;
use super::weave::{CHOSEN, REACHED};
use crate::stage::target;
use crate::suite::surroundings;

/// A program is ended that takes more time of processors than so many times what it took without a mutant, and these
/// seconds. Other programs do not change that, so it may take so many times as long by the clock.
const TIMES: u32 = 3;
const SECONDS: u64 = 20;
/// KiB that a program may take, and units of 512 bytes of a file that it may write: a mutant may ask for all there are.
const LIMITS: &str = "ulimit -v 12582912; ulimit -f 2097152; ulimit -c 0; exec \"$0\"";

/// What became of a mutant.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// By which test.
    Caught(String),
    /// Whether a test runs its code.
    Missed { is_reached: bool },
    /// Which program ran too long.
    Timeout(String),
    /// Why it does not compile.
    Unviable(String),
    /// Why it cannot be chosen while the program runs.
    Unwoven(String),
}

/// What became of mutants, by name, in a file that grows a line at a time.
pub struct Results {
    path: PathBuf,
    pub known: Vec<(String, Verdict)>,
}

impl Results {
    /// Reads the file, or begins it anew if its first line is not `head`.
    pub fn open(path: PathBuf, head: &str) -> Result<Self, String> {
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        let mut known = Vec::new();
        match text.split_once('\n') {
            // A line without an end was being written when the run was stopped.
            Some((first, lines)) if first == head => {
                let whole = lines.rsplit_once('\n').map_or("", |(whole, _)| whole);
                known.extend(whole.lines().filter_map(parse));
                std::fs::write(&path, known.iter().fold(format!("{head}\n"), |text, it| text + &line(it)))
            }
            _ => std::fs::write(&path, format!("{head}\n")),
        }
        .map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Self { path, known })
    }

    pub fn of(&self, name: &str) -> Option<&Verdict> {
        self.known.iter().find(|(known, _)| known == name).map(|(_, verdict)| verdict)
    }

    /// Adds a line.
    pub fn add(&mut self, name: &str, verdict: Verdict) -> Result<(), String> {
        let entry = (name.to_owned(), verdict);
        print!("{}", line(&entry));
        let file = File::options().append(true).open(&self.path);
        let written = file.and_then(|mut file| file.write_all(line(&entry).as_bytes()));
        self.known.push(entry);
        written.map_err(|error| format!("{}: {error}", self.path.display()))
    }
}

fn line((name, verdict): &(String, Verdict)) -> String {
    let (word, detail) = match verdict {
        Verdict::Caught(by) => ("caught", by.as_str()),
        Verdict::Missed { is_reached: true } => ("missed", "reached"),
        Verdict::Missed { is_reached: false } => ("missed", "not reached"),
        Verdict::Timeout(by) => ("timeout", by.as_str()),
        Verdict::Unviable(why) => ("unviable", why.as_str()),
        Verdict::Unwoven(why) => ("unwoven", why.as_str()),
    };
    let clean = |text: &str| text.replace(['\n', '\t'], " ");
    format!("{word}\t{}\t{}\n", clean(name), clean(detail))
}

fn parse(line: &str) -> Option<(String, Verdict)> {
    let mut parts = line.splitn(3, '\t');
    let (word, name, detail) = (parts.next()?, parts.next()?, parts.next()?.to_owned());
    let verdict = match word {
        "caught" => Verdict::Caught(detail),
        "missed" => Verdict::Missed { is_reached: detail == "reached" },
        "timeout" => Verdict::Timeout(detail),
        "unviable" => Verdict::Unviable(detail),
        "unwoven" => Verdict::Unwoven(detail),
        _ => return None,
    };
    Some((name.to_owned(), verdict))
}

/// A program with tests that was run without a mutant.
pub struct Known {
    pub test: Test,
    limits: Limits,
    /// `None` where the program cannot say: one that is killed as it writes a byte too many of a file.
    reached: Option<BTreeSet<u32>>,
}

/// What a program may take: of processors, and by the clock.
#[derive(Clone, Copy)]
struct Limits {
    work: Duration,
    clock: Duration,
}

enum Ended {
    Passed,
    Failed(String),
    Late,
}

fn fault(path: &Path, error: impl std::fmt::Display) -> String {
    format!("{}: {error}", path.display())
}

/// Runs a program without a mutant, and keeps which mutants' code it reaches.
///
/// # Errors
/// Fails if a test fails.
pub fn know(test: Test) -> Result<Known, String> {
    let file = target().join("mutants/reached.txt");
    std::fs::write(&file, "").map_err(|error| fault(&file, error))?;
    let start = Instant::now();
    let hour = Duration::from_secs(3600);
    let limits = Limits { work: hour, clock: hour };
    let (mut ended, mut work) = run(&test, 0, Some(&file), limits)?;
    let says = matches!(ended, Ended::Passed);
    if !says {
        (ended, work) = run(&test, 0, None, limits)?;
    }
    let length = start.elapsed();
    let name = test.program.display();
    match ended {
        Ended::Passed => {}
        Ended::Failed(what) => return Err(format!("without a mutant, {name} fails: {what}")),
        Ended::Late => return Err(format!("without a mutant, {name} does not end")),
    }
    let text = std::fs::read_to_string(&file).map_err(|error| fault(&file, error))?;
    let reached = says.then(|| text.lines().filter_map(|line| line.parse().ok()).collect::<BTreeSet<u32>>());
    let count = reached.as_ref().map_or("unknown".to_owned(), |reached| reached.len().to_string());
    println!("{name}: {:.1} s, mutants reached: {count}", length.as_secs_f64());
    let work = TIMES * work + Duration::from_secs(SECONDS);
    let clock = TIMES * (TIMES * length + Duration::from_secs(SECONDS));
    Ok(Known { test, limits: Limits { work, clock }, reached })
}

/// Runs those of `tests` that reach a mutant, until one notices it.
pub fn judge(number: u32, tests: &[&Known]) -> Result<Verdict, String> {
    let mut is_reached = false;
    for known in tests {
        match &known.reached {
            Some(reached) if !reached.contains(&number) => continue,
            reached => is_reached |= reached.is_some(),
        }
        match run(&known.test, number, None, known.limits)?.0 {
            Ended::Passed => {}
            Ended::Failed(what) => return Ok(Verdict::Caught(format!("{}: {what}", known.test.package))),
            Ended::Late => return Ok(Verdict::Timeout(known.test.package.clone())),
        }
    }
    Ok(Verdict::Missed { is_reached })
}

/// Runs a program until it ends, a test fails, or it takes too long. Also returns the time that it took of processors.
fn run(test: &Test, number: u32, reached: Option<&Path>, limits: Limits) -> Result<(Ended, Duration), String> {
    let path = target().join("mutants/output.txt");
    let output = File::create(&path).map_err(|error| fault(&path, error))?;
    let both = output.try_clone().map_err(|error| fault(&path, error))?;
    let mut command = Command::new("sh");
    command.args(["-c", LIMITS]).arg(&test.program).current_dir(&test.folder).process_group(0);
    command.stdin(Stdio::null()).stdout(output).stderr(both);
    command.env(CHOSEN, number.to_string()).env_remove(REACHED).env("CARGO_MANIFEST_DIR", &test.folder);
    if let Some(reached) = reached {
        command.env(REACHED, reached);
    }
    surroundings(&mut command);
    let mut child = command.spawn().map_err(|error| fault(&test.program, error))?;
    let start = Instant::now();
    let mut work = Duration::ZERO;
    let ended = loop {
        work = work.max(worked(child.id()).unwrap_or_else(|| start.elapsed()));
        let status = child.try_wait().map_err(|error| fault(&test.program, error))?;
        // Another test may go on for long.
        let failed = failure(&path);
        match status {
            Some(status) if status.success() => break Ended::Passed,
            Some(status) => break Ended::Failed(failed.unwrap_or_else(|| status.to_string())),
            None => {}
        }
        if let Some(failed) = failed {
            break Ended::Failed(failed);
        }
        if work > limits.work || start.elapsed() > limits.clock {
            break Ended::Late;
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    end(&mut child);
    Ok((ended, work))
}

/// Returns the time that a program and its ended descendants took of processors, where the system has a file of it.
fn worked(id: u32) -> Option<Duration> {
    /// Ticks of a second, the same on all of Linux.
    const TICKS: u64 = 100;
    let text = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    // The name, in parentheses, may have spaces.
    let fields = text.rsplit_once(')')?.1.split_whitespace().skip(11).take(4);
    let ticks: u64 = fields.filter_map(|field| field.parse::<u64>().ok()).sum();
    Some(Duration::from_millis(ticks * 1000 / TICKS))
}

/// Ends a program and its descendants.
fn end(child: &mut Child) {
    let kill = format!("kill -KILL -{}", child.id());
    let _ = Command::new("sh").args(["-c", &kill]).stderr(Stdio::null()).status();
    let _ = child.wait();
}

/// Returns the first test that failed, by what the program has printed.
fn failure(output: &Path) -> Option<String> {
    let bytes = std::fs::read(output).ok()?;
    let text = String::from_utf8_lossy(&bytes);
    let name = |line: &str| Some(line.strip_prefix("test ")?.strip_suffix(" ... FAILED")?.to_owned());
    text.lines().find_map(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_go_on_after_a_stop_and_begin_anew_for_another_head() {
        let path = std::env::temp_dir().join(format!("relievo-results-{}", std::process::id()));
        let _ = std::fs::remove_file(&path);
        let mut results = Results::open(path.clone(), "seed 1").unwrap();
        let verdicts = [
            Verdict::Caught("tiles: a::b".into()),
            Verdict::Missed { is_reached: false },
            Verdict::Unviable("no such\nmethod".into()),
        ];
        for (index, verdict) in verdicts.iter().enumerate() {
            results.add(&format!("a.rs:{index}:1: replace f"), verdict.clone()).unwrap();
        }
        let mut file = File::options().append(true).open(&path).unwrap();
        file.write_all(b"caught\ta.rs:9:1: repl").unwrap();
        let read = Results::open(path.clone(), "seed 1").unwrap();
        assert_eq!(read.known.len(), 3);
        assert_eq!(read.of("a.rs:1:1: replace f"), Some(&verdicts[1]));
        assert_eq!(read.of("a.rs:2:1: replace f"), Some(&Verdict::Unviable("no such method".into())));
        assert!(Results::open(path.clone(), "seed 2").unwrap().known.is_empty());
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn work_of_processors_grows_and_that_of_no_program_is_unknown() {
        let before = worked(std::process::id()).unwrap();
        let sum = (0..200_000_000u64).fold(0u64, |sum, at| std::hint::black_box(sum ^ at.wrapping_mul(at)));
        assert!(worked(std::process::id()).unwrap() > before, "{sum}");
        assert_eq!(worked(u32::MAX), None);
    }

    #[test]
    fn a_failure_is_read_before_the_program_ends() {
        let path = std::env::temp_dir().join(format!("relievo-output-{}", std::process::id()));
        std::fs::write(&path, "running 2 tests\ntest a::b ... ok\ntest c::d ... FAILED\ntest e").unwrap();
        assert_eq!(failure(&path).as_deref(), Some("c::d"));
        std::fs::write(&path, "test a::b ... ok\n").unwrap();
        assert_eq!(failure(&path), None);
        std::fs::remove_file(path).unwrap();
    }
}
