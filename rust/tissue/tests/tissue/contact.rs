//! Nodes that slide, and bodies that push.

use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_tissue::{
    Body, Collider, Curve, DistanceField, Held, Material, Model, Shape, Simulation, SimulationOptions, Sliding,
};

use crate::bodies::{block, gel};

/// A gel that survives a fall.
pub fn firm() -> Material {
    Material { shear: 2e4, bulk: 2e5, ..gel() }
}

/// A ball of triangles about the origin.
pub fn ball(radius: f32, rings: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let around = 2 * rings;
    let mut points = vec![[0.0, 0.0, -radius], [0.0, 0.0, radius]];
    for ring in 1..rings {
        let polar = std::f32::consts::PI * ring as f32 / rings as f32;
        for at in 0..around {
            let angle = std::f32::consts::TAU * at as f32 / around as f32;
            points.push([
                radius * polar.sin() * angle.cos(),
                radius * polar.sin() * angle.sin(),
                -radius * polar.cos(),
            ]);
        }
    }
    let id = |ring: u32, at: u32| 2 + (ring - 1) * around + at % around;
    let mut triangles = Vec::new();
    for at in 0..around {
        triangles.push([0, id(1, at + 1), id(1, at)]);
        triangles.push([1, id(rings - 1, at), id(rings - 1, at + 1)]);
        for ring in 1..rings - 1 {
            triangles.push([id(ring, at), id(ring, at + 1), id(ring + 1, at + 1)]);
            triangles.push([id(ring, at), id(ring + 1, at + 1), id(ring + 1, at)]);
        }
    }
    (points, triangles)
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
