//! Soft tissue: creation of models of the sizes in Table 2 of Warburton and Maddock 2013, steps of elements, and binding.

use glam::DVec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Error, Result};
use relievo_tissue::{
    Binding, Description, FibreField, Layer, Material, Model, Muscle, NurbsMuscle, Shape, Simulation,
    SimulationOptions, Skin, Volume,
};

use crate::measure::{Sample, core_seconds, memory, peak_of, sample, seconds};
use crate::report::{Goal, Report};

/// Steps of all elements that are timed together: some seconds, since the system counts hundredths.
const ELEMENT_STEPS: u64 = 60_000_000;
/// Points of the surface that is bound.
const POINTS: u32 = 1_000_000;

/// A model of the table: its radius and voxels in metres, its samples along an axis, the seconds that are the goal, and the
/// megabytes that it took there.
struct Row {
    radius: f32,
    voxel: f32,
    samples: u32,
    seconds: f64,
    megabytes: f64,
}

const TABLE: [Row; 3] = [
    Row { radius: 24.67e-3, voxel: 0.5e-3, samples: 4, seconds: 40.0, megabytes: 3250.0 },
    Row { radius: 15.69e-3, voxel: 0.5e-3, samples: 4, seconds: 4.0, megabytes: 496.0 },
    Row { radius: 38.3e-3, voxel: 2.5e-3, samples: 10, seconds: 4.0, megabytes: 148.0 },
];
/// Bytes of a megabyte.
const MEGABYTE: f64 = 1e6;

/// Measures creation, steps and binding.
pub fn run(report: &mut Report) -> Result<()> {
    let context = Context::new(&ContextOptions::default())?;
    for row in 0..TABLE.len() {
        creation(&context, report, row)?;
    }
    let core = Context::new(&ContextOptions { threads: 1, memory_limit: 0 })?;
    let mut rates = Vec::new();
    for side in [25, 50, 79] {
        rates.push(rate(&core, report, side)?.median());
    }
    let cost = Sample::new(vec![rates[0] / rates[2]]);
    report.add("cost of an element, of 493039 beside 15625", &cost, None, "times", Goal::AtMost(1.15));
    binding(&context, report)
}

/// A ball of skin layers around a muscle, whose elements are as many as those of a row of the table.
fn described(&Row { radius, voxel, samples, .. }: &Row) -> Result<Description> {
    let material = |name: &str| Material::of_library(name);
    let skin = ball("skin", radius, 96);
    let muscle = muscle(f64::from(radius))?;
    let (points, triangles) = muscle.mesh(48, 64);
    let belly = Shape { name: "belly".into(), points, triangles };
    Ok(Description {
        cell: [voxel; 3],
        samples,
        share: 0.5,
        materials: vec![
            material("hypodermis")?,
            material("dermis")?,
            material("stratum corneum")?,
            material("muscle")?,
        ],
        volumes: vec![
            Volume { shape: skin.clone(), level: 0, material: 0, has_layers: true, muscle: None },
            Volume {
                shape: belly,
                level: 1,
                material: 3,
                has_layers: false,
                muscle: Some((
                    Muscle { name: "belly".into(), stiffness: 1e4, strength: 3e5 },
                    FibreField::Nurbs(Box::new(muscle)),
                )),
            },
        ],
        skin: Some(Skin {
            shape: skin,
            layers: vec![Layer { material: 1, start: 0.0, thickness: 1.8e-3 }],
            epidermis: Some((2, 2e-5)),
        }),
        ..Description::default()
    })
}

/// Makes the model of a row, and says how long that takes and what a process that does it occupies at its peak.
fn creation(context: &Context, report: &mut Report, number: usize) -> Result<()> {
    let row = &TABLE[number];
    let description = described(row)?;
    let elements = description.build(context, &mut Silent)?.0.elements.len();
    let case = format!("creation, {elements} elements, {}³ samples", row.samples);
    let time = sample(1, || seconds(|| description.build(context, &mut Silent)));
    report.add(&case, &time, None, "s", Goal::AtMost(row.seconds));
    let case = format!("{case}: memory");
    match peak_of("creation", "--row", &number.to_string()) {
        Some(bytes) => {
            let [ours, paper] = [bytes / MEGABYTE, row.megabytes].map(|value| Sample::new(vec![value]));
            report.add(&case, &ours, Some(("the paper", &paper)), "MB", Goal::RatioAtMost(0.6));
        }
        None => report.skip(&case, "the system does not tell the peak of a process"),
    }
    Ok(())
}

/// Prints how many bytes a process that makes the model of a row occupies at its peak.
pub fn peak(row: usize) -> Result<()> {
    let row = TABLE.get(row).ok_or_else(|| Error::invalid(format!("there is no row {row}")))?;
    let context = Context::new(&ContextOptions::default())?;
    let made = described(row)?.build(&context, &mut Silent)?;
    let peak = memory("VmHWM");
    drop(made);
    peak.iter().for_each(|bytes| println!("{bytes}"));
    Ok(())
}

/// Steps of the elements of a cube of gel on one core, by the time that it works. Returns millions a second.
fn rate(context: &Context, report: &mut Report, side: u32) -> Result<Sample> {
    let gel = Material { name: "gel".into(), density: 1000.0, shear: 1006.71, bulk: 5e4 };
    let model = Model::block([0.0; 3], [0.1 / side as f32; 3], [side; 3], gel)?;
    let elements = model.elements.len() as u64;
    let mut simulation = Simulation::new(model, &SimulationOptions::default())?;
    let steps = ELEMENT_STEPS.div_ceil(elements);
    let mut outcome = Ok(());
    let rate = sample(3, || {
        let begin = core_seconds();
        outcome = simulation.advance(context, steps, &mut Silent);
        1e-6 * (steps * elements) as f64 / (core_seconds() - begin)
    });
    outcome?;
    report.add(&format!("steps on one core, {elements} elements"), &rate, None, "M/s", Goal::AtLeast(13.0));
    Ok(rate)
}

/// Binding of a surface, and its update.
fn binding(context: &Context, report: &mut Report) -> Result<()> {
    let gel = Material { name: "gel".into(), density: 1000.0, shear: 1006.71, bulk: 5e4 };
    let model = Model::block([0.0; 3], [2e-3; 3], [50; 3], gel)?;
    let place = |at: u32| {
        let turn = |by: f32| 0.05 + 0.049 * (at as f32 * by).sin();
        [turn(0.618), turn(0.377), turn(0.271)]
    };
    let points: Vec<[f32; 3]> = (0..POINTS).map(place).collect();
    let bound = Binding::new(context, &model, "surface", &points, &[])?;
    let time = sample(3, || seconds(|| Binding::new(context, &model, "surface", &points, &[])));
    report.add("binding of 1 M points", &time, None, "s", Goal::AtMost(1.0));
    let displacements = vec![[1e-3, 0.0, 0.0, 0.0]; model.nodes.len()];
    let time = sample(5, || 1e3 * seconds(|| bound.points(context, &model, &displacements)));
    report.add("update of 1 M bound points", &time, None, "ms", Goal::AtMost(20.0));
    Ok(())
}

fn ball(name: &str, radius: f32, rings: u32) -> Shape {
    let around = 2 * rings;
    let mut points = vec![[0.0, 0.0, -radius], [0.0, 0.0, radius]];
    for ring in 1..rings {
        let polar = std::f32::consts::PI * ring as f32 / rings as f32;
        points.extend((0..around).map(|at| {
            let angle = std::f32::consts::TAU * at as f32 / around as f32;
            [polar.sin() * angle.cos(), polar.sin() * angle.sin(), -polar.cos()].map(|part| radius * part)
        }));
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
    Shape { name: name.into(), points, triangles }
}

/// A bent muscle inside of a ball.
fn muscle(radius: f64) -> Result<NurbsMuscle> {
    let rings: Vec<Vec<[f64; 4]>> = (0..7)
        .map(|ring| {
            let along = f64::from(ring) / 6.0;
            let middle = radius * DVec3::new(1.2 * along - 0.6, 0.3 * along * along, 0.0);
            let thick = radius * (0.12 + 0.15 * (std::f64::consts::PI * along).sin());
            let point = |at: u32| {
                let angle = std::f64::consts::TAU * f64::from(at) / 8.0;
                [middle.x, middle.y + thick * angle.cos(), middle.z + thick * angle.sin(), 1.0]
            };
            (0..8).map(point).collect()
        })
        .collect();
    NurbsMuscle::new(&rings)
}
