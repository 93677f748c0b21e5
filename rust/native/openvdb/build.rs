//! Compiles the shim over OpenVDB and links the system's library.

fn main() {
    let source = "../../../cpp/openvdb/level_set.cpp";
    println!("cargo::rerun-if-changed={source}");
    cc::Build::new()
        .cpp(true)
        .std("c++17")
        .warnings(false)
        .debug(false)
        .opt_level(1)
        .include("/usr/include/Imath")
        .file(source)
        .compile("relievo_openvdb");
    for library in ["openvdb", "tbb", "Imath"] {
        println!("cargo::rustc-link-lib={library}");
    }
}
