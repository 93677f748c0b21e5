//! `cargo xtask bench NAME`: builds and runs `relievo-bench`, a program of its own because peers are native libraries.

use std::process::Command;

use crate::packages;
use crate::stage::{Outcome, call, cargo, root, target};

/// Runs the bench called `name` and prints a table, or JSON lines.
pub fn run(name: &str, json: bool) -> Outcome {
    if !json {
        packages::install(packages::ALL, false)?;
    }
    call(cargo().args(["build", "--release", "--quiet", "--package", "relievo-bench"]))?;
    let mut command = Command::new(target().join("release/relievo-bench"));
    command.current_dir(root()).arg(name);
    if json {
        command.arg("--json");
    }
    call(&mut command)
}
