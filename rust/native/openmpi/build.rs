//! Compiles the C side of the binding by `mpicc`, and links what that says.

use std::process::Command;

fn main() {
    let source = "../../../cpp/openmpi/world.c";
    println!("cargo:rerun-if-changed={source}");
    if std::env::var_os("CARGO_FEATURE_MPI").is_none() {
        return;
    }
    cc::Build::new().compiler("mpicc").file(source).compile("relievo_openmpi");
    for (what, kind) in [("--showme:libdirs", "search=native"), ("--showme:libs", "lib")] {
        for name in said(what).split_whitespace() {
            println!("cargo:rustc-link-{kind}={name}");
        }
    }
}

/// Returns what `mpicc` says of itself.
fn said(option: &str) -> String {
    let said = Command::new("mpicc").arg(option).output().expect("mpicc is needed: install libopenmpi-dev");
    assert!(said.status.success(), "mpicc of OpenMPI is needed, which knows {option}");
    String::from_utf8(said.stdout).expect("the names of libraries are UTF-8")
}
