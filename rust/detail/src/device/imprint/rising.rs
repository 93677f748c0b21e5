//! What imprints of a submission raise, as kernels of rims get it.

use glam::DAffine3;

use crate::geometry::grid::Grid;
use crate::imprint::rim::{highest, surroundings};
use crate::imprint::settings::ImprintSettings;

/// What an imprint raises.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rising {
    pub share: f32,
    pub width: f32,
    pub highest: f32,
}

impl Rising {
    /// What imprints of these settings raise; `None` where they raise nothing.
    pub fn of(settings: &ImprintSettings) -> Option<Self> {
        let rising = Self { share: settings.rim, width: settings.rim_width, highest: highest(settings) };
        (settings.rim > 0.0).then_some(rising)
    }

    /// The grid of nothing but the box in which something may rise, around that of an imprint.
    pub fn grid(&self, grid: &Grid, transform: &DAffine3) -> Grid {
        surroundings(&grid.obb, transform, self.width)
    }
}
