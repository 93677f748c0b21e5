//! Progressive meshes in the form of Table 2 of Derzapf, Grund and Guthe 2014, whose figures are for a GTX 580.

use std::f32::consts::TAU;
use std::sync::Arc;

use glam::Vec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, Falloff, Result};
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, BuildOptions, Cut, Edit, Extents, Extract, Handle, Region, View};

use crate::gpu::progressive;
use crate::lod::Triangles;
use crate::measure::{Sample, memory, sample, seconds};
use crate::report::{Goal, Report};

/// Whose figures stand beside ours.
const PAPER: &str = "Derzapf 2014, GTX 580";
/// Runs of each figure.
const RUNS: usize = 3;

/// The paper's figures of a model: seconds, and millions of collapses of the build, splits, collapses and updates a
/// second.
pub type Told = [f64; 5];

/// Measures a mesh. `most` is the time that its build may take, if that is not told by its rate.
pub fn case(
    report: &mut Report,
    context: &Context,
    name: &str,
    mesh: &Triangles,
    (told, most): (Option<Told>, Option<f64>),
) -> Result<()> {
    let name = format!("{name}, {} vertices, {} triangles", mesh.0.len(), mesh.1.len());
    let faces = mesh.1.len() as f64;
    let build = || Progressive::build(context, &mesh.0, &mesh.1, &BuildOptions::default(), &mut Silent);
    let built = Arc::new(build()?);
    let bytes = Sample::new(vec![built.bytes() as f64 / faces]);
    // Points, normals and corners.
    let plain = Sample::new(vec![(24.0 * mesh.0.len() as f64 + 12.0 * faces) / faces]);
    let plain = Some(("indexed face set with normals", &plain));
    report.add(&format!("{name}: in memory"), &bytes, plain, "bytes a triangle", Goal::AtMost(40.0));
    let mut file = Vec::new();
    built.write(context, &mut file).map_err(|error| relievo_core::Error::internal(error.to_string()))?;
    let bytes = Sample::new(vec![file.len() as f64 / faces]);
    report.add(&format!("{name}: in a file"), &bytes, None, "bytes a triangle", Goal::None);
    let time = sample(RUNS, || seconds(build));
    let paper = |index: usize| told.map(|told| Sample::new(vec![told[index]]));
    let goal = most.map_or(Goal::AtMost(faces / 0.7e6), Goal::AtMost);
    report.add(&format!("{name}: build"), &time, paper(0).as_ref().map(|it| (PAPER, it)), "s", goal);
    let operations = built.splits().count() as f64 / 1e6;
    let rates = rates(context, &built, operations)?;
    let build_rate = Sample::new(vec![operations / time.median()]);
    let rows = [("simplification", &build_rate, Goal::None), ("splits", &rates[0], Goal::AtLeast(3.0))];
    let rows = rows
        .into_iter()
        .chain([("collapses", &rates[1], Goal::AtLeast(2.0)), ("updates", &rates[2], Goal::AtLeast(1.0))]);
    for (index, (what, rate, goal)) in rows.enumerate() {
        let paper = paper(index + 1);
        report.add(&format!("{name}: {what}"), rate, paper.as_ref().map(|it| (PAPER, it)), "M/s", goal);
    }
    let views = views(&mesh.0);
    let (frames, triangles) = frames(context, &built, &views)?;
    let what = format!("{name}: frames of a camera around it, {triangles} triangles");
    report.add(&what, &frames, None, "1/s", Goal::None);
    progressive::case(report, context, &name, &built, &views)
}

/// Bytes a triangle that a build has at its peak beside the mesh that it is of, if the system tells and this process has had
/// no others.
pub fn peak(context: &Context, (points, triangles): &Triangles) -> Result<Option<f64>> {
    let before = memory("VmRSS");
    Progressive::build(context, points, triangles, &BuildOptions::default(), &mut Silent)?;
    Ok(memory("VmHWM").zip(before).map(|(peak, before)| (peak - before) / triangles.len() as f64))
}

/// Pictures of a camera that goes around a mesh.
const PICTURES: usize = 36;

/// A camera that goes around a mesh at its border, which it wants to a pixel of 720 lines.
fn views(points: &[[f32; 3]]) -> Vec<View> {
    let vectors = || points.iter().map(|point| Vec3::from(*point));
    let (low, high) =
        (vectors().reduce(Vec3::min).unwrap_or_default(), vectors().reduce(Vec3::max).unwrap_or_default());
    let (middle, radius) = ((low + high) / 2.0, (high - low).length() / 2.0);
    let view = |picture: usize| {
        let angle = TAU * picture as f32 / PICTURES as f32;
        let eye = middle + 1.2 * radius * Vec3::new(angle.cos(), angle.sin(), 0.3);
        View { eye: eye.to_array(), pixels: 720.0, tolerance: 1.0, outline: 1.0, planes: Vec::new() }
    };
    (0..=PICTURES).map(view).collect()
}

/// Frames a second in which a mesh becomes as fine as a camera needs it and a host's buffers are brought up to date, and
/// how many triangles it then has.
fn frames(context: &Context, built: &Arc<Progressive>, views: &[View]) -> Result<(Sample, usize)> {
    let extents = Extents::new(built);
    let (mut active, mut buffers, mut rates) = (ActiveMesh::new(built), Extract::default(), Vec::new());
    for (picture, view) in views.iter().enumerate() {
        let mut made = Ok([0; 2]);
        let time = seconds(|| {
            made = active.adapt_to(context, view, &extents);
            active.update(&mut buffers, false);
        });
        made?;
        // The first makes the mesh from its base.
        if picture > 0 {
            rates.push(1.0 / time);
        }
    }
    Ok((Sample::new(rates), active.triangle_count()))
}

/// Millions of splits, of collapses, and of collapses that are made anew after an edit, a second.
fn rates(context: &Context, built: &Arc<Progressive>, operations: f64) -> Result<[Sample; 3]> {
    let mut rates = [const { Vec::new() }; 3];
    let edit = of_everything();
    for _ in 0..RUNS {
        let mut active = ActiveMesh::new(built);
        active.adapt(context, Cut::FINEST);
        rates[1].push(operations / seconds(|| active.adapt(context, Cut::BASE)));
        rates[0].push(operations / seconds(|| active.adapt(context, Cut::FINEST)));
        // The first one finds what is around splits.
        active.edit(context, &edit)?;
        let mut edited = Ok(0);
        rates[2].push(operations / seconds(|| edited = active.edit(context, &edit)));
        edited?;
    }
    Ok(rates.map(Sample::new))
}

/// An edit that moves and turns everything.
pub fn of_everything() -> Edit {
    Edit { handles: vec![handle(Vec3::ZERO, 1e9, Falloff::Constant)], anchors: Vec::new() }
}

fn handle(center: Vec3, radius: f32, falloff: Falloff) -> Handle {
    let region = Region { center: center.to_array(), radius, falloff };
    Handle { region, translation: [0.01; 3], axis: [0.0, 0.0, 1.0], angle: 0.1 }
}

/// Vertices that a step of editing reaches.
const REACHED: usize = 10_000;
/// Steps of editing.
const STEPS: usize = 15;

/// Measures edits of a region of the finest mesh that all coarser ones follow, each step with what a host has to draw.
pub fn editing(report: &mut Report, context: &Context, name: &str, mesh: &Triangles) -> Result<()> {
    let name = format!("{name}, {} triangles", mesh.1.len());
    let built = Arc::new(Progressive::build(context, &mesh.0, &mesh.1, &BuildOptions::default(), &mut Silent)?);
    let mut active = ActiveMesh::new(&built);
    active.adapt(context, Cut::FINEST);
    let center = Vec3::from(mesh.0[0]);
    let mut distances: Vec<f32> = mesh.0.iter().map(|point| center.distance((*point).into())).collect();
    let (_, radius, _) = distances.select_nth_unstable_by(REACHED, f32::total_cmp);
    let radius = *radius;
    let step = |translation: f32| {
        let handle = Handle { translation: [translation * radius; 3], ..handle(center, radius, Falloff::Smooth) };
        Edit { handles: vec![handle], anchors: Vec::new() }
    };
    let mut buffers = Extract::default();
    active.update(&mut buffers, false);
    let mut first = Ok(0);
    let time = Sample::new(vec![seconds(|| first = active.edit(context, &step(0.01)))]);
    first?;
    report.add(&format!("{name}: the first edit of a mesh"), &time, None, "s", Goal::None);
    let (mut times, mut reached) = (Vec::new(), 0);
    for index in 0..STEPS {
        let mut edited = Ok(0);
        let time = seconds(|| {
            edited = active.edit(context, &step(if index % 2 == 0 { 0.01 } else { -0.01 }));
            active.update(&mut buffers, false);
        });
        reached = edited?;
        times.push(1e3 * time);
    }
    let what = format!("{name}: an edit of {reached} vertices, with {} coarser ones", active.moved_last() - reached);
    report.add(&what, &Sample::new(times), None, "ms", Goal::AtMost(16.0));
    Ok(())
}
