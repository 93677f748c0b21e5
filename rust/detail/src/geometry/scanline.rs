//! Scan conversion of triangles into the columns of a voxel grid, and resolution of each column's crossings into
//! solid spans.
//!
//! Corners are snapped to a lattice of 1/256 voxel and what follows is exact: rows step over rational edge positions, so
//! a column centre on a common edge falls into exactly one of two adjacent triangles and closed meshes have no leaks, and
//! the voxel that a column enters or leaves is that of the snapped plane, whatever the processor or graphics device
//! that computes it. Planes are followed in floats; where their rounding could decide, integers do. A column keeps
//! its crossings in one word, two of 16 bits: place and direction. Columns of more crossings have them in a list.
//! Beside them every column keeps the heights of its lowest and its highest crossing, which rays refine their ends by.

use std::cell::Cell;

use relievo_core::dispatch_simd;
use relievo_core::lanes::Lanes;

use crate::geometry::voxel::{CELL, PIECES};

/// Snapped units of a voxel.
pub(crate) const SUB: i64 = 256;

/// The snapped position of the first column's or row's centre.
const HALF: i64 = SUB / 2;

/// Snapped coordinates below which products fit 64 bits. Triangles that reach further are followed in floats alone.
const NARROW: i64 = 1 << 29;

/// Units of the heights of crossings in a voxel.
pub(crate) const FINE: i32 = 1 << 15;

/// The height of no crossing: above every height of a grid, and so little that differences of two heights do not wrap.
pub(crate) const NO_HEIGHT: u32 = 1 << 30;

/// Units by which the rounding of a height may take it beyond the step that its crossing belongs to.
const HEIGHT_SLACK: i32 = FINE / 8;

/// Columns of which heights are followed from one place, at every instruction level the same ones.
const TOGETHER: usize = 16;

/// The sizes a slab is filled with.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Columns of a row.
    pub nx: u32,
    /// Voxels of a column.
    pub nz: u32,
    /// Words of a column.
    pub words: u32,
    /// Whether winding is counted from +z.
    pub backward: bool,
    /// Whether the mesh may have open edges.
    pub open: bool,
}

/// The place of a coordinate in voxels on the lattice.
#[inline(always)]
pub fn snap(value: f64) -> i64 {
    (value * SUB as f64 + 0.5).floor() as i64
}

/// A side of a triangle: x over y in snapped units, from its lower end.
#[derive(Clone, Copy, Debug)]
struct Side {
    x: i64,
    y: i64,
    dx: i64,
    dy: i64,
}

/// A triangle ready for scan conversion.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// First row, row from which the upper short side holds, row after the last. Not yet clipped.
    rows: [i64; 3],
    /// The side from the lowest to the highest corner, and the two others from below.
    long: Side,
    short: [Side; 2],
    /// Whether the long side is on the left.
    long_left: bool,
    /// Whether products need 128 bits.
    wide: bool,
    /// Snapped z of the lowest corner, of the middle and of the highest one.
    heights: [i64; 3],
    /// z over the centre of column (0, 0), and its steps along x and y.
    plane: [f64; 3],
    /// By how much the rounded z over a column may be off, in voxels.
    margin: f32,
    /// Range of z, in steps of the column, clipped to the grid.
    range: [f64; 2],
    /// 1 where the column leaves the solid here, 0 where it enters.
    leaves: u64,
}

impl Facet {
    /// A facet that no row meets.
    pub const NONE: Self = Self {
        rows: [0; 3],
        long: Side { x: 0, y: 0, dx: 0, dy: 1 },
        short: [Side { x: 0, y: 0, dx: 0, dy: 1 }; 2],
        long_left: false,
        wide: false,
        heights: [0; 3],
        plane: [0.0; 3],
        margin: 0.0,
        range: [0.0; 2],
        leaves: 0,
    };

    /// Sets up a triangle given on the lattice; `None` if no column meets it or it does not matter.
    #[inline(always)]
    pub fn new(corners: &[[i64; 3]; 3], mirrored: bool, [nx, ny, nz]: [i64; 3], backward: bool) -> Option<Self> {
        let mut corners = corners.map(|[x, y, z]| (x, y, z));
        // A corner at the centre of row j belongs to row j: rows are half open upwards.
        let row = |y: i64| (y - HALF + SUB - 1).div_euclid(SUB);
        let mut odd = mirrored;
        for (a, b) in [(0, 1), (1, 2), (0, 1)] {
            if corners[b].1 < corners[a].1 {
                corners.swap(a, b);
                odd = !odd;
            }
        }
        let [(x0, y0, z0), (x1, y1, z1), (x2, y2, z2)] = corners;
        let rows = [row(y0), row(y1), row(y2)];
        if rows[0] == rows[2] || rows[2] <= 0 || rows[0] >= ny {
            return None;
        }
        let (low, high) = (x0.min(x1).min(x2), x0.max(x1).max(x2));
        if row(high) <= 0 || row(low) >= nx || row(low) == row(high) {
            return None;
        }
        let step = |z: i64| row(z).clamp(0, nz);
        let (bottom, top) = (z0.min(z1).min(z2), z0.max(z1).max(z2));
        let range = [step(bottom), step(top)];
        if if backward { range[1] <= 0 } else { range[0] >= nz } {
            return None;
        }
        let wide = low.min(y0).min(bottom) < -NARROW || high.max(y2).max(top) > NARROW;
        // Twice the area, and the integers that are proportional to the plane's steps.
        let [area, a, b] = if wide {
            let cross = |p: i64, q: i64, r: i64, s: i64| i128::from(p) * i128::from(q) - i128::from(r) * i128::from(s);
            [
                cross(x1 - x0, y2 - y0, x2 - x0, y1 - y0) as f64,
                cross(z1 - z0, y2 - y0, z2 - z0, y1 - y0) as f64,
                cross(z2 - z0, x1 - x0, z1 - z0, x2 - x0) as f64,
            ]
        } else {
            [
                ((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)) as f64,
                ((z1 - z0) * (y2 - y0) - (z2 - z0) * (y1 - y0)) as f64,
                ((z2 - z0) * (x1 - x0) - (z1 - z0) * (x2 - x0)) as f64,
            ]
        };
        if area == 0.0 {
            return None;
        }
        let (slope_x, slope_y) = (a / area, b / area);
        let unit = |value: i64| value as f64 / SUB as f64;
        let (from_x, from_y) = (unit(HALF - x0), unit(HALF - y0));
        let base = unit(z0) + slope_x * from_x + slope_y * from_y;
        // Floats have 24 bits and doubles 53; both bounds have room for a few roundings more than there are.
        let reach = unit(bottom.abs().max(top.abs())) + 1.0;
        let spread = slope_x.abs() * (from_x.abs() + nx as f64) + slope_y.abs() * (from_y.abs() + ny as f64);
        let flat = a == 0.0 && b == 0.0 && reach < 32768.0;
        let margin = if wide || flat { 0.0 } else { (reach * 2f64.powi(-21) + spread * 2f64.powi(-48)) as f32 };
        let side = |a: (i64, i64, i64), b: (i64, i64, i64)| Side { x: a.0, y: a.1, dx: b.0 - a.0, dy: b.1 - a.1 };
        // The z component of the normal is positive where the solid is left, going up.
        let leaves = u64::from((area > 0.0) != odd);
        Some(Self {
            rows,
            long: side(corners[0], corners[2]),
            short: [side(corners[0], corners[1]), side(corners[1], corners[2])],
            long_left: area > 0.0,
            wide,
            heights: [z0, z1, z2],
            plane: [base, slope_x, slope_y],
            margin,
            range: range.map(|step| step as f64),
            leaves,
        })
    }

    /// The first voxel whose centre is not below the facet in the column (x, y), by integers alone.
    #[cold]
    fn step(&self, x: i64, y: i64) -> u32 {
        let wide = |value: i64| i128::from(value);
        let (long, short) = (&self.long, &self.short[0]);
        let [z0, up1, up2] = [self.heights[0], self.heights[1] - self.heights[0], self.heights[2] - self.heights[0]];
        let area = wide(short.dx * long.dy - long.dx * short.dy);
        let along_x = wide(up1 * long.dy - up2 * short.dy) * wide(SUB * x + HALF - long.x);
        let along_y = wide(up2 * short.dx - up1 * long.dx) * wide(SUB * y + HALF - long.y);
        let above = wide(z0 - HALF) * area + along_x + along_y;
        let (above, area) = if area < 0 { (-above, -area) } else { (above, area) };
        let step = -(-above).div_euclid(wide(SUB) * area);
        step.clamp(self.range[0] as i128, self.range[1] as i128) as u32
    }

    /// The rows below `ny` that it covers: the first and the one after the last.
    pub fn row_range(&self, ny: u32) -> [u32; 2] {
        let ny = i64::from(ny);
        [self.rows[0].clamp(0, ny) as u32, self.rows[2].clamp(0, ny) as u32]
    }
}

/// Walks the first column whose centre is at or right of a side, row by row, as floor(m / den) with exact integers.
struct Walk {
    column: i64,
    rest: i64,
    step: i64,
    rest_step: i64,
    den: i64,
}

impl Walk {
    #[inline(always)]
    fn new(side: &Side, row: i64, wide: bool) -> Self {
        let den = SUB * side.dy;
        let up = SUB * row + HALF - side.y;
        let (column, rest) = if wide {
            let m = i128::from(side.x - HALF) * i128::from(side.dy)
                + i128::from(up) * i128::from(side.dx)
                + i128::from(den)
                - 1;
            (m.div_euclid(i128::from(den)) as i64, m.rem_euclid(i128::from(den)) as i64)
        } else {
            floor_division((side.x - HALF) * side.dy + up * side.dx + den - 1, den)
        };
        let (step, rest_step) = floor_division(side.dx, side.dy);
        Self { column, rest, step, rest_step: rest_step * SUB, den }
    }

    #[inline(always)]
    fn advance(&mut self) {
        let rest = self.rest + self.rest_step;
        // Without a branch, which would be guessed wrong every other time.
        let over = i64::from(rest >= self.den);
        self.rest = rest - (self.den & -over);
        self.column += self.step + over;
    }
}

#[inline(always)]
fn floor_division(a: i64, b: i64) -> (i64, i64) {
    let (q, r) = (a / b, a % b);
    if r < 0 { (q - 1, r + b) } else { (q, r) }
}

/// Rows of columns that are filled together, see [`crate::geometry::voxel::Voxels`].
#[derive(Debug)]
pub struct Slab<'a> {
    /// The ends of every column.
    pub spans: &'a mut [u32],
    /// The bits of columns of several pieces.
    pub words: &'a mut [u64],
    /// The crossings of every column, and [`PADDING`] more.
    pub records: &'a mut [u32],
    /// The heights of the lowest and the highest crossings, see [`crate::geometry::voxel::Columns`].
    pub heights: &'a mut [u32],
    /// Lowest solid voxel and the one after the highest, of every few columns of all rows.
    pub cells: &'a mut [[u16; 2]],
}

/// Heights of a row of `nx` columns: those of the lowest crossings, then those of the highest.
#[inline(always)]
pub(crate) const fn height_stride(nx: usize) -> usize {
    nx + PADDING
}

/// Records after those of a slab's columns, and heights after those of a row, so that vectors may reach beyond the last.
pub const PADDING: usize = 16;

/// The record of a column whose crossings are in the list.
const LISTED: u32 = u32::MAX;

dispatch_simd! {
    /// Fills the slab of rows that starts at row `first` from the facets that `list` names.
    pub fn fill = fill_body(facets: &[Facet], list: &[u32], shape: Shape, first: u32, slab: &mut Slab<'_>)
}

#[inline(always)]
fn fill_body<A: Lanes>(v: A, facets: &[Facet], list: &[u32], shape: Shape, first: u32, slab: &mut Slab<'_>) {
    slab.heights.fill(NO_HEIGHT);
    if list.is_empty() {
        slab.spans.fill(0);
        return;
    }
    slab.records.fill(0);
    let nx = shape.nx as usize;
    let rows = slab.spans.len() / nx;
    let mut listed = LISTS.take();
    listed.clear();
    for facet in list {
        convert(v, &facets[*facet as usize], shape, [i64::from(first), rows as i64], slab, &mut listed);
    }
    listed.sort_unstable();
    let spans = slab.spans.chunks_mut(nx).zip(slab.words.chunks_mut(nx * shape.words as usize));
    let rows = spans.zip(slab.records.chunks(nx)).zip(slab.heights.chunks_mut(2 * height_stride(nx)));
    for (row, (((spans, words), records), heights)) in rows.enumerate() {
        resolve(shape, row * nx, spans, words, records, &listed, slab.cells);
        settle_heights(spans, words, heights, shape.words as usize);
    }
    LISTS.set(listed);
}

thread_local! {
    /// Room for the crossings of columns that have several, by column, and for those of one of them.
    static LISTS: Cell<Vec<(u32, u16)>> = const { Cell::new(Vec::new()) };
    static CROSSINGS: Cell<Vec<u16>> = const { Cell::new(Vec::new()) };
}

/// Notes the crossings of one facet with the columns of the slab.
#[inline(always)]
fn convert<A: Lanes>(
    v: A,
    facet: &Facet,
    shape: Shape,
    [first, rows]: [i64; 2],
    slab: &mut Slab<'_>,
    listed: &mut Vec<(u32, u16)>,
) {
    let nx = shape.nx as usize;
    let stride = height_stride(nx);
    let start = facet.rows[0].max(first);
    let end = facet.rows[2].min(first + rows);
    if start >= end {
        return;
    }
    let turn = facet.rows[1].clamp(start, end);
    let mut long = Walk::new(&facet.long, start, facet.wide);
    let [base, slope_x, slope_y] = facet.plane;
    for (side, from, to) in [(0, start, turn), (1, turn, end)] {
        if from >= to {
            continue;
        }
        let mut short = Walk::new(&facet.short[side], from, facet.wide);
        for row in from..to {
            let (left, right) = if facet.long_left { (&long, &short) } else { (&short, &long) };
            let left = left.column.clamp(0, nx as i64) as usize;
            let right = right.column.clamp(0, nx as i64) as usize;
            if left < right {
                let own = (row - first) as usize;
                let z = base + slope_y * row as f64 + slope_x * left as f64 - 0.5;
                note(v, slab.records, own * nx + left, right - left, z as f32, facet, [left as i64, row], listed);
                let heights = &mut slab.heights[2 * own * stride..2 * (own + 1) * stride];
                note_heights(v, heights, [left, right], z, slope_x, shape.nz);
            }
            long.advance();
            short.advance();
        }
    }
}

/// Notes the crossings of `count` columns from the one at `at`, which is `column` and where the facet is at `z`.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn note<A: Lanes>(
    v: A,
    records: &mut [u32],
    at: usize,
    count: usize,
    z: f32,
    facet: &Facet,
    [x, y]: [i64; 2],
    listed: &mut Vec<(u32, u16)>,
) {
    const LANES: [u32; PADDING] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
    let (none, unit) = (v.isplat(0), v.isplat(1));
    let lanes = v.iload(&LANES);
    let (low, high) = (v.splat(facet.range[0] as f32), v.splat(facet.range[1] as f32));
    let slope = v.splat(facet.plane[1] as f32);
    let margin = v.splat(facet.margin);
    let direction = v.isplat(facet.leaves as i32 + 1);
    for from in (0..count).step_by(A::WIDTH) {
        let here = &mut records[at + from..];
        let column = v.float(v.iadd(lanes, v.isplat(from as i32)));
        let place = v.fused(slope, column, v.splat(z));
        let least = v.min(v.max(v.sub(place, margin), low), high);
        let most = v.min(v.max(v.add(place, margin), low), high);
        let whole = v.trunc(least);
        let mut step = v.iadd(whole, v.iselect(v.lt(v.float(whole), least), unit, none));
        let inside = v.ilt(lanes, v.isplat((count - from) as i32));
        // Where rounding could decide, the steps below and above differ.
        let sure = v.le(most, v.float(step));
        let unsure = v.mask(v.without(inside, sure));
        if unsure != 0 {
            let mut steps = [0; PADDING];
            v.istore(step, &mut steps);
            for lane in (0..A::WIDTH).filter(|lane| unsure >> lane & 1 != 0) {
                steps[lane] = facet.step(x + (from + lane) as i64, y);
            }
            step = v.iload(&steps);
        }
        let mark = v.iadd(v.iadd(step, step), direction);
        let record = v.iload(here);
        let full = v.without(inside, v.ieq(v.high(record), none));
        let put = v.without(inside, full);
        v.istore(v.iselect(put, v.iadd(v.raised(record), mark), record), here);
        if v.mask(full) != 0 {
            let mut marks = [0; PADDING];
            v.istore(mark, &mut marks);
            note_listed(here, at + from, v.mask(full), &marks, listed);
        }
    }
}

/// Notes the heights of the crossings of columns `from` to `to` of a row with a plane that is at `z` over the centre of the
/// first. Heights count from the centre of the lowest voxel and are held near the grid; those of highest crossings are
/// negated, so that of both the least stays.
#[inline(always)]
fn note_heights<A: Lanes>(v: A, heights: &mut [u32], [from, to]: [usize; 2], z: f64, slope: f64, nz: u32) {
    const LANES: [u32; PADDING] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
    let (lanes, none) = (v.iload(&LANES), v.isplat(0));
    let (steps, unit) = (v.splat(slope as f32), v.splat(FINE as f32));
    let (lows, highs) = heights.split_at_mut(heights.len() / 2);
    // From the lowest place of the columns on: what is above it is not negative.
    let dip = (slope * (TOGETHER - 1) as f64).min(0.0);
    for first in (from..to).step_by(TOGETHER) {
        let here = z + slope * (first - from) as f64;
        let base = (here + dip).floor().clamp(-2.0, f64::from(nz + 1));
        let rest = v.splat((here - base) as f32);
        let (low, high) = (v.splat((-2.0 - base) as f32), v.splat((f64::from(nz + 1) - base) as f32));
        let base = v.isplat(base as i32 * FINE);
        for at in (first..to.min(first + TOGETHER)).step_by(A::WIDTH) {
            let lane = v.iadd(lanes, v.isplat((at - first) as i32));
            let above = v.min(v.max(v.fused(steps, v.float(lane), rest), low), high);
            let height = v.iadd(base, v.trunc(v.mul(above, unit)));
            let inside = v.ilt(lanes, v.isplat((to - at) as i32));
            let (lows, highs) = (&mut lows[at..], &mut highs[at..]);
            let (old_low, old_high) = (v.iload(lows), v.iload(highs));
            v.istore(v.iselect(inside, v.imin(old_low, height), old_low), lows);
            v.istore(v.iselect(inside, v.imin(old_high, v.isub(none, height)), old_high), highs);
        }
    }
}

/// Notes crossings of the columns whose bits are set and whose records are full.
#[cold]
fn note_listed(records: &mut [u32], at: usize, columns: u32, marks: &[u32], listed: &mut Vec<(u32, u16)>) {
    for lane in (0..marks.len()).filter(|lane| columns >> lane & 1 != 0) {
        let index = (at + lane) as u32;
        if records[lane] != LISTED {
            listed.push((index, records[lane] as u16));
            listed.push((index, (records[lane] >> 16) as u16));
            records[lane] = LISTED;
        }
        listed.push((index, marks[lane] as u16));
    }
}

/// Writes the columns of one row. `at` is the index of its first column in the slab, as `listed` counts.
#[inline(always)]
fn resolve(
    shape: Shape,
    at: usize,
    spans: &mut [u32],
    words: &mut [u64],
    records: &[u32],
    listed: &[(u32, u16)],
    cells: &mut [[u16; 2]],
) {
    let any = records.iter().fold(0, |any, record| any | record);
    if any == 0 {
        spans.fill(0);
        return;
    }
    // Most columns are one span: between two crossings of opposite direction, or from one crossing to the far end.
    // All in masks, so that columns are resolved side by side.
    let mask = |condition: bool| 0u32.wrapping_sub(u32::from(condition));
    let select = |mask: u32, a: u32, b: u32| a & mask | b & !mask;
    let (open, backward) = (mask(shape.open), mask(shape.backward));
    let mut left_over = 0;
    for (record, span) in records.iter().zip(spans.iter_mut()) {
        let (first, second) = ((record & 0xffff).wrapping_sub(1), (record >> 16).wrapping_sub(1));
        let (a, b) = (first >> 1, second >> 1);
        let leaves = 0u32.wrapping_sub(first & 1);
        let some = mask(*record != 0);
        let one = mask(*record >> 16 == 0);
        // On an open mesh a single crossing says by its direction which side is solid.
        let below = select(open, leaves, backward);
        let from = select(one, a & !below, a.min(b));
        let to = select(one, select(below, a, shape.nz), a.max(b));
        // Between two crossings an open mesh is solid if the lower one enters. Listed ones seem to be of one direction.
        let entered = !open | (mask(a < b) ^ leaves) & mask(a != b);
        let two = 0u32.wrapping_sub((first ^ second) & 1) & entered;
        let simple = some & (one | two);
        *span = (from | to << 16) & simple & mask(from < to);
        left_over |= some & !simple;
    }
    if left_over != 0 {
        for column in 0..records.len() {
            if records[column] == 0 || spans[column] != 0 {
                continue;
            }
            let bits = &mut words[column * shape.words as usize..(column + 1) * shape.words as usize];
            spans[column] = resolve_several(shape, (at + column) as u32, records[column], listed, bits);
        }
    }
    for ((cell, spans), words) in
        cells.iter_mut().zip(spans.chunks(CELL as usize)).zip(words.chunks((CELL * shape.words) as usize))
    {
        let (mut least, mut most) = (u32::MAX, 0);
        let mut pieces = false;
        for span in spans {
            least = least.min(if *span == 0 { u32::MAX } else { span & 0xffff });
            most = most.max(span >> 16);
            pieces |= *span == PIECES;
        }
        if pieces {
            for (span, bits) in spans.iter().zip(words.chunks(shape.words as usize)) {
                if *span == PIECES {
                    let [low, high] = ends(bits);
                    (least, most) = (least.min(low), most.max(high));
                }
            }
        }
        if least < most {
            *cell = [cell[0].min(least as u16), cell[1].max(most as u16)];
        }
    }
}

/// Leaves of the heights of a row the ends of its columns' solids. Crossings that are rounded to another place are no ends:
/// of slivers between two centres, of shells inside others, and of what is solid beyond the grid.
#[inline(always)]
fn settle_heights(spans: &[u32], words: &[u64], heights: &mut [u32], stride: usize) {
    let (lows, highs) = heights.split_at_mut(heights.len() / 2);
    let mut pieces = false;
    for ((span, low), high) in spans.iter().zip(&mut *lows).zip(&mut *highs) {
        pieces |= *span == PIECES;
        let (from, to) = if *span == PIECES { (0, 0) } else { (span & 0xffff, span >> 16) };
        let (noted_low, noted_high) = (settled(*low, from, to, 1), settled(*high, to, to, -1));
        *low = if *span == PIECES { *low } else { noted_low };
        *high = if *span == PIECES { *high } else { noted_high };
    }
    if pieces {
        for (column, bits) in words.chunks(stride).enumerate().filter(|(column, _)| spans[*column] == PIECES) {
            let [from, to] = ends(bits);
            lows[column] = settled(lows[column], from, to, 1);
            highs[column] = settled(highs[column], to, to, -1);
        }
    }
}

/// The height that is noted of a column that is solid up to voxel `to`, or of a clear one with 0, if it is rounded up to
/// `end`. Heights of upper ends are negated, as `sign` says.
#[inline(always)]
fn settled(noted: u32, end: u32, to: u32, sign: i32) -> u32 {
    let rest = FINE * end as i32 - sign * noted as i32;
    let near = (rest + HEIGHT_SLACK) as u32 <= (FINE + 2 * HEIGHT_SLACK) as u32;
    if near & (to != 0) { noted } else { NO_HEIGHT }
}

/// Resolves a column whose crossings do not show at once what is solid: returns its ends, or writes its bits.
fn resolve_several(shape: Shape, index: u32, record: u32, listed: &[(u32, u16)], bits: &mut [u64]) -> u32 {
    let mut crossings = CROSSINGS.take();
    crossings.clear();
    if record == LISTED {
        let from = listed.partition_point(|(other, _)| *other < index);
        crossings.extend(listed[from..].iter().take_while(|(other, _)| *other == index).map(|(_, mark)| *mark));
    } else {
        crossings.extend([record as u16, (record >> 16) as u16].into_iter().filter(|mark| *mark != 0));
    }
    crossings.sort_unstable();
    bits.fill(0);
    let mut pieces: Option<[u64; 2]> = None;
    let mut one = true;
    for_each_span(shape, &crossings, |low, high| {
        // Spans that touch are one.
        match &mut pieces {
            Some([_, end]) if *end == low => *end = high,
            Some(_) => one = false,
            None => pieces = Some([low, high]),
        }
        for (word, bits) in bits.iter_mut().enumerate() {
            let base = word as u64 * 64;
            *bits |= below(high.saturating_sub(base)) & !below(low.saturating_sub(base));
        }
    });
    CROSSINGS.set(crossings);
    match pieces {
        Some([low, high]) if one => (low | high << 16) as u32,
        Some(_) => PIECES,
        None => 0,
    }
}

/// The lowest solid voxel of a column that has some, and the one after the highest.
fn ends(bits: &[u64]) -> [u32; 2] {
    let first = bits.iter().position(|word| *word != 0).unwrap_or(0);
    let last = bits.iter().rposition(|word| *word != 0).unwrap_or(0);
    [first as u32 * 64 + bits[first].trailing_zeros(), last as u32 * 64 + 64 - bits[last].leading_zeros()]
}

/// The lowest `count` bits, all for 64 and more.
#[inline(always)]
fn below(count: u64) -> u64 {
    let count = count.min(64);
    ((1 << (count & 63)) - 1) | 0u64.wrapping_sub(count >> 6)
}

/// Calls `span` for the stretches of a column where the winding number is not zero. `crossings` are sorted.
fn for_each_span(shape: Shape, crossings: &[u16], mut span: impl FnMut(u64, u64)) {
    let place = |mark: u16| u64::from(mark - 1) >> 1;
    let turn = |mark: u16| if (mark - 1) & 1 == 0 { 1 } else { -1 };
    let total: i64 = crossings.iter().map(|mark| turn(*mark)).sum();
    let mut winding = if shape.open {
        // The least winding number along the column is outside.
        let mut sum = 0;
        let mut least = 0;
        let mut index = 0;
        while index < crossings.len() {
            let here = place(crossings[index]);
            while index < crossings.len() && place(crossings[index]) == here {
                sum += turn(crossings[index]);
                index += 1;
            }
            least = least.min(sum);
        }
        -least
    } else if shape.backward {
        -total
    } else {
        0
    };
    let mut from = 0;
    for mark in crossings {
        if winding != 0 && place(*mark) > from {
            span(from, place(*mark));
        }
        winding += turn(*mark);
        from = place(*mark);
    }
    if winding != 0 && from < u64::from(shape.nz) {
        span(from, u64::from(shape.nz));
    }
}
