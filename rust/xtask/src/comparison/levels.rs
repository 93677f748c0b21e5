//! A progressive mesh that is edited at a coarse level, in the form of Figure 6 of Derzapf, Grund, Guthe 2014: the model,
//! the edit with the ball of what it grabs, and the finest level after it. Once the command makes the edit and our ray
//! caster draws, once the add-on does in Blender and Cycles draws.

use std::path::Path;
use std::process::{Command, Stdio};

use super::{SAME, goals};
use crate::blender;
use crate::files::{copy, remove};
use crate::stage::{Outcome, call, root, target};

/// Folders of the pictures, and what they show.
const STAGES: [(&str, &str); 4] = [
    ("original", "A model"),
    ("ball", "What an edit grabs at 600 triangles"),
    ("level", "The level after it"),
    ("result", "The finest level, which follows"),
];
/// Triangles of the level, as `levels_edits.toml` has it.
const FACES: &str = "600";
/// How much of the ball is seen, and how much of what is behind.
const COVER: [&str; 2] = ["0.45", "0.55"];

/// Compares with the command that was built; `mesh` is the model.
pub fn compare(python: &Path, source: &Path, mesh: &Path) -> Outcome {
    let folder = target().join("levels");
    remove(&folder)?;
    let relievo = target().join("release/relievo");
    let edits = source.join("levels_edits.toml");
    let [whole, edited] = ["model.rlvpm", "edited.rlvpm"].map(|name| folder.join(name));
    let run = |task: &str, from: &Path, to: &Path, more: &[&str]| {
        let mut command = Command::new(&relievo);
        command.args(["progressive", task]).arg(from).arg("--output").arg(to).args(more);
        call(command.stdout(Stdio::null()).stderr(Stdio::null()))
    };
    let level = |name: &str| folder.join(name).join("level.ply");
    for (name, _) in STAGES {
        let place = folder.join(name);
        std::fs::create_dir_all(&place).map_err(|error| format!("{}: {error}", place.display()))?;
    }
    // Both show facets, which Blender would turn to the normals of the model.
    run("build", mesh, &whole, &["--without", "normal"])?;
    run("edit", &whole, &edited, &["--script", &edits.to_string_lossy()])?;
    run("export", &whole, &level("original"), &[])?;
    run("export", &edited, &level("level"), &["--faces", FACES])?;
    copy(&level("level"), &level("ball"))?;
    run("export", &edited, &level("result"), &[])?;
    for (name, _) in STAGES {
        let scene = folder.join(name).join("levels.toml");
        let parts: &[&str] = if name == "ball" { &["levels.toml", "levels_ball.toml"] } else { &["levels.toml"] };
        let mut text = String::new();
        for part in parts {
            let part = source.join(part);
            text += &std::fs::read_to_string(&part).map_err(|error| format!("{}: {error}", part.display()))?;
        }
        std::fs::write(&scene, text).map_err(|error| format!("{}: {error}", scene.display()))?;
        call(
            Command::new(&relievo)
                .args(["scene", "run"])
                .arg(&scene)
                .arg("--out")
                .arg(folder.join(name))
                .stdout(Stdio::null()),
        )?;
    }
    let mut cycles = blender::clean(python);
    cycles.env("RELIEVO_LIBRARY", target().join("release/librelievo.so")).current_dir(root());
    cycles.arg(source.join("render_levels.py")).args([&whole, &edits, &folder]);
    call(cycles.stdout(Stdio::null()))?;
    cover(&folder)?;
    let mut compare = Command::new(&relievo);
    compare.args(["compare", "--names", "RELIEVO,BLENDER"]).args(goals(SAME));
    for (name, label) in STAGES {
        let names =
            if name == "ball" { ["covered.exr", "covered_cycles.exr"] } else { ["beauty-000000.exr", "cycles.exr"] };
        compare.args(["--row", label]).args(names.map(|file| folder.join(name).join(file)));
    }
    let sheet = folder.join("sheet.png");
    call(compare.arg("--sheet").arg(&sheet))?;
    println!("{}", sheet.display());
    Ok(())
}

/// Blends the pictures with and without the ball, so that it is seen through. Depths and normals are those of the ball.
fn cover(folder: &Path) -> Outcome {
    let part = |join: &mut Command, file: &Path, subimage: &str, names: &str| {
        join.arg(file).args(["--subimage", subimage, "--chnames", names]);
    };
    for (picture, out) in [("beauty-000000.exr", "covered.exr"), ("cycles.exr", "covered_cycles.exr")] {
        let [ball, level] = ["ball", "level"].map(|name| folder.join(name).join(picture));
        let mut join = Command::new("oiiotool");
        if out == "covered.exr" {
            join.arg(&ball).args(["--ch", "R,G,B", "--mulc", COVER[0]]);
            join.arg(&level).args(["--ch", "R,G,B", "--mulc", COVER[1], "--add"]);
            join.arg(&ball).args(["--ch", "Z,normal.X,normal.Y,normal.Z", "--chappend"]);
        } else {
            // Cycles has a part for every pass.
            part(&mut join, &ball, "0", "R,G,B,A");
            join.args(["--ch", "R,G,B", "--mulc", COVER[0]]);
            part(&mut join, &level, "0", "R,G,B,A");
            join.args(["--ch", "R,G,B", "--mulc", COVER[1], "--add"]);
            part(&mut join, &ball, "1", "Z");
            part(&mut join, &ball, "2", "normal.X,normal.Y,normal.Z");
            join.args(["--chappend", "--chappend"]);
        }
        call(join.args(["-d", "float", "-o"]).arg(folder.join("ball").join(out)))?;
    }
    Ok(())
}
