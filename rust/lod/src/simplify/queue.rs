//! Half-edges in the order of the magnitudes of their costs, in quarters of an octave.

/// Bits of a cost that are not its magnitude.
const FINE: u32 = 21;
/// Magnitudes.
pub const MAGNITUDES: usize = (f32::INFINITY.to_bits() >> FINE) as usize;

/// The magnitude of a cost, which is not negative.
#[inline(always)]
pub fn magnitude(cost: f32) -> usize {
    (cost.to_bits() >> FINE) as usize
}

/// Half-edges by magnitudes. Who takes one out tells whether it is still of that magnitude.
pub struct Queue {
    lists: Vec<Vec<u32>>,
    /// There is no entry of lesser magnitude.
    least: usize,
}

impl Default for Queue {
    fn default() -> Self {
        Self { lists: vec![Vec::new(); MAGNITUDES], least: 0 }
    }
}

impl Queue {
    /// Adds a half-edge whose cost is finite; one that would have had its turn has it next.
    #[inline(always)]
    pub fn push(&mut self, corner: u32, cost: f32) {
        self.lists[magnitude(cost).max(self.least)].push(corner);
    }

    /// A half-edge of the least magnitude, which it comes with, if that is no more than `most`.
    #[inline(always)]
    pub fn pop(&mut self, most: usize) -> Option<(u32, usize)> {
        while self.least <= most {
            if let Some(corner) = self.lists[self.least].pop() {
                return Some((corner, self.least));
            }
            self.least += 1;
        }
        None
    }

    /// The half-edge that would have its turn after so many others, if it is of the same magnitude.
    #[inline(always)]
    pub fn ahead(&self, others: usize) -> Option<u32> {
        let list = self.lists.get(self.least)?;
        list.len().checked_sub(others + 1).map(|at| list[at])
    }

    /// How many half-edges are of each magnitude.
    pub fn counts(&self) -> impl Iterator<Item = usize> {
        self.lists.iter().map(Vec::len)
    }
}
