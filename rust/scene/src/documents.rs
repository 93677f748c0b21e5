//! Documents of the surfaces of a scene: opened where an object starts from one, written where the scene asks for it.
//!
//! A document has a layer `displacement` and, of objects that are painted, a layer `colour`, of those that keep traces of
//! contact a layer `traces`, and of those with vector displacement a layer `vectors`.

use std::path::PathBuf;

use relievo_core::{Context, Mesh, Result};
use relievo_detail::{DisplacedObject, LayeredObject};
use relievo_document::Document;
use relievo_document::format::EXTENSION;

use crate::output::Folder;
use crate::paths::Paths;
use crate::world::{Item, World};

/// A document that an object starts from.
#[derive(Debug)]
pub struct Start {
    /// The document.
    pub document: Document,
    /// CRC-32 of its file.
    pub checksum: u32,
    /// What the user should know of it.
    pub notes: Vec<String>,
}

/// Opens the document that the scene calls `written`. Fails if it is damaged or was made on another mesh than `cage`.
pub fn open(context: &Context, paths: &Paths, written: &str, cage: &Mesh) -> Result<Start> {
    let path = paths.resolve(written)?;
    let checksum = crate::assets::checksum(&path)?;
    let document = Document::open(&path, context.memory_limit())?;
    let mut notes = document.notes.clone();
    notes.extend(document.fit(cage).map_err(|error| error.at(path.display().to_string()))?);
    Ok(Start { document, checksum, notes })
}

impl Start {
    /// Gives `object` what the document has, in `budget` bytes each layer, and notes what it cannot have.
    pub fn take_up(&mut self, context: &Context, object: &mut DisplacedObject, budget: u64) -> Result<()> {
        let unknown = object.take_up(context, &self.document, budget)?;
        self.notes.extend(unknown.into_iter().map(|name| format!("layer `{name}` of its document is left out")));
        Ok(())
    }
}

/// The document of the surface that an object shows.
pub(crate) fn document(context: &Context, world: &World, index: usize, surface: &DisplacedObject) -> Result<Document> {
    let mut document = Document::new(world.cage(index), context.level().name())?;
    surface.store(context, &mut document)?;
    Ok(document)
}

/// Writes the document of every surface. Returns the files.
pub fn write(context: &Context, world: &World, folder: &Folder, frame: u32) -> Result<Vec<PathBuf>> {
    let _stage = context.stats().begin("export.documents");
    let mut written = Vec::new();
    for (index, item) in world.items().iter().enumerate() {
        let Item::Surface(surface) = item else { continue };
        let document = document(context, world, index, surface)?;
        let name = &world.scene.objects[index].name.text;
        let path = folder.file(&format!("document-{frame:06}-{name}.{EXTENSION}"));
        document.write(&path)?;
        written.push(path);
    }
    Ok(written)
}
