//! Particles in the order of cells along a z-curve (Morton 1966), and where the particles of a cell are.
//!
//! Cells have the side of the support radius, so that what is near a particle lies in 27 of them (Ihmsen et al. 2011).
//! Only cells with particles take memory.

use std::ops::Range;

use glam::{IVec3, Vec3, Vec4, Vec4Swizzles};
use relievo_core::{Context, Error, Result};

use crate::solver::radix::{Keyed, sort};

/// Cells along an axis at most.
const MAX: i32 = 1 << 20;
/// Particles of a task.
const CHUNK_LEN: usize = 8192;

/// Occupied cells.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    /// Cells per unit of length.
    scale: f32,
    /// The cell before the first one of each axis, and how many there are up to the one after the last.
    low: IVec3,
    size: IVec3,
    /// Where the cells' particles begin, and at the end how many there are.
    starts: Vec<u32>,
    keys: Vec<u64>,
    /// Cells at places that follow from their keys, or the next free ones; 0 is none, else one more than the cell.
    slots: Vec<u32>,
    /// Room of the sort.
    keyed: [Vec<Keyed>; 2],
}

impl Cells {
    /// Puts points into cells of a side. What they were before stays where it fails: for points that are not finite, or
    /// more than 2²⁰ cells apart.
    pub fn fill(&mut self, context: &Context, side: f32, points: &[Vec4]) -> Result<()> {
        self.cover(side, bounds(context, points)?)?;
        self.sort(context, points);
        Ok(())
    }

    /// Lays a lattice of cells of a side over a box, or over the origin. The cells before stay where it fails: if the box is
    /// more than 2²⁰ cells wide.
    pub fn cover(&mut self, side: f32, bounds: Option<(Vec3, Vec3)>) -> Result<()> {
        let scale = side.recip();
        let (low, high) = bounds.unwrap_or_default();
        let (low, high) = ((low * scale).floor(), (high * scale).floor());
        if (high - low).max_element() > (MAX - 3) as f32 || low.abs().max(high.abs()).max_element() > (1 << 24) as f32 {
            return Err(Error::invalid(
                "particles are too far from each other or from the origin for their support radius",
            )
            .advise("let a sink take those that leave the scene"));
        }
        self.scale = scale;
        self.low = low.as_ivec3() - 1;
        self.size = high.as_ivec3() - self.low + 2;
        Ok(())
    }

    /// Puts points, which lie in the box that is covered, into the cells.
    pub fn sort(&mut self, context: &Context, points: &[Vec4]) {
        let [mut keyed, mut sorted] = std::mem::take(&mut self.keyed);
        keyed.resize(points.len(), (0, 0));
        let mut parts: Vec<_> = keyed.chunks_mut(CHUNK_LEN).collect();
        context.for_each_mut(&mut parts, |part, keyed| {
            let numbers = part * CHUNK_LEN..;
            for (keyed, number) in keyed.iter_mut().zip(numbers) {
                *keyed = (self.key(self.cell(points[number].xyz())), number as u32);
            }
        });
        let bits = 3 * (self.size.max_element() as u32).ilog2() + 3;
        sort(&mut keyed, &mut sorted, bits);
        self.keyed = [keyed, sorted];
        self.index();
    }

    /// The order of the points: the number that each had.
    pub fn order(&self) -> impl ExactSizeIterator<Item = u32> + Clone {
        self.keyed[0].iter().map(|(_, number)| *number)
    }

    /// The cell that a point is in.
    #[inline(always)]
    pub fn cell(&self, point: Vec3) -> IVec3 {
        (point * self.scale).floor().as_ivec3()
    }

    /// The particles in the cells around one and in itself, in the order of the cells' coordinates.
    pub fn around(&self, cell: IVec3) -> impl Iterator<Item = Range<usize>> {
        let first = cell - self.low - 1;
        let is_near = first.cmpge(IVec3::splat(-2)).all() && first.cmplt(self.size).all();
        let axis = move |first: i32, size: i32, shift: u32| {
            std::array::from_fn::<_, 3, _>(|step| {
                let at = first + step as i32;
                (0..size).contains(&at).then(|| spread(at as u32) << shift)
            })
        };
        let [xs, ys, zs] =
            [axis(first.x, self.size.x, 0), axis(first.y, self.size.y, 1), axis(first.z, self.size.z, 2)];
        let keys = zs.into_iter().flatten().flat_map(move |z| {
            ys.into_iter().flatten().flat_map(move |y| xs.into_iter().flatten().map(move |x| x | y | z))
        });
        keys.filter(move |_| is_near).filter_map(|key| self.find(key))
    }

    /// The place of a cell along the curve. Those around cells with points have one too.
    pub fn key(&self, cell: IVec3) -> u64 {
        let [x, y, z] = (cell - self.low).to_array().map(|at| spread(at as u32));
        x | y << 1 | z << 2
    }

    /// Finds the cells' first particles, and makes the table that leads to them.
    fn index(&mut self) {
        self.keys.clear();
        self.starts.clear();
        let mut last = u64::MAX;
        for (at, (key, _)) in self.keyed[0].iter().enumerate() {
            if *key != last {
                self.keys.push(*key);
                self.starts.push(at as u32);
                last = *key;
            }
        }
        self.starts.push(self.keyed[0].len() as u32);
        self.slots.clear();
        self.slots.resize((2 * self.keys.len()).next_power_of_two().max(2), 0);
        let mask = self.slots.len() - 1;
        for (cell, key) in (1..).zip(&self.keys) {
            let mut at = self.home(*key);
            while self.slots[at] != 0 {
                at = (at + 1) & mask;
            }
            self.slots[at] = cell;
        }
    }

    /// The place in the table at which the search for a cell begins.
    #[inline(always)]
    fn home(&self, key: u64) -> usize {
        (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & (self.slots.len() - 1)
    }

    #[inline(always)]
    fn find(&self, key: u64) -> Option<Range<usize>> {
        let mask = self.slots.len().wrapping_sub(1);
        let mut at = self.home(key);
        loop {
            let cell = (self.slots[at] as usize).checked_sub(1)?;
            if self.keys[cell] == key {
                return Some(self.starts[cell] as usize..self.starts[cell + 1] as usize);
            }
            at = (at + 1) & mask;
        }
    }
}

/// The box around points, if there are any. Fails if one is not finite.
pub fn bounds(context: &Context, points: &[Vec4]) -> Result<Option<(Vec3, Vec3)>> {
    let bounds = context.map(points.len().div_ceil(CHUNK_LEN), |part| {
        let points = &points[part * CHUNK_LEN..points.len().min((part + 1) * CHUNK_LEN)];
        let is_finite = points.iter().fold(true, |all, point| all & point.is_finite());
        let low = points.iter().fold(Vec3::MAX, |low, point| low.min(point.xyz()));
        let high = points.iter().fold(Vec3::MIN, |high, point| high.max(point.xyz()));
        is_finite.then_some((low, high))
    });
    let mut all = (Vec3::MAX, Vec3::MIN);
    for bounds in bounds {
        let (low, high) = bounds.ok_or_else(|| Error::invalid("a particle's position is not finite"))?;
        all = (all.0.min(low), all.1.max(high));
    }
    Ok((!points.is_empty()).then_some(all))
}

/// The bits of a number below 2²¹, each followed by two zeros.
#[inline(always)]
fn spread(number: u32) -> u64 {
    let number = u64::from(number);
    let number = (number | number << 32) & 0x001f_0000_0000_ffff;
    let number = (number | number << 16) & 0x001f_0000_ff00_00ff;
    let number = (number | number << 8) & 0x100f_00f0_0f00_f00f;
    let number = (number | number << 4) & 0x10c3_0c30_c30c_30c3;
    (number | number << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_that_is_near_is_in_the_cells_around() {
        let points: Vec<Vec4> = (0..3000u32)
            .map(|i| {
                let at = |k: u32| (i.wrapping_mul(k) >> 8) as f32 / (1 << 24) as f32 * 4.0 - 2.0;
                Vec4::new(at(0x9e37_79b1), at(0x85eb_ca77), at(0xc2b2_ae3d), 0.0)
            })
            .collect();
        let mut cells = Cells::default();
        cells.fill(&Context::serial(), 0.5, &points).unwrap();
        let order: Vec<usize> = cells.order().map(|number| number as usize).collect();
        let mut seen = order.clone();
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..points.len()));
        for point in points.iter().step_by(97).chain([&Vec4::splat(2.3), &Vec4::splat(-70.0)]) {
            let mut near: Vec<usize> =
                cells.around(cells.cell(point.xyz())).flatten().map(|place| order[place]).collect();
            near.retain(|other| points[*other].xyz().distance(point.xyz()) < 0.5);
            near.sort_unstable();
            let all = (0..points.len()).filter(|other| points[*other].xyz().distance(point.xyz()) < 0.5);
            assert!(near.into_iter().eq(all));
        }
    }

    #[test]
    fn points_that_no_cell_can_hold_are_refused() {
        let context = Context::serial();
        let fill = |points: &[Vec4]| Cells::default().fill(&context, 0.01, points);
        assert!(fill(&[]).is_ok());
        assert!(fill(&[Vec4::ZERO; 3]).is_ok());
        assert!(fill(&[Vec4::ZERO, Vec4::new(f32::NAN, 0.0, 0.0, 0.0)]).is_err());
        assert!(fill(&[Vec4::ZERO, Vec4::new(1e6, 0.0, 0.0, 0.0)]).is_err());
    }
}
