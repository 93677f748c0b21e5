//! Documents of the surfaces of a scene: opened where an object starts from one, written where the scene asks for it.
//!
//! A document has a layer `displacement` and, of objects that are painted, a layer `colour`, and of those
//! that keep traces of contact a layer `traces`.

use std::path::PathBuf;
use std::sync::Arc;

use relievo_core::{Context, Mesh, Result};
use relievo_detail::DisplacedObject;
use relievo_document::Document;
use relievo_document::format::EXTENSION;
use relievo_surface::TileTopology;
use relievo_tiles::{Displacement, Paint, Traces};

use crate::output::Folder;
use crate::paths::Paths;
use crate::world::{Item, World};

const DISPLACEMENT: &str = "displacement";
const COLOUR: &str = "colour";
const TRACES: &str = "traces";

/// A document that an object starts from.
#[derive(Debug)]
pub struct Start {
    document: Document,
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
    let unknown = document.layers().iter().filter(|layer| ![DISPLACEMENT, COLOUR, TRACES].contains(&layer.name()));
    notes.extend(unknown.map(|layer| {
        format!(
            "layer `{}` of its document is left out; `{DISPLACEMENT}`, `{COLOUR}` and `{TRACES}` are used",
            layer.name()
        )
    }));
    Ok(Start { document, checksum, notes })
}

impl Start {
    /// The displacement, which may occupy `budget` bytes; `None` if the document has none.
    pub fn displacement(
        &self,
        context: &Context,
        topology: &Arc<TileTopology>,
        budget: u64,
    ) -> Result<Option<Displacement>> {
        Displacement::stored(context, topology.clone(), &self.document, DISPLACEMENT, budget)
    }

    /// The colours, which may occupy `budget` bytes; `None` if the document has none.
    pub fn paint(&self, context: &Context, topology: &Arc<TileTopology>, budget: u64) -> Result<Option<Paint>> {
        Paint::stored(context, topology.clone(), &self.document, COLOUR, budget)
    }

    /// The traces of contact, which may occupy `budget` bytes; `None` if the document has none.
    pub fn traces(&self, context: &Context, topology: &Arc<TileTopology>, budget: u64) -> Result<Option<Traces>> {
        Traces::stored(context, topology.clone(), &self.document, TRACES, budget)
    }
}

/// The document of the surface that an object shows.
pub(crate) fn document(context: &Context, world: &World, index: usize, surface: &DisplacedObject) -> Result<Document> {
    let mut document = Document::new(world.cage(index), context.level().name())?;
    surface.displacement().field().store(context, &mut document, DISPLACEMENT)?;
    if let Some(paint) = surface.paint() {
        paint.field().store(context, &mut document, COLOUR)?;
    }
    if let Some(traces) = surface.traces() {
        traces.field().store(context, &mut document, TRACES)?;
    }
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
