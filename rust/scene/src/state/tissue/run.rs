//! Soft tissue that a scene simulates: `[[tissue]]`. Frame after frame it meets the rigid bodies of the scene, and its
//! frames are beside the baked ones of the scene, `cache/tissue/NAME-FRAME.rtstate`.
//!
//! Bodies do not feel the tissue, so that their way is that of the scene's physics, which repeats itself exactly. A frame
//! says what it is of: the simulation, the model, the bodies and the instruction level. A frame of anything else is not
//! taken.

use std::path::PathBuf;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, ErrorKind, Mesh, Result};
use relievo_tissue::{Body, Collider, DistanceField, Pose, SavedState, Simulation, State};

use super::motion::Motion;
use super::{read_model, surface};
use crate::format::description::{Scene, TissueEntry};
use crate::out::output::Folder;
use crate::state::checksum::checksum;
use crate::state::paths::Paths;
use crate::state::physics::Physics;

/// The folder of the frames in the cache of a scene.
const FOLDER: &str = "tissue";
/// The extension of frames.
const EXTENSION: &str = "rtstate";
/// Unbalanced forces at rest, as a share of the largest force.
const TOLERANCE: f32 = 1e-3;
/// Steps to rest at most.
const MAX: u64 = 20_000;

/// Tissue on its way through the frames of a scene.
#[derive(Debug)]
pub(crate) struct Tissue {
    name: String,
    simulation: Simulation,
    /// Whether it begins at rest under the loads at time 0.
    relaxes: bool,
    /// From the metres of the model, z up, to the units of the scene.
    space: DAffine3,
    fps: f64,
    /// The last frame of the scene.
    last: u32,
    /// What frames are of.
    identity: u32,
    level: String,
    bodies: Option<Bodies>,
    cache: Option<Folder>,
    /// The frame that the simulation is at; `None` before the first.
    frame: Option<u32>,
    /// Displacements of the nodes in the last frames that were asked for.
    recent: Vec<(u32, Vec<[f32; 4]>)>,
    files: Vec<u32>,
    notes: Vec<String>,
}

/// The way of the bodies that the tissue meets.
#[derive(Debug)]
struct Bodies {
    physics: Physics,
    /// The object and where its middle is in its own space, in the order of the last colliders of the simulation.
    solids: Vec<(usize, DVec3)>,
    /// From the world at time 0 to the metres of the model.
    back: DAffine3,
    /// Where the objects were at time 0.
    start: Vec<DAffine3>,
}

/// An object that tissue meets, and its mesh at time 0.
pub(crate) type Solid = (usize, Mesh);

impl Tissue {
    /// Reads a simulation and its model, from files that the scene may refer to. `space` takes metres, z up, to the units of
    /// the scene. Fails if a file cannot be read, or the model cannot be simulated.
    pub fn read(context: &Context, scene: &Scene, paths: &Paths, entry: &TissueEntry, space: DAffine3) -> Result<Self> {
        let path = paths.resolve(&entry.simulation.text)?;
        let named = |error: Error| error.at(path.display().to_string());
        let motion = Motion::read(&path)?;
        let mut files = vec![checksum(&path)?];
        let mut check = |file: PathBuf| -> Result<()> {
            files.push(checksum(&paths.resolve(&file.to_string_lossy()).map_err(named)?)?);
            Ok(())
        };
        let model = motion.model();
        check(model.clone())?;
        motion.files().try_for_each(&mut check)?;
        if super::is_named(&model, "toml") {
            super::Recipe::read(&model)?.files().into_iter().try_for_each(&mut check)?;
        }
        let (model, notes) = read_model(context, &model)?;
        let identity = motion.identity(context, &model).map_err(named)?;
        let simulation = motion.begin(context, model).map_err(named)?;
        let steps = simulation.steps();
        let mut notes: Vec<String> =
            notes.into_iter().map(|note| format!("tissue `{}`: {note}", entry.name.text)).collect();
        if steps.added_mass > 0.0 {
            let (name, share) = (&entry.name.text, 100.0 * steps.added_mass);
            notes
                .push(format!("tissue `{name}`: {share:.2} % of its mass are added for steps of {:.3e} s", steps.step));
        }
        Ok(Self {
            name: entry.name.text.clone(),
            simulation,
            relaxes: motion.relax,
            space,
            fps: scene.fps,
            last: scene.output.frames.saturating_sub(1),
            identity,
            level: context.level().name().to_owned(),
            bodies: None,
            cache: None,
            frame: None,
            recent: Vec::new(),
            files,
            notes,
        })
    }

    /// Lets the tissue meet objects of the scene, which move as `physics` says, and go to the first frame. `place` is where
    /// the object is that shows it.
    ///
    /// # Errors
    /// The object that shows it is not scaled evenly, a mesh has no surface, or the tissue turns inside out.
    pub fn meet(
        &mut self,
        context: &Context,
        (scene, entry): (&Scene, &TissueEntry),
        physics: Physics,
        place: DAffine3,
        solids: &[Solid],
    ) -> Result<()> {
        let place = place * self.space;
        let columns = [place.matrix3.x_axis, place.matrix3.y_axis, place.matrix3.z_axis];
        let size = columns[0].length();
        let gram = place.matrix3.transpose() * place.matrix3 * (size * size).recip();
        if !(size > 0.0 && gram.abs_diff_eq(DMat3::IDENTITY, 1e-6) && place.matrix3.determinant() > 0.0) {
            return Err(Error::invalid("the object that shows the tissue is sheared, mirrored or not scaled evenly")
                .advise("give it one `scale` for all axes"));
        }
        let (back, start) = (place.inverse(), physics.transforms());
        let (mut identity, mut kept) = (format!("{} {:?}", self.identity, back.to_cols_array()), Vec::new());
        for (object, mesh) in solids {
            let named = |error: Error| error.at(format!("object `{}`", scene.objects[*object].name.text));
            let to = back * start[*object];
            let points: Vec<DVec3> =
                mesh.points.iter().map(|point| to.transform_point3(Vec3::from(*point).as_dvec3())).collect();
            let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
            let points: Vec<[f32; 3]> = points.iter().map(|point| (*point - middle).as_vec3().to_array()).collect();
            let triangles = mesh.triangles();
            identity.push_str(&format!(" {:08x}", crc32fast::hash(bytemuck::cast_slice(&points))));
            identity.push_str(&format!(" {:08x}", crc32fast::hash(bytemuck::cast_slice(&triangles))));
            let field = DistanceField::new(&points, &triangles).map_err(named)?;
            let pose = Pose { translation: middle, rotation: DQuat::IDENTITY };
            self.simulation.add_collider(Collider::posed(Body::Mesh(field), entry.friction, pose).map_err(named)?);
            kept.push((*object, middle));
        }
        let placements: Vec<_> = scene.objects.iter().map(|object| object.placement).collect();
        identity.push_str(&format!(" {:?}", (scene.fps, scene.physics, &scene.bodies, placements, entry)));
        self.identity = crc32fast::hash(identity.as_bytes());
        self.bodies = Some(Bodies { physics, solids: kept, back, start });
        // The mesh at time 0 is that at rest, which is looked for only where it is not that of the model.
        if self.relaxes { self.go_to(context, 0) } else { Ok(()) }
    }

    /// Keeps frames in the folder of the cache of a scene from now on.
    pub fn keep(&mut self, cache: &Folder) -> Result<()> {
        self.cache = Some(cache.sub(FOLDER)?);
        Ok(())
    }

    /// Returns the number of the bound surface of a name, or of the first. Fails if there is none.
    pub fn bound(&self, name: Option<&str>) -> Result<usize> {
        surface::find(self.simulation.model(), name)
    }

    /// Returns a bound surface as the simulation is.
    pub fn mesh(&self, context: &Context, bound: usize) -> Mesh {
        let triangles = &self.simulation.model().bindings[bound].triangles;
        Mesh::from_triangles(self.placed(context, bound, &self.simulation.state().displacements), triangles)
    }

    /// Returns the last frame.
    pub fn last(&self) -> u32 {
        self.last
    }

    /// Returns checksums of the files it came from.
    pub fn checksums(&self) -> &[u32] {
        &self.files
    }

    /// Returns what the user should know since the last call.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    /// Returns the points of a bound surface in a frame. Frames on the way are simulated, unless they are in the cache.
    ///
    /// # Errors
    /// An element turns inside out, or a file cannot be read or written.
    pub fn points(&mut self, context: &Context, bound: usize, frame: u32) -> Result<Vec<[f32; 3]>> {
        let frame = frame.min(self.last);
        if self.recent.iter().all(|(known, _)| *known != frame) {
            self.go_to(context, frame).map_err(|error| error.at(format!("tissue `{}`", self.name)))?;
            // Two frames are enough for motion between them.
            if self.recent.len() > 1 {
                self.recent.remove(0);
            }
            self.recent.push((frame, self.simulation.state().displacements.clone()));
        }
        match self.recent.iter().find(|(known, _)| *known == frame) {
            Some((_, displacements)) => Ok(self.placed(context, bound, displacements)),
            None => Err(Error::internal("a frame of the tissue is not there")),
        }
    }

    fn placed(&self, context: &Context, bound: usize, displacements: &[[f32; 4]]) -> Vec<[f32; 3]> {
        let model = self.simulation.model();
        let points = model.bindings[bound].points(context, model, displacements);
        let place = |point: [f32; 3]| self.space.transform_point3(Vec3::from(point).as_dvec3()).as_vec3().to_array();
        points.into_iter().map(place).collect()
    }

    fn go_to(&mut self, context: &Context, frame: u32) -> Result<()> {
        if self.frame == Some(frame) {
            return Ok(());
        }
        self.open(context, frame)?;
        if self.frame.is_none_or(|at| at > frame) {
            let rest = vec![[0.0; 4]; self.simulation.model().nodes.len()];
            self.simulation.set_state(State { displacements: rest.clone(), velocities: rest, ..State::default() })?;
            if self.relaxes {
                let _stage = context.stats().begin("tissue.relax");
                let relaxation = self.simulation.relax(context, TOLERANCE, MAX, &mut Silent)?;
                if !relaxation.is_at_rest {
                    self.notes.push(format!("tissue `{}`: it is not at rest after {MAX} steps", self.name));
                }
            }
            self.frame = Some(0);
            self.store(0)?;
        }
        while let Some(at) = self.frame.filter(|at| *at < frame) {
            let mut stage = context.stats().begin("tissue.simulate");
            self.move_bodies(at + 1)?;
            let end = f64::from(at + 1) / self.fps;
            // A whole number of steps that ends at or just after the frame.
            let left = (end - self.simulation.state().seconds) / f64::from(self.simulation.steps().step);
            let steps = (left - 1e-6).ceil().max(0.0) as u64;
            self.simulation
                .advance(context, steps, &mut Silent)
                .map_err(|error| error.at(format!("frame {}", at + 1)))?;
            stage.count("steps", steps);
            self.frame = Some(at + 1);
            self.store(at + 1)?;
        }
        Ok(())
    }

    /// Gives the colliders the poses of the bodies up to a frame.
    fn move_bodies(&mut self, frame: u32) -> Result<()> {
        let Some(bodies) = &mut self.bodies else { return Ok(()) };
        while bodies.physics.frame() < frame {
            let before = bodies.physics.frame();
            let path = bodies.physics.advance();
            for (part, transforms) in path.iter().enumerate() {
                let time = (f64::from(before) + (part + 1) as f64 / path.len() as f64) / self.fps;
                let colliders = self.simulation.colliders_mut();
                let first = colliders.len() - bodies.solids.len();
                for (collider, (object, middle)) in colliders[first..].iter_mut().zip(&bodies.solids) {
                    let moved =
                        bodies.back * transforms[*object] * bodies.start[*object].inverse() * bodies.back.inverse();
                    let is_rigid = (moved.matrix3.transpose() * moved.matrix3).abs_diff_eq(DMat3::IDENTITY, 1e-4);
                    if !is_rigid {
                        return Err(Error::unsupported(format!("collider {object} is scaled while it moves"))
                            .advise("animate its translation and rotation alone"));
                    }
                    let rotation = DQuat::from_mat3(&moved.matrix3).normalize();
                    collider.add_pose(time, Pose { translation: moved.transform_point3(*middle), rotation })?;
                }
            }
        }
        Ok(())
    }

    fn path(folder: &Folder, name: &str, frame: u32) -> PathBuf {
        folder.file(&format!("{name}-{frame:06}.{EXTENSION}"))
    }

    /// Opens the last cached frame after the one it is at and up to `frame`, if there is one.
    fn open(&mut self, context: &Context, frame: u32) -> Result<()> {
        let Some(folder) = &self.cache else { return Ok(()) };
        let first = self.frame.filter(|at| *at < frame).map_or(0, |at| at + 1);
        for at in (first..=frame).rev() {
            let path = Self::path(folder, &self.name, at);
            if !path.exists() {
                continue;
            }
            let _stage = context.stats().begin("tissue.open");
            let saved = match SavedState::read(context, &path) {
                Ok(saved) => saved,
                Err(error) if error.kind == ErrorKind::Invalid => {
                    self.notes.push(format!("{error}; the frame of the tissue is simulated again"));
                    continue;
                }
                Err(error) => return Err(error),
            };
            if saved.identity == self.identity && saved.level == self.level {
                self.simulation.set_state(saved.state)?;
                self.frame = Some(at);
                break;
            }
        }
        Ok(())
    }

    fn store(&self, frame: u32) -> Result<()> {
        let Some(folder) = &self.cache else { return Ok(()) };
        let (identity, level, state) = (self.identity, self.level.clone(), self.simulation.state().clone());
        SavedState { identity, level, state }.write(&Self::path(folder, &self.name, frame))
    }
}

/// Removes the frames from `first` on of all tissues from the cache of a scene.
pub(crate) fn truncate(cache: &Folder, first: u32) -> Result<()> {
    let folder = cache.path().join(FOLDER);
    if !folder.exists() {
        return Ok(());
    }
    let failed = |error: std::io::Error| Error::io(&folder, &error);
    for entry in std::fs::read_dir(&folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let number = stem.rsplit_once('-').and_then(|(_, number)| number.parse::<u32>().ok());
        if super::is_named(&path, EXTENSION) && number.is_some_and(|number| number >= first) {
            std::fs::remove_file(&path).map_err(|error| Error::io(&path, &error))?;
        }
    }
    Ok(())
}
