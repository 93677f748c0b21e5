//! `relievo draw`

mod surface;

use std::path::PathBuf;
use std::process::ExitCode;

use glam::DAffine3;
use relievo_core::parameter::Switch;
use relievo_core::{Context, Error, Result};
use relievo_gpu::Device;
use relievo_render::virtual_vertex::{Placed, Rasterizer, Shape, Storage, Tuning, VirtualVertices};
use relievo_render::{Frame, Mesh, Scene, View, write_png};
use relievo_scene::showing::Showing;
use relievo_surface::bezier::{BezierSurface, Levels, MAX_LEVEL};

use crate::Outcome;
use crate::args::device::{Adapter, Device as Kind};
use crate::args::viewpoint::Axis;

#[derive(clap::Args)]
pub struct Arguments {
    /// Bézier patches (.bpt, or a list of indices and points), a mesh whose Catmull-Clark surface is drawn, or a document.
    file: PathBuf,
    /// The mesh that the document was made on.
    mesh: Option<PathBuf>,
    /// The picture: .png, or .exr with depth, normal and number of the patch or tile behind every pixel.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The level of all patches: each is divided into 2^(level + 1) − 1 quads a side.
    #[arg(short, long, value_name = "LEVEL", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_LEVEL)))]
    level: u32,
    /// Choose the level of every patch, so that triangles are at most this far from the surface on the picture; tiles are
    /// divided so by half a pixel if nothing else is said.
    #[arg(long, value_name = "PIXELS", conflicts_with_all = ["level", "cells"])]
    tolerance: Option<f64>,
    /// Cells along an edge of a mesh that tiles are divided into: a power of two from 2 to 256.
    #[arg(long, value_name = "COUNT")]
    cells: Option<u32>,
    /// Colour tiles by what they hold: nothing, one height everywhere, or more.
    #[arg(long)]
    tiles: bool,
    /// Let the light throw shadows.
    #[arg(long)]
    shadows: bool,
    /// Patches of a draw.
    #[arg(long, value_name = "COUNT", default_value_t = 16)]
    per_draw: u32,
    /// Where control points are kept.
    #[arg(long, value_enum, default_value = "uniform")]
    storage: StorageName,
    /// Measure which level, storage and number of patches a draw the device draws 60 frames a second with, draw with
    /// these, and print what was measured.
    #[arg(long, conflicts_with_all = ["level", "tolerance", "storage", "per_draw"])]
    tune: bool,
    /// What draws.
    #[arg(long, value_enum, default_value = "gpu")]
    device: Kind,
    #[command(flatten)]
    adapter: Adapter,
    /// The axis that points up.
    #[arg(long, value_enum, default_value = "z")]
    up: Axis,
    /// Pixels of the picture: WIDTHxHEIGHT.
    #[arg(long, value_name = "PIXELS", value_parser = crate::args::numbers::pixels, default_value = "640x480")]
    size: [u32; 2],
    /// Colours that are taken in every pixel.
    #[arg(long, value_name = "COUNT", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=256))]
    samples: u32,
    /// Draw the edges of triangles.
    #[arg(long)]
    wireframe: bool,
    #[command(flatten)]
    isolation: crate::args::limits::Isolation,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum StorageName {
    Uniform,
    Texture,
    Buffer,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let extension = arguments.output.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    if !matches!(extension.as_deref(), Some("png" | "exr")) {
        return Err(Error::unsupported("the format to write is not known")
            .at(arguments.output.display().to_string())
            .advise("use the extension .png or .exr")
            .into());
    }
    let context = crate::context(arguments.memory_limit)?;
    let device = arguments.adapter.open(arguments.device, arguments.memory_limit)?;
    let is_mesh = surface::is_document(&arguments.file) || !relievo_meshio::holds_patches(&arguments.file)?;
    let frame = match is_mesh {
        true => surface::drawn(&context, arguments, device.as_ref())?,
        false => patches(&context, arguments, device.as_ref())?,
    };
    match extension.as_deref() {
        Some("exr") => frame.write_exr(&arguments.output)?,
        _ => write_png(&arguments.output, &frame.color)?,
    }
    Ok(ExitCode::SUCCESS)
}

/// The view that shows all.
fn view(arguments: &Arguments, showing: &Showing) -> View {
    let switch = |on: bool| if on { Switch::ON } else { Switch::OFF };
    let mut view = View::new(showing.camera);
    view.lights = showing.lights.clone();
    [view.settings.width, view.settings.height] = arguments.size;
    view.settings.samples = arguments.samples;
    view.settings.sky_rays = 0;
    view.settings.shadows = switch(arguments.shadows);
    view.settings.wireframe = switch(arguments.wireframe);
    view
}

fn patches(context: &Context, arguments: &Arguments, device: Option<&Device>) -> Result<Frame> {
    let surface = crate::mesh::tessellate::surface(context, &arguments.file)?;
    let showing = Showing::new(surface.total_bounds(), arguments.up.into(), arguments.size)?;
    let view = view(arguments, &showing);
    let levels = match arguments.tolerance {
        Some(tolerance) => {
            Levels::select(context, &surface, &view.viewpoint(&DAffine3::IDENTITY), tolerance, MAX_LEVEL)?
        }
        None => Levels::uniform(&surface, arguments.level)?,
    };
    match device {
        Some(device) => rasterized(device, arguments, &surface, &levels, &view, &showing),
        None => cast(context, &surface, &levels, &view, &showing),
    }
}

fn rasterized(
    device: &Device,
    arguments: &Arguments,
    surface: &BezierSurface,
    levels: &Levels,
    view: &View,
    showing: &Showing,
) -> Result<Frame> {
    let storage = match arguments.storage {
        StorageName::Uniform => Storage::Uniform,
        StorageName::Texture => Storage::Texture,
        StorageName::Buffer => Storage::Buffer,
    };
    let mut rasterizer = Rasterizer::new(device)?;
    let patches = if arguments.tune {
        let tuned = rasterizer.tune(device, surface, view, &showing.material, &Tuning::default())?;
        let mut text = format!("{}\nlevel  storage  N_d  N_DP  ms\n", device.summary());
        for way in &tuned.all {
            let mark = if *way == tuned.best { "  <" } else { "" };
            let name = way.storage.name();
            let time = 1e3 * way.time.as_secs_f64();
            text += &format!("{:5}  {name:7} {:4} {:5}  {time:.3}{mark}\n", way.level, way.per_draw, way.draw_calls);
        }
        crate::print(&text)?;
        let best = tuned.best;
        let levels = Levels::uniform(surface, best.level)?;
        VirtualVertices::new(device, surface, &levels, best.storage, best.per_draw)?
    } else {
        VirtualVertices::new(device, surface, levels, storage, arguments.per_draw)?
    };
    eprintln!("{}: {} patches in {} draws", device.summary(), surface.count(), patches.draws().len());
    rasterizer.render(&[Placed::new(Shape::Patches(&patches), showing.material)], view)
}

/// The same triangles by rays.
fn cast(context: &Context, surface: &BezierSurface, levels: &Levels, view: &View, showing: &Showing) -> Result<Frame> {
    let tessellation = surface.tessellate(context, levels)?;
    let mut scene = Scene::new()?;
    let object = scene.add_object(DAffine3::IDENTITY, showing.material)?;
    let (points, triangles, normals) = (tessellation.points, tessellation.triangles, tessellation.normals);
    scene.set_mesh(object, 0, Mesh { points, triangles, normals, ..Mesh::default() })?;
    scene.render(context, view)
}
