//! The colours of an object on a graphics device, with the brush that paints them.

use relievo_tiles::{DeviceTiles, Texel};

use super::brush::DeviceBrush;

/// Colours, and what paints them.
#[derive(Debug)]
pub(crate) struct DeviceColors<T: Texel> {
    pub tiles: DeviceTiles<T>,
    /// At a coarser level, once a dab needed them.
    pub coarse: Option<DeviceTiles<T>>,
    pub brush: Option<DeviceBrush<T>>,
}
