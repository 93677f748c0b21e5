//! Where the files are that a description names.

use std::fmt::Debug;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use relievo_core::{Context, Error, Mesh, Result};

/// Finds the files that a description names.
pub trait Files: Debug + Send + Sync {
    /// Returns the path of the file called `name` in the description.
    ///
    /// # Errors
    /// Fails if the files have none of this name.
    fn path(&self, name: &Path) -> Result<PathBuf>;

    /// Displaces `mesh` by the document called `document` in the description: by the layer of this name alone or,
    /// without one, by all layers together, with so many cells along an edge of the cage.
    ///
    /// # Errors
    /// Fails if the document cannot be read or does not fit the mesh, and with `Unsupported` if these files displace no
    /// meshes.
    fn displaced(&self, context: &Context, document: &Path, mesh: &Mesh, shown: (Option<&str>, u32)) -> Result<Mesh>;
}

/// Files that several parts of a simulation read.
pub type Source = Arc<dyn Files>;

/// A folder of files. It displaces no meshes.
#[derive(Debug)]
struct Folder(PathBuf);

/// Returns the files that are named from a folder. Meshes that a document displaces are refused.
pub fn in_folder(folder: &Path) -> Source {
    Arc::new(Folder(folder.to_owned()))
}

impl Files for Folder {
    fn path(&self, name: &Path) -> Result<PathBuf> {
        Ok(self.0.join(name))
    }

    fn displaced(&self, _: &Context, document: &Path, _: &Mesh, _: (Option<&str>, u32)) -> Result<Mesh> {
        Err(Error::unsupported("meshes are not displaced by documents here")
            .at(document.display().to_string())
            .advise("write the displaced mesh by `relievo doc export`, and name that"))
    }
}
