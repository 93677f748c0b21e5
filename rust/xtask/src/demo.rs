//! `cargo xtask demo`: from nothing to pictures of the shipped scene.

use std::process::Command;

use crate::packages;
use crate::stage::{Outcome, call, cargo, root, target};

/// Sets up, builds the `relievo` command and runs the scene on `device`. On the processor, the command is built without
/// USD, decals and graphics devices, which are half of the build; the last lines say how to add them.
pub fn run(yes: bool, device: &str) -> Outcome {
    packages::install(packages::BUILD, yes)?;
    let whole = device != "cpu";
    let mut build = cargo();
    build.args(["build", "--release", "--package", "relievo-cli"]);
    if !whole {
        build.args(["--no-default-features", "--features", "rapier3d"]);
    }
    call(&mut build)?;
    let scene = "examples/scenes/snow.toml";
    let out = "out/demo";
    let relievo = target().join("release/relievo");
    call(Command::new(relievo).current_dir(root()).args(["run", scene, "--out", out, "--device", device]))?;
    println!("\nThe pictures, the mesh, the tiles and the table are in {}.", root().join(out).display());
    println!("The scene is {scene}: change it and type `target/release/relievo run {scene} --out {out}`.");
    if !whole {
        println!(
            "This command has no USD, decals and graphics devices: `cargo build --release --package relievo-cli` adds them."
        );
    }
    Ok(())
}
