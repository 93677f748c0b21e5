//! Compiles the C++ shim and links OpenSubdiv.

fn main() {
    let folder = std::path::Path::new("../../../cpp/opensubdiv");
    println!("cargo:rerun-if-changed={}", folder.display());
    cc::Build::new()
        .cpp(true)
        .std("c++17")
        .warnings(true)
        .file(folder.join("refine.cpp"))
        .file(folder.join("reference.cpp"))
        .compile("relievo_opensubdiv");
    println!("cargo:rustc-link-lib=osdCPU");
}
