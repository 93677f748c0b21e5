//! Meshes and blocks that the tests share.

use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_openvdb::{Block, Grid, Kind, Polygons, Transform};

pub type Soup = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// A box, seen from outside counter-clockwise.
pub fn cuboid(low: [f32; 3], high: [f32; 3]) -> Soup {
    let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] });
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    ((0..8).map(corner).collect(), triangles)
}

/// The level set of a box with voxels of a size.
pub fn level_set(low: [f32; 3], high: [f32; 3], voxel: f64) -> Grid {
    let (points, triangles) = cuboid(low, high);
    let transform = Transform::uniform(voxel);
    Grid::of_mesh(&Context::serial(), &points, &triangles, &transform, [3.0, 3.0], &mut Silent).unwrap()
}

/// The signed volume of polygons, positive where they are counter-clockwise seen from outside.
pub fn volume(polygons: &Polygons) -> f64 {
    let point = |at: u32| polygons.points[at as usize].map(f64::from);
    let tetrahedron = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
        (0..3).map(|i| a[i] * (b[(i + 1) % 3] * c[(i + 2) % 3] - b[(i + 2) % 3] * c[(i + 1) % 3])).sum::<f64>() / 6.0
    };
    let triangles = polygons.triangles.iter().map(|[a, b, c]| [*a, *b, *c]);
    let halves = polygons.quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    triangles.chain(halves).map(|[a, b, c]| tetrahedron(point(a), point(b), point(c))).sum()
}

/// The volume inside of a grid's surface.
pub fn inside(grid: &Grid, value: f64) -> f64 {
    volume(&grid.polygons(&Context::serial(), value, 0.0, &mut Silent).unwrap())
}

/// A block of varied values of a kind, with some of the background, 0.
pub fn block(kind: Kind, low: [i32; 3], size: [u32; 3]) -> Block {
    let count = size.iter().product::<u32>();
    let number = |at: u32| if at.is_multiple_of(7) { 0 } else { (at.wrapping_mul(2_654_435_761) >> 20) as i32 - 2000 };
    let each = |at: u32| -> Vec<u8> {
        let value = number(at);
        match kind {
            Kind::Float => (value as f32 * 0.25).to_ne_bytes().into(),
            Kind::Double => (f64::from(value) * 1e-7).to_ne_bytes().into(),
            Kind::Bool | Kind::Mask => vec![u8::from(value > 0)],
            Kind::Int32 => value.to_ne_bytes().into(),
            Kind::Int64 => (i64::from(value) << 33).to_ne_bytes().into(),
            Kind::Vec3s => [value, value / 2, -value].iter().flat_map(|it| (*it as f32).to_ne_bytes()).collect(),
            Kind::Vec3d => [value, 1, -value].iter().flat_map(|it| f64::from(*it).to_ne_bytes()).collect(),
            Kind::Vec3i => [value, 3, -value].iter().flat_map(|it| it.to_ne_bytes()).collect(),
            Kind::Points => Vec::new(),
        }
    };
    Block { low, size, kind, bytes: (0..count).flat_map(each).collect() }
}
