//! `cargo xtask demo`: from nothing to pictures of the shipped scene.

use std::process::Command;

use crate::packages;
use crate::stage::{Outcome, call, cargo, root, target};

/// Sets up, builds the `relievo` command and runs the scene on `device`.
pub fn run(yes: bool, device: &str) -> Outcome {
    packages::install(packages::BUILD, yes)?;
    call(cargo().args(["build", "--release", "--package", "relievo-cli"]))?;
    let scene = "examples/scenes/snow.toml";
    let out = "out/demo";
    let relievo = target().join("release/relievo");
    call(Command::new(relievo).current_dir(root()).args(["run", scene, "--out", out, "--device", device]))?;
    println!("\nThe pictures, the mesh, the tiles and the table are in {}.", root().join(out).display());
    println!("The scene is {scene}: change it and type `target/release/relievo run {scene} --out {out}`.");
    Ok(())
}
