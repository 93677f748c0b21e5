//! Directions among attributes: how normals and tangents of wedges turn where vertices have moved (Derzapf, Grund, Guthe
//! 2014, Section 4.1).
//!
//! What wedges have is kept as it was built. A vertex that has moved has a linear map of those around it, from where they
//! were built to where they are, and its wedges have their normals by the inverse transpose of that and their tangents by
//! the map itself. That is found when it is asked for: it follows from the mesh as it is, whatever was before.

use glam::Vec3;
use relievo_core::{Attribute, Domain};

use super::place::{Place, Surroundings};
use crate::simplify::mesh::is_direction;

/// Where directions begin among the numbers of a wedge.
#[derive(Clone, Copy, Debug, Default)]
pub struct Directions {
    normal: Option<usize>,
    tangent: Option<usize>,
}

impl Directions {
    /// Those of attributes.
    pub fn of(attributes: &[Attribute]) -> Self {
        let (mut made, mut first) = (Self::default(), 0);
        for attribute in attributes.iter().filter(|attribute| attribute.domain != Domain::Face) {
            if is_direction(attribute) {
                let kind = if attribute.name == "normal" { &mut made.normal } else { &mut made.tangent };
                *kind = Some(first);
            }
            first += attribute.width as usize;
        }
        made
    }

    /// Whether it is empty.
    pub fn is_empty(&self) -> bool {
        self.normal.is_none() && self.tangent.is_none()
    }

    /// Where the numbers of a normal and of a tangent begin.
    pub fn places(&self) -> [Option<usize>; 2] {
        [self.normal, self.tangent]
    }

    /// Turns the directions of a wedge from how they were built to how they are about a vertex.
    pub fn turn(&self, around: &Surroundings, vertex: [Place; 2], values: &mut [f32]) {
        let mut normals = vertex.map(|place| place.normal);
        if let Some(at) = self.normal {
            let built = Vec3::from_slice(&values[at..]);
            let now = around.normal(built);
            now.write_to_slice(&mut values[at..]);
            normals = [built, now].map(Vec3::normalize_or_zero);
        }
        if let Some(at) = self.tangent {
            around.tangent(Vec3::from_slice(&values[at..]), normals).write_to_slice(&mut values[at..]);
        }
    }
}
