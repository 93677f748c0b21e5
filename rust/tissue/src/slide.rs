//! Nodes that stay at a signed distance from a surface (Section 4.4).

use glam::Vec3;
use relievo_core::{Context, Result};

use crate::block::Row;
use crate::distance::DistanceField;
use crate::model::{Model, Sliding};
use crate::simulation::State;

/// Nodes that slide, and the surfaces they slide on.
#[derive(Debug, Default)]
pub(crate) struct Slides {
    fields: Vec<DistanceField>,
    sliding: Vec<Sliding>,
    /// The closest triangle of each when it was last asked for.
    near: Vec<u32>,
    /// The place in `sliding` of each node that slides, by node; empty if none does.
    of_node: Vec<u32>,
}

impl Slides {
    pub fn new(model: &Model) -> Result<Self> {
        let field = |shape: &crate::model::Shape| {
            DistanceField::new(&shape.points, &shape.triangles)
                .map_err(|error| error.at(format!("surface `{}`", shape.name)))
        };
        let fields = model.surfaces.iter().map(field).collect::<Result<Vec<_>>>()?;
        let sliding = model.sliding.clone();
        let mut slides = Self { fields, near: vec![0; sliding.len()], sliding, of_node: Vec::new() };
        slides.number(model.nodes.len());
        Ok(slides)
    }

    /// Returns the nodes that slide, and the surfaces they slide on.
    pub fn parts(&self) -> (&[Sliding], &[DistanceField]) {
        (&self.sliding, &self.fields)
    }

    /// Returns whether a node slides on several surfaces.
    pub fn are_crossed(&self) -> bool {
        let is_other = |(place, sliding): (u32, &Sliding)| self.of_node[sliding.node as usize] != place;
        (0u32..).zip(&self.sliding).any(is_other)
    }

    /// Leaves out nodes that are held or driven along every axis.
    pub fn keep_free(&mut self, masses: &[Row]) {
        self.sliding.retain(|sliding| masses[sliding.node as usize][..3].iter().any(|inverse| *inverse > 0.0));
        self.near = vec![0; self.sliding.len()];
        self.number(masses.len());
    }

    fn number(&mut self, nodes: usize) {
        self.of_node = vec![u32::MAX; if self.sliding.is_empty() { 0 } else { nodes }];
        for (place, sliding) in (0u32..).zip(&self.sliding) {
            self.of_node[sliding.node as usize] = place;
        }
    }

    /// Puts the nodes back to their distances, and their velocities along.
    pub fn keep(&mut self, context: &Context, nodes: &[[f32; 3]], state: &mut State, dt: f32) {
        let (sliding, fields, near) = (&self.sliding, &self.fields, &self.near);
        let kept = context.map(sliding.len(), |place| {
            let Sliding { node, surface, distance } = sliding[place];
            let (rest, u) = (Vec3::from(nodes[node as usize]), Vec3::from_slice(&state.displacements[node as usize]));
            let field = &fields[surface as usize];
            let mut triangle = near[place];
            let mut moved = u;
            // Where the surface is curved one correction is not exact; the second is to rounding.
            for _ in 0..2 {
                let closest = field.closest(rest + moved, Some(triangle));
                triangle = closest.triangle;
                let away = rest + moved - closest.point;
                let along = if closest.distance.abs() > 1e-9 { away / closest.distance } else { closest.normal };
                moved += along * (distance - closest.distance);
            }
            (triangle, moved - u, moved)
        });
        for ((sliding, near), (triangle, correction, moved)) in self.sliding.iter().zip(&mut self.near).zip(kept) {
            let node = sliding.node as usize;
            *near = triangle;
            for axis in 0..3 {
                state.displacements[node][axis] = moved[axis];
                state.velocities[node][axis] += correction[axis] / dt;
            }
        }
    }

    /// Returns the part of a force along which a node may move.
    pub fn free_part(&self, node: usize, nodes: &[[f32; 3]], state: &State, force: Vec3) -> Vec3 {
        let Some(place) = self.of_node.get(node).filter(|place| **place != u32::MAX) else { return force };
        let sliding = &self.sliding[*place as usize];
        let at = Vec3::from(nodes[node]) + Vec3::from_slice(&state.displacements[node]);
        let closest = self.fields[sliding.surface as usize].closest(at, Some(self.near[*place as usize]));
        force - closest.normal * force.dot(closest.normal)
    }
}
