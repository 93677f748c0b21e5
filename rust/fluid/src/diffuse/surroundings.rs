//! The fluid around points: its particles in rows of cells as wide as the support radius.

use std::ops::Range;

use glam::Vec3;
use relievo_core::lanes::Lanes;
use relievo_core::simd::Level;
use relievo_core::{Context, Result};

use super::CHUNK_LEN;
use super::options::DiffuseOptions;
use crate::solver::pairs::Vectors;
use crate::solver::radix::sort;
use crate::surface::profile::{LANES, WIDEST};
use crate::surface::rows::{Cell, Rows};

/// The width of a cell in support radii, so that rounding hides no neighbour.
const CELL: f32 = 1.0001;

/// The particles of a fluid in the order of their cells.
#[derive(Debug)]
pub struct Surroundings {
    rows: Rows,
    order: Vec<u32>,
    pub support: f32,
    pub level: Level,
    /// Coordinates of positions and velocities in the order of cells, and at the end numbers of no particle, for lanes.
    pub places: [Vec<f32>; 3],
    pub velocities: [Vec<f32>; 3],
}

impl Surroundings {
    /// Puts particles into cells. Fails for positions that are not finite or too far from each other.
    pub fn new(context: &Context, options: &DiffuseOptions, points: &[Vec3], velocities: &[Vec3]) -> Result<Self> {
        let support = options.support();
        let (rows, order) = Rows::new(context, bytemuck::cast_slice(points), CELL * support)?;
        let places = columns(order.iter().map(|at| points[*at as usize]));
        let velocities = columns(order.iter().map(|at| velocities[*at as usize]));
        Ok(Self { rows, order, support, level: context.level(), places, velocities })
    }

    /// Returns the number of particles.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Returns the numbers that the particles had before they were put into cells, in the order of cells.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Returns the position of a particle, by its number in the order of cells.
    pub fn place(&self, number: usize) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|axis| self.places[axis][number]))
    }

    /// Returns the velocity of a particle, by its number in the order of cells.
    pub fn velocity(&self, number: usize) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|axis| self.velocities[axis][number]))
    }

    /// Calls `work` for the particles of ranges, as many as there are lanes at a time: with the number of the first, the
    /// vectors from them to a point, their squared lengths, and which lanes hold a particle of the range.
    #[inline(always)]
    pub fn around<A: Lanes>(
        &self,
        v: A,
        point: Vec3,
        ranges: &[Range<usize>],
        mut work: impl FnMut(usize, Vectors<A>, A::F, A::M),
    ) {
        let (lanes, point) = (v.load(&LANES), Vectors::splat(v, point.extend(0.0)));
        for range in ranges {
            for first in range.clone().step_by(A::WIDTH) {
                let from = point.minus(v, Vectors::load(v, &self.places, first));
                let left = v.splat((range.end - first).min(WIDEST) as f32);
                work(first, from, from.dot(v, from), v.lt(lanes, left));
            }
        }
    }

    /// Returns the numbers of points in the order of the cells that they are in, so that neighbours follow each other.
    pub fn sorted(&self, context: &Context, points: &[Vec3]) -> Vec<u32> {
        let mut keyed = vec![(0, 0); points.len()];
        let done = context.for_each_part((points, keyed.as_mut_slice()), CHUNK_LEN, |first, (points, keyed)| {
            for (at, (point, keyed)) in points.iter().zip(keyed).enumerate() {
                *keyed = (self.rows.key_around(self.rows.cell(point.to_array())), (first + at) as u32);
            }
            Ok(())
        });
        // The work above has no error.
        debug_assert!(done.is_ok());
        sort(&mut keyed, &mut Vec::new(), self.rows.key_bits());
        keyed.into_iter().map(|(_, number)| number).collect()
    }

    /// Returns where to look for what is around points, one after the other.
    pub fn seeker(&self) -> Seeker<'_> {
        Seeker { rows: &self.rows, cell: None, ranges: Vec::new() }
    }
}

/// Where to look for what is around a point. It is fast where points follow each other that are in the same cell.
#[derive(Debug)]
pub struct Seeker<'a> {
    rows: &'a Rows,
    cell: Option<Cell>,
    ranges: Vec<Range<usize>>,
}

impl Seeker<'_> {
    /// Returns the particles in the cell of a point and in those around it, as ranges of the order of cells.
    #[inline(always)]
    pub fn around(&mut self, point: Vec3) -> &[Range<usize>] {
        let cell = self.rows.cell(point.to_array());
        if self.cell != Some(cell) {
            let [low, high] = [-1, 1].map(|step| cell.map(|at| at.saturating_add(step)));
            self.rows.ranges(low, high, &mut self.ranges);
            self.cell = Some(cell);
        }
        &self.ranges
    }
}

/// Returns the coordinates of vectors as lists, with as many zeros at the end as the widest level has lanes.
pub fn columns(vectors: impl ExactSizeIterator<Item = Vec3>) -> [Vec<f32>; 3] {
    let mut columns = [(); 3].map(|()| Vec::with_capacity(vectors.len() + WIDEST));
    for vector in vectors {
        for (column, value) in columns.iter_mut().zip(vector.to_array()) {
            column.push(value);
        }
    }
    columns.map(|mut column| {
        column.extend([0.0; WIDEST]);
        column
    })
}
