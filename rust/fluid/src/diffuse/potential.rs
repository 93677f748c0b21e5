//! How likely each particle of a fluid makes diffuse ones (Ihmsen et al. 2012, Section 3.1).

use std::ops::Range;

use glam::Vec3;
use relievo_core::lanes::Lanes;
use relievo_core::{Context, dispatch_simd};

use super::PART;
use super::options::DiffuseOptions;
use super::surroundings::{Surroundings, columns};
use crate::profile::WIDEST;

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
    let parts = fluid.len().div_ceil(PART);
    let part = |part: usize| part * PART..fluid.len().min((part + 1) * PART);
    let settings = &options.settings;
    let energy = |number: usize| {
        between([settings.energy_min, settings.energy_max], 0.5 * fluid.velocity(number).length_squared())
    };
    let near = context.map(parts, |at| {
        let energies: Vec<f32> = part(at).map(energy).collect();
        let mut near = Vec::with_capacity(PART);
        look(fluid.level, fluid, part(at), &energies, &mut near);
        near
    });
    let near = near.concat();
    let normals = columns(near.iter().map(|near| near.normal));
    let found = context.map(parts, |at| {
        let mut crests = Vec::with_capacity(PART);
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
            found[number - at * PART].crest = between([settings.crest_min, settings.crest_max], crest);
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
    let lanes = v.load(&LANES);
    let (zero, one, inverse) = (v.splat(0.0), v.splat(1.0), v.splat(fluid.support.recip()));
    let least = v.splat(f32::MIN_POSITIVE);
    let mut seeker = fluid.seeker();
    for (number, energy) in part.zip(energies) {
        let (place, velocity) = (fluid.place(number), fluid.velocity(number));
        let at = place.to_array().map(|value| v.splat(value));
        let own = velocity.to_array().map(|value| v.splat(value));
        let (mut sum, mut weights, mut air) = ([zero; 3], zero, zero);
        for range in seeker.around(place) {
            for first in range.clone().step_by(A::WIDTH) {
                let from: [A::F; 3] = std::array::from_fn(|axis| v.sub(at[axis], v.load(&fluid.places[axis][first..])));
                let distance = v.sqrt(dot(v, from, from));
                let left = v.splat((range.end - first).min(WIDEST) as f32);
                let weight = v.max(v.sub(one, v.mul(distance, inverse)), zero);
                let weight = v.select(v.lt(lanes, left), weight, zero);
                weights = v.add(weights, weight);
                sum = std::array::from_fn(|axis| v.fused(weight, from[axis], sum[axis]));
                if *energy > 0.0 {
                    let relative: [A::F; 3] =
                        std::array::from_fn(|axis| v.sub(own[axis], v.load(&fluid.velocities[axis][first..])));
                    let speed = v.sqrt(dot(v, relative, relative));
                    let along = v.div(dot(v, relative, from), v.max(distance, least));
                    // What is at the same place has no direction.
                    let weight = v.select(v.lt(zero, distance), weight, zero);
                    air = v.fused(weight, v.sub(speed, along), air);
                }
            }
        }
        let sum = Vec3::from_array(sum.map(|sum| v.sum(sum)));
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
    let lanes = v.load(&LANES);
    let (zero, one, inverse) = (v.splat(0.0), v.splat(1.0), v.splat(fluid.support.recip()));
    let mut seeker = fluid.seeker();
    for number in breaking {
        let place = fluid.place(*number);
        let at = place.to_array().map(|value| v.splat(value));
        let normal: [A::F; 3] = std::array::from_fn(|axis| v.splat(normals[axis][*number]));
        let mut sum = zero;
        for range in seeker.around(place) {
            for first in range.clone().step_by(A::WIDTH) {
                let from: [A::F; 3] = std::array::from_fn(|axis| v.sub(at[axis], v.load(&fluid.places[axis][first..])));
                let other: [A::F; 3] = std::array::from_fn(|axis| v.load(&normals[axis][first..]));
                let distance = v.sqrt(dot(v, from, from));
                let left = v.splat((range.end - first).min(WIDEST) as f32);
                let weight = v.max(v.sub(one, v.mul(distance, inverse)), zero);
                // Where the surface is convex its neighbours lie below its tangent plane; within the fluid there is none.
                let is_below = v.lt(zero, dot(v, from, normal));
                let counts = v.both(v.both(v.lt(lanes, left), is_below), v.lt(zero, dot(v, other, other)));
                sum = v.fused(v.select(counts, weight, zero), v.sub(one, dot(v, normal, other)), sum);
            }
        }
        crests.push(v.sum(sum));
    }
}

/// The numbers of lanes.
pub const LANES: [f32; WIDEST] = {
    let mut lanes = [0.0; WIDEST];
    let mut at = 0;
    while at < WIDEST {
        lanes[at] = at as f32;
        at += 1;
    }
    lanes
};

/// Returns the products of vectors.
#[inline(always)]
pub fn dot<A: Lanes>(v: A, a: [A::F; 3], b: [A::F; 3]) -> A::F {
    v.fused(a[0], b[0], v.fused(a[1], b[1], v.mul(a[2], b[2])))
}

/// Returns how far a value is between limits, from 0 to 1 (Equation 1).
fn between([low, high]: [f32; 2], value: f32) -> f32 {
    (value.clamp(low, high) - low) / (high - low)
}
