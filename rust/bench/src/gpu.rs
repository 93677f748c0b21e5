//! `gpu`: Bézier patches drawn from virtual vertices, as the tables of Concheiro et al. 2013: frames per second of the
//! paper's eight scenes by level and patches a draw, beside tessellating on the processor and sending the triangles of
//! every frame, and beside drawing the same strips with their points computed before.
//!
//! A frame is 1280 × 720 pixels of everything; times are by the device's clock, medians after a warm-up. What a device
//! that is the processor itself (lavapipe) draws is measured too, in few frames.

mod imprint;
mod paint;
pub(crate) mod progressive;

use std::time::Instant;

use glam::{DAffine3, DVec3};
use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_gpu::{AdapterKind, Device, DeviceOptions};
use relievo_render::virtual_vertex::{
    Coat, DrawnSurface, PassedVertex, PassedVertices, Placed, Rasterizer, Shape, Storage, TileDraw, TileRates, Tuning,
    VirtualVertices,
};
use relievo_render::{Camera, Material, View};
use relievo_surface::bezier::{BezierSurface, Levels, ParametricMap, draw_calls};
use relievo_surface::{Surface, SurfaceOptions};
use relievo_tiles::{Displaced, Displacement, DisplacementOptions, Sets};

use crate::measure::{Sample, sample};
use crate::report::{Goal, Report, figure, table};

/// Pixels of a frame.
const SIZE: [u32; 2] = [1280, 720];
/// Patches of a draw (N_d).
const PER_DRAW: [u32; 5] = [1, 2, 4, 8, 16];
const LEVELS: [u32; 5] = [1, 2, 3, 4, 5];
const SCENES: [(&str, &str, u32); 8] = [
    ("S5cups", "teacup", 5),
    ("S5pots", "teapot", 5),
    ("S10cups", "teacup", 10),
    ("S10pots", "teapot", 10),
    ("S15cups", "teacup", 15),
    ("S15pots", "teapot", 15),
    ("S20cups", "teacup", 20),
    ("S20pots", "teapot", 20),
];

/// Measures all scenes.
pub fn run(report: &mut Report, json: bool) -> Result<()> {
    let context = Context::new(&relievo_core::ContextOptions::default())?;
    let options = DeviceOptions { timing: true, ..DeviceOptions::default() };
    let device = match Device::open(&options) {
        Ok(device) => device,
        Err(error) => {
            report.skip("graphics devices", &error.to_string());
            return Ok(());
        }
    };
    crate::gpu::paint::run(&device, report, json)?;
    crate::gpu::imprint::run(&context, report, &device)?;
    let software = device.summary().kind == AdapterKind::Software;
    let frames = if software { 3 } else { 200 };
    let mut rasterizer = Rasterizer::new(&device)?;
    let material = Material { base_color: [0.6, 0.3, 0.2], specular: 0.04, roughness: 0.4 };
    let mut rows = vec![["scene".to_owned(), "N_s".into(), "N_d".into(), "N_DP".into()].to_vec()];
    rows[0].extend(LEVELS.map(|level| format!("L = {level}")));
    let mut last = None;
    for (name, model, copies) in SCENES {
        let Some(path) = relievo_testing::file(&format!("patches/{model}")) else { return Ok(()) };
        let scene = Scene::new(&context, &path, copies)?;
        let patches = scene.surface.count();
        let mut upload = vec![name.to_owned(), patches.to_string(), "processor".into(), String::new()];
        for level in LEVELS {
            let levels = Levels::uniform(&scene.surface, level)?;
            let count = if software { 1 } else { 9 };
            let time = tessellated(&context, &device, &mut rasterizer, &scene, &levels, &material, count)?;
            upload.push(format!("{:.1}", 1.0 / time.median()));
        }
        rows.push(upload);
        for per_draw in PER_DRAW {
            let calls = draw_calls(patches as u64, u64::from(per_draw));
            let mut row = vec![name.to_owned(), patches.to_string(), per_draw.to_string(), calls.to_string()];
            for level in LEVELS {
                let levels = Levels::uniform(&scene.surface, level)?;
                let drawn = VirtualVertices::new(&device, &scene.surface, &levels, Storage::Uniform, per_draw)?;
                let found = drawn.draws().len() as u64;
                if found != calls {
                    return Err(Error::internal(format!("{found} draws instead of {calls}")));
                }
                let time = rasterizer.median(&[Placed::new(Shape::Patches(&drawn), material)], &scene.view, frames)?;
                row.push(format!("{:.1}", 1.0 / time.as_secs_f64()));
            }
            rows.push(row);
        }
        last = Some(scene);
    }
    if !json {
        println!("{}, {} frames of {}×{} pixels; frames per second", device.summary(), frames, SIZE[0], SIZE[1]);
        print!("{}", table(&rows));
        println!();
    }
    let Some(scene) = last else { return Ok(()) };
    largest(&device, &mut rasterizer, &scene, &material, report, frames as usize)?;
    displaced(&context, &device, &mut rasterizer, &material, report, frames as usize)?;
    tuned(&device, &mut rasterizer, &scene, &material, frames, json)
}

/// The largest scene at the highest level: samples a second, and the same strips with points computed before.
fn largest(
    device: &Device,
    rasterizer: &mut Rasterizer,
    scene: &Scene,
    material: &Material,
    report: &mut Report,
    frames: usize,
) -> Result<()> {
    let level = LEVELS[LEVELS.len() - 1];
    let levels = Levels::uniform(&scene.surface, level)?;
    for storage in Storage::ALL {
        let patches = VirtualVertices::new(device, &scene.surface, &levels, storage, 16)?;
        let map = ParametricMap::new(level)?;
        let mut error = None;
        let mut seconds = |result: Result<std::time::Duration>| match result {
            Ok(time) => time.as_secs_f64().max(1e-9),
            Err(failure) => {
                error.get_or_insert(failure);
                1.0
            }
        };
        let drawn = [Placed::new(Shape::Patches(&patches), *material)];
        let ours = sample(frames, || seconds(rasterizer.time(&drawn, &scene.view, SIZE)));
        let passed = passed_vertices(device, scene, &patches, &levels)?;
        let drawn = [Placed::new(Shape::Strips(&patches, &passed), *material)];
        let peer = sample(frames, || seconds(rasterizer.time(&drawn, &scene.view, SIZE)));
        if let Some(error) = error {
            return Err(error);
        }
        let vertices = map.strip_vertices() as f64 * scene.surface.count() as f64;
        let rate = Sample::new(vec![vertices / ours.median() / 1e9]);
        let name = format!("{} patches, level {level}, {}", scene.surface.count(), storage.name());
        report.add(&format!("{name}, samples"), &rate, None, "G/s", Goal::AtLeast(1.0));
        let milliseconds = |sample: &Sample| Sample::new(vec![1e3 * sample.median()]);
        let (ours, peer) = (milliseconds(&ours), milliseconds(&peer));
        let peer = Some(("passed through", &peer));
        report.add(&format!("{name}, frame"), &ours, peer, "ms", Goal::RatioAtMost(1.3));
    }
    Ok(())
}

/// A displaced Catmull-Clark surface with Gregory patches, and the same vertices with points computed before.
fn displaced(
    context: &Context,
    device: &Device,
    rasterizer: &mut Rasterizer,
    material: &Material,
    report: &mut Report,
    frames: usize,
) -> Result<()> {
    let Some(path) = relievo_testing::file("cages/monsterfrog.obj") else { return Ok(()) };
    let cage = relievo_meshio::read(context, &path)?;
    let surface = Surface::new(context, &cage, &SurfaceOptions::default())?;
    let options = DisplacementOptions { size: 16, ..DisplacementOptions::default() };
    let mut displacement = Displacement::new(surface.topology().clone(), &options)?;
    let all: Vec<u32> = (0..surface.tile_count() as u32).collect();
    displacement.apply(&Sets { allocate: all.clone(), ..Sets::default() })?;
    let height = 0.001 * surface.extent();
    let changes = displacement.edit(context, &all, |_, texels| {
        for j in 0..texels.size() {
            for (i, texel) in texels.row_mut(j).iter_mut().enumerate() {
                *texel = f16::from_f32(height * ((i as f32).sin() + (j as f32).cos()));
            }
        }
    })?;
    displacement.settle(context, &changes)?;
    let made = Displaced::new(&surface, displacement.field())?;
    let mut drawn = DrawnSurface::new(context, device, &made, Coat::default())?;
    drawn.tiles_mut().divide(device, TileRates::uniform(surface.topology(), 16)?)?;
    let (low, high) = surface.bounds();
    let [low, high] = [low, high].map(|corner| DVec3::from(corner.map(f64::from)));
    let middle = 0.5 * (low + high);
    let mut view =
        View::new(Camera::look_at(middle + DVec3::new(0.5, 0.3, 2.0) * (high - low).length(), middle, DVec3::Y, 0.7)?);
    [view.settings.width, view.settings.height] = SIZE;
    view.settings.shadows = relievo_core::parameter::Switch::OFF;
    let mut error = None;
    let mut measure = |object: Placed<'_>| {
        sample(frames, || match rasterizer.time(&[object], &view, SIZE) {
            Ok(time) => 1e3 * time.as_secs_f64(),
            Err(failure) => {
                error.get_or_insert(failure);
                1.0
            }
        })
    };
    let ours = measure(drawn.placed(DAffine3::IDENTITY, *material, None));
    let passed = drawn.tiles().passed(context, device, &made, material)?;
    let peer = measure(Placed::new(Shape::Mesh(&passed), *material));
    if let Some(error) = error {
        return Err(error);
    }
    let vertices: u64 = drawn.tiles().draws().iter().map(TileDraw::vertices).sum();
    let name = format!("{} displaced tiles, {vertices} vertices", all.len());
    let rate = Sample::new(vec![vertices as f64 / ours.median() / 1e6]);
    report.add(&format!("{name}, evaluated once each"), &rate, None, "G/s", Goal::None);
    report.add(&format!("{name}, frame"), &ours, Some(("passed through", &peer)), "ms", Goal::RatioAtMost(1.3));
    Ok(())
}

fn tuned(
    device: &Device,
    rasterizer: &mut Rasterizer,
    scene: &Scene,
    material: &Material,
    frames: u32,
    json: bool,
) -> Result<()> {
    let tuning = Tuning { frames: frames.min(20), ..Tuning::default() };
    let best = rasterizer.tune(device, &scene.surface, &scene.view, material, &tuning)?.best;
    if !json {
        println!(
            "Tuned for 60 frames a second on {} patches: L = {}, N_d = {}, N_DP = {}, control points in a {}: {} ms",
            scene.surface.count(),
            best.level,
            best.per_draw,
            best.draw_calls,
            best.storage.name(),
            figure(1e3 * best.time.as_secs_f64())
        );
        println!();
    }
    Ok(())
}

/// Copies of a model, and a camera that sees them all.
struct Scene {
    surface: BezierSurface,
    view: View,
}

impl Scene {
    fn new(context: &Context, path: &std::path::Path, copies: u32) -> Result<Self> {
        let patches = relievo_meshio::read_patches(context, path)?;
        let one = BezierSurface::new(context, &patches.points, Some(&patches.indices), None)?;
        let (low, high) = one.total_bounds();
        let row = f64::from(copies).sqrt().ceil() as u32;
        let step: [f32; 3] = std::array::from_fn(|axis| 1.1 * (high[axis] - low[axis]));
        let mut points = Vec::new();
        for copy in 0..copies {
            let [x, y] = [copy % row, copy / row].map(|at| at as f32);
            for index in &patches.indices {
                let [px, py, pz] = patches.points[*index as usize];
                points.push([px + x * step[0], py + y * step[1], pz]);
            }
        }
        let surface = BezierSurface::new(context, &points, None, None)?;
        let (low, high) = surface.total_bounds();
        let [low, high] = [low, high].map(|corner| DVec3::from(corner.map(f64::from)));
        let (middle, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
        let eye = middle + DVec3::new(0.1, -0.5, 0.9).normalize() * radius * 2.4;
        let mut view = View::new(Camera::look_at(eye, middle, DVec3::Y, 0.7)?);
        [view.settings.width, view.settings.height] = SIZE;
        view.settings.shadows = relievo_core::parameter::Switch::OFF;
        Ok(Self { surface, view })
    }
}

/// Seconds of a frame whose triangles the processor makes: tessellation, sending, drawing.
fn tessellated(
    context: &Context,
    device: &Device,
    rasterizer: &mut Rasterizer,
    scene: &Scene,
    levels: &Levels,
    material: &Material,
    runs: usize,
) -> Result<Sample> {
    let patches = VirtualVertices::new(device, &scene.surface, levels, Storage::Buffer, 16)?;
    let vertices = patches.draws().iter().map(|draw| draw.vertices()).sum::<Result<u32>>()?;
    let passed = PassedVertices::new(device, vertices as usize)?;
    let mut times = Vec::new();
    let drawn = [Placed::new(Shape::Strips(&patches, &passed), *material)];
    for run in 0..=runs {
        let start = Instant::now();
        let strips = strips(context, scene, &patches, levels)?;
        passed.write(device, 0, &strips)?;
        rasterizer.time(&drawn, &scene.view, SIZE)?;
        if run > 0 {
            times.push(start.elapsed().as_secs_f64());
        }
    }
    Ok(Sample::new(times))
}

fn passed_vertices(
    device: &Device,
    scene: &Scene,
    patches: &VirtualVertices,
    levels: &Levels,
) -> Result<PassedVertices> {
    let strips = strips(&Context::serial(), scene, patches, levels)?;
    let passed = PassedVertices::new(device, strips.len())?;
    passed.write(device, 0, &strips)?;
    Ok(passed)
}

/// The strips of all draws with their points.
fn strips(context: &Context, scene: &Scene, patches: &VirtualVertices, levels: &Levels) -> Result<Vec<PassedVertex>> {
    let tessellation = scene.surface.tessellate(context, levels)?;
    let pieces = context.map(patches.draws().len(), |at| {
        let draw = patches.draws()[at];
        let map = ParametricMap::new(draw.level)?;
        let mut piece = Vec::with_capacity(draw.vertices()? as usize);
        for patch in &patches.order()[draw.first as usize..(draw.first + draw.count) as usize] {
            let first = tessellation.first[*patch as usize];
            piece.extend(map.strip().map(|[i, j]| {
                let point = (first + j * map.side() + i) as usize;
                PassedVertex {
                    p: tessellation.points[point],
                    sample: i | j << 16,
                    normal: tessellation.normals[point],
                    padding: 0,
                }
            }));
        }
        Ok(piece)
    });
    let mut all = Vec::new();
    for piece in pieces {
        let piece: Result<Vec<PassedVertex>> = piece;
        all.extend(piece?);
    }
    Ok(all)
}
