//! Generates both sides of the bridge, compiles the C++ side, and makes the private copy of OpenSubdiv that it calls.

mod copy;
mod jumps;

use std::path::{Path, PathBuf};
use std::process::Command;

/// The library that is copied.
const LIBRARY: &str = "libosdCPU.so";

fn main() {
    let folder = Path::new("../../../cpp");
    for source in ["exceptions.h", "opensubdiv"] {
        println!("cargo:rerun-if-changed={}", folder.join(source).display());
    }
    println!("cargo:rerun-if-changed=src/bridge.rs");
    println!("cargo:rerun-if-changed=build");
    let mut bridge = cxx_build::bridge("src/bridge.rs");
    bridge.std("c++17").warnings(true).include(folder);
    for source in ["refine", "reference", "subdivision"] {
        bridge.file(folder.join(format!("opensubdiv/{source}.cpp")));
    }
    let system = std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default();
    if system != "linux" {
        return link(&mut bridge, &system);
    }
    bridge.define(copy::THEIRS, copy::OURS).compile("relievo_opensubdiv");
    if let Err(error) = private(&bridge.get_compiler()) {
        println!("cargo::error=the private copy of OpenSubdiv cannot be made: {error}");
    }
}

/// Compiles the C++ side and links OpenSubdiv, from the folder that `RELIEVO_PREFIX` names or where the compiler finds it:
/// on other systems than Linux names belong to libraries.
fn link(bridge: &mut cc::Build, system: &str) {
    println!("cargo:rerun-if-env-changed=RELIEVO_PREFIX");
    if let Some(prefix) = std::env::var_os("RELIEVO_PREFIX").map(PathBuf::from) {
        bridge.include(prefix.join("include"));
        println!("cargo:rustc-link-search=native={}", prefix.join("lib").display());
    }
    // Without it, mingw's headers have no π in strict C++.
    if system == "windows" {
        bridge.define("_USE_MATH_DEFINES", None);
    }
    bridge.compile("relievo_opensubdiv");
    println!("cargo:rustc-link-lib={}osdCPU", if system == "windows" { "static=" } else { "" });
}

/// Writes the copy and the list of its symbols that the C++ side refers to, and compiles the jumps to them.
fn private(compiler: &cc::Tool) -> Result<(), String> {
    let out = PathBuf::from(std::env::var_os("OUT_DIR").ok_or("cargo names no folder")?);
    let original = found(compiler)?;
    println!("cargo:rerun-if-changed={}", original.display());
    let read = |path: &Path| std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()));
    let write = |name: &str, text: &[u8]| {
        let path = out.join(name);
        std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))
    };
    let copy = copy::made(&read(&original)?).map_err(|error| format!("{}: {error}", original.display()))?;
    let symbols = jumps::needed(&read(&out.join("librelievo_opensubdiv.a"))?, &copy)?;
    write("opensubdiv.so", &copy)?;
    write("symbols.rs", jumps::list(&symbols).as_bytes())?;
    write("jumps.S", jumps::assembly(&symbols)?.as_bytes())?;
    cc::Build::new().file(out.join("jumps.S")).compile("relievo_opensubdiv_jumps");
    Ok(())
}

/// The file that the compiler would link.
fn found(compiler: &cc::Tool) -> Result<PathBuf, String> {
    let mut command: Command = compiler.to_command();
    let output = command.arg(format!("-print-file-name={LIBRARY}")).output().map_err(|error| error.to_string())?;
    let path = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
    // A compiler that does not find it repeats the name.
    if !path.is_absolute() {
        return Err(format!("there is no {LIBRARY}; install OpenSubdiv 3.5 (Debian: libosd-dev)"));
    }
    path.canonicalize().map_err(|error| format!("{}: {error}", path.display()))
}
