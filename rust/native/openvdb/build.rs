//! Compiles the shims over OpenVDB and links the system's library.

fn main() {
    let sources = ["level_set", "points"].map(|name| format!("../../../cpp/openvdb/{name}.cpp"));
    println!("cargo::rerun-if-changed=../../../cpp/openvdb");
    cc::Build::new()
        .cpp(true)
        .std("c++17")
        .warnings(false)
        .debug(false)
        .opt_level(1)
        .include("/usr/include/Imath")
        .files(sources)
        .compile("relievo_openvdb");
    for library in ["openvdb", "tbb", "Imath"] {
        println!("cargo::rustc-link-lib={library}");
    }
}
