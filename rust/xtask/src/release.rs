//! `cargo xtask release --dry-run`: makes all files of a release in one folder and checks them. Nothing is published: whoever
//! releases uploads the folder.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::files::{copy, remove};
use crate::stage::{Outcome, call, output, root, target};
use crate::{bindings, dist, licences, sbom};

/// The version of a release: that of the workspace.
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// The sums of all files, as `sha256sum --check` reads them.
const SUMS: &str = "SHA256SUMS";
/// Bytes that a wheel or a zip file for Blender has at most.
const LIMIT: u64 = 30_000_000;

/// Makes the packages, the wheel, the zip files, the notices and the list of what is linked, checks all of them, and prints a
/// table.
pub fn run() -> Outcome {
    is_clean()?;
    versions()?;
    licences::check()?;
    bindings::run(true)?;
    abi()?;
    let folder = target().join("release-files");
    remove(&folder)?;
    dist::run(true)?;
    let packages = files(&target().join("dist/packages"))?;
    // The zip files hold the wheel too, which was made for them.
    let wheels = files(&target().join("wheel/dist"))?;
    for file in packages.iter().chain(&wheels) {
        copy(file, &folder.join(file.file_name().unwrap_or_default()))?;
    }
    licences::write(&folder.join("third-party.txt"))?;
    sbom::write(&folder.join(format!("relievo-{VERSION}.spdx.json")))?;
    copy(&root().join("CHANGELOG.md"), &folder.join("CHANGELOG.md"))?;
    sums(&folder)?;
    print(&folder)
}

/// Fails unless the tree is that of a commit.
fn is_clean() -> Outcome {
    let changed = output(Command::new("git").current_dir(root()).args(["status", "--porcelain"]))?;
    if changed.is_empty() {
        return Ok(());
    }
    Err(format!("the tree differs from its commit; commit the changes or put them aside:\n{changed}"))
}

/// Fails unless all files that state the version of the library state that of the workspace.
pub fn versions() -> Outcome {
    let parts: Vec<&str> = VERSION.split('.').collect();
    let [major, minor, patch] = parts[..] else { return Err(format!("{VERSION} is no version of three numbers")) };
    let stated = [
        ("include/relievo/version.h", format!("#define RLV_VERSION_MAJOR {major}\n")),
        ("include/relievo/version.h", format!("#define RLV_VERSION_MINOR {minor}\n")),
        ("include/relievo/version.h", format!("#define RLV_VERSION_PATCH {patch}\n")),
        ("plugins/python/pyproject.toml", format!("\nversion = \"{VERSION}\"\n")),
        ("plugins/blender/blender_manifest.toml", format!("\nversion = \"{VERSION}\"\n")),
        ("plugins/blender/blender_manifest.toml", format!("/librelievo-{VERSION}-")),
        ("plugins/blender/__init__.py", format!("\"version\": ({major}, {minor}, {patch}),")),
        ("CHANGELOG.md", format!("\n## [{VERSION}]")),
    ];
    for (file, text) in stated {
        let path = root().join(file);
        let whole = std::fs::read_to_string(&path).map_err(|error| format!("{file}: {error}"))?;
        if !whole.contains(&text) {
            return Err(format!("{file} does not state version {VERSION}: it lacks {:?}", text.trim()));
        }
    }
    Ok(())
}

/// Fails unless the headers declare the binary interface that was agreed on.
fn abi() -> Outcome {
    let define = |name: &str, path: &Path| format!("-D{name}={}", path.display());
    let mut compare = Command::new("cmake");
    compare.arg(define("HEADERS", &root().join("include")));
    compare.arg(define("BASELINE", &root().join("tests/c/abi.xml.gz")));
    compare.arg(define("WORK", &target().join("abi")));
    call(compare.arg("-P").arg(root().join("tests/c/abi.cmake")))
}

/// Returns the files of a folder, in order.
fn files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(|path| path.is_file()).collect();
    files.sort();
    Ok(files)
}

/// Writes the sums of the files of a folder, and checks them.
fn sums(folder: &Path) -> Outcome {
    let names = files(folder)?.into_iter().filter_map(|path| path.file_name().map(ToOwned::to_owned));
    let text = output(Command::new("sha256sum").current_dir(folder).arg("--").args(names))?;
    std::fs::write(folder.join(SUMS), text).map_err(|error| format!("{SUMS}: {error}"))?;
    call(Command::new("sha256sum").current_dir(folder).args(["--check", "--strict", "--quiet", SUMS]))
}

/// Prints the files with their sizes. Fails if a wheel or a zip file is larger than the limit.
fn print(folder: &Path) -> Outcome {
    println!("\n{} {VERSION}", folder.display());
    let mut large = Vec::new();
    for file in files(folder)? {
        let size = file.metadata().map_err(|error| format!("{}: {error}", file.display()))?.len();
        let extension = file.extension().unwrap_or_default();
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        println!("{:>8.2} MB  {name}", size as f64 / 1e6);
        if (extension == "whl" || extension == "zip") && size > LIMIT {
            large.push(name);
        }
    }
    if large.is_empty() { Ok(()) } else { Err(format!("larger than {} MB: {}", LIMIT / 1_000_000, large.join(", "))) }
}

#[cfg(test)]
mod tests {
    #[test]
    fn all_files_state_the_same_version() {
        super::versions().unwrap();
    }
}
