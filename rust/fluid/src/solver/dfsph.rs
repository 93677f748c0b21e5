//! Velocities that do not compress the fluid (Bender, Koschier 2017, Section 3.3), after all accelerations but
//! those by pressures of densities.
//!
//! Pressures are corrected by how fast densities grow, and change velocities, until densities hardly grow.

use glam::Vec4;
use relievo_core::lanes::Lanes;
use relievo_core::{Context, dispatch_simd};

use crate::solver::constants::Constants;
use crate::solver::neighbours::CHUNK_LEN;
use crate::solver::pairs::{Rows, Vectors, around};
use crate::solver::pcisph::{Correction, Excess, stiffness, tally};

/// Corrects pressures, the fourth numbers of `pressed`, by how much denser the fluid gets in the step at these velocities, and
/// returns how much, as a share of the density at rest, with the sum instead of the mean. What is less dense than at rest may grow until it has that.
pub fn slow(
    context: &Context,
    correction: &Correction,
    places: Rows,
    velocities: Rows,
    pressed: &mut [Vec4],
) -> [Excess; 1] {
    tally(context, pressed, |part, pressed| slow_part(context.level(), correction, places, velocities, part, pressed))
}

#[inline(always)]
fn slow_body<A: Lanes>(
    v: A,
    correction: &Correction,
    places: Rows,
    velocities: Rows,
    part: usize,
    pressed: &mut [Vec4],
) -> [Excess; 1] {
    let Constants { mass, density, diagonal, .. } = correction.constants;
    let [near, walls] = [&correction.near.parts()[part], &correction.walls.parts()[part]];
    let stiffness = stiffness(correction);
    let mut excess = Excess::default();
    for (particle, row) in pressed.iter_mut().enumerate() {
        let number = part * CHUNK_LEN + particle;
        let (place, velocity) = (places.fluid[number], velocities.fluid[number]);
        let velocity = Vectors::splat(v, velocity);
        let [mut sum, mut beside] = [v.splat(0.0); 2];
        around(v, near, particle, places.fluid, place, |from, _, at| {
            let [x, y, z, _] = v.gather_rows(bytemuck::cast_slice(velocities.fluid), &near.indices[at..]);
            let apart = velocity.minus(v, Vectors([x, y, z]));
            sum = v.fused(v.load(&near.slopes[at..]), from.dot(v, apart), sum);
        });
        around(v, walls, particle, places.walls, place, |from, mass, at| {
            let [x, y, z, _] = v.gather_rows(bytemuck::cast_slice(velocities.walls), &walls.indices[at..]);
            let apart = velocity.minus(v, Vectors([x, y, z]));
            beside = v.fused(v.mul(mass, v.load(&walls.slopes[at..])), from.dot(v, apart), beside);
        });
        let grown = correction.step * (mass * v.sum(sum) + v.sum(beside));
        let found = &correction.found[number];
        let over = grown.min(grown + found.density - density);
        row.w = (row.w + stiffness / found.diagonal.max(diagonal) * over).max(0.0);
        excess = excess.and(Excess::of(over / density));
    }
    [excess]
}

dispatch_simd! {
    fn slow_part = slow_body(
        correction: &Correction,
        places: Rows<'_>,
        velocities: Rows<'_>,
        part: usize,
        pressed: &mut [Vec4],
    ) -> [Excess; 1]
}
