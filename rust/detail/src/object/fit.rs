//! The hierarchy of a surface with boxes that follow its displacement: where brushes look for tiles.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 3: the
//! box of a brush is tested against the boxes of faces, extended by how far they are displaced, and only then against
//! their parts. Here the boxes are in a hierarchy, and an edit refits those of the tiles it changed, so that neither
//! the size of the mesh nor a deep edit elsewhere counts. Units: object units.

use std::collections::BTreeMap;

use relievo_core::Context;
use relievo_surface::{Cone, Surface};

use crate::geometry::hierarchy::{Bounds, Hierarchy};
use crate::object::tile_bounds::{tile_bounds, tile_cone};
use crate::paint::ground::Ground;

/// What is known of a displaced tile.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Known {
    /// The edits that last changed its displacement and its vectors, 0 where the reach covers more than it has now.
    versions: [u64; 2],
    reach: Reach,
    /// Of its normals in the pose of the surface, where its box needed it.
    cone: Option<Cone>,
}

/// What a refit finds of a tile.
#[derive(Clone, Copy)]
struct Fitted {
    known: Known,
    /// The box, where it is another than before.
    bounds: Option<Bounds>,
    /// Whether the box covers no more than the tile has now.
    is_exact: bool,
}

/// How far a tile is displaced.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Reach {
    /// Along the normals: the least and the largest, 0 between them.
    pub range: [f32; 2],
    /// The longest vector.
    pub length: f32,
}

impl Reach {
    fn of(ground: &Ground<'_>, tile: u32) -> Self {
        let [least, most] = ground.heights.range(tile);
        let length = ground.vectors.map_or(0.0, |vectors| vectors.length(tile));
        Self { range: [least.min(0.0), most.max(0.0)], length }
    }

    fn with(self, other: Self) -> Self {
        let range = [self.range[0].min(other.range[0]), self.range[1].max(other.range[1])];
        Self { range, length: self.length.max(other.length) }
    }
}

/// The tiles that are displaced.
fn allocated<'a>(ground: Ground<'a>) -> impl Iterator<Item = u32> + 'a {
    ground.heights.allocated().chain(ground.vectors.into_iter().flat_map(|vectors| vectors.allocated()))
}

fn versions(ground: &Ground<'_>, tile: u32) -> [u64; 2] {
    [ground.heights.version(tile), ground.vectors.map_or(0, |vectors| vectors.version(tile))]
        .map(|version| version.max(1))
}

/// Boxes of displaced tiles.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    hierarchy: Hierarchy,
    /// Tiles whose box is not that of the undisplaced surface.
    known: BTreeMap<u32, Known>,
    /// The numbers of the last edits of displacement and of vectors that it has seen.
    revision: [u64; 2],
    /// Whether boxes of tiles cover more than they have now.
    loose: bool,
}

impl Fit {
    /// The boxes of a surface without displacement, which `hierarchy` has, before any edit was seen.
    pub fn new(hierarchy: &Hierarchy) -> Self {
        Self { hierarchy: hierarchy.clone(), known: BTreeMap::new(), revision: [u64::MAX; 2], loose: false }
    }

    /// The boxes.
    pub fn hierarchy(&self) -> &Hierarchy {
        &self.hierarchy
    }

    /// Whether it has seen the edits of these numbers and all before.
    pub fn has_seen(&self, revision: [u64; 2]) -> bool {
        self.revision == revision
    }

    /// Knows no more what it has seen: anything may have been done.
    pub fn forget(&mut self) {
        self.revision = [u64::MAX; 2];
        self.known.values_mut().for_each(|known| known.versions = [0; 2]);
    }

    /// The displacement that the box of a tile covers.
    pub fn reach(&self, tile: u32) -> Reach {
        self.known.get(&tile).map_or(Reach::default(), |known| known.reach)
    }

    /// Refits what edits up to `revision` changed. With `start`, boxes cover that displacement too.
    pub fn follow(
        &mut self,
        context: &Context,
        surface: &Surface,
        now: Ground<'_>,
        start: Option<Ground<'_>>,
        revision: [u64; 2],
    ) {
        if self.has_seen(revision) && (start.is_some() || !self.loose) {
            return;
        }
        let mut tiles = context.scratch().lend::<Vec<u32>>();
        tiles.clear();
        tiles.extend(allocated(now).chain(self.known.keys().copied()));
        tiles.extend(start.into_iter().flat_map(allocated));
        tiles.sort_unstable();
        tiles.dedup();
        let changed = |tile: &u32| {
            start.is_some() || self.known.get(tile).map_or([0; 2], |known| known.versions) != versions(&now, *tile)
        };
        tiles.retain(changed);
        self.loose = false;
        self.refit(context, surface, now, start, &tiles, revision);
    }

    /// Refits `tiles`, which are all that changed up to `revision`. With `start`, boxes cover that displacement too.
    pub fn refit(
        &mut self,
        context: &Context,
        surface: &Surface,
        now: Ground<'_>,
        start: Option<Ground<'_>>,
        tiles: &[u32],
        revision: [u64; 2],
    ) {
        let mut fitted = context.scratch().lend::<Vec<Fitted>>();
        context.map_into(tiles.len(), &mut fitted, |index| {
            let tile = tiles[index];
            let own = Reach::of(&now, tile);
            let reach = own.with(start.map_or(Reach::default(), |start| Reach::of(&start, tile)));
            let (before, mut cone) = self.known.get(&tile).map_or_else(Default::default, |it| (it.reach, it.cone));
            let bounds = (reach != before).then(|| extended(surface, tile, reach, &mut cone));
            let is_exact = reach == own;
            let versions = if is_exact { versions(&now, tile) } else { [0; 2] };
            Fitted { known: Known { versions, reach, cone }, bounds, is_exact }
        });
        let mut boxes = context.scratch().lend::<Vec<(u32, Bounds)>>();
        boxes.clear();
        boxes.extend(tiles.iter().zip(fitted.iter()).filter_map(|(tile, fitted)| Some((*tile, fitted.bounds?))));
        self.hierarchy.update(context, &boxes);
        for (tile, fitted) in tiles.iter().zip(fitted.iter()) {
            let is_allocated = now.heights.is_allocated(*tile) || now.vectors.is_some_and(|v| v.is_allocated(*tile));
            if fitted.known.reach == Reach::default() && !is_allocated {
                self.known.remove(tile);
            } else {
                self.loose |= !fitted.is_exact;
                self.known.insert(*tile, fitted.known);
            }
        }
        self.revision = revision;
    }

    /// Takes the boxes of the surface in another pose, which `hierarchy` has without displacement.
    pub fn pose(&mut self, context: &Context, surface: &Surface, hierarchy: &Hierarchy) {
        self.hierarchy.copy_from(hierarchy);
        let mut boxes = context.scratch().lend::<Vec<(u32, Bounds)>>();
        boxes.clear();
        boxes.extend(self.known.iter_mut().map(|(tile, known)| {
            known.cone = None;
            (*tile, extended(surface, *tile, known.reach, &mut known.cone))
        }));
        self.hierarchy.update(context, &boxes);
    }
}

/// Returns the box of a tile that is displaced. Computes the cone of its normals where there is none and it is needed.
fn extended(surface: &Surface, tile: u32, reach: Reach, cone: &mut Option<Cone>) -> Bounds {
    let mut bounds = tile_bounds(surface, tile);
    let Reach { range: [least, most], length } = reach;
    if bounds.is_empty() || reach == Reach::default() {
        return bounds;
    }
    let cone = *cone.get_or_insert_with(|| tile_cone(surface, tile));
    // Edges may be evaluated in a neighbour, whose patches and coefficients are rounded apart from these.
    let slack = 1e-3 * (least.abs().max(most.abs()) + length) + 1e-6 * surface.extent() + length;
    for axis in 0..3 {
        let (against, along) = cone.span([0, 1, 2].map(|other: usize| f32::from(u8::from(other == axis))));
        let ends = [least * against, least * along, most * against, most * along];
        bounds.low[axis] += ends.into_iter().fold(f32::INFINITY, f32::min) - slack;
        bounds.high[axis] += ends.into_iter().fold(f32::NEG_INFINITY, f32::max) + slack;
    }
    bounds
}
