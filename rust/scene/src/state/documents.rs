//! Documents of the surfaces of a scene: opened where an object starts from one, written where the scene asks for it.
//!
//! A document has a layer `displacement` and, of objects that are painted, a layer `colour`, of objects that keep
//! traces of contact a layer `traces`, and of those with vector displacement a layer `vectors`.

use std::path::PathBuf;

use relievo_core::{Context, Mesh, Result};
use relievo_detail::LayeredObject;
use relievo_document::Document;
use relievo_document::format::EXTENSION;

use crate::out::output::Folder;
use crate::state::paths::Paths;
use crate::state::world::{Item, World};

/// A document that an object starts from.
#[derive(Debug)]
pub struct Start {
    path: PathBuf,
    /// The document.
    pub document: Document,
    /// CRC-32 of its file.
    pub checksum: u32,
    /// What the user should know of it.
    pub notes: Vec<String>,
}

/// Opens the document that the scene calls `written`. Fails if it is damaged.
pub fn open(context: &Context, paths: &Paths, written: &str) -> Result<Start> {
    let path = paths.resolve(written)?;
    let checksum = crate::state::checksum::checksum(&path)?;
    let document = Document::open(&path, context.memory_limit())?;
    let notes = document.notes.clone();
    Ok(Start { path, document, checksum, notes })
}

impl Start {
    /// Fails unless it was made on the Catmull-Clark surface over `cage`.
    pub fn fit(&mut self, cage: &Mesh) -> Result<()> {
        self.notes.extend(self.document.fit(cage).map_err(|error| error.at(self.path.display().to_string()))?);
        Ok(())
    }

    /// Fails unless it was made on the triangles of `mesh`.
    pub fn fit_triangles(&self, mesh: &Mesh) -> Result<()> {
        self.document.fit_triangles(mesh).map_err(|error| error.at(self.path.display().to_string()))
    }

    /// Gives `object` what the document has, in `budget` bytes each layer, and notes what it cannot have.
    pub fn take_up(&mut self, context: &Context, object: &mut impl LayeredObject, budget: u64) -> Result<()> {
        let unknown = object.take_up(context, &self.document, budget)?;
        self.notes.extend(unknown.into_iter().map(|name| format!("layer `{name}` of its document is left out")));
        Ok(())
    }
}

/// The document of the surface that an object shows; `None` if it shows a mesh.
pub(crate) fn document(context: &Context, world: &World, index: usize) -> Result<Option<Document>> {
    let (mesh, level) = (world.cage(index), context.level().name());
    let mut document = match world.items().get(index) {
        Some(Item::Surface(_)) => Document::new(mesh, level)?,
        Some(Item::Triangles(_)) => Document::of_triangles(mesh, level)?,
        _ => return Ok(None),
    };
    match world.items().get(index) {
        Some(Item::Surface(surface)) => surface.store(context, &mut document)?,
        Some(Item::Triangles(item)) => item.object.store(context, &mut document)?,
        _ => {}
    }
    Ok(Some(document))
}

/// Writes the document of every surface. Returns the files.
pub fn write(context: &Context, world: &World, folder: &Folder, frame: u32) -> Result<Vec<PathBuf>> {
    let _stage = context.stats().begin("export.documents");
    let mut written = Vec::new();
    for index in 0..world.items().len() {
        let Some(document) = document(context, world, index)? else { continue };
        let name = &world.scene.objects[index].name.text;
        let path = folder.file(&format!("document-{frame:06}-{name}.{EXTENSION}"));
        document.write(&path)?;
        written.push(path);
    }
    Ok(written)
}
