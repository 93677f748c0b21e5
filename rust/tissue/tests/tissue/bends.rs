//! Models that are bent, against closed forms, and a bent skin that a muscle wrinkles.

use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_tissue::{
    Bend, Curve, Description, Drive, FibreField, Layer, Material, Model, Muscle, Restraint, Shape, Simulation,
    SimulationOptions, Skin, Volume,
};

use crate::creation::cuboid;

const ACROSS: f64 = 0.075;
const UP: f64 = 0.095;

/// Skin over bone with a muscle along z, whose upper end is held.
fn strip(counts: [u32; 2], bend: [f64; 2], has_layers: bool) -> Description {
    let cell = [0.002, 0.0006, 0.001];
    let half = 0.5 * cell[0] * counts[0] as f32;
    let (low, high) = ([-half, 0.0, -0.012], [half, 0.0048, -0.012 + cell[2] * counts[1] as f32]);
    let side = |name: &str, side: usize| {
        let (points, triangles) = cuboid(low, high);
        Shape { name: name.into(), points, triangles: triangles[2 * side..2 * side + 2].to_vec() }
    };
    let whole = |name: &str, (points, triangles)| Shape { name: name.into(), points, triangles };
    let block = Volume { shape: whole("block", cuboid(low, high)), level: 0, material: 1, has_layers, muscle: None };
    let belly = cuboid([-1.0, 0.0027, -0.006], [1.0, 0.0042, 1.0]);
    let muscle = Muscle { name: "frontalis".into(), strength: 3e5, stiffness: 2e4 };
    let belly = Volume {
        shape: whole("frontalis", belly),
        level: 1,
        material: 2,
        has_layers: false,
        muscle: Some((muscle, FibreField::Uniform(glam::DVec3::Z))),
    };
    let names = ["dermis", "hypodermis", "muscle", "stratum corneum"];
    let layers = vec![Layer { material: 0, start: 0.0, thickness: 0.0018 }];
    let bone = Restraint { shape: side("bone", 3), is_sliding: true, is_internal: false, angle: 1.0 };
    Description {
        cell,
        samples: 4,
        share: 0.5,
        materials: names.map(|name| Material::of_library(name).unwrap()).to_vec(),
        volumes: vec![block, belly],
        skin: has_layers.then(|| Skin { shape: side("skin", 2), layers, epidermis: Some((3, 2e-5)) }),
        restraints: vec![bone],
        bound: vec![side("skin", 2)],
        bend: Some(Bend { radii: bend }),
    }
}

/// Returns how far a place is within the torus that the skin is bent to.
fn depth([x, y, z]: [f32; 3]) -> f64 {
    let around = f64::from(x).hypot(ACROSS - f64::from(y)) - (ACROSS - UP);
    UP - around.hypot(f64::from(z))
}

#[test]
fn a_bent_block_keeps_its_depths() {
    let context = Context::serial();
    let bent = strip([8, 20], [ACROSS, UP], true);
    let mut flat = bent.clone();
    flat.bend = None;
    let build = |description: &Description| description.build(&context, &mut Silent).unwrap().0;
    let (bent, flat) = (build(&bent), build(&flat));
    assert_eq!((bent.cell, flat.cell.is_some()), (None, true));
    assert_eq!((&bent.elements, &bent.mixtures, bent.nodes.len()), (&flat.elements, &flat.mixtures, flat.nodes.len()));
    for (node, from) in bent.nodes.iter().zip(&flat.nodes) {
        assert!((depth(*node) - f64::from(from[1])).abs() < 1e-7, "{from:?} went to {node:?}");
        // Arcs have the lengths of what they were.
        let angles = [(f64::from(node[0])).atan2(ACROSS - f64::from(node[1])) * ACROSS, f64::from(from[0])];
        assert!((angles[0] - angles[1]).abs() < 1e-7, "{angles:?}");
    }
    // Fibres along z stay across the normal and in the plane of the axis.
    let elements = bent.elements.iter().zip(0..);
    for (corners, element) in elements {
        for fibre in bent.fibres.get(element) {
            let middle: glam::DVec3 =
                corners.iter().map(|node| glam::Vec3::from(bent.nodes[*node as usize]).as_dvec3()).sum::<glam::DVec3>()
                    / 8.0;
            let ring = glam::DVec3::new(middle.x, middle.y - ACROSS, 0.0).normalize();
            let out = (middle - (ring * (ACROSS - UP) + glam::DVec3::Y * ACROSS)).normalize();
            let direction = glam::Vec3::from(fibre.direction).as_dvec3();
            assert!(direction.dot(out).abs() < 1e-3 && direction.z > 0.9, "{direction}");
            assert!(direction.dot(ring.cross(glam::DVec3::Z)).abs() < 1e-3, "{direction}");
        }
    }
    assert!(!bent.sliding.is_empty() && bent.sliding.iter().all(|it| it.distance.abs() < 2e-5), "{:?}", bent.sliding);
    let binding = &bent.bindings[0];
    assert!(binding.anchors.len() > 100, "{}", binding.anchors.len());
    let still = vec![[0.0; 4]; bent.nodes.len()];
    let points = binding.points(&context, &bent, &still);
    let used = binding.triangles.iter().flatten().map(|point| points[*point as usize]);
    let off = used.map(|point| depth(point).abs()).fold(0.0, f64::max);
    assert!(off < 2e-5, "{off}");
}

#[test]
fn bends_that_fold_the_block_are_refused() {
    let context = Context::serial();
    for (bend, says) in
        [([0.0, 0.1], "radii"), ([0.1, f64::NAN], "radii"), ([0.1, 0.004], "far"), ([0.001, 0.1], "far")]
    {
        let error = strip([2, 12], bend, false).build(&context, &mut Silent).unwrap_err();
        assert!(error.to_string().contains(says) && error.to_string().contains("bend"), "{error}");
    }
}

/// Contracts the muscle of a strip and returns how much the skin's height differs from that around it, in metres.
fn unevenness(has_layers: bool) -> f64 {
    let context = Context::serial();
    let (model, _) = strip([1, 48], [ACROSS, UP], has_layers).build(&context, &mut Silent).unwrap();
    let nodes = |model: &Model, set: &str| model.set(set).unwrap().nodes.clone();
    let still = || Curve::constant([0.0; 3]);
    let sides = [nodes(&model, "x-"), nodes(&model, "x+")].concat();
    let (top, skin) = (nodes(&model, "z+"), nodes(&model, "y-"));
    let options = SimulationOptions {
        gravity: [0.0; 3],
        damping: 40.0,
        safety: 0.5,
        mass_scaling: Some(2e-5),
        ..Default::default()
    };
    let rest = model.nodes.clone();
    let mut simulation = Simulation::new(model, &options).unwrap();
    simulation.drive(Drive { nodes: sides, axes: 1, displacement: still() }).unwrap();
    simulation.drive(Drive { nodes: top, axes: 7, displacement: still() }).unwrap();
    simulation.activate(0, Curve::new(vec![(0.0, [0.0]), (0.12, [0.6])]).unwrap()).unwrap();
    simulation.advance(&context, 8000, &mut Silent).unwrap();
    let places = simulation.positions();
    let mut line: Vec<(f32, f64)> =
        skin.iter().map(|node| (rest[*node as usize][2], -depth(places[*node as usize]))).collect();
    line.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Two nodes lie side by side; between the free end and the held one.
    let heights: Vec<f64> = line.chunks(2).map(|pair| 0.5 * (pair[0].1 + pair[1].1)).skip(10).collect();
    let bends = heights.windows(7).map(|window| (window[0] - 2.0 * window[3] + window[6]).abs());
    bends.take(heights.len() - 12).fold(0.0, f64::max)
}

#[test]
fn a_muscle_wrinkles_skin_in_layers_and_not_skin_without() {
    let (layered, plain) = (unevenness(true), unevenness(false));
    println!("uneven by {layered} m with layers, {plain} m without");
    assert!(layered > 4e-4 && plain < 0.25 * layered, "{layered} {plain}");
}
