//! How likely each particle of a fluid makes diffuse ones (Ihmsen et al. 2012, Section 3.1).

use std::ops::Range;

use glam::Vec3;
use relievo_core::lanes::Lanes;
use relievo_core::{Context, dispatch_simd};

use super::CHUNK_LEN;
use super::options::DiffuseOptions;
use super::surroundings::{Surroundings, columns};
use crate::solver::pairs::Vectors;

/// The share of the support radius that the mean of the neighbours is away from a particle at the surface.
const SURFACE: f32 = 0.1;
/// The cosine between velocity and normal from which a crest breaks.
const BREAKING: f32 = 0.6;

/// The potentials of a particle, each from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Potentials {
    /// Trapped air (Equations 2 and 3).
    pub air: f32,
    /// Wave crests (Equations 4 to 7).
    pub crest: f32,
    /// Kinetic energy (Section 3.1.3).
    pub energy: f32,
}

/// What a first look at the neighbours of a particle gives.
#[derive(Clone, Copy, Debug, Default)]
struct Near {
    /// The outward normal of a particle at the surface, or zero of another.
    normal: Vec3,
    /// The sum of Equation 2.
    air: f32,
}

/// Returns the potentials of all particles of a fluid, in the order of cells.
pub fn potentials(context: &Context, options: &DiffuseOptions, fluid: &Surroundings) -> Vec<Potentials> {
    let parts = fluid.len().div_ceil(CHUNK_LEN);
    let part = |part: usize| part * CHUNK_LEN..fluid.len().min((part + 1) * CHUNK_LEN);
    let settings = &options.settings;
    let energy = |number: usize| {
        between([settings.energy_min, settings.energy_max], 0.5 * fluid.velocity(number).length_squared())
    };
    let near = context.map(parts, |at| {
        let energies: Vec<f32> = part(at).map(energy).collect();
        let mut near = Vec::with_capacity(CHUNK_LEN);
        look(fluid.level, fluid, part(at), &energies, &mut near);
        near
    });
    let near = near.concat();
    let normals = columns(near.iter().map(|near| near.normal));
    let found = context.map(parts, |at| {
        let mut crests = Vec::with_capacity(CHUNK_LEN);
        let is_breaking = |number: usize| {
            let (velocity, normal) = (fluid.velocity(number), near[number].normal);
            energy(number) > 0.0 && normal != Vec3::ZERO && velocity.normalize_or_zero().dot(normal) >= BREAKING
        };
        let breaking: Vec<usize> = part(at).filter(|number| is_breaking(*number)).collect();
        curve(fluid.level, fluid, &normals, &breaking, &mut crests);
        let mut found: Vec<Potentials> = part(at)
            .map(|number| match energy(number) {
                // Without energy nothing is born, and most of a fluid is calm.
                0.0 => Potentials::default(),
                energy => {
                    let air = between([settings.air_min, settings.air_max], near[number].air);
                    let crest = between([settings.crest_min, settings.crest_max], 0.0);
                    Potentials { air, crest, energy }
                }
            })
            .collect();
        for (number, crest) in breaking.iter().zip(crests) {
            found[number - at * CHUNK_LEN].crest = between([settings.crest_min, settings.crest_max], crest);
        }
        found
    });
    found.concat()
}

dispatch_simd! {
    fn look = look_body(fluid: &Surroundings, part: Range<usize>, energies: &[f32], near: &mut Vec<Near>)
}

/// Adds what is near each particle of a part. The air is only found where there is energy.
#[inline(always)]
fn look_body<A: Lanes>(v: A, fluid: &Surroundings, part: Range<usize>, energies: &[f32], near: &mut Vec<Near>) {
    let (zero, one, inverse) = (v.splat(0.0), v.splat(1.0), v.splat(fluid.support.recip()));
    let least = v.splat(f32::MIN_POSITIVE);
    let mut seeker = fluid.seeker();
    for (number, energy) in part.zip(energies) {
        let place = fluid.place(number);
        let own = Vectors::splat(v, fluid.velocity(number).extend(0.0));
        let (mut sum, mut weights, mut air) = (Vectors::zero(v), zero, zero);
        fluid.around(v, place, seeker.around(place), |first, from, square, is_there| {
            let distance = v.sqrt(square);
            let weight = v.max(v.sub(one, v.mul(distance, inverse)), zero);
            let weight = v.select(is_there, weight, zero);
            weights = v.add(weights, weight);
            sum = sum.plus(v, weight, from);
            if *energy > 0.0 {
                let relative = own.minus(v, Vectors::load(v, &fluid.velocities, first));
                let speed = v.sqrt(relative.dot(v, relative));
                let along = v.div(relative.dot(v, from), v.max(distance, least));
                // What is at the same place has no direction.
                let weight = v.select(v.lt(zero, distance), weight, zero);
                air = v.fused(weight, v.sub(speed, along), air);
            }
        });
        let sum = sum.sum(v).truncate();
        let is_surface = sum.length() > SURFACE * fluid.support * v.sum(weights);
        near.push(Near { normal: if is_surface { sum.normalize_or_zero() } else { Vec3::ZERO }, air: v.sum(air) });
    }
}

dispatch_simd! {
    fn curve = curve_body(fluid: &Surroundings, normals: &[Vec<f32>; 3], breaking: &[usize], crests: &mut Vec<f32>)
}

/// Adds how much the surface curves around each of some particles (Equations 4 to 6).
#[inline(always)]
fn curve_body<A: Lanes>(
    v: A,
    fluid: &Surroundings,
    normals: &[Vec<f32>; 3],
    breaking: &[usize],
    crests: &mut Vec<f32>,
) {
    let (zero, one, inverse) = (v.splat(0.0), v.splat(1.0), v.splat(fluid.support.recip()));
    let mut seeker = fluid.seeker();
    for number in breaking {
        let place = fluid.place(*number);
        let normal = Vectors(std::array::from_fn(|axis| v.splat(normals[axis][*number])));
        let mut sum = zero;
        fluid.around(v, place, seeker.around(place), |first, from, square, is_there| {
            let other = Vectors::load(v, normals, first);
            let weight = v.max(v.sub(one, v.mul(v.sqrt(square), inverse)), zero);
            // Where the surface is convex its neighbours lie below its tangent plane; within the fluid there is none.
            let is_below = v.lt(zero, from.dot(v, normal));
            let counts = v.both(v.both(is_there, is_below), v.lt(zero, other.dot(v, other)));
            sum = v.fused(v.select(counts, weight, zero), v.sub(one, normal.dot(v, other)), sum);
        });
        crests.push(v.sum(sum));
    }
}

/// Returns how far a value is between limits, from 0 to 1 (Equation 1).
fn between([low, high]: [f32; 2], value: f32) -> f32 {
    (value.clamp(low, high) - low) / (high - low)
}
