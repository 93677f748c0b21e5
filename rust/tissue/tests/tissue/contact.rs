//! Nodes that slide, and bodies that push.

use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_testing::ball;
use relievo_tissue::{
    Body, Collider, Curve, DistanceField, Held, Material, Model, Shape, Simulation, SimulationOptions, Sliding,
};

use crate::bodies::{block, gel};

/// A gel that survives a fall.
pub fn firm() -> Material {
    Material { shear: 2e4, bulk: 2e5, ..gel() }
}

#[test]
fn distances_to_a_ball_of_triangles_are_those_of_the_ball() {
    let (points, triangles) = ball(0.5, 64);
    let field = DistanceField::new(&points, &triangles).unwrap();
    for at in 0..200u32 {
        let place = glam::Vec3::new((at as f32 * 0.37).sin(), (at as f32 * 0.73).cos(), (at as f32 * 0.11).sin());
        let closest = field.closest(place, Some(at % 100));
        assert!((closest.distance - (place.length() - 0.5)).abs() < 1e-3, "{place}: {closest:?}");
        assert_eq!(closest, field.closest(place, None));
        assert!(closest.normal.dot(place.normalize()) > 0.99);
    }
    assert!(DistanceField::new(&points, &[[0, 1, 9999]]).is_err());
    assert!(DistanceField::new(&[[0.0; 3]; 3], &[[0, 1, 2]]).is_err());
}

fn fallen(friction: f32, body: Body, slope: f32) -> Vec<(f64, f64, f32)> {
    let context = Context::serial();
    let model = block([0.1; 3], [4; 3], firm());
    let options = SimulationOptions { gravity: [slope, 0.0, -9.81], ..SimulationOptions::default() };
    let mut simulation = Simulation::new(model, &options).unwrap();
    let below = Curve::constant([0.05, 0.05, if matches!(body, Body::Floor) { -0.02 } else { -0.12 }]);
    simulation.add_collider(Collider::new(body, friction, below, Curve::constant([0.0; 3])).unwrap());
    let steps = (0.3 / simulation.steps().step) as u64 / 30;
    let mut seen = Vec::new();
    for _ in 0..30 {
        simulation.advance(&context, steps, &mut Silent).unwrap();
        let e = simulation.energies(&context).unwrap();
        let low = simulation.positions().iter().map(|place| place[2]).fold(f32::INFINITY, f32::min);
        seen.push((e.kinetic + e.elastic + e.potential, e.kinetic, low));
    }
    seen
}

#[test]
fn a_block_that_falls_gains_no_energy_and_stays_above_the_floor() {
    let (points, triangles) = ball(0.1, 24);
    let mesh = Body::Mesh(DistanceField::new(&points, &triangles).unwrap());
    for (body, floor) in [(Body::Floor, -0.02), (Body::Ball(0.1), -0.3), (mesh, -0.3)] {
        let seen = fallen(0.3, body, 0.0);
        let most = seen.iter().map(|seen| seen.1).fold(0.0, f64::max);
        let mut least = 0f64;
        for (total, _, low) in &seen {
            assert!(*total < least + 0.01 * most, "{seen:?}");
            least = least.min(*total);
            assert!(*low > floor - 0.1 * 0.025, "{low}");
        }
        assert!(most > 0.1, "{most}");
    }
}

#[test]
fn friction_holds_a_block_on_a_slope() {
    let context = Context::serial();
    let slid = |friction: f32| {
        let options = SimulationOptions { gravity: [2.0, 0.0, -9.81], damping: 20.0, ..SimulationOptions::default() };
        let mut simulation = Simulation::new(block([0.1; 3], [4; 3], gel()), &options).unwrap();
        let none = Curve::constant([0.0; 3]);
        simulation.add_collider(Collider::new(Body::Floor, friction, none.clone(), none).unwrap());
        let steps = (0.4 / simulation.steps().step) as u64;
        simulation.advance(&context, steps, &mut Silent).unwrap();
        simulation.positions()[2][0] - 0.05
    };
    let (free, rough) = (slid(0.0), slid(0.8));
    assert!(free > 0.03 && rough.abs() < 0.01, "{free} {rough}");
}

#[test]
fn sliding_nodes_keep_their_distance_from_a_sphere() {
    let context = Context::serial();
    let (points, triangles) = ball(0.3, 40);
    let mut model: Model = block([0.2, 0.2, 0.05], [6, 6, 2], firm());
    for node in &mut model.nodes {
        *node = [node[0] - 0.1, node[1] - 0.1, node[2] + 0.31];
    }
    let field = DistanceField::new(&points, &triangles).unwrap();
    let lowest = model.nodes_within([-1.0, -1.0, 0.3], [1.0, 1.0, 0.311]);
    let distance = |place: [f32; 3]| field.closest(glam::Vec3::from(place), None).distance;
    model.sliding = lowest
        .iter()
        .map(|node| Sliding { node: *node, surface: 0, distance: distance(model.nodes[*node as usize]) })
        .collect();
    model.surfaces.push(Shape { name: "skull".into(), points, triangles });
    let corner = model.nodes_within([-1.0, -1.0, 0.359], [-0.0999, -0.0999, 1.0]);
    model.held = corner.into_iter().map(|node| Held { node, axes: 7 }).collect();
    let options = SimulationOptions { gravity: [6.0, 3.0, -9.81], ..SimulationOptions::default() };
    let mut simulation = Simulation::new(model, &options).unwrap();
    simulation.advance(&context, 500, &mut Silent).unwrap();
    let (places, model) = (simulation.positions(), simulation.model());
    let mut moved = 0f32;
    for sliding in &model.sliding {
        let place = places[sliding.node as usize];
        let off = field.closest(glam::Vec3::from(place), None).distance - sliding.distance;
        assert!(off.abs() < 1e-6, "{off}");
        moved = moved.max((place[0] - model.nodes[sliding.node as usize][0]).abs());
    }
    assert!(moved > 1e-3, "{moved}");
}

/// The upper nodes of a block with their shares of a load that is even over its faces, which sum to 1.
fn shares(model: &Model, height: f32) -> Vec<(usize, f32)> {
    let nodes = model.nodes_within([-1.0, -1.0, height - 1e-4], [1.0, 1.0, height + 1e-4]);
    let most: [f32; 2] =
        [0, 1].map(|axis| nodes.iter().map(|node| model.nodes[*node as usize][axis]).fold(0.0, f32::max));
    let weight = |node: &u32| {
        let at = model.nodes[*node as usize];
        (0..2).map(|axis| if at[axis] < 1e-6 || at[axis] > most[axis] - 1e-6 { 0.5f32 } else { 1.0 }).product::<f32>()
    };
    let sum: f32 = nodes.iter().map(weight).sum();
    nodes.iter().map(|node| (*node as usize, weight(node) / sum)).collect()
}

/// The area over which some nodes are spread out at present.
fn area(simulation: &Simulation, nodes: &[(usize, f32)]) -> f32 {
    let places = simulation.positions();
    let side = |axis: usize| {
        let along = nodes.iter().map(|(node, _)| places[*node][axis]);
        along.clone().fold(f32::MIN, f32::max) - along.fold(f32::MAX, f32::min)
    };
    side(0) * side(1)
}

#[test]
fn a_block_presses_on_the_floor_with_its_weight_and_load_by_the_area() {
    let context = Context::serial();
    let size = [0.1, 0.08, 0.06];
    let none = Curve::constant([0.0; 3]);
    for gravity in [0.0, 9.81] {
        let options = SimulationOptions { gravity: [0.0, 0.0, -gravity], ..SimulationOptions::default() };
        let mut simulation = Simulation::new(block(size, [5, 4, 3], firm()), &options).unwrap();
        assert!(simulation.contact_pressures(&context).unwrap().iter().all(|pressure| *pressure == 0.0));
        simulation.add_collider(Collider::new(Body::Floor, 0.0, none.clone(), none.clone()).unwrap());
        let (upper, lower) = (shares(simulation.model(), size[2]), shares(simulation.model(), 0.0));
        let load = 3.0;
        let mut forces = vec![[0.0; 3]; simulation.model().nodes.len()];
        upper.iter().for_each(|(node, share)| forces[*node][2] = -load * share);
        simulation.load(&forces).unwrap();
        let rest = simulation.relax(&context, 1e-4, 20_000, &mut Silent).unwrap();
        assert!(rest.is_at_rest && rest.steps < 20_000, "{rest:?}");
        let pressures = simulation.contact_pressures(&context).unwrap();
        let weight = gravity * 1000.0 * size.iter().product::<f32>();
        let expected = (load + weight) / area(&simulation, &lower);
        let mean: f32 = lower.iter().map(|(node, share)| share * pressures[*node]).sum();
        assert!((mean - expected).abs() < 5e-3 * expected, "{mean} Pa is not {expected}");
        for (node, pressure) in pressures.iter().enumerate() {
            let is_low = lower.iter().any(|(other, _)| *other == node);
            // Lower layers spread out more under the weight of those above, so that the rim presses less.
            let off = (pressure - expected).abs() / expected;
            let most = if gravity == 0.0 { 0.01 } else { 0.2 };
            assert!(if is_low { off < most } else { *pressure == 0.0 }, "node {node}: {pressure} Pa, not {expected}");
        }
    }
}

#[test]
fn a_plate_presses_with_the_reaction_of_the_held_side_by_the_area() {
    let context = Context::serial();
    let size = [0.1, 0.1, 0.06];
    let mut model = block(size, [4, 4, 3], firm());
    model.held =
        model.nodes_within([-1.0; 3], [1.0, 1.0, 1e-4]).into_iter().map(|node| Held { node, axes: 4 }).collect();
    let options = SimulationOptions { gravity: [0.0; 3], ..SimulationOptions::default() };
    // A floor upside down, and a mesh of a plate.
    let above = |at: f32| (Curve::constant([0.0, 0.0, at]), Curve::constant([std::f32::consts::PI, 0.0, 0.0]));
    let (points, triangles) = ball(0.5, 24);
    let points: Vec<_> = points.iter().map(|[x, y, z]| [*x, *y, if *z < 0.0 { 0.0 } else { *z }]).collect();
    let plate = Body::Mesh(DistanceField::new(&points, &triangles).unwrap());
    let plates =
        [(Body::Floor, above(0.057)), (plate, (Curve::constant([0.05, 0.05, 0.057]), Curve::constant([0.0; 3])))];
    for (body, (translation, rotation)) in plates {
        let mut simulation = Simulation::new(model.clone(), &options).unwrap();
        simulation.add_collider(Collider::new(body, 0.0, translation, rotation).unwrap());
        let rest = simulation.relax(&context, 1e-4, 20_000, &mut Silent).unwrap();
        assert!(rest.is_at_rest && rest.steps < 20_000, "{rest:?}");
        let (upper, lower) = (shares(simulation.model(), size[2]), shares(simulation.model(), 0.0));
        let held: Vec<u32> = lower.iter().map(|(node, _)| *node as u32).collect();
        let force = simulation.reaction(&context, &held).unwrap()[2].abs() as f32;
        let pressures = simulation.contact_pressures(&context).unwrap();
        let mean: f32 = upper.iter().map(|(node, share)| share * pressures[*node]).sum();
        let expected = force / area(&simulation, &upper);
        assert!(expected > 1000.0 && (mean - expected).abs() < 5e-3 * expected, "{mean} Pa is not {expected}");
        // Uniaxial: the pressure is the stress.
        let states = simulation.element_states(&context).unwrap();
        assert!(states.iter().all(|state| (state.stress[2] + expected).abs() < 0.02 * expected));
        assert!(states.iter().all(|state| (state.principal_strain[2] - 0.5 * (0.95 * 0.95 - 1.0)).abs() < 1e-4));
    }
}

#[test]
fn colliders_that_swallow_the_model_are_named_and_leave_numbers_finite() {
    let context = Context::serial();
    let (points, triangles) = ball(1.0, 24);
    let bodies =
        [Body::Floor, Body::Ball(1.0), Body::Mesh(DistanceField::new(&points, &triangles).unwrap()), Body::Ball(0.03)];
    let still = || Curve::constant([0.0; 3]);
    let at = |z: f32| [0.05, 0.05, z];
    for (index, body) in bodies.into_iter().enumerate() {
        // From the start, or all at once after some steps; the small ball is in the middle of the model.
        let within = if index == 0 { 0.5 } else { 0.05 };
        let beyond = if index == 0 { -0.5 } else { 5.0 };
        let jump = Curve::new(vec![(0.0, at(beyond)), (0.002, at(beyond)), (0.00201, at(within))]).unwrap();
        for (path, halvings, held) in
            [(Curve::constant(at(within)), 0, false), (jump.clone(), 0, true), (jump, 2, false)]
        {
            let mut model = block([0.1; 3], [4; 3], firm());
            if held {
                let low = model.nodes_within([-1.0; 3], [1.0, 1.0, 1e-4]);
                model.held = low.into_iter().map(|node| Held { node, axes: 7 }).collect();
            }
            let options = SimulationOptions { halvings, ..SimulationOptions::default() };
            let mut simulation = Simulation::new(model, &options).unwrap();
            simulation.add_collider(Collider::new(body.clone(), 0.3, path, still()).unwrap());
            let steps = (0.003 / simulation.steps().step) as u64;
            let outcome = simulation.advance(&context, steps, &mut Silent);
            match outcome {
                Err(error) => {
                    // The small ball throws elements about, which turn inside out also where it is not.
                    let (said, small) = (error.to_string(), index == 3);
                    assert!(said.contains(if small { "shorter step" } else { "begin outside" }), "{index}: {said}");
                    assert!(small || said.contains("collider 0"), "{index}: {said}");
                }
                Ok(()) => assert_eq!(index, 3, "a body that swallows all is an error"),
            }
            let places = simulation.positions();
            // Nodes may have been thrown, but not out of the world.
            let is_bounded = |at: &f32| at.is_finite() && at.abs() < 100.0;
            assert!(places.as_flattened().iter().all(is_bounded), "{index}: {places:?}");
        }
        // Relaxation does not begin.
        let mut simulation = Simulation::new(block([0.1; 3], [4; 3], firm()), &SimulationOptions::default()).unwrap();
        simulation.add_collider(Collider::new(body, 0.3, Curve::constant(at(within)), still()).unwrap());
        let outcome = simulation.relax(&context, 1e-3, 300, &mut Silent);
        assert!(outcome.is_err() || index == 3, "{index}");
        assert!(simulation.positions().as_flattened().iter().all(|at| at.is_finite()));
    }
}
