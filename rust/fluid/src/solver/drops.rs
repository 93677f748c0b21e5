//! Surface tension, held against what is known of drops.

use std::f64::consts::{PI, TAU};

use super::*;
use crate::solver::constants::TENSION as SHARES;
use crate::solver::neighbours::CHUNK_LEN;
use crate::{KernelSet, Kernels, PressureSolver, block};

const SOLVERS: [PressureSolver; 2] = [PressureSolver::Pcisph, PressureSolver::Dfsph];
/// Water, in mm.
const SPACING: f32 = 1e-3;
const TENSION: f32 = 0.072;

/// A drop of water of no weight, of so many spacings in radius, its radius in metres, and the period in seconds of its
/// oscillations between long and flat (Rayleigh 1879): ω² = 8 σ / (ρ R³).
fn drop(solver: PressureSolver, spacings: f32) -> (Fluid, f64, f64) {
    let side = Vec3::splat((spacings + 1.0).floor() * SPACING);
    let mut places = block(-side, side, SPACING).unwrap();
    places.retain(|place| place.length() < spacings * SPACING);
    begin(solver, &places, 0.01)
}

/// The same of places, with a viscosity over √(σ R / ρ).
fn begin(solver: PressureSolver, places: &[Vec3], viscosity: f64) -> (Fluid, f64, f64) {
    let radius = f64::from(SPACING) * (0.75 * places.len() as f64 / PI).cbrt();
    let over = f64::from(TENSION) / 1000.0;
    let viscosity = (viscosity * (over * radius).sqrt()) as f32;
    let options =
        FluidOptions { spacing: SPACING, tension: TENSION, viscosity, friction: viscosity, ..Default::default() };
    let mut fluid = Fluid::new(FluidOptions { solver, gravity: Vec3::ZERO, ..options }).unwrap();
    fluid.add(places, Vec3::ZERO).unwrap();
    (fluid, radius, TAU / (8.0 * over / radius.powi(3)).sqrt())
}

/// The pull of two particles at a share of the support.
fn pull_at(q: f64) -> f64 {
    let cube = 64.0 * (q * (1.0 - q)).powi(3);
    if q < 0.5 { 2.0 * cube - 1.0 } else { cube }
}

/// The mean of places.
fn middle(fluid: &Fluid) -> DVec3 {
    fluid.places().iter().map(|place| place.xyz().as_dvec3()).sum::<DVec3>() / fluid.len() as f64
}

/// The means of squares of distances from the middle along the axes, in m².
fn moments(fluid: &Fluid) -> DVec3 {
    let middle = middle(fluid);
    let squares = fluid.places().iter().map(|place| (place.xyz().as_dvec3() - middle).powf(2.0));
    squares.sum::<DVec3>() / fluid.len() as f64
}

#[test]
fn accelerations_are_the_sums_over_all_pairs_and_add_up_to_nothing() {
    let context = Context::serial();
    let (mut fluid, ..) = drop(PressureSolver::Pcisph, 5.0);
    fluid.advance(&context, 0.02, |_, _| Ok(())).unwrap();
    fluid.look_around(&context).unwrap();
    let Constants { kernels, mass, density, tension: [cohesion, area], .. } = fluid.constants;
    let (places, found) = (fluid.places().to_vec(), &fluid.found);
    let pairs = |number: usize| {
        let others = places.iter().enumerate().filter(move |(other, _)| *other != number);
        let own = places[number];
        others
            .map(move |(other, place)| (other, (own - *place).xyz()))
            .filter(|(_, from)| from.length() < kernels.support)
    };
    let normal = |number: usize| -> Vec3 {
        pairs(number).map(|(_, from)| kernels.density_slope(from.length()) * from).sum::<Vec3>()
            * (kernels.support * mass / density)
    };
    let normals: Vec<Vec3> = (0..places.len()).map(normal).collect();
    let mut accelerations = vec![Vec4::ZERO; places.len()];
    let tension = Tension { constants: fluid.constants, places: &fluid.particles.places, near: &fluid.near, found };
    tension::pull(&context, &tension, &mut Domain::default(), &mut Vec::new(), &mut accelerations).unwrap();
    let mut most = 0.0f32;
    for (number, acceleration) in accelerations.iter().enumerate() {
        let mut sum = Vec3::ZERO;
        for (other, from) in pairs(number) {
            let q = from.length() / kernels.support;
            let kernel = pull_at(f64::from(q)) as f32;
            let apart = (1.0 - q) * (normals[number] - normals[other]);
            let share = 2.0 * density / (found[number].density + found[other].density);
            sum -= share * (cohesion * kernel * from.normalize() + area * apart);
        }
        most = most.max(sum.length());
        assert!(
            acceleration.xyz().distance(sum) < 1e-4 * sum.length() + 1e-4 * cohesion,
            "{number} {sum} {acceleration}"
        );
    }
    let all: DVec3 = accelerations.iter().map(|acceleration| acceleration.xyz().as_dvec3()).sum();
    assert!(all.length() < 1e-6 * f64::from(most) * places.len() as f64, "{all}");
}

/// Of a fluid without order below a flat surface, the work of pairs across it less that along it, by integrals over their
/// distances and depths, is the tension (Fowler 1937).
#[test]
fn pairs_without_order_sum_up_to_the_tension() {
    let kernels = Kernels::new(KernelSet::Wendland, 2.0);
    let support = f64::from(kernels.support);
    let steps = 400;
    let integral = |low: f64, f: &dyn Fn(f64) -> f64| -> f64 {
        let step = (support - low) / f64::from(steps);
        (0..steps).map(|at| f(low + (f64::from(at) + 0.5) * step)).sum::<f64>() * step
    };
    let pulled = 0.125 * PI * integral(0.0, &|r| r.powi(4) * pull_at(r / support));
    // The normal at a depth, and how much counts of a plane at a distance.
    let normal = |depth: f64| TAU * support * integral(depth, &|r| r * f64::from(kernels.density(r as f32)));
    let plane = |distance: f64| TAU * integral(distance, &|r| r * (1.0 - r / support));
    let step = support / f64::from(steps / 2);
    let rows = |value: &dyn Fn(f64) -> f64| -> Vec<f64> { (0..steps).map(|at| value(f64::from(at) * step)).collect() };
    let normals = rows(&|depth| if depth < support { normal(depth) } else { 0.0 });
    let planes = rows(&|distance| if distance < support { plane(distance) } else { 0.0 });
    let mut drawn = 0.0;
    for (at, own) in normals.iter().enumerate() {
        for (to, other) in normals.iter().enumerate().skip(at) {
            drawn += (to - at) as f64 * step * (own - other) * planes[to - at] * step * step;
        }
    }
    let [cohesion, area] = SHARES.map(f64::from);
    println!("{pulled:.3} of cohesion, {drawn:.3} of normals");
    assert!((cohesion * pulled + area * drawn - 1.0).abs() < 0.02, "{pulled} {drawn}");
}

/// A cube of fluid becomes a ball of the same volume, and stays one.
#[test]
fn a_cube_becomes_a_ball() {
    for solver in SOLVERS {
        let context = Context::serial();
        let side = Vec3::splat(5.0 * SPACING);
        let (mut fluid, radius, period) = begin(solver, &block(-side, side, SPACING).unwrap(), 0.1);
        let mut fastest = 0.0f64;
        let mean_speed = |fluid: &Fluid| {
            let speeds = fluid.velocities().iter().map(|velocity| f64::from(velocity.xyz().length()));
            speeds.sum::<f64>() / fluid.len() as f64
        };
        for time in [1.0, 3.0] {
            let left = time * period - fluid.seconds();
            fluid
                .advance(&context, left as f32, |fluid, done| {
                    fastest = fastest.max(mean_speed(fluid));
                    assert!(done.excess.most <= 0.01 && done.excess.mean <= 0.001);
                    Ok(())
                })
                .unwrap();
            let moments = moments(&fluid);
            // 1 of a ball, in which the mean square along an axis is a fifth of the radius squared.
            let size = (5.0 / 3.0 * moments.element_sum()).sqrt() / radius;
            let ratio = (moments.max_element() / moments.min_element()).sqrt();
            let distances =
                fluid.places().iter().map(|place| (place.xyz().as_dvec3() - middle(&fluid)).length() / radius);
            let farthest = distances.fold(0.0, f64::max);
            let momentum = f64::from(fluid.momentum().length() / fluid.mass()) / fluid.len() as f64 / fastest;
            let speed = mean_speed(&fluid) / fastest;
            println!(
                "{solver:?}: after {time} periods axes are {ratio:.4} of each other, the size is {size:.4} of a ball's, the \
                 farthest particle at {farthest:.3} of its radius, speeds {speed:.3} and the momentum {momentum:.1e} of the greatest"
            );
            assert!(ratio < 1.03 && (size - 1.0).abs() < 0.01 && farthest < 1.0, "{ratio} {size} {farthest}");
            assert!(momentum < 2e-6, "{momentum}");
        }
        // The corners of the cube were at 1.40 of the radius.
        assert!(mean_speed(&fluid) < 0.1 * fastest);
    }
}

/// Within a ball the pressure is 2 σ / R (Laplace 1806): that of the solver less what cohesion holds together.
#[test]
fn pressures_in_drops_are_those_of_laplace() {
    for (solver, spacings) in SOLVERS.into_iter().flat_map(|solver| [7.0, 10.0].map(|spacings| (solver, spacings))) {
        let context = Context::serial();
        let (mut fluid, radius, period) = drop(solver, spacings);
        fluid.advance(&context, period as f32, |_, _| Ok(())).unwrap();
        // With weights (1 − r²/a²)² where differences of normals do not reach.
        let reach = radius - 4.0 * f64::from(SPACING);
        let space = 4.0 * PI * reach.powi(3) * (1.0 / 3.0 - 2.0 / 5.0 + 1.0 / 7.0);
        let (mut sum, mut steps) = (0.0, 0);
        fluid
            .advance(&context, 0.5 * period as f32, |fluid, _| {
                sum += virial(fluid, &context, reach) / space;
                steps += 1;
                Ok(())
            })
            .unwrap();
        let ratio = sum / f64::from(steps) * radius / (2.0 * f64::from(TENSION));
        println!("{solver:?}: the pressure in a drop of {spacings} spacings is {ratio:.3} of Laplace's");
        assert!((ratio - 1.0).abs() < 0.2, "{ratio}");
    }
}

/// The sum of pressures times volumes, with weights (1 − r²/a²)² about the middle.
fn virial(fluid: &mut Fluid, context: &Context, reach: f64) -> f64 {
    fluid.look_around(context).unwrap();
    let (middle, Constants { kernels, mass, density, tension: [cohesion, _], .. }) = (middle(fluid), fluid.constants);
    let mut sum = 0.0;
    for (number, place) in fluid.places().iter().enumerate() {
        let share = 1.0 - (place.xyz().as_dvec3() - middle).length_squared() / (reach * reach);
        if share <= 0.0 {
            continue;
        }
        let part = &fluid.near.parts()[number / CHUNK_LEN];
        let mut pulled = 0.0;
        let others = part.indices[part.range(number % CHUNK_LEN)].iter().map(|other| *other as usize);
        for other in others.filter(|other| *other < fluid.len()) {
            let q = ((fluid.places()[other] - *place).xyz().length() / kernels.support).min(1.0);
            let kernel = pull_at(f64::from(q)) as f32;
            let dense = fluid.found[number].density + fluid.found[other].density;
            pulled += 2.0 * density / dense * cohesion * kernel * q * kernels.support;
        }
        // Half of a pair's is each particle's, and a third of it the pressure.
        let pressed = fluid.pressures()[number] * mass / density - mass * pulled / 6.0;
        sum += f64::from(pressed) * share * share;
    }
    sum
}

#[test]
fn drops_oscillate_as_rayleigh_found() {
    for solver in SOLVERS {
        let context = Context::serial();
        let (mut fluid, _, period) = drop(solver, 8.0);
        fluid.advance(&context, period as f32, |_, _| Ok(())).unwrap();
        let mut state = fluid.state();
        let rate = (0.2 * TAU / period) as f32;
        let middle = middle(&fluid).as_vec3();
        for (velocity, place) in state.velocities.iter_mut().zip(&state.places) {
            *velocity += (rate * (place.xyz() - middle) * Vec3::new(2.0, -1.0, -1.0)).extend(0.0);
        }
        fluid.set_state(state).unwrap();
        // When it is a ball again.
        let (mut crossings, mut before) = (Vec::new(), None);
        fluid
            .advance(&context, 1.6 * period as f32, |fluid, _| {
                let moments = moments(fluid);
                let now = (fluid.seconds(), moments.x - 0.5 * (moments.y + moments.z));
                if let Some((time, shape)) = before.filter(|(_, shape): &(f64, f64)| shape * now.1 < 0.0) {
                    crossings.push(time + (now.0 - time) * shape / (shape - now.1));
                }
                before = Some(now);
                Ok(())
            })
            .unwrap();
        let ratio = (crossings[2] - crossings[0]) / period;
        println!("{solver:?}: a drop oscillates in {ratio:.3} of Rayleigh's period");
        assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
    }
}
