//! Models made from surfaces, against closed forms.

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions};
use relievo_testing::ball;
use relievo_tissue::{
    Curve, Description, Drive, FibreField, Labels, Layer, Material, Model, Muscle, NurbsMuscle, Range, Restraint, Scan,
    Shape, Simulation, SimulationOptions, Skin, Volume,
};

fn shape(name: &str, (points, triangles): (Vec<[f32; 3]>, Vec<[u32; 3]>)) -> Shape {
    Shape { name: name.into(), points, triangles }
}

fn volume(shape: Shape, level: u32, material: u32) -> Volume {
    Volume { shape, level, material, has_layers: false, muscle: None }
}

/// A box of triangles.
pub fn cuboid(low: [f32; 3], high: [f32; 3]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let corner = |at: usize| std::array::from_fn(|axis| if at >> axis & 1 != 0 { high[axis] } else { low[axis] });
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    ((0..8).map(corner).collect(), triangles)
}

fn torus(large: f32, small: f32, count: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let angle = |at: u32| std::f32::consts::TAU * at as f32 / count as f32;
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for a in 0..count {
        for b in 0..count {
            let (u, v) = (angle(a), angle(b));
            points.push([(large + small * v.cos()) * u.cos(), (large + small * v.cos()) * u.sin(), small * v.sin()]);
            let id = |a: u32, b: u32| (a % count) * count + b % count;
            triangles.push([id(a, b), id(a + 1, b), id(a + 1, b + 1)]);
            triangles.push([id(a, b), id(a + 1, b + 1), id(a, b + 1)]);
        }
    }
    (points, triangles)
}

fn materials() -> Vec<Material> {
    ["dermis", "muscle", "hypodermis", "stratum corneum"].map(|name| Material::of_library(name).unwrap()).to_vec()
}

fn description(volumes: Vec<Volume>, cell: f32) -> Description {
    Description { cell: [cell; 3], samples: 4, share: 0.5, materials: materials(), volumes, ..Description::default() }
}

#[test]
fn volumes_of_a_ball_and_a_torus_are_those_of_closed_forms() {
    let context = Context::serial();
    let pi = std::f64::consts::PI;
    let cases = [
        (ball(0.05, 96), 4.0 / 3.0 * pi * 0.05f64.powi(3)),
        (torus(0.05, 0.02, 160), 2.0 * pi * pi * 0.05 * 0.02f64.powi(2)),
    ];
    for (mesh, expected) in cases {
        let mut description = description(vec![volume(shape("body", mesh), 0, 0)], 0.004);
        description.cell = [0.004, 0.005, 0.003];
        let (model, report) = description.build(&context, &mut Silent).unwrap();
        assert!((report.volume / expected - 1.0).abs() < 5e-3, "{} m³, not {expected}", report.volume);
        let elements = model.elements.len() as f64 * 0.004 * 0.005 * 0.003;
        assert!((elements / expected - 1.0).abs() < 0.02, "{elements}");
    }
}

#[test]
fn any_number_of_samples_finds_a_box() {
    let context = Context::serial();
    for samples in [1, 2, 3, 5, 7] {
        let mut description = description(vec![volume(shape("box", cuboid([0.0; 3], [0.04, 0.03, 0.02])), 0, 0)], 0.01);
        description.samples = samples;
        let (model, report) = description.build(&context, &mut Silent).unwrap();
        assert_eq!((model.elements.len(), model.nodes.len()), (24, 60), "{samples}");
        assert!((report.volume / 24e-6 - 1.0).abs() < 1e-6, "{samples}: {}", report.volume);
    }
}

#[test]
fn lower_levels_override_and_the_same_level_blends() {
    let context = Context::serial();
    let skin = volume(shape("skin", cuboid([0.0; 3], [0.08, 0.04, 0.04])), 0, 0);
    // Both reach out of the skin and into each other.
    let one = volume(shape("one", cuboid([-0.02, -0.01, -0.01], [0.05, 0.05, 0.02])), 1, 1);
    let other = volume(shape("other", cuboid([0.03, -0.01, -0.01], [0.1, 0.05, 0.02])), 1, 2);
    let (model, _) = description(vec![skin, one, other], 0.01).build(&context, &mut Silent).unwrap();
    assert_eq!(model.elements.len(), 8 * 4 * 4);
    for element in 0..model.elements.len() {
        let [x, _, z] = model.nodes[model.elements[element][0] as usize];
        let expected: &[(u32, f32)] = match (x, z) {
            (_, z) if z > 0.019 => &[(0, 1.0)],
            (x, _) if x < 0.029 => &[(1, 1.0)],
            (x, _) if x < 0.049 => &[(1, 0.5), (2, 0.5)],
            _ => &[(2, 1.0)],
        };
        let found: Vec<(u32, f32)> = model.mixtures.get(element).iter().map(|it| (it.material, it.share)).collect();
        assert_eq!(found, expected, "{x} {z}");
    }
}

#[test]
fn layers_follow_depth_and_the_epidermis_lies_on_top() {
    let context = Context::serial();
    let mesh = cuboid([0.0; 3], [0.04, 0.04, 0.02]);
    let top = shape("skin", (mesh.0.clone(), mesh.1[10..].to_vec()));
    let mut body = volume(shape("tissue", mesh), 0, 2);
    body.has_layers = true;
    let mut description = description(vec![body], 0.002);
    let layers = vec![Layer { material: 0, start: 0.0, thickness: 0.005 }];
    description.skin = Some(Skin { shape: top, layers, epidermis: Some((3, 0.0002)) });
    let (model, _) = description.build(&context, &mut Silent).unwrap();
    assert_eq!(model.elements.len(), 20 * 20 * 10);
    for element in 0..model.elements.len() {
        let portions = model.mixtures.get(element);
        let of = |material: u32| portions.iter().find(|it| it.material == material).map_or(0.0, |it| it.share);
        let depth = 0.02 - model.nodes[model.elements[element][4] as usize][2];
        let (dermis, epidermis) = match depth {
            depth if depth < 0.001 => (0.9, 0.1),
            depth if depth < 0.003 => (1.0, 0.0),
            depth if depth < 0.005 => (0.5, 0.0),
            _ => (0.0, 0.0),
        };
        assert!((of(0) - dermis).abs() < 1e-5 && (of(3) - epidermis).abs() < 1e-5, "{depth}: {portions:?}");
    }
}

/// A straight muscle of rings along x that grow and shrink.
fn spindle(bend: f64) -> NurbsMuscle {
    let rings: Vec<Vec<[f64; 4]>> = (0..7)
        .map(|ring| {
            let x = 0.01 * f64::from(ring);
            let radius = 0.008 + 0.004 * (f64::from(ring) / 6.0 * std::f64::consts::PI).sin();
            let point = |at: u32| {
                let angle = std::f64::consts::TAU * f64::from(at) / 8.0;
                [x, radius * angle.cos() + bend * x * x, radius * angle.sin(), 1.0]
            };
            (0..8).map(point).collect()
        })
        .collect();
    NurbsMuscle::new(&rings).unwrap()
}

#[test]
fn parameters_of_a_muscle_are_inverted_and_fibres_follow_it() {
    let muscle = spindle(5.0);
    let (mut near, mut most) = (None, 0f64);
    for at in 0..300u32 {
        let (u, v, w) =
            (f64::from(at) * 0.618 % 1.0, 0.02 + f64::from(at % 97) / 100.0, 0.02 + f64::from(at % 31) / 33.0);
        let place = muscle.point([u, v, w].into());
        let found = muscle.parameters(place, near);
        near = Some(found);
        most = most.max(muscle.point(found).distance(place));
        assert!((found.y - v).abs() < 1e-5 && (found.z - w).abs() < 1e-5, "{found} is not {u} {v} {w}");
    }
    assert!(most < 1e-9, "{most} m");
    // The central curve of the straight muscle is along x.
    let (direction, _) = spindle(0.0).direction([0.03, 0.001, 0.0].into(), None);
    assert!(direction.x.abs() > 0.999, "{direction}");
    assert!(NurbsMuscle::new(&[vec![[0.0; 4]; 8], vec![[0.0; 4]; 8]]).is_err());
    assert!(NurbsMuscle::new(&[vec![[0.0, 0.0, 0.0, 1.0]; 8]]).is_err());
}

fn muscular(context: &Context) -> Model {
    let muscle = spindle(0.0);
    let mut belly = volume(shape("belly", muscle.mesh(24, 24)), 1, 1);
    belly.muscle =
        Some((Muscle { name: "belly".into(), stiffness: 1e4, strength: 3e5 }, FibreField::Nurbs(Box::new(muscle))));
    let skin = volume(shape("skin", cuboid([-0.01, -0.02, -0.02], [0.07, 0.02, 0.02])), 0, 0);
    let mut description = description(vec![skin, belly], 0.005);
    let floor = cuboid([-0.01, -0.02, -0.02], [0.07, 0.02, 0.02]);
    let end = |name: &str, triangles: &[[u32; 3]], is_sliding: bool| Restraint {
        shape: shape(name, (floor.0.clone(), triangles.to_vec())),
        is_sliding,
        is_internal: false,
        angle: 1.5,
    };
    description.restraints = vec![end("bone", &floor.1[8..10], true), end("end", &floor.1[..2], false)];
    description.build(context, &mut Silent).unwrap().0
}

#[test]
fn muscles_have_fibres_and_restraints_have_nodes() {
    let context = Context::serial();
    let model = muscular(&context);
    let with_fibres = (0..model.elements.len()).filter(|element| !model.fibres.get(*element).is_empty());
    let mut count = 0;
    for element in with_fibres {
        count += 1;
        let fibre = model.fibres.get(element)[0];
        // They lean by as much as the belly grows.
        assert!(fibre.direction[0].abs() > 0.95, "{fibre:?}");
        let [first, last] = [0, 6].map(|corner| model.nodes[model.elements[element][corner] as usize]);
        assert!(first[0].max(last[0]) > -0.001 && first[1].abs().min(last[1].abs()) < 0.014);
    }
    assert!(count > 50, "{count}");
    assert_eq!(model.set("end").unwrap().nodes.len(), 9 * 9);
    assert_eq!(model.sliding.len(), 17 * 9);
    assert!(model.sliding.iter().all(|sliding| sliding.distance.abs() < 1e-6));
    assert_eq!(model.set("z-").unwrap().nodes.len(), 17 * 9);
    assert!(model.set("q").unwrap_err().to_string().contains("bone"));
}

#[test]
fn any_number_of_threads_makes_the_same_model() {
    let build = |threads| muscular(&Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap());
    assert_eq!(build(1), build(3));
}

#[test]
fn surfaces_that_make_no_model_are_refused() {
    let context = Context::serial();
    let refused = |spoil: &dyn Fn(&mut Description), why: &str| {
        let mut description = description(vec![volume(shape("skin", cuboid([0.0; 3], [0.04; 3])), 0, 0)], 0.01);
        spoil(&mut description);
        let error = description.build(&context, &mut Silent).unwrap_err().to_string();
        assert!(error.contains(why), "{error} should say {why}");
    };
    refused(&|it| it.volumes[0].shape.triangles.truncate(11), "open");
    refused(&|it| it.volumes[0].shape.triangles.iter_mut().for_each(|t| t.swap(0, 1)), "inside out");
    refused(&|it| it.volumes[0].shape.points[2][0] = f32::NAN, "point 2");
    refused(&|it| it.volumes[0].shape.triangles[3][1] = 99, "triangle 3");
    refused(&|it| it.volumes[0].level = 1, "level 0");
    refused(&|it| it.volumes[0].material = 44, "material 44");
    refused(&|it| it.volumes[0].has_layers = true, "skin");
    refused(&|it| it.cell = [0.0; 3], "voxel");
    refused(&|it| it.cell = [1e-6; 3], "too large");
    refused(&|it| it.samples = 0, "samples");
    refused(&|it| it.volumes.clear(), "0 volumes");
    refused(
        &|it| {
            let far = Shape {
                name: "far".into(),
                points: vec![[9.0; 3], [9.1, 9.0, 9.0], [9.0, 9.1, 9.0]],
                triangles: vec![[0, 1, 2]],
            };
            it.restraints.push(Restraint { shape: far, is_sliding: false, is_internal: false, angle: 1.5 });
        },
        "far",
    );
}

/// A scan of NIfTI-1 of bytes, in millimetres.
fn nifti(counts: [i16; 3], values: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0; 352];
    bytes[..4].copy_from_slice(&348i32.to_le_bytes());
    for (at, count) in [3, counts[0], counts[1], counts[2]].into_iter().enumerate() {
        bytes[40 + 2 * at..42 + 2 * at].copy_from_slice(&count.to_le_bytes());
    }
    bytes[70..72].copy_from_slice(&2i16.to_le_bytes());
    for (at, size) in [1.0f32, 2.0, 2.0, 3.0].into_iter().enumerate() {
        bytes[76 + 4 * at..80 + 4 * at].copy_from_slice(&size.to_le_bytes());
    }
    bytes[108..112].copy_from_slice(&352f32.to_le_bytes());
    bytes[123] = 2;
    bytes[344..348].copy_from_slice(b"n+1\0");
    bytes.extend(values);
    bytes
}

#[test]
fn a_labelled_scan_becomes_a_model() {
    let context = Context::serial();
    // Two layers of bone below two of fat, and air around.
    let label = |at: usize| {
        let (x, y, z) = (at % 6, at / 6 % 6, at / 36);
        if !(1..5).contains(&x) || !(1..5).contains(&y) {
            0
        } else if z < 2 {
            200
        } else {
            90
        }
    };
    let values: Vec<u8> = (0..6 * 6 * 4).map(label).collect();
    let bytes = nifti([6, 6, 4], &values);
    let scan = Scan::decode(bytes.as_slice(), u64::MAX).unwrap();
    assert_eq!((scan.counts, scan.cell), ([6, 6, 4], [2e-3, 2e-3, 3e-3]));
    let ranges = vec![Range { material: 0, low: 150.0, high: 255.0 }, Range { material: 1, low: 50.0, high: 255.0 }];
    let labels = Labels { block: 2, share: 0.2, materials: materials(), ranges };
    let (model, report) = labels.build(&context, &scan).unwrap();
    // Of three by three columns the corners are a quarter full, the sides a half.
    assert_eq!((model.elements.len(), report.voxels), (18, [3, 3, 2]));
    assert!((report.volume / (16.0 * 4.0 * 12e-9) - 1.0).abs() < 1e-6);
    for element in 0..18 {
        let z = model.nodes[model.elements[element][0] as usize][2];
        assert_eq!(model.mixtures.get(element)[0].material, u32::from(z > 1e-3));
    }
    assert!((0..bytes.len()).all(|length| Scan::decode(&bytes[..length], u64::MAX).is_err()));
    assert!(Scan::decode(nifti([i16::MAX; 3], &[]).as_slice(), 1 << 20).unwrap_err().to_string().contains("memory"));
    assert!(Scan::decode(nifti([6, -1, 4], &values).as_slice(), u64::MAX).is_err());
    assert!(Labels { block: 0, ..labels.clone() }.build(&context, &scan).is_err());
    assert!(Labels { ranges: Vec::new(), ..labels }.build(&context, &scan).is_err());
}
/// Shortens a block of skin by a fifth between two plates. Returns how uneven its upper side is, in metres.
fn shortened(has_layers: bool) -> f32 {
    let context = Context::serial();
    let mesh = cuboid([0.0; 3], [0.04, 0.002, 0.008]);
    let top = shape("skin", (mesh.0.clone(), mesh.1[10..].to_vec()));
    let mut block = volume(shape("block", mesh), 0, 2);
    block.has_layers = has_layers;
    let mut description = description(vec![block], 0.001);
    description.cell = [0.001, 0.002, 0.001];
    let layers = vec![Layer { material: 0, start: 0.0, thickness: 0.0018 }];
    description.skin = has_layers.then_some(Skin { shape: top, layers, epidermis: Some((3, 4e-5)) });
    let (model, _) = description.build(&context, &mut Silent).unwrap();
    let nodes = |set: &str| model.set(set).unwrap().nodes.clone();
    let top = nodes("z+");
    let move_to = |x: f32| Curve::new(vec![(0.0, [0.0; 3]), (0.1, [x, 0.0, 0.0])]).unwrap();
    let drives = [
        Drive { nodes: nodes("x-"), axes: 1, displacement: move_to(0.004) },
        Drive { nodes: nodes("x+"), axes: 1, displacement: move_to(-0.004) },
        Drive { nodes: [nodes("y-"), nodes("y+")].concat(), axes: 2, displacement: move_to(0.0) },
        Drive { nodes: nodes("z-"), axes: 4, displacement: move_to(0.0) },
    ];
    let options = SimulationOptions { damping: 30.0, safety: 0.5, mass_scaling: Some(1e-5), ..Default::default() };
    let mut simulation = Simulation::new(model, &options).unwrap();
    drives.into_iter().for_each(|drive| simulation.drive(drive).unwrap());
    simulation.advance(&context, 12_000, &mut Silent).unwrap();
    let places = simulation.positions();
    // Beside the plates the skin slides up.
    let heights = top.iter().map(|node| places[*node as usize]).filter(|place| place[0] > 0.01 && place[0] < 0.03);
    let heights: Vec<f32> = heights.map(|place| place[2]).collect();
    heights.iter().copied().fold(0.0, f32::max) - heights.iter().copied().fold(1.0, f32::min)
}

#[test]
fn skin_in_layers_wrinkles_and_skin_without_does_not() {
    let (layered, plain) = (shortened(true), shortened(false));
    println!("uneven by {layered} m with layers, {plain} m without");
    assert!(layered > 1e-3 && plain < 2e-4, "{layered} {plain}");
}
