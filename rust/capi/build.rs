//! Gives the shared library its SONAME or its install name, one per minor version until 1.0, exports nothing of the
//! libraries linked into it, and keeps it loaded once a host opened it: thread-local destructors of an unloaded library
//! would crash the host at exit.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let system = std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default();
    let version = |part: &str| std::env::var(format!("CARGO_PKG_VERSION_{part}")).unwrap_or_default();
    if system == "macos" {
        let name = format!("@rpath/librelievo.{}.{}.dylib", version("MAJOR"), version("MINOR"));
        println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,{name}");
    }
    if system == "linux" {
        let soname = format!("librelievo.so.{}.{}", version("MAJOR"), version("MINOR"));
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,{soname}");
        println!("cargo::rustc-cdylib-link-arg=-Wl,-z,nodelete");
        // The runtime of cxx exports its own symbols; another library of the host with another cxx would take ours.
        println!("cargo::rustc-cdylib-link-arg=-Wl,--exclude-libs,ALL");
    }
}
