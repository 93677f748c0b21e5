//! Tiles at other sizes: faces that are given another, and edits at half or a quarter of the texels.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 7.1,
//! where an edit is made at T, T/2 or T/4. A tile has one size at a time. What it is at a coarser level follows from
//! it, by the left inverse of subdivision (Samavati and Bartels 1999); an edit there is carried to the tile by adding
//! the subdivided difference, so that finer detail stays, where the paper copies values and loses it. For B-spline
//! coefficients that is exact, for colours it is bilinear interpolation; the same masks do both. Faces without any tile
//! yet get the size that the level asks for, and finer edits enlarge them. Units: those of the texels.

use std::collections::BTreeMap;
use std::sync::Arc;

use bytemuck::Zeroable;
use relievo_core::{Context, Error, Result};

use crate::quads::channel::{Applied, Channel, class_of};
use crate::quads::field::{Entry, Field};
use crate::quads::ring::{self, Change, Plan, View, Writes};
use crate::quads::spline::{coarsen_block, subdivide_block};
use crate::store::heap::SizeClass;
use crate::store::paging::Paged;
use crate::store::sets::Sets;
use crate::store::slot::Slot;
use crate::texel::{Texel, Value};

/// The coarsest level of edits: a quarter of the texels.
pub const MAX_LEVEL: u32 = 2;

impl<T: Texel> Field<T> {
    /// The allocated ones of `tiles` at the size of an edit's `level`, with their rings; no other tile is in it.
    ///
    /// # Errors
    /// Fails if the level is above [`MAX_LEVEL`] or a tile does not exist.
    pub fn at_level(&self, context: &Context, level: u32, tiles: &[u32]) -> Result<Self> {
        if level > MAX_LEVEL {
            return Err(Error::invalid(format!("there is no level {level}")).advise("use 0, 1 or 2"));
        }
        if let Some(tile) = tiles.iter().find(|tile| **tile as usize >= self.tile_count()) {
            return Err(Error::invalid(format!("tile {tile} does not exist")));
        }
        let classes: Vec<SizeClass> = (0..self.tile_count() as u32).map(|tile| self.class_at(tile, level)).collect();
        let blocks = context.map(tiles.len(), |index| {
            let (tile, block) = (tiles[index], self.block(tiles[index])?);
            let (from, to) = (self.size(tile) as usize, classes[tile as usize].size() as usize);
            Some((tile, if from == to { block.into() } else { texels(&convert(values(block), from, to)) }))
        });
        Ok(self.like(classes, self.blank(), blocks.into_iter().flatten().collect()))
    }
}

impl<T: Texel> Channel<T> {
    /// Carries an edit at another level to the tiles. `level` is what [`Field::at_level`] made of this channel's field;
    /// `blocks` are new blocks of some of its tiles, ascending, rings of no account. Allocates what is not allocated
    /// and enlarges faces that are coarser than the level. Returns what changed and what the budget refused, for
    /// [`Self::settle`].
    ///
    /// # Errors
    /// Fails, and changes no texel, as [`Self::put`] and [`Self::resize`] do.
    pub fn put_at(&mut self, context: &Context, level: &Field<T>, blocks: Vec<(u32, Arc<[T]>)>) -> Result<Applied> {
        if let Some(pair) = blocks.windows(2).find(|pair| pair[0].0 >= pair[1].0) {
            return Err(Error::invalid("it is not after the one before").at(format!("tile {}", pair[1].0)));
        }
        for (tile, block) in &blocks {
            self.check(*tile)?;
            let class = level.class(*tile);
            if block.len() != class.texels() {
                let what = format!("{} texels are not the {} of its block", block.len(), class.texels());
                return Err(Error::invalid(what).at(format!("tile {tile}")));
            }
            if !T::all_finite(block) {
                let fault = Error::invalid("an edit left a number that is not finite");
                return Err(fault.at(format!("tile {tile}")));
            }
        }
        // A coefficient at a border is one of the neighbour's ring, and so changes the neighbour's finer ones.
        let differences = differences(context, level, &blocks);
        let mut tiles: Vec<u32> = differences.allocated().collect();
        let resized = self.fit(context, level, &tiles)?;
        let mut applied = self.apply(&Sets { allocate: tiles.clone(), ..Sets::default() })?;
        tiles.retain(|tile| applied.refused.binary_search(tile).is_err());
        let field = &self.field;
        let new = context.map(tiles.len(), |index| {
            let tile = tiles[index];
            let (from, to) = (level.size(tile) as usize, field.size(tile) as usize);
            let old = field.block(tile).unwrap_or(&[]);
            if from == to {
                let block = blocks.binary_search_by_key(&tile, |(tile, _)| *tile);
                return (tile, block.map_or_else(|_| old.into(), |at| blocks[at].1.clone()));
            }
            let change = convert(values(differences.block(tile).unwrap_or(&[])), from, to);
            let added = |(old, change): (&T, &T::Value)| {
                let new = T::nearest(old.value() + *change);
                // What the edit does not reach keeps its bits.
                if T::Difference::nearest(*change).is_blank(Zeroable::zeroed()) { *old } else { new }
            };
            (tile, old.iter().zip(&change).map(added).collect())
        });
        applied.changes.extend(resized);
        applied.changes.extend(self.put(context, new)?);
        Ok(applied)
    }

    /// Gives the faces of `tiles` the size of the level where they have no tile yet, or are coarser.
    #[inline(never)]
    fn fit(&mut self, context: &Context, level: &Field<T>, tiles: &[u32]) -> Result<Vec<Change>> {
        let topology = self.field.topology().clone();
        let mut faces: Vec<u32> = tiles.iter().map(|tile| topology.face(*tile)).collect();
        faces.dedup();
        let mut sizes = BTreeMap::new();
        for face in faces {
            let tiles = || topology.tiles_of(face);
            let used = tiles().any(|tile| self.field.is_allocated(tile));
            let differs = |tile: u32| {
                let (own, wanted) = (self.field.class(tile), level.class(tile));
                own < wanted || (!used && own > wanted)
            };
            if tiles().any(differs) {
                sizes.extend(tiles().map(|tile| (tile, level.class(tile))));
            }
        }
        self.convert(context, sizes)
    }

    /// Gives faces other sizes, texels along an edge of the cage. What is allocated is kept: exactly, but for rounding,
    /// where a face becomes finer; where it becomes coarser in the least detail, of colours as means. Returns tiles
    /// that the budget refused to allocate beside a coarser one, as [`Self::settle`] does.
    ///
    /// # Errors
    /// Fails, and changes nothing, if a face or size does not exist, the budget does not allow it, or a page cannot be
    /// read. Fails too if a page cannot be written.
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
        let changes = self.convert(context, sizes.clone())?;
        sizes.into_iter().for_each(|(tile, class)| self.field.give_class(tile, class));
        self.settle(context, &changes)
    }

    /// Gives every face the size that `sizes` has for it, of which it was given `given`, or the same if that is empty,
    /// as when an edit is undone. Tiles that change their size are blank and not allocated afterwards; their blocks are
    /// to be put back, and then [`Self::update_rings`] or all of their neighbours' blocks.
    ///
    /// # Errors
    /// Fails, and changes nothing, if a size does not exist, there is not one for every face, or a page could not be
    /// read or written before.
    #[inline(never)]
    pub fn reshape(&mut self, sizes: &[u32], given: &[u32]) -> Result<()> {
        let topology = self.field.topology().clone();
        let given = if given.is_empty() { sizes } else { given };
        if sizes.len() != topology.face_count() || given.len() != topology.face_count() {
            return Err(Error::invalid("there is not a size for every face"));
        }
        let classes = |sizes: &[u32]| -> Result<Vec<SizeClass>> {
            (0..topology.tile_count() as u32)
                .map(|tile| class_of(&topology, tile, SizeClass::of(sizes[topology.face(tile) as usize])?))
                .collect()
        };
        let (sizes, given) = (classes(sizes)?, classes(given)?);
        let other = |tile: &u32| sizes[*tile as usize] != self.field.class(*tile);
        let tiles: Vec<u32> = (0..topology.tile_count() as u32).filter(other).collect();
        let allocated = tiles.iter().copied().filter(|tile| self.field.is_allocated(*tile)).collect();
        self.apply(&Sets { deallocate: allocated, ..Sets::default() })?;
        // While tiles have the sizes that their mips have.
        self.update_mips(&Context::serial());
        for tile in &tiles {
            let (own, class) = (self.field.class(*tile), sizes[*tile as usize]);
            if !topology.is_hole(*tile) {
                self.full_bytes = self.full_bytes - self.blocks.heap.bytes_of(own) + self.blocks.heap.bytes_of(class);
            }
            self.field.set_class(*tile, class);
        }
        if !tiles.is_empty() {
            self.field.compare();
        }
        (0..).zip(given).for_each(|(tile, class)| {
            if self.field.class_at(tile, 0) != class {
                self.field.give_class(tile, class);
            }
        });
        Ok(())
    }

    /// Gives the faces of `tiles`, ascending, the sizes they have in `other`, which an edit changed, as an edit at
    /// another level does: where there is no tile yet, or it is coarser. Returns what changed, for [`Self::settle`].
    ///
    /// # Errors
    /// Fails, and changes nothing, if the budget does not allow it, or a page cannot be read.
    pub fn follow_sizes(&mut self, context: &Context, other: &Field<T>, tiles: &[u32]) -> Result<Vec<Change>> {
        self.fit(context, other, tiles)
    }

    /// Gives tiles other sizes. Returns those whose blocks changed.
    #[inline(never)]
    fn convert(&mut self, context: &Context, mut sizes: BTreeMap<u32, SizeClass>) -> Result<Vec<Change>> {
        let topology = self.field.topology().clone();
        sizes.retain(|tile, class| *class != self.field.class(*tile) && !topology.is_hole(*tile));
        if sizes.is_empty() {
            return Ok(Vec::new());
        }
        let allocated: Vec<(u32, SizeClass)> =
            sizes.iter().filter(|(tile, _)| self.field.is_allocated(**tile)).map(|(a, b)| (*a, *b)).collect();
        self.check_readable(allocated.iter().map(|(tile, _)| *tile))?;
        for (tile, _) in &allocated {
            self.bring_back(*tile)?;
        }
        let old: u64 = allocated.iter().map(|(tile, _)| self.field.tile_bytes(*tile)).sum();
        let new: u64 = allocated.iter().map(|(_, class)| self.blocks.heap.bytes_of(*class)).sum();
        let keep: Vec<u32> = allocated.iter().map(|(tile, _)| *tile).collect();
        if new > old && !self.make_room(new - old, &keep) {
            self.trim();
            self.report_fault()?;
            return Err(Error::memory("the tiles need more than their budget")
                .advise(format!("allow at least {} bytes", self.bytes() - old + new)));
        }
        self.update_mips(context);
        self.begin();
        let field = &self.field;
        let blocks: Vec<Arc<[T]>> = context.map(allocated.len(), |index| {
            let (tile, class) = allocated[index];
            let (from, to) = (field.size(tile), class.size());
            match field.level(tile, (from / to).max(1).ilog2()).filter(|_| T::MIPS && to < from) {
                Some(mip) => mip.into(),
                None => texels(&convert(values(field.block(tile).unwrap_or(&[])), from as usize, to as usize)),
            }
        });
        let freed: Vec<_> = allocated.iter().filter_map(|(tile, _)| self.take_block(*tile)).collect();
        self.blocks.heap.free(&freed);
        for (tile, class) in &sizes {
            let own = self.field.class(*tile);
            self.full_bytes = self.full_bytes - self.blocks.heap.bytes_of(own) + self.blocks.heap.bytes_of(*class);
            self.field.set_class(*tile, *class);
        }
        self.field.compare();
        let classes: Vec<SizeClass> = allocated.iter().map(|(_, class)| *class).collect();
        // Blocks beyond a budget that was lowered may stay, and so may coarser ones in their place.
        let budget = self.blocks.heap.budget();
        self.blocks.heap.set_budget(u64::MAX);
        let ids = self.blocks.heap.allocate(&classes);
        self.blocks.heap.set_budget(budget);
        for (((tile, class), texels), id) in allocated.iter().zip(blocks).zip(ids) {
            let mips: Arc<[T]> = vec![self.field.blank(); if T::MIPS { class.mip_texels() } else { 0 }].into();
            let (texels, mips) = (Slot::Here(texels), Slot::Here(mips));
            *self.field.entry_mut(*tile) = id.map(|id| Entry { texels, mips, id, version: self.blocks.revision });
            self.mark(*tile);
            self.touch_all(*tile);
        }
        Ok(allocated.iter().map(|(tile, _)| Change::all(*tile)).collect())
    }
}

/// What `blocks` add to the tiles of `level`, and, as rings, to their neighbours.
fn differences<T: Texel>(context: &Context, level: &Field<T>, blocks: &[(u32, Arc<[T]>)]) -> Field<T::Difference> {
    let made = context.map(blocks.len(), |index| {
        let (tile, block) = &blocks[index];
        let blank = level.blank();
        let old = |at: usize| level.block(*tile).map_or(blank, |old| old[at]);
        let difference = |at: usize| {
            let old = old(at);
            if block[at].same(old) {
                return Zeroable::zeroed();
            }
            T::Difference::nearest(block[at].value() - old.value())
        };
        let size = level.size(*tile) as usize;
        let stride = size + 2;
        let inside = |at: usize| (1..=size).contains(&(at % stride)) && (1..=size).contains(&(at / stride));
        let texel = |at: usize| if inside(at) { difference(at) } else { Zeroable::zeroed() };
        (*tile, (0..block.len()).map(texel).collect())
    });
    let classes = (0..level.tile_count() as u32).map(|tile| level.class(tile)).collect();
    let mut field: Field<T::Difference> = level.like(classes, Zeroable::zeroed(), made);
    let changes: Vec<Change> = blocks.iter().map(|(tile, _)| Change::all(*tile)).collect();
    let mut reached = context.scratch().list();
    ring::reached(&field, &changes, &mut reached);
    for tile in reached.iter().copied() {
        field.insert(tile, vec![Zeroable::zeroed(); field.class(tile).texels()].into());
    }
    let mut plan = Plan::default();
    ring::plan(&View::whole(&field), changes.iter().copied(), &mut plan);
    let mut writes = Writes::default();
    ring::rings(context, &field, &plan, &mut writes);
    for (_, tile, list) in writes.iter() {
        let texels = field.entry_mut(tile).as_mut().and_then(|entry| entry.texels.here_mut());
        if let Some(block) = texels.and_then(Arc::get_mut) {
            list.iter().for_each(|(at, value)| block[*at as usize] = *value);
        }
    }
    field
}

fn values<T: Texel>(block: &[T]) -> Vec<T::Value> {
    block.iter().map(|texel| texel.value()).collect()
}

fn texels<T: Texel>(values: &[T::Value]) -> Arc<[T]> {
    values.iter().map(|value| T::nearest(*value)).collect()
}

/// A block of `from` texels a side at `to` texels.
fn convert<V: Value>(mut values: Vec<V>, from: usize, to: usize) -> Vec<V> {
    let mut size = from;
    while size < to {
        values = subdivide_block(&values, size);
        size *= 2;
    }
    while size > to {
        values = coarsen_block(&values, size);
        size /= 2;
    }
    values
}
