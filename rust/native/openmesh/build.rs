//! Compiles the C++ side of the bridge. OpenMesh itself is opened at run time on Linux, and linked elsewhere.

use std::path::{Path, PathBuf};

fn main() {
    let cpp = Path::new("../../../cpp");
    for source in ["exceptions.h", "openmesh"] {
        println!("cargo:rerun-if-changed={}", cpp.join(source).display());
    }
    println!("cargo:rerun-if-changed=src/bridge.rs");
    let mut bridge = cxx_build::bridge("src/bridge.rs");
    bridge
        .file(cpp.join("openmesh/patch.cpp"))
        .include(cpp)
        .std("c++17")
        // Its assertions print, and without this its headers use dynamic_cast on properties.
        .define("NDEBUG", None)
        .flag_if_supported("-fvisibility=hidden")
        .warnings(false);
    let system = std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default();
    if system == "linux" {
        bridge.file(cpp.join("openmesh/library.cpp")).compile("relievo_openmesh");
        return;
    }
    // On other systems names belong to libraries. OpenMesh is in the folder that the variable names, or where the compiler
    // finds it.
    println!("cargo:rerun-if-env-changed=RELIEVO_PREFIX");
    if let Some(prefix) = std::env::var_os("RELIEVO_PREFIX").map(PathBuf::from) {
        bridge.include(prefix.join("include"));
        println!("cargo:rustc-link-search=native={}", prefix.join("lib").display());
    }
    // Without the first, mingw's headers have no π in strict C++; the second is for a static library.
    let is_static = system == "windows";
    if is_static {
        bridge.define("_USE_MATH_DEFINES", None).define("OM_STATIC_BUILD", None);
    }
    bridge.file(cpp.join("openmesh/linked.cpp")).compile("relievo_openmesh");
    println!("cargo:rustc-link-lib={}OpenMeshCore", if is_static { "static=" } else { "" });
}
