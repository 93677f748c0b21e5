//! `cargo xtask bench NAME`: builds and runs `relievo-bench`, a program of its own because peers are native libraries;
//! `hosts` is a host in C++, since it measures what hosts see.

use std::process::Command;

use crate::packages;
use crate::stage::{Outcome, call, cargo, root, target};
use crate::suite;

/// Runs the bench called `name` and prints a table, or JSON lines.
pub fn run(name: &str, json: bool) -> Outcome {
    if !json {
        packages::install(packages::ALL, false)?;
    }
    let mut command = if name == "hosts" {
        call(cargo().args(["build", "--release", "--quiet", "--package", "relievo-capi"]))?;
        suite::build_host("embree_rate")?;
        Command::new(target().join("hosts/embree_rate"))
    } else {
        call(cargo().args(["build", "--release", "--quiet", "--package", "relievo-bench"]))?;
        let mut command = Command::new(target().join("release/relievo-bench"));
        command.arg(name);
        command
    };
    command.current_dir(root());
    if json {
        command.arg("--json");
    }
    call(&mut command)
}
