//! The mips of a tile: levels of half, a quarter, … of its texels a side, down to two, for filtered look-ups.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 5 and
//! Figure 5. A texel of a level is the mean, in linear light, of two by two texels of the level below; every level has
//! a ring of its own, made by [`crate::ring`]. Only what lies above changed texels is made anew. At vertices where
//! texels are equalised a level holds something else than means at its corners; the means there are found from the
//! level below whenever they are needed. Units: texels.

use std::ops::Range;

use relievo_core::simd::Level;

use crate::heap::SizeClass;
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

    /// The rectangles of texels of the block with the indices `list`: one each if they are few, else one for all.
    pub fn of_indices(list: impl Iterator<Item = usize> + Clone, size: usize) -> Vec<Self> {
        /// Above this many a common rectangle is less work.
        const FEW: usize = 8;
        let stride = size + 2;
        let inside = |at: &usize| (1..=size).contains(&(at % stride)) && (1..=size).contains(&(at / stride));
        let place = |at: usize| (at % stride - 1, at / stride - 1);
        let texels: Vec<(usize, usize)> = list.filter(inside).map(place).collect();
        if texels.len() <= FEW {
            return texels.iter().map(|(i, j)| Self { columns: *i..i + 1, rows: *j..j + 1 }).collect();
        }
        let range = |of: fn(&(usize, usize)) -> usize| {
            let all = texels.iter().map(of);
            all.clone().min().unwrap_or(0)..all.max().map_or(0, |last| last + 1)
        };
        vec![Self { columns: range(|place| place.0), rows: range(|place| place.1) }]
    }

    /// What lies above it.
    fn halved(&self) -> Self {
        let half = |range: &Range<usize>| range.start / 2..range.end.div_ceil(2);
        Self { columns: half(&self.columns), rows: half(&self.rows) }
    }
}

/// Brings the mips above `rects` of `texels` up to date, rings and equalised corners left out: these are means again
/// afterwards.
pub(crate) fn refresh<T: Texel>(simd: Level, class: SizeClass, texels: &[T], mips: &mut [T], rects: &[Rect]) {
    let mut rects = rects.to_vec();
    let mut size = class.size() as usize;
    for level in 1..=class.mips() {
        let (below, rest) = mips.split_at_mut(class.level_start(level).min(mips.len()));
        let source = if level == 1 { texels } else { &below[class.level_start(level - 1)..] };
        let target = &mut rest[..class.level_texels(level)];
        let (from, to) = (size + 2, size / 2 + 2);
        for rect in &mut rects {
            *rect = rect.halved();
            let (first, count) = (rect.columns.start, rect.columns.len());
            for j in rect.rows.clone() {
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
