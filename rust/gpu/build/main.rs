//! Lists the WGSL modules of `shaders/`, in all of its folders, for `src/module.rs`, and writes the structs that host and
//! shader share in Rust, for `src/wgsl.rs`.

mod layout;
mod rust;
mod wgsl;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let root = fs::canonicalize("../../shaders")?;
    let mut files = Vec::new();
    collect(&root, &mut files)?;
    files.sort_by(|a, b| a.file_stem().cmp(&b.file_stem()));
    let mut list = String::from("&[\n");
    let mut modules = Vec::new();
    for file in files {
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let place = file.strip_prefix(&root).unwrap_or(&file).to_string_lossy().replace('\\', "/");
        let _ = writeln!(list, "Module {{ name: {name:?}, file: {place:?}, text: include_str!({:?}) }},", file);
        modules.push(wgsl::Module::read(&name, &place, &fs::read_to_string(&file)?).map_err(io::Error::other)?);
    }
    list.push(']');
    let out = env::var_os("OUT_DIR").ok_or_else(|| io::Error::other("OUT_DIR is not set"))?;
    fs::write(Path::new(&out).join("modules.rs"), list)?;
    let structs = rust::write(&layout::Modules(modules)).map_err(io::Error::other)?;
    fs::write(Path::new(&out).join("wgsl.rs"), structs)
}

/// Adds the WGSL files of `folder` and of the folders in it to `files`. Cargo runs this script again when one changes.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    println!("cargo::rerun-if-changed={}", folder.display());
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "wgsl") {
            files.push(path);
        }
    }
    Ok(())
}
