//! Particles sorted into the cells of a grid, row after row along x, so that what is near is in a few ranges of a list.
//! Only cells with particles are stored, so memory grows with the particles and not with the box.

use std::ops::Range;

use relievo_core::{Context, Error, Result};

use crate::solver::radix::sort;

/// Cells of an axis at most: three such numbers are one key.
const MAX: f64 = 1_048_576.0;
/// Particles of one task.
const CHUNK_LEN: usize = 16_384;

/// The cells, sorted by z, then y, then x.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    low: [f64; 3],
    inverse: f64,
    /// Cells of each axis.
    size: [i64; 3],
    /// Cells that have particles, as (z · size y + y) · size x + x.
    keys: Vec<u64>,
    /// The first particle of each of these cells, and how many particles there are.
    starts: Vec<u32>,
}

/// A cell's coordinates.
pub(crate) type Cell = [i64; 3];

impl Rows {
    /// Cells whose edges are `edge` long, and the particles in their order; those of a cell are in that of the list.
    /// Fails if a position is not finite, if there are 2³² of them, or if they are more than 1,048,576 cells apart.
    pub fn new(context: &Context, points: &[[f32; 3]], edge: f32) -> Result<(Self, Vec<u32>)> {
        let count = points.len();
        if u32::try_from(count).is_err() {
            return Err(Error::invalid(format!("there are {count} particles")).advise("use less than 2^32"));
        }
        let parts: Vec<&[[f32; 3]]> = points.chunks(CHUNK_LEN).collect();
        let bounds = context.map(parts.len(), |part| {
            let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
            for (at, point) in parts[part].iter().enumerate() {
                if !point.iter().all(|value| value.is_finite()) {
                    return Err(Error::invalid("a coordinate is not a finite number")
                        .at(format!("particle {}", part * CHUNK_LEN + at))
                        .advise("remove the particle or repair its position"));
                }
                for axis in 0..3 {
                    bounds[0][axis] = bounds[0][axis].min(point[axis]);
                    bounds[1][axis] = bounds[1][axis].max(point[axis]);
                }
            }
            Ok(bounds)
        });
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for part in bounds {
            let [least, most] = part?;
            low = std::array::from_fn(|axis| low[axis].min(least[axis]));
            high = std::array::from_fn(|axis| high[axis].max(most[axis]));
        }
        if count == 0 {
            (low, high) = ([0.0; 3], [0.0; 3]);
        }
        let low = low.map(f64::from);
        let inverse = 1.0 / f64::from(edge);
        let mut size = [1; 3];
        for axis in 0..3 {
            let cells = (f64::from(high[axis]) - low[axis]) * inverse + 1.0;
            if cells.is_nan() || cells > MAX {
                return Err(Error::invalid(format!("particles are more than {MAX} support radii of {edge} apart"))
                    .advise("remove those that are far away, or use a larger support radius"));
            }
            size[axis] = cells as i64;
        }
        let mut rows = Self { low, inverse, size, keys: Vec::new(), starts: Vec::new() };
        let mut keyed = vec![(0u64, 0u32); count];
        context.for_each_part((points, keyed.as_mut_slice()), CHUNK_LEN, |first, (points, keyed)| {
            for (at, (point, keyed)) in points.iter().zip(keyed).enumerate() {
                *keyed = (rows.key(rows.cell(*point)), (first + at) as u32);
            }
            Ok(())
        })?;
        let bits = u64::BITS - size.iter().product::<i64>().leading_zeros();
        sort(&mut keyed, &mut Vec::new(), bits);
        for (at, (key, _)) in keyed.iter().enumerate() {
            if rows.keys.last() != Some(key) {
                rows.keys.push(*key);
                rows.starts.push(at as u32);
            }
        }
        rows.starts.push(count as u32);
        Ok((rows, keyed.into_iter().map(|(_, at)| at).collect()))
    }

    /// The cell of a place, which may lie outside of the grid.
    #[inline]
    pub fn cell(&self, point: [f32; 3]) -> Cell {
        self.cell_at(point.map(f64::from))
    }

    /// As [`Self::cell`].
    #[inline]
    pub fn cell_at(&self, point: [f64; 3]) -> Cell {
        std::array::from_fn(|axis| ((point[axis] - self.low[axis]) * self.inverse).floor() as i64)
    }

    fn key(&self, [x, y, z]: Cell) -> u64 {
        ((z * self.size[1] + y) * self.size[0] + x) as u64
    }

    /// Returns a number that orders cells as they are stored, in the grid and one cell around it. Cells further away have
    /// that of one at the rim.
    pub fn key_around(&self, cell: Cell) -> u64 {
        let [x, y, z] = std::array::from_fn(|axis| cell[axis].clamp(-1, self.size[axis]) + 1);
        ((z * (self.size[1] + 2) + y) * (self.size[0] + 2) + x) as u64
    }

    /// Returns how many bits [`Self::key_around`] has.
    pub fn key_bits(&self) -> u32 {
        u64::BITS - self.size.iter().map(|size| *size as u64 + 2).product::<u64>().leading_zeros()
    }

    /// The lowest corner of the cells, and their edge.
    pub fn lattice(&self) -> ([f64; 3], f64) {
        (self.low, 1.0 / self.inverse)
    }

    /// The number of a cell; none if it has no particles.
    pub fn find(&self, cell: Cell) -> Option<usize> {
        if (0..3).any(|axis| !(0..self.size[axis]).contains(&cell[axis])) {
            return None;
        }
        self.keys.binary_search(&self.key(cell)).ok()
    }

    /// How many cells have particles.
    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// The particles of the cell with this number.
    pub fn particles(&self, number: usize) -> Range<usize> {
        self.starts[number] as usize..self.starts[number + 1] as usize
    }

    /// The first particles of pieces of up to so many, of neighbouring cells in a row, and how many particles there are.
    pub fn pieces(&self, most: usize) -> Vec<u32> {
        let mut firsts = Vec::with_capacity(self.keys.len() + 1);
        let mut before = None;
        for cell in 0..self.len() {
            let (key, particles) = (self.keys[cell], self.particles(cell));
            let follows = before.is_some_and(|before| before + 1 == key && key % self.size[0] as u64 != 0);
            let fits = firsts.last().is_some_and(|first| particles.end - *first as usize <= most);
            if !(follows && fits) {
                firsts.extend(particles.step_by(most).map(|at| at as u32));
            }
            before = Some(key);
        }
        firsts.push(self.starts.last().copied().unwrap_or(0));
        firsts
    }

    /// The first key from a place on that is not below another: rows are near each other, so in steps that double.
    fn seek(&self, mut from: usize, key: u64) -> usize {
        let mut step = 1;
        while self.keys.get(from + step).is_some_and(|at| *at < key) {
            from += step;
            step *= 2;
        }
        let end = (from + step).min(self.keys.len());
        from + self.keys[from..end].partition_point(|at| *at < key)
    }

    /// Lists the particles of the cells from `low` to `high`, both inclusive, as ranges in rising order.
    pub fn ranges(&self, low: Cell, high: Cell, ranges: &mut Vec<Range<usize>>) {
        ranges.clear();
        let low = low.map(|at| at.max(0));
        let high: Cell = std::array::from_fn(|axis| high[axis].min(self.size[axis] - 1));
        if (0..3).any(|axis| low[axis] > high[axis]) {
            return;
        }
        let mut from = 0;
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                from = self.seek(from, self.key([low[0], y, z]));
                let last = self.key([high[0], y, z]);
                let to = from + self.keys[from..].iter().take_while(|key| **key <= last).count();
                if to > from {
                    let range = self.starts[from] as usize..self.starts[to] as usize;
                    match ranges.last_mut() {
                        Some(before) if before.end == range.start => before.end = range.end,
                        _ => ranges.push(range),
                    }
                }
                from = to;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_box_of_cells_has_the_particles_in_it(
            points in prop::collection::vec(prop::array::uniform3(-3.0f32..5.0), 0..200),
            low in prop::array::uniform3(-2i64..6), extent in prop::array::uniform3(0i64..6),
        ) {
            let (rows, order) = Rows::new(&Context::serial(), &points, 1.3).unwrap();
            let high: Cell = std::array::from_fn(|axis| low[axis] + extent[axis]);
            let mut ranges = Vec::new();
            rows.ranges(low, high, &mut ranges);
            let mut found: Vec<u32> = ranges.into_iter().flat_map(|range| order[range].to_vec()).collect();
            found.sort_unstable();
            let inside = |point: &[f32; 3]| {
                let cell = rows.cell(*point);
                (0..3).all(|axis| (low[axis]..=high[axis]).contains(&cell[axis]))
            };
            let expected: Vec<u32> = (0..points.len() as u32).filter(|at| inside(&points[*at as usize])).collect();
            prop_assert_eq!(found, expected);
            for number in 0..rows.len() {
                let cells = rows.particles(number).map(|at| rows.cell(points[order[at] as usize]));
                let cells: std::collections::BTreeSet<Cell> = cells.collect();
                prop_assert_eq!(cells.len(), 1);
            }
            let pieces = rows.pieces(4);
            prop_assert_eq!(pieces.last().copied(), Some(points.len() as u32));
            for ends in pieces.windows(2) {
                let cells: Vec<Cell> = (ends[0]..ends[1]).map(|at| rows.cell(points[order[at as usize] as usize])).collect();
                prop_assert!((1..=4).contains(&cells.len()));
                prop_assert!(cells.windows(2).all(|two| (0..2).contains(&(two[1][0] - two[0][0])) && two[0][1..] == two[1][1..]));
            }
        }
    }

    #[test]
    fn what_cannot_be_sorted_is_refused() {
        let error = Rows::new(&Context::serial(), &[[0.0; 3], [0.0, f32::NAN, 0.0]], 1.0).unwrap_err();
        assert!(error.to_string().contains("particle 1"), "{error}");
        for far in [3e6, f32::MAX] {
            let error = Rows::new(&Context::serial(), &[[0.0; 3], [far, 0.0, 0.0]], 1.0).unwrap_err();
            assert!(error.to_string().contains("apart"), "{error}");
        }
    }
}
