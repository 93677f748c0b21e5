//! The hierarchy of a surface with boxes that follow its displacement: where brushes look for tiles.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 3: the box
//! of a brush is tested against the boxes of faces, extended by how far they are displaced, and only then against their
//! parts. Here the boxes are in a hierarchy, and an edit refits those of the tiles it changed, so that neither the size
//! of the mesh nor a deep edit elsewhere counts. Units: object units.

use std::collections::BTreeMap;

use relievo_core::Context;
use relievo_surface::Surface;
use relievo_tiles::Field;

use crate::hierarchy::{Bounds, Hierarchy};
use crate::object::{tile_bounds, tile_cone};

/// What is known of a displaced tile.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Known {
    /// The edit that last changed it, 0 where the range covers more than it has now.
    version: u64,
    range: [f32; 2],
}

/// Boxes of displaced tiles.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    hierarchy: Hierarchy,
    /// Tiles whose box is not that of the undisplaced surface.
    known: BTreeMap<u32, Known>,
    /// The number of the last edit that it has seen.
    revision: u64,
    /// Whether boxes of tiles cover more than they have now.
    loose: bool,
}

impl Fit {
    /// The boxes of a surface without displacement, which `hierarchy` has, before any edit was seen.
    pub fn new(hierarchy: &Hierarchy) -> Self {
        Self { hierarchy: hierarchy.clone(), known: BTreeMap::new(), revision: u64::MAX, loose: false }
    }

    /// The boxes.
    pub fn hierarchy(&self) -> &Hierarchy {
        &self.hierarchy
    }

    /// Whether it has seen the edit of this number and all before.
    pub fn has_seen(&self, revision: u64) -> bool {
        self.revision == revision
    }

    /// Knows no more what it has seen: anything may have been done.
    pub fn forget(&mut self) {
        self.revision = u64::MAX;
        self.known.values_mut().for_each(|known| known.version = 0);
    }

    /// The range of displacement that the box of a tile covers.
    pub fn range(&self, tile: u32) -> [f32; 2] {
        self.known.get(&tile).map_or([0.0; 2], |known| known.range)
    }

    /// Refits what edits up to `revision` changed. With `start`, boxes cover that displacement too.
    pub fn follow(
        &mut self,
        context: &Context,
        surface: &Surface,
        field: &Field,
        start: Option<&Field>,
        revision: u64,
    ) {
        if self.has_seen(revision) && (start.is_some() || !self.loose) {
            return;
        }
        let mut tiles: Vec<u32> = field.allocated().chain(self.known.keys().copied()).collect();
        tiles.extend(start.into_iter().flat_map(|start| start.allocated()));
        tiles.sort_unstable();
        tiles.dedup();
        let changed = |tile: &u32| {
            start.is_some() || self.known.get(tile).map_or(0, |known| known.version) != field.version(*tile).max(1)
        };
        tiles.retain(changed);
        self.loose = false;
        self.refit(context, surface, field, start, &tiles, revision);
    }

    /// Refits `tiles`, which are all that changed up to `revision`. With `start`, boxes cover that displacement too.
    pub fn refit(
        &mut self,
        context: &Context,
        surface: &Surface,
        field: &Field,
        start: Option<&Field>,
        tiles: &[u32],
        revision: u64,
    ) {
        let fitted = context.map(tiles.len(), |index| {
            let tile = tiles[index];
            let ranges = start.map_or([0.0; 2], |start| start.range(tile));
            let now = field.range(tile);
            let range = [now[0].min(ranges[0]), now[1].max(ranges[1])];
            (tile, range, extended(surface, tile, range), range == [now[0].min(0.0), now[1].max(0.0)])
        });
        let boxes: Vec<(u32, Bounds)> = fitted.iter().map(|(tile, _, bounds, _)| (*tile, *bounds)).collect();
        self.hierarchy.update(&boxes);
        for (tile, range, _, exact) in fitted {
            if range == [0.0; 2] && !field.is_allocated(tile) {
                self.known.remove(&tile);
            } else {
                self.loose |= !exact;
                let version = if exact { field.version(tile).max(1) } else { 0 };
                self.known.insert(tile, Known { version, range });
            }
        }
        self.revision = revision;
    }

    /// Takes the boxes of the surface in another pose, which `hierarchy` has without displacement.
    pub fn pose(&mut self, surface: &Surface, hierarchy: &Hierarchy) {
        self.hierarchy = hierarchy.clone();
        let boxes: Vec<(u32, Bounds)> =
            self.known.iter().map(|(tile, known)| (*tile, extended(surface, *tile, known.range))).collect();
        self.hierarchy.update(&boxes);
    }
}

/// The box of a tile that is displaced by a range along its normals.
fn extended(surface: &Surface, tile: u32, [least, most]: [f32; 2]) -> Bounds {
    let mut bounds = tile_bounds(surface, tile);
    if bounds.is_empty() || [least, most] == [0.0; 2] {
        return bounds;
    }
    let cone = tile_cone(surface, tile);
    // Edges may be evaluated in a neighbour, whose patches and coefficients are rounded apart from these.
    let slack = 1e-3 * least.abs().max(most.abs()) + 1e-6 * surface.extent();
    for axis in 0..3 {
        let (against, along) = cone.span([0, 1, 2].map(|other: usize| f32::from(u8::from(other == axis))));
        let ends = [least * against, least * along, most * against, most * along];
        bounds.low[axis] += ends.into_iter().fold(f32::INFINITY, f32::min) - slack;
        bounds.high[axis] += ends.into_iter().fold(f32::NEG_INFINITY, f32::max) + slack;
    }
    bounds
}
