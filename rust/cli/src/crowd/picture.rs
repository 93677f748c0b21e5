//! `relievo crowd render`: what a view draws of a crowd, by rays.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use glam::{DAffine3, DVec3};
use relievo_core::parameter::Switch;
use relievo_core::{Error, Result};
use relievo_crowd::{Cluster, CrowdModel};
use relievo_gpu::Device;
use relievo_render::color::{categories, from_hex};
use relievo_render::virtual_vertex::{DeviceMesh, Placed, Rasterizer, Shape};
use relievo_render::{FalseColor, Image, Lights, Material, Mesh, Sky, Sun, View, draw_legend, write_png};
use relievo_scene::walking::{DeviceStandIns, Look, StandIns, with_shadows};

use super::scene::{Scene, SceneArguments};
use crate::Outcome;
use crate::args::device::{Adapter, Device as Kind};

const EXAMPLE: &str = "Example: relievo crowd render robot.rcrowd --square 1000 -o crowd.png --show clusters";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// The picture: a .png. Several frames are one below the other.
    #[arg(short, long, value_name = "FILE.png")]
    output: PathBuf,
    /// What the picture shows.
    #[arg(long, value_enum, default_value = "shaded")]
    show: Show,
    /// Rays from the camera per pixel.
    #[arg(long, value_name = "N", default_value_t = 4)]
    samples: u32,
    /// Draw the edges of triangles.
    #[arg(long)]
    wireframe: bool,
    /// Light without shadows, and as if nothing hid the sky.
    #[arg(long)]
    unshadowed: bool,
    /// What cuts, poses and draws the crowd. On a graphics device suns throw shadows by maps, and nothing hides the sky.
    #[arg(long, value_enum, default_value = "cpu")]
    device: Kind,
    #[command(flatten)]
    adapter: Adapter,
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Show {
    /// Surfaces in the light, a colour for each material.
    Shaded,
    /// The same with a colour for each agent, of six.
    Agents,
    /// A colour for each cluster.
    Clusters,
    /// A colour for each number of simplifications.
    Levels,
}

/// Colours of levels from the finest to the coarsest (cividis, which the colour-blind can read).
pub const LEVELS: [(u32, &str); 7] = [
    (0xffea46, "input"),
    (0xcbba69, "1"),
    (0x958f78, "2"),
    (0x7c7b78, "3"),
    (0x666970, "4"),
    (0x31446b, "5"),
    (0x00204d, "6 and more"),
];
/// What agents are made of, beside their colour.
const MATERIAL: Material = Material { base_color: [0.6; 3], specular: 0.02, roughness: 0.6 };
const GROUND: Material = Material { base_color: [0.42, 0.41, 0.39], specular: 0.0, roughness: 1.0 };
/// Colours of materials or agents, in turn.
pub const MATERIALS: [u32; 6] = [0xd9a441, 0x5b7b9a, 0x9a5b4f, 0x6f8f5f, 0xc9c2b2, 0x4a4a52];

pub fn run(arguments: &Arguments) -> Outcome {
    let mut scene = arguments.scene.open()?;
    let mut view = View::new(scene.camera);
    view.lights = Lights {
        suns: vec![Sun { direction: [-0.5, 0.8, 0.6], irradiance: [2.6, 2.45, 2.2], angular_radius: 0.01 }],
        sky: Sky { up: [0.0, 1.0, 0.0], ..Lights::default().sky },
    };
    let [width, height] = arguments.scene.size;
    let rows = height.checked_mul(arguments.scene.frames).ok_or_else(|| {
        Error::invalid("the picture of all frames has too many rows").at("--frames").advise("render fewer frames")
    })?;
    let mut strip = Strip { image: Image::new(width, rows, 3)?, filled: 0, text: String::new(), show: arguments.show };
    [view.settings.width, view.settings.height] = [width, height];
    view.settings.samples = arguments.samples;
    view.settings.wireframe = Switch(u32::from(arguments.wireframe));
    view.settings.false_color = 1.0;
    view.false_color = Some(FalseColor { palette: palette(arguments.show) });
    let device = arguments.adapter.open(arguments.device, arguments.scene.limits.memory_limit)?;
    if arguments.unshadowed {
        (view.settings.shadows, view.settings.sky_rays) = (Switch::OFF, 0);
    }
    strip.text = format!("{}\n", arguments.output.display());
    if device.is_some() {
        // Nothing hides the sky there.
        view.settings.sky_rays = 0;
    }
    scene.view = with_shadows(&scene.crowd, &scene.view, &view);
    if !arguments.unshadowed && scene.show_hidden() {
        eprintln!("note: agents that others hide throw shadows: --occlusion leaves none out without --unshadowed");
    }
    match device {
        Some(device) => on_device(arguments, &device, &mut scene, &view, &mut strip)?,
        None => by_rays(arguments, &mut scene, &view, &mut strip)?,
    }
    write_png(&arguments.output, &strip.image)?;
    crate::print(&strip.text)?;
    Ok(ExitCode::SUCCESS)
}

/// Frames, one below the other, with a line on each.
struct Strip {
    image: Image,
    /// Numbers of the frames before.
    filled: usize,
    text: String,
    show: Show,
}

impl Strip {
    /// Adds a frame that shows some of the agents by some triangles.
    fn add(&mut self, mut color: Image, [shown, agents, triangles]: [u64; 3]) {
        if self.show == Show::Levels {
            let entries: Vec<_> = LEVELS.iter().map(|(color, label)| (from_hex(*color), *label)).collect();
            draw_legend(&mut color, &entries);
        }
        let count = color.data().len();
        self.image.data_mut()[self.filled..self.filled + count].copy_from_slice(color.data());
        self.filled += count;
        self.text += &format!("{shown} of {agents} agents, {triangles} triangles\n");
    }
}

fn tag(show: Show, agent: u32, cluster: &Cluster, number: u32, material: u32) -> u32 {
    match show {
        Show::Shaded => material,
        Show::Agents => agent,
        Show::Clusters => number,
        Show::Levels => cluster.depth.min(LEVELS.len() as u32 - 1),
    }
}

fn by_rays(arguments: &Arguments, scene: &mut Scene, view: &View, strip: &mut Strip) -> Result<()> {
    let mut picture = relievo_render::Scene::new()?;
    let (at, mesh) = ground(scene);
    let object = picture.add_object(at, GROUND)?;
    picture.set_mesh(object, 0, mesh)?;
    let mut stand_ins = StandIns::default();
    arguments.scene.for_each_frame(scene, |scene, shown| {
        let tag = |agent: u32, cluster: &Cluster, number: u32, material: u32| {
            tag(arguments.show, agent, cluster, number, material)
        };
        let frame = (&scene.crowd, &shown.frame, shown.time, scene.camera.eye);
        stand_ins.show(&scene.context, &mut picture, frame, MATERIAL, &tag)?;
        let color = picture.render(&scene.context, view)?.color;
        if let Some(missing) = scene.crowd.stream().map(|stream| stream.counts().missing).filter(|count| *count > 0) {
            eprintln!("note: {missing} clusters are not in memory: parts are coarser than --pixels says");
        }
        let agents = scene.crowd.agents().len() as u64;
        strip.add(color, [shown.frame.drawn.len() as u64, agents, shown.frame.triangles]);
        Ok(())
    })
}

/// Cuts, poses and draws all frames on a device.
fn on_device(arguments: &Arguments, device: &Device, scene: &mut Scene, view: &View, strip: &mut Strip) -> Result<()> {
    let tag = |model: &CrowdModel, number: u32, material: u32| {
        tag(arguments.show, 0, &model.clusters[number as usize], number, material)
    };
    let by_cluster: Option<&dyn Fn(&CrowdModel, u32, u32) -> u32> = match arguments.show {
        Show::Agents => None,
        Show::Shaded | Show::Clusters | Show::Levels => Some(&tag),
    };
    let look = Look { tag: by_cluster, lines: arguments.wireframe };
    let mut stand_ins = DeviceStandIns::new(device, &scene.crowd, look)?;
    let mut rasterizer = Rasterizer::new(device)?;
    let (at, mesh) = ground(scene);
    let mesh = DeviceMesh::new(device, &mesh, &GROUND)?;
    let ground = Placed { transform: at, throws_shadows: false, ..Placed::new(Shape::Mesh(&mesh), GROUND) };
    for time in arguments.scene.times() {
        scene.walk(time)?;
        let pixels = scene.pixels();
        let pixels = scene.has_occlusion().then_some(&pixels);
        let counts = stand_ins.update(&scene.context, &scene.crowd, (&scene.view, time), pixels)?;
        let [clusters, quads] = stand_ins.placed(MATERIAL);
        let color = rasterizer.render(&[ground, clusters, quads], view)?.color;
        let agents = scene.crowd.agents().len() as u64;
        strip.add(color, [u64::from(counts.agents + counts.impostors), agents, u64::from(counts.triangles)]);
    }
    Ok(())
}

fn palette(show: Show) -> Vec<[f32; 3]> {
    match show {
        Show::Shaded | Show::Agents => MATERIALS.map(from_hex).to_vec(),
        Show::Clusters => categories().to_vec(),
        Show::Levels => LEVELS.map(|(color, _)| from_hex(color)).to_vec(),
    }
}

/// Returns a square of ground that reaches far beyond the crowd, and where it is.
fn ground(scene: &Scene) -> (DAffine3, Mesh) {
    let places = || scene.crowd.agents().iter().map(|agent| agent.transform.translation);
    let middle = places().sum::<DVec3>() / places().count().max(1) as f64;
    let far = places().map(|place| place.distance(middle)).fold(scene.camera.eye.distance(middle), f64::max);
    let half = (20.0 * far) as f32;
    let points = vec![[-half, 0.0, -half], [-half, 0.0, half], [half, 0.0, half], [half, 0.0, -half]];
    let mesh = Mesh { points, triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() };
    (DAffine3::from_translation(DVec3::new(middle.x, scene.ground, middle.z)), mesh)
}
