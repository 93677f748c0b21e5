//! Tests of USD against OpenUSD, as PyPI has it, and against Blender without the add-on.

use std::path::Path;

use crate::blender;
use crate::stage::{Outcome, call, cargo, root, target};
use crate::wheel::environment;

/// What the tests are run with, apart from Blender: its OpenUSD and this one do not go into one process.
const PACKAGES: &[&str] = &["usd-core==26.11", "numpy==1.26.4"];

/// Builds the library and the command and runs the tests.
pub fn run() -> Outcome {
    call(cargo().args(["build", "--release", "--package", "relievo-capi", "--package", "relievo-cli"]))?;
    test()
}

/// Runs `tests/usd` with the library and the command that were built.
pub fn test() -> Outcome {
    let openusd = environment(&target().join("usd"), PACKAGES)?;
    script(&openusd, "test_usd.py")?;
    script(&blender::python()?, "test_blender.py")
}

fn script(python: &Path, name: &str) -> Outcome {
    let built = target().join("release");
    let mut command = blender::clean(python);
    command.arg(root().join("tests/usd").join(name));
    command.env("RELIEVO_COMMAND", built.join("relievo")).env("RELIEVO_LIBRARY", built.join("librelievo.so"));
    call(&mut command)
}
