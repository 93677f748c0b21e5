//! Steps on a graphics device beside those of the processor.

use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_gpu::Device;
use relievo_testing::ball;
use relievo_testing::device;
use relievo_tissue::{
    Body, Collider, Curve, DistanceField, Drive, Fibre, Held, Lists, Material, Model, Muscle, Portion, Shape,
    Simulation, SimulationOptions, Sliding, State,
};

use crate::bodies;
use crate::contact::firm;

/// A block of two materials with a muscle along x in its upper half; its lower face is held. `bent` moves its nodes, so that
/// no element is a box.
fn block(bent: bool) -> Model {
    let gel = Material { name: "gel".into(), density: 1000.0, shear: 1000.0, bulk: 5e4 };
    let mut model = Model::block([0.0; 3], [0.0125, 0.01, 0.0125], [10, 9, 8], gel).unwrap();
    model.materials.push(Material { name: "core".into(), density: 1100.0, shear: 4000.0, bulk: 8e4 });
    let count = model.elements.len();
    let is_upper = |model: &Model, element: usize| model.nodes[model.elements[element][0] as usize][2] > 0.03;
    let portions = (0..count).map(|element| match is_upper(&model, element) {
        true => vec![Portion { material: 0, share: 0.7 }, Portion { material: 1, share: 0.3 }],
        false => vec![Portion { material: 0, share: 1.0 }],
    });
    let portions: Vec<_> = portions.collect();
    model.mixtures = Lists::default();
    portions.into_iter().for_each(|list| model.mixtures.push(list));
    model.muscles.push(Muscle { name: "biceps".into(), stiffness: 2000.0, strength: 3e4 });
    let fibres = (0..count).map(|element| match is_upper(&model, element) {
        true => vec![Fibre { muscle: 0, direction: [0.8, 0.6, 0.0], share: 0.5 }],
        false => Vec::new(),
    });
    let fibres: Vec<_> = fibres.collect();
    model.fibres = Lists::default();
    fibres.into_iter().for_each(|list| model.fibres.push(list));
    for (node, place) in (0..).zip(&model.nodes) {
        if place[2] == 0.0 {
            model.held.push(Held { node, axes: 7 });
        }
    }
    if bent {
        for place in &mut model.nodes {
            let turn = 2.0 * place[2];
            *place =
                [place[0] * turn.cos() + 0.1 * turn, place[1] * (1.0 + place[0]), place[2] - place[0] * turn.sin()];
        }
        model.cell = None;
    }
    model
}

/// The block with a contraction, loads, a driven corner, a floor and a ball that comes down, which rubs.
fn simulation(bent: bool) -> Simulation {
    let model = block(bent);
    let corner: Vec<u32> =
        (0..).zip(&model.nodes).filter(|(_, at)| at[2] > 0.09 && at[0] < 0.02).map(|it| it.0).collect();
    let loads: Vec<[f32; 3]> = model.nodes.iter().map(|at| [0.0, if at[2] > 0.08 { 2e-4 } else { 0.0 }, 0.0]).collect();
    let options = SimulationOptions { damping: 5.0, safety: 0.4, ..SimulationOptions::default() };
    let mut made = Simulation::new(model, &options).unwrap();
    made.activate(0, Curve::new(vec![(0.0, [0.0]), (0.05, [1.0])]).unwrap()).unwrap();
    let displacement = Curve::new(vec![(0.0, [0.0; 3]), (0.05, [0.0, 0.004, 0.0])]).unwrap();
    made.drive(Drive { nodes: corner, axes: 2, displacement }).unwrap();
    made.load(&loads).unwrap();
    let down = Curve::new(vec![(0.0, [0.06, 0.04, 0.131]), (0.05, [0.07, 0.04, 0.124])]).unwrap();
    let turn = Curve::new(vec![(0.0, [0.0; 3]), (0.05, [0.0, 1.0, 0.2])]).unwrap();
    made.add_collider(Collider::new(Body::Ball(0.03), 0.4, down, turn).unwrap());
    let still = Curve::constant([0.0; 3]);
    made.add_collider(Collider::new(Body::Floor, 0.2, Curve::constant([0.0, 0.0, -0.02]), still).unwrap());
    made
}

fn run(simulation: &mut Simulation, steps: u64) -> State {
    simulation.advance(&Context::serial(), steps, &mut Silent).unwrap();
    simulation.state().clone()
}

fn largest(rows: &[[f32; 4]]) -> f32 {
    rows.iter().flatten().fold(0.0, |most, part| most.max(part.abs()))
}

fn difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    let apart: Vec<[f32; 4]> = a.iter().zip(b).map(|(a, b)| std::array::from_fn(|axis| a[axis] - b[axis])).collect();
    largest(&apart) / largest(a)
}

#[test]
fn a_device_moves_nodes_as_the_processor_does() {
    // One device for all, since it compiles its kernels anew.
    let Some(device) = device() else { return };
    moves_as_the_processor(&device);
    slides_and_meets_meshes(&device);
    leaves_the_rest_to_the_processor(&device);
    stops_before_an_element_is_inside_out(&device);
}

fn moves_as_the_processor(device: &Device) {
    for bent in [false, true] {
        let mut ours = simulation(bent);
        let mut theirs = simulation(bent);
        theirs.use_device(Some(device));
        assert_eq!(theirs.device_refusal(), None);
        // Until the ball touches, what differs is rounding.
        let (a, b) = (run(&mut ours, 3), run(&mut theirs, 3));
        assert_eq!((a.steps, a.seconds), (b.steps, b.seconds));
        let apart = difference(&a.velocities, &b.velocities);
        assert!(apart < 1e-5, "bent {bent}: velocities differ by {apart} after 3 steps");
        let rest = (0.05 / f64::from(ours.steps().step)) as u64;
        let (a, b) = (run(&mut ours, rest), run(&mut theirs, rest));
        assert!(largest(&a.displacements) > 0.003, "it moves");
        let apart = difference(&a.displacements, &b.displacements);
        assert!(apart < 1e-3, "bent {bent}: displacements differ by {apart} after {rest} steps");
        // In the same way every time, in one call or in several, and it goes on on the processor.
        let mut again = simulation(bent);
        again.use_device(Some(device));
        run(&mut again, 100);
        assert_eq!(run(&mut again, 3 + rest - 100), b);
        again.use_device(None);
        let next = difference(&run(&mut again, 1).displacements, &run(&mut theirs, 1).displacements);
        assert!(next < 1e-5, "{next}");
    }
}

/// A block whose lowest nodes slide on a ball, and a ball of triangles with friction that comes down on it and turns.
fn sliding() -> Simulation {
    let (points, triangles) = ball(0.3, 24);
    let mut model = bodies::block([0.2, 0.2, 0.05], [6, 6, 2], firm());
    model.nodes.iter_mut().for_each(|at| *at = [at[0] - 0.1, at[1] - 0.1, at[2] + 0.31]);
    let field = DistanceField::new(&points, &triangles).unwrap();
    let lowest = model.nodes_within([-1.0, -1.0, 0.3], [1.0, 1.0, 0.311]);
    let distance = |node: u32| field.closest(glam::Vec3::from(model.nodes[node as usize]), None).distance;
    model.sliding = lowest.iter().map(|node| Sliding { node: *node, surface: 0, distance: distance(*node) }).collect();
    model.surfaces.push(Shape { name: "skull".into(), points, triangles });
    let corner = model.nodes_within([-1.0, -1.0, 0.359], [-0.0999, -0.0999, 1.0]);
    model.held = corner.into_iter().map(|node| Held { node, axes: 7 }).collect();
    let options = SimulationOptions { gravity: [6.0, 3.0, -9.81], damping: 5.0, ..SimulationOptions::default() };
    let mut made = Simulation::new(model, &options).unwrap();
    let (points, triangles) = ball(0.05, 12);
    let end = 200.0 * f64::from(made.steps().step);
    let down = Curve::new(vec![(0.0, [0.01, 0.02, 0.411]), (end, [0.015, 0.02, 0.402])]).unwrap();
    let turn = Curve::new(vec![(0.0, [0.0; 3]), (end, [0.0, 0.3, 0.1])]).unwrap();
    let mesh = Body::Mesh(DistanceField::new(&points, &triangles).unwrap());
    made.add_collider(Collider::new(mesh, 0.4, down, turn).unwrap());
    made
}

fn slides_and_meets_meshes(device: &Device) {
    let (mut ours, mut theirs) = (sliding(), sliding());
    theirs.use_device(Some(device));
    assert_eq!(theirs.device_refusal(), None);
    let (a, b) = (run(&mut ours, 3), run(&mut theirs, 3));
    let apart = difference(&a.velocities, &b.velocities);
    println!("sliding nodes: velocities differ by {apart} after 3 steps");
    assert!(apart < 1e-5, "{apart}");
    let (a, b) = (run(&mut ours, 197), run(&mut theirs, 197));
    let apart = difference(&a.displacements, &b.displacements);
    println!("sliding nodes and a mesh: displacements differ by {apart} after 200 steps");
    // The ball has pressed the upper face in.
    assert!(b.displacements.iter().any(|u| u[2] < -0.002), "the mesh touches");
    assert!(apart < 1e-3, "{apart}");
    let (model, places) = (theirs.model(), theirs.positions());
    let shape = &model.surfaces[0];
    let field = DistanceField::new(&shape.points, &shape.triangles).unwrap();
    for slide in &model.sliding {
        let off = field.closest(glam::Vec3::from(places[slide.node as usize]), None).distance - slide.distance;
        assert!(off.abs() < 1e-6, "{off}");
    }
}

fn leaves_the_rest_to_the_processor(device: &Device) {
    let options = SimulationOptions { halvings: 2, ..SimulationOptions::default() };
    let [mut given, mut plain] = [(); 2].map(|()| Simulation::new(block(false), &options).unwrap());
    given.use_device(Some(device));
    assert_eq!(given.device_refusal(), Some("steps may be halved"));
    assert_eq!(run(&mut given, 20), run(&mut plain, 20));
}

fn stops_before_an_element_is_inside_out(device: &Device) {
    let mut torn = simulation(false);
    torn.use_device(Some(device));
    let before = run(&mut torn, 10);
    let top = (0..).zip(&torn.model().nodes).filter(|(_, at)| at[2] > 0.09).map(|(node, _)| node).collect();
    let displacement = Curve::new(vec![(0.0, [0.0; 3]), (0.02, [0.0, 0.0, -0.2])]).unwrap();
    torn.drive(Drive { nodes: top, axes: 4, displacement }).unwrap();
    let error = torn.advance(&Context::serial(), 400, &mut Silent).unwrap_err().to_string();
    assert!(error.contains("inside out") && error.contains("element "), "{error}");
    assert_eq!(*torn.state(), before);
}
