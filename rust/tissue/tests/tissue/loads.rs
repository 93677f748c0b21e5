//! Pressures, principal stresses, contact of a model with itself, steps that are halved, and convergence.

use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_tissue::{
    Curve, DistanceField, Drive, Held, Material, Model, Portion, Pressure, Simulation, SimulationOptions, State,
};

use crate::bodies::{block, displaced, distorted, gel};

fn still() -> SimulationOptions {
    SimulationOptions { gravity: [0.0; 3], ..SimulationOptions::default() }
}

#[test]
fn pressure_from_all_sides_makes_a_block_smaller_by_its_bulk_modulus() {
    let context = Context::serial();
    // A pressure above the shear modulus would drive hourglass modes.
    let boxes = block([0.1; 3], [3; 3], Material { shear: 1e4, ..gel() });
    for mut model in [boxes.clone(), distorted(boxes, 0.2)] {
        // The corner and the planes through it do not move away.
        for axis in 0..3 {
            let mut high = [1.0; 3];
            high[axis] = 1e-4;
            model
                .held
                .extend(model.nodes_within([-1.0; 3], high).iter().map(|node| Held { node: *node, axes: 1 << axis }));
        }
        let nodes: Vec<u32> = (0..model.nodes.len() as u32).collect();
        let faces = model.outer_faces_of(&nodes);
        assert_eq!(faces.len(), 54);
        let mut simulation = Simulation::new(model, &still()).unwrap();
        simulation.press(Pressure { faces, pressure: Curve::constant([5e3]) }).unwrap();
        assert!(simulation.relax(&context, 1e-4, 20_000, &mut Silent).unwrap().is_at_rest);
        for state in simulation.element_states(&context).unwrap() {
            // K (J − 1) = −p
            assert!((state.volume - 0.9).abs() < 2e-4, "{state:?}");
            assert!(state.principal.iter().all(|part| (part + 5e3).abs() < 20.0), "{state:?}");
        }
    }
}

#[test]
fn pressure_on_a_closed_surface_moves_nothing_as_a_whole() {
    let context = Context::serial();
    let model = block([0.1; 3], [3; 3], gel());
    let nodes: Vec<u32> = (0..model.nodes.len() as u32).collect();
    let pressure = Pressure { faces: model.outer_faces_of(&nodes), pressure: Curve::constant([2e3]) };
    let mut simulation = Simulation::new(model, &still()).unwrap();
    simulation.press(pressure).unwrap();
    simulation.advance(&context, 400, &mut Silent).unwrap();
    let velocities = &simulation.state().velocities;
    let [sum, most] = velocities
        .iter()
        .fold([0f64, 0.0], |[sum, most], v| [sum + f64::from(v[0] + v[1] + v[2]), f64::from(v[0].abs()).max(most)]);
    assert!(most > 1e-3 && sum.abs() < 1e-3 * most * velocities.len() as f64, "{sum} of {most}");
    let other = Pressure { faces: vec![[0, 1, 2, 999]], pressure: Curve::constant([0.0]) };
    assert!(simulation.press(other).unwrap_err().to_string().contains("face 0"));
}

#[test]
fn principal_stresses_are_those_of_simple_shear_and_tension() {
    let context = Context::serial();
    let model = block([0.1; 3], [1; 3], gel());
    let mut simulation = Simulation::new(model.clone(), &still()).unwrap();
    let shear = 1e-3f32;
    simulation.set_state(displaced(&model, |[_, y, _]| [shear * y, 0.0, 0.0])).unwrap();
    let state = simulation.element_states(&context).unwrap()[0];
    let expected = 1006.71 * shear;
    assert!((state.principal[0] - expected).abs() < 2e-3 * expected, "{state:?}");
    assert!((state.principal[2] + expected).abs() < 2e-3 * expected && state.principal[1].abs() < 2e-3 * expected);
    simulation.set_state(displaced(&model, |[x, y, z]| [0.3 * x, -0.1 * y, 0.05 * z])).unwrap();
    let state = simulation.element_states(&context).unwrap()[0];
    let [x, y, z, ..] = state.stress;
    assert_eq!(state.principal.map(|part| part.round()), [x, z, y].map(|part| part.round()), "{state:?}");
}

/// Two blocks above one another, of the same boxes, and the number of nodes of the lower one.
fn two_blocks(gap: f32, shift: f32) -> (Model, usize) {
    let firm = Material { shear: 2e4, bulk: 1e5, ..gel() };
    let mut model = block([0.1, 0.1, 0.05], [4, 4, 2], firm.clone());
    let upper = Model::block([shift, 0.013, 0.05 + gap], [0.025; 3], [3, 3, 2], firm).unwrap();
    let first = model.nodes.len() as u32;
    model.nodes.extend(upper.nodes);
    for element in upper.elements {
        model.elements.push(element.map(|node| node + first));
        model.mixtures.push([Portion { material: 0, share: 1.0 }]);
        model.fibres.push([]);
    }
    (model, first as usize)
}

#[test]
fn a_step_ends_though_an_element_is_drawn_out_of_all_bounds() {
    let model = block([0.1, 0.1, 0.05], [2, 2, 1], gel());
    let count = model.nodes.len();
    let options = SimulationOptions { self_friction: Some(0.5), ..still() };
    for far in [1e15, f32::MAX] {
        let mut simulation = Simulation::new(model.clone(), &options).unwrap();
        let mut state =
            State { displacements: vec![[0.0; 4]; count], velocities: vec![[0.0; 4]; count], ..State::default() };
        state.velocities[0][0] = -far;
        state.velocities[1][0] = far;
        simulation.set_state(state).unwrap();
        // The next step finds the element inside out.
        let _ = simulation.advance(&Context::serial(), 1, &mut Silent);
        assert!(simulation.advance(&Context::serial(), 1, &mut Silent).is_err());
    }
}

#[test]
fn blocks_of_one_model_that_collide_keep_their_momentum_and_gain_no_energy() {
    let context = Context::serial();
    for (friction, along) in [(0.0, 0.0), (0.5, 0.4)] {
        let (model, first) = two_blocks(0.004, 0.011);
        let count = model.nodes.len();
        let options = SimulationOptions { self_friction: Some(friction), safety: 0.5, ..still() };
        let mut simulation = Simulation::new(model, &options).unwrap();
        let mut state =
            State { displacements: vec![[0.0; 4]; count], velocities: vec![[0.0; 4]; count], ..State::default() };
        state.velocities[first..].fill([along, 0.0, -1.0, 0.0]);
        simulation.set_state(state).unwrap();
        let masses = masses(simulation.model());
        let momentum = |simulation: &Simulation, axis: usize| -> f64 {
            let rows = simulation.state().velocities.iter().zip(&masses);
            rows.map(|(v, mass)| f64::from(v[axis]) * mass).sum()
        };
        let total = |simulation: &mut Simulation| {
            let energies = simulation.energies(&context).unwrap();
            energies.kinetic + energies.elastic
        };
        let begin = [momentum(&simulation, 0), momentum(&simulation, 2)];
        let energy = total(&mut simulation);
        let lower = |simulation: &Simulation| -> f64 {
            simulation.state().velocities[..first].iter().map(|v| f64::from(v[2])).sum::<f64>() / first as f64
        };
        for _ in 0..30 {
            simulation.advance(&context, 10, &mut Silent).unwrap();
            assert!(total(&mut simulation) < 1.01 * energy);
            for (axis, begin) in [(0, begin[0]), (2, begin[1])] {
                let now = momentum(&simulation, axis);
                assert!((now - begin).abs() < 1e-4 * masses.iter().sum::<f64>(), "axis {axis}: {now} {begin}");
            }
            let places = simulation.positions();
            let faces = simulation.model().outer_faces().into_iter().map(|(_, face)| face);
            let lower = faces.filter(|face| (face[0] as usize) < first);
            let triangles: Vec<[u32; 3]> = lower.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
            let field = DistanceField::new(&places, &triangles).unwrap();
            let distances = places[first..].iter().map(|at| field.closest(glam::Vec3::from(*at), None).distance);
            let deepest = distances.fold(f32::INFINITY, f32::min);
            assert!(deepest > -0.1 * 0.025, "{deepest}");
        }
        assert!(lower(&simulation) < -0.1, "the lower block was pushed: {}", lower(&simulation));
        let moved = simulation.state().velocities[..first].iter().map(|v| f64::from(v[0])).sum::<f64>();
        assert_eq!(moved.abs() > 1e-2 * first as f64, friction > 0.0, "{moved}");
    }
    // Without contact they pass.
    let (model, first) = two_blocks(0.004, 0.011);
    let count = model.nodes.len();
    let mut simulation = Simulation::new(model, &still()).unwrap();
    let mut state =
        State { displacements: vec![[0.0; 4]; count], velocities: vec![[0.0; 4]; count], ..State::default() };
    state.velocities[first..].fill([0.0, 0.0, -1.0, 0.0]);
    simulation.set_state(state).unwrap();
    let steps = (0.05 / simulation.steps().step) as u64;
    simulation.advance(&context, steps, &mut Silent).unwrap();
    assert!(simulation.state().velocities[..first].iter().all(|v| *v == [0.0; 4]));
}

/// The masses of nodes, in kg.
fn masses(model: &Model) -> Vec<f64> {
    let mut masses = vec![0.0; model.nodes.len()];
    for nodes in &model.elements {
        nodes.iter().for_each(|node| masses[*node as usize] += 1000.0 * 0.025f64.powi(3) / 8.0);
    }
    masses
}

/// A block whose upper face is moved down fast.
fn crushed(layers: u32, safety: f32, halvings: u32, depth: f32) -> Simulation {
    let mut model = block([0.1; 3], [4, 4, layers], gel());
    model.held =
        model.nodes_within([-1.0; 3], [1.0, 1.0, 1e-4]).into_iter().map(|node| Held { node, axes: 7 }).collect();
    let top = model.nodes_within([-1.0, -1.0, 0.0999], [1.0; 3]);
    let options = SimulationOptions { safety, halvings, ..still() };
    let mut simulation = Simulation::new(model, &options).unwrap();
    let displacement = Curve::new(vec![(0.0, [0.0; 3]), (0.05, [0.0, 0.0, -depth])]).unwrap();
    simulation.drive(Drive { nodes: top, axes: 7, displacement }).unwrap();
    simulation
}

#[test]
fn steps_are_halved_where_elements_turn_inside_out() {
    let context = Context::serial();
    let run = |layers: u32, safety: f32, halvings: u32, depth: f32| {
        let mut simulation = crushed(layers, safety, halvings, depth);
        let steps = (0.05 / simulation.steps().step).round() as u64;
        let outcome = simulation.advance(&context, steps, &mut Silent);
        (outcome, simulation)
    };
    // Faces that grow to three times their area need a third of the step.
    let (outcome, _) = run(4, 1.0, 0, 0.075);
    assert!(outcome.is_err(), "the step should be too long");
    let (outcome, halved) = run(4, 1.0, 4, 0.075);
    outcome.unwrap();
    assert!(halved.halved() > 0);
    let (outcome, fine) = run(4, 0.15, 0, 0.075);
    outcome.unwrap();
    let (seconds, expected) = (halved.state().seconds, fine.state().seconds);
    assert!((seconds - expected).abs() < f64::from(halved.steps().step), "{seconds} {expected}");
    let pairs = halved.state().displacements.iter().zip(&fine.state().displacements);
    let off = pairs.map(|(a, b)| (0..3).map(|axis| (a[axis] - b[axis]).abs()).fold(0.0, f32::max)).fold(0.0, f32::max);
    assert!(off < 5e-3, "{off}");
    // What is inside out by itself stays so, and the state is one that can be gone on from.
    let (outcome, broken) = run(1, 0.7, 2, 0.11);
    assert!(outcome.unwrap_err().place.starts_with("element "));
    assert!(broken.state().displacements.as_flattened().iter().all(|u| u.is_finite()));
}

#[test]
fn steps_that_are_not_halved_have_the_bits_of_those_that_may_not_be() {
    let context = Context::serial();
    let [mut plain, mut careful] = [0, 3].map(|halvings| crushed(4, 0.5, halvings, 0.01));
    plain.advance(&context, 150, &mut Silent).unwrap();
    careful.advance(&context, 150, &mut Silent).unwrap();
    assert_eq!(plain.state().displacements, careful.state().displacements);
    assert_eq!(careful.halved(), 0);
}

/// The error of a block of so many elements along an edge, for small displacements along x of the shape of half a wave
/// along each axis, whose body forces follow from the equations of linear elasticity.
fn error(count: u32) -> f64 {
    let context = Context::serial();
    let material = gel();
    let mut model = block([1.0; 3], [count; 3], material.clone());
    let is_border = |node: &[f32; 3]| node.iter().any(|at| *at < 1e-4 || *at > 1.0 - 1e-4);
    model.held = (0u32..)
        .zip(&model.nodes)
        .filter(|(_, node)| is_border(node))
        .map(|(node, _)| Held { node, axes: 7 })
        .collect();
    let size = 1e-4f64;
    let (g, k) = (f64::from(material.shear), f64::from(material.bulk));
    let lambda = k - 2.0 / 3.0 * g;
    let pi = std::f64::consts::PI;
    let wave = |[x, y, z]: [f64; 3]| size * (pi * x).sin() * (pi * y).sin() * (pi * z).sin();
    let force = |[x, y, z]: [f64; 3]| {
        let (square, mixed) = (pi * pi, (lambda + g) * pi * pi * size);
        [
            (lambda + g) * square * wave([x, y, z]) + 3.0 * g * square * wave([x, y, z]),
            -mixed * (pi * x).cos() * (pi * y).cos() * (pi * z).sin(),
            -mixed * (pi * x).cos() * (pi * y).sin() * (pi * z).cos(),
        ]
    };
    let volume = f64::from(count).powi(-3);
    let loads: Vec<[f32; 3]> =
        model.nodes.iter().map(|node| force(node.map(f64::from)).map(|part| (part * volume) as f32)).collect();
    let mut simulation = Simulation::new(model.clone(), &still()).unwrap();
    simulation.load(&loads).unwrap();
    let rest = simulation.relax(&context, 1e-4, 20_000, &mut Silent).unwrap();
    assert!(rest.is_at_rest, "{rest:?}");
    let squares = model.nodes.iter().zip(&simulation.state().displacements).map(|(node, u)| {
        let expected = [wave(node.map(f64::from)), 0.0, 0.0];
        (0..3).map(|axis| (f64::from(u[axis]) - expected[axis]).powi(2)).sum::<f64>()
    });
    (squares.sum::<f64>() * volume).sqrt() / size
}

#[test]
fn displacements_converge_with_the_square_of_the_size_of_elements() {
    let errors = [4, 8, 16].map(error);
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    println!("errors of 4³, 8³ and 16³ elements: {errors:.5?}, of the orders {orders:.2?}");
    assert!(orders.iter().all(|order| (1.7..2.4).contains(order)), "{errors:?} {orders:?}");
    assert!(errors[2] < 0.01);
}
