//! How diffuse particles move, by their kinds (Ihmsen et al. 2012, Sections 3.3 and 3.4).

use glam::Vec3;
use relievo_core::lanes::Lanes;
use relievo_core::{Context, dispatch_simd};

use super::options::DiffuseOptions;
use super::surroundings::Surroundings;
use super::{CHUNK_LEN, DiffuseKind, DiffuseParticles};
use crate::solver::pairs::Vectors;

/// The fluid around a particle.
#[derive(Clone, Copy, Debug, Default)]
struct Flow {
    /// The mean velocity of the neighbours (Equation 10), or zero without any.
    velocity: Vec3,
    neighbours: u32,
}

/// Moves particles by a step of so many seconds and gives them their kinds. Foam loses as much of its lifetime.
pub fn advance(
    context: &Context,
    options: &DiffuseOptions,
    fluid: &Surroundings,
    seconds: f32,
    particles: &mut DiffuseParticles,
) {
    let flows = flows(context, fluid, &particles.positions);
    let DiffuseParticles { positions, velocities, kinds, ages, lifetimes, .. } = particles;
    let parts = ((positions.as_mut_slice(), velocities.as_mut_slice()), kinds.as_mut_slice());
    let lists = (parts, (ages.as_mut_slice(), lifetimes.as_mut_slice()));
    let done =
        context.for_each_part(lists, CHUNK_LEN, |first, (((positions, velocities), kinds), (ages, lifetimes))| {
            for (at, position) in positions.iter_mut().enumerate() {
                let velocity = &mut velocities[at];
                let Flow { velocity: flow, neighbours } = flows[first + at];
                let kind = kind(options, neighbours);
                kinds[at] = kind;
                ages[at] += seconds;
                match kind {
                    // The parabola of the step, to which no step is too long.
                    DiffuseKind::Spray => {
                        *position += seconds * (*velocity + 0.5 * seconds * options.gravity);
                        *velocity += seconds * options.gravity;
                    }
                    DiffuseKind::Foam => {
                        *velocity = flow;
                        *position += seconds * flow;
                        lifetimes[at] -= seconds;
                    }
                    DiffuseKind::Bubble => {
                        *velocity += -seconds * options.settings.buoyancy * options.gravity
                            + options.settings.drag * (flow - *velocity);
                        *position += seconds * *velocity;
                    }
                }
            }
            Ok(())
        });
    // The work above has no error.
    debug_assert!(done.is_ok());
}

/// Returns the fluid around points, in their order.
fn flows(context: &Context, fluid: &Surroundings, points: &[Vec3]) -> Vec<Flow> {
    let order = fluid.sorted(context, points);
    let parts: Vec<&[u32]> = order.chunks(CHUNK_LEN).collect();
    let sorted = context.map(parts.len(), |part| {
        let mut flows = Vec::with_capacity(CHUNK_LEN);
        mean(fluid.level, fluid, points, parts[part], &mut flows);
        flows
    });
    let mut flows = vec![Flow::default(); points.len()];
    for (number, flow) in order.iter().zip(sorted.iter().flatten()) {
        flows[*number as usize] = *flow;
    }
    flows
}

dispatch_simd! {
    fn mean = mean_body(fluid: &Surroundings, points: &[Vec3], numbers: &[u32], flows: &mut Vec<Flow>)
}

/// Adds the fluid around the points of some numbers.
#[inline(always)]
fn mean_body<A: Lanes>(v: A, fluid: &Surroundings, points: &[Vec3], numbers: &[u32], flows: &mut Vec<Flow>) {
    let (zero, one, two) = (v.splat(0.0), v.splat(1.0), v.splat(2.0));
    let (scale, quarter) = (v.splat(2.0 * fluid.support.recip()), v.splat(0.25));
    let (square, cube) = (v.splat(-1.5), v.splat(0.75));
    let reach = v.splat(fluid.support * fluid.support);
    let mut seeker = fluid.seeker();
    for number in numbers {
        let point = points[*number as usize];
        let (mut sum, mut weights, mut neighbours) = (Vectors::zero(v), zero, 0);
        fluid.around(v, point, seeker.around(point), |first, _, distance, is_there| {
            let counts = v.both(is_there, v.lt(distance, reach));
            // The cubic spline (Monaghan 1992) of twice the share of the support radius, without its constant factor.
            let q = v.mul(v.sqrt(distance), scale);
            let inner = v.fused(v.mul(q, q), v.fused(cube, q, square), one);
            let rest = v.max(v.sub(two, q), zero);
            let outer = v.mul(v.mul(quarter, rest), v.mul(rest, rest));
            let weight = v.select(counts, v.select(v.lt(q, one), inner, outer), zero);
            neighbours += v.mask(counts).count_ones();
            weights = v.add(weights, weight);
            sum = sum.plus(v, weight, Vectors::load(v, &fluid.velocities, first));
        });
        let (sum, weights) = (sum.sum(v).truncate(), v.sum(weights));
        flows.push(Flow { velocity: if weights > 0.0 { sum / weights } else { Vec3::ZERO }, neighbours });
    }
}

/// Returns the kind of a particle by the number of its neighbours.
fn kind(options: &DiffuseOptions, neighbours: u32) -> DiffuseKind {
    match neighbours {
        _ if neighbours < options.settings.spray_below => DiffuseKind::Spray,
        _ if neighbours > options.settings.bubbles_above => DiffuseKind::Bubble,
        _ => DiffuseKind::Foam,
    }
}
