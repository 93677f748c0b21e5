//! The front of a patch: adds faces beyond its boundary and places their vertices.

use std::collections::{HashSet, VecDeque};

use relievo_core::{Error, Result};

use crate::map::energy::{Rest, Vec2, distance};
use crate::map::extend::extend;
use crate::map::grow::Growth;
use crate::map::patch::Joint;
use crate::map::region::buckets;
use crate::map::seed::Seed;
use crate::print::buckets::{holds, middle};
use crate::surface::{NONE, Surface, dot, minus, previous};

/// The share of its faces that a patch grows by in a round, beside the first rings.
const GROWTH: usize = 2;
/// Copies of a vertex of the surface that a sticker which overlaps itself may have.
const LAYERS: usize = 4;
/// Copies of a vertex within this many lengths of an edge are the same place of the sticker.
const REACH: f64 = 4.0;
/// The least area in the plane of a face that is upright, as a share of its area on the surface.
const UPRIGHT: f64 = 1e-3;
/// A pin is near a patch of this many times the faces around the pin out to the patch.
const ASIDE: usize = 8;

/// The faces that a round of growth adds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Faces {
    /// This many rings.
    Rings(u32),
    /// One ring of the faces that are not flipped where they are placed first.
    Upright,
    /// The faces between parts of the boundary that meet on the surface.
    Seam,
}

impl Growth<'_> {
    /// Lets the patch grow beyond the region to the pins that it does not hold. Returns whether all of them are near it. A pin at
    /// the front of a patch that it pulls bends the front, and faces that grow from there fold.
    pub fn approach(&mut self) -> bool {
        let Seed { surface, patch, .. } = &*self.seed;
        let most = patch.faces.len() / ASIDE;
        let is_held = |vertex: &u32| patch.copies(*vertex).next().is_some();
        let mut towards = HashSet::new();
        for vertex in self.vertices.iter().filter(|vertex| !is_held(vertex)) {
            let (mut ring, mut faces, mut is_near) = (vec![*vertex], HashSet::new(), false);
            while !is_near {
                if ring.is_empty() || faces.len() >= most {
                    return false;
                }
                is_near = ring.iter().any(is_held);
                let around = ring.iter().flat_map(|vertex| surface.fan(*vertex)).map(|half| half / 3);
                let added: Vec<u32> = around.filter(|face| faces.insert(*face)).collect();
                ring = added.iter().flat_map(|face| surface.triangles[*face as usize]).collect();
            }
            towards.extend(faces);
        }
        self.towards = towards;
        true
    }

    /// Adds faces within the region, and those of [`Growth::towards`].
    ///
    /// # Errors
    /// The patch grows beyond its limit.
    pub fn grow(&mut self, faces: Faces) -> Result<()> {
        let Seed { surface, patch, scale, .. } = &mut *self.seed;
        let rings = if let Faces::Rings(rings) = faces { rings } else { 1 };
        let layers = if self.limits.can_overlap { LAYERS } else { 1 };
        let mut taken = vec![0_u8; surface.triangles.len()];
        for triangle in &patch.triangles {
            let count = &mut taken[*triangle as usize];
            *count = count.saturating_add(1);
        }
        // Of each new vertex, the edges that suggested a place for it.
        let (older, mut counts) = (patch.vertices.len(), Vec::<f64>::new());
        let mut plane = buckets(patch, self.outline);
        let most = patch.faces.len() * (1 + GROWTH) + 64;
        let mut queue: VecDeque<(u32, u32)> = patch.boundary().into_iter().map(|vertex| (vertex, 0)).collect();
        while let Some((from, ring)) = queue.pop_front() {
            if !patch.is_boundary(from) || ring >= rings || patch.faces.len() >= most {
                continue;
            }
            let to = patch.after(from);
            let ends = [from, to].map(|vertex| patch.positions[vertex as usize]);
            let Some(half) = patch.beyond(surface, from) else {
                continue;
            };
            let layer = usize::from(taken[half as usize / 3]);
            let is_in_reach = self.outline.touches(ends[0], ends[1]) || self.towards.contains(&(half / 3));
            if layer >= layers || !is_in_reach {
                continue;
            }
            if patch.faces.len() >= self.limits.faces {
                return Err(Error::memory(format!("the patch grows beyond {} triangles", self.limits.faces))
                    .at("decal")
                    .advise("make the sticker smaller, simplify the surface, or raise the limit"));
            }
            let joint = patch.joint(surface, from, half);
            match joint {
                Joint::Blocked => continue,
                Joint::New => {
                    let position = unfold(surface, half, ends, *scale);
                    let copies = || patch.copies(surface.origin(previous(half)));
                    let reach = REACH * distance(ends[0], position).max(distance(ends[1], position));
                    let is_near = |copy: u32| distance(patch.positions[copy as usize], position) < reach;
                    // A copy of the vertex may be reached along the boundary later: seams wait until it was not.
                    let waits = if faces == Faces::Seam {
                        layer > 0
                    } else {
                        copies().count() >= layers || copies().any(is_near)
                    };
                    // Beside an edge the plane may be taken by faces of a vertex with more than a full turn around it.
                    let is_beside = |face: u32| patch.faces[face as usize].iter().any(|end| [from, to].contains(end));
                    let corners = [ends[0], ends[1], position];
                    let at = middle(corners);
                    if waits || plane.at(at).any(|face| !is_beside(face) && holds(patch.corners(face), at)) {
                        continue;
                    }
                    plane.insert(patch.faces.len() as u32, corners);
                    if let Some(vertex) = patch.add(surface, from, half, joint, position) {
                        counts.push(1.0);
                        queue.push_back((from, ring + 1));
                        queue.push_back((vertex, ring + 1));
                    }
                }
                Joint::Start(third) | Joint::End(third) => {
                    let apex = patch.positions[third as usize];
                    if faces == Faces::Upright {
                        let area = 0.5 * turn(ends[1], ends[0], apex);
                        if area <= UPRIGHT * scale.powi(2) * surface.area(half / 3) {
                            continue;
                        }
                    } else if let Some(count) = (third as usize).checked_sub(older).and_then(|at| counts.get_mut(at)) {
                        // A vertex of this round moves to the mean of the places that the edges around it suggest.
                        let guess = unfold(surface, half, ends, *scale);
                        *count += 1.0;
                        let position = &mut patch.positions[third as usize];
                        *position =
                            std::array::from_fn(|axis| position[axis] + (guess[axis] - position[axis]) / *count);
                    }
                    patch.add(surface, from, half, joint, [0.0; 2]);
                    // The edges beside the closed gap may close now as well.
                    let start = if matches!(joint, Joint::Start(_)) { third } else { from };
                    queue.push_front((start, ring));
                }
            }
            taken[half as usize / 3] += 1;
        }
        patch.shrink();
        Ok(())
    }

    /// Places the vertices of the faces from `first` on that no older face has.
    ///
    /// # Errors
    /// Memory does not suffice.
    pub fn extend(&mut self, first: usize) -> Result<()> {
        let Seed { surface, patch, scale, .. } = &mut *self.seed;
        let mut number = vec![NONE; patch.vertices.len()];
        let (mut is_fixed, mut positions) = (Vec::new(), Vec::new());
        let mut is_old = vec![false; patch.vertices.len()];
        for vertex in patch.faces[..first].as_flattened() {
            is_old[*vertex as usize] = true;
        }
        let mut local = |vertex: u32| {
            let local = &mut number[vertex as usize];
            if *local == NONE {
                *local = is_fixed.len() as u32;
                is_fixed.push(is_old[vertex as usize]);
                positions.push(patch.positions[vertex as usize]);
            }
            *local
        };
        let faces: Vec<[u32; 3]> = patch.faces[first..].iter().map(|face| face.map(&mut local)).collect();
        let rest: Vec<Rest> =
            patch.triangles[first..].iter().map(|triangle| Rest::new(surface.corners(*triangle), *scale)).collect();
        extend(&faces, &rest, &is_fixed, &mut positions)?;
        for (position, local) in patch.positions.iter_mut().zip(number).filter(|(_, local)| *local != NONE) {
            *position = positions[local as usize];
        }
        Ok(())
    }
}

/// Twice the signed area of a triangle of the plane.
fn turn(a: Vec2, b: Vec2, c: Vec2) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The place of the third corner of the face beyond an edge. The face keeps its shape and the scale of the patch, so that
/// a stretched edge does not stretch all that follows.
fn unfold(surface: &Surface, half: u32, ends: [Vec2; 2], scale: f64) -> Vec2 {
    // `half` runs from the second end to the first.
    let (from, to, apex) = (surface.origin(half), surface.target(half), surface.origin(previous(half)));
    let [from, to, apex] = [from, to, apex].map(|vertex| surface.points[vertex as usize]);
    let (edge, way) = (minus(to, from), minus(apex, from));
    let length = dot(edge, edge).sqrt().max(f64::MIN_POSITIVE.sqrt());
    let along = dot(way, edge) / length;
    let height = (dot(way, way) - along * along).max(0.0).sqrt();
    let axis = [ends[0][0] - ends[1][0], ends[0][1] - ends[1][1]];
    let base = axis[0].hypot(axis[1]).max(f64::MIN_POSITIVE.sqrt());
    let (along, across) = (scale * (along - 0.5 * length) / base, scale * height / base);
    let middle = [0.5 * (ends[0][0] + ends[1][0]), 0.5 * (ends[0][1] + ends[1][1])];
    [middle[0] + along * axis[0] - across * axis[1], middle[1] + along * axis[1] + across * axis[0]]
}
