//! `cargo xtask dist`: what is handed out. An archive and a Debian package of the library, its headers and package files,
//! the command with its manual pages, and the licences of what is linked. CPack makes them by the install rules of
//! `CMakeLists.txt`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::files::{only_file, remove, strip};
use crate::licences;
use crate::packages;
use crate::stage::{Outcome, call, cargo, root, target};

/// What is handed out, by its file.
pub struct Packages {
    pub archive: PathBuf,
    pub debian: PathBuf,
}

/// Builds the library and the command, and makes the packages; uses them too for a `test`.
pub fn run(test: bool) -> Outcome {
    call(cargo().args(["build", "--release", "--package", "relievo-capi", "--package", "relievo-cli"]))?;
    let made = make()?;
    println!("{}\n{}", made.archive.display(), made.debian.display());
    if test { test_made(&made) } else { Ok(()) }
}

/// Makes the packages of what was built.
pub fn make() -> Result<Packages, String> {
    let folder = target().join("dist");
    let built = folder.join("built");
    for name in ["librelievo.so", "relievo"] {
        strip(&target().join("release").join(name), &built.join(name))?;
    }
    call(Command::new(built.join("relievo")).arg("manual").arg(built.join("man")))?;
    licences::write(&built.join("third-party.txt"))?;
    Ok(Packages {
        archive: pack(&folder, &built, "TGZ", &["-DCMAKE_INSTALL_LIBDIR=lib"])?,
        // On Debian libraries are in a folder of the architecture, which CMake finds out for this prefix.
        debian: pack(&folder, &built, "DEB", &["-DCMAKE_INSTALL_PREFIX=/usr"])?,
    })
}

/// Has CPack make one package.
fn pack(folder: &Path, built: &Path, generator: &str, options: &[&str]) -> Result<PathBuf, String> {
    let (build, out) = (folder.join(generator), folder.join(format!("{generator}-package")));
    remove(&out)?;
    let mut configure = Command::new("cmake");
    configure.arg("-S").arg(root()).arg("-B").arg(&build).args(["-G", "Ninja"]).args(options);
    configure.arg(format!("-DRELIEVO_LIBRARY_DIR={}", built.display()));
    call(configure.arg(format!("-DRELIEVO_EXTRAS_DIR={}", built.display())))?;
    call(Command::new("cpack").current_dir(&build).args(["-G", generator, "-B"]).arg(&out))?;
    // CPack leaves its working folder beside the package.
    remove(&out.join("_CPack_Packages"))?;
    only_file(&out)
}

/// Makes the packages and uses each.
pub fn test() -> Outcome {
    test_made(&make()?)
}

/// Uses each package where nothing else of ours is: the archive in a prefix of its own, the Debian package in a bare
/// Debian 12.
fn test_made(made: &Packages) -> Outcome {
    test_archive(&made.archive)?;
    test_debian(&made.debian)
}

fn test_archive(archive: &Path) -> Outcome {
    let folder = target().join("dist/prefix");
    remove(&folder)?;
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    call(Command::new("tar").arg("-xzf").arg(archive).arg("--strip-components=1").arg("-C").arg(&folder))?;
    for file in
        ["share/man/man1/relievo-run.1", "share/doc/relievo/third-party.txt", "lib/cmake/Relievo/RelievoConfig.cmake"]
    {
        if !folder.join(file).is_file() {
            return Err(format!("the archive lacks {file}"));
        }
    }
    let consumer = root().join("tests/hosts/pkg-config-consumer/run.sh");
    call(Command::new("sh").arg(consumer).arg(&folder).arg(target().join("dist/consumer")).arg("cc"))?;
    let out = target().join("dist/run");
    remove(&out)?;
    let mut run = Command::new(folder.join("bin/relievo"));
    call(run.arg("run").arg(root().join(SCENE)).args(["--frames", "0..1", "--out"]).arg(out))
}

/// What the packages are tried with: it makes pictures, so that Embree is found too.
const SCENE: &str = "examples/scenes/press.toml";

/// Installs the package with what it depends on into a bare system, and runs a scene there.
fn test_debian(package: &Path) -> Outcome {
    if !packages::is_root() {
        println!("skipped: only root can make a bare Debian to install the package in");
        return Ok(());
    }
    let hook = |line: &str| OsString::from(format!("--customize-hook={line}"));
    let into = |file: &Path| hook(&format!("copy-in '{}' /tmp", file.display()));
    let name = package.file_name().unwrap_or_default().to_string_lossy();
    let mut bare = Command::new("mmdebstrap");
    bare.args(["--quiet", "--variant=apt"]).arg(into(package)).arg(into(&root().join(SCENE)));
    bare.arg(hook(&format!("chroot \"$1\" apt-get install --yes --install-recommends --quiet=2 /tmp/{name}")));
    bare.arg(hook("chroot \"$1\" sh -c 'cd /tmp && relievo run press.toml --frames 0..1 --out out && ls out/*.png'"));
    call(bare.args(["bookworm", "/dev/null"]))
}
