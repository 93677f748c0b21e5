//! `cargo xtask demo`: from nothing to pictures of the shipped scene.

use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};

use crate::packages;
use crate::stage::{Outcome, call, cargo, root, target};

const SCENE: &str = "examples/scenes/snow.toml";
const OUT: &str = "out/demo";

/// Sets up, makes the pictures of the scene, and builds the `relievo` command. On the processor, a small program makes the
/// pictures before the command is compiled; on another `device`, the command makes them.
pub fn run(yes: bool, device: &str) -> Outcome {
    if device == "cpu" {
        scene_packages(yes)?;
        call(&mut program())?;
        call(Command::new(target().join("release/relievo-scene")).current_dir(root()).args([SCENE, OUT]))?;
        println!("\nThe pictures, the mesh, the tiles and the table are in {}.", root().join(OUT).display());
        println!("The command `relievo` is compiled next.\n");
    }
    packages::install(packages::BUILD, yes)?;
    // With the library selected, crates are built with the features that a build of everything gives them.
    call(cargo().args([
        "build",
        "--release",
        "--package",
        "relievo-cli",
        "--package",
        "relievo-capi",
        "--bin",
        "relievo",
    ]))?;
    if device != "cpu" {
        let relievo = target().join("release/relievo");
        call(
            Command::new(relievo).current_dir(root()).args(["scene", "run", SCENE, "--out", OUT, "--device", device]),
        )?;
        println!("\nThe pictures, the mesh, the tiles and the table are in {}.", root().join(OUT).display());
    }
    println!("\nThe scene is {SCENE}: change it and type `target/release/relievo scene run {SCENE} --out {OUT}`.");
    Ok(())
}

/// Installs the Debian packages that scenes need. Meanwhile Cargo compiles what needs none of them; crates that do need them
/// fail in that build, whose messages are dropped. It is ended with the installation, and the next build goes on from it.
fn scene_packages(yes: bool) -> Outcome {
    if packages::are_installed(packages::SCENE) {
        return Ok(());
    }
    let mut early = program();
    early.args(["--keep-going", "--quiet"]).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    // A group of its own, so that compilers end with it.
    let early = early.process_group(0).spawn();
    println!("What needs no package is compiled while packages are installed.");
    let installed = packages::install(packages::SCENE, yes);
    if let Ok(mut early) = early {
        let group = format!("-{}", early.id());
        // It fails where the build has ended before.
        drop(Command::new("kill").args(["-TERM", "--", &group]).stderr(Stdio::null()).status());
        early.wait().map_err(|error| error.to_string())?;
    }
    installed
}

/// Returns the build of the program that makes pictures of scenes on the processor.
fn program() -> Command {
    let mut build = cargo();
    build.args(["build", "--release", "--package", "relievo-scene", "--no-default-features"]);
    build.args(["--features", "relievo-scene/program,relievo-scene/rapier3d", "--bin", "relievo-scene"]);
    build
}
