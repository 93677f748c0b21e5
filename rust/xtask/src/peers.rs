//! Programs of peers that `cargo xtask bench lod`, `fluid`, `decal` and `native` measure beside ours: compiled of `rust/bench/peers`, or scripts
//! that call a Python. They run in the bench only, each in a process of its own; nothing of them is linked or shipped.

use std::fs::{create_dir_all, metadata, remove_file, set_permissions, write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::packages;
use crate::stage::{Outcome, call, root, target};
use crate::wheel::environment;

/// A peer in C++: its name, its source, its Debian package, and what it is linked to.
type Compiled = (&'static str, &'static str, &'static str, &'static [&'static str]);

const COMPILED: [Compiled; 2] = [
    ("CGAL Lindstrom-Turk", "cgal.cpp", "libcgal-dev", &["-lgmp", "-lmpfr"]),
    ("OpenMesh", "openmesh.cpp", "libopenmesh-dev", &["-lOpenMeshCore", "-lOpenMeshTools"]),
];
/// What is installed from PyPI.
const PACKAGES: &[&str] = &["numpy==1.26.4", "fast-simplification==0.2.0"];
const REPAIRS: &[&str] = &["numpy==1.26.4", "meshlib==3.1.4.297", "pymeshlab==2023.12.post3"];
const FLUIDS: &[&str] = &["numpy==1.26.4", "pysplishsplash==2.19.0", "pysplashsurf==0.14.1.0"];
const DECALS: &[&str] = &["numpy==1.26.4", "scipy==1.13.1", "libigl==2.5.1", "potpourri3d==1.4.0"];
/// SPlisHSPlasH crashes where libraries of Debian 12 are not loaded before those it carries, and its threads would take time
/// while they wait.
const VARIABLES: &str = "OMP_WAIT_POLICY=passive LD_PRELOAD=libGLdispatch.so.0:libGLX.so.0:libOpenGL.so.0";

/// Makes the programs and returns their folder; says which cannot be made and why. With `quiet` nothing is installed.
pub fn make(quiet: bool) -> Result<PathBuf, String> {
    let folder = target().join("peers/programs");
    create_dir_all(&folder).map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
    let note = |name: &str, made: Outcome| {
        if let Err(error) = made {
            eprintln!("skipped: {name}: {error}");
            // What was made of it once may not run any more.
            let _ = remove_file(folder.join(name));
        }
    };
    for peer in COMPILED {
        note(peer.0, compile(peer, &folder, quiet));
    }
    let name = "fast-simplification";
    let python = environment(&target().join("peers/python"), PACKAGES);
    note(name, python.and_then(|python| script(&folder.join(name), "", &python, "simplify.py fast_simplification")));
    let name = "Blender Decimate";
    let python = target().join("blender/bpy/bin/python");
    let is_there = if python.exists() { Ok(()) } else { Err("`cargo xtask blender` makes a Python with it".into()) };
    note(name, is_there.and_then(|()| script(&folder.join(name), "", &python, "simplify.py blender")));
    Ok(folder)
}

/// Makes the programs that repair meshes, and returns their folder; says why where they cannot be made.
pub fn repairs() -> Result<PathBuf, String> {
    let folder = target().join("peers/repairs");
    create_dir_all(&folder).map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
    for (name, called) in [("MeshLib", "repair.py meshlib"), ("MeshLab", "repair.py pymeshlab")] {
        let python = environment(&target().join("peers/repair"), REPAIRS);
        if let Err(error) = python.and_then(|python| script(&folder.join(name), "", &python, called)) {
            eprintln!("skipped: {name}: {error}");
            let _ = remove_file(folder.join(name));
        }
    }
    Ok(folder)
}

/// Makes the programs that map patches into the plane, and returns their folder; says why where they cannot be made.
pub fn decals() -> Result<PathBuf, String> {
    let folder = target().join("peers/decals");
    create_dir_all(&folder).map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
    for (name, called) in [
        ("libigl SLIM", "decal.py slim"),
        ("libigl LSCM", "decal.py lscm"),
        ("libigl flipped_triangles", "decal.py flips"),
        ("potpourri3d log map", "decal.py log_map"),
        ("potpourri3d geodesics", "decal.py geodesics"),
    ] {
        let python = environment(&target().join("peers/decal"), DECALS);
        if let Err(error) = python.and_then(|python| script(&folder.join(name), "", &python, called)) {
            eprintln!("skipped: {name}: {error}");
            let _ = remove_file(folder.join(name));
        }
    }
    Ok(folder)
}

/// Makes the program `fluid`, which simulates by SPlisHSPlasH and makes meshes by splashsurf, and returns its folder; says why
/// where it cannot be made.
pub fn fluids(quiet: bool) -> Result<PathBuf, String> {
    let folder = target().join("peers/fluids");
    let make = || {
        if !quiet {
            packages::install(&["libopengl0", "libglx0"], false)?;
        }
        let python = environment(&folder.join("python"), FLUIDS)?;
        script(&folder.join("fluid"), VARIABLES, &python, "fluid.py")
    };
    if let Err(error) = make() {
        eprintln!("skipped: SPlisHSPlasH and splashsurf: {error}");
        let _ = remove_file(folder.join("fluid"));
    }
    Ok(folder)
}

fn compile((name, source, package, libraries): Compiled, folder: &Path, quiet: bool) -> Outcome {
    if !quiet {
        packages::install(&[package], false)?;
    }
    let sources = root().join("rust/bench/peers");
    let (source, program) = (sources.join(source), folder.join(name));
    let changed = |path: &Path| metadata(path).and_then(|data| data.modified()).ok();
    let newest = [source.as_path(), &sources.join("mesh.h")].into_iter().filter_map(changed).max();
    if changed(&program).zip(newest).is_some_and(|(made, newest)| made > newest) {
        return Ok(());
    }
    let mut compiler = Command::new("g++");
    compiler.args(["-std=c++17", "-O3", "-DNDEBUG", "-march=native", "-o"]).arg(program).arg(source);
    call(compiler.args(libraries))
}

/// A program that calls one of the scripts of peers, with the arguments that come after its name.
fn script(program: &Path, variables: &str, python: &Path, called: &str) -> Outcome {
    let (name, arguments) = called.split_once(' ').unwrap_or((called, ""));
    let script = root().join("rust/bench/peers").join(name);
    let quoted = |path: &Path| format!("'{}'", path.display().to_string().replace('\'', r"'\''"));
    let text = format!(
        "#!/bin/sh\nexec env PYTHONDONTWRITEBYTECODE=1 PYTHONPATH= {variables} {} {} {arguments} \"$@\"\n",
        quoted(python),
        quoted(&script)
    );
    let fault = |error: std::io::Error| format!("cannot write {}: {error}", program.display());
    write(program, text).map_err(fault)?;
    set_permissions(program, std::fs::Permissions::from_mode(0o755)).map_err(fault)
}
