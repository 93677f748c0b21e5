//! `cargo xtask bindings` and `cargo xtask docs`: what is made from C headers, by the tool in `rust/bindings`.

use std::process::Command;

use crate::packages;
use crate::stage::{Outcome, call, cargo, root, target};

/// Writes the declarations anew, or compares them with the headers if `check` is set.
pub fn run(check: bool) -> Outcome {
    tool(if check { &["--check"] } else { &[] })
}

/// Writes the pages of the C ABI to `target/docs`, and fails where a comment leaves something undocumented.
pub fn pages() -> Outcome {
    tool(&["--pages", &target().join("docs").to_string_lossy()])
}

/// Builds the tool and runs it. It is no dependency of this one, because bindgen takes most of a minute to build.
fn tool(arguments: &[&str]) -> Outcome {
    packages::install(packages::BINDINGS, false)?;
    // Of the whole workspace, so that the test command does not build its dependencies a second time.
    call(cargo().args(["build", "--release", "--workspace", "--bin", "bindings"]))?;
    call(Command::new(target().join("release/bindings")).current_dir(root()).args(arguments))
}
