//! Sets of numbers that are walked through at the cost of what is in them.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// A set of numbers below a limit: a bit for each, and one more for every 64 bits that tells whether one of them is set,
/// and so on. Threads may add numbers at the same time, or remove some, but not both.
pub struct BitSet(Vec<Vec<AtomicU64>>);

impl BitSet {
    /// None of the numbers below `count`.
    pub fn new(count: usize) -> Self {
        let (mut levels, mut bits) = (Vec::new(), count.max(1));
        while levels.is_empty() || bits > 1 {
            bits = bits.div_ceil(64);
            levels.push((0..bits).map(|_| AtomicU64::new(0)).collect());
        }
        Self(levels)
    }

    /// Those of the bits of words, for numbers below 64 times as many.
    pub fn of_words(words: Vec<u64>) -> Self {
        let above = |words: &[u64]| -> Vec<u64> {
            let bit = |(at, word): (usize, &u64)| u64::from(*word != 0) << at;
            words.chunks(64).map(|words| words.iter().enumerate().fold(0, |sum, word| sum | bit(word))).collect()
        };
        let mut levels = vec![words];
        while let Some(last) = levels.last().filter(|last| last.len() > 1) {
            levels.push(above(last));
        }
        Self(levels.into_iter().map(|level| level.into_iter().map(AtomicU64::new).collect()).collect())
    }

    /// Bytes of a set of numbers below `count`, or a little less.
    pub fn bytes(count: usize) -> usize {
        count / 8 + count / 512
    }

    /// Adds a number. Returns whether it is new.
    #[inline]
    pub fn insert(&self, number: u32) -> bool {
        let mut number = number as usize;
        let mut is_new = None;
        for level in &self.0 {
            let (word, bit) = (number / 64, 1 << (number % 64));
            let before = level[word].fetch_or(bit, Relaxed);
            is_new.get_or_insert(before & bit == 0);
            // What is above tells of others already.
            if before != 0 {
                break;
            }
            number = word;
        }
        is_new == Some(true)
    }

    /// Removes a number.
    #[inline]
    pub fn remove(&self, number: u32) {
        let mut number = number as usize;
        for level in &self.0 {
            let (word, bit) = (number / 64, 1 << (number % 64));
            if level[word].fetch_and(!bit, Relaxed) != bit {
                break;
            }
            number = word;
        }
    }

    /// The words of 64 numbers in which there are some, ascending.
    pub fn words(&self) -> Vec<u32> {
        self.0[1..].iter().rev().fold(vec![0], |words, level| {
            words.into_iter().flat_map(|word| bits(word, level[word as usize].load(Relaxed))).collect()
        })
    }

    /// How many words of 64 numbers there are.
    pub fn word_count(&self) -> usize {
        self.0[0].len()
    }

    /// The bits of 64 numbers.
    #[inline]
    pub fn word(&self, word: u32) -> u64 {
        self.0[0][word as usize].load(Relaxed)
    }

    /// The last number up to one.
    #[inline]
    pub fn last_up_to(&self, number: u32) -> Option<u32> {
        let last = |word: u64| 63 - word.leading_zeros();
        let mut at = number;
        for (height, level) in self.0.iter().enumerate() {
            let found = level[at as usize / 64].load(Relaxed) & (u64::MAX >> (63 - at % 64));
            if found != 0 {
                let found = at & !63 | last(found);
                let down = self.0[..height].iter().rev();
                return Some(down.fold(found, |word, level| 64 * word + last(level[word as usize].load(Relaxed))));
            }
            at = (at / 64).checked_sub(1)?;
        }
        None
    }

    /// The first number from one on.
    #[inline]
    pub fn first_from(&self, number: u32) -> Option<u32> {
        let mut at = number;
        for (height, level) in self.0.iter().enumerate() {
            let found = level.get(at as usize / 64)?.load(Relaxed) & (u64::MAX << (at % 64));
            if found != 0 {
                let found = at & !63 | found.trailing_zeros();
                let down = self.0[..height].iter().rev();
                let first =
                    |word: u32, level: &Vec<AtomicU64>| 64 * word + level[word as usize].load(Relaxed).trailing_zeros();
                return Some(down.fold(found, first));
            }
            at = at / 64 + 1;
        }
        None
    }

    /// All numbers, ascending.
    pub fn iter(&self) -> impl Iterator<Item = u32> {
        self.words().into_iter().flat_map(|word| self.numbers(word))
    }

    /// The numbers in a word, ascending.
    #[inline]
    pub fn numbers(&self, word: u32) -> impl Iterator<Item = u32> + use<> {
        bits(word, self.word(word))
    }
}

/// The numbers of the bits that are set in a word.
#[inline]
pub fn bits(word: u32, mut left: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        (left != 0).then(|| {
            let bit = left.trailing_zeros();
            left &= left - 1;
            64 * word + bit
        })
    })
}

#[cfg(test)]
mod tests {
    use super::BitSet;

    #[test]
    fn a_set_has_what_was_added_and_not_removed() {
        for count in [1, 64, 65, 4096, 4097, 300_000] {
            let set = BitSet::new(count as usize);
            assert_eq!(set.iter().count(), 0);
            let some: Vec<u32> = (0..count).filter(|number| number % 1000 < 3 || number + 1 == count).collect();
            assert!(some.iter().rev().all(|number| set.insert(*number)));
            assert!(!set.insert(some[0]));
            assert!(set.iter().eq(some.iter().copied()));
            let (gone, left): (Vec<u32>, Vec<u32>) = some.into_iter().partition(|number| number / 1000 % 2 == 0);
            gone.iter().for_each(|number| set.remove(*number));
            assert!(set.iter().eq(left.iter().copied()));
            set.remove(gone[0]);
            assert!(set.iter().eq(left.iter().copied()));
            for number in (0..count).step_by(37) {
                assert_eq!(set.last_up_to(number), left.iter().rfind(|other| **other <= number).copied());
                assert_eq!(set.first_from(number), left.iter().find(|other| **other >= number).copied());
            }
            let copy = BitSet::of_words((0..set.word_count() as u32).map(|word| set.word(word)).collect());
            assert!(copy.iter().eq(left.iter().copied()));
        }
    }
}
