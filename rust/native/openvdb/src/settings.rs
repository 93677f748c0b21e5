//! The numbers that conversions and changes of grids take, in one table for hosts.

use relievo_core::{Context, Progress, Result};

use crate::edit::{Filter, Order};
use crate::grid::Grid;
use crate::surface::Polygons;
use crate::transform::Transform;

relievo_core::parameters! {
    /// How grids are made, changed and meshed.
    pub struct GridSettings {
        /// The edge of a voxel of grids that are made of meshes or particles, or resampled.
        voxel: f32 = 0.1, 1e-9..=1e9, "world units";
        /// Half the width of the band of distances that a level set has.
        band: f32 = 3.0, 1.0..=100.0, "voxels";
        /// The radius of particles; 0 for their spacing.
        radius: f32 = 0.0, 0.0..=1e9, "world units";
        /// The value at the surface: 0 of level sets, the density of fog, 0.5 of masks made numbers.
        value: f32 = 0.0, -1e9..=1e9, "";
        /// How much polygons grow where the surface is flat; 0 for quads of one size.
        adaptivity: f32 = 0.0, 0.0..=1.0, "";
        /// How far a surface is moved outwards; inwards if it is negative.
        distance: f32 = 0.0, -1e9..=1e9, "world units";
        /// Half the width of a filter.
        width: u32 = 1, 1..=100, "voxels";
        /// How often a filter is applied.
        iterations: u32 = 1, 1..=1000, "";
    }
}

/// Ways in which a grid is made of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// A surface is moved by the distance.
    Offset,
    /// Values are smoothed by a filter of the width, so often as there are iterations.
    Smooth(Filter),
    /// Voxels get the edge that is asked for; values are interpolated.
    Resample(Order),
    /// A level set becomes fog.
    Fog,
    /// Fog at the value, or a mask, becomes a level set with the band.
    LevelSet,
}

impl Grid {
    /// Makes a grid of it.
    ///
    /// # Errors
    /// Fails with `Invalid` if a setting is out of its range, and as the function of the change does.
    pub fn changed(
        &self,
        context: &Context,
        change: Change,
        settings: &GridSettings,
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        settings.check()?;
        match change {
            Change::Offset => self.offset(context, settings.distance.into(), progress),
            Change::Smooth(filter) => self.filtered(context, filter, settings.width, settings.iterations, progress),
            Change::Resample(order) => {
                self.resampled(context, &Transform::uniform(settings.voxel.into()), order, progress)
            }
            Change::Fog => self.fog(context, progress),
            Change::LevelSet => self.level_set(context, settings.value.into(), settings.band, progress),
        }
    }

    /// Meshes it at the value with the adaptivity of settings.
    ///
    /// # Errors
    /// Fails with `Invalid` if a setting is out of its range, and as [`Grid::polygons`] does.
    pub fn meshed(&self, context: &Context, settings: &GridSettings, progress: &mut dyn Progress) -> Result<Polygons> {
        settings.check()?;
        self.polygons(context, settings.value.into(), settings.adaptivity.into(), progress)
    }
}
