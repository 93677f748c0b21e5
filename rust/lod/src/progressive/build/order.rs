//! Where splits deviate more than their order says.
//!
//! The order of splits and what they deviate by stay those of the mesh that was built, whatever is edited (Derzapf, Grund,
//! Guthe 2014, Section 7: it "is fixed after initial simplification", and to simplify anew "might be desirable after huge
//! deformations"). What a split deviates by now is found as simplification does: what its two vertices do, and how far the
//! vertex that is split is from the planes of the triangles around those, by root mean square.

use glam::{Vec3, Vec3A};
use relievo_core::Context;

use super::hierarchy::{Child, LEAF, Progressive};
use crate::connectivity::NONE;
use crate::progressive::edit::moves::Moves;
use crate::progressive::edit::place::Place;
use crate::progressive::mesh::active::{ActiveMesh, Waiting};
use crate::simplify::decimation::normal;

/// Splits of one task.
const CHUNK_LEN: usize = 64;
/// How many times as much as it says a split deviates that is out of order.
const MORE: f32 = 2.0;
/// Deviations, in extents of the mesh, that rounding makes.
const MIN: f32 = 1e-5;

/// A split that is out of order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misplaced {
    /// Where the vertex is that it splits.
    pub point: [f32; 3],
    /// What it deviates by as the levels tell it.
    pub told: f32,
    /// What it deviates by.
    pub now: f32,
}

impl ActiveMesh {
    /// The splits that deviate more than twice as much as they tell, the most deviating first: meshes as coarse as
    /// they are deviate more than was asked for, and keep triangles elsewhere that are needed here. [`Self::rebuilt`] puts
    /// them in order. All splits are looked at.
    pub fn misplaced(&mut self, context: &Context) -> Vec<Misplaced> {
        // All places are known there.
        self.at_finest(context, |mesh| {
            let is_edited = mesh.moves.is_some();
            let mut moves = mesh.moves.take().unwrap_or_else(|| Moves::new(mesh.whole.vertex_count()));
            let found = context.within(|| {
                moves.stars.complete(context, mesh);
                find(context, &mesh.whole, &moves)
            });
            mesh.moves = is_edited.then_some(moves);
            found
        })
    }
}

fn find(context: &Context, whole: &Progressive, moves: &Moves) -> Vec<Misplaced> {
    let mut waiting = Waiting::default();
    whole.splits().for_each(|(split, key, _)| waiting.add(key.depth(), split));
    let least = MIN / whole.scale();
    let mut deviations = vec![0.0; whole.vertex_count()];
    let mut found = Vec::new();
    // What a split becomes is less deep.
    for splits in waiting.0 {
        let known = &deviations;
        let made = context.map(splits.len().div_ceil(CHUNK_LEN), |part| {
            let mut measuring = Measuring { whole, moves, points: Vec::new(), counts: Vec::new() };
            let splits = &splits[part * CHUNK_LEN..splits.len().min((part + 1) * CHUNK_LEN)];
            splits.iter().map(|split| measuring.deviation(*split, known)).collect::<Vec<_>>()
        });
        for (split, now) in splits.into_iter().zip(made.into_iter().flatten()) {
            deviations[split as usize] = now;
            let told = whole.splits[split as usize].key.error();
            if now > MORE * told + least {
                found.push(Misplaced { point: before_split(whole, moves, split).point.to_array(), told, now });
            }
        }
    }
    found.sort_by(|a, b| b.now.total_cmp(&a.now));
    found
}

/// Where the vertex is that a split splits.
fn before_split(whole: &Progressive, moves: &Moves, split: u32) -> Place {
    moves.place(whole.parent(split)).unwrap_or_else(|| whole.place(Child::Split(split), split))
}

/// What is needed to find what splits deviate by.
struct Measuring<'a> {
    whole: &'a Progressive,
    moves: &'a Moves,
    /// Of the ring of a split and its two vertices, from the vertex that is split.
    points: Vec<Vec3>,
    /// How many triangles at a vertex have each of them.
    counts: Vec<u8>,
}

impl Measuring<'_> {
    /// What a split deviates by, with what its two vertices do.
    fn deviation(&mut self, split: u32, known: &[f32]) -> f32 {
        let (whole, moves, scale) = (self.whole, self.moves, self.whole.scale());
        let star = moves.stars.star(split);
        let here = before_split(whole, moves, split).point;
        let nodes = star.ring.iter().copied().chain([2 * split, 2 * split + 1]);
        self.points.clear();
        self.points.extend(nodes.map(|node| {
            let place = moves.place(node).unwrap_or_else(|| whole.node_place(node));
            (place.point - here) * scale
        }));
        let (mut sum, mut weight) = (0.0, 0.0);
        for side in 0..2 {
            let from = self.points[star.end(side)];
            self.counts.clear();
            self.counts.resize(self.points.len(), 0);
            for [after, before] in star.spokes(side) {
                [after, before].into_iter().for_each(|end| self.counts[end] = self.counts[end].saturating_add(1));
                // Those at both vertices are looked at from the first.
                if side == 0 || ![after, before].contains(&star.end(0)) {
                    let [after, before] = [after, before].map(|end| Vec3A::from(self.points[end] - from));
                    let normal = normal(after, before);
                    sum += normal.dot(from.into()).powi(2);
                    weight += normal.length_squared();
                }
            }
            // Boundaries hold by the distance from the lines of their edges.
            let borders = self.counts.iter().enumerate().filter(|(_, count)| **count == 1);
            for (end, _) in borders.filter(|(end, _)| side == 0 || *end != star.end(0)) {
                let along = self.points[end] - from;
                sum += along.cross(from).length_squared();
                weight += 2.0 * along.length_squared();
            }
        }
        let ends = whole.splits[split as usize].children;
        let of_ends = ends.into_iter().filter(|child| child & LEAF == 0 && *child != NONE);
        let before = of_ends.map(|child| known[child as usize]).fold(0.0, f32::max);
        before + (sum / f32::max(weight, 1e-30)).sqrt() / scale
    }
}
