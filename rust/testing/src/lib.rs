//! Cages for tests and benches, random ones and models beside the checkout, and characters; the graphics device of
//! tests. Nothing that is shipped uses this crate.

mod ball;
mod device;
mod grid;
mod limbs;
mod patches;

use std::path::PathBuf;

use relievo_core::{Context, Mesh};

pub use ball::ball;
pub use device::device;
pub use grid::{Random, grid};
pub use limbs::{Limb, write_limbs};
pub use patches::tea_set;

/// The folder of models: `RELIEVO_DATA`, or `shared/data` beside the checkout. It need not be there.
pub fn folder() -> PathBuf {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    std::env::var_os("RELIEVO_DATA").map_or_else(|| beside.into(), PathBuf::from)
}

/// The folder of models, or `None`, with a word about it, where there is none.
pub fn data() -> Option<PathBuf> {
    present(folder())
}

/// A file in the folder of models, or `None`, with a word about it, where there is no such file.
pub fn file(name: &str) -> Option<PathBuf> {
    present(folder().join(name))
}

fn present(path: PathBuf) -> Option<PathBuf> {
    if path.exists() {
        return Some(path);
    }
    println!("skipped: {} is not here", path.display());
    None
}

/// A cage of the folder of models, or `None`, with a word about it, where there is no such file.
///
/// # Panics
/// If the file cannot be read.
pub fn cage(name: &str) -> Option<Mesh> {
    let path = file(&format!("cages/{name}"))?;
    Some(relievo_meshio::read(&Context::serial(), &path).unwrap_or_else(|error| panic!("{error}")))
}
