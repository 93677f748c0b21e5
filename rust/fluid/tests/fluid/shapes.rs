//! Particles and functions that tests share.

use glam::{DVec3, Vec3};
use relievo_core::{Mesh, Values};
use relievo_fluid::SurfaceFunction;

/// One of each, of particles of a radius.
pub const FUNCTIONS: [fn(f32) -> SurfaceFunction; 4] =
    [SurfaceFunction::blobs, SurfaceFunction::zhu_bridson, SurfaceFunction::density, SurfaceFunction::anisotropic];

/// Points of a lattice with so many along each axis, some distance apart.
pub fn lattice(count: usize, distance: f32) -> Vec<[f32; 3]> {
    let at = move |index: usize| index as f32 * distance;
    let row = move |y: usize, z: usize| (0..count).map(move |x| [at(x), at(y), at(z)]);
    (0..count).flat_map(|z| (0..count).flat_map(move |y| row(y, z))).collect()
}

/// A lattice with so many along each axis, 2 cm apart, with a hole within, a drop beside, and no lattice any more.
pub fn hollow(count: usize) -> Vec<[f32; 3]> {
    let mut points = lattice(count, 0.02);
    let middle = 0.01 * count as f32;
    points.retain(|point| point.iter().map(|at| (at - middle).powi(2)).sum::<f32>() > 0.08f32.powi(2));
    points.push([0.02 * count as f32 + 0.2, middle, middle]);
    for (at, point) in points.iter_mut().enumerate() {
        *point = point.map(|value| value + 0.004 * (at as f32 * (1.0 + value)).sin());
    }
    points
}

/// The numbers of an attribute.
pub fn floats<'a>(mesh: &'a Mesh, name: &str) -> &'a [f32] {
    match &mesh.attribute(name).unwrap().values {
        Values::F32(values) => values,
        Values::U32(_) => panic!("{name} is of integers"),
    }
}

/// The volume of a closed mesh.
pub fn volume(mesh: &Mesh) -> f64 {
    let point = |at: u32| DVec3::from(Vec3::from(mesh.points[at as usize]));
    mesh.triangles().iter().map(|[a, b, c]| point(*a).dot(point(*b).cross(point(*c))) / 6.0).sum()
}
