//! Motion: energies, threads, states, and what stops it.

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions};
use relievo_tissue::{Binding, Curve, Drive, Fibre, Held, Model, Muscle, Simulation, SimulationOptions};

use crate::bodies::{block, displaced, distorted, gel};

fn standing() -> Model {
    let mut model = block([0.2, 0.2, 0.2], [6, 6, 6], gel());
    model.held = model
        .nodes_within([-1.0, -1.0, -1e-4], [1.0, 1.0, 1e-4])
        .into_iter()
        .map(|node| Held { node, axes: 7 })
        .collect();
    model
}

#[test]
fn energy_is_kept_over_ten_thousand_steps() {
    let context = Context::serial();
    let mut simulation = Simulation::new(standing(), &SimulationOptions::default()).unwrap();
    let (mut most, mut worst) = (0f64, 0f64);
    for _ in 0..40 {
        simulation.advance(&context, 250, &mut Silent).unwrap();
        let energies = simulation.energies(&context).unwrap();
        most = most.max(energies.kinetic);
        worst = worst.max((energies.kinetic + energies.elastic + energies.potential).abs());
    }
    assert!(most > 1e-3, "{most}");
    assert!(worst < 0.01 * most, "{worst} J of {most} J");
}

fn muscular() -> Simulation {
    let mut model = distorted(block([0.4, 0.2, 0.2], [12, 9, 8], gel()), 0.1);
    model.held = standing().held.into_iter().filter(|held| held.node < 60).collect();
    model.muscles.push(Muscle { name: "biceps".into(), stiffness: 500.0, strength: 4000.0 });
    model.muscles.push(Muscle { name: "triceps".into(), stiffness: 100.0, strength: 1000.0 });
    model.fibres = Default::default();
    for element in 0..model.elements.len() {
        let one = Fibre { muscle: 0, share: 0.6, direction: [0.6, 0.0, 0.8] };
        let two = Fibre { muscle: 1, share: 0.4, direction: [0.0, 1.0, 0.0] };
        let list: &[Fibre] = if element % 3 == 0 {
            &[one, two]
        } else if element % 3 == 1 {
            &[two]
        } else {
            &[]
        };
        model.fibres.push(list.iter().copied());
    }
    let options = SimulationOptions { damping: 2.0, ..SimulationOptions::default() };
    let mut simulation = Simulation::new(model, &options).unwrap();
    simulation.activate(0, Curve::new(vec![(0.0, [0.0]), (0.05, [1.0])]).unwrap()).unwrap();
    simulation
}

#[test]
fn any_number_of_threads_and_any_state_give_the_same_bits() {
    let mut ends = Vec::new();
    for threads in [1, 2, 5] {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let mut simulation = muscular();
        simulation.advance(&context, 60, &mut Silent).unwrap();
        let half = simulation.state().clone();
        simulation.advance(&context, 60, &mut Silent).unwrap();
        let mut other = muscular();
        other.set_state(half).unwrap();
        other.advance(&context, 60, &mut Silent).unwrap();
        assert_eq!(other.state(), simulation.state());
        ends.push(simulation.state().clone());
    }
    assert!(ends[0].displacements.iter().any(|u| u[2].abs() > 1e-4));
    assert!(ends.iter().all(|end| *end == ends[0]));
}

#[test]
fn an_element_inside_out_is_named_and_the_last_state_stays() {
    let context = Context::serial();
    let model = standing();
    let top = model.nodes_within([-1.0, -1.0, 0.1999], [1.0, 1.0, 0.2001]);
    let mut simulation = Simulation::new(model, &SimulationOptions::default()).unwrap();
    let displacement = Curve::new(vec![(0.0, [0.0; 3]), (0.002, [0.0, 0.0, -0.3])]).unwrap();
    simulation.drive(Drive { nodes: top, axes: 7, displacement }).unwrap();
    let error = simulation.advance(&context, 10_000, &mut Silent).unwrap_err();
    assert!(error.place.starts_with("element ") && error.what.contains("its volume"), "{error}");
    assert!(simulation.state().displacements.as_flattened().iter().all(|u| u.is_finite()));
}

#[test]
fn what_cannot_be_simulated_is_refused() {
    let refused = |spoil: &dyn Fn(&mut Model, &mut SimulationOptions), why: &str| {
        let (mut model, mut options) = (standing(), SimulationOptions::default());
        spoil(&mut model, &mut options);
        let error = Simulation::new(model, &options).unwrap_err().to_string();
        assert!(error.contains(why), "{error} should say {why}");
    };
    refused(&|model, _| model.elements[3].swap(0, 6), "element 3");
    refused(&|model, _| model.nodes[7][1] = f32::NAN, "node 7");
    refused(&|model, _| model.elements[5][2] = 1_000_000, "element 5");
    refused(&|model, _| model.mixtures.items[2].share = 0.5, "element 2");
    refused(&|model, _| model.mixtures.items[2].material = 9, "element 2");
    refused(&|model, _| model.materials[0].bulk = -1.0, "bulk");
    refused(&|model, _| model.held.push(Held { node: 1 << 30, axes: 7 }), "does not exist");
    refused(&|model, _| model.elements.clear(), "no elements");
    refused(&|_, options| options.step = Some(1.0), "longer than the stable one");
    refused(&|_, options| options.damping = -1.0, "damping");
    refused(&|_, options| options.gravity[1] = f32::NAN, "gravity");
}

#[test]
fn added_mass_allows_the_step_that_was_asked_for() {
    let plain = Simulation::new(standing(), &SimulationOptions::default()).unwrap().steps().clone();
    assert_eq!(plain.added_mass, 0.0);
    let wanted = 2.0 * plain.step;
    let options = SimulationOptions { mass_scaling: Some(wanted), ..SimulationOptions::default() };
    let scaled = Simulation::new(standing(), &options).unwrap().steps().clone();
    assert!((scaled.step / wanted - 1.0).abs() < 1e-5 && (scaled.added_mass - 3.0).abs() < 1e-3, "{scaled:?}");
}

#[test]
fn bound_points_follow_rigid_motion_inside_and_outside() {
    let context = Context::serial();
    let points = [[0.05, 0.07, 0.11], [0.2, 0.2, 0.2], [0.23, -0.02, 0.3], [0.0, 0.0, 0.0], [0.11, 0.4, 0.1]];
    for model in [standing(), distorted(standing(), 0.2)] {
        let binding = Binding::new(&context, &model, "skin", &points, &[[0, 1, 2]]).unwrap();
        let rest = binding.points(&context, &model, &vec![[0.0; 4]; model.nodes.len()]);
        let turned = |[x, y, z]: [f32; 3]| [-y + 0.5, x - 0.25, z + 0.125];
        let state = displaced(&model, |at| {
            let to = turned(at);
            std::array::from_fn(|axis| to[axis] - at[axis])
        });
        let moved = binding.points(&context, &model, &state.displacements);
        for ((point, rest), moved) in points.iter().zip(&rest).zip(&moved) {
            let expected = turned(*point);
            for axis in 0..3 {
                assert!((rest[axis] - point[axis]).abs() < 3e-6, "{rest:?} {point:?}");
                assert!((moved[axis] - expected[axis]).abs() < 5e-6, "{moved:?} {expected:?}");
            }
        }
    }
}
