//! Squares of cells before they are cut into blocks, and where what is met in them lies on the surface.

use crate::block::MIN_RATE;

/// A square of cells: a tile, or a part of a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Square {
    /// The tile, or the triangle.
    pub tile: u32,
    pub chart: Chart,
    /// Cells along its side.
    pub rate: u32,
    /// How many cells along each side, half by half, a coarser neighbour has; 0 where none has fewer. Sides are v = 0,
    /// u = 1, v = 1 and u = 0, in the direction around the square.
    pub ruled: [[u32; 2]; 4],
}

/// The (rate + 1)² corners of a square, row by row.
pub(crate) type Lattice = Vec<[f32; 3]>;

/// How a square lies on its tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Chart {
    /// It is the tile.
    Tile,
    /// The third of a triangle around a corner: (0, 0) is the corner, (1, 0) and (0, 1) are the middles of the sides
    /// there, and (1, 1) is the centroid. Either half beside the diagonal is affine.
    Third(u8),
    /// The half v ≤ u is a triangle whose corners are (0, 0), (1, 0) and (1, 1); the other half has no area.
    Triangle,
}

impl Chart {
    /// Parameters in the tile at a place of the square; those of a triangle are barycentric coordinates of its second
    /// and third corner.
    pub fn place(self, [x, y]: [f32; 2]) -> [f32; 2] {
        let corner = match self {
            Self::Tile => return [x, y],
            Self::Triangle => return [(x - y).max(0.0), y.min(x)],
            Self::Third(corner) => usize::from(corner),
        };
        let (far, near) = (x.max(y), x.min(y));
        let along = (0.5 * far - near / 6.0).max(0.0);
        let across = near / 3.0;
        let [next, last] = if y > x { [across, along] } else { [along, across] };
        let mut weights = [0.0; 3];
        weights[corner % 3] = 1.0 - next - last;
        weights[(corner + 1) % 3] = next;
        weights[(corner + 2) % 3] = last;
        [weights[1], weights[2]]
    }
}

impl Square {
    /// Whether a coarser neighbour rules each of its sides.
    pub fn seams(&self) -> [bool; 4] {
        self.ruled.map(|halves| halves.iter().any(|cells| *cells > 0))
    }

    /// Puts corners on sides that a coarser neighbour rules on its chords.
    pub fn chords(&self, lattice: &mut [[f32; 3]]) {
        let (n, stride) = (self.rate as usize, self.rate as usize + 1);
        for (side, halves) in self.ruled.iter().enumerate() {
            let at = |k: usize| match side {
                0 => k,
                1 => k * stride + n,
                2 => n * stride + n - k,
                _ => (n - k) * stride,
            };
            for (half, cells) in halves.iter().enumerate().filter(|(_, cells)| **cells > 0) {
                let length = n / 2 / *cells as usize;
                for start in (half * n / 2..(half + 1) * n / 2).step_by(length) {
                    let (a, b) = (lattice[at(start)], lattice[at(start + length)]);
                    for k in 1..length {
                        let t = k as f32 / length as f32;
                        lattice[at(start + k)] = [0, 1, 2].map(|axis| a[axis] + t * (b[axis] - a[axis]));
                    }
                }
            }
        }
    }
}

/// Cells of what a square is to have, within what it can have.
pub(crate) fn rate(cells: u32, most: u32) -> u32 {
    cells.clamp(MIN_RATE, most).next_power_of_two()
}
