//! Table 1 of Schäfer et al. 2014 in full, with the paper's figures for a GTX 780 beside ours. Every imprint is a first
//! contact: ours includes the allocation of tiles, which the paper's does not name.

use relievo_core::{Context, Result};
use relievo_surface::Place;

use crate::imprint::contact::{Contact, Press};
use crate::imprint::{RADIUS, SIDE, frog, frog_tiles, terrain_tiles};
use crate::measure::Sample;
use crate::report::{Goal, Report};
use crate::shapes;

/// Whose figures stand beside ours.
const PAPER: &str = "Schäfer 2014, GTX 780";

/// The rows of stages: the paper's name and our stages.
const STAGES: [(&str, &[&str]); 5] = [
    ("culling", &["imprint.obb", "imprint.cull"]),
    ("compaction", &["imprint.compact"]),
    ("voxelisation", &["imprint.voxelise"]),
    ("ray casting", &["imprint.raycast"]),
    ("overlap update", &["imprint.ring"]),
];

/// A column: its name, tile size, whether it culls and compacts, runs, and the paper's stages and sum in milliseconds.
struct Column {
    name: &'static str,
    size: u32,
    culling: u32,
    compaction: u32,
    runs: usize,
    paper: [Option<f64>; 6],
}

const fn column(name: &'static str, size: u32, culling: u32, compaction: u32, paper: [Option<f64>; 6]) -> Column {
    Column { name, size, culling, compaction, runs: if culling == 0 { 2 } else { 9 }, paper }
}

const TERRAIN: [Column; 4] = [
    column("32²", 32, 1, 1, [Some(0.164), Some(0.005), Some(0.006), Some(0.053), Some(0.025), Some(0.254)]),
    column("128²", 128, 1, 1, [Some(0.164), Some(0.005), Some(0.006), Some(0.073), Some(0.025), Some(0.273)]),
    column("128², no culling", 128, 0, 1, [None, None, Some(0.006), Some(10.11), Some(0.228), Some(10.31)]),
    column("128², no compaction", 128, 1, 0, [Some(0.164), None, Some(0.006), Some(0.073), Some(0.228), Some(0.471)]),
];

const FROG: [Column; 4] = [
    column("32²", 32, 1, 1, [Some(0.368), Some(0.004), Some(0.006), Some(0.083), Some(0.025), Some(0.486)]),
    column("128²", 128, 1, 1, [Some(0.368), Some(0.004), Some(0.006), Some(0.114), Some(0.028), Some(0.521)]),
    column("128², no culling", 128, 0, 1, [None, None, Some(0.006), Some(45.87), Some(0.178), Some(46.054)]),
    column("128², no compaction", 128, 1, 0, [Some(0.368), None, Some(0.006), Some(0.114), Some(0.178), Some(0.666)]),
];

/// Measures both scenes.
pub fn run(context: &Context, report: &mut Report) -> Result<()> {
    let mut terrain = Contact::new(context, shapes::terrain(SIDE), RADIUS)?;
    let tiles: Vec<u32> = terrain_tiles(SIDE).collect();
    scene(context, report, "Table 1, terrain", &mut terrain, &tiles, &TERRAIN, [8769.0, 12679.0])?;
    if let Some(mut frog) = frog(context)? {
        let tiles: Vec<u32> = frog_tiles(&frog).collect();
        scene(context, report, "Table 1, frog", &mut frog, &tiles, &FROG, [1292.0, 41274.0])?;
    }
    Ok(())
}

fn scene(
    context: &Context,
    report: &mut Report,
    name: &str,
    contact: &mut Contact,
    tiles: &[u32],
    columns: &[Column],
    paper: [f64; 2],
) -> Result<()> {
    let ours = [contact.cage().face_count(), contact.surface().patch_count()];
    for (what, (ours, paper)) in ["base patches", "render patches"].iter().zip(ours.into_iter().zip(paper)) {
        let [ours, paper] = [ours as f64, paper].map(|count| Sample::new(vec![count]));
        report.add(&format!("{name}: {what}"), &ours, Some((PAPER, &paper)), "patches", Goal::None);
    }
    for column in columns {
        contact.settings_mut().culling = column.culling;
        contact.settings_mut().compaction = column.compaction;
        let mut presses = Vec::new();
        for tile in tiles.iter().take(column.runs + 1) {
            // Without culling, what an imprint costs depends on what was touched before.
            let mut object = contact.object(context, column.size)?;
            presses.push(contact.press(context, &mut object, Place::new(*tile, 0.5, 0.5), false)?);
        }
        // The first one warms up.
        presses.remove(0);
        for ((row, stages), paper) in STAGES.iter().zip(&column.paper) {
            let time = |press: &Press| stages.iter().filter_map(|stage| press.stages.get(stage)).sum::<f64>();
            add(report, &format!("{name}, {}: {row}", column.name), &presses, time, *paper);
        }
        add(report, &format!("{name}, {}: sum", column.name), &presses, |press| press.sum, column.paper[5]);
    }
    contact.settings_mut().culling = 1;
    contact.settings_mut().compaction = 1;
    Ok(())
}

fn add(report: &mut Report, case: &str, presses: &[Press], time: impl Fn(&Press) -> f64, paper: Option<f64>) {
    let ours = Sample::new(presses.iter().map(|press| 1e3 * time(press)).collect());
    let paper = paper.map(|figure| Sample::new(vec![figure]));
    report.add(case, &ours, paper.as_ref().map(|figure| (PAPER, figure)), "ms", Goal::None);
}
