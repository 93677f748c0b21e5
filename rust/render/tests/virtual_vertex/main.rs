//! Surfaces drawn from virtual vertices on a graphics device, against the processor.

mod patches;
mod tiles;
mod triangles;

use glam::DVec3;
use relievo_core::Values;
use relievo_render::{Camera, Frame, Picture, View};

fn view(target: DVec3, eye: DVec3, up: DVec3, size: [u32; 2]) -> View {
    let mut view = View::new(Camera::look_at(eye, target, up, 0.5).unwrap());
    [view.settings.width, view.settings.height] = size;
    view.settings.samples = 1;
    view
}

fn picture(frame: &Frame) -> Picture {
    let (depth, normal) = (Some(frame.depth.clone()), Some(frame.normal.clone()));
    Picture { color: frame.color.clone(), alpha: None, depth, normal }
}

/// Returns the contact, depth and age of the traces on a mesh, vertex by vertex.
fn traces_of(mesh: &relievo_core::Mesh) -> [Vec<f32>; 3] {
    ["contact", "depth", "age"].map(|name| match &mesh.attribute(name).unwrap().values {
        Values::F32(values) => values.clone(),
        Values::U32(_) => Vec::new(),
    })
}
