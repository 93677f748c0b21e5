//! Where the vertices of an edited mesh are on a device, by their nodes.

use bytemuck::{Pod, Zeroable};
use relievo_core::Result;
use relievo_gpu::{Access, Bindings, Device};

use super::hierarchy::DeviceHierarchy;
use super::windows::Windows;
use crate::progressive::edit::place;

/// As in `progressive.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Place {
    point: [f32; 3],
    moved: u32,
    normal: [f32; 3],
    padding: u32,
}

impl Place {
    /// Of a node, if it is elsewhere than it was built.
    pub fn of(place: Option<place::Place>) -> Self {
        let moved = u32::from(place.is_some());
        let place::Place { point, normal } = place.unwrap_or_default();
        Self { point: point.to_array(), moved, normal: normal.to_array(), padding: 0 }
    }

    /// Where it is, if it is elsewhere.
    pub fn get(&self) -> Option<place::Place> {
        let place = place::Place { point: self.point.into(), normal: self.normal.into() };
        (self.moved == 1).then_some(place)
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_testing::wgsl::assert_layout;
    use std::mem::offset_of;

    #[test]
    fn layouts_are_those_of_the_shaders() {
        let place = [
            ("point", offset_of!(Place, point)),
            ("moved", offset_of!(Place, moved)),
            ("normal", offset_of!(Place, normal)),
        ];
        assert_layout("progressive", "Place", size_of::<Place>(), &place);
    }
}
