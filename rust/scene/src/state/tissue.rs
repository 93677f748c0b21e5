//! Soft tissue: descriptions of models and simulations in TOML, tissue that a scene simulates (`[[tissue]]`), and meshes
//! that follow it.

mod body;
mod motion;
mod recipe;
mod run;
mod surface;

use std::path::{Path, PathBuf};

use relievo_core::error::nearest;
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Result, file};
use relievo_tissue::Model;
use serde::de::DeserializeOwned;

pub use body::Body;
pub use motion::Motion;
pub use recipe::Recipe;
pub(crate) use run::{Solid, Tissue, truncate};
pub(crate) use surface::TissueSurface;

/// Bytes of a description at most.
const LONGEST: u64 = 1 << 22;

/// Reads a description in TOML. An unknown key is an error that names the one that may be meant.
fn description<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let named = |error: Error| error.at(path.display().to_string());
    let bytes = file::load(path, LONGEST)?;
    let text = std::str::from_utf8(&bytes).map_err(|_| named(Error::invalid("it is not UTF-8 text")))?;
    toml::from_str(text).map_err(|error| {
        let described = Error::invalid(error.to_string());
        let mut names = error.message().split('`').skip(1).step_by(2);
        let word = names.next().filter(|_| error.message().starts_with("unknown"));
        named(match word.and_then(|word| nearest(word, names)) {
            Some(name) => described.advise(format!("perhaps `{name}` is meant")),
            None => described,
        })
    })
}

/// Returns the folder of a file, from which other files are named.
fn folder(path: &Path) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).to_owned()
}

/// Returns whether the extension of a path is `extension`.
pub fn is_named(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// Reads a model (`.rtissue`, or Abaqus' `.inp`) or builds that of a description (`.toml`). Returns also notes on what was
/// passed over.
///
/// # Errors
/// Fails with `NotFound` or `Io` if a file cannot be read, with `Memory` if memory does not suffice, with `Invalid` if
/// the file is damaged or no model can be made of it, and with `Unsupported` if it is of another version.
pub fn read_model(context: &Context, path: &Path) -> Result<(Model, Vec<String>)> {
    if is_named(path, "toml") {
        return Ok((Recipe::read(path)?.build(context, &mut Silent)?.0, Vec::new()));
    }
    if is_named(path, "inp") {
        let read = Model::read_inp(context, path)?;
        let notes = read.notes.iter().map(|note| format!("{}: {note}", path.display())).collect();
        return Ok((read.model, notes));
    }
    Ok((Model::read(context, path)?, Vec::new()))
}
