//! Cages, and channels with something in them.
// No test uses all of it.
#![allow(dead_code)]

use glam::Vec3;
use relievo_core::{Context, Mesh};
use relievo_surface::{Surface, SurfaceOptions, TriangleSurface};
use relievo_testing::{Random, grid};
use relievo_tiles::triangle::{Slot, TriangleChannel, TriangleSets, TriangleValues, edge_foot, foot};
use relievo_tiles::{Change, Channel, ChannelOptions, Field, Sets, Texel};

/// Cages of quads, triangles and polygons, with borders and without.
pub fn cages() -> Vec<Mesh> {
    vec![grid(4, true, &[0, 1, 2, 3, 0], false), grid(5, false, &[0, 0, 1], false), grid(3, false, &[2, 3, 1], false)]
}

pub fn surface(mesh: &Mesh) -> Surface {
    Surface::new(&Context::serial(), mesh, &SurfaceOptions::default()).unwrap()
}

pub fn options(mesh: &Mesh, mixed: bool) -> ChannelOptions {
    let sizes = [8, 16, 32];
    let face_sizes =
        if mixed { (0..mesh.face_count() as u32).map(|f| (f, sizes[f as usize % 3])).collect() } else { Vec::new() };
    ChannelOptions { size: 16, face_sizes, ..ChannelOptions::default() }
}

/// Writes numbers into about half of the tiles.
pub fn scribble<T: Texel>(
    context: &Context,
    channel: &mut Channel<T>,
    random: &mut Random,
    texel: impl Fn(&mut Random) -> T,
) {
    let count = channel.field().tile_count();
    let tiles: Vec<u32> = (0..count as u32).filter(|_| random.below(2) == 0).collect();
    let allocated = channel.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
    let lists: Vec<Vec<T>> =
        tiles.iter().map(|tile| (0..channel.field().size(*tile).pow(2)).map(|_| texel(random)).collect()).collect();
    let changes = channel
        .edit(context, &tiles, |tile, texels| {
            let list = &lists[tiles.binary_search(&tile).unwrap()];
            let size = texels.size();
            (0..size).for_each(|j| texels.row_mut(j).copy_from_slice(&list[j * size..][..size]));
        })
        .unwrap();
    let all: Vec<Change> = changes.into_iter().chain(allocated.changes).collect();
    channel.settle(context, &all).unwrap();
}

pub fn same_tiles<T: Texel>(a: &Field<T>, b: &Field<T>) {
    assert!(a.allocated().eq(b.allocated()), "{:?} {:?}", a.allocated().count(), b.allocated().count());
    (0..a.tile_count() as u32).for_each(|tile| assert_eq!(a.size(tile), b.size(tile)));
}

/// A channel on all faces whose values follow from where they are.
pub fn everywhere<T: Texel>(
    context: &Context,
    surface: &TriangleSurface,
    mut channel: TriangleChannel<T>,
    texel: impl Fn(Vec3) -> T,
) -> TriangleChannel<T> {
    let (topology, pattern) = (surface.topology(), channel.field().pattern());
    let allocate = (0..topology.face_count() as u32).collect();
    assert!(channel.apply(context, pattern, &TriangleSets { allocate, ..Default::default() }).unwrap().is_empty());
    let place = |face: u32, index: u32| foot(surface, face, pattern, pattern.at_slot(Slot::Inside(index))).point;
    let inside = |face: u32| (0..pattern.face_values() as u32).map(|index| texel(place(face, index))).collect();
    let along = |edge: u32| {
        (1..pattern.segments()).map(|step| texel(edge_foot(surface, edge, step, pattern.segments()).point)).collect()
    };
    let values = TriangleValues {
        faces: (0..topology.face_count() as u32).map(|face| (face, inside(face))).collect(),
        edges: (0..topology.edge_count() as u32).map(|edge| (edge, along(edge))).collect(),
        vertices: (0..).zip(surface.points()).map(|(vertex, point)| (vertex, texel(Vec3::from(*point)))).collect(),
    };
    channel.write(values).unwrap();
    channel
}
