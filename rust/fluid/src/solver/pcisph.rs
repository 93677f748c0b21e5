//! Pressure by prediction and correction (Solenthaler, Pajarola 2009): particles are moved as they would be without it, the
//! densities there tell pressures, and so on until nothing is too dense.
//!
//! Two things differ. A step begins with the pressures of the one before. And a particle's pressure follows its own
//! surroundings, not those of a full lattice alone: beside walls and in crowds it would be too much, and not converge.

use glam::Vec4;
use relievo_core::lanes::Lanes;
use relievo_core::{Context, dispatch_simd};

use crate::solver::constants::{Constants, KernelLanes};
use crate::solver::neighbours::{CHUNK_LEN, Neighbours};
use crate::solver::pairs::{Rows, Vectors, around};
use crate::solver::prepare::Neighborhood;

/// The share of an excess of density that a correction takes away if no neighbour changes its pressure. All do, so a lattice
/// is corrected by up to 2.4 times as much; beyond 2 in all, corrections would grow.
const RELAXATION: f32 = 0.5;

/// What corrections read.
pub struct Correction<'a> {
    pub constants: Constants,
    pub near: &'a Neighbours,
    pub walls: &'a Neighbours,
    pub found: &'a [Neighborhood],
    /// Velocities after all accelerations but those by pressure, and pressures that have worked on them.
    pub velocities: &'a [Vec4],
    /// s
    pub step: f32,
    /// The density up to which a particle may be when the step ends, and the share that may stay of what it has more than
    /// that when it begins.
    pub begun_limit: f32,
    pub allowed_share: f32,
}

/// How much denser than at rest a fluid is, as a share of that.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Excess {
    /// Of the particle where it is most.
    pub most: f32,
    /// In the mean; particles that are less dense count as 0.
    pub mean: f32,
}

/// Moves the particles by the pressures that they have, the fourth numbers of `places`. Those of what is predicted are all
/// the pressures that have worked.
pub fn predict(context: &Context, correction: &Correction, places: Rows, predicted: &mut [Vec4]) {
    let mut parts: Vec<_> = predicted.chunks_mut(CHUNK_LEN).collect();
    context.for_each_mut(&mut parts, |part, predicted| {
        pressure_part(context.level(), correction, places, part, predicted);
        let numbers = part * CHUNK_LEN..;
        for (predicted, number) in predicted.iter_mut().zip(numbers) {
            let (place, before) = (places.fluid[number], correction.velocities[number].w);
            *predicted = (place + correction.step * *predicted).truncate().extend(place.w + before);
        }
    });
}

/// Velocities after the pressures that particles have, the fourth numbers of `places`, and of these velocities too.
pub fn pressure_velocities(context: &Context, correction: &Correction, places: Rows, velocities: &mut [Vec4]) {
    let mut parts: Vec<_> = velocities.chunks_mut(CHUNK_LEN).collect();
    context.for_each_mut(&mut parts, |part, velocities| {
        pressure_part(context.level(), correction, places, part, velocities)
    });
}

/// Corrects pressures by the densities at predicted places, and returns how much too high these are, beyond rest and beyond
/// what may be kept of what a step begins with: the most, and the sum instead of the mean.
pub fn correct(context: &Context, correction: &Correction, predicted: Rows, places: &mut [Vec4]) -> [Excess; 2] {
    tally(context, places, |part, places| correct_part(context.level(), correction, predicted, part, places))
}

/// Goes through the parts of all rows, and returns the greatest excesses and, as means, the sums of all.
pub fn tally<const KINDS: usize>(
    context: &Context,
    rows: &mut [Vec4],
    work: impl Fn(usize, &mut [Vec4]) -> [Excess; KINDS] + Sync,
) -> [Excess; KINDS] {
    let mut parts: Vec<_> = rows.chunks_mut(CHUNK_LEN).map(|rows| (rows, [Excess::default(); KINDS])).collect();
    context.for_each_mut(&mut parts, |part, (rows, excess)| *excess = work(part, rows));
    std::array::from_fn(|kind| parts.iter().fold(Excess::default(), |all, (_, part)| all.and(part[kind])))
}

/// What a pressure grows by for each kg/m³ that the density is too high by, times [`Neighborhood::diagonal`].
pub fn stiffness(correction: &Correction) -> f32 {
    let Correction { constants, step, .. } = correction;
    RELAXATION * (constants.density / step) * (constants.density / step)
}

impl Excess {
    /// Of one particle, by which the density is too high; what is not a number is more than anything.
    #[inline(always)]
    pub fn of(over: f32) -> Self {
        let share = if over > 0.0 || over.is_nan() { over } else { 0.0 };
        Self { most: share, mean: share }
    }

    /// Of both; what is not a number is more than anything.
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        let is_more = other.most > self.most || other.most.is_nan();
        Self { most: if is_more { other.most } else { self.most }, mean: self.mean + other.mean }
    }
}

#[inline(always)]
fn pressure_body<A: Lanes>(v: A, correction: &Correction, places: Rows, part: usize, velocities: &mut [Vec4]) {
    let Constants { mass, density, .. } = correction.constants;
    let [near, walls] = [&correction.near.parts()[part], &correction.walls.parts()[part]];
    for (particle, velocities) in velocities.iter_mut().enumerate() {
        let number = part * CHUNK_LEN + particle;
        let own = places.fluid[number];
        let pressure = v.splat(own.w);
        let [mut push, mut back] = [Vectors::zero(v); 2];
        around(v, near, particle, places.fluid, own, |from, other, at| {
            push = push.plus(v, v.mul(v.load(&near.slopes[at..]), v.add(pressure, other)), from);
        });
        around(v, walls, particle, places.walls, own, |from, mass, at| {
            back = back.plus(v, v.mul(v.load(&walls.slopes[at..]), mass), from);
        });
        let acceleration = (mass * push.sum(v) + own.w * back.sum(v)) / -(density * density);
        *velocities = (correction.velocities[number] + correction.step * acceleration).with_w(own.w);
    }
}

dispatch_simd! {
    fn pressure_part = pressure_body(correction: &Correction, places: Rows<'_>, part: usize, velocities: &mut [Vec4])
}

#[inline(always)]
fn correct_body<A: Lanes>(
    v: A,
    correction: &Correction,
    predicted: Rows,
    part: usize,
    places: &mut [Vec4],
) -> [Excess; 2] {
    let Constants { mass, density, kernels, wall, diagonal, .. } = correction.constants;
    let smoothing = KernelLanes::new(v, &correction.constants);
    let stiffness = stiffness(correction);
    let [near, walls] = [&correction.near.parts()[part], &correction.walls.parts()[part]];
    let mut excess = [Excess::default(); 2];
    for (particle, place) in places.iter_mut().enumerate() {
        let number = part * CHUNK_LEN + particle;
        let own = predicted.fluid[number];
        let [mut sum, mut beside] = [v.splat(0.0); 2];
        around(v, near, particle, predicted.fluid, own, |from, _, _| {
            sum = v.add(sum, smoothing.density(from.dot(v, from)));
        });
        around(v, walls, particle, predicted.walls, own, |from, mass, _| {
            beside = v.fused(mass, smoothing.wall(v.sqrt(from.dot(v, from))), beside);
        });
        let here = kernels.density * mass * (1.0 + v.sum(sum)) + wall * v.sum(beside);
        let found = &correction.found[number];
        let kept = correction.allowed_share * (found.density - correction.begun_limit).max(0.0);
        let over = here - density - kept;
        place.w = (place.w + stiffness / found.diagonal.max(diagonal) * over).max(0.0);
        for (excess, over) in excess.iter_mut().zip([here - density, over]) {
            *excess = excess.and(Excess::of(over / density));
        }
    }
    excess
}

dispatch_simd! {
    fn correct_part = correct_body(
        correction: &Correction,
        predicted: Rows<'_>,
        part: usize,
        places: &mut [Vec4],
    ) -> [Excess; 2]
}
