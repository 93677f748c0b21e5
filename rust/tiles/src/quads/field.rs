//! The tiles of a channel at one moment: which are allocated, their blocks and versions.
//!
//! Copies share what is not written afterwards, see `pages.rs`. Units: those of the texels.

use std::sync::Arc;

use half::f16;
use relievo_core::Result;
use relievo_core::simd::Level;
use relievo_document::PageStore;
use relievo_surface::{Link, Place, TileTopology};

use crate::quads::frame::Frames;
use crate::quads::spline::{self, Jet};
use crate::store::heap::{BlockId, SizeClass};
use crate::store::pages::{CowBlocks, Page};
use crate::store::slot::{Pager, Slot};
use crate::store::spare::BlockPool;
use crate::texel::{Texel, Vector};

/// The block of a tile and its mips.
#[derive(Clone, Debug)]
pub(crate) struct Entry<T> {
    pub texels: Slot<T>,
    /// Level by level; none where texels have no mips.
    pub mips: Slot<T>,
    /// Its class, and its number where it is in the heap and not on a page.
    pub id: BlockId,
    pub version: u64,
}

/// Texels of all tiles of a surface, immutable where it is shared: displacement, or colour. Cloning is cheap.
#[derive(Clone, Debug)]
pub struct Field<T = f16> {
    topology: Arc<TileTopology>,
    classes: Arc<[SizeClass]>,
    /// The sizes that faces were given, where an edit of another level changed `classes`.
    given: Arc<[SizeClass]>,
    pages: CowBlocks<Entry<T>>,
    blank: T,
    /// By tile, see [`Self::uneven`]; empty where no tile is uneven.
    uneven: Arc<[u8]>,
    /// How frames are turned, for texels that have a direction.
    pub(crate) frames: Option<Arc<Frames>>,
    /// What blocks page to, if they do.
    pub(crate) pager: Option<Arc<Pager>>,
    /// Blocks that no field has any more.
    pub(crate) spare: Arc<BlockPool<T, Page<Entry<T>>>>,
}

impl<T> Drop for Field<T> {
    /// What a stroke or a history held is spare for the next ones.
    fn drop(&mut self) {
        // Not for a field that is the last one of its channel.
        if Arc::strong_count(&self.spare) > 1 {
            self.release();
        }
    }
}

impl<T> Field<T> {
    /// Has no blocks any more. Blocks that no other field has are spare.
    pub(crate) fn release(&mut self) {
        let spare = &self.spare;
        let block = |slot| {
            if let Slot::Here(texels) = slot {
                spare.keep(texels);
            }
        };
        let entry = |entry: Entry<T>| [entry.texels, entry.mips].into_iter().for_each(block);
        self.pages.release(entry, |page| spare.keep_page(page));
        self.pager = None;
    }
}

impl<T: Texel> Field<T> {
    /// A field without blocks, where `classes` says the size of every tile and `blank` what it reads as.
    pub(crate) fn new(topology: Arc<TileTopology>, classes: Vec<SizeClass>, blank: T) -> Self {
        let pages = CowBlocks::new(topology.tile_count());
        let classes: Arc<[SizeClass]> = classes.into();
        let given = classes.clone();
        let (uneven, spare) = (Arc::default(), Arc::default());
        let mut field = Self { topology, classes, given, pages, blank, uneven, frames: None, pager: None, spare };
        field.compare();
        field
    }

    /// Becomes a copy of `other`, in the room that it has.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        let Self { topology, classes, given, pages, blank, uneven, frames, pager, spare } = self;
        topology.clone_from(&other.topology);
        classes.clone_from(&other.classes);
        given.clone_from(&other.given);
        pages.copy_from(&other.pages);
        *blank = other.blank;
        uneven.clone_from(&other.uneven);
        frames.clone_from(&other.frames);
        pager.clone_from(&other.pager);
        spare.clone_from(&other.spare);
    }

    /// A block that is nobody else's, with the texels of `tile` and its ring: blank ones if it is not allocated.
    pub fn copied(&self, tile: u32) -> Arc<[T]> {
        match self.block(tile) {
            Some(block) => self.spare.copy_of(block),
            None => self.spare.filled(self.class(tile).texels(), self.blank),
        }
    }

    /// Notes where tiles of different density meet.
    pub(crate) fn compare(&mut self) {
        let topology = &self.topology;
        let uneven = |tile: u32| {
            // The coarsest mips of sub-tiles are twice as dense as those of whole tiles, which therefore rule.
            let key = |tile: u32| (self.full_density(tile), topology.is_sub(tile));
            let coarser = |other: u32| key(other) < key(tile);
            let edge = |edge: &u8| match topology.link(tile, *edge) {
                Link::Boundary | Link::Pinned { .. } => false,
                Link::Whole { side, .. } | Link::Half { side, .. } => coarser(side.tile),
                Link::Halves { first, second, .. } => coarser(first.tile) || coarser(second.tile),
            };
            let corner = |corner: &u8| {
                let ring = topology.ring(topology.rings(tile)[usize::from(*corner)]);
                ring.iter().any(|entry| coarser(entry.tile))
            };
            let edges: u8 = (0..4).filter(edge).map(|edge| 1 << edge).sum();
            edges | (0..4).filter(corner).map(|corner| 16 << corner).sum::<u8>()
        };
        let live = |tile: &u32| !topology.is_hole(*tile);
        if !T::MIPS || (0..self.tile_count() as u32).filter(live).all(|tile| uneven(tile) == 0) {
            self.uneven = Arc::default();
            return;
        }
        let of = |tile: u32| if live(&tile) { uneven(tile) } else { 0 };
        self.uneven = (0..self.tile_count() as u32).map(of).collect();
    }

    /// Where coarser tiles, or whole ones a sub-tile, meet `tile`, whether they are allocated or not: bit e for edge e,
    /// bit 4 + c for corner c. Always 0 where texels have no mips.
    pub fn uneven(&self, tile: u32) -> u8 {
        self.uneven.get(tile as usize).copied().unwrap_or(0)
    }

    /// As [`Self::density`], whether the tile is allocated or not.
    pub(crate) fn full_density(&self, tile: u32) -> u32 {
        self.size(tile) << u32::from(self.topology.is_sub(tile))
    }

    /// What tiles without a block read as.
    pub fn blank(&self) -> T {
        self.blank
    }

    /// How the tiles meet.
    pub fn topology(&self) -> &Arc<TileTopology> {
        &self.topology
    }

    /// Number of tiles, allocated or not.
    pub fn tile_count(&self) -> usize {
        self.topology.tile_count()
    }

    /// The size class of `tile`, whether it is allocated or not.
    pub fn class(&self, tile: u32) -> SizeClass {
        self.classes[tile as usize]
    }

    /// The size class of `tile` at an edit's level: as its face was given at 0, half of it at 1, a quarter at 2, but
    /// not below the least.
    pub(crate) fn class_at(&self, tile: u32, level: u32) -> SizeClass {
        self.given[tile as usize].halved(level)
    }

    /// Texels along the sides of `tile` at an edit's level, see [`Channel::put_at`](crate::Channel::put_at).
    pub fn size_at(&self, tile: u32, level: u32) -> u32 {
        self.class_at(tile, level).size()
    }

    /// Makes `class` the size that the face of `tile` was given.
    pub(crate) fn give_class(&mut self, tile: u32, class: SizeClass) {
        Arc::make_mut(&mut self.given)[tile as usize] = class;
    }

    /// The sizes that faces were given, where edits of other levels changed some.
    pub(crate) fn given(&self) -> &Arc<[SizeClass]> {
        &self.given
    }

    /// A field of the same tiles with these blocks and nothing else.
    pub(crate) fn like<U: Texel>(&self, classes: Vec<SizeClass>, blank: U, blocks: Vec<(u32, Arc<[U]>)>) -> Field<U> {
        let mut field = Field::new(self.topology.clone(), classes, blank);
        field.frames = self.frames.clone();
        blocks.into_iter().for_each(|(tile, texels)| field.insert(tile, texels));
        field
    }

    /// Puts a block that is in no heap.
    pub(crate) fn insert(&mut self, tile: u32, texels: Arc<[T]>) {
        let id = BlockId { class: self.class(tile), number: 0 };
        *self.entry_mut(tile) =
            Some(Entry { texels: Slot::Here(texels), mips: Slot::Here(Arc::default()), id, version: 0 });
    }

    pub(crate) fn set_class(&mut self, tile: u32, class: SizeClass) {
        Arc::make_mut(&mut self.classes)[tile as usize] = class;
    }

    /// Texels along the sides of `tile`, whether it is allocated or not.
    pub fn size(&self, tile: u32) -> u32 {
        self.class(tile).size()
    }

    /// Whether tiles are known to have the sizes of those of `other`, a copy from before or after.
    pub fn has_sizes_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.classes, &other.classes)
    }

    /// Bytes of the block of `tile`, whether it is allocated or not.
    pub fn block_bytes(&self, tile: u32) -> u64 {
        self.class(tile).bytes(size_of::<T>())
    }

    /// Level `level` of `tile` with its ring, row by row: 0 is the tile itself, each further one has half the texels a
    /// side. `None` if it is not allocated or there is no such level.
    pub fn level(&self, tile: u32, level: u32) -> Option<&[T]> {
        let entry = self.entry(tile)?;
        if level == 0 {
            return Some(&entry.texels);
        }
        let class = entry.id.class;
        entry.mips.get(class.level_start(level)..class.level_start(level + 1))
    }

    /// Bytes of the block of `tile` and its mips, whether it is allocated or not.
    pub fn tile_bytes(&self, tile: u32) -> u64 {
        let class = self.class(tile);
        class.bytes(size_of::<T>()) + if T::MIPS { (size_of::<T>() * class.mip_texels()) as u64 } else { 0 }
    }

    /// Texels along an edge of the cage beside `tile`, 0 if it is not allocated. A sub-tile covers half an edge.
    pub fn density(&self, tile: u32) -> u32 {
        match self.entry(tile) {
            Some(entry) => entry.id.class.size() << u32::from(self.topology.is_sub(tile)),
            None => 0,
        }
    }

    /// Whether `tile` has a block.
    pub fn is_allocated(&self, tile: u32) -> bool {
        self.entry(tile).is_some()
    }

    /// The `(size + 2)²` texels of `tile` with its ring, row by row from v < 0; `None` if it is not allocated.
    pub fn block(&self, tile: u32) -> Option<&[T]> {
        self.entry(tile).map(|entry| &*entry.texels)
    }

    /// As [`Self::block`].
    ///
    /// # Errors
    /// Fails if the texels are on a page that cannot be read, which [`Self::block`] shows as blank.
    pub fn try_block(&self, tile: u32) -> Result<Option<&[T]>> {
        let Some(entry) = self.entry(tile) else { return Ok(None) };
        entry.texels.check()?;
        Ok(Some(&entry.texels))
    }

    /// Where blocks page to, if they do.
    pub(crate) fn page_store(&self) -> Option<&Arc<dyn PageStore>> {
        self.pager.as_ref().map(|pager| &pager.store)
    }

    /// Whether `tile` is allocated and on a page, see [`crate::store::paging`].
    pub fn is_paged(&self, tile: u32) -> bool {
        self.entry(tile).is_some_and(|entry| entry.texels.is_paged())
    }

    /// The number of the edit that last changed the block of `tile`, 0 if it is not allocated.
    pub fn version(&self, tile: u32) -> u64 {
        self.entry(tile).map_or(0, |entry| entry.version)
    }

    /// The allocated tiles, ascending.
    pub fn allocated(&self) -> impl Iterator<Item = u32> {
        self.pages.used()
    }

    pub(crate) fn blank_ref(&self) -> &T {
        &self.blank
    }

    pub(crate) fn classes(&self) -> &Arc<[SizeClass]> {
        &self.classes
    }

    /// The tiles whose blocks are not as in `other`, to the bit, ascending.
    pub fn differing(&self, other: &Self) -> Vec<u32> {
        // Of one channel, equal versions are equal texels: what is on pages need not be read.
        let related = match (&self.pager, &other.pager) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            _ => false,
        };
        let differs = |tile: &u32| match (self.entry(*tile), other.entry(*tile)) {
            (Some(a), Some(b)) => {
                !a.texels.is_same(&b.texels)
                    && !(related && a.version == b.version)
                    && bytemuck::cast_slice::<T, u8>(&a.texels) != bytemuck::cast_slice::<T, u8>(&b.texels)
            }
            (a, b) => a.is_some() || b.is_some(),
        };
        self.pages.unshared(&other.pages).filter(differs).collect()
    }

    /// The tiles that may be others than in `other`, a copy from before or after, ascending: all that are not listed are
    /// the same memory.
    pub fn touched(&self, other: &Self) -> impl Iterator<Item = u32> {
        let count = self.tile_count() as u32;
        self.pages.unshared(&other.pages).take_while(move |tile| *tile < count)
    }

    /// The tiles in which something else may be looked up than in `before`, of which `changed` are others: themselves,
    /// and where tiles of different density meet those around them. They are put into `seen`, ascending if `changed` is.
    pub fn seen_from(&self, before: &Self, changed: &[u32], seen: &mut Vec<u32>) {
        seen.clear();
        seen.extend(changed);
        if !self.uneven.is_empty() || !before.uneven.is_empty() {
            seen.extend(changed.iter().flat_map(|tile| crate::quads::channel::neighbours(&self.topology, *tile)));
            seen.sort_unstable();
            seen.dedup();
        }
    }

    /// The one place at which `place` is evaluated, see [`TileTopology::canonical`].
    pub fn canonical(&self, place: Place) -> Place {
        self.topology.canonical(place, |tile| self.density(tile))
    }

    pub(crate) fn entry(&self, tile: u32) -> Option<&Entry<T>> {
        self.pages.entry(tile)
    }

    /// The entry of `tile`, which must exist, for writing.
    /// Takes the blocks of `tiles` away.
    pub fn forget(&mut self, tiles: &[u32]) {
        for tile in tiles {
            *self.entry_mut(*tile) = None;
        }
    }

    pub(crate) fn entry_mut(&mut self, tile: u32) -> &mut Option<Entry<T>> {
        let spare = &self.spare;
        self.pages.entry_with(tile, || spare.page())
    }
}

impl Field {
    /// The displacement in `place`'s own tile: zero if it is not allocated. Give it a canonical place for values that
    /// agree across seams.
    pub fn point(&self, level: Level, place: Place) -> Jet {
        match self.entry(place.tile) {
            Some(entry) => spline::point(level, &entry.texels, entry.id.class.size(), place.u, place.v),
            None => Jet::default(),
        }
    }

    /// The least and the largest coefficient of `tile`, ring included: bounds of its displacement. Zeros if it is not
    /// allocated.
    pub fn range(&self, tile: u32) -> [f32; 2] {
        let Some(entry) = self.entry(tile) else { return [0.0; 2] };
        entry.texels.bound().unwrap_or_else(|| f16::bound(&entry.texels))
    }
}

impl Field<Vector> {
    /// The displacement in `place`'s own tile, as three components: zeros if it is not allocated. Give it a canonical
    /// place for vectors that agree across seams.
    pub fn vector(&self, level: Level, place: Place) -> [Jet; 3] {
        match self.entry(place.tile) {
            Some(entry) => spline::vector_point(level, &entry.texels, entry.id.class.size(), place.u, place.v),
            None => [Jet::default(); 3],
        }
    }

    /// A bound of the lengths of the vectors over `tile`, 0 if it is not allocated.
    pub fn length(&self, tile: u32) -> f32 {
        let Some(entry) = self.entry(tile) else { return 0.0 };
        entry.texels.bound().unwrap_or_else(|| Vector::bound(&entry.texels))[1]
    }
}

/// A line of coefficients of a block along one of its edges.
///
/// Coefficient `k` counts along the edge from its first corner; `depth` is 0 for the border row, −1 for the ring.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    start: isize,
    step: isize,
}

impl Line {
    pub fn new(size: u32, edge: u8, depth: isize) -> Self {
        let (n, stride) = (size as isize, size as isize + 2);
        match edge & 3 {
            0 => Self { start: (depth + 1) * stride + 1, step: 1 },
            1 => Self { start: stride + n - depth, step: stride },
            2 => Self { start: (n - depth) * stride + n, step: -1 },
            _ => Self { start: n * stride + depth + 1, step: -stride },
        }
    }

    /// The index of coefficient `k` in the block; −1 and `size` are the ring's corners.
    pub fn at(&self, k: isize) -> usize {
        (self.start + k * self.step) as usize
    }
}
