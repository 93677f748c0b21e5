//! What is inside of a function, such as a grid of distances or of fog: where fluid begins.

use glam::Vec3;
use relievo_core::{Context, Result};

use crate::source::solid::Lattice;

/// How far around a place all has to be inside, in spacings: a little less than half of it, for rounding.
const AROUND: f32 = 0.499;

/// The places of particles that fill what a function says is inside, within a box by its corners in metres: those of a lattice
/// of a spacing that begins half a spacing from the low sides of the box, where the places half a spacing away along the axes
/// and the diagonals are inside too. A box that ends where the inside does is filled as [`crate::surface::block`] does.
///
/// # Errors
/// Fails if the spacing is not positive, a number is not finite, or the box has more than 2²⁸ places
/// ([`ErrorKind::Memory`](relievo_core::ErrorKind)).
pub fn fill_where(
    context: &Context,
    [low, high]: [Vec3; 2],
    spacing: f32,
    is_inside: &(dyn Fn(Vec3) -> bool + Sync),
) -> Result<Vec<Vec3>> {
    let lattice = Lattice::new(low, high, spacing)?;
    let steps = (0..27).map(|at| Vec3::new((at % 3) as f32, (at / 3 % 3) as f32, (at / 9) as f32) - 1.0);
    // The place itself comes first, along the axes and to the corners of a cube come next.
    let mut steps: Vec<Vec3> = steps.filter(|step| step.abs().element_sum() != 2.0).collect();
    steps.sort_by_key(|step| step.length_squared() as u32);
    let around: Vec<Vec3> = steps.iter().map(|step| AROUND * spacing * step.normalize_or_zero()).collect();
    let [nx, ny, nz] = lattice.counts();
    let layers = context.map(nz, |z| {
        let places = (0..nx * ny).map(|cell| lattice.at([cell % nx, cell / nx, z]));
        places.filter(|place| around.iter().all(|step| is_inside(*place + *step))).collect::<Vec<Vec3>>()
    });
    Ok(layers.concat())
}
