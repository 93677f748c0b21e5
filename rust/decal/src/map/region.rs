//! The region of the sticker in the plane, and what a patch has of it.

use std::collections::HashSet;

use crate::artwork::outline::Outline;
use crate::map::energy::Vec2;
use crate::map::grow::Growth;
use crate::map::patch::Patch;
use crate::map::seed::Seed;
use crate::print::buckets::{Buckets, holds, middle};
use crate::print::coverage::coverage;

impl Growth<'_> {
    /// Removes faces outside of the region.
    pub fn peel(&mut self) {
        let outline = self.outline;
        let inner = outline.corners()[0];
        let pinned: HashSet<u32> = self.seed.pins.iter().map(|(_, vertex)| *vertex).collect();
        let is_doubled = doubled(&self.seed.patch, outline);
        let is_wanted = |patch: &Patch, face: usize| {
            let vertices = patch.faces[face];
            let corners = vertices.map(|vertex| patch.positions[vertex as usize]);
            let side = |a: Vec2, b: Vec2| (b[0] - a[0]) * (inner[1] - a[1]) - (b[1] - a[1]) * (inner[0] - a[0]);
            let is_within = (0..3).any(|corner| outline.touches(corners[corner], corners[(corner + 1) % 3]))
                || (0..3).all(|corner| side(corners[corner], corners[(corner + 1) % 3]) >= 0.0);
            vertices.iter().any(|vertex| pinned.contains(vertex)) || (is_within && !is_doubled[face])
        };
        let old = self.seed.patch.peel(&self.seed.surface, &is_wanted);
        for (_, vertex) in &mut self.seed.pins {
            if let Some(number) = old.iter().position(|old| old == vertex) {
                *vertex = number as u32;
            }
        }
        (self.watch)(&self.seed.patch);
    }
}

/// Returns the share of a sticker that a patch shows, and shows once.
pub fn once(seed: &Seed, outline: &Outline) -> f64 {
    let coverage = coverage(outline, &seed.patch.faces, &seed.patch.positions);
    coverage.covered - coverage.doubled
}

/// Returns whether no boundary edge of a patch with a face beyond touches the region.
pub fn is_covered(seed: &Seed, outline: &Outline) -> bool {
    let patch = &seed.patch;
    patch.boundary().iter().all(|from| {
        let ends = [*from, patch.after(*from)].map(|vertex| patch.positions[vertex as usize]);
        patch.beyond(&seed.surface, *from).is_none() || !outline.touches(ends[0], ends[1])
    })
}

/// The faces of a patch in the plane.
pub fn buckets(patch: &Patch, outline: &Outline) -> Buckets {
    let mut buckets = Buckets::new(outline.bounds(), patch.faces.len());
    for (face, vertices) in patch.faces.iter().enumerate() {
        buckets.insert(face as u32, vertices.map(|vertex| patch.positions[vertex as usize]));
    }
    buckets
}

/// Whether an older face that shares no vertex with it lies at the middle of each face.
fn doubled(patch: &Patch, outline: &Outline) -> Vec<bool> {
    let buckets = buckets(patch, outline);
    let is_doubled = |(face, vertices): (usize, &[u32; 3])| {
        let at = middle(patch.corners(face as u32));
        let mut older = buckets.at(at).filter(|other| (*other as usize) < face);
        older.any(|other| {
            let is_beside = patch.faces[other as usize].iter().any(|vertex| vertices.contains(vertex));
            !is_beside && holds(patch.corners(other), at)
        })
    };
    patch.faces.iter().enumerate().map(is_doubled).collect()
}
