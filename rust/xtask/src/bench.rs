//! `cargo xtask bench NAME`: builds and runs `relievo-bench`, a program of its own because peers are native libraries;
//! `hosts` are programs in C++ and the add-on in Blender's Python, since it measures what hosts see, and the memory of
//! surfaces as estimated and as used.

use std::process::Command;

use serde_json::json;

use crate::files::{copy_files, remove};
use crate::stage::{Outcome, call, cargo, output, root, target};
use crate::suite;
use crate::{packages, peers};

/// Runs the bench called `name` and prints a table, or JSON lines.
pub fn run(name: &str, json: bool) -> Outcome {
    if !json {
        packages::install(packages::ALL, false)?;
    }
    if name == "hosts" {
        hosts(json)?;
        return run("memory", json);
    }
    call(cargo().args(["build", "--release", "--quiet", "--workspace", "--bin", "relievo-bench"]))?;
    let mut bench = Command::new(target().join("release/relievo-bench"));
    match name {
        "lod" => drop(bench.arg("--peers").arg(peers::make(json)?)),
        "fluid" | "dams" => drop(bench.arg("--peers").arg(peers::fluids(json)?)),
        "decal" => drop(bench.arg("--peers").arg(peers::decals()?)),
        "native" => drop(bench.arg("--peers").arg(peers::repairs()?)),
        _ => {}
    }
    measure(bench.arg(name), json)
}

fn measure(command: &mut Command, json: bool) -> Outcome {
    command.current_dir(root());
    if json {
        command.arg("--json");
    }
    call(command)
}

fn hosts(json: bool) -> Outcome {
    call(cargo().args(["build", "--release", "--quiet", "--package", "relievo-capi", "--package", "relievo-cli"]))?;
    for name in ["embree_rate", "call_rate"] {
        suite::build_host(name)?;
        measure(&mut Command::new(target().join("hosts").join(name)), json)?;
    }
    blender(json)
}

/// The figures of the add-on, where `cargo xtask blender` has made a Python with Blender in it. The add-on is that of the
/// sources, the library the one that was built last.
fn blender(json: bool) -> Outcome {
    let base = target().join("blender");
    let python = base.join("bpy/bin/python");
    if !python.exists() {
        eprintln!("skipped: the add-on in Blender: there is no {}; `cargo xtask blender` makes it", python.display());
        return Ok(());
    }
    let scripts = base.join("bench");
    let addon = scripts.join("addons/relievo");
    remove(&scripts)?;
    crate::blender::sources(&addon)?;
    copy_files(&root().join("plugins/python/librelievo"), &addon.join("librelievo"))?;
    let mut bench = Command::new(python);
    bench.arg(root().join("tests/blender/bench.py")).env("PYTHONDONTWRITEBYTECODE", "1").env_remove("PYTHONPATH");
    bench.env("BLENDER_USER_SCRIPTS", &scripts).env("RELIEVO_LIBRARY", target().join("release/librelievo.so"));
    for line in output(&mut bench)?.lines() {
        // Blender says things of its own.
        let [name, milliseconds, goal] = line.split('\t').collect::<Vec<_>>()[..] else { continue };
        let Ok(ours) = milliseconds.parse::<f64>() else { continue };
        let met = goal.parse().ok().map(|goal: f64| ours <= goal);
        let goal = if goal.is_empty() { String::new() } else { format!("<= {goal}") };
        if json {
            let peer = None::<f64>;
            println!(
                "{}",
                json!({
                    "bench": "hosts", "case": name, "ours": ours, "peer": peer, "peer_name": peer, "unit": "ms",
                    "ratio": peer, "goal": goal, "met": met,
                })
            );
        } else {
            let met = met.map_or("", |met| if met { "yes" } else { "NO" });
            println!("{name:<52} {ours:>9.3} ms  {goal:<6} {met}");
        }
    }
    Ok(())
}
