//! Crowds of a scene: agents of an articulated model, which pictures draw by the triangles that the view deserves.
//!
//! Agents are in no cache: where they are follows from the time alone. The ray caster draws them, in scenes for graphics
//! devices too; `relievo crowd render` draws them on devices as well. Crowds that a collider names press into surfaces.

mod device;
mod pressing;

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Result};
use relievo_crowd::{
    Agent, BuildSettings, Cluster, Crowd, CrowdModel, CrowdView, Drawn, Frame, Impostor, Impostors, PoseKey, ShadowSun,
    Walker, read_walkers, skin, skin_normals,
};
use relievo_render as render;

pub use self::device::{DeviceCounts, DeviceStandIns};
pub(crate) use self::pressing::Pressing;
pub use relievo_crowd::Look;

use crate::format::description::{CrowdEntry, Scene};
use crate::state::paths::Paths;
use crate::state::world::World;

/// Radii of the largest agent within which agents out of sight hide the sky: beyond, one hides at most a sixty-fourth of it.
const AROUND: f32 = 8.0;

/// Bytes that a triangle of an agent takes in a picture: corners, vertices and Embree's tree.
const TRIANGLE_BYTES: u64 = 192;
/// Bytes that an agent takes in a picture besides.
const AGENT_BYTES: u64 = 4096;

/// A crowd of a scene: its model and where its agents start.
#[derive(Debug)]
pub(crate) struct Loaded {
    model: Arc<CrowdModel>,
    walkers: Vec<Walker>,
    /// From metres with y up to the units and the axes of the scene.
    space: DAffine3,
}

impl Loaded {
    /// Reads the list of agents, and reads or builds the model.
    ///
    /// # Errors
    /// A file cannot be read, is damaged, has no triangles or no such clip; a line of the list is unusable.
    pub fn new(context: &Context, paths: &Paths, scene: &Scene, entry: &CrowdEntry) -> Result<Self> {
        let model = model(context, &paths.resolve(&entry.file.text)?, entry)?;
        let walkers = read_walkers(context, &paths.resolve(&entry.agents.text)?, &[&model])?;
        let space = DAffine3::from_mat3(scene.up.from_y_up() * (1.0 / scene.metres));
        let loaded = Self { model: Arc::new(model), walkers, space };
        // Agents that cannot be placed are found before the first frame.
        loaded.crowd(0.0)?;
        Ok(loaded)
    }

    /// Returns the crowd at a time, seconds.
    fn crowd(&self, time: f64) -> Result<Crowd> {
        let mut crowd = Crowd::new(vec![Arc::clone(&self.model)]);
        for (index, agent) in self.agents(time).enumerate() {
            crowd.add(agent).map_err(|error| error.at(format!("agent {index}")))?;
        }
        Ok(crowd)
    }

    /// Returns the agents at a time, seconds, in the space of the scene.
    fn agents(&self, time: f64) -> impl Iterator<Item = Agent> + '_ {
        self.walkers.iter().map(move |walker| self.placed(walker.at(time)))
    }

    /// Returns an agent in the space of the scene.
    fn placed(&self, agent: Agent) -> Agent {
        Agent { transform: self.space * agent.transform, ..agent }
    }

    /// Returns the number of agents.
    pub fn len(&self) -> usize {
        self.walkers.len()
    }
}

impl World {
    /// Makes a crowd of the scene, with its agents where they are at the start.
    ///
    /// # Errors
    /// There is no crowd of this number.
    pub fn crowd(&self, index: usize) -> Result<Crowd> {
        self.crowds().get(index).ok_or_else(|| missing(index))?.crowd(0.0)
    }

    /// Moves the agents of a crowd that [`Self::crowd`] made to where they are at `time` seconds.
    ///
    /// # Errors
    /// There is no crowd of this number, or `crowd` is another one.
    pub fn walk(&self, index: usize, time: f64, crowd: &mut Crowd) -> Result<()> {
        let loaded = self.crowds().get(index).ok_or_else(|| missing(index))?;
        (0..).zip(loaded.agents(time)).try_for_each(|(agent, walker)| crowd.set(agent, walker))
    }
}

fn missing(index: usize) -> Error {
    Error::invalid(format!("the scene has no crowd {index}"))
}

/// Reads a crowd model, or builds it of a character.
fn model(context: &Context, path: &Path, entry: &CrowdEntry) -> Result<CrowdModel> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("rcrowd")) {
        return match &entry.clip {
            None => CrowdModel::load(context, path),
            Some(_) => Err(Error::invalid("a crowd model has its clips already")
                .at(path.display().to_string())
                .advise("remove `clip`: the list of agents says which clip each agent plays")),
        };
    }
    let source = relievo_meshio::read_model(context, path)?;
    let clips = match &entry.clip {
        Some(clip) => vec![source.animation(&clip.text)?],
        None => (0..source.animations.len()).collect(),
    };
    let made = CrowdModel::build(context, &source, &clips, &BuildSettings::default(), &mut Silent);
    made.map_err(|error| error.at(path.display().to_string()))
}

/// A crowd in pictures.
#[derive(Debug)]
pub(crate) struct Shown {
    crowd: Crowd,
    stand_ins: StandIns,
    frame: Frame,
}

impl Shown {
    /// Makes a crowd of which nothing is drawn yet. Fails if an agent cannot be placed.
    pub fn new(loaded: &Loaded) -> Result<Self> {
        Ok(Self { crowd: loaded.crowd(0.0)?, stand_ins: StandIns::default(), frame: Frame::default() })
    }

    /// Moves the agents to where they are at `time` and puts what `view` draws of them into a picture. All have the false
    /// colour `tag`. Returns the number of triangles. Fails if the view is not finite, or memory does not suffice.
    pub fn draw(
        &mut self,
        context: &Context,
        (loaded, entry): (&Loaded, &CrowdEntry),
        (view, time): (&render::View, f64),
        tag: u32,
        picture: &mut render::Scene,
    ) -> Result<u64> {
        for (index, agent) in (0..).zip(loaded.agents(time)) {
            self.crowd.set(index, agent)?;
        }
        let (camera, settings) = (&view.camera, &view.settings);
        let size = [settings.width, settings.height];
        let seen = CrowdView::perspective(camera.eye, camera.axes, camera.fov, size, entry.pixels)?;
        let seen = with_shadows(&self.crowd, &seen, view);
        self.crowd.cut(context, &seen, &mut self.frame)?;
        let base_color = entry.colour.map(|value| value.min(1.0));
        let material = render::Material { base_color, ..render::Material::default() };
        let shown = (&self.crowd, &self.frame, time, camera.eye);
        self.stand_ins.show(context, picture, shown, material, &|_, _, _, _| tag)?;
        Ok(self.frame.triangles)
    }
}

/// Returns the view of a crowd for a picture, in which agents out of sight throw their shadows, and hide the sky from what is in
/// sight if they are nearer to it than eight of the largest radii of agents.
pub fn with_shadows(crowd: &Crowd, seen: &CrowdView, view: &render::View) -> CrowdView {
    let (settings, lights) = (&view.settings, &view.lights);
    let sun = |sun: &render::Sun| ShadowSun { towards: sun.direction, angular_radius: sun.angular_radius };
    let has_shadows = settings.shadows.is_on();
    let suns: Vec<ShadowSun> = lights.suns.iter().filter(|_| has_shadows).map(sun).collect();
    let around = if settings.sky_rays > 0 { AROUND * crowd.largest_radius() } else { 0.0 };
    seen.with_shadows(&suns, around)
}

/// The objects of a picture that show the agents of a crowd: one for each agent that was ever drawn.
#[derive(Debug, Default)]
pub struct StandIns {
    objects: Vec<Option<render::ObjectId>>,
    is_shown: Vec<bool>,
    impostors: Impostors,
}

/// A character in a pose.
struct Posed {
    points: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl StandIns {
    /// Puts the agents of a frame, at `time` seconds and seen from `eye`, into a picture in place of those of the frame before.
    /// Impostors are made of a square for each texel that is covered. The false
    /// colour of a triangle is what `tag` returns for the agent, the cluster, its number and the material.
    ///
    /// # Errors
    /// The meshes exceed the memory limit, or Embree has no memory for them.
    pub fn show(
        &mut self,
        context: &Context,
        picture: &mut render::Scene,
        (crowd, frame, time, eye): (&Crowd, &Frame, f64, DVec3),
        material: render::Material,
        tag: &dyn Fn(u32, &Cluster, u32, u32) -> u32,
    ) -> Result<()> {
        let bytes = frame.triangles * TRIANGLE_BYTES + frame.drawn.len() as u64 * AGENT_BYTES;
        if bytes > context.memory_limit() {
            return Err(Error::memory(format!(
                "{} agents with {} triangles take {bytes} bytes in a picture, more than the memory limit",
                frame.drawn.len(),
                frame.triangles
            ))
            .advise("raise the limit, allow larger errors in pixels, or show fewer agents"));
        }
        let count = crowd.agents().len();
        self.objects.resize(count, None);
        let before = std::mem::replace(&mut self.is_shown, vec![false; count]);
        // Agents in the same pose share it.
        let mut poses: HashMap<PoseKey, Posed> = HashMap::new();
        let mut impostors = self.impostors.of_frame(context, (crowd, frame, time), eye)?.into_iter();
        for drawn in &frame.drawn {
            let (number, agent) = (drawn.0, &crowd.agents()[drawn.0 as usize]);
            let model = &crowd.models()[agent.model as usize];
            let mut mesh = render::Mesh::default();
            if drawn.1 == Drawn::Impostor {
                let found = impostors.next().map(|(_, impostor)| impostor);
                let tag =
                    |cluster: u32, material: u32| tag(number, &model.clusters[cluster as usize], cluster, material);
                found.iter().for_each(|impostor| add_texels(&mut mesh, impostor, &tag));
            } else {
                let key = crowd.pose_key(number, time);
                let posed = match poses.entry(key) {
                    Entry::Occupied(posed) => posed.into_mut(),
                    Entry::Vacant(place) => {
                        let pose = crowd.posed(&key);
                        let points = skin(context, &model.character, &pose, model.blend)?;
                        let normals = skin_normals(context, &model.character, &pose, model.blend)?;
                        place.insert(Posed { points, normals })
                    }
                };
                let mut numbers = HashMap::new();
                let blends = crowd.blends(frame, *drawn).iter().copied().chain(std::iter::repeat(0.0));
                for of in crowd.clusters(frame, *drawn).iter().copied().zip(blends) {
                    let found = model.clusters[of.0 as usize];
                    let (triangles, materials) = crowd.triangles(agent.model, of.0);
                    for (triangle, material) in triangles.iter().zip(materials) {
                        mesh.triangles.push(triangle.map(|vertex| {
                            // Other clusters may have the vertex where it does not move.
                            let moves = of.1 > 0.0 && model.target(of.0, vertex).is_some();
                            *numbers.entry((vertex, moves)).or_insert_with(|| {
                                mesh.points.push(model.blended(of, vertex, &posed.points));
                                if !posed.normals.is_empty() {
                                    mesh.normals.push(model.blended(of, vertex, &posed.normals));
                                }
                                mesh.points.len() as u32 - 1
                            })
                        }));
                        mesh.tags.push(tag(number, &found, of.0, *material));
                    }
                }
            }
            let slot = &mut self.objects[number as usize];
            let object = match *slot {
                Some(object) => {
                    picture.set_transform(object, agent.transform)?;
                    object
                }
                None => *slot.insert(picture.add_object(agent.transform, material)?),
            };
            picture.set_mesh(object, 0, mesh)?;
            self.is_shown[number as usize] = true;
        }
        let gone = before.iter().zip(&self.is_shown).map(|(before, now)| *before && !now);
        for (object, _) in self.objects.iter().zip(gone).filter(|(_, is_gone)| *is_gone) {
            if let Some(object) = object {
                picture.remove_mesh(*object, 0)?;
            }
        }
        Ok(())
    }
}

/// Adds a square for each texel of an impostor that is covered.
fn add_texels(mesh: &mut render::Mesh, impostor: &Impostor, tag: &dyn Fn(u32, u32) -> u32) {
    for (at, texel) in impostor.covered() {
        let first = mesh.points.len() as u32;
        mesh.points.extend(impostor.corners(at));
        mesh.normals.extend([texel.normal; 4]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh.tags.extend([tag(texel.cluster, texel.material); 2]);
    }
}
