//! Elements of arrays that changed, as ranges: what a copy of these arrays has to renew.

use std::ops::Range;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

/// Unchanged elements between two ranges up to which they are one range: copying these takes less time than another call.
pub const GAP: u32 = 8;

/// Marks of the elements that changed, one bit each. Threads may mark at the same time.
#[derive(Debug, Default)]
pub struct Marks {
    words: Vec<AtomicU64>,
    count: usize,
}

impl Marks {
    /// Makes marks for `count` elements, without any mark.
    pub fn new(count: usize) -> Self {
        Self { words: (0..count.div_ceil(64)).map(|_| AtomicU64::new(0)).collect(), count }
    }

    /// Marks an element. Does nothing if there is no such element.
    pub fn mark(&self, element: usize) {
        if element < self.count {
            self.set(element / 64, 1 << (element % 64));
        }
    }

    /// Marks all elements.
    pub fn mark_all(&self) {
        for (word, first) in self.words.iter().zip((0..self.count).step_by(64)) {
            word.store(u64::MAX >> (64 - (self.count - first).min(64)), Relaxed);
        }
    }

    /// Puts `new` in place of `old`, the values of the elements from `first` on, and marks elements whose bits differ, as far as
    /// there are marks for them.
    pub fn renew<const N: usize>(&self, first: usize, old: &mut [[f32; N]], new: &[[f32; N]]) {
        let (mut at, mut bits) = (first / 64, 0);
        for (element, (old, new)) in (first..).zip(old.iter_mut().zip(new)) {
            if old.map(f32::to_bits) == new.map(f32::to_bits) {
                continue;
            }
            *old = *new;
            if element >= self.count {
                continue;
            }
            if element / 64 != at {
                self.set(at, bits);
                (at, bits) = (element / 64, 0);
            }
            bits |= 1 << (element % 64);
        }
        self.set(at, bits);
    }

    fn set(&self, word: usize, bits: u64) {
        if let Some(word) = self.words.get(word).filter(|_| bits != 0) {
            word.fetch_or(bits, Relaxed);
        }
    }

    /// Makes `ranges` the marked elements, ascending, with the elements of gaps of at most [`GAP`] between them, and
    /// removes all marks.
    pub fn take(&mut self, ranges: &mut Vec<Range<u32>>) {
        ranges.clear();
        for (word, first) in self.words.iter_mut().zip((0u32..).step_by(64)) {
            let mut bits = std::mem::take(word.get_mut());
            while bits != 0 {
                let start = bits.trailing_zeros();
                let end = start + (!(bits >> start)).trailing_zeros();
                bits = bits.checked_shr(end).and_then(|rest| rest.checked_shl(end)).unwrap_or(0);
                add(ranges, first + start..first + end);
            }
        }
    }
}

/// Appends a range that begins at or after the end of the last one of `ranges`, or makes the last one longer where the
/// gap between them is at most [`GAP`].
fn add(ranges: &mut Vec<Range<u32>>, range: Range<u32>) {
    match ranges.last_mut() {
        Some(last) if range.start - last.end <= GAP => last.end = range.end,
        _ => ranges.push(range),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What ranges have to be, element by element.
    fn expected(marked: &[bool]) -> Vec<Range<u32>> {
        let mut ranges: Vec<Range<u32>> = Vec::new();
        for element in (0..).zip(marked).filter_map(|(element, marked)| marked.then_some(element)) {
            match ranges.last_mut() {
                Some(last) if element - last.end <= GAP => last.end = element + 1,
                _ => ranges.push(element..element + 1),
            }
        }
        ranges
    }

    #[test]
    fn ranges_are_the_marked_elements_and_small_gaps() {
        let mut state = 7_u64;
        let mut random = |below: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % below
        };
        for count in [0, 1, 63, 64, 65, 128, 1000] {
            for rarity in [1, 2, 9, 40] {
                let marked: Vec<bool> = (0..count).map(|_| random(rarity) == 0).collect();
                let mut marks = Marks::new(count);
                (0..count).filter(|element| marked[*element]).for_each(|element| marks.mark(element));
                let mut ranges: Vec<_> = std::iter::once(3..4).collect();
                marks.take(&mut ranges);
                assert_eq!(ranges, expected(&marked), "{count} {rarity}");
                marks.take(&mut ranges);
                assert!(ranges.is_empty());
                marks.mark_all();
                marks.mark(count);
                marks.take(&mut ranges);
                assert_eq!(ranges, expected(&vec![true; count]));
            }
        }
    }

    #[test]
    fn elements_whose_bits_differ_are_renewed_and_marked() {
        let (mut old, mut marks) = (vec![[0.0, f32::NAN]; 200], Marks::new(200));
        let mut new = old.clone();
        for element in [0, 63, 64, 130, 199] {
            new[element][0] = -0.0;
        }
        marks.renew(0, &mut old, &new);
        assert!(old.iter().zip(&new).all(|(old, new)| old.map(f32::to_bits) == new.map(f32::to_bits)));
        let mut ranges = Vec::new();
        marks.take(&mut ranges);
        assert_eq!(ranges, [0..1, 63..65, 130..131, 199..200]);
        // A part of the elements, up to a word's end and beyond.
        marks.renew(60, &mut old[60..140], &[[1.0; 2]; 80]);
        marks.take(&mut ranges);
        assert_eq!(ranges, std::iter::once(60..140).collect::<Vec<_>>());
        // Elements without marks get their values too.
        marks.renew(190, &mut old[190..], &[[2.0; 2]; 10]);
        let (mut longer, new) = (vec![[0.0; 2]; 30], [[3.0; 2]; 30]);
        marks.renew(180, &mut longer, &new);
        marks.take(&mut ranges);
        assert_eq!(longer, new);
        assert_eq!(ranges, std::iter::once(180..200).collect::<Vec<_>>());
    }
}
