//! The files that a description of a fluid names, from the folder that it lies in.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use relievo_core::{Context, Mesh, Result};
use relievo_simulation::{Files, Source};

use crate::doc::displaced;

/// The folder of a description.
#[derive(Debug)]
struct Folder(PathBuf);

/// Returns the files that are named from the folder of the description at `path`.
pub fn beside(path: &Path) -> Source {
    Arc::new(Folder(path.parent().unwrap_or(Path::new("")).to_owned()))
}

impl Files for Folder {
    fn path(&self, name: &Path) -> Result<PathBuf> {
        Ok(self.0.join(name))
    }

    fn displaced(
        &self,
        context: &Context,
        document: &Path,
        mesh: &Mesh,
        (layer, cells): (Option<&str>, u32),
    ) -> Result<Mesh> {
        let path = self.0.join(document);
        let (made, notes) = displaced::mesh(context, &path, mesh, layer, cells)?;
        notes.iter().for_each(|note| eprintln!("note: {}: {note}", path.display()));
        Ok(made)
    }
}
