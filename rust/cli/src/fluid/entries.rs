//! What of a description has a shape or acts on particles: fills, colliders, bodies, emitters, sinks and forces.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{Quat, Vec3};
use relievo_core::{Context, Error, Result};
use relievo_fluid::{
    BodyOptions, ColliderOptions, Contact, Emitter, Force, Overflow, Sink, Solid, Sources, cuboid, sphere,
};
use serde::Deserialize;

/// A box by its corners, in metres.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Corners {
    pub low: [f32; 3],
    pub high: [f32; 3],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Ball {
    middle: [f32; 3],
    radius: f32,
}

/// Points in metres and triangles of them.
pub type Triangles = (Vec<Vec3>, Vec<[u32; 3]>);

/// A mesh file, a box or a sphere.
struct Shape<'a> {
    mesh: Option<&'a Path>,
    corners: Option<&'a Corners>,
    sphere: Option<&'a Ball>,
}

impl Shape<'_> {
    /// Its triangles; files are named from a folder.
    fn triangles(&self, context: &Context, folder: &Path) -> Result<Triangles> {
        match (self.mesh, self.corners, self.sphere) {
            (Some(mesh), None, None) => {
                let mesh = relievo_meshio::read(context, &folder.join(mesh))?;
                Ok((mesh.points.iter().map(|point| Vec3::from(*point)).collect(), mesh.triangles()))
            }
            (None, Some(Corners { low, high }), None) => Ok(cuboid(Vec3::from(*low), Vec3::from(*high))),
            (None, None, Some(Ball { middle, radius })) => Ok(sphere(Vec3::from(*middle), *radius)),
            _ => Err(Error::invalid("it has no shape, or more than one").advise("give it one of mesh, box and sphere")),
        }
    }
}

/// What begins full of fluid.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fill {
    mesh: Option<PathBuf>,
    #[serde(rename = "box")]
    corners: Option<Corners>,
    sphere: Option<Ball>,
    #[serde(default)]
    pub velocity: [f32; 3],
    pub color: Option<[f32; 3]>,
}

impl Fill {
    pub fn places(&self, context: &Context, folder: &Path, spacing: f32) -> Result<Vec<Vec3>> {
        let shape = Shape { mesh: self.mesh.as_deref(), corners: self.corners.as_ref(), sphere: self.sphere.as_ref() };
        let (points, triangles) = shape.triangles(context, folder)?;
        Solid::new(&points, &triangles)?.fill(context, spacing)
    }
}

/// A mesh that fluid does not pass.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Collider {
    mesh: Option<PathBuf>,
    #[serde(rename = "box")]
    corners: Option<Corners>,
    sphere: Option<Ball>,
    #[serde(default)]
    container: bool,
    contact: Option<String>,
    friction: Option<f32>,
    #[serde(default)]
    pivot: [f32; 3],
    #[serde(default)]
    keys: Vec<Key>,
}

/// Where a collider is at a time.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Key {
    /// Seconds since the beginning.
    time: f64,
    /// By how many metres it has moved.
    #[serde(default = "zero", rename = "move")]
    moved: [f32; 3],
    /// By how much it has turned about its pivot: an axis as long as the angle in radians.
    #[serde(default = "zero")]
    turn: [f32; 3],
}

fn zero() -> [f32; 3] {
    [0.0; 3]
}

fn contact(contact: Option<&str>, friction: Option<f32>) -> Result<Contact> {
    match (contact, friction) {
        (None | Some("slip"), None) => Ok(Contact::Slip),
        (None, Some(share)) => Ok(Contact::Friction(share)),
        (Some("stop"), None) => Ok(Contact::Stop),
        _ => Err(Error::invalid("there is no such contact with a collider")
            .at("contact")
            .advise("use slip or stop, or give a friction")),
    }
}

/// A rigid body that floats.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Floating {
    mesh: Option<PathBuf>,
    #[serde(rename = "box")]
    corners: Option<Corners>,
    sphere: Option<Ball>,
    density: f32,
    #[serde(default)]
    velocity: [f32; 3],
    #[serde(default)]
    spin: [f32; 3],
    contact: Option<String>,
    friction: Option<f32>,
}

impl Floating {
    /// Its triangles and what it is.
    pub fn body(&self, context: &Context, folder: &Path) -> Result<(Triangles, BodyOptions)> {
        let shape = Shape { mesh: self.mesh.as_deref(), corners: self.corners.as_ref(), sphere: self.sphere.as_ref() };
        let options = BodyOptions {
            density: self.density,
            velocity: self.velocity.into(),
            spin: self.spin.into(),
            contact: contact(self.contact.as_deref(), self.friction)?,
        };
        Ok((shape.triangles(context, folder)?, options))
    }
}

/// A collider on its way.
pub struct Mover {
    pub points: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    pub options: ColliderOptions,
    pivot: Vec3,
    keys: Vec<Key>,
}

impl Collider {
    pub fn mover(&self, context: &Context, folder: &Path) -> Result<Mover> {
        let shape = Shape { mesh: self.mesh.as_deref(), corners: self.corners.as_ref(), sphere: self.sphere.as_ref() };
        let (points, triangles) = shape.triangles(context, folder)?;
        let contact = contact(self.contact.as_deref(), self.friction)?;
        let is_sound = |key: &Key| key.time.is_finite() && key.moved.iter().chain(&key.turn).all(|at| at.is_finite());
        if !self.keys.iter().all(is_sound) || self.keys.windows(2).any(|pair| pair[0].time >= pair[1].time) {
            return Err(Error::invalid("times of keys do not increase, or a number is not finite").at("keys"));
        }
        let options = ColliderOptions { contact, is_container: self.container };
        Ok(Mover { points, triangles, options, pivot: self.pivot.into(), keys: self.keys.clone() })
    }
}

impl Mover {
    /// Whether it is elsewhere at another time.
    pub fn is_moving(&self) -> bool {
        self.keys.len() > 1
    }

    /// How it is turned about the origin at a time in seconds, and moved then: straight from key to key, turned by the
    /// shortest way.
    pub fn pose(&self, time: f64) -> (Quat, Vec3) {
        let after = self.keys.partition_point(|key| key.time <= time);
        let pose = |key: &Key| (Vec3::from(key.moved), Quat::from_scaled_axis(Vec3::from(key.turn)));
        let (moved, turn) = match (after.checked_sub(1).map(|at| &self.keys[at]), self.keys.get(after)) {
            (Some(last), Some(next)) => {
                let share = ((time - last.time) / (next.time - last.time)) as f32;
                let ([a, b], [from, to]) = ([pose(last).0, pose(next).0], [pose(last).1, pose(next).1]);
                (a.lerp(b, share), from.slerp(to, share))
            }
            (Some(key), None) | (None, Some(key)) => pose(key),
            (None, None) => (Vec3::ZERO, Quat::IDENTITY),
        };
        (turn, self.pivot - turn * self.pivot + moved)
    }

    /// Where its points are at a time in seconds.
    pub fn at(&self, time: f64) -> Vec<Vec3> {
        let (turn, moved) = self.pose(time);
        self.points.iter().map(|point| turn * *point + moved).collect()
    }
}

/// Where particles come from.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outlet {
    disc: Option<Disc>,
    rectangle: Option<Rectangle>,
    mesh: Option<PathBuf>,
    /// m/s
    speed: f32,
    #[serde(default)]
    start: f64,
    stop: Option<f64>,
    lifetime: Option<f32>,
    color: Option<[f32; 3]>,
    #[serde(default)]
    channels: BTreeMap<String, Vec<f32>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Disc {
    middle: [f32; 3],
    normal: [f32; 3],
    radius: f32,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Rectangle {
    middle: [f32; 3],
    /// Half its sides, as vectors; particles go along their cross product.
    sides: [[f32; 3]; 2],
}

impl Outlet {
    fn emitter(&self, context: &Context, folder: &Path, spacing: f32) -> Result<Emitter> {
        let mut emitter = match (&self.disc, &self.rectangle, &self.mesh) {
            (Some(Disc { middle, normal, radius }), None, None) => {
                Emitter::disc(Vec3::from(*middle), Vec3::from(*normal), *radius, self.speed, spacing)?
            }
            (None, Some(Rectangle { middle, sides }), None) => {
                Emitter::rectangle(Vec3::from(*middle), sides.map(Vec3::from), self.speed, spacing)?
            }
            (None, None, Some(mesh)) => {
                let shape = Shape { mesh: Some(mesh), corners: None, sphere: None };
                let (points, triangles) = shape.triangles(context, folder)?;
                Emitter::mesh(&points, &triangles, self.speed, spacing)?
            }
            _ => {
                return Err(Error::invalid("it has no shape, or more than one")
                    .advise("give it one of disc, rectangle and mesh"));
            }
        };
        emitter.time = [self.start, self.stop.unwrap_or(f64::INFINITY)];
        emitter.lifetime = self.lifetime.unwrap_or(f32::INFINITY);
        emitter.channels = self.channels.iter().map(|(name, values)| (name.clone(), values.clone())).collect();
        emitter.channels.extend(self.color.map(|color| ("color".to_owned(), color.to_vec())));
        Ok(emitter)
    }
}

/// What takes particles away.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drain {
    mesh: Option<PathBuf>,
    #[serde(rename = "box")]
    corners: Option<Corners>,
    sphere: Option<Ball>,
    outside: Option<Corners>,
}

impl Drain {
    fn sink(&self, context: &Context, folder: &Path) -> Result<Sink> {
        let ends = |corners: &Corners| [Vec3::from(corners.low), Vec3::from(corners.high)];
        match (&self.outside, &self.mesh, &self.corners, &self.sphere) {
            (Some(corners), None, None, None) => Ok(Sink::Outside(ends(corners))),
            (None, None, Some(corners), None) => Ok(Sink::Inside(ends(corners))),
            (None, mesh, corners, ball) => {
                let shape = Shape { mesh: mesh.as_deref(), corners: corners.as_ref(), sphere: ball.as_ref() };
                let (points, triangles) = shape.triangles(context, folder)?;
                Ok(Sink::Mesh(Solid::new(&points, &triangles)?))
            }
            _ => {
                Err(Error::invalid("it has more than one shape").advise("give it one of outside, mesh, box and sphere"))
            }
        }
    }
}

/// How many particles there may be.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    particles: usize,
    #[serde(default)]
    stop: bool,
}

/// What particles come from and where they go, of the entries of a description.
pub fn sources(
    context: &Context,
    folder: &Path,
    spacing: f32,
    (outlets, drains, budget): (&[Outlet], &[Drain], Option<&Budget>),
) -> Result<Sources> {
    let named = |kind: &'static str, number: usize| move |error: Error| error.at(format!("{kind} {number}"));
    let emitters = outlets
        .iter()
        .enumerate()
        .map(|(number, outlet)| outlet.emitter(context, folder, spacing).map_err(named("emitter", number)));
    let sinks =
        drains.iter().enumerate().map(|(number, drain)| drain.sink(context, folder).map_err(named("sink", number)));
    Ok(Sources {
        emitters: emitters.collect::<Result<_>>()?,
        sinks: sinks.collect::<Result<_>>()?,
        budget: budget.map(|budget| budget.particles),
        overflow: if budget.is_some_and(|budget| budget.stop) { Overflow::Stop } else { Overflow::Refuse },
    })
}

/// A force by its kind.
#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum Push {
    Gravity {
        acceleration: [f32; 3],
    },
    Wind {
        velocity: [f32; 3],
        share: f32,
    },
    Drag {
        share: f32,
        #[serde(default)]
        square: f32,
    },
    Vortex {
        place: [f32; 3],
        axis: [f32; 3],
        strength: f32,
        radius: f32,
    },
    Attractor {
        place: [f32; 3],
        strength: f32,
        radius: f32,
    },
    Turbulence {
        strength: f32,
        scale: f32,
        #[serde(default)]
        rate: f32,
        #[serde(default)]
        seed: u32,
    },
}

impl Push {
    pub fn force(&self) -> Force {
        match *self {
            Self::Gravity { acceleration } => Force::Gravity(acceleration.into()),
            Self::Wind { velocity, share } => Force::Wind { velocity: velocity.into(), share },
            Self::Drag { share, square } => Force::Drag { share, square },
            Self::Vortex { place, axis, strength, radius } => {
                Force::Vortex { place: place.into(), axis: axis.into(), strength, radius }
            }
            Self::Attractor { place, strength, radius } => Force::Attractor { place: place.into(), strength, radius },
            Self::Turbulence { strength, scale, rate, seed } => Force::Turbulence { strength, scale, rate, seed },
        }
    }
}
