//! `cargo xtask demo`: from nothing to pictures of the shipped scene.

use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};

use crate::packages;
use crate::stage::{Outcome, call, cargo, root, target};

const SCENE: &str = "examples/scenes/snow.toml";
const OUT: &str = "out/demo";

/// Sets up, makes the pictures of the scene, and builds the `relievo` command. On the processor, a small program makes the
/// pictures, and the command, which is compiled after it, lacks USD, decals, the server and graphics devices, which are
/// half of its build; the last lines say how to add them. On another `device` the whole command is built and makes the
/// pictures.
pub fn run(yes: bool, device: &str) -> Outcome {
    if device != "cpu" {
        packages::install(packages::BUILD, yes)?;
        call(cargo().args(["build", "--release", "--package", "relievo-cli"]))?;
        let relievo = target().join("release/relievo");
        call(Command::new(relievo).current_dir(root()).args(["run", SCENE, "--out", OUT, "--device", device]))?;
        println!("\nThe pictures, the mesh, the tiles and the table are in {}.", root().join(OUT).display());
        return Ok(());
    }
    scene_packages(yes)?;
    call(&mut build("relievo-scene"))?;
    call(Command::new(target().join("release/relievo-scene")).current_dir(root()).args([SCENE, OUT]))?;
    println!("\nThe pictures, the mesh, the tiles and the table are in {}.", root().join(OUT).display());
    println!("The command `relievo` is compiled next.\n");
    packages::install(packages::BUILD, yes)?;
    call(&mut build("relievo"))?;
    println!("\nThe scene is {SCENE}: change it and type `target/release/relievo run {SCENE} --out {OUT}`.");
    println!(
        "This command has no USD, decals, server and graphics devices: `cargo build --release --package relievo-cli` adds them."
    );
    Ok(())
}

/// Installs the Debian packages that scenes need. Meanwhile Cargo compiles what needs none of them; crates that do need them
/// fail in that build, whose messages are dropped. It is ended with the installation, and the next build goes on from it.
fn scene_packages(yes: bool) -> Outcome {
    if packages::are_installed(packages::SCENE) {
        return Ok(());
    }
    let mut early = build("relievo-scene");
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

/// The build of a program for the processor. Both programs are selected each time, so that crates that they share are
/// compiled once, with the same features.
fn build(program: &str) -> Command {
    let mut build = cargo();
    build.args(["build", "--release", "--package", "relievo-scene", "--package", "relievo-cli", "--no-default-features"]);
    build.args(["--features", "relievo-cli/rapier3d,relievo-scene/program", "--bin", program]);
    build
}
