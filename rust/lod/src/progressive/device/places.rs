//! Where the vertices of an edited mesh are on a device, by their nodes.

use relievo_core::Result;
use relievo_gpu::wgsl::progressive::Place;
use relievo_gpu::{Access, Bindings, Device};

use super::hierarchy::DeviceHierarchy;
use super::windows::Windows;
use crate::progressive::edit::place;

/// Returns the place of a node on a device, if it is elsewhere than it was built.
pub fn sent(place: Option<place::Place>) -> Place {
    let moved = u32::from(place.is_some());
    let place::Place { point, normal } = place.unwrap_or_default();
    Place { point: point.to_array(), moved, normal: normal.to_array(), padding: 0 }
}

/// Returns where a node is, if it is elsewhere than it was built.
pub fn received(place: &Place) -> Option<place::Place> {
    let moved = place::Place { point: place.point.into(), normal: place.normal.into() };
    (place.moved == 1).then_some(moved)
}

/// Places of all nodes.
#[derive(Debug)]
pub struct Places {
    pub nodes: Windows<Place, 2>,
    /// As in `progressive_edited.wgsl`.
    pub bindings: Bindings,
}

impl Places {
    /// Of a mesh that is not edited yet. Fails where the device has no memory.
    pub fn new(whole: &DeviceHierarchy) -> Result<Self> {
        Self::of_nodes(&whole.device, 2 * whole.vertices, whole.window)
    }

    /// In place of those of a mesh that has none.
    pub fn none(whole: &DeviceHierarchy) -> Result<Self> {
        Self::of_nodes(&whole.device, 0, whole.window)
    }

    fn of_nodes(device: &Device, nodes: usize, window: u64) -> Result<Self> {
        let nodes = Windows::new(device, "places", nodes, window)?;
        Ok(Self { bindings: device.bind_as(&[Access::Write; 2], &nodes.wgpu())?, nodes })
    }

    /// The constants of the bindings.
    pub fn constants(&self) -> [(&'static str, f64); 1] {
        [("PLACES", self.nodes.size())]
    }
}
