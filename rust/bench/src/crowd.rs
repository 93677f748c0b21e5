//! Bench `crowd`: hierarchies of articulated models beside meshoptimizer's cluster hierarchy, which knows the bind pose
//! alone, clusters by an octree, and hierarchies over all poses; the cuts of a thousand agents; whole crowds on a graphics device.

mod compare;
mod device;
mod refine;

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Result};
use relievo_crowd::{Agent, BuildSettings, Crowd, CrowdModel, CrowdView, Frame, parse_agents, square};

use self::refine::{joined, refined};
use crate::measure::{Sample, seconds};
use crate::report::{Goal, Report};

/// A walking person, its clip, and how often its triangles are divided into four.
const PERSON: (&str, &str, u32) = ("characters/girl.glb", "RunTrack", 4);
/// Poses of the clip.
const POSES: f32 = 8.0;
/// Poses that the paper's walk has, and a distance at which about eight of them are representative, as there.
const WALK: (f32, f32) = (35.0, 0.2);
/// Triangles of the largest person of the paper, and seconds that a build of it may take.
const LARGEST: (f64, f64) = (110_000.0, 10.0);
const AGENTS: usize = 1000;
/// Frames of a walk through the crowd.
const FRAMES: usize = 300;
const SIZE: [u32; 2] = [1280, 720];

pub fn run(report: &mut Report) -> Result<()> {
    let context = Context::new(&ContextOptions::default())?;
    let (name, clip, times) = PERSON;
    let path = relievo_testing::folder().join(name);
    if !path.is_file() {
        report.skip("crowd", "characters/girl.glb is not there");
        return Ok(());
    }
    let source = relievo_meshio::read_model(&context, &path)?;
    let clip = source.animation(clip)?;
    let (start, end) = source.animations[clip].range();
    let rate = |poses: f32| BuildSettings { pose_rate: poses / (end - start) as f32, ..BuildSettings::default() };
    let fine = refined(&source, times);
    let mut model = CrowdModel::default();
    let walk = BuildSettings { pose_distance: WALK.1, ..rate(WALK.0) };
    for (settings, goal) in [(walk, None), (rate(POSES), Some(LARGEST.1))] {
        let build = || model = CrowdModel::build(&context, &fine, &[clip], &settings, &mut Silent).unwrap_or_default();
        let time = Sample::new(vec![seconds(build)]);
        let (triangles, found) = (model.input_triangles, model.report);
        let case = format!(
            "build of a person, {triangles} triangles, {} of {} poses representative",
            found.representatives, found.poses
        );
        let goal = goal.unwrap_or(LARGEST.1 * f64::from(triangles) / LARGEST.0);
        report.add(&case, &time, None, "s", Goal::AtMost((10.0 * goal).round() / 10.0));
    }
    let mut file = Vec::new();
    model.write(&mut file).map_err(|error| relievo_core::Error::internal(error.to_string()))?;
    let bytes = Sample::new(vec![file.len() as f64 / f64::from(model.input_triangles)]);
    report.add("its file", &bytes, None, "bytes/triangle", Goal::AtMost(48.0));
    cuts(report, &context, model)?;
    // The peer takes vertices at one place as one, so that both have the shape alone. Seams would open where the weights of
    // both sides are rounded apart when triangles are divided.
    let mut bare = source.clone();
    for part in &mut bare.meshes {
        part.mesh.attributes.retain(|attribute| attribute.name == "joints" || attribute.name == "weights");
        part.mesh = joined(&part.mesh);
    }
    compare::run(report, &context, (&bare, clip), &rate)?;
    device::run(report, &context, (&source, clip), &rate(POSES))
}

/// Measures the cuts of a crowd that walks while the camera goes through it.
fn cuts(report: &mut Report, context: &Context, model: CrowdModel) -> Result<()> {
    let size = f64::from(model.size());
    let agents = parse_agents(&square(&model, AGENTS, 0.8 * size), &[&model])?;
    let full = u64::from(model.input_triangles);
    let mut crowd = Crowd::new(vec![Arc::new(model)]);
    for agent in &agents {
        crowd.add(*agent)?;
    }
    let half = 0.4 * size * (AGENTS as f64).sqrt();
    let (mut times, mut drawn, mut in_view) = (Vec::new(), 0.0, 0.0);
    let mut frame = Frame::default();
    for number in 0..FRAMES {
        let time = number as f64 / 60.0;
        let eye = DVec3::new(0.3 * half, size, half * (1.3 - 0.2 * time));
        let axes = DMat3::from_rotation_y(0.1 * time);
        let view = CrowdView::perspective(eye, axes, 0.7, SIZE, 0.5)?;
        let mut done = Ok(());
        times.push(1e3 * seconds(|| done = walk(&mut crowd, context, &agents, time, &view, &mut frame)));
        done?;
        drawn += frame.triangles as f64;
        in_view += (full * frame.drawn.len() as u64) as f64;
    }
    let case = format!("cut of {AGENTS} agents that walk, a frame");
    report.add(&case, &Sample::new(times), None, "ms", Goal::AtMost(0.3));
    let share = 100.0 * drawn / in_view;
    // The exhibition of the paper draws 1.94 of 24.66 million triangles with culling by occlusion (Table 1), which is not at work
    // here.
    let goal = Goal::AtMost(7.9);
    report.add("triangles drawn at 0.5 pixels", &Sample::new(vec![share]), None, "% of those in view", goal);
    Ok(())
}

/// Moves all agents ahead and cuts the crowd.
fn walk(
    crowd: &mut Crowd,
    context: &Context,
    agents: &[Agent],
    time: f64,
    view: &CrowdView,
    frame: &mut Frame,
) -> Result<()> {
    for (index, agent) in agents.iter().enumerate() {
        crowd.set(index as u32, moved(agent, time))?;
    }
    crowd.cut(context, view, frame)
}

/// Returns an agent that has gone ahead by so many of its own units.
fn moved(agent: &Agent, distance: f64) -> Agent {
    let step = DAffine3::from_translation(agent.transform.matrix3 * DVec3::Z * distance);
    Agent { transform: step * agent.transform, ..*agent }
}
