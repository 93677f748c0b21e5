//! What is simulated, in TOML: a model, what moves it, and how.

use std::path::{Path, PathBuf};

use relievo_core::{Context, Error, Result};
use relievo_tissue::{
    Body as Solid, Collider, Curve, DistanceField, Drive, Model, Pressure, Simulation, SimulationOptions,
};
use serde::Deserialize;

use super::body::Body;
use super::{description, folder};

/// A simulation in TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    model: PathBuf,
    /// Frames after the first.
    pub frames: u32,
    /// Frames a second.
    #[serde(default = "fps")]
    pub fps: f64,
    /// Whether it begins at rest under its loads at time 0.
    #[serde(default)]
    pub relax: bool,
    #[serde(default)]
    options: Options,
    #[serde(default, rename = "move")]
    moves: Vec<Move>,
    #[serde(default)]
    activation: Vec<Activation>,
    #[serde(default)]
    collider: Vec<Obstacle>,
    #[serde(default)]
    pressure: Vec<PressureEntry>,
    /// The folder of the description.
    #[serde(skip)]
    folder: PathBuf,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Options {
    gravity: [f32; 3],
    damping: f32,
    step: Option<f32>,
    safety: f32,
    hourglass: f32,
    mass_scaling: Option<f32>,
    halvings: u32,
    self_friction: Option<f32>,
}

impl Default for Options {
    fn default() -> Self {
        let SimulationOptions { gravity, damping, step, safety, hourglass, mass_scaling, halvings, self_friction } =
            SimulationOptions::default();
        Self { gravity, damping, step, safety, hourglass, mass_scaling, halvings, self_friction }
    }
}

/// Nodes of a set that are held or moved.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Move {
    set: String,
    #[serde(default = "all_axes")]
    axes: String,
    /// Displacements at times; an empty list holds the nodes where they are.
    #[serde(default)]
    keys: Vec<Key>,
}

fn all_axes() -> String {
    "xyz".into()
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Key {
    time: f64,
    #[serde(default)]
    at: [f32; 3],
    /// Rotation vector in radians, of colliders.
    #[serde(default)]
    turn: [f32; 3],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Activation {
    muscle: String,
    /// Pairs of time in seconds and activation, 0 to 1.
    keys: Vec<[f64; 2]>,
}

/// A pressure on the outer faces of which all nodes are in a set.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PressureEntry {
    set: String,
    /// Pairs of time in seconds and pressure in Pa.
    keys: Vec<[f64; 2]>,
}

/// A body that nodes do not enter, in its own space about the origin.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Obstacle {
    #[serde(default)]
    floor: bool,
    ball: Option<f32>,
    body: Option<Body>,
    #[serde(default)]
    friction: f32,
    #[serde(default)]
    keys: Vec<Key>,
}

fn fps() -> f64 {
    24.0
}

impl Motion {
    /// Reads a simulation.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the file cannot be read, with `Memory` if it is longer than 4 MiB, and with
    /// `Invalid` if it is not TOML, has unknown keys, lacks one without a default, or its frames a second are out of
    /// range.
    pub fn read(path: &Path) -> Result<Self> {
        let mut read: Self = description(path)?;
        if !(read.fps > 1e-3 && read.fps < 1e6) {
            return Err(Error::invalid(format!("{} frames a second cannot be", read.fps))
                .at(format!("{}: fps", path.display()))
                .advise("use more than 0.001 and less than 1000000"));
        }
        read.folder = folder(path);
        Ok(read)
    }

    /// Returns the file of the model.
    pub fn model(&self) -> PathBuf {
        self.folder.join(&self.model)
    }

    /// Returns the mesh files of its colliders.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> {
        let bodies = self.collider.iter().filter_map(|entry| entry.body.as_ref());
        bodies.filter_map(Body::file).map(|file| self.folder.join(file))
    }

    /// Returns all that decides what frames of a model are, but not how many there are.
    ///
    /// # Errors
    /// Fails as [`Body::triangles`] if the body of a collider cannot be made.
    pub fn identity(&self, context: &Context, model: &Model) -> Result<u32> {
        let text = format!("{self:?}").replacen(&format!("frames: {}, ", self.frames), "", 1);
        let mut bytes = text.replace(&format!(", folder: {:?}", self.folder), "").into_bytes();
        bytes.extend(model.checksum().to_le_bytes());
        for body in self.collider.iter().filter_map(|it| it.body.as_ref()) {
            let (points, triangles) = body.triangles(context, &self.folder)?;
            bytes.extend(points.as_flattened().iter().flat_map(|at| at.to_le_bytes()));
            bytes.extend(triangles.as_flattened().iter().flat_map(|at| at.to_le_bytes()));
        }
        Ok(crc32fast::hash(&bytes))
    }

    /// Prepares the simulation of a model at time 0.
    ///
    /// # Errors
    /// Fails with `Invalid` if a set, muscle, axis or outer face that it names does not exist, keys are missing, not
    /// finite or not in order of time, the model, an option or a collider cannot be used, or an activation is not 0 to
    /// 1, and as [`Body::triangles`] if the body of a collider cannot be made.
    pub fn begin(&self, context: &Context, model: Model) -> Result<Simulation> {
        let options = SimulationOptions {
            gravity: self.options.gravity,
            damping: self.options.damping,
            step: self.options.step,
            safety: self.options.safety,
            hourglass: self.options.hourglass,
            mass_scaling: self.options.mass_scaling,
            halvings: self.options.halvings,
            self_friction: self.options.self_friction,
        };
        let drives = self.moves.iter().map(|entry| entry.drive(&model)).collect::<Result<Vec<_>>>()?;
        let muscles = self.activation.iter().map(|entry| model.muscle(&entry.muscle)).collect::<Result<Vec<_>>>()?;
        let pressures = self.pressure.iter().map(|entry| entry.pressure(&model)).collect::<Result<Vec<_>>>()?;
        let mut simulation = Simulation::new(model, &options)?;
        for pressure in pressures {
            simulation.press(pressure)?;
        }
        for drive in drives {
            simulation.drive(drive)?;
        }
        for (entry, muscle) in self.activation.iter().zip(muscles) {
            let named = |error: Error| error.at(format!("activation of `{}`", entry.muscle));
            let keys = entry.keys.iter().map(|[time, value]| (*time, [*value as f32])).collect();
            simulation.activate(muscle, Curve::new(keys).map_err(named)?).map_err(named)?;
        }
        for (number, entry) in self.collider.iter().enumerate() {
            let named = |error: Error| error.at(format!("collider {number}"));
            simulation.add_collider(entry.collider(context, &self.folder).map_err(named)?);
        }
        Ok(simulation)
    }

    /// Returns the surfaces of the colliders at a time, in metres, for pictures; floors are left out.
    ///
    /// # Errors
    /// Fails with `Invalid` if a collider has more than one shape, its keys are not in order of time, or its friction
    /// or radius is out of range, and as [`Body::triangles`].
    pub fn solids(&self, context: &Context, time: f64) -> Result<Vec<(Vec<[f32; 3]>, Vec<[u32; 3]>)>> {
        let mut solids = Vec::new();
        for entry in self.collider.iter().filter(|entry| !entry.floor) {
            let (mut points, triangles) = match (&entry.body, entry.ball) {
                (Some(body), _) => body.triangles(context, &self.folder)?,
                (None, Some(radius)) => Body::sphere(radius).triangles(context, &self.folder)?,
                (None, None) => continue,
            };
            let pose = entry.collider(context, &self.folder)?.pose(time);
            for point in &mut points {
                *point = pose.transform_point3(glam::Vec3::from(*point).as_dvec3()).as_vec3().to_array();
            }
            solids.push((points, triangles));
        }
        Ok(solids)
    }
}

impl Move {
    fn drive(&self, model: &Model) -> Result<Drive> {
        let named = |error: Error| error.at(format!("move of `{}`", self.set));
        let mut axes = 0;
        for letter in self.axes.chars() {
            axes |= match letter {
                'x' => 1,
                'y' => 2,
                'z' => 4,
                _ => {
                    return Err(named(Error::invalid(format!("there is no axis `{letter}`")).advise("use x, y and z")));
                }
            };
        }
        let displacement = curve(&self.keys, |key| key.at).map_err(named)?;
        Ok(Drive { nodes: model.set(&self.set).map_err(named)?.nodes.clone(), axes, displacement })
    }
}

impl PressureEntry {
    fn pressure(&self, model: &Model) -> Result<Pressure> {
        let named = |error: Error| error.at(format!("pressure on `{}`", self.set));
        let faces = model.outer_faces_of(&model.set(&self.set).map_err(named)?.nodes);
        if faces.is_empty() {
            return Err(named(
                Error::invalid("no outer face has all its nodes in the set").advise("name a set of the outer surface"),
            ));
        }
        let keys = self.keys.iter().map(|[time, value]| (*time, [*value as f32])).collect();
        Ok(Pressure { faces, pressure: Curve::new(keys).map_err(named)? })
    }
}

impl Obstacle {
    fn collider(&self, context: &Context, folder: &Path) -> Result<Collider> {
        let body = match (self.floor, self.ball, &self.body) {
            (true, None, None) => Solid::Floor,
            (false, Some(radius), None) => Solid::Ball(radius),
            (false, None, Some(body)) => {
                let (points, triangles) = body.triangles(context, folder)?;
                Solid::Mesh(DistanceField::new(&points, &triangles)?)
            }
            _ => {
                return Err(
                    Error::invalid("it has no shape, or more than one").advise("give it one of floor, ball and body")
                );
            }
        };
        Collider::new(body, self.friction, curve(&self.keys, |key| key.at)?, curve(&self.keys, |key| key.turn)?)
    }
}

/// Returns the curve through one number of each key; 0 everywhere for an empty list.
fn curve(keys: &[Key], of: impl Fn(&Key) -> [f32; 3]) -> Result<Curve<3>> {
    if keys.is_empty() {
        return Ok(Curve::constant([0.0; 3]));
    }
    Curve::new(keys.iter().map(|key| (key.time, of(key))).collect())
}
