//! `cargo xtask comparison`: the scenes of `tests/hosts/comparison` in our ray caster, in Cycles and in POV-Ray, with
//! the same camera and light, a progressive mesh that the command and the add-on edit, and Bézier patches drawn from
//! virtual vertices and by POV-Ray; silhouettes, depths and normals held against their goals.

mod levels;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::blender;
use crate::files::remove;
use crate::stage::{Outcome, call, cargo, root, target};

/// A scene, by its file's name.
struct Scene {
    name: &'static str,
    label: &'static str,
    /// Depths that nothing in it is nearer and farther than, in scene units: what 16 bits are spread over.
    depths: [f64; 2],
    /// The greatest difference of depth inside of 999 in 1000 pixels, as a share of how far depths are apart.
    depth: &'static str,
}

const SCENES: [Scene; 4] = [
    Scene { name: "cage", label: "Limit surface of a creased cage", depths: [5.0, 9.0], depth: SAME },
    Scene { name: "terrain", label: "A dented terrain", depths: [3.0, 6.0], depth: SAME },
    Scene { name: "idol", label: "A painted and sculpted model", depths: [4.5, 6.5], depth: SAME },
    // The others have a mesh of it, flat in cells of an eighth of the support radius.
    Scene { name: "fluid", label: "A fluid of particles", depths: [4.0, 10.0], depth: "0.001" },
];
/// Files of Bézier patches beside the checkout, with the axis that points up.
const PATCHES: [(Scene, &str); 2] = [
    (Scene { name: "teapot", label: "Newell's teapot", depths: [7.0, 16.0], depth: SAME }, "z"),
    (Scene { name: "teacup", label: "Newell's teacup", depths: [2.0, 7.0], depth: SAME }, "y"),
];
/// Pixels of the pictures, as the scenes have it.
const SIZE: [&str; 2] = ["640", "480"];
/// The difference of depth of the same surface.
const SAME: &str = "0.0001";

/// Goals: pixels that one picture alone covers, as a share of those covered; differences of depth inside; the median of
/// angles between normals inside, in degrees.
fn goals(depth: &str) -> [&str; 6] {
    ["--max-silhouette", "0.002", "--max-depth", depth, "--max-normal", "0.5"]
}

/// Builds the command and compares; `sheet` is where the contact sheet goes, as a PNG file.
pub fn run(sheet: Option<&Path>) -> Outcome {
    call(cargo().args(["build", "--release", "--package", "relievo-cli", "--package", "relievo-capi"]))?;
    compare(sheet)
}

/// Compares with the command that was built.
pub fn test() -> Outcome {
    compare(None)
}

fn compare(sheet: Option<&Path>) -> Outcome {
    if Command::new("povray").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_err() {
        println!("skipped: povray is not installed");
        return Ok(());
    }
    patches()?;
    let python = match blender::python() {
        Ok(python) => python,
        Err(error) => {
            println!("skipped: there is no bpy: {error}");
            return Ok(());
        }
    };
    let source = root().join("tests/hosts/comparison");
    let folder = target().join("comparison");
    remove(&folder)?;
    let relievo = target().join("release/relievo");
    let outs = SCENES.map(|scene| folder.join(scene.name));
    let mut cycles = blender::clean(&python);
    cycles.arg(source.join("render_cycles.py"));
    for (scene, out) in SCENES.iter().zip(&outs) {
        let file = source.join(scene.name).with_extension("toml");
        call(Command::new(&relievo).args(["scene", "run"]).arg(file).arg("--out").arg(out).stdout(Stdio::null()))?;
        cycles.arg(out.join("scene-000000.py")).arg(out.join("cycles.exr"));
    }
    call(cycles.stdout(Stdio::null()))?;
    let compare = || {
        let mut compare = Command::new(&relievo);
        compare.args(["compare", "--names", "RELIEVO,CYCLES,POV-RAY"]);
        compare
    };
    let pictures = |out: &PathBuf| ["beauty-000000.exr", "cycles.exr", "povray.exr"].map(|name| out.join(name));
    let sheet = sheet.map_or_else(|| folder.join("sheet.png"), |path| path.to_path_buf());
    let mut all = compare();
    for (scene, out) in SCENES.iter().zip(&outs) {
        povray(&source, scene, out)?;
        call(compare().args(goals(scene.depth)).args(["--row", scene.label]).args(pictures(out)))?;
        all.args(["--row", scene.label]);
    }
    call(all.args(outs.iter().flat_map(pictures)).arg("--sheet").arg(&sheet).stdout(Stdio::null()))?;
    println!("{}", sheet.display());
    levels::compare(&python, &source, &folder.join("idol/mesh-000000.glb"))
}

/// Bézier patches, which POV-Ray cuts into triangles of its own. They are drawn on a graphics device if there is one.
fn patches() -> Outcome {
    let data = std::env::var_os("RELIEVO_DATA").map_or_else(|| root().join("../shared/data"), PathBuf::from);
    let (source, folder) = (root().join("tests/hosts/comparison"), target().join("patches"));
    remove(&folder)?;
    let relievo = target().join("release/relievo");
    let mut compare = Command::new(&relievo);
    compare.args(["compare", "--names", "POV-RAY,RELIEVO"]).args(goals(SAME));
    let mut pictures = Vec::new();
    for (scene, up) in PATCHES {
        let file = data.join("patches").join(scene.name);
        if !file.exists() {
            println!("skipped: {} is not here", file.display());
            continue;
        }
        let out = folder.join(scene.name);
        let size = format!("{}x{}", SIZE[0], SIZE[1]);
        call(
            Command::new(&relievo)
                .args(["export", "pov", "--up", up, "--size", &size, "--out"])
                .arg(&out)
                .arg(&file)
                .stdout(Stdio::null()),
        )?;
        povray(&source, &scene, &out)?;
        let drawn = out.join("relievo.exr");
        let mut draw = Command::new(&relievo);
        draw.args(["draw", "--device", "gpu", "--level", "6", "--samples", "1", "--up", up, "--size", &size]);
        call(draw.arg(&file).arg("--output").arg(&drawn))?;
        compare.args(["--row", scene.label]);
        pictures.extend([out.join("povray.exr"), drawn]);
    }
    if pictures.is_empty() {
        return Ok(());
    }
    let sheet = folder.join("sheet.png");
    call(compare.args(pictures).arg("--sheet").arg(&sheet))?;
    println!("{}", sheet.display());
    Ok(())
}

/// Renders colours, depths and normals of a scene by POV-Ray, and puts them into one EXR file.
fn povray(source: &Path, scene: &Scene, out: &Path) -> Outcome {
    let [near, far] = scene.depths;
    let passes: [(&str, PathBuf); 3] = [
        ("color", out.join("scene-000000.pov")),
        ("depth", source.join("depth.pov")),
        ("normal", source.join("normal.pov")),
    ];
    for (name, file) in passes {
        let joined = |start: &str, path: &Path| [OsString::from(start), path.into()].into_iter().collect::<OsString>();
        let mut command = Command::new("povray");
        command
            .arg(joined("+I", &file))
            .arg(joined("+L", out))
            .arg(joined("+O", &out.join(name).with_extension("png")));
        command.args([format!("+W{}", SIZE[0]), format!("+H{}", SIZE[1])]);
        // Sixteen bits of linear light, transparent where nothing is.
        command.args(["-D", "-A", "-V", "-GA", "+FN16", "+UA", "File_Gamma=1"]);
        command.args([format!("Declare=Near={near}"), format!("Declare=Far={far}")]);
        call(command.stderr(Stdio::null()))?;
    }
    let mut join = Command::new("oiiotool");
    join.arg(out.join("color.png")).args(["--ch", "R,G,B,A"]);
    join.arg(out.join("depth.png")).args(["--dup", "--ch", "Z=R", "--swap", "--ch", "Z=G", "--div"]);
    join.args(["--mulc", &(far - near).to_string(), "--addc", &near.to_string()]);
    join.arg(out.join("normal.png")).args(["--ch", "normal.X=R,normal.Y=G,normal.Z=B", "--mulc", "2", "--subc", "1"]);
    call(join.args(["--chappend", "--chappend", "-d", "float", "-o"]).arg(out.join("povray.exr")))
}
