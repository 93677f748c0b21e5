//! A crowd in the window: what a view draws of it within an error in pixels that a slider sets.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use relievo_core::{Context, Result};
use relievo_crowd::{
    Agent, Crowd, CrowdModel, CrowdView, Frame, PoseKey, Walker, parse_walkers, read_walkers, skin, skin_normals,
    square,
};
use relievo_render::Mesh;
use relievo_render::color::{Color, categories, from_hex};
use relievo_view::show::{Eye, Frames, Picture, Range, Setting, Subject};

use crate::crowd::picture::{LEVELS, MATERIALS};

/// Frames that are played; clips repeat.
const FRAMES: usize = 240;

/// Frames a second.
const RATE: f64 = 24.0;

/// Distance between agents of a square, in diagonals of the model.
const SPACING: f64 = 0.8;

/// What colours stand for.
const SHOWN: [&str; 4] = ["materials", "agents", "clusters", "error"];

/// The number that a vertex of a model got in the mesh, for which of the clusters that were added and in which colour.
#[derive(Clone, Copy, Default)]
struct Number {
    made: u64,
    color: Color,
    number: u32,
}

/// A crowd over time.
pub struct Walkers {
    context: Context,
    name: String,
    crowd: Crowd,
    walkers: Vec<Walker>,
    frame: Frame,
}

impl Walkers {
    /// Opens a model with the agents of a file, or so many of them on a square.
    pub fn open(context: Context, path: &Path, agents: Option<&Path>, count: usize) -> Result<Self> {
        let model = Arc::new(CrowdModel::load(&context, path)?);
        let walkers = match agents {
            Some(agents) => read_walkers(&context, agents, &[&*model])?,
            None => parse_walkers(&square(&model, count, SPACING * f64::from(model.size())), &[&*model])?,
        };
        let mut crowd = Crowd::new(vec![model]);
        for (index, walker) in walkers.iter().enumerate() {
            crowd.add(walker.agent).map_err(|error| error.at(format!("agent {index}")))?;
        }
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Ok(Self { context, name, crowd, walkers, frame: Frame::default() })
    }
}

/// Makes the mesh of what a frame draws of a crowd at `time` seconds. `color` returns the colour of a triangle's points for an
/// agent, a cluster, its number of simplifications and a material.
pub fn mesh(
    context: &Context,
    (crowd, frame): (&Crowd, &Frame),
    time: f64,
    color: impl Fn(u32, u32, u32, u32) -> Color,
) -> Result<Mesh> {
    let mut poses: HashMap<PoseKey, [Vec<[f32; 3]>; 2]> = HashMap::new();
    let mut mesh = Mesh::default();
    let (mut numbers, mut made) = (Vec::<Number>::new(), 0);
    for drawn in &frame.drawn {
        let agent = &crowd.agents()[drawn.0 as usize];
        let model = &crowd.models()[agent.model as usize];
        let key = crowd.pose_key(drawn.0, time);
        let [points, normals] = match poses.entry(key) {
            Entry::Occupied(posed) => &*posed.into_mut(),
            Entry::Vacant(place) => {
                let pose = crowd.posed(&key);
                let points = skin(context, &model.character, &pose, model.blend)?;
                let normals = skin_normals(context, &model.character, &pose, model.blend)?;
                &*place.insert([points, normals])
            }
        };
        let turn = agent.transform.matrix3.inverse().transpose();
        for number in crowd.clusters(frame, *drawn) {
            let cluster = model.clusters[*number as usize];
            let materials = &model.character.materials[cluster.first as usize..];
            // Clusters may differ in colour where they share vertices.
            made += 1;
            if numbers.len() < points.len() {
                numbers.resize(points.len(), Number::default());
            }
            for (triangle, material) in model.triangles(*number).iter().zip(materials) {
                let color = color(drawn.0, *number, cluster.depth, *material);
                mesh.triangles.push(triangle.map(|vertex| {
                    let found = &mut numbers[vertex as usize];
                    if (found.made, found.color) != (made, color) {
                        *found = Number { made, color, number: mesh.points.len() as u32 };
                        let at = |list: &[[f32; 3]]| glam::Vec3::from(list[vertex as usize]).as_dvec3();
                        mesh.points.push(agent.transform.transform_point3(at(points)).as_vec3().to_array());
                        if !normals.is_empty() {
                            let normal = (turn * at(normals)).normalize_or(DVec3::Y);
                            mesh.normals.push(normal.as_vec3().to_array());
                        }
                        mesh.colors.push(color);
                    }
                    found.number
                }));
            }
        }
    }
    Ok(mesh)
}

/// Returns smallest and largest coordinates of a crowd, by the places of its agents; `None` without agents.
pub fn bounds(crowd: &Crowd) -> Option<[DVec3; 2]> {
    let reach = |agent: &Agent| {
        let scale = agent.transform.matrix3.determinant().abs().cbrt();
        DVec3::splat(0.5 * scale * f64::from(crowd.models()[agent.model as usize].size()))
    };
    let low = crowd.agents().iter().map(|agent| agent.transform.translation - reach(agent)).reduce(DVec3::min)?;
    let high = crowd.agents().iter().map(|agent| agent.transform.translation + reach(agent)).reduce(DVec3::max)?;
    Some([low, high])
}

impl Subject for Walkers {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn frames(&self) -> Frames {
        Frames { count: FRAMES, rate: RATE }
    }

    fn follows_the_eye(&self) -> bool {
        true
    }

    fn bounds(&self) -> Option<[DVec3; 2]> {
        bounds(&self.crowd)
    }

    fn settings(&self) -> Vec<Setting> {
        vec![
            Setting {
                name: "Error".into(),
                hint: "Pixels that what is drawn may differ from the model".into(),
                range: Range::Slider { least: 0.1, most: 50.0, is_logarithmic: true, is_whole: false },
                value: 0.5,
            },
            Setting {
                name: "Colours show".into(),
                hint: "Of the error: how often a cluster was simplified".into(),
                range: Range::Choice(SHOWN.map(str::to_owned).to_vec()),
                value: 0.0,
            },
        ]
    }

    fn picture(&mut self, frame: usize, values: &[f64], eye: &Eye) -> Result<Picture> {
        let [error, shown] = [0, 1].map(|at| values.get(at).copied().unwrap_or_default());
        let time = frame as f64 / RATE;
        for (index, walker) in (0..).zip(&self.walkers) {
            self.crowd.set(index, walker.at(time))?;
        }
        let view = CrowdView::perspective(eye.place, eye.axes, eye.fov, eye.size, error as f32)?;
        self.crowd.cut(&self.context, &view, &mut self.frame)?;
        let categories = categories();
        let materials = MATERIALS.map(from_hex);
        let levels = LEVELS.map(|(hex, _)| from_hex(hex));
        let color = |agent: u32, number: u32, depth: u32, material: u32| match shown as usize {
            1 => categories[agent as usize % categories.len()],
            2 => categories[number as usize % categories.len()],
            3 => levels[(depth as usize).min(levels.len() - 1)],
            _ => materials[material as usize % materials.len()],
        };
        let mut picture =
            Picture { mesh: mesh(&self.context, (&self.crowd, &self.frame), time, color)?, ..Picture::default() };
        if shown as usize == 3 {
            picture.legend = levels.into_iter().zip(LEVELS.map(|(_, text)| text.to_owned())).collect();
        }
        let input = |agent: &relievo_crowd::Agent| u64::from(self.crowd.models()[agent.model as usize].input_triangles);
        let full: u64 = self.crowd.agents().iter().map(input).sum();
        picture.facts = vec![
            format!("{} of {} agents in view", self.frame.drawn.len(), self.crowd.agents().len()),
            format!("{} of {full} triangles", self.frame.triangles),
        ];
        Ok(picture)
    }
}
