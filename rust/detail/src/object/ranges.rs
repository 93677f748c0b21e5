//! How far a surface is displaced, block by block as it was measured last.

use std::collections::BTreeMap;

use half::f16;

/// The ranges of blocks' coefficients with the numbers of the edits that made them so.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ranges(BTreeMap<u32, (u64, [f32; 2])>);

impl Ranges {
    /// The least and the largest coefficient of `blocks`, and 0. Each is a block and the number of the edit that last
    /// changed it; only blocks that were changed since the last time are measured.
    pub fn of(&mut self, blocks: impl Iterator<Item = (u32, u64)>, measure: impl Fn(u32) -> [f32; 2]) -> [f32; 2] {
        let mut all = [0.0; 2];
        let mut count = 0;
        for (block, version) in blocks {
            let known = self.0.entry(block).or_insert((u64::MAX, [0.0; 2]));
            if known.0 != version {
                *known = (version, measure(block));
            }
            all = widest(all, known.1);
            count += 1;
        }
        if count < self.0.len() {
            // Some are gone: what comes in their place is measured anew.
            self.0.clear();
        }
        all
    }

    /// Forgets everything: the blocks are others.
    pub fn forget(&mut self) {
        self.0.clear();
    }
}

/// The range that holds two.
pub(crate) fn widest(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// The least and the largest of some coefficients.
pub(crate) fn range(block: &[f16]) -> [f32; 2] {
    // Half floats order like integers once the magnitude of negative ones is reversed.
    let key = |bits: u16| (bits ^ (((bits as i16) >> 15) as u16 & 0x7fff)) as i16;
    let back = |key: i16| f16::from_bits(key as u16 ^ ((key >> 15) as u16 & 0x7fff)).to_f32();
    let (mut low, mut high) = (i16::MAX, i16::MIN);
    for value in block {
        let key = key(value.to_bits());
        low = low.min(key);
        high = high.max(key);
    }
    [back(low), back(high)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    #[test]
    fn the_range_of_coefficients_is_exact() {
        let values = [0.5, -3.25, 7.0, -0.0, 0.001].map(f16::from_f32);
        assert_eq!(range(&values), [-3.25, 7.0]);
        assert_eq!(range(&[f16::from_f32(-2.0), f16::from_f32(-5.0)]), [-5.0, -2.0]);
        assert_eq!(range(&[f16::from_f32(2.0), f16::from_f32(5.0)]), [2.0, 5.0]);
    }

    #[test]
    fn only_what_changed_is_measured_and_what_is_gone_does_not_count() {
        let mut ranges = Ranges::default();
        let measured = RefCell::new(Vec::new());
        let mut of = |blocks: &[(u32, u64)]| {
            measured.borrow_mut().clear();
            let range = ranges.of(blocks.iter().copied(), |block| {
                measured.borrow_mut().push(block);
                [-(block as f32), 2.0 * block as f32]
            });
            (range, measured.borrow().clone())
        };
        assert_eq!(of(&[]), ([0.0; 2], vec![]));
        assert_eq!(of(&[(1, 0), (4, 7)]), ([-4.0, 8.0], vec![1, 4]));
        assert_eq!(of(&[(1, 8), (4, 7), (2, 9)]), ([-4.0, 8.0], vec![1, 2]));
        assert_eq!(of(&[(1, 8), (2, 9)]), ([-2.0, 4.0], vec![]));
        assert_eq!(of(&[(1, 8)]), ([-1.0, 2.0], vec![1]));
    }
}
