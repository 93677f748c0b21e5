//! The fluid around points: its particles in cells as wide as the support radius.

use glam::{Vec3, Vec4, Vec4Swizzles};
use relievo_core::{Context, Result};

use super::options::DiffuseOptions;
use crate::cells::Cells;

/// The particles of a fluid in the order of their cells.
#[derive(Debug)]
pub struct Surroundings {
    cells: Cells,
    support: f32,
    /// Positions and velocities in the order of cells.
    pub places: Vec<Vec3>,
    pub velocities: Vec<Vec3>,
}

impl Surroundings {
    /// Puts particles into cells. Fails for positions that are not finite or too far from each other.
    pub fn new(context: &Context, options: &DiffuseOptions, points: &[Vec4], velocities: &[Vec3]) -> Result<Self> {
        let mut cells = Cells::default();
        cells.fill(context, options.support(), points)?;
        let order: Vec<u32> = cells.order().collect();
        let places = context.map(order.len(), |at| points[order[at] as usize].xyz());
        let velocities = context.map(order.len(), |at| velocities[order[at] as usize]);
        Ok(Self { cells, support: options.support(), places, velocities })
    }

    /// Returns the numbers that the particles had before they were put into cells, in the order of cells.
    pub fn order(&self) -> impl Iterator<Item = u32> + '_ {
        self.cells.order()
    }

    /// Calls `visit` with each particle nearer to a point than the support radius: its number in the order of cells, the
    /// vector from it to the point, the length of that, and the length as a share of the support radius.
    #[inline]
    pub fn around(&self, point: Vec3, mut visit: impl FnMut(usize, Vec3, f32, f32)) {
        let (inverse, square) = (self.support.recip(), self.support * self.support);
        for range in self.cells.around(self.cells.cell(point)) {
            for number in range {
                let from = point - self.places[number];
                let distance = from.length_squared();
                if distance < square {
                    let distance = distance.sqrt();
                    visit(number, from, distance, distance * inverse);
                }
            }
        }
    }
}
