//! How the faces of a Ptex file meet: the links of tiles as the format has them.

use relievo_core::{Error, Result};
use relievo_ptex::{Face, MeshType, Neighbor, Reader, Resolution};
use relievo_surface::{Link, Side, TileTopology};

/// The face that stands for `tile`. Edges where tiles are wound the other way, and non-manifold ones, have no
/// neighbour: the format cannot say it.
pub(super) fn face(topology: &TileTopology, tile: u32, resolution: Resolution) -> Face {
    let neighbor = |side: Side| Some(Neighbor { face: side.tile, edge: side.edge });
    let neighbors = topology.links(tile).map(|link| match link {
        Link::Boundary | Link::Pinned { .. } => None,
        Link::Whole { reversed: true, .. } | Link::Half { reversed: true, .. } => None,
        Link::Halves { reversed: true, .. } => None,
        Link::Whole { side, .. } | Link::Half { side, .. } => neighbor(side),
        Link::Halves { first, .. } => neighbor(first),
    });
    Face { resolution, neighbors, subface: topology.is_sub(tile) }
}

/// Fails, with what differs, unless the faces of a file can be the tiles of a mesh.
pub(super) fn check<B: AsRef<[u8]>>(topology: &TileTopology, reader: &Reader<B>) -> Result<()> {
    let advice = "give the mesh that the file was made for, with its faces in the same order";
    if reader.format().mesh == MeshType::Triangle {
        return Err(Error::unsupported("its faces are triangles, and a subdivision surface has quads")
            .advise("convert the file to one of quads, one per corner of a triangle"));
    }
    let (tiles, faces) = (topology.tile_count(), reader.face_count() as usize);
    if tiles != faces {
        let subs = (0..tiles as u32).filter(|tile| topology.is_sub(*tile)).count();
        let parts = if subs > 0 {
            format!(" ({} quads, {subs} corners of other polygons)", tiles - subs)
        } else {
            String::new()
        };
        return Err(Error::invalid(format!("it has {faces} faces, and the mesh takes {tiles}{parts}")).advise(advice));
    }
    let (mut differing, mut first) = (0, None);
    for tile in 0..tiles as u32 {
        let found = reader.face(tile)?;
        if found.subface != topology.is_sub(tile) {
            let is = |sub: bool| if sub { "a corner of a polygon" } else { "a quad" };
            let what = format!("it is {} in the file and {} of the mesh", is(found.subface), is(topology.is_sub(tile)));
            return Err(Error::invalid(what).at(format!("face {tile}")).advise(advice));
        }
        for edge in 0..4 {
            // Programs that do not know what meets what leave neighbours out.
            let Some(neighbor) = found.neighbors[usize::from(edge)] else { continue };
            if !may_meet(topology.link(tile, edge), neighbor) {
                differing += 1;
                first = first.or(Some((tile, edge, neighbor)));
            }
        }
    }
    let Some((tile, edge, neighbor)) = first else { return Ok(()) };
    let what = format!(
        "{differing} edges have another neighbour than those of the mesh; the first meets edge {} of face {}",
        neighbor.edge, neighbor.face
    );
    Err(Error::invalid(what).at(format!("face {tile}, edge {edge}")).advise(advice))
}

/// Whether a file may name `neighbor` across an edge with `link`.
fn may_meet(link: Link, neighbor: Neighbor) -> bool {
    let is = |side: Side| side == Side { tile: neighbor.face, edge: neighbor.edge };
    match link {
        Link::Boundary => false,
        // Of several faces at an edge a program picks one.
        Link::Pinned { .. } => true,
        Link::Whole { side, .. } | Link::Half { side, .. } => is(side),
        Link::Halves { first, second, .. } => is(first) || is(second),
    }
}
