//! Bodies in a build without the feature `rapier3d`: fixed and keyframed ones are placed, and one that forces would move
//! is an error.

use glam::DAffine3;
use relievo_core::Mesh;

use crate::format::description::{BodyEntry, Motion, Scene};
use crate::format::diagnostic::Diagnostic;
use crate::format::placement::Placement;
use crate::state::keyframe::placement_at;

/// The bodies of a scene on their way through time.
#[derive(Debug)]
pub struct Physics {
    bodies: Vec<BodyEntry>,
    rest: Vec<Placement>,
    steps: u64,
    sub_steps: u32,
    fps: f64,
}

impl Physics {
    /// Returns the bodies of `scene` at time 0. Fails if forces move one of them.
    pub fn new(scene: &Scene, _: &[&Mesh]) -> Result<Self, Diagnostic> {
        if let Some(body) = scene.bodies.iter().find(|body| body.motion == Motion::Dynamic) {
            let what = format!("body `{}`: this build has no rigid bodies that forces move", body.name.text);
            return Err(Diagnostic::new(body.name.span.clone(), what)
                .advise("build with the feature `rapier3d`, or give the body keyframes"));
        }
        Ok(Self {
            bodies: scene.bodies.clone(),
            rest: scene.objects.iter().map(|object| object.placement).collect(),
            steps: 0,
            sub_steps: scene.physics.sub_steps,
            fps: scene.fps,
        })
    }

    /// Returns the transforms of all objects now.
    pub fn transforms(&self) -> Vec<DAffine3> {
        let mut all: Vec<DAffine3> = self.rest.iter().map(Placement::transform).collect();
        for body in &self.bodies {
            let keyed = placement_at(&body.keyframes, self.time());
            if let (Some(slot), Some(placement)) = (all.get_mut(body.object), keyed) {
                *slot = placement.transform();
            }
        }
        all
    }

    /// Returns the frame that the bodies have reached.
    pub fn frame(&self) -> u32 {
        (self.steps / u64::from(self.sub_steps)) as u32
    }

    /// Returns the seconds since the start.
    pub fn time(&self) -> f64 {
        self.steps as f64 / (self.fps * f64::from(self.sub_steps))
    }

    /// Goes on by one frame. Returns the transforms of all objects after every sub-step; the last are the new frame's.
    pub fn advance(&mut self) -> Vec<Vec<DAffine3>> {
        (0..self.sub_steps)
            .map(|_| {
                self.steps += 1;
                self.transforms()
            })
            .collect()
    }
}
