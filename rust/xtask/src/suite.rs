//! `cargo xtask test`: every test there is, stage by stage. It is also what continuous integration runs, on 2 cores.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

use crate::stage::{Outcome, Stages, call, cargo, output, root, target, watch};
use crate::{bindings, blender, comparison, dist, fuzz, licences, module, packages, usd, wheel};

/// Seconds each fuzz target runs; `cargo xtask fuzz` runs them for longer.
const FUZZ_SECONDS: u32 = 3;
/// The seed of libFuzzer and of tests with random cases, so that a change that touches nothing is not failed by chance.
/// `cargo test` draws another one each time.
const SEED: u32 = 1;

/// Runs all stages. After a failed set-up or build nothing else runs; otherwise everything does, then it fails.
pub fn run(yes: bool) -> Outcome {
    let mut stages = Stages::default();
    let ready = stages.run("set-up", 4, || packages::install(packages::ALL, yes))
        && stages.run("OpenVDB module", 2, module::run)
        && stages.run("build", 16, || call(cargo().args(["build", "--release", "--workspace", "--all-targets"])));
    if ready {
        stages.run("licences", 1, licences::check);
        stages.run("lints", 2, lints);
        stages.run("bindings", 1, || bindings::run(true));
        stages.run("features", 1, features);
        stages.run("pages", 1, bindings::pages);
        stages.run("Rust tests", 1, rust_tests);
        stages.run("MPI", 1, mpi);
        stages.run("lower levels", 1, lower_levels);
        stages.run("Embree 4", 1, embree_4);
        if stages.run("hosts: build", 1, build_hosts) {
            stages.run("hosts: tests", 1, || ctest(&["--label-exclude", "valgrind"]));
            stages.run("Valgrind", 2, || ctest(&["--label-regex", "valgrind"]));
        }
        stages.run("packages", 2, dist::test);
        stages.run("Blender", 2, blender::test);
        stages.run("comparison", 1, comparison::test);
        stages.run("USD", 1, usd::test);
        stages.run("fuzz", 5, || fuzz::build().and_then(|()| fuzz::run(&[], FUZZ_SECONDS, Some(SEED))));
    }
    stages.finish()
}

/// Lints of Clippy that ask for worse code here, each with the reason.
const REFUSED_LINTS: [&str; 8] = [
    // Kernels walk several lists by one index, which is what the lint calls needless.
    "needless_range_loop",
    // A comparison that fails for what is not a number is written with a negation on purpose.
    "neg_cmp_op_on_partial_ord",
    "nonminimal_bool",
    // `clamp` panics where a bound is not a number.
    "manual_clamp",
    // Pairs and lists of one use need no name.
    "type_complexity",
    // Values of these kinds are few.
    "large_enum_variant",
    // `from` and `new` are words of the field in some names.
    "wrong_self_convention",
    "new_ret_no_self",
];

/// Checks all code with Clippy, which a toolchain of Rust's minimal profile lacks.
fn lints() -> Outcome {
    if output(cargo().args(["clippy", "--version"])).is_err() {
        call(Command::new("rustup").args(["component", "add", "clippy"]))?;
    }
    let refused = REFUSED_LINTS.iter().flat_map(|lint| ["--allow".to_owned(), format!("clippy::{lint}")]);
    let mut clippy = cargo();
    call(
        clippy
            .args([
                "clippy",
                "--release",
                "--workspace",
                "--all-targets",
                "--features",
                MPI,
                "--",
                "--deny",
                "warnings",
                // Public functions say what makes them fail.
                "--deny",
                "clippy::missing_errors_doc",
            ])
            .args(refused),
    )
}

/// Checks that the library, the command and the demo's program compile without features. Checks make no library, so that
/// the one that was built stays.
fn features() -> Outcome {
    let packages = ["--package", "relievo-capi", "--package", "relievo-cli", "--package", "relievo-scene"];
    let features = ["--no-default-features", "--features", "relievo-scene/program"];
    call(cargo().args(["check", "--release", "--lib", "--bins"]).args(features).args(packages))
}

fn tests() -> Command {
    let mut test = cargo();
    surroundings(test.args(["test", "--release", "--no-fail-fast"]));
    test
}

/// Plays the first tasks in the window, and puts strips of pictures into `docs/images`.
pub fn window() -> Outcome {
    let mut test = tests();
    test.args(["--workspace", "--test", "tasks", "--", "--nocapture"]);
    call(test.env("RELIEVO_STRIPS", root().join("docs/images")))
}

/// The feature that needs the headers of an MPI.
const MPI: &str = "relievo-mpi/mpi";

/// MessagePack as PyPI has it.
const MSGPACK: &str = "msgpack==1.1.1";

/// Runs all tests in Rust. Those of the simulation server have a client in Python.
fn rust_tests() -> Outcome {
    let python = wheel::environment(&target().join("msgpack"), &[MSGPACK])?;
    watch_tests(tests().arg("--workspace").env("RELIEVO_MSGPACK_PYTHON", python))
}

/// Runs the tests of simulations over MPI, which nothing else is built with.
fn mpi() -> Outcome {
    watch_tests(tests().args(["--workspace", "--features", MPI, "--test", "mpi"]))
}

/// Runs tests in Rust. The causes are the messages of tests that fail.
pub fn watch_tests(command: &mut Command) -> Outcome {
    let mut fails = false;
    watch(command, |line| {
        fails = (fails || line == "failures:") && !line.starts_with("test result:");
        fails
    })
}

/// Sets what tests ask their surroundings for.
pub fn surroundings(test: &mut Command) {
    test.env("PROPTEST_RNG_SEED", SEED.to_string());
    // Without the second, Mesa looks for a screen at every start and says that there is none.
    test.env("RELIEVO_GPU_TESTS", "required").env("NODEVICE_SELECT", "1");
    test.env("RELIEVO_OPENVDB_TESTS", "required").env("RELIEVO_OPENVDB", module::path());
}

/// Folders of crates with kernels that are compiled for several instruction levels.
const KERNELS: [&str; 7] = ["core", "surface", "tiles", "detail", "lod", "fluid", "tissue"];
/// Those of them that are tested at levels in between, where only the number of lanes differs.
#[cfg(target_arch = "x86_64")]
const LANES: [&str; 4] = ["core", "surface", "tiles", "fluid"];

/// Runs the tests of kernels at the instruction levels below this processor's best, without graphics devices, which the stage
/// before compared with the processor. They are the programs that it built: naming packages to Cargo would build them once more
/// with other features.
fn lower_levels() -> Outcome {
    #[cfg(target_arch = "x86_64")]
    let levels: [(&str, bool, &[&str]); 2] = [
        ("baseline", is_x86_feature_detected!("avx2"), &KERNELS),
        ("avx2", is_x86_feature_detected!("avx512f"), &LANES),
    ];
    #[cfg(not(target_arch = "x86_64"))]
    let levels: [(&str, bool, &[&str]); 1] = [("baseline", cfg!(target_arch = "aarch64"), &KERNELS)];
    let mut failed = Vec::new();
    for (level, _, crates) in levels.iter().filter(|(_, below, _)| *below) {
        let built = built_tests(crates)?;
        failed.extend(run_with(&built, "RELIEVO_SIMD", level.as_ref(), false).err());
    }
    if failed.is_empty() { Ok(()) } else { Err(failed.join("; ")) }
}

/// An Embree 4 as PyPI has it.
pub const EMBREE_4: &str = "embreex==4.4.0.post1";
/// Another TBB than Debian's, as PyPI has it.
const OTHER_TBB: &str = "tbb==2022.3.1";
/// The crates whose tests are run with other Embrees than Debian's.
const CASTING: [&str; 2] = ["native/embree", "render"];

/// Runs the tests of what casts rays with Embree 4, in place of the system's Embree 3: with PyPI's, and with the one that
/// bpy carries.
fn embree_4() -> Outcome {
    let built = built_tests(&CASTING)?;
    let [pypi, carried] = [embree_4_library()?, blender::embree()?];
    let failed: Vec<_> =
        [pypi, carried].iter().filter_map(|it| run_with(&built, "RELIEVO_EMBREE", it.as_ref(), true).err()).collect();
    if failed.is_empty() { Ok(()) } else { Err(failed.join("; ")) }
}

fn embree_4_library() -> Result<PathBuf, String> {
    let python = wheel::environment(&target().join("embree4"), &[EMBREE_4])?;
    wheel::found(&python, "platlib", "embreex.libs/libembree4*")
}

fn other_tbb_library() -> Result<PathBuf, String> {
    let python = wheel::environment(&target().join("tbb"), &[OTHER_TBB])?;
    wheel::found(&python, "data", "lib/libtbb.so.12")
}

/// The executables of the tests of crates, each with the folder it runs in, as the stages before built them.
fn built_tests(crates: &[&str]) -> Result<Vec<(PathBuf, PathBuf)>, String> {
    let folders: Vec<PathBuf> = crates.iter().map(|name| root().join("rust").join(name)).collect();
    let mut list = tests();
    list.args(["--workspace", "--tests", "--no-run", "--quiet", "--message-format", "json"]);
    let executable = |message: Value| {
        let folder = PathBuf::from(message["manifest_path"].as_str()?).parent()?.to_owned();
        let wanted = folders.contains(&folder) && message["profile"]["test"] == true;
        let executable = message["executable"].as_str().filter(|_| wanted)?;
        Some((folder, executable.into()))
    };
    let built = output(&mut list)?;
    let built: Vec<_> = built.lines().filter_map(|line| executable(serde_json::from_str(line).ok()?)).collect();
    if built.is_empty() { Err(format!("Cargo names no tests of {}", crates.join(", "))) } else { Ok(built) }
}

/// Runs tests that were built with an environment variable set, with or without graphics devices.
fn run_with(tests: &[(PathBuf, PathBuf)], variable: &str, value: &OsStr, has_devices: bool) -> Outcome {
    println!("\nwith {variable}={}", value.display());
    let mut failed = Vec::new();
    for (folder, executable) in tests {
        let mut test = Command::new(executable);
        surroundings(test.current_dir(folder).env(variable, value));
        if !has_devices {
            test.env_remove("RELIEVO_GPU_TESTS").env("VK_DRIVER_FILES", "/dev/null");
        }
        failed.extend(watch_tests(test.arg("--quiet")).err());
    }
    if failed.is_empty() { Ok(()) } else { Err(failed.join("; ")) }
}

/// Configures and builds the C and C++ hosts of `tests/`.
fn build_hosts() -> Outcome {
    build_host("all")
}

/// Configures the hosts of `tests/` and builds the one called `name`.
pub fn build_host(name: &str) -> Outcome {
    let folder = target().join("hosts");
    let mut configure = Command::new("cmake");
    configure.arg("-S").arg(root().join("tests")).arg("-B").arg(&folder);
    configure.args(["-G", "Ninja", "-DCMAKE_BUILD_TYPE=RelWithDebInfo"]);
    configure.arg(format!("-DRELIEVO_LIBRARY_DIR={}", target().join("release").display()));
    configure.arg(format!("-DEMBREE4_LIBRARY={}", embree_4_library()?.display()));
    configure.arg(format!("-DOTHER_TBB_LIBRARY={}", other_tbb_library()?.display()));
    call(&mut configure)?;
    let mut build = Command::new("cmake");
    build.arg("--build").arg(&folder).args(["--target", name]);
    call(&mut build)
}

fn ctest(labels: &[&str]) -> Outcome {
    let mut command = Command::new("ctest");
    command.arg("--test-dir").arg(target().join("hosts")).env("RELIEVO_GPU_TESTS", "required");
    command.arg("--parallel").arg(std::thread::available_parallelism().map_or(1, usize::from).to_string());
    let mut fails = false;
    watch(command.args(["--output-on-failure", "--no-tests=error"]).args(labels), |line| {
        // Between tests there are lines of their starts and ends.
        let is_end = line.contains(" Test ") && line.contains(" sec");
        fails = if is_end { line.contains("***") } else { fails && !line.trim_start().starts_with("Start ") };
        fails
    })
}
