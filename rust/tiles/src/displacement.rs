//! A channel of scalar displacement over the tiles of a surface, allocated where something happened.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Sections 4 and 5.
//! An edit goes: [`Displacement::apply`] the allocations of its [`Sets`], [`Displacement::edit`] the coefficients of the
//! tiles to modify, [`Displacement::settle`] what that changed, [`Displacement::commit`]. Settling allocates the
//! neighbours that a changed border reaches and brings rings up to date; committing makes the edit visible to readers
//! as an immutable [`Snapshot`]. Where the byte budget refuses a tile it stays as it was, the borders beside it are
//! held at zero, and the tile is reported. Units: object units; bytes.

use std::collections::BTreeMap;
use std::ops::Deref;
use std::sync::Arc;

use half::f16;
use half::slice::HalfFloatSliceExt;
use relievo_core::{Context, Error, Result};
use relievo_surface::TileTopology;

use crate::field::{Entry, Field, Line};
use crate::heap::{CLASS_COUNT, Heap, MIN_SIZE, SizeClass};
use crate::ring::{self, Change, Writes};
use crate::sets::Sets;
use crate::spline::{coarsen_block, subdivide_block};

/// How a displacement is made.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplacementOptions {
    /// Texels along an edge of the cage: 8, 16, 32, 64, 128 or 256. Sub-tiles have half of it, but at least 8.
    pub size: u32,
    /// Faces that differ from `size`, and theirs.
    pub face_sizes: Vec<(u32, u32)>,
    /// Bytes that blocks may occupy.
    pub budget: u64,
}

impl Default for DisplacementOptions {
    fn default() -> Self {
        Self { size: 128, face_sizes: Vec::new(), budget: 1 << 30 }
    }
}

/// Displacements that may be edited. See the [module](self).
#[derive(Debug)]
pub struct Displacement {
    field: Field,
    heap: Heap,
    /// A block of zeros of each class, shared by tiles that were allocated and not yet written.
    zeros: [Option<Arc<[f16]>>; CLASS_COUNT],
    revision: u64,
    /// Tiles changed since the last commit, and a bit for each tile that is listed.
    changed: Vec<u32>,
    listed: Vec<u64>,
    full_bytes: u64,
}

/// What [`Displacement::apply`] did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Applied {
    /// Tiles that were allocated or deallocated, for the ring update.
    pub changes: Vec<Change>,
    /// Tiles the budget refused.
    pub refused: Vec<u32>,
}

/// Displacements as they were at a commit, for any number of readers.
#[derive(Clone, Debug)]
pub struct Snapshot {
    field: Field,
    changed: Vec<u32>,
    revision: u64,
    bytes: u64,
}

impl Snapshot {
    /// The tiles.
    pub fn field(&self) -> &Field {
        &self.field
    }

    /// Tiles that were written, allocated or deallocated since the commit before, ascending.
    pub fn changed(&self) -> &[u32] {
        &self.changed
    }

    /// The number of the last edit that is in it.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Bytes of the allocated blocks.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl Deref for Snapshot {
    type Target = Field;

    fn deref(&self) -> &Field {
        &self.field
    }
}

/// The coefficients of one tile, without its ring, open for editing.
#[derive(Debug)]
pub struct Texels<'a> {
    size: usize,
    block: &'a mut [f16],
}

impl Texels<'_> {
    /// Texels a side.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Row `j`: coefficients at v = (j + ½)/size. Panics if there is no such row.
    pub fn row(&self, j: usize) -> &[f16] {
        let start = (j + 1) * (self.size + 2) + 1;
        &self.block[start..start + self.size]
    }

    /// Row `j`, for writing. Panics if there is no such row.
    pub fn row_mut(&mut self, j: usize) -> &mut [f16] {
        let start = (j + 1) * (self.size + 2) + 1;
        &mut self.block[start..start + self.size]
    }

    /// The whole block with the ring, for filters that look at neighbours.
    pub fn block(&self) -> &[f16] {
        self.block
    }
}

impl Displacement {
    /// A displacement of zero everywhere. Fails if a size or face does not exist.
    pub fn new(topology: Arc<TileTopology>, options: &DisplacementOptions) -> Result<Self> {
        let mut sizes = vec![SizeClass::of(options.size)?; topology.face_count()];
        for (face, size) in &options.face_sizes {
            let class = SizeClass::of(*size).map_err(|error| error.at(format!("face {face}")))?;
            *sizes.get_mut(*face as usize).ok_or_else(|| Error::invalid(format!("face {face} does not exist")))? =
                class;
        }
        let mut classes = Vec::with_capacity(topology.tile_count());
        let mut full_bytes = 0;
        for tile in 0..topology.tile_count() as u32 {
            let class = class_of(&topology, tile, sizes[topology.face(tile) as usize])?;
            if !topology.is_hole(tile) {
                full_bytes += class.bytes();
            }
            classes.push(class);
        }
        let listed = vec![0; topology.tile_count().div_ceil(64)];
        Ok(Self {
            field: Field::new(topology, classes),
            heap: Heap::new(options.budget),
            zeros: Default::default(),
            revision: 0,
            changed: Vec::new(),
            listed,
            full_bytes,
        })
    }

    /// The tiles as they are now.
    pub fn field(&self) -> &Field {
        &self.field
    }

    /// Number of allocated tiles.
    pub fn allocated_count(&self) -> usize {
        self.heap.total()
    }

    /// Bytes of the allocated blocks.
    pub fn bytes(&self) -> u64 {
        self.heap.bytes()
    }

    /// Bytes if every tile were allocated, those of holes left out.
    pub fn full_bytes(&self) -> u64 {
        self.full_bytes
    }

    /// Bytes that blocks may occupy.
    pub fn budget(&self) -> u64 {
        self.heap.budget()
    }

    /// Changes the budget. Allocated blocks stay, even beyond it.
    pub fn set_budget(&mut self, budget: u64) {
        self.heap.set_budget(budget);
    }

    /// Allocates and deallocates the tiles of `sets`. New blocks are zero. Tiles that already are as wished are left
    /// out; tiles beyond the budget are reported. Fails, and does nothing, if a tile does not exist or is a hole.
    pub fn apply(&mut self, sets: &Sets) -> Result<Applied> {
        for tile in sets.allocate.iter().chain(&sets.deallocate) {
            self.check(*tile)?;
        }
        self.revision += 1;
        let mut applied = Applied::default();
        let mut freed = Vec::new();
        for tile in &sets.deallocate {
            if self.field.is_allocated(*tile) {
                freed.extend(self.field.entry_mut(*tile).take().map(|entry| entry.id));
                applied.changes.push(Change::all(*tile));
                self.mark(*tile);
            }
        }
        self.heap.free(&freed);
        let mut wanted: Vec<u32> =
            sets.allocate.iter().copied().filter(|tile| !self.field.is_allocated(*tile)).collect();
        wanted.sort_unstable();
        wanted.dedup();
        let classes: Vec<SizeClass> = wanted.iter().map(|tile| self.field.class(*tile)).collect();
        for (tile, block) in wanted.into_iter().zip(self.heap.allocate(&classes)) {
            let Some(id) = block else {
                applied.refused.push(tile);
                continue;
            };
            let zeros = self.zeros[id.class.index()].get_or_insert_with(|| vec![f16::ZERO; id.class.texels()].into());
            let entry = Entry { texels: zeros.clone(), id, version: self.revision };
            *self.field.entry_mut(tile) = Some(entry);
            applied.changes.push(Change::all(tile));
            self.mark(tile);
        }
        Ok(applied)
    }

    /// Calls `work` for each of `tiles` to change its coefficients; tiles are worked on in parallel. Returns what
    /// changed, by tile; a tile whose coefficients stay the same is not touched.
    ///
    /// Fails, and changes nothing, if a tile is not allocated or listed twice, or if `work` leaves a coefficient that
    /// is not finite.
    pub fn edit(
        &mut self,
        context: &Context,
        tiles: &[u32],
        work: impl Fn(u32, &mut Texels<'_>) + Sync,
    ) -> Result<Vec<Change>> {
        for tile in tiles {
            self.check(*tile)?;
            if !self.field.is_allocated(*tile) {
                return Err(Error::invalid("it is not allocated")
                    .at(format!("tile {tile}"))
                    .advise("allocate it first"));
            }
        }
        let mut order = tiles.to_vec();
        order.sort_unstable();
        if let Some(pair) = order.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(Error::invalid("it is listed twice").at(format!("tile {}", pair[0])));
        }
        let field = &self.field;
        let edited = context.map(order.len(), |index| {
            let tile = order[index];
            let old = field.block(tile).unwrap_or(&[]);
            let mut new: Arc<[f16]> = old.into();
            let size = field.size(tile) as usize;
            if let Some(block) = Arc::get_mut(&mut new) {
                work(tile, &mut Texels { size, block });
            }
            let (before, after) = (old.reinterpret_cast(), new.reinterpret_cast());
            if before == after {
                return None;
            }
            let finite = after.chunks(256).all(all_finite);
            Some((tile, finite, changed_borders(old, &new, size as u32), new))
        });
        if let Some((tile, ..)) = edited.iter().flatten().find(|(_, finite, ..)| !finite) {
            return Err(Error::invalid("an edit left a coefficient that is not finite").at(format!("tile {tile}")));
        }
        self.revision += 1;
        let mut changes = Vec::new();
        for (tile, _, borders, texels) in edited.into_iter().flatten() {
            self.replace(tile, texels);
            changes.push(Change { tile, borders });
        }
        Ok(changes)
    }

    /// Ends an edit: allocates the tiles that `changes` reach and brings borders and rings up to date. Returns the
    /// tiles the budget refused; borders toward them are zero again.
    pub fn settle(&mut self, context: &Context, changes: &[Change]) -> Result<Vec<u32>> {
        let reached = ring::reached(&self.field, changes);
        if reached.is_empty() {
            self.update_rings(context, changes)?;
            return Ok(Vec::new());
        }
        let applied = self.apply(&Sets { allocate: reached, ..Sets::default() })?;
        let all: Vec<Change> = changes.iter().chain(&applied.changes).copied().collect();
        self.update_rings(context, &all)?;
        Ok(applied.refused)
    }

    /// Brings borders and rings up to date, see [`crate::ring`]. Returns the tiles that changed by it, ascending.
    pub fn update_rings(&mut self, context: &Context, changes: &[Change]) -> Result<Vec<u32>> {
        for change in changes {
            self.check(change.tile)?;
        }
        self.revision += 1;
        let mut tiles = Vec::new();
        let plan = ring::plan(&self.field, changes);
        for pass in [ring::borders, ring::rings] {
            let writes = pass(context, &self.field, &plan);
            tiles.extend(writes.iter().map(|(tile, _)| *tile));
            self.write_texels(context, &writes);
        }
        tiles.sort_unstable();
        tiles.dedup();
        Ok(tiles)
    }

    /// Gives faces other sizes, texels along an edge of the cage. What is allocated is kept: exactly, but for rounding,
    /// where a face becomes finer, in the least detail where it becomes coarser. Returns tiles that the budget refused
    /// to allocate beside a coarser one, as [`Self::settle`] does.
    ///
    /// Fails, and changes nothing, if a face or size does not exist or the budget does not allow it.
    pub fn resize(&mut self, context: &Context, faces: &[(u32, u32)]) -> Result<Vec<u32>> {
        let topology = self.field.topology().clone();
        let mut sizes = BTreeMap::new();
        for (face, size) in faces {
            if *face as usize >= topology.face_count() {
                return Err(Error::invalid(format!("face {face} does not exist")));
            }
            for tile in topology.tiles_of(*face) {
                let class = SizeClass::of(*size).map_err(|error| error.at(format!("face {face}")))?;
                sizes.insert(tile, class_of(&topology, tile, class)?);
            }
        }
        sizes.retain(|tile, class| *class != self.field.class(*tile) && !topology.is_hole(*tile));
        let allocated: Vec<(u32, SizeClass)> =
            sizes.iter().filter(|(tile, _)| self.field.is_allocated(**tile)).map(|(a, b)| (*a, *b)).collect();
        let old: u64 = allocated.iter().map(|(tile, _)| self.field.class(*tile).bytes()).sum();
        let new: u64 = allocated.iter().map(|(_, class)| class.bytes()).sum();
        if new > old && self.bytes() - old + new > self.budget() {
            return Err(Error::memory("the tiles need more than their budget")
                .advise(format!("allow at least {} bytes", self.bytes() - old + new)));
        }
        self.revision += 1;
        let field = &self.field;
        let blocks = context.map(allocated.len(), |index| {
            let (tile, class) = allocated[index];
            convert(field.block(tile).unwrap_or(&[]), field.size(tile) as usize, class.size() as usize)
        });
        let freed: Vec<_> =
            allocated.iter().filter_map(|(tile, _)| self.field.entry_mut(*tile).take().map(|entry| entry.id)).collect();
        self.heap.free(&freed);
        for (tile, class) in &sizes {
            self.full_bytes = self.full_bytes - self.field.class(*tile).bytes() + class.bytes();
            self.field.set_class(*tile, *class);
        }
        let classes: Vec<SizeClass> = allocated.iter().map(|(_, class)| *class).collect();
        // Blocks beyond a budget that was lowered may stay, and so may coarser ones in their place.
        let budget = self.heap.budget();
        self.heap.set_budget(u64::MAX);
        let ids = self.heap.allocate(&classes);
        self.heap.set_budget(budget);
        for (((tile, _), texels), id) in allocated.iter().zip(blocks).zip(ids) {
            *self.field.entry_mut(*tile) = id.map(|id| Entry { texels, id, version: self.revision });
            self.mark(*tile);
        }
        let changes: Vec<Change> = allocated.iter().map(|(tile, _)| Change::all(*tile)).collect();
        self.settle(context, &changes)
    }

    /// Makes everything up to now visible as a snapshot.
    pub fn commit(&mut self) -> Arc<Snapshot> {
        let mut changed = std::mem::take(&mut self.changed);
        changed.sort_unstable();
        for tile in &changed {
            self.listed[*tile as usize / 64] &= !(1 << (tile % 64));
        }
        Arc::new(Snapshot { field: self.field.clone(), changed, revision: self.revision, bytes: self.heap.bytes() })
    }

    /// The block of `tile` as bytes: `(size + 2)²` half floats, little-endian; `None` if it is not allocated.
    pub fn read(&self, tile: u32) -> Result<Option<Vec<u8>>> {
        self.check(tile)?;
        Ok(self.field.block(tile).map(|block| block.iter().flat_map(|c| c.to_le_bytes()).collect()))
    }

    /// Puts back what [`Self::read`] gave, rings and all: allocates or deallocates as needed. When all tiles of an
    /// edit are put back their rings agree; after anything else, call [`Self::update_rings`].
    ///
    /// Fails, and changes nothing, if the tile does not exist or is a hole, the length is not that of its block, a
    /// number is not finite, or the budget does not allow it.
    pub fn write(&mut self, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
        self.check(tile)?;
        let Some(bytes) = bytes else {
            self.apply(&Sets { deallocate: vec![tile], ..Sets::default() })?;
            return Ok(());
        };
        let place = || format!("tile {tile}");
        let class = self.field.class(tile);
        if bytes.len() as u64 != class.bytes() {
            return Err(Error::invalid(format!("a block of {} bytes cannot be put back", bytes.len()))
                .at(place())
                .advise(format!("tiles of {} texels have {} bytes", class.size(), class.bytes())));
        }
        let texels: Arc<[f16]> = bytes.chunks_exact(2).map(|pair| f16::from_le_bytes([pair[0], pair[1]])).collect();
        if let Some(index) = texels.iter().position(|c| !c.is_finite()) {
            return Err(Error::invalid(format!("coefficient {index} is not finite")).at(place()));
        }
        if !self.apply(&Sets { allocate: vec![tile], ..Sets::default() })?.refused.is_empty() {
            return Err(Error::memory("the tiles need more than their budget")
                .at(place())
                .advise(format!("allow more than {} bytes", self.budget())));
        }
        self.replace(tile, texels);
        Ok(())
    }

    fn check(&self, tile: u32) -> Result<()> {
        if tile as usize >= self.field.tile_count() {
            return Err(Error::invalid(format!("tile {tile} does not exist"))
                .advise(format!("use 0 to {}", self.field.tile_count() - 1)));
        }
        if self.field.topology().is_hole(tile) {
            return Err(Error::invalid("it belongs to a hole").at(format!("tile {tile}")));
        }
        Ok(())
    }

    fn mark(&mut self, tile: u32) {
        let (word, bit) = (tile as usize / 64, 1 << (tile % 64));
        if self.listed[word] & bit == 0 {
            self.listed[word] |= bit;
            self.changed.push(tile);
        }
    }

    fn replace(&mut self, tile: u32, texels: Arc<[f16]>) {
        let version = self.revision;
        if let Some(entry) = self.field.entry_mut(tile) {
            entry.texels = texels;
            entry.version = version;
            self.mark(tile);
        }
    }

    /// Writes single coefficients: in place where no snapshot shares the block, else to a copy.
    fn write_texels(&mut self, context: &Context, writes: &[Writes]) {
        let version = self.revision;
        let mut shared = Vec::new();
        for (index, (tile, list)) in writes.iter().enumerate() {
            self.mark(*tile);
            let Some(entry) = self.field.entry_mut(*tile) else { continue };
            entry.version = version;
            match Arc::get_mut(&mut entry.texels) {
                Some(block) => list.iter().for_each(|(at, value)| block[*at as usize] = *value),
                None => shared.push(index),
            }
        }
        let field = &self.field;
        let copies = context.map(shared.len(), |index| {
            let (tile, list) = &writes[shared[index]];
            let mut texels: Arc<[f16]> = field.block(*tile).unwrap_or(&[]).into();
            if let Some(block) = Arc::get_mut(&mut texels) {
                list.iter().for_each(|(at, value)| block[*at as usize] = *value);
            }
            texels
        });
        for (index, texels) in shared.into_iter().zip(copies) {
            self.replace(writes[index].0, texels);
        }
    }
}

/// The class of a tile whose face has `class`: sub-tiles are half as large.
fn class_of(topology: &TileTopology, tile: u32, class: SizeClass) -> Result<SizeClass> {
    if topology.is_sub(tile) { SizeClass::of((class.size() / 2).max(MIN_SIZE)) } else { Ok(class) }
}

/// A block of `from` texels a side at `to` texels.
fn convert(block: &[f16], from: usize, to: usize) -> Arc<[f16]> {
    let (mut texels, mut size) = (block.to_f32_vec(), from);
    while size < to {
        texels = subdivide_block(&texels, size);
        size *= 2;
    }
    while size > to {
        texels = coarsen_block(&texels, size);
        size /= 2;
    }
    texels.into_iter().map(|c| f16::from_f32(c.clamp(-65504.0, 65504.0))).collect()
}

/// Whether all of up to 256 half floats are finite. Counted in 16 bits, which compiles to wide comparisons.
fn all_finite(bits: &[u16]) -> bool {
    bits.iter().map(|bits| u16::from(bits & 0x7c00 == 0x7c00)).sum::<u16>() == 0
}

/// Which border rows differ between two blocks, as bits.
fn changed_borders(old: &[f16], new: &[f16], size: u32) -> u8 {
    let differs = |edge: u8| {
        let line = Line::new(size, edge, 0);
        (0..size as isize).any(|k| old[line.at(k)].to_bits() != new[line.at(k)].to_bits())
    };
    (0..4).filter(|edge| differs(*edge)).map(|edge| 1 << edge).sum()
}
