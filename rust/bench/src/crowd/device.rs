//! The scenes of Table 1 of the paper on a graphics device, cut, posed and drawn there: at full resolution, by the cut of half a
//! pixel, and without agents that others hide.
//!
//! A frame is all work of the processor and the device for 1280 × 720 pixels, until the device is done. Where the device is the
//! processor itself (lavapipe), crowds and characters are smaller and frames few.

use std::sync::Arc;
use std::time::Instant;

use glam::{DMat3, DVec3};
use relievo_core::parameter::Switch;
use relievo_core::progress::Silent;
use relievo_core::{Context, Result};
use relievo_crowd::{Agent, BuildSettings, Crowd, CrowdModel, CrowdView, Frame, Look, PixelView, parse_agents, square};
use relievo_gpu::{AdapterKind, Device, DeviceOptions};
use relievo_meshio::Model;
use relievo_render::virtual_vertex::Rasterizer;
use relievo_render::{Camera, Material, View};
use relievo_scene::walking::{DeviceStandIns, StandIns};

use super::refine::refined;
use super::{SIZE, moved};
use crate::measure::Sample;
use crate::report::{Goal, Report};

/// Frames of a case, and of one on a device that is the processor itself.
const FRAMES: [usize; 2] = [120, 3];
/// As many times more with culling, which needs some to find out whether it pays.
const CULLED: [usize; 2] = [1, 3];
/// The angle of view in radians.
const FOV: f64 = 0.7;
const MATERIAL: Material = Material { base_color: [0.6; 3], specular: 0.02, roughness: 0.6 };
/// Difference of two colours beyond which they count as different.
const DIFFERENT: f32 = 0.02;
/// Error in pixels at which nothing is simplified.
const NOTHING: f32 = 1e-6;

/// A scene of Table 1. The paper's has as many agents, or as many triangles of which each agent has more.
struct Scene {
    name: &'static str,
    /// Agents and how often their triangles are divided into four; the same on a device that is the processor.
    agents: [usize; 2],
    divided: [u32; 2],
    /// Diagonals of the character from agent to agent, and from the ground to the camera.
    spacing: f64,
    above: f64,
    /// Frames a second, and thousands of triangles a frame, in the table: at full resolution, by cuts, and with culling.
    rates: [f64; 3],
    triangles: [f64; 3],
}

const SCENES: [Scene; 3] = [
    Scene {
        name: "office",
        agents: [200, 60],
        divided: [4, 1],
        spacing: 0.5,
        above: 0.6,
        rates: [10.27, 43.29, 49.21],
        triangles: [12_460.0, 2_290.0, 2_060.0],
    },
    Scene {
        name: "exhibition",
        agents: [1_000, 300],
        divided: [4, 1],
        spacing: 0.35,
        above: 0.6,
        rates: [7.73, 29.15, 46.08],
        triangles: [24_660.0, 3_140.0, 1_940.0],
    },
    Scene {
        name: "stampede",
        agents: [6_750, 200],
        divided: [3, 2],
        spacing: 0.8,
        above: 12.0,
        rates: [0.55, 16.38, 16.23],
        triangles: [148_090.0, 4_770.0, 4_700.0],
    },
];

/// Whether cuts are refined to the input, and whether agents that others hide are drawn.
const CASES: [(&str, f32, bool); 3] = [
    ("full resolution", NOTHING, false),
    ("cut at half a pixel", 0.5, false),
    ("the same, culled by occlusion", 0.5, true),
];

/// Measures the scenes with a character that plays a clip.
pub fn run(
    report: &mut Report,
    context: &Context,
    (source, clip): (&Model, usize),
    settings: &BuildSettings,
) -> Result<()> {
    let device = match Device::open(&DeviceOptions::default()) {
        Ok(device) => device,
        Err(error) => {
            report.skip("crowds on graphics devices", &error.to_string());
            return Ok(());
        }
    };
    let kind = usize::from(device.summary().kind == AdapterKind::Software);
    for scene in &SCENES {
        let fine = refined(source, scene.divided[kind]);
        let model = CrowdModel::build(context, &fine, &[clip], settings, &mut Silent)?;
        let mut shown = Shown::new(context, &device, scene, scene.agents[kind], model)?;
        let full = shown.full() as f64 / 1e6;
        for ((case, error, culls), at) in CASES.into_iter().zip(0..) {
            let count = FRAMES[kind] * if culls { CULLED[kind] } else { 1 };
            let frames = (0..count).map(|number| shown.draw(number, error, culls)).collect::<Result<Vec<_>>>()?;
            // Room is made in the first frames.
            let skipped = frames.len() / 3;
            let rates = frames[skipped..].iter().map(|(seconds, _)| 1.0 / seconds).collect();
            let counts = frames.iter().map(|(_, triangles)| f64::from(*triangles) / 1e6).collect();
            let name = format!("{}, {} agents, {full:.1} M triangles, {case}", scene.name, scene.agents[kind]);
            let paper = |value: f64| Sample::new(vec![value]);
            let goal = if kind == 0 && at > 0 { Goal::AtLeast(200.0) } else { Goal::None };
            report.add(&name, &Sample::new(rates), Some(("paper", &paper(scene.rates[at]))), "frames/s", goal);
            report.add(
                "its triangles",
                &Sample::new(counts),
                Some(("paper", &paper(scene.triangles[at] / 1e3))),
                "M",
                Goal::None,
            );
        }
        let differ = Sample::new(vec![shown.differ_from_rays()?]);
        let case = format!("{}, numbers of its picture that differ from the caster's", scene.name);
        report.add(&case, &differ, None, "%", Goal::AtMost(0.5));
    }
    Ok(())
}

/// A crowd that walks before a camera, on a device.
struct Shown<'a> {
    context: &'a Context,
    crowd: Crowd,
    agents: Vec<Agent>,
    stand_ins: DeviceStandIns,
    rasterizer: Rasterizer,
    /// Where the camera is, and its angle above the horizon.
    eye: DVec3,
    pitch: f64,
    /// Of agents, units a second.
    speed: f64,
}

impl<'a> Shown<'a> {
    fn new(context: &'a Context, device: &Device, scene: &Scene, count: usize, model: CrowdModel) -> Result<Self> {
        let size = f64::from(model.size());
        let agents = parse_agents(&square(&model, count, scene.spacing * size), &[&model])?;
        let mut crowd = Crowd::new(vec![Arc::new(model)]);
        agents.iter().try_for_each(|agent| crowd.add(*agent).map(drop))?;
        let half = 0.5 * scene.spacing * size * (count as f64).sqrt();
        let eye = DVec3::new(0.0, scene.above * size, half + 2.0 * size);
        let look = Look { tag: None, lines: false };
        Ok(Self {
            context,
            stand_ins: DeviceStandIns::new(device, &crowd, look)?,
            rasterizer: Rasterizer::new(device)?,
            crowd,
            agents,
            pitch: -(eye.y - 0.5 * size).atan2(eye.z),
            eye,
            speed: 0.5 * size,
        })
    }

    /// Returns the triangles of all agents at full resolution.
    fn full(&self) -> u64 {
        u64::from(self.crowd.models()[0].input_triangles) * self.agents.len() as u64
    }

    /// Moves the agents ahead, and returns the views of a frame.
    fn view(&mut self, number: usize, error: f32) -> Result<(f64, View, CrowdView, PixelView)> {
        let time = number as f64 / 60.0;
        for (index, agent) in (0..).zip(&self.agents) {
            self.crowd.set(index, moved(agent, self.speed * time))?;
        }
        let axes = DMat3::from_rotation_y(0.1 * time) * DMat3::from_rotation_x(self.pitch);
        let camera = Camera { eye: self.eye, axes, fov: FOV };
        let mut view = View::new(camera);
        [view.settings.width, view.settings.height] = SIZE;
        (view.settings.samples, view.settings.sky_rays, view.settings.shadows) = (1, 0, Switch::OFF);
        let seen = CrowdView::perspective(camera.eye, axes, FOV, SIZE, error)?;
        Ok((time, view, seen, PixelView { eye: camera.eye, axes, fov: FOV, size: SIZE }))
    }

    /// Draws a frame. Returns its seconds and triangles.
    fn draw(&mut self, number: usize, error: f32, culls: bool) -> Result<(f64, u32)> {
        let start = Instant::now();
        let (time, view, seen, pixels) = self.view(number, error)?;
        let pixels = culls.then_some(&pixels);
        let counts = self.stand_ins.update(self.context, &self.crowd, (&seen, time), pixels)?;
        self.rasterizer.time(&self.stand_ins.placed(MATERIAL), &view, SIZE)?;
        Ok((start.elapsed().as_secs_f64(), counts.triangles))
    }

    /// Returns the share of the numbers of a picture, in percent, that differ from those of the ray caster for the same cut.
    fn differ_from_rays(&mut self) -> Result<f64> {
        let (time, view, seen, _) = self.view(0, 0.5)?;
        self.stand_ins.update(self.context, &self.crowd, (&seen, time), None)?;
        let drawn = self.rasterizer.render(&self.stand_ins.placed(MATERIAL), &view)?.color;
        let (mut frame, mut picture) = (Frame::default(), relievo_render::Scene::new()?);
        self.crowd.cut(self.context, &seen, &mut frame)?;
        let shown = (&self.crowd, &frame, time, view.camera.eye);
        StandIns::default().show(self.context, &mut picture, shown, MATERIAL, &|_, _, _, _| 0)?;
        let rays = picture.render(self.context, &view)?.color;
        let differ = rays.data().iter().zip(drawn.data()).filter(|(a, b)| (*a - *b).abs() > DIFFERENT).count();
        Ok(100.0 * differ as f64 / rays.data().len() as f64)
    }
}
