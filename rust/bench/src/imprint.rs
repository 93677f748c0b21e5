//! Bench `imprint`: what the imprint of a collider costs, in all and stage by stage (Schäfer et al. 2014, Section 7).

pub(crate) mod contact;
mod table1;

use relievo_core::{Context, ContextOptions, Result};
use relievo_surface::Place;

use crate::imprint::contact::{Contact, Press};
use crate::measure::{Sample, sample, seconds};
use crate::report::{Goal, Report};
use crate::{shapes, voxels};

/// Faces along a side of the terrain: 8,836 in all, as many as the paper's has.
pub const SIDE: u32 = 94;
/// Radius of the ball on the terrain, whose faces have edges of 1: it touches up to 24 of them.
pub const RADIUS: f64 = 4.9;
/// Texels along an edge of a tile.
const SIZE: u32 = 128;
/// Runs of what is set up for every run.
const RUNS: usize = 9;

/// Measures every case into `report`.
pub fn run(report: &mut Report) -> Result<()> {
    let context = Context::new(&ContextOptions::default())?;
    terrain(&context, report)?;
    match frog(&context)? {
        Some(mut contact) => {
            let mut object = contact.object(&context, SIZE)?;
            let mut presses = Vec::new();
            for tile in frog_tiles(&contact) {
                presses.push(contact.press(&context, &mut object, Place::new(tile, 0.5, 0.5), false)?);
            }
            report.add("frog: first contact", &milliseconds(&presses), None, "ms", Goal::AtMost(6.0));
            counts(report, "frog", &presses);
        }
        None => report.skip("frog", "cages/monsterfrog.obj is not there"),
    }
    table1::run(&context, report)?;
    voxels::run(&context, report)
}

/// The paper's frog and a ball in proportion to its faces.
pub fn frog(context: &Context) -> Result<Option<Contact>> {
    let Some(cage) = shapes::model(context, "cages/monsterfrog.obj")? else { return Ok(None) };
    let edges = cage.faces().flat_map(|face| (0..face.len()).map(|i| [face[i], face[(i + 1) % face.len()]]));
    let lengths = edges.map(|edge| {
        let [a, b] = edge.map(|point| glam::Vec3::from(cage.points[point as usize]));
        f64::from(a.distance(b))
    });
    let mean = lengths.sum::<f64>() / cage.corners.len() as f64;
    Contact::new(context, cage, 2.4 * mean).map(Some)
}

/// Places all over the frog.
pub fn frog_tiles(contact: &Contact) -> impl Iterator<Item = u32> + use<> {
    (20..contact.surface().tile_count() as u32).step_by(85)
}

/// Places on a terrain, far enough apart for a ball to find each untouched.
pub fn terrain_tiles(side: u32) -> impl Iterator<Item = u32> {
    let rows = (10..SIDE - 9).step_by(12);
    rows.clone().flat_map(move |j| rows.clone().map(move |i| j * side + i))
}

fn terrain(context: &Context, report: &mut Report) -> Result<()> {
    let mut near = Contact::new(context, shapes::terrain(SIDE), RADIUS)?;
    let mut far = Contact::new(context, shapes::terrain(4 * SIDE), RADIUS)?;
    let (mut small, mut large) = (near.object(context, SIZE)?, far.object(context, SIZE)?);
    let (mut first, mut again, mut far_first, mut far_again) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (run, (a, b)) in terrain_tiles(SIDE).zip(terrain_tiles(4 * SIDE)).enumerate() {
        let (a, b) = (Place::new(a, 0.5, 0.5), Place::new(b, 0.5, 0.5));
        let mut press_near = |again| near.press(context, &mut small, a, again);
        let mut press_far = |again| far.press(context, &mut large, b, again);
        // Who goes first changes; the first place warms up.
        let presses = if run % 2 == 0 {
            let near = [press_near(false)?, press_near(true)?];
            (near, [press_far(false)?, press_far(true)?])
        } else {
            let far = [press_far(false)?, press_far(true)?];
            ([press_near(false)?, press_near(true)?], far)
        };
        if run > 0 {
            let ([a, b], [c, d]) = presses;
            first.push(a);
            again.push(b);
            far_first.push(c);
            far_again.push(d);
        }
    }
    let faces = |contact: &Contact| format!("{} faces", contact.cage().face_count());
    let [first_time, again_time] = [&first, &again].map(|presses| milliseconds(presses));
    report.add("terrain: first contact", &first_time, None, "ms", Goal::AtMost(3.0));
    report.add("terrain: touched before", &again_time, None, "ms", Goal::AtMost(1.5));
    for (case, far_presses, time) in
        [("first contact", far_first, &first_time), ("touched before", far_again, &again_time)]
    {
        let peer = Some((faces(&near), time));
        let peer = peer.as_ref().map(|(name, time)| (name.as_str(), *time));
        let case = format!("{}: {case}", faces(&far));
        report.add(&case, &milliseconds(&far_presses), peer, "ms", Goal::RatioAtMost(1.3));
    }
    counts(report, "terrain", &first);
    hierarchies(context, report, "terrain", &near)
}

/// Seconds of whole imprints, in milliseconds.
pub fn milliseconds(presses: &[Press]) -> Sample {
    Sample::new(presses.iter().map(|press| 1e3 * press.sum).collect())
}

/// What the imprints touched.
fn counts(report: &mut Report, scene: &str, presses: &[Press]) {
    let mut add = |what: &str, unit: &str, count: fn(&Press) -> u64| {
        let sample = Sample::new(presses.iter().map(|press| count(press) as f64).collect());
        report.add(&format!("{scene}: {what}"), &sample, None, unit, Goal::None);
    };
    add("tiles touched", "tiles", |press| press.report.changed.len() as u64);
    add("triangles voxelised", "triangles", |press| press.report.triangles);
    add("rays", "rays", |press| press.report.tested_coefficients);
}

/// Building the hierarchy of a surface and refitting it to an animated cage, which imprints do not pay for.
fn hierarchies(context: &Context, report: &mut Report, scene: &str, contact: &Contact) -> Result<()> {
    let mut object = contact.object(context, SIZE)?;
    let stage = |name: &str| context.stats().take().iter().filter(|event| event.stage == name).map(|e| e.length).sum();
    let in_stage = |name: &str| 1e3 * std::time::Duration::as_secs_f64(&stage(name));
    let build = sample(RUNS, || {
        context.stats().take();
        seconds(|| contact.object(context, SIZE));
        in_stage("object.hierarchy")
    });
    report.add(&format!("{scene}: hierarchy, built"), &build, None, "ms", Goal::None);
    object.pose(context, &contact.cage().points)?;
    let refit = sample(RUNS, || {
        context.stats().take();
        seconds(|| object.pose(context, &contact.cage().points));
        in_stage("object.refit")
    });
    report.add(&format!("{scene}: hierarchy, refitted"), &refit, None, "ms", Goal::None);
    Ok(())
}
