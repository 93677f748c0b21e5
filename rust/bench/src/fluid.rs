//! Bench `fluid`: dams of particles beside SPlisHSPlasH's, the form of Table 1 of Morgenroth, Weiskopf and Eberhardt (2013),
//! and meshes of particles beside splashsurf's. Time is that of all cores together where it says core-seconds, so that other
//! work of the machine counts less.

mod device;
pub(crate) mod render;

use std::path::Path;
use std::process::Command;

use glam::{Vec3, Vec4Swizzles};
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Error, Result};
use relievo_fluid::{
    Excess, Fluid, FluidOptions, PressureSolver, Surface, SurfaceFunction, TimeStep, basin, block, mesh,
};
use serde_json::{Value, json};

use crate::measure::{Sample, core_seconds, memory, seconds};
use crate::report::{Goal, Report};

/// Particles lie so far from each other, in metres, and kernels reach the paper's 4 cm.
const SPACING: f32 = 0.02;
/// The longest step in seconds where rates are compared: that by which the peer takes least time.
const STEP: f32 = 0.001;
/// Particles along each axis of a dam, and seconds that are simulated beside the peer.
const DAMS: [(u32, f32); 2] = [(27, 0.4), (50, 0.1)];
/// Particles along each axis of the paper's dams, frames of 0.01 s that are simulated of its 100, and its seconds.
const TABLE: [(u32, u32, [f64; 3]); 3] =
    [(27, 100, [87.0, 48.0, 19.0]), (50, 100, [809.0, 306.0, 136.0]), (108, 5, [10_448.0, 4168.0, 1774.0])];
const PAPER: [&str; 3] = ["Morgenroth 2013, i7", "its GTX 570M", "its GTX 680"];
/// The peer's names of pressure solvers, ours, and particle-steps a second and core that are to be reached, in thousands.
const METHODS: [(&str, PressureSolver, f64); 2] =
    [("PCISPH", PressureSolver::Pcisph, 340.0), ("DFSPH", PressureSolver::Dfsph, 400.0)];
/// Runs of meshing.
const RUNS: usize = 3;

/// What a simulation told.
#[derive(Default)]
struct Told {
    particles: usize,
    steps: u32,
    corrections: u32,
    /// Excess of density: the largest of all steps, and the mean of their means.
    most: f64,
    mean: f64,
    /// Simulated, and of all cores.
    seconds: f64,
    core_seconds: f64,
}

/// Measures all cases into `report`, beside the program `fluid` in a folder of peers.
pub fn run(report: &mut Report, peers: Option<&Path>) -> Result<()> {
    let program = peers.map(|folder| folder.join("fluid"));
    let context = Context::new(&ContextOptions::default())?;
    dams(report, peers)?;
    for (side, frames, paper) in TABLE {
        crate::fluid::device::case(report, &dam(&context, options(PressureSolver::Pcisph, None), side)?)?;
        let fluid = table(report, &context, side, frames, paper)?;
        if side > DAMS[0].0 {
            meshing(report, program.as_deref(), &fluid)?;
        }
    }
    Ok(())
}

/// Measures dams by both solvers into `report`, beside the program `fluid` in a folder of peers.
pub fn dams(report: &mut Report, peers: Option<&Path>) -> Result<()> {
    let program = peers.map(|folder| folder.join("fluid"));
    let context = Context::new(&ContextOptions::default())?;
    for (side, seconds) in DAMS {
        let mut costs = Vec::new();
        for method in METHODS {
            costs.push(beside(report, &context, program.as_deref(), method, side, seconds)?);
        }
        let [first, second] = [0, 1].map(|method| Sample::new(vec![costs[method]]));
        let name = format!("{} particles: time of a second by DFSPH", side.pow(3));
        report.add(&name, &second, Some(("by PCISPH", &first)), "core-seconds", Goal::RatioAtMost(1.0));
    }
    Ok(())
}

/// Returns the options of a dam with steps of at most `longest` seconds.
fn options(solver: PressureSolver, longest: Option<f32>) -> FluidOptions {
    let usual = FluidOptions::default();
    let time_step = longest.map_or(usual.time_step, |most| TimeStep::Courant { number: 0.4, most });
    FluidOptions { spacing: SPACING, gravity: Vec3::new(0.0, -9.81, 0.0), solver, time_step, ..usual }
}

/// Makes a cube of particles in a corner of a basin of three by one by two of its sides, y upwards.
fn dam(context: &Context, options: FluidOptions, side: u32) -> Result<Fluid> {
    let mut fluid = Fluid::new(options)?;
    let width = SPACING * side as f32;
    fluid.add(&block(Vec3::ZERO, Vec3::splat(width), SPACING)?, Vec3::ZERO)?;
    fluid.set_walls(context, &basin(Vec3::ZERO, width * Vec3::new(3.0, 2.0, 1.0), SPACING)?)?;
    Ok(fluid)
}

/// Simulates so many seconds, and tells what it took.
fn simulate(context: &Context, fluid: &mut Fluid, duration: f32) -> Result<Told> {
    let mut told = Told { particles: fluid.len(), seconds: f64::from(duration), ..Told::default() };
    let before = core_seconds();
    fluid.advance(context, duration, |_, done| {
        told.steps += 1;
        told.corrections += done.corrections + done.divergence_corrections;
        told.most = told.most.max(f64::from(done.excess.most));
        told.mean += f64::from(done.excess.mean);
        Ok(())
    })?;
    told.core_seconds = core_seconds() - before;
    told.mean /= f64::from(told.steps);
    Ok(told)
}

/// Returns bounds by which our steps end no denser than the peer's did.
fn strict(peer: &Told) -> Excess {
    let usual = FluidOptions::default().excess;
    Excess { most: usual.most.min(peer.most as f32), mean: usual.mean.min(peer.mean as f32) }
}

/// One dam beside the peer's: rates by the same longest step, and what a second of it takes by steps of our own, which is
/// returned.
fn beside(
    report: &mut Report,
    context: &Context,
    program: Option<&Path>,
    (method, solver, goal): (&str, PressureSolver, f64),
    side: u32,
    duration: f32,
) -> Result<f64> {
    let equal = simulate(context, &mut dam(context, options(solver, Some(STEP)), side)?, duration)?;
    let own = simulate(context, &mut dam(context, options(solver, None), side)?, duration)?;
    let name = format!("{method}, {} particles", equal.particles);
    let arguments = [method, &SPACING.to_string(), &side.to_string(), &duration.to_string()];
    let peer = told(report, &name, program, "simulate", &arguments).map(|peer| {
        let number = |key: &str| peer[key].as_f64().unwrap_or(f64::NAN);
        let count = |key: &str| peer[key].as_u64().unwrap_or(0) as u32;
        Told {
            particles: count("particles") as usize,
            steps: count("steps"),
            corrections: count("iterations"),
            most: number("most"),
            mean: number("mean"),
            seconds: number("seconds"),
            core_seconds: number("core_seconds"),
        }
    });
    type Figure = fn(&Told) -> f64;
    let rate: Figure = |told| told.particles as f64 * f64::from(told.steps) / told.core_seconds / 1e3;
    let cost: Figure = |told| told.core_seconds / told.seconds;
    let rows: [(&str, &Told, Figure, &str, Goal); 6] = [
        ("rate at steps of 1 ms at most", &equal, rate, "k particle-steps/s a core", Goal::AtLeast(goal)),
        ("time of a second", &own, cost, "core-seconds", Goal::RatioAtMost(0.5)),
        ("corrections a step", &own, |told| f64::from(told.corrections) / f64::from(told.steps), "", Goal::None),
        ("steps a second", &own, |told| f64::from(told.steps) / told.seconds, "", Goal::None),
        ("mean excess of density", &own, |told| 100.0 * told.mean, "%", Goal::AtMost(0.1)),
        ("largest excess of density", &own, |told| 100.0 * told.most, "%", Goal::AtMost(1.0)),
    ];
    for (what, ours, figure, unit, goal) in rows {
        let theirs = peer.as_ref().map(|peer| Sample::new(vec![figure(peer)]));
        let theirs = theirs.as_ref().map(|sample| ("SPlisHSPlasH", sample));
        report.add(&format!("{name}: {what}"), &Sample::new(vec![figure(ours)]), theirs, unit, goal);
    }
    if let Some(peer) = peer.filter(|peer| peer.mean < own.mean) {
        let bounded = FluidOptions { excess: strict(&peer), ..options(solver, Some(STEP)) };
        let strict = simulate(context, &mut dam(context, bounded, side)?, duration)?;
        let rows: [(&str, Figure, &str, Goal); 3] = [
            ("rate at the peer's mean excess", rate, "k particle-steps/s a core", Goal::RatioAtLeast(2.0)),
            ("mean excess there", |told| 100.0 * told.mean, "%", Goal::RatioAtMost(1.0)),
            ("largest excess there", |told| 100.0 * told.most, "%", Goal::RatioAtMost(1.0)),
        ];
        for (what, figure, unit, goal) in rows {
            let theirs = Sample::new(vec![figure(&peer)]);
            let ours = Sample::new(vec![figure(&strict)]);
            report.add(&format!("{name}: {what}"), &ours, Some(("SPlisHSPlasH", &theirs)), unit, goal);
        }
    }
    Ok(cost(&own))
}

/// The paper's table, by DFSPH: seconds for 100 frames of 0.01 s. Where fewer are simulated its seconds are the same share of its own.
fn table(report: &mut Report, context: &Context, side: u32, frames: u32, paper: [f64; 3]) -> Result<Fluid> {
    let mut fluid = dam(context, options(PressureSolver::Dfsph, None), side)?;
    let mut told = Ok(Told::default());
    let time = seconds(|| told = simulate(context, &mut fluid, 0.01 * frames as f32));
    let told = told?;
    let name = format!("Table 1, {} particles, {frames} frames", told.particles);
    for (column, theirs) in PAPER.into_iter().zip(paper) {
        let theirs = Sample::new(vec![theirs * f64::from(frames) / 100.0]);
        report.add(&name, &Sample::new(vec![time]), Some((column, &theirs)), "s", Goal::None);
    }
    let cost = Sample::new(vec![told.core_seconds / told.seconds]);
    report.add(&format!("{name}: time of a second"), &cost, None, "core-seconds", Goal::None);
    Ok(fluid)
}

/// Meshes of the particles of a fluid, ours and the peer's each in a process of its own.
fn meshing(report: &mut Report, program: Option<&Path>, fluid: &Fluid) -> Result<()> {
    let file = tempfile::NamedTempFile::new().map_err(|error| Error::io(&std::env::temp_dir(), &error))?;
    let places = fluid.places().iter().flat_map(|place| place.xyz().to_array());
    let bytes: Vec<u8> = places.flat_map(f32::to_le_bytes).collect();
    std::fs::write(file.path(), bytes).map_err(|error| Error::io(file.path(), &error))?;
    let path = file.path().display().to_string();
    let ours = std::env::current_exe().map_err(|error| Error::io(Path::new("relievo-bench"), &error))?;
    let name = format!("mesh of {} particles, cells of a radius", fluid.len());
    let radius = (0.5 * SPACING).to_string();
    let (mut mine, mut theirs, mut peaks) = (Vec::new(), Vec::new(), Vec::new());
    let millions = fluid.len() as f64 / 1e6;
    let rate = |told: &Value| told["seconds"].as_f64().map(|seconds| millions / seconds);
    for _ in 0..RUNS {
        let told_of_us = told(report, &name, Some(&ours), "meshing", &["--particles", &path]);
        mine.extend(told_of_us.as_ref().and_then(rate));
        peaks.extend(told_of_us.and_then(|told| told["peak"].as_f64()).map(|peak| peak / fluid.len() as f64));
        theirs.extend(told(report, &name, program, "mesh", &[&path, &radius, "1.0"]).as_ref().and_then(rate));
    }
    if mine.is_empty() {
        return Err(Error::internal("its process did not tell how long it took").at(name));
    }
    let theirs = (!theirs.is_empty()).then(|| Sample::new(theirs));
    let theirs = theirs.as_ref().map(|sample| ("splashsurf", sample));
    report.add(&name, &Sample::new(mine.clone()), theirs, "M particles/s", Goal::AtLeast(1.0));
    if theirs.is_some() {
        report.add(&format!("{name}, beside it"), &Sample::new(mine), theirs, "M particles/s", Goal::RatioAtLeast(1.0));
    }
    match peaks.is_empty() {
        false => {
            let unit = "bytes a particle";
            report.add(&format!("{name}: peak"), &Sample::new(peaks), None, unit, Goal::AtMost(200.0));
        }
        true => report.skip(&format!("{name}: peak"), "the system does not tell it"),
    }
    Ok(())
}

/// Meshes the particles of a file and prints how long it takes, and how many bytes it has at its peak beside the particles
/// and the mesh.
pub fn mesh_file(path: &Path) -> Result<()> {
    let context = Context::new(&ContextOptions::default())?;
    let bytes = std::fs::read(path).map_err(|error| Error::io(path, &error))?;
    let numbers: Vec<f32> = bytes.as_chunks().0.iter().map(|number| f32::from_le_bytes(*number)).collect();
    let places = numbers.as_chunks().0;
    let radius = 0.5 * SPACING;
    let before = memory("VmRSS");
    let mut made = None;
    let time = seconds(|| {
        let surface = Surface::new(&context, places, SurfaceFunction::density(radius));
        made = Some(surface.and_then(|surface| mesh(&context, &surface, radius, &[], &mut Silent)));
    });
    let made = made.ok_or_else(|| Error::internal("nothing was made"))??;
    // Points and normals of vertices, corners and sizes of triangles.
    let size = 24 * made.points.len() + 16 * made.face_count();
    let peak = memory("VmHWM").zip(before).map(|(peak, before)| peak - before - size as f64);
    println!("{}", json!({ "seconds": time, "vertices": made.points.len(), "peak": peak }));
    Ok(())
}

/// What a program tells as JSON on its last line; says so where there is none.
fn told(report: &Report, case: &str, program: Option<&Path>, what: &str, arguments: &[&str]) -> Option<Value> {
    let Some(program) = program else {
        report.skip(case, "there is no program of the peer; `cargo xtask bench fluid` makes it");
        return None;
    };
    let output = match Command::new(program).arg(what).args(arguments).output() {
        Ok(output) => output,
        Err(error) => {
            report.skip(case, &format!("{}: {error}", program.display()));
            return None;
        }
    };
    let said = String::from_utf8_lossy(&output.stdout);
    let told = said.lines().last().and_then(|line| serde_json::from_str(line).ok());
    if told.is_none() {
        let error = String::from_utf8_lossy(&output.stderr);
        report.skip(case, &format!("it ended with {}: {}", output.status, error.lines().last().unwrap_or_default()));
    }
    told
}
