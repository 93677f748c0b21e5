//! Surface tension (Akinci, Akinci, Teschner 2013, Section 3): particles pull each other together, and push where they are very
//! close, and differences of normals draw in what bends outwards.
//!
//! One thing differs: differences of normals count less with the distance, as a viscosity's of velocities, so that
//! nothing jumps where a particle comes into reach.

use glam::Vec4;
use relievo_core::lanes::Lanes;
use relievo_core::{Context, Result, dispatch_simd};

use crate::solver::constants::{Constants, KernelLanes};
use crate::solver::domain::Domain;
use crate::solver::neighbours::{CHUNK_LEN, Neighbours};
use crate::solver::pairs::{Vectors, around};
use crate::solver::prepare::Neighborhood;

/// What tension follows from.
pub struct Tension<'a> {
    pub constants: Constants,
    /// A row a particle, and [`crate::solver::neighbours::NOWHERE`] after the last.
    pub places: &'a [Vec4],
    /// With the slopes of this step.
    pub near: &'a Neighbours,
    pub found: &'a [Neighborhood],
}

/// Adds the accelerations by tension. `normals` are filled with those of all particles: the slope of how much fluid is around
/// one, times the support radius, so that they are about 1.5 at a flat surface and 0 within. The fourth numbers are densities.
pub fn pull(
    context: &Context,
    tension: &Tension,
    domain: &mut Domain,
    normals: &mut Vec<Vec4>,
    accelerations: &mut [Vec4],
) -> Result<()> {
    let count = tension.found.len();
    normals.resize(count + 1, Vec4::ZERO);
    normals[count] = Vec4::ZERO.with_w(tension.constants.density);
    let mut parts: Vec<_> = normals[..count].chunks_mut(CHUNK_LEN).collect();
    context.for_each_mut(&mut parts, |part, normals| normals_part(context.level(), tension, part, normals));
    domain.refresh(&mut normals[..count])?;
    let mut parts: Vec<_> = accelerations.chunks_mut(CHUNK_LEN).collect();
    context.for_each_mut(&mut parts, |part, accelerations| {
        pull_part(context.level(), tension, normals, part, accelerations);
    });
    Ok(())
}

#[inline(always)]
fn normals_body<A: Lanes>(v: A, tension: &Tension, part: usize, normals: &mut [Vec4]) {
    let Constants { kernels, mass, density, .. } = tension.constants;
    let scale = kernels.support * mass / density;
    let near = &tension.near.parts()[part];
    for (particle, normal) in normals.iter_mut().enumerate() {
        let number = part * CHUNK_LEN + particle;
        let mut slope = Vectors::zero(v);
        around(v, near, particle, tension.places, tension.places[number], |from, _, at| {
            slope = slope.plus(v, v.load(&near.slopes[at..]), from);
        });
        *normal = (scale * slope.sum(v)).with_w(tension.found[number].density);
    }
}

dispatch_simd! {
    fn normals_part = normals_body(tension: &Tension<'_>, part: usize, normals: &mut [Vec4])
}

#[inline(always)]
fn pull_body<A: Lanes>(v: A, tension: &Tension, normals: &[Vec4], part: usize, accelerations: &mut [Vec4]) {
    let smoothing = KernelLanes::new(v, &tension.constants);
    let near = &tension.near.parts()[part];
    let [cohesion, area] = tension.constants.tension.map(|factor| v.splat(factor));
    let twice = v.splat(2.0 * tension.constants.density);
    for (particle, acceleration) in accelerations.iter_mut().enumerate() {
        let number = part * CHUNK_LEN + particle;
        let own = normals[number];
        let (normal, density) = (Vectors::splat(v, own), v.splat(own.w));
        let mut sum = Vectors::zero(v);
        around(v, near, particle, tension.places, tension.places[number], |from, _, at| {
            let [pull, left] = smoothing.cohesion(v.sqrt(from.dot(v, from)));
            let [x, y, z, other] = v.gather_rows(bytemuck::cast_slice(normals), &near.indices[at..]);
            // Particles of a surface, which are less dense, pull more.
            let share = v.div(twice, v.add(density, other));
            sum = sum.plus(v, v.mul(share, v.mul(cohesion, pull)), from);
            let apart = normal.minus(v, Vectors([x, y, z]));
            sum = sum.plus(v, v.mul(share, v.mul(area, left)), apart);
        });
        *acceleration -= sum.sum(v);
    }
}

dispatch_simd! {
    fn pull_part = pull_body(tension: &Tension<'_>, normals: &[Vec4], part: usize, accelerations: &mut [Vec4])
}
