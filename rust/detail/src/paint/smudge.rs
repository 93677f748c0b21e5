//! What a smearing brush carries: the colours that were under it, spread out over its box.
//!
//! As a finger does, each dab leaves the picture that the one before picked up, and picks up what is then there. The
//! picture lies across the box and does not depend on faces, so colours are carried over every edge and from object to
//! object. Sums are whole numbers, so that it does not matter which thread adds first. Colours are linear with alpha.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use crate::channels::knots::PerKnot;
use crate::paint::mode::Colors;
use crate::paint::weights::Weights;

/// Cells along the finest picture.
const SIDE: usize = 32;
/// Those of all of it.
pub(crate) const CELLS: usize = SIDE * SIDE;
/// Parts of one in which colours are added up.
const UNIT: f64 = 1048576.0;
/// The largest colour that is carried.
const BRIGHTEST: f32 = 65504.0;

/// Sums of red, green, blue and alpha, and how many.
pub(crate) type Sums = [i64; 5];

/// A picture of what was under a brush.
#[derive(Clone, Debug)]
pub(crate) struct Carried {
    cells: Vec<[f32; 4]>,
}

/// A brush that leaves one picture and picks up another.
#[derive(Clone, Debug)]
pub struct Smudge {
    /// What it leaves, once that is known.
    carried: Arc<OnceLock<Option<Arc<Carried>>>>,
    /// The one that picks that up.
    before: Option<Arc<Smudge>>,
    picked: Arc<Mutex<Picked>>,
}

/// What was picked up: sums by cell, or a picture that was made of them elsewhere.
#[derive(Debug)]
struct Picked {
    sums: Vec<Sums>,
    picture: Option<Arc<Carried>>,
}

impl PartialEq for Smudge {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.picked, &other.picked)
    }
}

impl Smudge {
    /// A brush that carries a picture, or nothing yet.
    pub(crate) fn new(carried: Option<Arc<Carried>>) -> Self {
        Self { carried: Arc::new(OnceLock::from(carried)), before: None, picked: Picked::nothing() }
    }

    /// A brush that leaves what `before` has picked up when this one is used.
    pub(crate) fn after(before: &Self) -> Self {
        Self { carried: Arc::default(), before: Some(Arc::new(before.clone())), picked: Picked::nothing() }
    }

    /// Whether it leaves what `before` picks up.
    pub(crate) fn follows(&self, before: &Self) -> bool {
        self.before.as_deref() == Some(before)
    }

    fn left(&self) -> Option<&Arc<Carried>> {
        self.carried.get_or_init(|| self.before.as_ref().and_then(|before| before.taken())).as_ref()
    }

    /// Sets the colours that the brush leaves; without a picture the shares are 0.
    pub(crate) fn leave(&self, weights: &mut Weights, brush: &mut Colors) {
        let Some(carried) = self.left() else { return weights.share.fill(0.0) };
        let Weights { share, across: [x, y], .. } = weights;
        for k in (0..share.len()).filter(|k| share[*k] > 0.0) {
            let color = carried.sample(x[k], y[k]);
            (0..4).for_each(|channel| brush[channel][k] = color[channel]);
        }
    }

    /// Picks up the colours of places in the box.
    pub(crate) fn pick(&self, inside: &PerKnot, across: &[PerKnot; 2], colors: &Colors) {
        let mut picked = self.picked.lock().unwrap_or_else(PoisonError::into_inner);
        for k in (0..inside.len()).filter(|k| inside[*k] > 0.0) {
            let [i, j] =
                across.map(|axis| ((0.5 + 0.5 * axis[k]) * SIDE as f32).clamp(0.0, SIDE as f32 - 1.0) as usize);
            let sums = &mut picked.sums[j * SIDE + i];
            for (sum, channel) in sums.iter_mut().zip(colors) {
                *sum += (f64::from(channel[k].clamp(-BRIGHTEST, BRIGHTEST)) * UNIT) as i64;
            }
            sums[4] += 1;
        }
    }

    /// The cells of the picture that is carried.
    pub(crate) fn carried(&self) -> Option<&[[f32; 4]]> {
        self.left().map(|carried| carried.cells.as_slice())
    }

    /// Takes on the cells of the picture that was made of what was picked up elsewhere.
    pub(crate) fn set_picture(&self, cells: Vec<[f32; 4]>) {
        let mut picked = self.picked.lock().unwrap_or_else(PoisonError::into_inner);
        picked.picture = Some(Arc::new(Carried { cells }));
    }

    /// Adds sums that were picked up elsewhere, cell by cell.
    pub(crate) fn add(&self, sums: impl Iterator<Item = Sums>) {
        let mut picked = self.picked.lock().unwrap_or_else(PoisonError::into_inner);
        for (own, more) in picked.sums.iter_mut().zip(sums) {
            own.iter_mut().zip(more).for_each(|(own, more)| *own += more);
        }
    }

    /// The picture that was picked up; that which was carried if nothing was there.
    pub(crate) fn taken(&self) -> Option<Arc<Carried>> {
        let picked = self.picked.lock().unwrap_or_else(PoisonError::into_inner);
        picked.picture.clone().or_else(|| Carried::of(&picked.sums).map(Arc::new)).or_else(|| self.left().cloned())
    }
}

impl Picked {
    fn nothing() -> Arc<Mutex<Self>> {
        Arc::new(Mutex::new(Self { sums: vec![[0; 5]; CELLS], picture: None }))
    }
}

impl Carried {
    /// Means of the sums; a cell without any gets the mean of the least square of cells around it that has some.
    fn of(sums: &[Sums]) -> Option<Self> {
        let mut levels = vec![sums.to_vec()];
        let mut side = SIDE;
        while side > 1 {
            side /= 2;
            let finer = &levels[levels.len() - 1];
            let sum = |k: usize| {
                let (i, j) = (2 * (k % side), 2 * (k / side));
                let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(di, dj)| finer[(j + dj) * 2 * side + i + di]);
                std::array::from_fn(|n| four.iter().map(|sums| sums[n]).sum())
            };
            levels.push((0..side * side).map(sum).collect());
        }
        let mean = |sums: &Sums| [0, 1, 2, 3].map(|n: usize| (sums[n] as f64 / UNIT / sums[4] as f64) as f32);
        let mut cells: Vec<[f32; 4]> = Vec::new();
        for (level, sums) in levels.iter().enumerate().rev() {
            let side = SIDE >> level;
            let cell = |k: usize| match sums[k] {
                sums if sums[4] > 0 => Some(mean(&sums)),
                _ => cells.get(k / side / 2 * (side / 2) + k % side / 2).copied(),
            };
            cells = (0..side * side).map(cell).collect::<Option<_>>()?;
        }
        Some(Self { cells })
    }

    /// Bilinear at a place of the brush.
    fn sample(&self, x: f32, y: f32) -> [f32; 4] {
        let at = |value: f32| ((0.5 + 0.5 * value) * SIDE as f32 - 0.5).clamp(0.0, SIDE as f32 - 1.0);
        let (x, y) = (at(x), at(y));
        let (i, j) = (x as usize, y as usize);
        let (s, t) = (x - i as f32, y - j as f32);
        let cell = |i: usize, j: usize| self.cells[j.min(SIDE - 1) * SIDE + i.min(SIDE - 1)];
        let (a, b, c, d) = (cell(i, j), cell(i + 1, j), cell(i, j + 1), cell(i + 1, j + 1));
        [0, 1, 2, 3].map(|n| {
            let (low, high) = (a[n] + (b[n] - a[n]) * s, c[n] + (d[n] - c[n]) * s);
            low + (high - low) * t
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channels::knots::BLOCK_KNOTS;

    #[test]
    fn what_is_picked_up_is_left_where_it_was_in_the_box() {
        // Few places, so that most cells have none: red goes by x, green by y.
        let smudge = Smudge::new(None);
        let mut weights = Weights::default();
        let mut colors: Colors = [[0.25; BLOCK_KNOTS]; 4];
        for k in 0..BLOCK_KNOTS {
            let at = |k: usize| (k as f32 + 0.5) / 8.0 - 1.0;
            (weights.across[0][k], weights.across[1][k], weights.share[k]) = (at(k % 16), at(k / 16), 1.0);
            (colors[0][k], colors[1][k]) = (2.0 + weights.across[0][k], 2.0 + weights.across[1][k]);
        }
        assert!(smudge.taken().is_none());
        smudge.pick(&weights.share, &weights.across, &colors);
        let next = Smudge::new(smudge.taken());
        let mut brush: Colors = [[9.0; BLOCK_KNOTS]; 4];
        next.leave(&mut weights, &mut brush);
        for (k, share) in weights.share.iter().enumerate() {
            assert!(*share == 1.0 && brush[2][k] == 0.25);
            assert!((brush[0][k] - colors[0][k]).abs() < 0.1 && (brush[1][k] - colors[1][k]).abs() < 0.1, "{k}");
        }
        // A brush that carries nothing leaves nothing.
        smudge.leave(&mut weights, &mut brush);
        assert!(!weights.any());
    }
}
