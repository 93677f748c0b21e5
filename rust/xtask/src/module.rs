//! `cargo xtask module`: builds the module over OpenVDB into the folder of Cargo's build, where programs and tests find it.

use std::path::PathBuf;
use std::process::Command;

use crate::files::copy;
use crate::stage::{Outcome, call, root, target};

/// The file of the module.
pub const FILE: &str = "librelievo_openvdb.so";

/// Builds the module with CMake.
pub fn run() -> Outcome {
    let build = target().join("openvdb");
    let mut configure = Command::new("cmake");
    configure.arg("-S").arg(root().join("cpp/openvdb")).arg("-B").arg(&build);
    call(configure.args(["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release"]))?;
    call(Command::new("cmake").arg("--build").arg(&build))?;
    copy(&build.join(FILE), &path())?;
    println!("{}", path().display());
    Ok(())
}

/// Where it lies.
pub fn path() -> PathBuf {
    target().join("release").join(FILE)
}
