//! `cargo xtask test`: every test there is, stage by stage. It is also what continuous integration runs, on 2 cores.

use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

use crate::stage::{Outcome, Stages, call, cargo, output, root, target};
use crate::{fuzz, packages};

/// Seconds each fuzz target runs; `cargo xtask fuzz` runs them for longer.
const FUZZ_SECONDS: u32 = 12;
/// The seed of libFuzzer and of tests with random cases, so that a change that touches nothing is not failed by chance.
/// `cargo test` draws another one each time.
const SEED: u32 = 1;

/// Runs all stages. After a failed set-up or build nothing else runs; otherwise everything does, then it fails.
pub fn run(yes: bool) -> Outcome {
    let mut stages = Stages::default();
    let ready = stages.run("set-up", 6, || packages::install(packages::ALL, yes))
        && stages.run("build", 12, || call(cargo().args(["build", "--release", "--workspace", "--all-targets"])));
    if ready {
        stages.run("Rust tests", 6, || call(tests().arg("--workspace")));
        stages.run("lower levels", 2, lower_levels);
        if stages.run("hosts: build", 2, build_hosts) {
            stages.run("hosts: tests", 4, || ctest(&["--label-exclude", "valgrind"]));
            stages.run("Valgrind", 2, || ctest(&["--label-regex", "valgrind"]));
        }
        stages.run("fuzz", 4, || fuzz::build().and_then(|()| fuzz::run(&[], FUZZ_SECONDS, Some(SEED))));
    }
    stages.finish()
}

fn tests() -> Command {
    let mut test = cargo();
    test.args(["test", "--release", "--no-fail-fast"]).env("PROPTEST_RNG_SEED", SEED.to_string());
    test
}

/// Folders of crates with kernels that are compiled for several instruction levels.
const KERNELS: [&str; 4] = ["core", "surface", "tiles", "detail"];

/// Runs the tests of kernels at the instruction levels below this processor's best. They are those that the stage
/// before built: naming packages to Cargo would build them once more with other features.
fn lower_levels() -> Outcome {
    #[cfg(target_arch = "x86_64")]
    let levels = [("baseline", is_x86_feature_detected!("avx2")), ("avx2", is_x86_feature_detected!("avx512f"))];
    #[cfg(not(target_arch = "x86_64"))]
    let levels: [(&str, bool); 0] = [];
    let mut list = tests();
    list.args(["--workspace", "--tests", "--no-run", "--quiet", "--message-format", "json"]);
    let built = output(&mut list)?;
    let built = built.lines().filter_map(|line| kernel_tests(&serde_json::from_str(line).ok()?));
    let built: Vec<(PathBuf, PathBuf)> = built.collect();
    if built.is_empty() {
        return Err("Cargo names no tests of kernels".into());
    }
    let mut failed = Vec::new();
    for (level, _) in levels.iter().filter(|(_, below)| *below) {
        println!("\nkernels at the level `{level}`");
        for (folder, executable) in &built {
            let mut test = Command::new(executable);
            test.current_dir(folder).env("RELIEVO_SIMD", level).env("PROPTEST_RNG_SEED", SEED.to_string());
            failed.extend(call(test.arg("--quiet")).err());
        }
    }
    if failed.is_empty() { Ok(()) } else { Err(failed.join("; ")) }
}

/// The folder of a crate with kernels and an executable of its tests, if a message of Cargo tells of one.
fn kernel_tests(message: &Value) -> Option<(PathBuf, PathBuf)> {
    let folder = PathBuf::from(message["manifest_path"].as_str()?).parent()?.to_owned();
    let is_kernel = KERNELS.iter().any(|name| folder == root().join("rust").join(name));
    let executable = message["executable"].as_str().filter(|_| is_kernel && message["profile"]["test"] == true)?;
    Some((folder, executable.into()))
}

/// Configures and builds the C and C++ hosts of `tests/`.
fn build_hosts() -> Outcome {
    let folder = target().join("hosts");
    let mut configure = Command::new("cmake");
    configure.arg("-S").arg(root().join("tests")).arg("-B").arg(&folder);
    configure.args(["-G", "Ninja", "-DCMAKE_BUILD_TYPE=RelWithDebInfo"]);
    configure.arg(format!("-DRELIEVO_LIBRARY_DIR={}", target().join("release").display()));
    call(&mut configure)?;
    call(Command::new("cmake").arg("--build").arg(&folder))
}

fn ctest(labels: &[&str]) -> Outcome {
    let mut command = Command::new("ctest");
    command.arg("--test-dir").arg(target().join("hosts"));
    command.arg("--parallel").arg(std::thread::available_parallelism().map_or(1, usize::from).to_string());
    call(command.args(["--output-on-failure", "--no-tests=error"]).args(labels))
}
