//! What of a description has a shape or acts on particles: bodies, emitters, sinks and forces.

use std::collections::BTreeMap;

use glam::Vec3;
use relievo_core::{Context, Error, Result};
use relievo_fluid::{BodyOptions, Contact, Emitter, Force, Overflow, Sink, Solid, Sources};
use serde::Deserialize;

use crate::files::Source;
use crate::shape::{Ball, Corners, MeshFile, Shape, Triangles};

/// What becomes of particles, of the names of a description.
pub fn contact(contact: Option<&str>, friction: Option<f32>) -> Result<Contact> {
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
    mesh: Option<MeshFile>,
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
    /// The mesh that it is read from.
    pub fn mesh(&self) -> Option<&MeshFile> {
        self.mesh.as_ref()
    }

    /// Its triangles and what it is.
    pub fn body(&self, context: &Context, files: &Source) -> Result<(Triangles, BodyOptions)> {
        let shape = Shape { mesh: self.mesh.as_ref(), corners: self.corners.as_ref(), sphere: self.sphere.as_ref() };
        let options = BodyOptions {
            density: self.density,
            velocity: self.velocity.into(),
            spin: self.spin.into(),
            contact: contact(self.contact.as_deref(), self.friction)?,
        };
        Ok((shape.triangles(context, files)?, options))
    }
}

/// Where particles come from.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outlet {
    disc: Option<Disc>,
    rectangle: Option<Rectangle>,
    mesh: Option<MeshFile>,
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
    /// The mesh that it is read from.
    pub fn mesh(&self) -> Option<&MeshFile> {
        self.mesh.as_ref()
    }

    fn emitter(&self, context: &Context, files: &Source, spacing: f32) -> Result<Emitter> {
        let mut emitter = match (&self.disc, &self.rectangle, &self.mesh) {
            (Some(Disc { middle, normal, radius }), None, None) => {
                Emitter::disc(Vec3::from(*middle), Vec3::from(*normal), *radius, self.speed, spacing)?
            }
            (None, Some(Rectangle { middle, sides }), None) => {
                Emitter::rectangle(Vec3::from(*middle), sides.map(Vec3::from), self.speed, spacing)?
            }
            (None, None, Some(mesh)) => {
                let (points, triangles) = mesh.triangles(context, files)?;
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
    mesh: Option<MeshFile>,
    #[serde(rename = "box")]
    corners: Option<Corners>,
    sphere: Option<Ball>,
    outside: Option<Corners>,
}

impl Drain {
    /// The mesh that it is read from.
    pub fn mesh(&self) -> Option<&MeshFile> {
        self.mesh.as_ref()
    }

    fn sink(&self, context: &Context, files: &Source) -> Result<Sink> {
        let ends = |corners: &Corners| [Vec3::from(corners.low), Vec3::from(corners.high)];
        match (&self.outside, &self.mesh, &self.corners, &self.sphere) {
            (Some(corners), None, None, None) => Ok(Sink::Outside(ends(corners))),
            (None, None, Some(corners), None) => Ok(Sink::Inside(ends(corners))),
            (None, mesh, corners, ball) => {
                let shape = Shape { mesh: mesh.as_ref(), corners: corners.as_ref(), sphere: ball.as_ref() };
                let (points, triangles) = shape.triangles(context, files)?;
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
    files: &Source,
    spacing: f32,
    (outlets, drains, budget): (&[Outlet], &[Drain], Option<&Budget>),
) -> Result<Sources> {
    let named = |kind: &'static str, number: usize| move |error: Error| error.at(format!("{kind} {number}"));
    let emitters = outlets
        .iter()
        .enumerate()
        .map(|(number, outlet)| outlet.emitter(context, files, spacing).map_err(named("emitter", number)));
    let sinks =
        drains.iter().enumerate().map(|(number, drain)| drain.sink(context, files).map_err(named("sink", number)));
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
