//! Table 1 of Schäfer et al. 2014 on a graphics device, by the device's clock, with the paper's figures for a GTX 780
//! beside ours, and what submitting the imprints of a frame costs the processor.
//!
//! Boxes and the overlap update are the processor's and stand beside the sum. What an object without culling would need
//! does not go through a device.

use std::collections::BTreeMap;

use relievo_core::{Context, Result};
use relievo_detail::ImprintSettings;
use relievo_gpu::{AdapterKind, Device, DeviceOptions};
use relievo_surface::Place;

use crate::imprint::contact::Contact;
use crate::imprint::{RADIUS, SIDE, frog, frog_tiles, terrain_tiles};
use crate::measure::Sample;
use crate::report::{Goal, Report};
use crate::shapes;

/// Whose figures stand beside ours.
const PAPER: &str = "Schäfer 2014, GTX 780";

/// The rows of stages on the device: the paper's name and ours.
const STAGES: [(&str, &str); 3] = [
    ("culling and compaction", "imprint.device.cull"),
    ("voxelisation", "imprint.device.voxelise"),
    ("ray casting", "imprint.device.raycast"),
];

/// Stages of the processor.
const HERE: [(&str, &str); 2] =
    [("boxes, on the processor", "imprint.obb"), ("overlap update, on the processor", "imprint.ring")];

/// Texels along an edge of a tile, and the paper's stages and their sum, milliseconds.
type Column = (u32, [f64; 4]);

const TERRAIN: [Column; 2] = [(32, [0.169, 0.006, 0.053, 0.254]), (128, [0.169, 0.006, 0.073, 0.273])];
const FROG: [Column; 2] = [(32, [0.372, 0.006, 0.083, 0.486]), (128, [0.372, 0.006, 0.114, 0.521])];

/// Pairs of a frame.
const PAIRS: usize = 8;

/// Measures the pairs of the table on `device`, which times its passes.
pub fn run(context: &Context, report: &mut Report, device: &Device) -> Result<()> {
    let software = device.summary().kind == AdapterKind::Software;
    let runs = if software { 3 } else { 200 };
    let mut terrain = Contact::new(context, shapes::terrain(SIDE), RADIUS)?;
    let tiles: Vec<u32> = terrain_tiles(SIDE).collect();
    let near = scene(context, report, device, ("terrain", runs, 0.15), &mut terrain, &tiles, &TERRAIN)?;
    let mut large = Contact::new(context, shapes::terrain(4 * SIDE), RADIUS)?;
    let far_tiles: Vec<u32> = terrain_tiles(4 * SIDE).collect();
    let far = sums(context, device, runs, &mut large, &far_tiles, 128)?.remove("sum").unwrap_or_default();
    let case = format!("Table 1 on the device, 128²: sum at {} faces", large.cage().face_count());
    report.add(&case, &Sample::new(far), Some(("8836 faces", &near)), "ms", Goal::RatioAtMost(1.5));
    if let Some(mut frog) = frog(context)? {
        let tiles: Vec<u32> = frog_tiles(&frog).collect();
        scene(context, report, device, ("frog", runs, 0.25), &mut frog, &tiles, &FROG)?;
    }
    submission(context, report, device, runs.max(15), &mut terrain, &tiles)?;
    triangles(context, report, device, runs, &terrain, &tiles)
}

/// Measures first contacts on the same surface as a triangle mesh: what the device does of one, all stages together, and of
/// a frame's pairs, plain and with what rises and is smoothed.
fn triangles(
    context: &Context,
    report: &mut Report,
    device: &Device,
    runs: usize,
    contact: &Contact,
    tiles: &[u32],
) -> Result<()> {
    let places: Vec<Place> = tiles.iter().map(|tile| Place::new(*tile, 0.5, 0.5)).collect();
    let plain = *contact.settings();
    let shaped = ImprintSettings { rim: 0.5, rim_width: 0.4, smoothing: 0.5, ..plain };
    for (segments, name, settings, pairs) in [
        (16, "one pair", &plain, 1),
        (16, "8 pairs", &plain, PAIRS),
        (64, "8 pairs", &plain, PAIRS),
        (16, "8 pairs with rims, smoothed", &shaped, PAIRS),
    ] {
        let (mut on_device, mut all) = (Vec::new(), Vec::new());
        // The first one warms up.
        for run in 0..=runs {
            let mut mesh = contact.mesh(context, segments)?;
            mesh.use_device(Some(device))?;
            let first = run * pairs % places.len().saturating_sub(pairs).max(1);
            let made = contact.press_triangles(context, &mut mesh, &places[first..first + pairs], settings)?;
            if let Some(fault) = mesh.take_device_fault() {
                return Err(fault);
            }
            if run > 0 {
                on_device.extend(made.stages.get("imprint.device.triangles").map(|time| 1e3 * time));
                all.push(1e3 * made.sum);
            }
        }
        let faces = 2 * contact.cage().face_count();
        let case = format!("imprint on the device, {faces} triangles, {segments} segments, {name}");
        if !on_device.is_empty() {
            report.add(&format!("{case}: all stages"), &Sample::new(on_device), None, "ms", Goal::None);
        }
        report.add(&format!("{case}: with the way back"), &Sample::new(all), None, "ms", Goal::None);
    }
    Ok(())
}

/// Measures one scene in all tile sizes. Returns the sums of the last.
fn scene(
    context: &Context,
    report: &mut Report,
    device: &Device,
    (name, runs, goal): (&str, usize, f64),
    contact: &mut Contact,
    tiles: &[u32],
    columns: &[Column],
) -> Result<Sample> {
    let mut last = Sample::new(vec![0.0]);
    for (size, paper) in columns {
        let mut found = sums(context, device, runs, contact, tiles, *size)?;
        let mut add = |row: &str, stage: &str, paper: Option<f64>, goal: Goal| {
            let times = found.remove(stage)?;
            let paper = paper.map(|figure| Sample::new(vec![figure]));
            let ours = Sample::new(times);
            let case = format!("Table 1 on the device, {name}, {size}²: {row}");
            report.add(&case, &ours, paper.as_ref().map(|figure| (PAPER, figure)), "ms", goal);
            Some(ours)
        };
        for ((row, stage), paper) in STAGES.iter().zip(paper) {
            add(row, stage, Some(*paper), Goal::None);
        }
        let goal = if *size == 128 { Goal::AtMost(goal) } else { Goal::None };
        last = add("sum", "sum", Some(paper[3]), goal).unwrap_or(last);
        for (row, stage) in HERE {
            add(row, stage, None, Goal::None);
        }
        add("in all, with the way back", "all", None, Goal::None);
    }
    Ok(last)
}

/// Milliseconds of the stages of first contacts, of those on the device together, and of all.
fn sums(
    context: &Context,
    device: &Device,
    runs: usize,
    contact: &mut Contact,
    tiles: &[u32],
    size: u32,
) -> Result<BTreeMap<&'static str, Vec<f64>>> {
    let mut found: BTreeMap<&'static str, Vec<f64>> = BTreeMap::new();
    let mut object = contact.object(context, size)?;
    object.use_device(Some(device))?;
    // The first one warms up.
    for (run, tile) in tiles.iter().cycle().take(runs + 1).enumerate() {
        if run > 0 && run % tiles.len() == 0 {
            object = contact.object(context, size)?;
            object.use_device(Some(device))?;
        }
        let press = contact.press(context, &mut object, Place::new(*tile, 0.5, 0.5), false)?;
        if let Some(fault) = object.take_device_fault() {
            return Err(fault);
        }
        if run == 0 || run % tiles.len() == 0 {
            continue;
        }
        let on_device = STAGES.iter().filter_map(|(_, stage)| press.stages.get(stage)).sum::<f64>();
        let stages = press.stages.iter().map(|(stage, time)| (*stage, *time));
        for (stage, time) in stages.chain([("sum", on_device), ("all", press.sum)]) {
            found.entry(stage).or_default().push(1e3 * time);
        }
    }
    Ok(found)
}

/// What recording and submitting the imprints of a frame's pairs takes, on a device that times nothing.
fn submission(
    context: &Context,
    report: &mut Report,
    device: &Device,
    runs: usize,
    contact: &mut Contact,
    tiles: &[u32],
) -> Result<()> {
    let adapter = relievo_gpu::AdapterChoice::Named(device.summary().name.clone());
    let device = Device::open(&DeviceOptions { adapter, ..DeviceOptions::default() })?;
    let mut object = contact.object(context, 128)?;
    object.use_device(Some(&device))?;
    let places: Vec<Place> = tiles.iter().take(PAIRS).map(|tile| Place::new(*tile, 0.5, 0.5)).collect();
    let mut times = Vec::new();
    for run in 0..=runs {
        // Rings of the last run, on a device that is the processor itself, would take part of its time.
        device.frame()?.submit()?.wait()?;
        let press = contact.press_all(context, &mut object, &places)?;
        if let Some(fault) = object.take_device_fault() {
            return Err(fault);
        }
        if run > 0 {
            times.extend(press.stages.get("imprint.device.submit").map(|time| 1e3 * time));
        }
    }
    if !times.is_empty() {
        let case = format!("submission of {PAIRS} pairs, on the processor");
        report.add(&case, &Sample::new(times), None, "ms", Goal::AtMost(0.2));
    }
    Ok(())
}
