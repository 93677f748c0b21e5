//! Soft tissue: creation of models of the sizes in Table 2 of Warburton and Maddock 2013, steps of elements, also beside
//! NiftySim, and binding.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use glam::DVec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Error, Result};
use relievo_tissue::{
    Binding, Curve, Description, Drive, FibreField, Held, Layer, Material, Model, Muscle, NurbsMuscle, Shape,
    Simulation, SimulationOptions, Skin, Volume,
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

/// Names the program of NiftySim, built without Boost: its clock then counts the time of the processor.
const NIFTYSIM: &str = "RELIEVO_NIFTYSIM";
/// Elements along a cube that is stretched beside NiftySim, and steps: 40 million steps of elements each.
const STRETCHES: [(u32, u64); 2] = [(20, 5000), (40, 625)];
/// Side of that cube and how much longer it becomes, in metres.
const SIDE: f32 = 0.1;
const STRETCH: f32 = 0.01;
/// Shear and bulk modulus of its gel in Pa, kilograms a cubic metre, and damping in 1/s.
const GEL: [f32; 4] = [1006.71, 5e4, 1000.0, 60.0];
/// The force in N that holds the cube, at rest, by the neo-Hookean law.
const FORCE: f64 = 2.7336027;
/// Points of the curve that stretches it.
const KEYS: u32 = 512;

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
    for (side, steps) in STRETCHES {
        stretch(&core, report, side, steps)?;
    }
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

/// Stretches a cube of gel on one core by as many steps as NiftySim does, and compares the rates and the forces.
fn stretch(context: &Context, report: &mut Report, side: u32, steps: u64) -> Result<()> {
    let elements = u64::from(side).pow(3);
    let case = format!("steps on one core, cube of {elements} elements stretched");
    let Some(program) = std::env::var_os(NIFTYSIM) else {
        report.skip(&case, "RELIEVO_NIFTYSIM does not name a program; docs/tissue.md says how to build NiftySim");
        return Ok(());
    };
    let step = 6e-3 / side as f32;
    let [shear, bulk, density, damping] = GEL;
    let gel = Material { name: "gel".into(), density, shear, bulk };
    let mut model = Model::block([0.0; 3], [SIDE / side as f32; 3], [side; 3], gel)?;
    for axis in 0..3 {
        let mut high = [1.0; 3];
        high[axis] = 1e-4;
        let held = model.nodes_within([-1e-4; 3], high).into_iter().map(|node| Held { node, axes: 1 << axis });
        model.held.extend(held);
    }
    let top = model.nodes_within([-1.0, -1.0, SIDE - 1e-4], [1.0; 3]);
    let folder = tempfile::tempdir().map_err(|error| Error::io(Path::new("cube.xml"), &error))?;
    let file = folder.path().join("cube.xml");
    let text = niftysim_model(side, step, steps);
    std::fs::write(&file, text).map_err(|error| Error::io(&file, &error))?;

    let duration = f64::from(step) * steps as f64;
    let key = |at: u32| {
        let share = f64::from(at) / f64::from(KEYS);
        // The load shape POLY345 of NiftySim.
        let smooth = share.powi(3) * (10.0 - share * (15.0 - 6.0 * share));
        (share * duration, [0.0, 0.0, STRETCH * smooth as f32])
    };
    let curve = Curve::new((0..=KEYS).map(key).collect())?;
    let options = SimulationOptions { gravity: [0.0; 3], damping, step: Some(step), ..SimulationOptions::default() };
    let ours = || -> Result<(f64, f64)> {
        let mut simulation = Simulation::new(model.clone(), &options)?;
        simulation.drive(Drive { nodes: top.clone(), axes: 4, displacement: curve.clone() })?;
        let begin = core_seconds();
        simulation.advance(context, steps, &mut Silent)?;
        let passed = core_seconds() - begin;
        Ok((passed, simulation.reaction(context, &top)?[2]))
    };
    let (mut rates, mut forces) = ([vec![], vec![]], [0.0; 2]);
    for run in 0..3 {
        for who in [run % 2, 1 - run % 2] {
            let (seconds, force) = if who == 0 { ours()? } else { niftysim(Path::new(&program), &file)? };
            rates[who].push(1e-6 * (steps * elements) as f64 / seconds);
            forces[who] = force;
        }
    }
    let [fast, peer] = rates.map(Sample::new);
    report.add(&case, &fast, Some(("NiftySim", &peer)), "M/s", Goal::RatioAtLeast(2.7));
    let [ours, theirs] = forces.map(|force| Sample::new(vec![force]));
    let case = format!("its force after {steps} steps, {FORCE:.4} at rest");
    // The shorter run does not come to rest.
    let goal = if steps == STRETCHES[0].1 { Goal::RatioAtMost(1.001) } else { Goal::None };
    report.add(&case, &ours, Some(("NiftySim", &theirs)), "N", goal);
    Ok(())
}

/// Runs NiftySim on a model. Returns the seconds that the processor worked on steps, and the force of the driven nodes in N.
fn niftysim(program: &Path, model: &Path) -> Result<(f64, f64)> {
    let mut command = Command::new(program);
    command.arg("-x").arg(model).args(["-t", "-print", "LNFS"]);
    let output = command.output().map_err(|error| Error::io(program, &error))?;
    let said = String::from_utf8_lossy(&output.stdout);
    let time = said.lines().find_map(|line| line.strip_prefix("Execution time:")?.split_whitespace().next());
    let force = said.lines().find_map(|line| line.trim().strip_prefix("Sums")?.split_whitespace().nth(2));
    let number = |text: Option<&str>| text?.parse::<f64>().ok().filter(|value| value.is_finite());
    number(time).zip(number(force)).map(|(time, force)| (1e-3 * time, force)).ok_or_else(|| {
        Error::internal("NiftySim did not say its time and forces")
            .at(program.display().to_string())
            .advise("build the program as docs/tissue.md says")
    })
}

/// Returns a cube that is stretched along z while its sides at 0 keep to their planes, as a model of NiftySim.
fn niftysim_model(side: u32, step: f32, steps: u64) -> String {
    let [shear, bulk, density, damping] = GEL;
    let row = side + 1;
    let node = |[x, y, z]: [u32; 3]| (z * row + y) * row + x;
    let cells = |count: u32| (0..count.pow(3)).map(move |at| [at % count, at / count % count, at / count.pow(2)]);
    let mut text = format!("<?xml version=\"1.0\"?>\n<Model>\n<Nodes DOF=\"3\" NumNodes=\"{}\">\n", row.pow(3));
    // Writing to a string does not fail.
    for place in cells(row) {
        let [x, y, z] = place.map(|at| SIDE * at as f32 / side as f32);
        let _ = writeln!(text, "{x} {y} {z}");
    }
    let _ = writeln!(text, "</Nodes>\n<Elements NumEls=\"{}\" Type=\"H8\">", side.pow(3));
    for [x, y, z] in cells(side) {
        let ring = [[0, 0], [1, 0], [1, 1], [0, 1]];
        let corners = (0..8).map(|at| node([x + ring[at % 4][0], y + ring[at % 4][1], z + at as u32 / 4]));
        text.extend(corners.map(|corner| format!("{corner} ")));
        text.push('\n');
    }
    let _ = writeln!(
        text,
        "</Elements>\n<ElementSet Size=\"all\"><Material Type=\"NH\"><ElasticParams NumParams=\"2\">{shear} {bulk}\
         </ElasticParams></Material>0</ElementSet>"
    );
    for (axis, at, kind) in [(0, 0, "Fix"), (1, 0, "Fix"), (2, 0, "Fix"), (2, side, "Disp")] {
        let nodes = cells(row).filter(|place| place[axis] == at).map(|place| format!("{} ", node(place)));
        let size = row.pow(2);
        let _ = write!(
            text,
            "<Constraint DOF=\"{axis}\" NumNodes=\"{size}\" Type=\"{kind}\" LoadShape=\"POLY345\"><Nodes>{}</Nodes>",
            nodes.collect::<String>()
        );
        let magnitude = format!("<Magnitudes Type=\"UNIFORM\">{STRETCH}</Magnitudes>");
        let _ = writeln!(text, "{}</Constraint>", if kind == "Disp" { &magnitude } else { "" });
    }
    let _ = writeln!(
        text,
        "<SystemParams><TimeStep>{step}</TimeStep><TotalTime>{}</TotalTime><DampingCoeff>{damping}</DampingCoeff>\
         <HGKappa>0.075</HGKappa><Density>{density}</Density><ROM>0</ROM></SystemParams>\n</Model>",
        f64::from(step) * steps as f64
    );
    text
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
    let (points, triangles) = relievo_testing::ball(radius, rings);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_of_niftysim_turns_its_corners_as_that_does() {
        let text = niftysim_model(1, 0.5, 4);
        assert!(text.contains("NumEls=\"1\" Type=\"H8\">\n0 1 3 2 4 5 7 6 \n"), "{text}");
        assert!(text.contains("\n0.1 0 0\n0 0.1 0\n"), "{text}");
        assert!(text.contains("Type=\"Disp\" LoadShape=\"POLY345\"><Nodes>4 5 6 7 </Nodes>"), "{text}");
        assert!(text.contains("<TotalTime>2<"), "{text}");
    }
}
