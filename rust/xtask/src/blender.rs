//! The Python package and the Blender extension: the wheel is made, and tested with PyPI's bpy and Debian's Blender.

use std::path::Path;
use std::process::Command;

use crate::stage::{Outcome, call, root, target};
use crate::wheel;

/// What the tests are run with; bpy 5.0 needs Python 3.11.
const PACKAGES: &[&str] = &["bpy==5.0.1", "numpy==1.26.4"];

/// Makes the wheel and runs `tests/python` with what it holds.
pub fn run() -> Outcome {
    let wheel = wheel::make()?;
    let folder = target().join("blender");
    let python = wheel::environment(&folder.join("bpy"), PACKAGES)?;
    let site = folder.join("wheel");
    unpack(&python, &wheel, &site)?;
    python_tests(&python, &site)
}

/// Unpacks a wheel, which is all that installing a package without scripts is.
fn unpack(python: &Path, wheel: &Path, site: &Path) -> Outcome {
    if site.exists() {
        std::fs::remove_dir_all(site).map_err(|error| format!("{}: {error}", site.display()))?;
    }
    let install = ["-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--disable-pip-version-check"];
    call(Command::new(python).args(install).arg("--target").arg(site).arg(wheel))
}

fn python_tests(python: &Path, site: &Path) -> Outcome {
    let tests = root().join("tests/python");
    for name in ["test_abi.py", "test_nouns.py", "test_wheel.py"] {
        let mut command = Command::new(python);
        command.arg(tests.join(name)).env("PYTHONPATH", site).env_remove("RELIEVO_LIBRARY");
        call(command.env_remove("RELIEVO_EMBREE").env("PYTHONDONTWRITEBYTECODE", "1"))?;
    }
    Ok(())
}
