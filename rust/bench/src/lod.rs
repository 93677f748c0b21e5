//! Bench `lod`: simplification beside meshoptimizer's, which moves vertices too, and beside programs of other peers; meshes
//! of the same triangles at no height beside curved ones; progressive meshes. Rates of other peers are of a single run.

use std::path::Path;
use std::process::Command;

use glam::Vec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Result};
use relievo_lod::{Simplified, SimplifyOptions, simplify};

use crate::deviation::{Deviation, box_of};
use crate::measure::{Sample, compare, sample, seconds};
use crate::peers::Peer;
use crate::report::{Goal, Report};
use crate::{progressive, shapes, textured};

/// The share of triangles that is left.
const LEFT: f64 = 0.1;
/// The largest deviation that is asked for, as a share of the diagonal.
const BOUND: f32 = 0.001;
/// The peer whose simplification knows no meshes before either, and deviates least of all.
const BEST: &str = "CGAL Lindstrom-Turk";
/// Runs of each side.
pub const RUNS: usize = 5;

pub type Triangles = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// Measures every case into `report`, beside the programs in a folder.
pub fn run(report: &mut Report, peers: Option<&Path>) -> Result<()> {
    let peers = peers.map_or(Ok(Vec::new()), Peer::of_folder)?;
    let context = Context::new(&ContextOptions::default())?;
    let noisy_knot = noisy_knot(640, 256);
    let rate = case(report, &context, &peers, "noisy knot, 327,680 triangles", &noisy_knot)?;
    let flat = shapes::terrain(404);
    let points = flat.points.iter().map(|[x, y, _]| [*x, *y, 0.0]).collect();
    let flat = (points, flat.triangles());
    let time = sample(RUNS, || seconds(|| ours(&context, &flat)));
    let curved = Sample::new(vec![noisy_knot.1.len() as f64 / rate / 1e6]);
    let name = "flat grid, 326,432 triangles: time beside a curved mesh";
    report.add(name, &time, Some(("the noisy knot", &curved)), "s", Goal::RatioAtMost(1.5));
    for name in ["horse.ply", "igea.ply", "ogre.obj", "stanford-bunny.obj", "fandisk.obj"] {
        match shapes::model(&context, &format!("meshes/{name}"))? {
            Some(mesh) => {
                let triangles = mesh.triangles();
                let name = format!("{name}, {} triangles", triangles.len());
                case(report, &context, &peers, &name, &(mesh.points, triangles))?;
            }
            None => eprintln!("skipped: meshes/{name} is not there"),
        }
    }
    largest(report, &context)?;
    textured::run(report, &context)?;
    progressive_cases(report, &context)
}

/// A knot with octaves of waves.
pub fn noisy_knot(along: u32, around: u32) -> Triangles {
    let wave = |p: Vec3| p.x.sin() * (1.1 * p.y + 1.3).sin() * (0.9 * p.z + 0.7).cos();
    let noisy = |point: &[f32; 3]| {
        let point = Vec3::from(*point);
        let octaves = (0..5).map(|octave| 2.0f32.powi(octave));
        let noise: f32 = octaves.map(|octave| 0.03 / octave * wave(point * 4.0 * octave)).sum();
        (point * (1.0 + noise)).to_array()
    };
    let knot = shapes::knot(along, around);
    (knot.points.iter().map(noisy).collect(), knot.triangles())
}

/// Prints how many bytes a triangle the build of a progressive mesh of a knot takes at its peak. It runs in a process of its
/// own, since others have had memory before that they may use again.
pub fn peak(along: u32, around: u32) -> Result<()> {
    let context = Context::new(&ContextOptions::default())?;
    let bytes = progressive::peak(&context, &noisy_knot(along, around))?;
    bytes.into_iter().for_each(|bytes| println!("{bytes}"));
    Ok(())
}

/// What [`peak`] says in its process; `None` where it cannot be known.
fn peak_apart(along: u32, around: u32) -> Option<f64> {
    let size = [along, around].map(|count| count.to_string());
    let told = Command::new(std::env::current_exe().ok()?).args(["peak", "--knot"]).args(size).output().ok()?;
    String::from_utf8(told.stdout).ok()?.trim().parse().ok()
}

/// Progressive meshes: the paper's horse, and meshes of ours of the sizes of two of its dragons.
fn progressive_cases(report: &mut Report, context: &Context) -> Result<()> {
    match shapes::model(context, "meshes/horse.ply")? {
        Some(mesh) => {
            let (told, triangles) = ([0.3, 0.162, 0.595, 0.443, 0.384], mesh.triangles());
            progressive::case(report, context, "horse.ply", &(mesh.points, triangles), (Some(told), Some(0.15)))?;
        }
        None => eprintln!("skipped: meshes/horse.ply is not there"),
    }
    for (along, around, told) in
        [(1050, 415, [1.4, 0.313, 1.201, 0.882, 0.674]), (3000, 1204, [10.4, 0.347, 0.760, 0.379, 0.335])]
    {
        let mesh = noisy_knot(along, around);
        let name = format!("noisy knot, {} vertices, {} triangles: peak of the build", mesh.0.len(), mesh.1.len());
        match peak_apart(along, around) {
            Some(bytes) => {
                report.add(&name, &Sample::new(vec![bytes]), None, "bytes a triangle", Goal::AtMost(150.0));
            }
            None => report.skip(&name, "the system does not tell it"),
        }
        progressive::case(report, context, "noisy knot", &mesh, (Some(told), None))?;
    }
    progressive::editing(report, context, "noisy knot", &noisy_knot(1200, 420))
}

/// Measures a mesh, and returns our rate in millions of triangles a second.
fn case(report: &mut Report, context: &Context, peers: &[Peer], name: &str, mesh: &Triangles) -> Result<f64> {
    let millions = mesh.1.len() as f64 / 1e6;
    let (mine, peer) =
        compare(RUNS, || millions / seconds(|| ours(context, mesh)), || millions / seconds(|| theirs(mesh)));
    report.add(name, &mine, Some(("meshoptimizer", &peer)), "Mtri/s", Goal::RatioAtLeast(1.0));
    let serial = Context::serial();
    let (alone, peer) =
        compare(RUNS, || millions / seconds(|| ours(&serial, mesh)), || millions / seconds(|| theirs(mesh)));
    let one_thread = format!("{name}: one thread against one");
    report.add(&one_thread, &alone, Some(("meshoptimizer", &peer)), "Mtri/s", Goal::None);
    bounded(report, context, name, mesh)?;
    let left = Deviation::between(context, mesh, &ours(context, mesh)?)?;
    let beside = |report: &mut Report, peer: &str, made: &Triangles, [goal, largest]: [Goal; 2]| -> Result<()> {
        let theirs = Deviation::between(context, mesh, made)?;
        for (what, ours, theirs, goal) in [
            ("root mean square deviation", left.mean, theirs.mean, goal),
            ("largest deviation", left.largest, theirs.largest, largest),
        ] {
            let [ours, theirs] = [ours, theirs].map(|value| Sample::new(vec![value]));
            report.add(&format!("{name}: {what}"), &ours, Some((peer, &theirs)), "% of diagonal", goal);
        }
        Ok(())
    };
    beside(report, "meshoptimizer", &theirs(mesh), [0.85, 1.0].map(Goal::RatioAtMost))?;
    for peer in peers {
        let goal = if peer.name == BEST { Goal::RatioAtMost(1.05) } else { Goal::None };
        match peer.simplify(mesh, self::left(&mesh.1)) {
            Ok((made, time)) => {
                beside(report, &peer.name, &made, [goal, Goal::None])?;
                let rate = Sample::new(vec![millions / time]);
                report.add(name, &mine, Some((&peer.name, &rate)), "Mtri/s", Goal::None);
            }
            Err(error) => report.skip(&format!("{name} beside {}", peer.name), &error.to_string()),
        }
    }
    Ok(mine.median())
}

/// Models of which the largest deviation alone is compared. The last two have parts that meet
/// at edges of more than two triangles.
const MODELS: [&str; 12] = [
    "meshes/cheburashka.obj",
    "meshes/beetle-alt.obj",
    "ugly/cow.obj",
    "ugly/octagonal_pocket.ply",
    "ugly/teapot_unwelded.obj",
    "ugly/bunny_zippered.ply",
    "ugly/featuretype.ply",
    "cages/suzanne.obj",
    "cages/monsterfrog.obj",
    "cages/bishop.obj",
    "ugly/beetle.obj",
    "ugly/cycloidal.ply",
];

/// Measures the largest deviations of models, welded, beside meshoptimizer's.
fn largest(report: &mut Report, context: &Context) -> Result<()> {
    for name in MODELS {
        let Some(mesh) = shapes::model(context, name)? else {
            eprintln!("skipped: {name} is not there");
            continue;
        };
        let welded = relievo_lod::weld(&mesh.points, &mesh.triangles());
        let mesh = (welded.points, welded.triangles);
        let made = [ours(context, &mesh)?, theirs(&mesh)];
        let [mine, peer] =
            [Deviation::between(context, &mesh, &made[0])?, Deviation::between(context, &mesh, &made[1])?];
        let [mine, peer] = [mine, peer].map(|deviation| Sample::new(vec![deviation.largest]));
        let case = format!("{name}, {} triangles: largest deviation", mesh.1.len());
        report.add(&case, &mine, Some(("meshoptimizer", &peer)), "% of diagonal", Goal::RatioAtMost(1.0));
    }
    Ok(())
}

/// Measures how far meshes deviate that were simplified to a bound, and to an estimate of the same length, beside what was
/// reported.
fn bounded(report: &mut Report, context: &Context, name: &str, mesh: &Triangles) -> Result<()> {
    let (low, high) = box_of(&mesh.0);
    let diagonal = low.distance(high);
    let length = BOUND * diagonal;
    let cases = [
        ("bound", SimplifyOptions { bound: length, ..SimplifyOptions::default() }, Goal::RatioAtMost(1.0)),
        ("estimate", SimplifyOptions { max_error: length, ..SimplifyOptions::default() }, Goal::None),
    ];
    for (what, options, goal) in cases {
        let mut result = Ok(Default::default());
        let time = seconds(|| result = simplify(context, &mesh.0, &mesh.1, &options, &mut Silent));
        let made: Simplified = result?;
        let reported = Sample::new(vec![100.0 * f64::from(made.error / diagonal)]);
        let made = (made.points, made.triangles);
        let measured = Sample::new(vec![Deviation::between(context, mesh, &made)?.largest]);
        let case = format!("{name}: largest deviation, {} triangles by a {what} of 0.1 %", made.1.len());
        report.add(&case, &measured, Some(("reported", &reported)), "% of diagonal", goal);
        let rate = Sample::new(vec![mesh.1.len() as f64 / 1e6 / time]);
        report.add(&format!("{name}: by a {what} of 0.1 %"), &rate, None, "Mtri/s", Goal::None);
    }
    Ok(())
}

/// How many triangles of these are to be left.
pub fn left(triangles: &[[u32; 3]]) -> usize {
    (triangles.len() as f64 * LEFT) as usize
}

fn ours(context: &Context, mesh: &Triangles) -> Result<Triangles> {
    let options = SimplifyOptions { target_triangles: left(&mesh.1), ..SimplifyOptions::default() };
    let made = simplify(context, &mesh.0, &mesh.1, &options, &mut Silent)?;
    Ok((made.points, made.triangles))
}

fn theirs(mesh: &Triangles) -> Triangles {
    let (mut points, mut indices) = (mesh.0.clone(), mesh.1.as_flattened().to_vec());
    let options = meshopt::SimplifyOptions::None;
    let count = 3 * left(&mesh.1);
    let count =
        meshopt::simplify_with_update(&mut indices, &mut points, &mut [], &[], 0, None, count, f32::MAX, options, None);
    (points, indices[..count].as_chunks().0.to_vec())
}
