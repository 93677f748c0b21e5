//! `cargo xtask platforms`: builds for other systems and processors, and tests them in emulators. Nothing of it is part of
//! `cargo xtask test`.

use std::ffi::OsString;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::ValueEnum;

use crate::files::{copy, only_file, remove};
use crate::packages;
use crate::stage::{Outcome, Stages, call, cargo, output, root, target};
use crate::suite::{EMBREE_4, watch_tests};
use crate::wheel;

/// A system and a processor that are not those of this machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Platform {
    /// Linux on AArch64: all crates are checked, tests run in qemu
    Aarch64,
    /// Windows by mingw: all crates are checked, the C tests run in Wine
    Windows,
    /// macOS on Apple's processors: crates that bind libraries are checked
    Macos,
}

impl Platform {
    /// The target as Rust calls it.
    fn triple(self) -> &'static str {
        match self {
            Self::Aarch64 => "aarch64-unknown-linux-gnu",
            Self::Windows => "x86_64-pc-windows-gnu",
            Self::Macos => "aarch64-apple-darwin",
        }
    }

    /// The Debian packages that its build and its tests need.
    fn packages(self) -> &'static [&'static str] {
        match self {
            Self::Aarch64 => {
                &["g++", "g++-aarch64-linux-gnu", "qemu-user", "mmdebstrap", "libosd-dev", "libopenmesh-dev"]
            }
            Self::Windows => &[
                "g++",
                "g++-mingw-w64-x86-64-posix",
                "wine64",
                "cmake",
                "ninja-build",
                "dpkg-dev",
                "xz-utils",
                "python3-venv",
            ],
            Self::Macos => &["g++"],
        }
    }

    /// Where what it needs lies.
    fn folder(self) -> PathBuf {
        target().join("platforms").join(match self {
            // As Debian calls it.
            Self::Aarch64 => "arm64",
            Self::Windows => "windows",
            Self::Macos => "macos",
        })
    }
}

/// Builds and tests for `platforms`, or for all where none is named.
pub fn run(platforms: &[Platform], yes: bool) -> Outcome {
    let platforms = if platforms.is_empty() { Platform::value_variants() } else { platforms };
    let mut stages = Stages::default();
    for &platform in platforms {
        if !stages.run("set-up", 4, || set_up(platform, yes)) {
            continue;
        }
        match platform {
            Platform::Aarch64 => aarch64(&mut stages),
            Platform::Windows => windows(&mut stages),
            Platform::Macos => {
                stages.run("macOS: check", 4, macos);
            }
        }
    }
    stages.finish()
}

fn set_up(platform: Platform, yes: bool) -> Outcome {
    packages::install(platform.packages(), yes)?;
    if output(Command::new("rustup").args(["target", "list", "--installed"]))?.contains(platform.triple()) {
        return Ok(());
    }
    call(Command::new("rustup").args(["target", "add", platform.triple()]))
}

/// Cargo, with what the C and C++ of crates are compiled and linked by.
fn cargo_for(platform: Platform) -> Command {
    let mut command = cargo();
    // Half of the time of the compiler; results have the same bits, and times in an emulator say nothing.
    command.env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "1");
    let folder = platform.folder();
    match platform {
        Platform::Aarch64 => {
            let libraries = folder.join("usr/lib/aarch64-linux-gnu");
            command.env("CXXFLAGS_aarch64_unknown_linux_gnu", format!("-B{}", libraries.display()));
            command.env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER", "aarch64-linux-gnu-g++");
            let runner = format!("qemu-aarch64 -L {}", folder.display());
            command.env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER", runner);
        }
        Platform::Windows => {
            command.env("CC_x86_64_pc_windows_gnu", format!("{MINGW}-gcc-posix"));
            command.env("CXX_x86_64_pc_windows_gnu", format!("{MINGW}-g++-posix"));
            command.env("AR_x86_64_pc_windows_gnu", format!("{MINGW}-ar"));
            command.env("CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER", format!("{MINGW}-gcc-posix"));
            command.env("RELIEVO_PREFIX", folder.join("prefix"));
            command.env("CARGO_TARGET_X86_64_PC_WINDOWS_GNU_RUNNER", WINE).envs(wine());
        }
        Platform::Macos => {}
    }
    command
}

/// Checks all crates with their tests. A check makes no library.
fn check(platform: Platform) -> Outcome {
    let mut check = cargo_for(platform);
    check.args(["check", "--workspace", "--all-targets", "--target", platform.triple()]);
    if platform == Platform::Windows {
        // This program installs Debian's packages and makes such.
        check.args(["--exclude", "xtask"]);
    }
    call(&mut check)
}

/// A test that starts itself to see its peak of memory, which programs in qemu cannot; and the peak is the emulator's.
const STARTS_ITSELF: &str = "memory_is_estimated_within_30_percent";

/// Tests crates in the emulator.
fn test(platform: Platform, crates: &[&str]) -> Outcome {
    let mut tests = cargo_for(platform);
    tests.args(["test", "--release", "--no-fail-fast", "--tests", "--target", platform.triple()]);
    tests.args(crates.iter().flat_map(|name| ["--package".into(), format!("relievo-{name}")]));
    tests.args(["--", "--skip", STARTS_ITSELF]);
    watch_tests(tests.env("PROPTEST_RNG_SEED", "1"))
}

/// What is tested for AArch64: lanes, what is bound to C++ and to Embree, and the kernels of surfaces and tiles.
const TESTED: [&str; 6] = ["core", "opensubdiv", "openmesh", "embree", "surface", "tiles"];
/// What those tests open, and what it links.
const LIBRARIES: &str = "libc6,libstdc++6,libosd-dev,libembree3-3,libopenmesh1";

fn aarch64(stages: &mut Stages) {
    let platform = Platform::Aarch64;
    if stages.run("AArch64: libraries", 1, debian) && stages.run("AArch64: check", 8, || check(platform)) {
        stages.run("AArch64: tests", 10, || test(platform, &TESTED));
    }
}

/// Unpacks Debian's libraries for AArch64 into a folder of their own, so that the machine has no architecture more.
fn debian() -> Outcome {
    let folder = Platform::Aarch64.folder();
    if folder.join("usr/lib/aarch64-linux-gnu/libosdCPU.so").exists() {
        return Ok(());
    }
    remove(&folder)?;
    make(folder.parent().unwrap_or(&folder))?;
    let mut unpack = Command::new("mmdebstrap");
    unpack.args(["--quiet", "--variant=extract", "--architectures=arm64"]).arg(format!("--include={LIBRARIES}"));
    call(unpack.arg("bookworm").arg(&folder).arg(DEBIAN))
}

/// Where Debian's packages and sources are.
const DEBIAN: &str = "http://deb.debian.org/debian";
/// How the names of mingw's programs start.
const MINGW: &str = "x86_64-w64-mingw32";
/// What is built from Debian's sources, since there is no package for mingw.
const SOURCES: [&str; 2] = ["opensubdiv", "openmesh"];
/// The libraries of the compiler that the DLL needs beside it.
const BESIDE: [&str; 3] = ["libstdc++-6.dll", "libgcc_s_seh-1.dll", "libwinpthread-1.dll"];
/// What runs programs of Windows.
const WINE: &str = "/usr/lib/wine/wine64";
/// What is tested for Windows in Rust. Embree has no package.
const TESTED_IN_WINE: [&str; 3] = ["core", "opensubdiv", "openmesh"];

/// Where Wine keeps its settings, that it prints nothing of its own, and where it finds the libraries of the compiler.
fn wine() -> Vec<(&'static str, OsString)> {
    let libraries = BESIDE.iter().filter_map(|name| Some(beside(name).ok()?.parent()?.to_owned()));
    let folders = std::iter::once(stand_in()).chain(libraries);
    let path: Vec<_> = folders.map(|folder| on_windows(&folder)).collect();
    let prefix = Platform::Windows.folder().join("wine");
    vec![("WINEPREFIX", prefix.into()), ("WINEDEBUG", "-all".into()), ("WINEPATH", path.join(";").into())]
}

/// What programs in Wine call a path.
fn on_windows(path: &Path) -> String {
    format!("Z:{}", path.display())
}

/// The folder with the Embree 4 for Windows that PyPI has, and its TBB.
fn embree() -> Result<PathBuf, String> {
    let folder = Platform::Windows.folder().join("embree");
    let libraries = folder.join("embreex.libs");
    if !libraries.exists() {
        let python = wheel::tools()?;
        let files = folder.join("files");
        remove(&files)?;
        let mut download = Command::new(&python);
        download.args(["-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]);
        download.args(["--only-binary=:all:", "--platform", "win_amd64", "--python-version", "3.11", EMBREE_4]);
        call(download.arg("--dest").arg(&files))?;
        call(Command::new(&python).args(["-m", "zipfile", "--extract"]).arg(only_file(&files)?).arg(&folder))?;
    }
    Ok(libraries)
}

/// Where the library is that Wine 8 lacks.
fn stand_in() -> PathBuf {
    Platform::Windows.folder().join("stand-in")
}

/// The file of a library of the compiler.
fn beside(name: &str) -> Result<PathBuf, String> {
    let mut compiler = Command::new(format!("{MINGW}-g++-posix"));
    Ok(output(compiler.arg(format!("-print-file-name={name}")))?.trim().into())
}

fn windows(stages: &mut Stages) {
    let platform = Platform::Windows;
    if stages.run("Windows: libraries", 4, libraries)
        && stages.run("Windows: check", 8, || check(platform))
        && stages.run("Windows: tests", 6, || test(platform, &TESTED_IN_WINE))
        && stages.run("Windows: build", 20, || {
            let mut build = cargo_for(platform);
            call(build.args(["build", "--release", "--package", "relievo-capi", "--target", platform.triple()]))
        })
    {
        stages.run("Windows: C tests", 8, windows_tests);
    }
}

/// Builds OpenSubdiv and OpenMesh as static libraries, and the library that Wine lacks.
fn libraries() -> Outcome {
    let folder = Platform::Windows.folder();
    let sources = folder.join("sources");
    make(&sources.join("lists/partial"))?;
    make(&sources.join("cache/archives/partial"))?;
    let list = sources.join("sources.list");
    let key = "/usr/share/keyrings/debian-archive-keyring.gpg";
    let text = format!("deb-src [signed-by={key}] {DEBIAN} bookworm main\n");
    std::fs::write(&list, text).map_err(|error| format!("{}: {error}", list.display()))?;
    // Lists of its own, so that those of the system stay without sources.
    let apt = || {
        let mut apt = Command::new("apt-get");
        let option = |name: &str, value: &Path| format!("-o{name}={}", value.display());
        apt.current_dir(&sources).arg("--quiet").arg(option("Dir::Etc::SourceList", &list));
        apt.arg(option("Dir::Etc::SourceParts", Path::new("/dev/null")));
        apt.arg(option("Dir::State::Lists", &sources.join("lists")));
        apt.arg(option("Dir::Cache", &sources.join("cache")));
        // The user that apt takes for downloads may not write into this folder.
        apt.arg("-oAPT::Sandbox::User=root");
        apt
    };
    if SOURCES.iter().any(|name| unpacked(&sources, name).is_err()) {
        call(apt().arg("update"))?;
        call(apt().arg("source").args(SOURCES))?;
    }
    let build = folder.join("build");
    let mut configure = Command::new("cmake");
    configure.arg("-S").arg(root().join("cmake/windows")).arg("-B").arg(&build).args(cross());
    configure.arg(format!("-DCMAKE_INSTALL_PREFIX={}", folder.join("prefix").display()));
    configure.arg(format!("-DOPENSUBDIV={}", unpacked(&sources, "opensubdiv")?.display()));
    configure.arg(format!("-DOPENMESH={}", unpacked(&sources, "openmesh")?.display()));
    call(&mut configure)?;
    call(Command::new("cmake").arg("--build").arg(&build).args(["--target", "install"]))?;
    make(&stand_in())?;
    let mut compiler = Command::new(format!("{MINGW}-gcc-posix"));
    compiler.args(["-O2", "-shared", "-o"]).arg(stand_in().join("bcryptprimitives.dll"));
    call(compiler.arg(root().join("tests/platforms/bcryptprimitives.c")).arg("-ladvapi32"))
}

/// The folder with the sources of a package.
fn unpacked(sources: &Path, name: &str) -> Result<PathBuf, String> {
    let start = format!("{name}-");
    let entries = std::fs::read_dir(sources).map_err(|error| format!("{}: {error}", sources.display()))?;
    let mut folders = entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir());
    let is_it = |path: &PathBuf| path.file_name().is_some_and(|file| file.to_string_lossy().starts_with(&start));
    folders.find(is_it).ok_or_else(|| format!("{}: there are no sources of {name}", sources.display()))
}

/// What CMake is to know of the compiler.
fn cross() -> [String; 6] {
    [
        "-GNinja".into(),
        "-DCMAKE_SYSTEM_NAME=Windows".into(),
        "-DCMAKE_BUILD_TYPE=Release".into(),
        format!("-DCMAKE_C_COMPILER={MINGW}-gcc-posix"),
        format!("-DCMAKE_CXX_COMPILER={MINGW}-g++-posix"),
        // Programs of tests carry the libraries of the compiler.
        "-DCMAKE_EXE_LINKER_FLAGS=-static".into(),
    ]
}

/// Compiles the C tests, and runs them in Wine beside the DLL.
fn windows_tests() -> Outcome {
    let platform = Platform::Windows;
    let tests = platform.folder().join("tests");
    let built = target().join(platform.triple()).join("release");
    copy(&built.join("relievo.dll"), &tests.join("relievo.dll"))?;
    for name in BESIDE {
        copy(&beside(name)?, &tests.join(name))?;
    }
    let mut configure = Command::new("cmake");
    configure.arg("-S").arg(root().join("tests/platforms")).arg("-B").arg(&tests).args(cross());
    configure.arg(format!("-DRELIEVO_LIBRARY={}", built.join("librelievo.dll.a").display()));
    call(configure.arg(format!("-DCMAKE_CROSSCOMPILING_EMULATOR={WINE}")))?;
    call(Command::new("cmake").arg("--build").arg(&tests))?;
    let embree = embree()?;
    let mut ctest = Command::new("ctest");
    // Wine 8 now and then kills a process with threads that has ended by itself, which looks like a failure.
    ctest.args(["--output-on-failure", "--repeat", "until-pass:3", "--test-dir"]).arg(&tests).envs(wine());
    // What Embree is linked to is looked for in the folders of the path, not in its own.
    ctest.env("WINEPATH", [on_windows(&stand_in()), on_windows(&embree)].join(";"));
    call(ctest.env("RELIEVO_EMBREE", on_windows(&embree.join("embree4.dll"))))
}

fn make(folder: &Path) -> Outcome {
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))
}

/// What is checked for macOS: what differs there is in the crates that bind libraries.
const BINDINGS: [&str; 5] = ["core", "embree", "openvdb", "opensubdiv", "openmesh"];

/// Checks crates. Their C++ is not compiled, which would take Apple's headers: build scripts get programs that make empty
/// files, and a check links nothing.
fn macos() -> Outcome {
    let folder = Platform::Macos.folder();
    make(&folder)?;
    let stand_in = |name: &str, text: &str| -> Result<PathBuf, String> {
        let path = folder.join(name);
        let fault = |error: std::io::Error| format!("{}: {error}", path.display());
        std::fs::write(&path, text).map_err(fault)?;
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).map_err(fault)?;
        Ok(path)
    };
    let compiler = stand_in("compiler", COMPILER)?;
    let mut check = cargo_for(Platform::Macos);
    for name in ["CC_aarch64_apple_darwin", "CXX_aarch64_apple_darwin"] {
        check.env(name, &compiler);
    }
    check.env("AR_aarch64_apple_darwin", stand_in("archiver", ARCHIVER)?).env("SDKROOT", &folder);
    check.args(["check", "--lib", "--target", Platform::Macos.triple()]);
    call(check.args(BINDINGS.iter().flat_map(|name| ["--package".into(), format!("relievo-{name}")])))
}

/// Makes the file that is named after `-o`, empty.
const COMPILER: &str = "#!/bin/sh
for word; do
  if [ \"$last\" = -o ]; then : > \"$word\"; fi
  last=$word
done
";
/// Makes the archive that is named after the operation, empty.
const ARCHIVER: &str = "#!/bin/sh
: > \"$2\"
";
