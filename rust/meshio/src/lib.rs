//! Readers and writers of mesh files.
//!
//! Files are hostile until read: every size is checked against the file's length and the memory limit before anything
//! is allocated, every index before it is used. Errors name the file and the line or element.

mod budget;
mod color;
mod file;
mod model;
mod notes;
mod obj;
mod ply;
mod ply_header;
mod text;

use std::path::Path;

use relievo_core::{Context, Error, Mesh, Result};

pub use model::{Animation, Channel, Interpolation, Model, Node, Part, Placement, Property, Skin};
pub use obj::read_obj;
pub use ply::read_ply;

/// Formats that can be read, by extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Obj,
    Ply,
}

impl Format {
    /// The format that the first bytes of a file show, or else its extension.
    fn of(path: &Path, _bytes: &[u8]) -> Result<Self> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("obj") => Ok(Self::Obj),
            Some("ply") => Ok(Self::Ply),
            _ => Err(Error::unsupported("the format of the file is not known").advise("use OBJ or PLY")),
        }
    }
}

/// Reads a mesh. See [`read_model`].
pub fn read(context: &Context, path: &Path) -> Result<Mesh> {
    let model = read_model(context, path)?;
    Ok(model.meshes.into_iter().next().unwrap_or_default().mesh)
}

/// Reads everything a file holds. The context's memory limit bounds the file and what is made of it together.
///
/// Indices are in range and numbers finite in what is returned; whether the faces can be used says
/// [`Mesh::check`].
pub fn read_model(context: &Context, path: &Path) -> Result<Model> {
    let named = |error: Error| error.at(path.display().to_string());
    let limit = context.memory_limit();
    let bytes = file::load(path, limit)?;
    let left = limit - bytes.len() as u64;
    let model = match Format::of(path, &bytes).map_err(named)? {
        Format::Obj => read_obj(&bytes, left),
        Format::Ply => read_ply(&bytes, left),
    };
    model.map_err(named)
}
