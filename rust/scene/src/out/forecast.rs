//! How large the meshes that a run writes will be, before its first frame.

use relievo_core::Result;

use crate::format::description::When;
use crate::out::stages::STAGE;
use crate::out::tessellation::Rates;
use crate::state::world::{Item, World};

/// Characters of a number of a vertex or a normal in OBJ, with the space before it.
const NUMBER: u64 = 11;
/// Characters of a line of OBJ beside its numbers.
const LINE: u64 = 3;

/// Returns the bytes of the meshes of frames `first` to `last`, if all of them were divided as the objects are now. Tiles that
/// get displacement later are divided more finely, and fluids and attributes are not counted, so there may be more.
///
/// # Errors
/// Fails if the vectors of an object do not fit its displacement.
pub(crate) fn mesh_bytes(world: &World, (first, last): (u32, u32)) -> Result<u64> {
    let output = &world.scene.output;
    let frames = match output.mesh {
        When::Never => 0,
        When::Last => u64::from(last == output.frames - 1),
        When::Every => u64::from(last - first) + 1,
    };
    let mut bytes = 0;
    for (index, item) in world.items().iter().enumerate().filter(|(index, _)| world.scene.objects[*index].visible) {
        let (points, triangles) = counts(world, index, item)?;
        bytes += output.mesh_formats.iter().map(|format| file(format, points, triangles)).sum::<u64>();
    }
    Ok(frames * bytes)
}

/// Returns the points and triangles of an object.
fn counts(world: &World, index: usize, item: &Item) -> Result<(u64, u64)> {
    let output = &world.scene.output;
    Ok(match item {
        Item::Surface(surface) => {
            let coat = world.coat(index);
            let rates = Rates::new(&surface.displaced()?, coat.as_ref(), output.rate, output.mesh_rate);
            let quads = rates.as_slice().iter().map(|rate| u64::from(*rate).pow(2)).sum::<u64>();
            (quads, 2 * quads)
        }
        Item::Triangles(item) => {
            let count = item.object.surface().topology().face_count() as u32;
            let inside = |face: u32| item.object.rates(face).inside.map_or(1, |pattern| u64::from(pattern.segments()));
            let triangles = (0..count).map(|face| inside(face).pow(2)).sum::<u64>();
            (triangles / 2, triangles)
        }
        Item::Mesh(item) => {
            let (corners, faces) = (item.mesh.corners.len() as u64, item.mesh.face_count() as u64);
            (item.mesh.points.len() as u64, corners.saturating_sub(2 * faces))
        }
    })
}

/// Returns the bytes of points with normals and of triangles in a file.
fn file(format: &str, points: u64, triangles: u64) -> u64 {
    if format == "obj" {
        let digits = u64::from(points.max(1).ilog10()) + 1;
        return 2 * points * (3 * NUMBER + LINE) + triangles * (3 * (2 * digits + 3) + LINE);
    }
    // Single precision in GLB, PLY and stages; a stage counts the corners of every face besides.
    24 * points + if format == STAGE { 16 } else { 12 } * triangles
}
