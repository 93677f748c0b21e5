//! A channel over the tiles of a surface, allocated where something happened: displacement or colour, by its texels.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Sections 4
//! and 5. An edit goes: [`Channel::apply`] the allocations of its [`Sets`], [`Channel::edit`] the texels of the tiles
//! to modify, [`Channel::settle`] what that changed, [`Channel::commit`]. Settling allocates the neighbours that a
//! changed border reaches and brings rings up to date; committing makes the edit visible to readers as an immutable
//! [`Snapshot`]. Where the byte budget refuses a tile it stays as it was, the borders beside it are held at what it
//! reads as, and the tile is reported. Units: those of the texels; bytes.

use std::ops::Deref;
use std::sync::Arc;

use half::f16;
use relievo_core::{ArcPool, Context, Error, Result};
use relievo_surface::{Link, TileTopology};

use crate::quads::field::{Entry, Field, Line};
use crate::quads::mip::Rect;
use crate::quads::ring::{self, Change, Plan, View, Writes, WritesAt};
use crate::store::heap::{BlockId, CLASS_COUNT, Heap, MIN_SIZE, SizeClass};
use crate::store::paging::{BlockStore, Paged};
use crate::store::sets::Sets;
use crate::store::slot::Slot;
use crate::texel::Texel;

/// How a channel is made.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelOptions {
    /// Texels along an edge of the cage: 8, 16, 32, 64, 128 or 256. Sub-tiles have half of it, but at least 8.
    pub size: u32,
    /// Faces that differ from `size`, and theirs.
    pub face_sizes: Vec<(u32, u32)>,
    /// Bytes that blocks may occupy.
    pub budget: u64,
}

impl Default for ChannelOptions {
    fn default() -> Self {
        Self { size: 128, face_sizes: Vec::new(), budget: 1 << 30 }
    }
}

/// Texels that may be edited. See the [module](self).
#[derive(Debug)]
pub struct Channel<T> {
    pub(crate) field: Field<T>,
    pub(crate) blocks: BlockStore,
    /// A blank block of each class, shared by tiles that were allocated and not yet written.
    blanks: [Option<[Arc<[T]>; 2]>; CLASS_COUNT],
    /// Tiles whose mips, or those of their neighbours, are not up to date, and what of them changed, if something did.
    pub(crate) pending: Vec<(u32, Option<Rect>)>,
    /// Tiles changed since the last commit, and a bit for each tile that is listed.
    changed: Vec<u32>,
    listed: Vec<u64>,
    pub(crate) full_bytes: u64,
    /// Tiles that may be lost where the budget refuses others, the last first, and their versions when they were named.
    expendable: Vec<(u32, u64)>,
    /// The last commits, for the next one where nobody looks at one any more.
    snapshots: ArcPool<Snapshot<T>>,
    room: Room,
}

/// What [`Channel::apply`] needs on its way.
#[derive(Debug, Default)]
struct Room {
    freed: Vec<BlockId>,
    wanted: Vec<u32>,
    classes: Vec<SizeClass>,
    granted: Vec<Option<BlockId>>,
}

impl<T: Texel> Clone for Channel<T> {
    #[inline(never)]
    fn clone(&self) -> Self {
        let mut copy = Self {
            field: self.field.clone(),
            blocks: self.blocks.clone(),
            blanks: self.blanks.clone(),
            pending: self.pending.clone(),
            changed: self.changed.clone(),
            listed: self.listed.clone(),
            full_bytes: self.full_bytes,
            expendable: self.expendable.clone(),
            snapshots: ArcPool::default(),
            room: Room::default(),
        };
        copy.fork();
        copy
    }
}

/// What [`Channel::apply`] did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Applied {
    /// Tiles that were allocated or deallocated, for the ring update.
    pub changes: Vec<Change>,
    /// Tiles the budget refused.
    pub refused: Vec<u32>,
}

/// Texels as they were at a commit, for any number of readers.
#[derive(Clone, Debug)]
pub struct Snapshot<T = f16> {
    field: Field<T>,
    changed: Vec<u32>,
    revision: u64,
    bytes: u64,
    /// Whether nobody looks at it any more, and it holds no blocks.
    is_spent: bool,
}

impl<T> Snapshot<T> {
    fn new(field: Field<T>) -> Self {
        Self { field, changed: Vec::new(), revision: 0, bytes: 0, is_spent: false }
    }

    /// The tiles.
    pub fn field(&self) -> &Field<T> {
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

impl<T> Deref for Snapshot<T> {
    type Target = Field<T>;

    fn deref(&self) -> &Field<T> {
        &self.field
    }
}

/// The texels of one tile, without its ring, open for editing.
#[derive(Debug)]
pub struct Texels<'a, T = f16> {
    size: usize,
    block: &'a mut [T],
}

impl<T> Texels<'_, T> {
    /// Texels a side.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Row `j`: texels at v = (j + ½)/size. Panics if there is no such row.
    pub fn row(&self, j: usize) -> &[T] {
        let start = (j + 1) * (self.size + 2) + 1;
        &self.block[start..start + self.size]
    }

    /// Row `j`, for writing. Panics if there is no such row.
    pub fn row_mut(&mut self, j: usize) -> &mut [T] {
        let start = (j + 1) * (self.size + 2) + 1;
        &mut self.block[start..start + self.size]
    }

    /// The whole block with the ring, for filters that look at neighbours.
    pub fn block(&self) -> &[T] {
        self.block
    }
}

impl<T: Texel> Channel<T> {
    /// A channel that reads as `blank` everywhere. Fails if a size or face does not exist.
    #[inline(never)]
    pub(crate) fn blank(topology: Arc<TileTopology>, blank: T, options: &ChannelOptions) -> Result<Self> {
        let mut sizes = vec![SizeClass::of(options.size)?; topology.face_count()];
        for (face, size) in &options.face_sizes {
            let class = SizeClass::of(*size).map_err(|error| error.at(format!("face {face}")))?;
            *sizes.get_mut(*face as usize).ok_or_else(|| Error::invalid(format!("face {face} does not exist")))? =
                class;
        }
        let mut classes = Vec::with_capacity(topology.tile_count());
        let new = if T::MIPS { Heap::with_mips } else { Heap::new };
        let heap = new(size_of::<T>(), options.budget);
        let mut full_bytes = 0;
        for tile in 0..topology.tile_count() as u32 {
            let class = class_of(&topology, tile, sizes[topology.face(tile) as usize])?;
            if !topology.is_hole(tile) {
                full_bytes += heap.bytes_of(class);
            }
            classes.push(class);
        }
        let listed = vec![0; topology.tile_count().div_ceil(64)];
        Ok(Self {
            field: Field::new(topology, classes, blank),
            blocks: BlockStore::new(heap),
            blanks: Default::default(),
            pending: Vec::new(),
            changed: Vec::new(),
            listed,
            full_bytes,
            expendable: Vec::new(),
            snapshots: ArcPool::default(),
            room: Room::default(),
        })
    }

    /// The tiles as they are now.
    pub fn field(&self) -> &Field<T> {
        &self.field
    }

    /// The number of the last edit.
    pub fn revision(&self) -> u64 {
        self.blocks.revision
    }

    /// Number of allocated tiles.
    pub fn allocated_count(&self) -> usize {
        self.blocks.heap.total() + self.blocks.paging.count
    }

    /// Bytes of the allocated blocks, with the mips that colours have: see [`Field::tile_bytes`]. Blocks on pages count
    /// nothing.
    pub fn bytes(&self) -> u64 {
        self.blocks.heap.bytes()
    }

    /// Bytes if every tile were allocated, those of holes left out.
    pub fn full_bytes(&self) -> u64 {
        self.full_bytes
    }

    /// Bytes that blocks may occupy.
    pub fn budget(&self) -> u64 {
        self.blocks.heap.budget()
    }

    /// Changes the budget. Allocated blocks stay, even beyond it, unless they page: see [`Self::page_to`].
    pub fn set_budget(&mut self, budget: u64) {
        self.blocks.heap.set_budget(budget);
        self.trim();
    }

    /// Names tiles that may be lost where the budget refuses others, the first of them first, unless they are edited
    /// meanwhile: those of layers that fade, by age.
    pub fn set_expendable(&mut self, tiles: &[u32]) {
        let list = tiles.iter().rev().filter(|tile| self.field.is_allocated(**tile));
        self.expendable = list.map(|tile| (*tile, self.field.version(*tile))).collect();
    }

    /// The tiles that were lost since this was called last, ascending.
    pub fn take_lost(&mut self) -> Vec<u32> {
        self.blocks.take_lost()
    }

    /// Makes `tiles` blank and gives their blocks back, whatever neighbours have at their borders. They count as lost.
    ///
    /// # Errors
    /// Fails, and changes nothing, if a tile does not exist or is a hole. Fails too if a page cannot be read or
    /// written.
    #[inline(never)]
    pub fn lose_tiles(&mut self, context: &Context, tiles: &[u32]) -> Result<()> {
        let applied = self.apply(&Sets { deallocate: tiles.to_vec(), ..Sets::default() })?;
        self.blocks.lost.extend(applied.changes.iter().map(|change| change.tile));
        self.update_rings(context, &applied.changes)?;
        Ok(())
    }

    /// As [`Self::lose_tiles`], but only tiles that [`Self::set_expendable`] named and that were not edited since.
    ///
    /// # Errors
    /// Fails if a page cannot be read or written.
    #[inline(never)]
    pub fn lose_expendable(&mut self, context: &Context, tiles: &[u32]) -> Result<()> {
        let named = |tile: &u32| self.expendable.contains(&(*tile, self.field.version(*tile)));
        let gone: Vec<u32> = tiles.iter().copied().filter(named).collect();
        if gone.is_empty() { Ok(()) } else { self.lose_tiles(context, &gone) }
    }

    /// Loses tiles until the tiles that are `wanted` of `sets` have room, as far as there are any.
    fn lose(&mut self, sets: &Sets, wanted: &[u32], applied: &mut Applied) {
        if self.expendable.is_empty() {
            return;
        }
        let mut used: Vec<u32> = sets.allocate.iter().chain(&sets.modify).copied().collect();
        used.sort_unstable();
        self.expendable.retain(|(tile, _)| used.binary_search(tile).is_err());
        let needed: u64 = wanted.iter().map(|tile| self.blocks.heap.bytes_of(self.field.class(*tile))).sum();
        while self.blocks.heap.bytes().saturating_add(needed) > self.blocks.heap.budget()
            && let Some((tile, version)) = self.expendable.pop()
        {
            // What is on a page takes no room.
            let paged = self.field.entry(tile).is_some_and(|entry| entry.texels.is_paged());
            if paged || self.field.version(tile) != version {
                continue;
            }
            if let Some(block) = self.take_block(tile) {
                self.blocks.heap.free(&[block]);
                applied.changes.push(Change::all(tile));
                self.mark(tile);
                self.touch(tile, None);
                self.blocks.lost.push(tile);
            }
        }
    }

    /// Allocates and deallocates the tiles of `sets`. New blocks are blank. Tiles that already are as wished are left
    /// out; tiles beyond the budget are reported. With pages, the blocks edited longest ago make room, and those of the
    /// sets come back.
    ///
    /// # Errors
    /// Fails, and does nothing, if a tile does not exist or is a hole, a page cannot be read, or one could not be
    /// written before.
    pub fn apply(&mut self, sets: &Sets) -> Result<Applied> {
        let mut applied = Applied::default();
        self.apply_into(sets, &mut applied)?;
        Ok(applied)
    }

    /// As [`Self::apply`], in place of what `applied` holds, whose room is used again.
    ///
    /// # Errors
    /// Fails as [`Self::apply`].
    #[inline(never)]
    pub fn apply_into(&mut self, sets: &Sets, applied: &mut Applied) -> Result<()> {
        applied.changes.clear();
        applied.refused.clear();
        for tile in sets.allocate.iter().chain(&sets.deallocate) {
            self.check(*tile)?;
        }
        self.report_fault()?;
        self.check_readable(sets.allocate.iter().chain(&sets.modify).copied())?;
        self.begin();
        let mut room = std::mem::take(&mut self.room);
        let Room { freed, wanted, classes, granted } = &mut room;
        freed.clear();
        for tile in &sets.deallocate {
            if self.field.is_allocated(*tile) {
                freed.extend(self.take_block(*tile));
                applied.changes.push(Change::all(*tile));
                self.mark(*tile);
                self.touch(*tile, None);
            }
        }
        self.blocks.heap.free(freed);
        wanted.clear();
        wanted.extend(sets.allocate.iter().copied().filter(|tile| !self.field.is_allocated(*tile)));
        wanted.sort_unstable();
        wanted.dedup();
        self.clear_the_way(sets, wanted);
        self.lose(sets, wanted, applied);
        classes.clear();
        classes.extend(wanted.iter().map(|tile| self.field.class(*tile)));
        self.blocks.heap.allocate_into(classes, granted);
        for (tile, block) in wanted.iter().copied().zip(granted.iter().copied()) {
            let Some(id) = block else {
                applied.refused.push(tile);
                continue;
            };
            let texel = self.field.blank();
            let [texels, mips] = self.blanks[id.class.index()].get_or_insert_with(|| {
                let mips = if T::MIPS { id.class.mip_texels() } else { 0 };
                [id.class.texels(), mips].map(|count| vec![texel; count].into())
            });
            let (texels, mips) = (Slot::Here(texels.clone()), Slot::Here(mips.clone()));
            let entry = Entry { texels, mips, id, version: self.blocks.revision };
            *self.field.entry_mut(tile) = Some(entry);
            self.touch(tile, None);
            applied.changes.push(Change::all(tile));
            self.mark(tile);
        }
        self.room = room;
        Ok(())
    }

    /// Calls `work` for each of `tiles` to change its texels; tiles are worked on in parallel. Returns what changed,
    /// by tile; a tile whose texels stay the same is not touched.
    ///
    /// # Errors
    /// Fails, and changes nothing, if a tile does not exist or is a hole, is not allocated or listed twice, if a page
    /// cannot be read, or if `work` leaves a number that is not finite.
    #[inline(never)]
    pub fn edit(
        &mut self,
        context: &Context,
        tiles: &[u32],
        work: impl Fn(u32, &mut Texels<'_, T>) + Sync,
    ) -> Result<Vec<Change>> {
        for tile in tiles {
            self.check(*tile)?;
            if !self.field.is_allocated(*tile) {
                return Err(Error::invalid("it is not allocated")
                    .at(format!("tile {tile}"))
                    .advise("allocate it first"));
            }
        }
        let scratch = context.scratch();
        let mut order = scratch.list();
        order.extend_from_slice(tiles);
        order.sort_unstable();
        if let Some(pair) = order.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(Error::invalid("it is listed twice").at(format!("tile {}", pair[0])));
        }
        self.check_readable(order.iter().copied())?;
        let field = &self.field;
        let mut edited = scratch.list::<Option<Edited<T>>>();
        context.map_into(order.len(), &mut edited, |index| {
            let tile = order[index];
            let old = field.block(tile).unwrap_or(&[]);
            let mut new = field.copied(tile);
            let size = field.size(tile) as usize;
            if let Some(block) = Arc::get_mut(&mut new) {
                work(tile, &mut Texels { size, block });
            }
            if bytemuck::cast_slice::<T, u8>(old) == bytemuck::cast_slice::<T, u8>(&new) {
                return None;
            }
            let finite = T::all_finite(&new);
            let rect = if T::MIPS { Rect::of_difference(old, &new, size) } else { None };
            let borders = changed_borders(old, &new, size as u32);
            Some(Edited { tile, texels: new, finite, borders, rect })
        });
        if let Some(edited) = edited.iter().flatten().find(|edited| !edited.finite) {
            let place = format!("tile {}", edited.tile);
            return Err(Error::invalid("an edit left a number that is not finite").at(place));
        }
        self.begin();
        let mut changes = scratch.take_list();
        for Edited { tile, borders, rect, texels, .. } in edited.drain(..).flatten() {
            self.replace(tile, texels);
            self.touch(tile, rect);
            changes.push(Change { tile, borders });
        }
        Ok(changes)
    }

    /// Replaces the blocks of tiles, rings included, by ones made from [`Field::block`]. Returns what changed, by tile;
    /// a tile whose texels stay the same is not touched. For edits that make whole blocks anyway; as [`Self::edit`]
    /// else.
    ///
    /// # Errors
    /// Fails, and changes nothing, if a tile does not exist or is a hole, is not allocated or not listed in ascending
    /// order, a length is not that of its block, a page cannot be read, or a number is not finite.
    pub fn put(&mut self, context: &Context, mut blocks: Vec<(u32, Arc<[T]>)>) -> Result<Vec<Change>> {
        let place = |tile: u32| format!("tile {tile}");
        if let Some(pair) = blocks.windows(2).find(|pair| pair[0].0 >= pair[1].0) {
            return Err(Error::invalid("it is not after the one before").at(place(pair[1].0)));
        }
        self.check_readable(blocks.iter().map(|(tile, _)| *tile))?;
        for (tile, texels) in &blocks {
            self.check(*tile)?;
            let Some(old) = self.field.block(*tile) else {
                return Err(Error::invalid("it is not allocated").at(place(*tile)).advise("allocate it first"));
            };
            if texels.len() != old.len() {
                let what = format!("{} texels are not the {} of its block", texels.len(), old.len());
                return Err(Error::invalid(what).at(place(*tile)));
            }
        }
        let field = &self.field;
        let scratch = context.scratch();
        let mut borders = scratch.list::<Option<(bool, u8, Option<Rect>)>>();
        context.map_into(blocks.len(), &mut borders, |index| {
            let (tile, new) = &blocks[index];
            let old = field.block(*tile).unwrap_or(&[]);
            let same = bytemuck::cast_slice::<T, u8>(old) == bytemuck::cast_slice::<T, u8>(new);
            let size = field.size(*tile);
            let rect = || if T::MIPS { Rect::of_difference(old, new, size as usize) } else { None };
            (!same).then(|| (T::all_finite(new), changed_borders(old, new, size), rect()))
        });
        let mut found = blocks.iter().zip(borders.iter());
        if let Some(((tile, _), _)) = found.find(|(_, found)| matches!(found, Some((false, ..)))) {
            return Err(Error::invalid("an edit left a number that is not finite").at(place(*tile)));
        }
        self.begin();
        let mut changes = scratch.take_list();
        for ((tile, texels), found) in blocks.drain(..).zip(borders.drain(..)) {
            if let Some((_, borders, rect)) = found {
                self.replace(tile, texels);
                self.touch(tile, rect);
                changes.push(Change { tile, borders });
            }
        }
        scratch.keep_list(blocks);
        Ok(changes)
    }

    /// Ends an edit: allocates the tiles that `changes` reach and brings borders and rings up to date. Returns the
    /// tiles the budget refused; borders toward them are blank again.
    ///
    /// # Errors
    /// Fails if a tile of `changes` does not exist or is a hole, or a page cannot be read or written.
    #[inline(never)]
    pub fn settle(&mut self, context: &Context, changes: &[Change]) -> Result<Vec<u32>> {
        let scratch = context.scratch();
        let mut reached = scratch.list();
        ring::reached(&self.field, changes, &mut reached);
        if reached.is_empty() {
            self.follow_changes(context, changes, &mut reached)?;
            return Ok(Vec::new());
        }
        let sets = Sets { allocate: reached.detach(), ..Sets::default() };
        let mut applied = scratch.lend::<Applied>();
        let done = self.apply_into(&sets, &mut applied);
        sets.give_back(context);
        done?;
        let mut all = scratch.list();
        all.extend(changes.iter().chain(&applied.changes));
        self.follow_changes(context, &all, &mut scratch.list())?;
        Ok(applied.refused.drain(..).collect())
    }

    /// Brings borders and rings up to date, see [`crate::quads::ring`]. Returns the tiles that changed by it, ascending.
    ///
    /// # Errors
    /// Fails if a tile of `changes` does not exist or is a hole, or a page cannot be read or written.
    #[inline(never)]
    pub fn update_rings(&mut self, context: &Context, changes: &[Change]) -> Result<Vec<u32>> {
        let mut tiles = Vec::new();
        self.follow_changes(context, changes, &mut tiles)?;
        Ok(tiles)
    }

    /// As [`Self::update_rings`]; the tiles are in place of what `tiles` holds.
    #[inline(never)]
    fn follow_changes(&mut self, context: &Context, changes: &[Change], tiles: &mut Vec<u32>) -> Result<()> {
        for change in changes {
            self.check(change.tile)?;
        }
        self.begin();
        tiles.clear();
        let mut plan = context.scratch().lend::<Plan>();
        ring::plan(&View::whole(&self.field), changes.iter().copied(), &mut plan);
        let mut writes = context.scratch().lend::<Writes<T>>();
        for pass in [ring::borders, ring::rings] {
            pass(context, &self.field, &plan, &mut writes);
            tiles.extend(writes.iter().map(|(_, tile, _)| tile));
            self.write_texels(context, &writes);
        }
        drop(writes);
        tiles.sort_unstable();
        tiles.dedup();
        self.update_mips(context);
        self.trim();
        self.report_fault()
    }

    /// Gives back the blocks of those of `tiles` that hold nothing but what tiles without a block read as, unless a
    /// neighbour's texels reach into them: nothing reads otherwise afterwards. Returns the tiles, ascending.
    ///
    /// # Errors
    /// Fails, and changes nothing, if a tile does not exist or is a hole. Fails too if a page cannot be read or
    /// written.
    #[inline(never)]
    pub fn reclaim(&mut self, context: &Context, tiles: &[u32]) -> Result<Vec<u32>> {
        for tile in tiles {
            self.check(*tile)?;
        }
        let blank = self.field.blank();
        let block = |tile: &u32| self.field.try_block(*tile).ok().flatten();
        let empty = |tile: &u32| block(tile).is_some_and(|block| block.iter().all(|c| c.is_blank(blank)));
        let mut gone: Vec<u32> = tiles.iter().copied().filter(empty).collect();
        gone.sort_unstable();
        gone.dedup();
        if gone.is_empty() {
            return Ok(gone);
        }
        // Whether the neighbours would want them again.
        let mut without = self.field.clone();
        gone.iter().for_each(|tile| *without.entry_mut(*tile) = None);
        let topology = self.field.topology();
        let mut around: Vec<u32> = gone.iter().flat_map(|tile| neighbours(topology, *tile)).collect();
        around.sort_unstable();
        around.dedup();
        let around: Vec<Change> = around.into_iter().map(Change::all).collect();
        let mut wanted = context.scratch().list();
        ring::reached(&without, &around, &mut wanted);
        gone.retain(|tile| wanted.binary_search(tile).is_err());
        let applied = self.apply(&Sets { deallocate: gone.clone(), ..Sets::default() })?;
        self.update_rings(context, &applied.changes)?;
        Ok(gone)
    }

    /// Makes everything up to now visible as a snapshot.
    pub fn commit(&mut self) -> Arc<Snapshot<T>> {
        if !self.pending.is_empty() {
            self.update_mips(&Context::serial());
        }
        self.trim();
        self.changed.sort_unstable();
        for tile in &self.changed {
            self.listed[*tile as usize / 64] &= !(1 << (tile % 64));
        }
        let mut snapshot = self.snapshots.take().unwrap_or_else(|| Arc::new(Snapshot::new(self.field.clone())));
        if let Some(made) = Arc::get_mut(&mut snapshot) {
            made.field.copy_from(&self.field);
            made.changed.clear();
            std::mem::swap(&mut made.changed, &mut self.changed);
            (made.revision, made.bytes, made.is_spent) = (self.blocks.revision, self.blocks.heap.bytes(), false);
        }
        self.snapshots.watch(&snapshot);
        snapshot
    }

    /// The block of `tile` as bytes: `(size + 2)²` texels, of little-endian numbers; `None` if it is not allocated.
    ///
    /// # Errors
    /// Fails if the tile does not exist or is a hole, or it is on a page that cannot be read.
    pub fn read(&self, tile: u32) -> Result<Option<Vec<u8>>> {
        self.check(tile)?;
        Ok(self.field.try_block(tile)?.map(|block| bytemuck::cast_slice(block).to_vec()))
    }

    /// Puts back what [`Self::read`] gave, rings and all: allocates or deallocates as needed. When all tiles of an
    /// edit are put back their rings agree; after anything else, call [`Self::update_rings`].
    ///
    /// # Errors
    /// Fails, and changes nothing, if the tile does not exist or is a hole, the length is not that of its block, a
    /// number is not finite, the budget does not allow it, or a page cannot be written.
    #[inline(never)]
    pub fn write(&mut self, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
        self.check(tile)?;
        let Some(bytes) = bytes else {
            self.apply(&Sets { deallocate: vec![tile], ..Sets::default() })?;
            return Ok(());
        };
        let place = || format!("tile {tile}");
        let class = self.field.class(tile);
        let expected = class.bytes(size_of::<T>());
        if bytes.len() as u64 != expected {
            return Err(Error::invalid(format!("a block of {} bytes cannot be put back", bytes.len()))
                .at(place())
                .advise(format!("tiles of {} texels have {expected} bytes", class.size())));
        }
        let texels: Arc<[T]> = bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect();
        if !T::all_finite(&texels) {
            return Err(Error::invalid("a number of the block is not finite").at(place()));
        }
        let fits = if self.is_paged(tile) {
            self.begin();
            self.make_room(self.blocks.heap.bytes_of(class), &[])
        } else {
            self.apply(&Sets { allocate: vec![tile], ..Sets::default() })?.refused.is_empty()
        };
        if !fits {
            self.report_fault()?;
            return Err(Error::memory("the tiles need more than their budget")
                .at(place())
                .advise(format!("allow more than {} bytes", self.budget())));
        }
        self.replace(tile, texels);
        self.touch_all(tile);
        Ok(())
    }

    /// Begins an edit. Blocks that only commits hold which nobody looks at any more are the channel's own again.
    pub(crate) fn begin(&mut self) {
        self.blocks.revision += 1;
        self.release_spent();
    }

    /// Has no blocks and pages any more that only such commits hold.
    pub(crate) fn release_spent(&mut self) {
        self.snapshots.for_each_free(|snapshot| {
            if !snapshot.is_spent {
                snapshot.field.release();
                snapshot.is_spent = true;
            }
        });
    }

    pub(crate) fn check(&self, tile: u32) -> Result<()> {
        if tile as usize >= self.field.tile_count() {
            return Err(Error::invalid(format!("tile {tile} does not exist"))
                .advise(format!("use 0 to {}", self.field.tile_count() - 1)));
        }
        if self.field.topology().is_hole(tile) {
            return Err(Error::invalid("it belongs to a hole").at(format!("tile {tile}")));
        }
        Ok(())
    }

    /// Tiles changed since the last commit.
    pub(crate) fn pending(&self) -> &[u32] {
        &self.changed
    }

    pub(crate) fn mark(&mut self, tile: u32) {
        let (word, bit) = (tile as usize / 64, 1 << (tile % 64));
        if self.listed[word] & bit == 0 {
            self.listed[word] |= bit;
            self.changed.push(tile);
        }
    }

    fn replace(&mut self, tile: u32, texels: Arc<[T]>) {
        let version = self.blocks.revision;
        if let Some(entry) = self.field.entry(tile)
            && entry.texels.is_paged()
        {
            let mips = entry.mips.shared();
            let lost = mips.is_err().then(|| Arc::from(&*entry.mips));
            self.place(tile, [texels.clone(), mips.ok().or(lost.clone()).unwrap_or_default()]);
            if lost.is_some() {
                self.touch_all(tile);
            }
        }
        if let Some(entry) = self.field.entry_mut(tile) {
            let old = std::mem::replace(&mut entry.texels, Slot::Here(texels));
            entry.version = version;
            if let Slot::Here(old) = old {
                self.field.spare.keep(old);
            }
            self.mark(tile);
        }
    }

    /// Writes single texels: in place where no snapshot shares the block, else to a copy.
    #[inline(never)]
    fn write_texels(&mut self, context: &Context, writes: &Writes<T>) {
        let version = self.blocks.revision;
        let mut room = context.scratch().lend::<SharedRoom<T>>();
        let SharedRoom { shared, copies } = &mut *room;
        shared.clear();
        for (at, tile, list) in writes.iter() {
            self.mark(tile);
            if T::MIPS {
                let (size, indices) = (self.field.size(tile) as usize, list.iter().map(|(at, _)| *at as usize));
                Rect::of_indices(indices, size, |rect| self.touch(tile, Some(rect)));
            }
            // What cannot be read back cannot be written to; it is reported.
            if !self.fetch(tile) {
                continue;
            }
            let Some(entry) = self.field.entry_mut(tile) else { continue };
            entry.version = version;
            match entry.texels.here_mut().and_then(Arc::get_mut) {
                Some(block) => list.iter().for_each(|(at, value)| block[*at as usize] = *value),
                None => shared.push((tile, at)),
            }
        }
        let field = &self.field;
        context.map_into(shared.len(), copies, |index| {
            let (tile, at) = shared[index];
            let mut texels = field.copied(tile);
            if let Some(block) = Arc::get_mut(&mut texels) {
                writes.list(at).iter().for_each(|(at, value)| block[*at as usize] = *value);
            }
            texels
        });
        for ((tile, _), texels) in shared.drain(..).zip(copies.drain(..)) {
            self.replace(tile, texels);
        }
    }
}

/// What an edit made of a tile.
struct Edited<T> {
    tile: u32,
    texels: Arc<[T]>,
    /// Whether all its numbers are.
    finite: bool,
    borders: u8,
    rect: Option<Rect>,
}

/// Tiles whose blocks somebody shares, where in the writes theirs are, and the copies that take the place of the blocks.
struct SharedRoom<T> {
    shared: Vec<(u32, WritesAt)>,
    copies: Vec<Arc<[T]>>,
}

impl<T> Default for SharedRoom<T> {
    fn default() -> Self {
        Self { shared: Vec::new(), copies: Vec::new() }
    }
}

/// The class of a tile whose face has `class`: sub-tiles are half as large.
pub(crate) fn class_of(topology: &TileTopology, tile: u32, class: SizeClass) -> Result<SizeClass> {
    if topology.is_sub(tile) { SizeClass::of((class.size() / 2).max(MIN_SIZE)) } else { Ok(class) }
}

/// The tiles that share a vertex or a part of an edge with `tile`, itself among them, with repetition.
pub(crate) fn neighbours(topology: &TileTopology, tile: u32) -> impl Iterator<Item = u32> {
    let middles = (0..4).filter_map(move |edge| match topology.link(tile, edge) {
        Link::Halves { middle, .. } => Some(middle),
        _ => None,
    });
    let rings = topology.rings(tile).iter().copied().chain(middles);
    rings.flat_map(|ring| topology.ring(ring)).map(|entry| entry.tile)
}

/// Which border rows differ between two blocks, as bits.
fn changed_borders<T: Texel>(old: &[T], new: &[T], size: u32) -> u8 {
    let differs = |edge: u8| {
        let line = Line::new(size, edge, 0);
        (0..size as isize).any(|k| !old[line.at(k)].same(new[line.at(k)]))
    };
    (0..4).filter(|edge| differs(*edge)).map(|edge| 1 << edge).sum()
}
