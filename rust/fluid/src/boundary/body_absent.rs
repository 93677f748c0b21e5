//! Rigid bodies in a build without the feature `rapier3d`: the list is empty, and adding one fails.

use glam::{Quat, Vec3};
use relievo_core::{Context, Error, Result};

use crate::boundary::body_state::{BodyOptions, BodyState};
use crate::{Fluid, StepStatistics};

fn absent() -> Error {
    Error::unsupported("this build has no rigid bodies").advise("build with the feature `rapier3d`")
}

/// The rigid bodies of a fluid, of which this build has none.
#[derive(Debug)]
pub struct Bodies {
    obstacles: usize,
}

impl Bodies {
    /// Returns none.
    pub fn new(_: Vec3, _: Option<[Vec3; 2]>) -> Self {
        Self { obstacles: 0 }
    }

    /// Returns 0.
    pub fn len(&self) -> usize {
        0
    }

    /// Returns true.
    pub fn is_empty(&self) -> bool {
        true
    }

    /// Fails.
    pub fn add(&mut self, _: &Context, _: &mut Fluid, _: (&[Vec3], &[[u32; 3]]), _: &BodyOptions) -> Result<usize> {
        Err(absent())
    }

    /// Counts a mesh that no body meets and returns its number.
    pub fn add_obstacle(&mut self, _: &[Vec3], _: &[[u32; 3]]) -> Result<usize> {
        self.obstacles += 1;
        Ok(self.obstacles - 1)
    }

    /// Does nothing, since no body meets an obstacle.
    pub fn move_obstacle(&mut self, _: usize, _: [(Quat, Vec3); 2]) -> Result<()> {
        Ok(())
    }

    /// Does nothing, since no body meets an obstacle.
    pub fn bend_obstacle(&mut self, _: usize, _: [&[Vec3]; 2]) -> Result<()> {
        Ok(())
    }

    /// Returns no pose.
    pub fn pose(&self, _: usize) -> Option<(Quat, Vec3)> {
        None
    }

    /// Returns no states.
    pub fn states(&self) -> Vec<BodyState> {
        Vec::new()
    }

    /// Fails unless there are no states.
    pub fn set_states(&mut self, states: &[BodyState]) -> Result<()> {
        if states.is_empty() { Ok(()) } else { Err(absent()) }
    }

    /// Fails; a fluid without bodies advances by its own steps.
    pub fn advance(
        &mut self,
        _: &Context,
        _: &mut Fluid,
        _: f32,
        _: impl FnMut(&mut Fluid, &StepStatistics) -> Result<()>,
    ) -> Result<()> {
        Err(absent())
    }
}
