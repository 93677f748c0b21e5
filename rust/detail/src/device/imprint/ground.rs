//! The displacement of an object, bound for kernels that ask where vectors bring places
//! (`shaders/imprint/imprint_vectors.wgsl`).

use relievo_core::Result;
use relievo_gpu::{Access, Bindings, Device};
use relievo_tiles::{DeviceTiles, Vector};

/// What such kernels have as their group 2: heights, then vectors or, without vectors, anything.
pub(super) const GROUND_GROUP: [Access; 4] = [Access::Read; 4];

/// The constants of kernels for objects without vectors, and for objects with vectors.
pub(super) const WITHOUT_AND_WITH_VECTORS: [[(&str, f64); 1]; 2] = [[("VECTORS", 0.0)], [("VECTORS", 1.0)]];

/// What is bound of an object as that group.
#[derive(Debug)]
pub(super) struct BoundGround {
    pub group: Bindings,
    /// Whether there are vectors.
    pub has_vectors: bool,
}

impl BoundGround {
    /// The displacement by `heights` and then `vectors`. Fails where the device does.
    pub fn of(device: &Device, heights: &DeviceTiles, vectors: Option<&DeviceTiles<Vector>>) -> Result<Self> {
        let heights = heights.buffers();
        let bound = [heights, vectors.map_or(heights, DeviceTiles::buffers)].concat();
        Ok(Self { group: device.bind_as(&GROUND_GROUP, &bound)?, has_vectors: vectors.is_some() })
    }
}
