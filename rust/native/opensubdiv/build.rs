//! Generates both sides of the bridge, compiles the C++ side and links OpenSubdiv.

fn main() {
    let folder = std::path::Path::new("../../../cpp");
    for source in ["exceptions.h", "opensubdiv"] {
        println!("cargo:rerun-if-changed={}", folder.join(source).display());
    }
    println!("cargo:rerun-if-changed=src/bridge.rs");
    cxx_build::bridge("src/bridge.rs")
        .std("c++17")
        .warnings(true)
        .include(folder)
        .file(folder.join("opensubdiv/refine.cpp"))
        .file(folder.join("opensubdiv/reference.cpp"))
        .file(folder.join("opensubdiv/subdivision.cpp"))
        .compile("relievo_opensubdiv");
    println!("cargo:rustc-link-lib=osdCPU");
}
