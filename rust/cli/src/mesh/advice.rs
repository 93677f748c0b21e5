//! Advice to repair meshes that a command cannot use as they are.

use std::path::Path;

use relievo_core::{Error, Mesh};

/// Adds to an error about a mesh that cannot be used how to repair it.
pub fn offered(error: Error, mesh: &Mesh, file: &Path) -> Error {
    if mesh.check().is_ok() {
        return error;
    }
    let repair = format!("`relievo mesh repair {} -o FILE` mends it", file.display());
    let remedy = if error.remedy.is_empty() { repair } else { format!("{}; {repair}", error.remedy) };
    error.advise(remedy)
}

/// Notes on standard error that a mesh has edges at which triangles cannot be taken away, and how to repair it.
pub fn note_non_manifold(mesh: &Mesh, file: &Path) {
    let edges = relievo_meshio::Summary::of_mesh(mesh).non_manifold_edges;
    if edges > 0 {
        eprintln!(
            "note: {edges} edges have more than two faces and may keep triangles; \
             `relievo mesh repair {} -o FILE` splits them",
            file.display()
        );
    }
}
