//! `relievo crowd render`: what a view draws of a crowd, by rays.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use glam::{DAffine3, DVec3};
use relievo_core::{Error, Result};
use relievo_crowd::{Blend, Cluster};
use relievo_render::color::{categories, from_hex};
use relievo_render::{FalseColor, Image, Lights, Material, Mesh, Sky, Sun, View, draw_legend, write_png};
use relievo_scene::walking::StandIns;

use super::scene::{Scene, SceneArguments};
use crate::Outcome;

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
    /// How bones are blended.
    #[arg(long, value_enum, default_value = "linear")]
    blend: BlendName,
    /// Rays from the camera per pixel.
    #[arg(long, value_name = "N", default_value_t = 4)]
    samples: u32,
    /// Draw the edges of triangles.
    #[arg(long)]
    wireframe: bool,
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

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum BlendName {
    /// Weighted sums of matrices.
    Linear,
    /// Weighted sums of dual quaternions.
    Dual,
}

/// Colours of levels from the finest to the coarsest (cividis, which the colour-blind can read).
const LEVELS: [(u32, &str); 7] = [
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
/// Colours of materials or agents, in turn.
const MATERIALS: [u32; 6] = [0xd9a441, 0x5b7b9a, 0x9a5b4f, 0x6f8f5f, 0xc9c2b2, 0x4a4a52];

pub fn run(arguments: &Arguments) -> Outcome {
    let mut scene = arguments.scene.open()?;
    let mut picture = relievo_render::Scene::new()?;
    add_ground(&scene, &mut picture)?;
    let mut view = View::new(scene.camera);
    view.lights = Lights {
        suns: vec![Sun { direction: [-0.5, 0.8, 0.6], irradiance: [2.6, 2.45, 2.2], angular_radius: 0.01 }],
        sky: Sky { up: [0.0, 1.0, 0.0], ..Lights::default().sky },
    };
    let [width, height] = arguments.scene.size;
    let rows = height.checked_mul(arguments.scene.frames).ok_or_else(|| {
        Error::invalid("the picture of all frames has too many rows").at("--frames").advise("render fewer frames")
    })?;
    let mut strip = Image::new(width, rows, 3)?;
    [view.settings.width, view.settings.height] = [width, height];
    view.settings.samples = arguments.samples;
    view.settings.wireframe = relievo_core::parameter::Switch(u32::from(arguments.wireframe));
    view.settings.false_color = 1.0;
    view.false_color = Some(FalseColor { palette: palette(arguments.show) });
    let (mut text, mut first) = (format!("{}\n", arguments.output.display()), 0);
    let mut stand_ins = StandIns::default();
    arguments.scene.for_each_frame(&mut scene, |scene, shown| {
        let blend = match arguments.blend {
            BlendName::Linear => Blend::Linear,
            BlendName::Dual => Blend::DualQuaternion,
        };
        let tag = |agent: u32, cluster: &Cluster, number: u32, material: u32| match arguments.show {
            Show::Shaded => material,
            Show::Agents => agent,
            Show::Clusters => number,
            Show::Levels => cluster.depth.min(LEVELS.len() as u32 - 1),
        };
        let crowd = &scene.crowd;
        stand_ins.show(
            &scene.context,
            &mut picture,
            (crowd, &shown.frame, shown.time, scene.camera.eye),
            blend,
            MATERIAL,
            &tag,
        )?;
        let mut frame = picture.render(&scene.context, &view)?;
        if arguments.show == Show::Levels {
            let entries: Vec<_> = LEVELS.iter().map(|(color, label)| (from_hex(*color), *label)).collect();
            draw_legend(&mut frame.color, &entries);
        }
        let count = frame.color.data().len();
        strip.data_mut()[first..first + count].copy_from_slice(frame.color.data());
        first += count;
        let agents = crowd.agents().len();
        text += &format!("{} of {agents} agents, {} triangles\n", shown.frame.drawn.len(), shown.frame.triangles);
        Ok(())
    })?;
    write_png(&arguments.output, &strip)?;
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn palette(show: Show) -> Vec<[f32; 3]> {
    match show {
        Show::Shaded | Show::Agents => MATERIALS.map(from_hex).to_vec(),
        Show::Clusters => categories().to_vec(),
        Show::Levels => LEVELS.map(|(color, _)| from_hex(color)).to_vec(),
    }
}

/// Adds a square of ground that reaches far beyond the crowd.
fn add_ground(scene: &Scene, picture: &mut relievo_render::Scene) -> Result<()> {
    let places = || scene.crowd.agents().iter().map(|agent| agent.transform.translation);
    let middle = places().sum::<DVec3>() / places().count().max(1) as f64;
    let far = places().map(|place| place.distance(middle)).fold(scene.camera.eye.distance(middle), f64::max);
    let half = (20.0 * far) as f32;
    let material = Material { base_color: [0.42, 0.41, 0.39], specular: 0.0, roughness: 1.0 };
    let at = DVec3::new(middle.x, scene.ground, middle.z);
    let ground = picture.add_object(DAffine3::from_translation(at), material)?;
    let points = vec![[-half, 0.0, -half], [-half, 0.0, half], [half, 0.0, half], [half, 0.0, -half]];
    picture.set_mesh(ground, 0, Mesh { points, triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() })
}
