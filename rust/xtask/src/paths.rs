//! Folders of the machine that builds: messages of panics name the source files below them, and packages should not.

use std::path::{Path, PathBuf};

use crate::stage::{Outcome, root, target};

/// Returns the folders whose names are overwritten: Cargo's, rustup's, the build's and that of the workspace.
fn hidden() -> Vec<PathBuf> {
    let of_user = |variable: &str, name: &str| {
        let home = || std::env::home_dir().map(|home| home.join(name));
        std::env::var_os(variable).map(PathBuf::from).or_else(home)
    };
    let user = [("CARGO_HOME", ".cargo"), ("RUSTUP_HOME", ".rustup")];
    let mut all = vec![target(), root()];
    all.extend(user.into_iter().filter_map(|(variable, name)| of_user(variable, name)));
    // Of two of which one is in the other, the inner one goes first.
    all.sort_by_key(|folder| std::cmp::Reverse(folder.as_os_str().len()));
    all
}

/// Overwrites the names of these folders in a library or program.
///
/// rustc's `--remap-path-prefix` would leave them out, but other flags build every crate a second time beside the build that
/// is tested. So each name becomes a dot and slashes of the same length: nothing moves, and the names lie in messages alone,
/// which `.rodata` has with their lengths.
pub fn hide(file: &Path) -> Outcome {
    let failed = |error: std::io::Error| format!("{}: {error}", file.display());
    let mut bytes = std::fs::read(file).map_err(failed)?;
    hidden().iter().for_each(|folder| overwrite(&mut bytes, folder));
    std::fs::write(file, bytes).map_err(failed)
}

fn overwrite(bytes: &mut [u8], folder: &Path) {
    let Some(name) = name(folder) else { return };
    let mut from = 0;
    while let Some(found) = bytes.get(from..).and_then(|rest| find(rest, &name)) {
        let end = from + found + name.len();
        bytes[from + found..end].fill(b'/');
        bytes[from + found] = b'.';
        from = end;
    }
}

/// Returns what a file has where it names something in `folder`; `None` for the root of all files.
fn name(folder: &Path) -> Option<Vec<u8>> {
    let text = folder.to_str().filter(|_| folder.parent().is_some())?;
    Some(format!("{}/", text.trim_end_matches('/')).into_bytes())
}

fn find(bytes: &[u8], name: &[u8]) -> Option<usize> {
    bytes.windows(name.len()).position(|window| window == name)
}

/// Checks that no file in `folder`, or below it, names the folders that [`hide`] overwrites or the user's own.
pub fn check(folder: &Path) -> Outcome {
    let names: Vec<Vec<u8>> = hidden().into_iter().chain(std::env::home_dir()).filter_map(|path| name(&path)).collect();
    let mut left = vec![folder.to_owned()];
    while let Some(folder) = left.pop() {
        for entry in std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?.flatten() {
            let path = entry.path();
            if path.is_dir() {
                left.push(path);
                continue;
            }
            let bytes = std::fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
            if let Some(name) = names.iter().find(|name| find(&bytes, name).is_some()) {
                return Err(format!("{} names {}", path.display(), String::from_utf8_lossy(name)));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_folders_are_overwritten_at_their_length() {
        let mut bytes = b"x/home/me/.cargo/registry/a.rsat/home/me/.cargo/b.rs/home/me/.cargos".to_vec();
        overwrite(&mut bytes, Path::new("/home/me/.cargo"));
        let expected: &[u8] = b"x.///////////////registry/a.rsat.///////////////b.rs/home/me/.cargos";
        assert_eq!(String::from_utf8_lossy(&bytes), String::from_utf8_lossy(expected));
        overwrite(&mut bytes, Path::new("/"));
        assert_eq!(bytes, expected);
    }

    #[test]
    fn files_that_name_folders_of_this_machine_are_refused() {
        let folder = target().join("tmp/paths");
        std::fs::create_dir_all(folder.join("lib")).unwrap();
        let file = folder.join("lib/library.so");
        std::fs::write(&file, format!("\u{7f}ELF{}/rust/xtask/a.rs", root().display())).unwrap();
        assert!(check(&folder).unwrap_err().contains("library.so names"));
        hide(&file).unwrap();
        check(&folder).unwrap();
        assert!(std::fs::read(&file).unwrap().ends_with(b"/rust/xtask/a.rs"));
    }
}
