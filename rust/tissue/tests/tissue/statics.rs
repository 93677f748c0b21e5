//! Forces and rests against closed forms.

use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_tissue::{Curve, Drive, Fibre, Held, Material, Model, Muscle, Simulation, SimulationOptions};

use crate::bodies::{block, displaced, distorted, gel};

fn still(hourglass: f32) -> SimulationOptions {
    SimulationOptions { gravity: [0.0; 3], hourglass, ..SimulationOptions::default() }
}

#[test]
fn constant_strain_of_distorted_hexahedra_leaves_no_force_inside() {
    let context = Context::serial();
    let model = distorted(block([0.4, 0.3, 0.3], [4, 3, 3], gel()), 0.25);
    let mut simulation = Simulation::new(model.clone(), &still(1.0)).unwrap();
    let state = displaced(&model, |[x, y, z]| [0.1 * x + 0.05 * y, -0.04 * y + 0.06 * z, 0.03 * x - 0.05 * z]);
    simulation.set_state(state).unwrap();
    let forces = simulation.inner_forces(&context).unwrap();
    let is_inside = |node: &[f32; 3]| {
        let high = [0.4, 0.3, 0.3];
        (0..3).all(|axis| node[axis] > 1e-4 && node[axis] < high[axis] - 1e-4)
    };
    let size = |force: &[f32; 3]| force.iter().map(|part| part * part).sum::<f32>().sqrt();
    let (mut inside, mut most) = (0f32, 0f32);
    for (node, force) in model.nodes.iter().zip(&forces) {
        most = most.max(size(force));
        if is_inside(node) {
            inside = inside.max(size(force));
        }
    }
    assert!(most > 0.1 && inside < 5e-6 * most, "{inside} of {most}");
}

#[test]
fn an_element_has_six_modes_without_energy_and_eighteen_with_it() {
    let context = Context::serial();
    let cube = block([0.1; 3], [1; 3], gel());
    let mut bent = cube.clone();
    bent.cell = None;
    bent.nodes[7] = [0.02, 0.11, 0.12];
    bent.nodes[1] = [0.11, -0.02, 0.01];
    for (name, model) in [("cube", cube), ("hexahedron", bent)] {
        for (hourglass, rank) in [(1.0, 18), (0.0, 6)] {
            let mut simulation = Simulation::new(model.clone(), &still(hourglass)).unwrap();
            let step = 1e-4f32;
            let mut stiffness = vec![vec![0f64; 24]; 24];
            for column in 0..24 {
                let mut sides = [1.0f32, -1.0].map(|sign| {
                    let mut state = displaced(&model, |_| [0.0; 3]);
                    state.displacements[column / 3][column % 3] = sign * step;
                    simulation.set_state(state).unwrap();
                    simulation.inner_forces(&context).unwrap()
                });
                let [plus, minus] = &mut sides;
                for row in 0..24 {
                    let change = plus[row / 3][row % 3] - minus[row / 3][row % 3];
                    stiffness[row][column] = f64::from(change) / f64::from(2.0 * step);
                }
            }
            let values = eigenvalues(stiffness);
            let most = values.iter().copied().fold(0.0, f64::max);
            let nonzero = values.iter().filter(|value| **value > 1e-4 * most).count();
            assert_eq!(nonzero, rank, "{name} {hourglass}: {values:?}");
            assert!(values.iter().all(|value| *value > -1e-4 * most), "{values:?}");
        }
    }
}

/// The eigenvalues of the symmetric part of a matrix by Jacobi's rotations.
fn eigenvalues(mut a: Vec<Vec<f64>>) -> Vec<f64> {
    let n = a.len();
    for i in 0..n {
        for j in 0..i {
            let mean = 0.5 * (a[i][j] + a[j][i]);
            (a[i][j], a[j][i]) = (mean, mean);
        }
    }
    for _ in 0..30 {
        for p in 0..n {
            for q in p + 1..n {
                if a[p][q] == 0.0 {
                    continue;
                }
                let angle = 0.5 * (2.0 * a[p][q]).atan2(a[q][q] - a[p][p]);
                let (s, c) = angle.sin_cos();
                for row in a.iter_mut() {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
                for k in 0..n {
                    (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
                }
            }
        }
    }
    (0..n).map(|i| a[i][i]).collect()
}

/// Holds the lowest layer along z, lines of it along x and y, and moves the uppermost by `stretch` metres along z.
fn stretched(mut model: Model, height: f32, stretch: f32) -> (Simulation, Vec<u32>) {
    for node in model.nodes_within([-1.0, -1.0, -1e-4], [1.0, 1.0, 1e-4]) {
        model.held.push(Held { node, axes: 4 });
    }
    for node in model.nodes_within([-1e-4, -1.0, -1.0], [1e-4, 1.0, 1.0]) {
        model.held.push(Held { node, axes: 1 });
    }
    for node in model.nodes_within([-1.0, -1e-4, -1.0], [1.0, 1e-4, 1.0]) {
        model.held.push(Held { node, axes: 2 });
    }
    let top = model.nodes_within([-1.0, -1.0, height - 1e-4], [1.0, 1.0, height + 1e-4]);
    let mut simulation = Simulation::new(model, &still(1.0)).unwrap();
    let displacement = Curve::constant([0.0, 0.0, stretch]);
    simulation.drive(Drive { nodes: top.clone(), axes: 4, displacement }).unwrap();
    (simulation, top)
}

#[test]
fn a_stretched_cube_pulls_and_thins_as_the_neo_hookean_law_says() {
    let context = Context::serial();
    let cube = block([0.1; 3], [2; 3], gel());
    for model in [block([0.1; 3], [1; 3], gel()), cube.clone(), distorted(cube, 0.2)] {
        let (mut simulation, top) = stretched(model, 0.1, 0.01);
        let relaxation = simulation.relax(&context, 1e-5, 20_000, &mut Silent).unwrap();
        assert!(relaxation.is_at_rest, "{relaxation:?}");
        let force = simulation.reaction(&context, &top).unwrap()[2];
        assert!((force / 2.7336027 - 1.0).abs() < 2e-5, "{force} N");
        let far = simulation.model().nodes_within([0.0999, 0.0, 0.0], [0.1001, 1.0, 1.0]);
        for node in far {
            let thinned = simulation.state().displacements[node as usize][0];
            assert!((thinned + 0.00455841).abs() < 1e-7, "{thinned} m");
        }
    }
}

#[test]
fn strains_are_those_of_a_linear_field() {
    let context = Context::serial();
    let model = distorted(block([0.2, 0.1, 0.1], [4, 2, 2], gel()), 0.2);
    let mut simulation = Simulation::new(model.clone(), &still(1.0)).unwrap();
    // F = [[1, 0.2, 0], [0, 1, 0], [0.1, 0, 1.1]], and (FᵀF − 1)/2.
    simulation.set_state(displaced(&model, |[x, y, z]| [0.2 * y, 0.0, 0.1 * x + 0.1 * z])).unwrap();
    for state in simulation.element_states(&context).unwrap() {
        let expected = [0.005, 0.02, 0.105, 0.0, 0.055, 0.1];
        let is_near = state.strain.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 2e-6);
        assert!(is_near, "{:?}", state.strain);
    }
}

#[test]
fn a_rotated_block_has_no_force() {
    let context = Context::serial();
    let boxes = block([0.2, 0.1, 0.1], [4, 2, 2], gel());
    for model in [boxes.clone(), distorted(boxes, 0.2)] {
        let mut simulation = Simulation::new(model.clone(), &still(1.0)).unwrap();
        let (s, c) = 1.1f64.sin_cos();
        let turn = |[x, y, z]: [f32; 3]| {
            let [dx, dy] = [f64::from(x), f64::from(y)];
            [(c * dx - s * dy - dx) as f32 + 0.3, (s * dx + c * dy - dy) as f32, z - z]
        };
        simulation.set_state(displaced(&model, turn)).unwrap();
        let forces = simulation.inner_forces(&context).unwrap();
        let most = forces.as_flattened().iter().fold(0f32, |most, part| most.max(part.abs()));
        // Of 1e4 Pa on 2.5e-3 m² a rounding of 1e-6 leaves this.
        assert!(most < 1e-3, "{most} N");
    }
}

#[test]
fn boxes_have_the_forces_of_general_hexahedra() {
    let context = Context::serial();
    let boxes = block([0.2, 0.3, 0.1], [4, 3, 5], gel());
    let general = distorted(boxes.clone(), 0.0);
    let wave = |[x, y, z]: [f32; 3]| {
        [0.01 * (20.0 * y + 9.0 * z).sin(), 0.008 * (15.0 * x * z).cos(), 0.01 * (11.0 * x + 17.0 * y).sin()]
    };
    let [a, b] = [boxes, general].map(|model| {
        let mut simulation = Simulation::new(model.clone(), &still(0.7)).unwrap();
        simulation.set_state(displaced(&model, wave)).unwrap();
        simulation.inner_forces(&context).unwrap()
    });
    let most = a.as_flattened().iter().fold(0f32, |most, part| most.max(part.abs()));
    for (a, b) in a.as_flattened().iter().zip(b.as_flattened()) {
        assert!((a - b).abs() < 1e-5 * most, "{a} {b} of {most}");
    }
}

#[test]
fn an_isometric_muscle_pulls_with_its_strength_times_activation() {
    let context = Context::serial();
    for (direction, axis) in [([1.0, 0.0, 0.0], 0), ([0.0, 0.0, 1.0], 2)] {
        let mut model = block([0.1; 3], [2; 3], gel());
        model.muscles.push(Muscle { name: "biceps".into(), stiffness: 2e4, strength: 3e5 });
        model.fibres = Default::default();
        (0..8).for_each(|_| model.fibres.push([Fibre { muscle: 0, share: 0.5, direction }]));
        model.held = (0..27).map(|node| Held { node, axes: 7 }).collect();
        let mut simulation = Simulation::new(model, &still(1.0)).unwrap();
        simulation.activate(0, Curve::constant([0.6])).unwrap();
        let stress = simulation.element_states(&context).unwrap()[0].stress[axis];
        // Half of each element is muscle.
        assert!((stress / (0.5 * 0.6 * 3e5) - 1.0).abs() < 1e-5, "{stress} Pa");
        let mut low = [-1.0; 3];
        low[axis] = 0.0999;
        let end = simulation.model().nodes_within(low, [1.0; 3]);
        let pull = simulation.reaction(&context, &end).unwrap()[axis];
        assert!((pull / (0.5 * 0.6 * 3e5 * 0.01) - 1.0).abs() < 1e-5, "{pull} N");
    }
}

#[test]
fn a_cantilever_bends_as_timoshenko_says() {
    let context = Context::serial();
    let mut errors = Vec::new();
    for fine in [1u32, 2] {
        let material = Material::of_young("rubber", 1e5, 0.3, 1000.0).unwrap();
        let counts = [20 * fine, 2 * fine, 2 * fine];
        let mut model = block([10.0, 1.0, 1.0], counts, material);
        model.held = model
            .nodes_within([-0.01, -1.0, -1.0], [0.01, 2.0, 2.0])
            .into_iter()
            .map(|node| Held { node, axes: 7 })
            .collect();
        let end = model.nodes_within([9.99, -1.0, -1.0], [11.0, 2.0, 2.0]);
        // The load of a node is its share of the end face.
        let sizes = end.iter().map(|node| {
            let rim = |axis: usize| {
                let at = model.nodes[*node as usize][axis];
                if (0.01..=0.99).contains(&at) { 1.0 } else { 0.5 }
            };
            rim(1) * rim(2)
        });
        let sizes: Vec<f32> = sizes.collect();
        let all: f32 = sizes.iter().sum();
        let mut loads = vec![[0.0; 3]; model.nodes.len()];
        end.iter().zip(&sizes).for_each(|(node, size)| loads[*node as usize][2] = size / all);
        let mut simulation = Simulation::new(model, &still(1.0)).unwrap();
        simulation.load(&loads).unwrap();
        // Slow modes have small forces, so that their size does not say whether a slender beam is at rest.
        let relaxation = simulation.relax(&context, 1e-7, 12_000 * u64::from(fine), &mut Silent).unwrap();
        let mean =
            end.iter().map(|node| simulation.state().displacements[*node as usize][2]).sum::<f32>() / end.len() as f32;
        println!("cantilever of {} × {} × {}: {mean} m, {} steps", counts[0], counts[1], counts[2], relaxation.steps);
        errors.push((f64::from(mean) / 0.040306 - 1.0).abs());
    }
    assert!(errors[0] < 0.04 && errors[1] < 0.025 && errors[1] < errors[0], "{errors:?}");
}
