//! Displaced surfaces as meshes, of documents and the meshes they were made on.

use std::path::Path;

use relievo_bake::opened::Opened;
use relievo_core::{Context, Error, Mesh, Result};
use relievo_document::Document;
use relievo_tiles::{Displaced, Tessellation, uniform_rates};

use super::triangles;

/// The surface with the layer called `layer` alone, or all as they are seen together, with so many cells along an edge of
/// its cage.
pub fn tessellation(
    context: &Context,
    opened: &Opened<'_>,
    cage: &Mesh,
    layer: Option<&str>,
    cells: u32,
) -> Result<Tessellation> {
    let displacement = opened.displacement(context, layer)?.map_or_else(|| opened.undisplaced(), Ok)?;
    let vectors = opened.vectors(context, layer)?;
    let mut displaced = Displaced::new(opened.surface(), displacement.field())?;
    if let Some(vectors) = &vectors {
        displaced = displaced.with_vectors(vectors.field())?;
    }
    displaced.tessellate(context, cage, &uniform_rates(opened.surface().topology(), cells))
}

/// The displaced mesh of the document in a file, made on `mesh`, as `relievo doc export` writes it, and what the user should
/// know. Triangles of a mesh have the cells that the document has, and not `cells`.
pub fn mesh(
    context: &Context,
    path: &Path,
    mesh: &Mesh,
    layer: Option<&str>,
    cells: u32,
) -> Result<(Mesh, Vec<String>)> {
    let named = |error: Error| error.at(path.display().to_string());
    let document = Document::open(path, context.memory_limit())?;
    if document.topology().is_of_triangles() {
        let object = triangles::shown(context, &document, mesh, layer).map_err(named)?;
        return Ok((triangles::tessellation(context, &object, mesh).map_err(named)?.mesh, document.notes.clone()));
    }
    let opened = Opened::new(context, &document, mesh, None).map_err(named)?;
    let made = tessellation(context, &opened, mesh, layer, cells).map_err(named)?;
    Ok((made.mesh, opened.notes))
}
