//! The mips of a tile: levels of half, a quarter, … of its texels a side, down to two, for filtered look-ups.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 5 and
//! Figure 5. A texel of a level is the mean, in linear light, of two by two texels of the level below; every level has
//! a ring of its own, made by [`crate::quads::ring`]. Only what lies above changed texels is made anew. At vertices where
//! texels are equalised a level holds something else than means at its corners; the means there are found from the
//! level below whenever they are needed. Units: texels.

use std::ops::Range;
use std::sync::Arc;

use relievo_core::Context;
use relievo_core::simd::Level;

use crate::quads::channel::Channel;
use crate::quads::field::Entry;
use crate::quads::ring::{self, Change, Plan, View, Writes};
use crate::store::heap::{MAX_SIZE, SizeClass};
use crate::store::paging::Paged;
use crate::store::slot::Slot;
use crate::texel::Texel;

/// Texels of a tile that changed, without the ring.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Rect {
    pub columns: Range<usize>,
    pub rows: Range<usize>,
}

impl Rect {
    /// All texels of a tile.
    pub fn whole(size: usize) -> Self {
        Self { columns: 0..size, rows: 0..size }
    }

    /// Where two blocks of `size`² texels and their rings differ, ring left out; `None` if nowhere.
    pub fn of_difference<T: Texel>(old: &[T], new: &[T], size: usize) -> Option<Self> {
        let stride = size + 2;
        let row = |block: &'_ [T], j: usize| -> Range<usize> {
            let start = (j + 1) * stride + 1;
            start..(start + size).min(block.len())
        };
        let differs = |j: &usize| {
            let row = row(old, *j);
            bytemuck::cast_slice::<T, u8>(&old[row.clone()]) != bytemuck::cast_slice::<T, u8>(&new[row])
        };
        let first = (0..size).find(differs)?;
        let last = (first..size).rev().find(differs)?;
        let (mut low, mut high) = (size, 0);
        for j in first..=last {
            let row = row(old, j);
            let (old, new) = (&old[row.clone()], &new[row]);
            low = (0..low).find(|i| !old[*i].same(new[*i])).unwrap_or(low);
            high = (high..size).rev().find(|i| !old[*i].same(new[*i])).map_or(high, |i| i + 1);
        }
        Some(Self { columns: low..high, rows: first..last + 1 })
    }

    /// Calls `each` with the rectangles of texels of the block with the indices `list`: one each if they are few, else
    /// one for all.
    pub fn of_indices(list: impl Iterator<Item = usize> + Clone, size: usize, mut each: impl FnMut(Self)) {
        /// Above this many a common rectangle is less work.
        const MAX_SINGLE: usize = 8;
        let stride = size + 2;
        let inside = |at: &usize| (1..=size).contains(&(at % stride)) && (1..=size).contains(&(at / stride));
        let texels = list.filter(inside).map(|at| (at % stride - 1, at / stride - 1));
        let texel = |(i, j): (usize, usize)| Self { columns: i..i + 1, rows: j..j + 1 };
        if texels.clone().nth(MAX_SINGLE).is_none() {
            return texels.map(texel).for_each(each);
        }
        let both = |a: Range<usize>, b: Range<usize>| a.start.min(b.start)..a.end.max(b.end);
        let with = |a: Self, b: Self| Self { columns: both(a.columns, b.columns), rows: both(a.rows, b.rows) };
        texels.map(texel).reduce(with).into_iter().for_each(&mut each);
    }

    /// What lies above it, `levels` levels up.
    fn halved(&self, levels: u32) -> Self {
        let half = |range: &Range<usize>| range.start >> levels..range.end.div_ceil(1 << levels);
        Self { columns: half(&self.columns), rows: half(&self.rows) }
    }
}

/// A tile whose mips are made anew above some of the rectangles that are pending.
struct MipWork<T> {
    tile: u32,
    rects: Range<usize>,
    class: SizeClass,
    texels: Arc<[T]>,
    mips: Arc<[T]>,
}

impl<T: Texel> Channel<T> {
    /// Brings mips up to date with what was written. [`Self::settle`], [`Self::update_rings`] and [`Self::commit`] do
    /// it as well; only who reads filtered colours after [`Self::write`] and before any of them needs to.
    #[inline(never)]
    pub fn update_mips(&mut self, context: &Context) {
        let mut pending = std::mem::take(&mut self.pending);
        if pending.is_empty() {
            return;
        }
        pending.sort_unstable_by_key(|(tile, _)| *tile);
        // Mips leave their entries while they are written, so that those nobody else holds are written in place.
        let mut work = context.scratch().list::<MipWork<T>>();
        let mut first = 0;
        for own in pending.chunk_by(|a, b| a.0 == b.0) {
            let rects = first..first + own.len();
            first = rects.end;
            if own.iter().all(|(_, rect)| rect.is_none()) {
                continue;
            }
            let tile = own[0].0;
            self.fetch(tile);
            if let Some(Entry { texels: Slot::Here(texels), mips: Slot::Here(mips), id, .. }) =
                self.field.entry_mut(tile)
            {
                let (class, texels, mips) = (id.class, texels.clone(), std::mem::take(mips));
                work.push(MipWork { tile, rects, class, texels, mips });
            }
        }
        let spare = self.field.spare.clone();
        context.for_each_mut(&mut work, |_, MipWork { rects, class, texels, mips, .. }| {
            if Arc::get_mut(mips).is_none() {
                *mips = spare.copy_of(mips);
            }
            if let Some(mips) = Arc::get_mut(mips) {
                let rects = pending[rects.clone()].iter().filter_map(|(_, rect)| rect.as_ref());
                refresh(context.level(), *class, texels, mips, rects);
            }
        });
        for MipWork { tile, mips, .. } in work.drain(..) {
            if let Some(entry) = self.field.entry_mut(tile) {
                entry.mips = Slot::Here(mips);
            }
        }
        let mut plan = context.scratch().lend::<Plan>();
        let changes = pending.chunk_by(|a, b| a.0 == b.0).map(|own| Change::all(own[0].0));
        ring::plan(&View::at(&self.field, 2 * MAX_SIZE), changes, &mut plan);
        pending.clear();
        self.pending = pending;
        let mut writes = context.scratch().lend::<Writes<T>>();
        ring::mip_rings(context, &self.field, &plan, &mut writes);
        for (_, tile, list) in writes.iter() {
            self.fetch(tile);
            let Some(Entry { mips: Slot::Here(mips), .. }) = self.field.entry_mut(tile) else { continue };
            if Arc::get_mut(mips).is_none() {
                *mips = spare.copy_of(mips);
            }
            if let Some(mips) = Arc::get_mut(mips) {
                list.iter().for_each(|(at, value)| mips[*at as usize] = *value);
            }
        }
    }

    /// Notes that mips of `tile` and its neighbours are to be made anew: above `rect`, if there is one, and their rings.
    pub(crate) fn touch(&mut self, tile: u32, rect: Option<Rect>) {
        if T::MIPS {
            self.pending.push((tile, rect));
        }
    }

    /// As [`Self::touch`], of all texels of `tile`.
    pub(crate) fn touch_all(&mut self, tile: u32) {
        self.touch(tile, Some(Rect::whole(self.field.size(tile) as usize)));
    }
}

/// Brings the mips above `rects` of `texels` up to date, rings and equalised corners left out: these are means again
/// afterwards.
fn refresh<'a, T: Texel>(
    simd: Level,
    class: SizeClass,
    texels: &[T],
    mips: &mut [T],
    rects: impl Iterator<Item = &'a Rect> + Clone,
) {
    let mut size = class.size() as usize;
    for level in 1..=class.mips() {
        let (below, rest) = mips.split_at_mut(class.level_start(level).min(mips.len()));
        let source = if level == 1 { texels } else { &below[class.level_start(level - 1)..] };
        let target = &mut rest[..class.level_texels(level)];
        let (from, to) = (size + 2, size / 2 + 2);
        for rect in rects.clone() {
            let rect = rect.halved(level);
            let (first, count) = (rect.columns.start, rect.columns.len());
            for j in rect.rows {
                let row = |j: usize| &source[j * from + 1 + 2 * first..][..2 * count];
                let out = &mut target[(j + 1) * to + 1 + first..][..count];
                T::shrink(simd, row(2 * j + 1), row(2 * j + 2), out);
            }
        }
        for corner in 0..4 {
            let (right, up) = place(corner);
            let (own, other) = (|far: bool| if far { to - 2 } else { 1 }, |far: bool| if far { from - 2 } else { 1 });
            let value = source[other(up) * from + other(right)];
            target[own(up) * to + own(right)] = corner_mean(source, size, corner, value);
        }
        size /= 2;
    }
}

/// Whether a corner is on the side of u = 1, and of v = 1.
fn place(corner: u8) -> (bool, bool) {
    (corner == 1 || corner == 2, corner >= 2)
}

/// The mean of the two by two texels at `corner` of a block of `size`², where that at the corner itself is `value`.
pub(crate) fn corner_mean<T: Texel>(block: &[T], size: usize, corner: u8, value: T) -> T {
    let (right, up) = place(corner);
    let start = |far: bool| if far { size - 1 } else { 1 };
    let at = |i: usize, j: usize| block[(start(up) + j) * (size + 2) + start(right) + i];
    let mut square = [[at(0, 0), at(1, 0)], [at(0, 1), at(1, 1)]];
    square[usize::from(up)][usize::from(right)] = value;
    let mut mean = [T::zeroed()];
    T::shrink(Level::Baseline, &square[0], &square[1], &mut mean);
    mean[0]
}
