//! What a dab of a brush costs on a graphics device, for the bench `gpu`: Table 1 of Schäfer et al. 2015, Local Painting
//! and Deformation of Meshes on the GPU, with the paper's numbers beside ours. Its models are not public, so ours are
//! terrains of as many faces, of which a dab touches 64; edits are tiles of 8 × 8.

use glam::{DAffine3, DMat3, DVec3};
use relievo_core::{Context, Error, Result};
use relievo_detail::{Action, Brush, Dab, DisplacedObject, Falloff, SculptMode};
use relievo_gpu::{AdapterKind, Device, PassTime};
use relievo_surface::{Surface, SurfaceOptions};
use relievo_tiles::{Displacement, DisplacementOptions};

use crate::measure::Sample;
use crate::report::{Goal, Report, figure, table};
use crate::shapes;

/// Whose figures stand beside ours.
const PAPER: &str = "Schäfer 2015, GTX Titan";
/// Faces along a side of the terrains, the paper's model that has as many elements, and its milliseconds of
/// intersecting, scanning and managing. The last three are triangle meshes there, whose edges count too.
const SIDES: [(u32, &str, [f64; 3]); 7] = [
    (190, "Dragon*", [0.25, 0.025, 0.006]),
    (276, "Dragon SubD 1*", [0.78, 0.028, 0.006]),
    (456, "Dragon SubD 2*", [2.31, 0.049, 0.006]),
    (205, "Frog*", [0.27, 0.028, 0.006]),
    (255, "Kitten", [0.017, 0.038, 0.006]),
    (546, "Horse", [0.058, 0.122, 0.006]),
    (712, "Armadillo", [0.068, 0.203, 0.006]),
];
/// The paper's milliseconds of processing edits.
const EDITS: f64 = 0.05;
/// The passes of the paper's columns, and the edit's.
const PASSES: [&str; 4] = ["dab.intersect", "dab.scan", "dab.manage", "dab.edit"];
/// Runs of a device, and of one that is the processor.
const RUNS: [usize; 2] = [200, 9];

/// Measures every row into `report`.
pub fn run(device: &Device, report: &mut Report, json: bool) -> Result<()> {
    if !device.is_timed() {
        report.skip("dabs on a device", "the device has no timestamps");
        return Ok(());
    }
    let context = Context::new(&relievo_core::ContextOptions::default())?;
    let runs = RUNS[usize::from(device.summary().kind == AdapterKind::Software)];
    let brush = Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::new(3.9, 3.9, 2.0), Falloff::Smooth)?;
    let action = Action::Sculpt { mode: SculptMode::Draw, height: 0.1 };
    let dab = Dab { brush, action, strength: 0.5 };
    let head = ["mesh", "elements", "intersect", "scan", "manage", "sum", "paper", "edits", "paper"];
    let mut rows = vec![head.map(String::from).to_vec()];
    for (side, model, paper) in SIDES {
        let cage = shapes::terrain(side);
        let surface = Surface::new(&context, &cage, &SurfaceOptions::default())?;
        let options = DisplacementOptions { size: 8, ..DisplacementOptions::default() };
        let displacement = Displacement::new(surface.topology().clone(), &options)?;
        let mut object = DisplacedObject::new(&context, surface, &cage.points, displacement, DAffine3::IDENTITY)?;
        object.use_device(Some(device))?;
        let mut all: [Vec<f64>; 4] = Default::default();
        for run in 0..=runs {
            let times = object.time_dab(&dab)?;
            for (pass, all) in PASSES.iter().zip(&mut all).filter(|_| run > 0) {
                all.push(milliseconds(&times, pass)?);
            }
        }
        let sums = (0..runs).map(|run| all[..3].iter().map(|times| times[run]).sum()).collect();
        let [intersect, scan, manage, edit] = all.map(Sample::new);
        let sum = Sample::new(sums);
        let elements = side * side;
        let shown = |sample: &Sample| figure(sample.median());
        let theirs = paper.map(|time| time.to_string()).join(" + ");
        rows.push(vec![
            model.into(),
            format!("{} k", elements / 1000),
            shown(&intersect),
            shown(&scan),
            shown(&manage),
            shown(&sum),
            theirs,
            shown(&edit),
            EDITS.to_string(),
        ]);
        let of = |value: f64| Sample::new(vec![value]);
        let case = format!("dab of {elements} faces ({model})");
        let peer = of(paper.iter().sum());
        report.add(&format!("{case}: intersect, scan, manage"), &sum, Some((PAPER, &peer)), "ms", Goal::AtMost(0.1));
        report.add(&format!("{case}: edits"), &edit, Some((PAPER, &of(EDITS))), "ms", Goal::AtMost(EDITS));
    }
    if !json {
        println!("Dabs, {}, median of {runs}; milliseconds", device.summary());
        print!("{}", table(&rows));
        println!();
    }
    Ok(())
}

fn milliseconds(times: &[PassTime], pass: &str) -> Result<f64> {
    let found = times.iter().find(|time| time.name == pass);
    let found = found.ok_or_else(|| Error::internal(format!("no time of the pass `{pass}`")))?;
    Ok(1e3 * found.length.as_secs_f64())
}
