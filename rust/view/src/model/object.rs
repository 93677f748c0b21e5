//! What is looked at and edited: a Catmull-Clark surface over the faces of a mesh, or the mesh's own triangles.

use glam::{DAffine3, Vec4};
use relievo_core::{Context, Mesh, Result};
use relievo_detail::{AnyObject, DisplacedObject, LayeredObject, TriangleObject, with_object};
use relievo_document::Document;
use relievo_surface::{Surface, SurfaceOptions, TriangleSurface};
use relievo_tiles::triangle::{Pattern, TriangleChannel, TriangleOptions};
use relievo_tiles::{ChannelOptions, Displacement, Paint};

/// What is not painted: a light grey, linear Rec.709 and alpha.
const BLANK: Vec4 = Vec4::new(0.55, 0.53, 0.5, 1.0);

/// Triangles that a view has at most where nobody asks for more.
const MAX_TRIANGLES: u64 = 400_000;

/// Bytes that the blocks of a channel may occupy.
const BUDGET: u64 = 2 << 30;

/// The kinds of surface that a mesh can be taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceKind {
    /// The limit surface of Catmull and Clark.
    Surface,
    /// The triangles of the mesh.
    Triangles,
}

/// Makes the object of a mesh, and takes up what a document of it holds. New details and the view have `cells` along an
/// edge of a face, or as many as fit some hundred thousand triangles. Returns what the user should know too.
///
/// # Errors
/// The mesh cannot be of that kind, the document was made on another mesh, or memory runs out.
pub(crate) fn open_object(
    context: &Context,
    mesh: &Mesh,
    kind: SurfaceKind,
    document: Option<&Document>,
    cells: u32,
) -> Result<(AnyObject, Vec<String>)> {
    let mut notes = Vec::new();
    let mut object = match kind {
        SurfaceKind::Surface => {
            notes.extend(document.map(|document| document.fit(mesh)).transpose()?.flatten());
            let (options, lowered) = Surface::choose_isolation(context, mesh, &SurfaceOptions::default(), None)?;
            notes.extend(lowered);
            let surface = Surface::new(context, mesh, &options)?;
            let topology = surface.topology().clone();
            let options = ChannelOptions { size: cells.clamp(8, 256), budget: BUDGET, ..Default::default() };
            let displacement = Displacement::new(topology.clone(), &options)?;
            let mut object = DisplacedObject::new(context, surface, &mesh.points, displacement, DAffine3::IDENTITY)?;
            object.set_paint(Paint::of_color(topology, BLANK, &options)?)?;
            AnyObject::Tiles(Box::new(object))
        }
        SurfaceKind::Triangles => {
            document.map(|document| document.fit_triangles(mesh)).transpose()?;
            let surface = TriangleSurface::new(context, mesh)?;
            let topology = surface.topology().clone();
            let segments = cells.clamp(Pattern::SIZES[0], Pattern::SIZES[3]);
            let options = TriangleOptions { segments, budget: BUDGET };
            let displacement = TriangleChannel::displacement(topology.clone(), &options)?;
            let mut object = TriangleObject::new(context, surface, displacement, DAffine3::IDENTITY)?;
            object.set_paint(TriangleChannel::of_color(topology, BLANK, &options)?)?;
            AnyObject::Triangles(Box::new(object))
        }
    };
    if let Some(document) = document {
        notes.extend(document.notes.iter().cloned());
        let unknown = with_object!(&mut object, it => it.take_up(context, document, context.memory_limit()))?;
        notes.extend(unknown.iter().map(|name| format!("layer `{name}` cannot be shown")));
    }
    object.settle(context)?;
    Ok((object, notes))
}

/// The kind that a mesh is taken for where nobody says: its triangles if it has no other faces.
pub(crate) fn kind_of(mesh: &Mesh) -> SurfaceKind {
    if mesh.face_sizes.iter().all(|size| *size == 3) { SurfaceKind::Triangles } else { SurfaceKind::Surface }
}

/// Cells along an edge of a face, a power of two, with which a mesh has a few hundred thousand triangles at most.
pub(crate) fn affordable_cells(mesh: &Mesh, kind: SurfaceKind) -> u32 {
    let count = |cells: u64| match kind {
        SurfaceKind::Surface => mesh
            .face_sizes
            .iter()
            .map(|size| if *size == 4 { 2 * cells * cells } else { u64::from(*size) * 2 * (cells / 2).max(1).pow(2) })
            .sum::<u64>(),
        SurfaceKind::Triangles => mesh.face_sizes.len() as u64 * if cells == 1 { 1 } else { 3 * cells * cells / 2 },
    };
    let sizes: &[u32] = match kind {
        SurfaceKind::Surface => &[64, 32, 16, 8, 4, 2],
        SurfaceKind::Triangles => &[32, 16, 8],
    };
    sizes.iter().copied().find(|cells| count(u64::from(*cells)) <= MAX_TRIANGLES).unwrap_or(1)
}
