//! `relievo crowd render`: what a view draws of a crowd, by rays.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use glam::{DAffine3, DVec3};
use relievo_core::Result;
use relievo_crowd::{Blend, skin, skin_normals};
use relievo_render::color::{categories, from_hex};
use relievo_render::{FalseColor, Lights, Material, Mesh, Sky, Sun, View, draw_legend, write_png};

use super::scene::{Scene, SceneArguments};
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo crowd render robot.rcrowd --square 1000 -o crowd.png --show clusters";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// The picture: a .png.
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
/// Colours of materials, in turn.
const MATERIALS: [u32; 6] = [0xd9a441, 0x5b7b9a, 0x9a5b4f, 0x6f8f5f, 0xc9c2b2, 0x4a4a52];

/// A character in a pose.
struct Posed {
    points: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let scene = arguments.scene.open()?;
    let mut picture = relievo_render::Scene::new()?;
    add_ground(&scene, &mut picture)?;
    add_agents(&scene, arguments, &mut picture)?;
    let mut view = View::new(scene.camera);
    view.lights = Lights {
        suns: vec![Sun { direction: [-0.5, 0.8, 0.6], irradiance: [2.6, 2.45, 2.2], angular_radius: 0.01 }],
        sky: Sky { up: [0.0, 1.0, 0.0], ..Lights::default().sky },
    };
    [view.settings.width, view.settings.height] = arguments.scene.size;
    view.settings.samples = arguments.samples;
    view.settings.wireframe = relievo_core::parameter::Switch(u32::from(arguments.wireframe));
    view.settings.false_color = 1.0;
    view.false_color = Some(FalseColor { palette: palette(arguments.show) });
    let mut frame = picture.render(&scene.context, &view)?;
    if arguments.show == Show::Levels {
        let entries: Vec<_> = LEVELS.iter().map(|(color, label)| (from_hex(*color), *label)).collect();
        draw_legend(&mut frame.color, &entries);
    }
    write_png(&arguments.output, &frame.color)?;
    let text = format!(
        "{}\n{} of {} agents, {} triangles\n",
        arguments.output.display(),
        scene.frame.drawn.len(),
        scene.crowd.agents().len(),
        scene.frame.triangles
    );
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn palette(show: Show) -> Vec<[f32; 3]> {
    match show {
        Show::Shaded => MATERIALS.map(from_hex).to_vec(),
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

fn add_agents(scene: &Scene, arguments: &Arguments, picture: &mut relievo_render::Scene) -> Result<()> {
    let blend = match arguments.blend {
        BlendName::Linear => Blend::Linear,
        BlendName::Dual => Blend::DualQuaternion,
    };
    let crowd = &scene.crowd;
    // Agents in the same pose share it.
    let mut poses: HashMap<(u32, u32, usize), Posed> = HashMap::new();
    for drawn in &scene.frame.drawn {
        let agent = &crowd.agents()[drawn.0 as usize];
        let model = &crowd.models()[agent.model as usize];
        let number = crowd.pose(agent, arguments.scene.time);
        let key = (agent.model, agent.clip, number);
        let posed = match poses.entry(key) {
            Entry::Occupied(posed) => posed.into_mut(),
            Entry::Vacant(place) => {
                let pose = &model.clips[agent.clip as usize].poses[number];
                let points = skin(&scene.context, &model.character, pose, blend)?;
                let normals = skin_normals(&scene.context, &model.character, pose, blend)?;
                place.insert(Posed { points, normals })
            }
        };
        let mut mesh = Mesh::default();
        let mut numbers = HashMap::new();
        for cluster in crowd.clusters(&scene.frame, *drawn) {
            let found = model.clusters[*cluster as usize];
            let materials = &model.character.materials[found.first as usize..];
            for (triangle, material) in model.triangles(*cluster).iter().zip(materials) {
                mesh.triangles.push(triangle.map(|vertex| {
                    *numbers.entry(vertex).or_insert_with(|| {
                        mesh.points.push(posed.points[vertex as usize]);
                        mesh.normals.extend(posed.normals.get(vertex as usize));
                        mesh.points.len() as u32 - 1
                    })
                }));
                mesh.tags.push(match arguments.show {
                    Show::Shaded => *material,
                    Show::Clusters => *cluster,
                    Show::Levels => found.depth.min(LEVELS.len() as u32 - 1),
                });
            }
        }
        let material = Material { base_color: [0.6; 3], specular: 0.02, roughness: 0.6 };
        let object = picture.add_object(agent.transform, material)?;
        picture.set_mesh(object, 0, mesh)?;
    }
    Ok(())
}
