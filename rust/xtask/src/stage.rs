//! Commands run as stages: their output goes to the terminal, their time is kept and shown beside its budget.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// What a task returns: an error is a message for the contributor.
pub type Outcome = Result<(), String>;

/// The folder of the workspace.
pub fn root() -> PathBuf {
    let xtask = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    xtask.ancestors().nth(2).map_or(xtask.clone(), PathBuf::from)
}

/// The folder that Cargo builds into.
pub fn target() -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(folder) => root().join(folder),
        None => root().join("target"),
    }
}

/// A Cargo command in the folder of the workspace. It does not inherit what Cargo says about this program, since build
/// scripts that look at it would run again after every Cargo that was started by hand.
pub fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    let about = |name: &str| ["CARGO_PKG_", "CARGO_MANIFEST_"].iter().any(|prefix| name.starts_with(prefix));
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_str().is_some_and(about)) {
        command.env_remove(name);
    }
    command.current_dir(root());
    command
}

/// Runs a command to its end with its output shown; an error tells the command and how it ended.
pub fn call(command: &mut Command) -> Outcome {
    let line = shown(command);
    let status = command.status().map_err(|error| format!("cannot start `{line}`: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("`{line}` ended with {status}")) }
}

/// Runs a command to its end with its output shown; an error also has the lines that `is_cause` picks, which the summary of
/// all stages shows again.
pub fn watch(command: &mut Command, mut is_cause: impl FnMut(&str) -> bool) -> Outcome {
    let line = shown(command);
    let mut child =
        command.stdout(Stdio::piped()).spawn().map_err(|error| format!("cannot start `{line}`: {error}"))?;
    let mut causes = String::new();
    for printed in child.stdout.take().into_iter().flat_map(|stdout| BufReader::new(stdout).split(b'\n')) {
        let printed = printed.map_err(|error| format!("cannot read from `{line}`: {error}"))?;
        let printed = String::from_utf8_lossy(&printed);
        println!("{printed}");
        if is_cause(&printed) {
            causes.push('\n');
            causes.push_str(&printed);
        }
    }
    let status = child.wait().map_err(|error| format!("cannot wait for `{line}`: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("`{line}` ended with {status}{causes}")) }
}

/// Runs a command to its end and returns what it printed; its messages go to the terminal.
pub fn output(command: &mut Command) -> Result<String, String> {
    let line = shown(command);
    let output =
        command.stderr(Stdio::inherit()).output().map_err(|error| format!("cannot start `{line}`: {error}"))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(format!("`{line}` ended with {}", output.status))
    }
}

/// Returns the line that a command is.
pub fn shown(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    let words: Vec<_> = words.map(|word| word.to_string_lossy().into_owned()).collect();
    words.join(" ")
}

/// The stages run so far.
#[derive(Default)]
pub struct Stages {
    done: Vec<Stage>,
}

struct Stage {
    name: &'static str,
    minutes: u64,
    length: Duration,
    outcome: Outcome,
}

impl Stages {
    /// Runs `work` as the stage `name`, which should take at most `minutes`. Returns whether it went well.
    pub fn run(&mut self, name: &'static str, minutes: u64, work: impl FnOnce() -> Outcome) -> bool {
        println!("\n=== {name}");
        let start = Instant::now();
        let outcome = work();
        if let Err(message) = &outcome {
            eprintln!("error: {name}: {message}");
        }
        let good = outcome.is_ok();
        self.done.push(Stage { name, minutes, length: start.elapsed(), outcome });
        good
    }

    /// Prints every stage's time and fails if one of them failed.
    pub fn finish(self) -> Outcome {
        println!("\n{:<14} {:>8} {:>8}  result", "stage", "time", "budget");
        for stage in &self.done {
            let result = match &stage.outcome {
                Ok(()) => "passed",
                Err(_) => "FAILED",
            };
            println!("{:<14} {:>8} {:>8}  {result}", stage.name, clock(stage.length), format!("{}:00", stage.minutes));
        }
        let total = self.done.iter().map(|stage| stage.length).sum();
        let budget: u64 = self.done.iter().map(|stage| stage.minutes).sum();
        println!("{:<14} {:>8} {:>8}", "all", clock(total), format!("{budget}:00"));
        // Once more, since the first time is far above.
        let failure = |stage: &Stage| Some(format!("{}: {}", stage.name, stage.outcome.as_ref().err()?));
        let failed: Vec<_> = self.done.iter().filter_map(failure).collect();
        if failed.is_empty() { Ok(()) } else { Err(failed.join("\n")) }
    }
}

fn clock(length: Duration) -> String {
    let seconds = length.as_secs_f64().round() as u64;
    format!("{}:{:02}", seconds / 60, seconds % 60)
}
