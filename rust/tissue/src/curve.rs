//! Curves over time: activations of muscles and displacements of nodes.

use relievo_core::{Error, Result};

/// Values at times, linear between them and constant before the first and after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve<const WIDTH: usize> {
    keys: Vec<(f64, [f32; WIDTH])>,
}

impl<const WIDTH: usize> Curve<WIDTH> {
    /// Makes a curve of times in seconds, which increase, and values.
    ///
    /// # Errors
    /// Fails if there is no key, a number is not finite, or the times do not increase.
    pub fn new(keys: Vec<(f64, [f32; WIDTH])>) -> Result<Self> {
        let is_finite = |(time, value): &(f64, [f32; WIDTH])| time.is_finite() && value.iter().all(|v| v.is_finite());
        if keys.is_empty() || !keys.iter().all(is_finite) || !keys.windows(2).all(|pair| pair[0].0 < pair[1].0) {
            return Err(Error::invalid("the keys of a curve are empty, not finite or not in order of time")
                .advise("give at least one key, with times that increase"));
        }
        Ok(Self { keys })
    }

    /// Makes a curve that is always `value`.
    pub fn constant(value: [f32; WIDTH]) -> Self {
        Self { keys: vec![(0.0, value)] }
    }

    /// Returns the value at `time` in seconds.
    pub fn at(&self, time: f64) -> [f32; WIDTH] {
        let after = self.keys.partition_point(|key| key.0 <= time);
        let (Some(next), Some(last)) = (self.keys.get(after), after.checked_sub(1).map(|last| &self.keys[last])) else {
            return self.keys[after.min(self.keys.len() - 1)].1;
        };
        let share = ((time - last.0) / (next.0 - last.0)) as f32;
        std::array::from_fn(|at| last.1[at] + share * (next.1[at] - last.1[at]))
    }

    /// Returns the keys.
    pub fn keys(&self) -> &[(f64, [f32; WIDTH])] {
        &self.keys
    }
}
