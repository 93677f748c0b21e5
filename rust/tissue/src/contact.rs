//! Pressures of contact: the force with which a collider holds a node, by the node's share of the surface.

use glam::Vec3;
use relievo_core::Context;

use crate::block::Row;
use crate::collider::{Collider, place};
use crate::model::Model;
use crate::pressure::areas;
use crate::simulation::State;

/// The share of an edge within which a node touches a collider. A node that is pushed is on its surface but for rounding.
pub(crate) const MARGIN: f32 = 1e-3;
/// The share of the faces around a node that looks at a collider at least. Others touch it by their rims, without an area that
/// a pressure could be of.
const MIN: f32 = 1e-3;

/// The outer faces of a model where they are at present.
pub(crate) struct Surface {
    faces: Vec<[u32; 4]>,
    /// The areas of each corner of the faces as outward vectors, in m².
    shares: Vec<[Vec3; 4]>,
    /// Distance within which nodes touch, in metres.
    margin: f32,
}

impl Surface {
    /// Finds the outer faces of a model and their areas in a state.
    pub fn new(model: &Model, state: &State) -> Self {
        let faces: Vec<[u32; 4]> = model.outer_faces().into_iter().map(|(_, face)| face).collect();
        let moved = |node: u32| place(&model.nodes, state, node as usize).as_vec3();
        let shares: Vec<_> = faces.iter().map(|face| areas(face.map(moved))).collect();
        let area: f64 = shares.iter().flatten().map(|share| f64::from(share.length())).sum();
        let margin = MARGIN * (area / faces.len().max(1) as f64).sqrt() as f32;
        Self { faces, shares, margin }
    }

    /// Returns the distance within which nodes touch, in metres.
    pub fn margin(&self) -> f32 {
        self.margin
    }

    /// Returns the pressure of a collider on each node in Pa, 0 where it does not touch. `balance` returns the sum of all other
    /// forces on a node in N.
    pub fn pressures(
        &self,
        context: &Context,
        collider: &Collider,
        (nodes, state, masses): (&[[f32; 3]], &State, &[Row]),
        balance: &(impl Fn(usize) -> Vec3 + Sync),
    ) -> Vec<f32> {
        let pose = collider.pose(state.seconds);
        let touched = |node: usize| collider.touched(pose, place(nodes, state, node), self.margin);
        let normals: Vec<Option<Vec3>> = context.map(nodes.len(), touched);
        // What looks at the collider, and all, of the faces around each node.
        let mut areas = vec![[0f32; 2]; nodes.len()];
        for (node, share) in self.faces.as_flattened().iter().zip(self.shares.as_flattened()) {
            if let Some(normal) = normals[*node as usize] {
                let [facing, all] = &mut areas[*node as usize];
                *facing += (-share.dot(normal)).max(0.0);
                *all += share.length();
            }
        }
        context.map(nodes.len(), |node| {
            let (Some(normal), [facing, all]) = (normals[node], areas[node]) else { return 0.0 };
            // Along axes in which the node is held, something else may hold it.
            let free = Vec3::from_slice(&masses[node]).map(|inverse| if inverse > 0.0 { 1.0 } else { 0.0 });
            let along = free * normal;
            if facing <= MIN * all || along.length_squared() < 1e-6 {
                return 0.0;
            }
            let force = -balance(node).dot(along) / along.length_squared();
            force.max(0.0) / facing
        })
    }
}
