//! Compiles the C++ side of the bridge. OpenMesh itself is opened at run time.

fn main() {
    let cpp = std::path::Path::new("../../../cpp");
    for source in ["exceptions.h", "openmesh"] {
        println!("cargo:rerun-if-changed={}", cpp.join(source).display());
    }
    println!("cargo:rerun-if-changed=src/bridge.rs");
    cxx_build::bridge("src/bridge.rs")
        .file(cpp.join("openmesh/patch.cpp"))
        .file(cpp.join("openmesh/library.cpp"))
        .include(cpp)
        .std("c++17")
        // Its assertions print, and without this its headers use dynamic_cast on properties.
        .define("NDEBUG", None)
        .flag_if_supported("-fvisibility=hidden")
        .warnings(false)
        .compile("relievo_openmesh");
}
