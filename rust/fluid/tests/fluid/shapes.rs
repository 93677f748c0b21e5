//! Particles and functions that tests share.

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
