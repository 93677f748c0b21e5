//! Measurements: runs of ours and the peer's take turns, so that what else the machine does falls on both.

use std::time::Instant;

/// A quantity measured in several runs.
#[derive(Clone, Debug)]
pub struct Sample {
    sorted: Vec<f64>,
}

impl Sample {
    /// From the values of the runs, at least one.
    pub fn new(mut values: Vec<f64>) -> Self {
        assert!(!values.is_empty(), "a sample needs a run");
        values.sort_by(f64::total_cmp);
        Self { sorted: values }
    }

    /// The median of the runs.
    pub fn median(&self) -> f64 {
        self.quantile(0.5)
    }

    /// Half the distance between the quartiles, as a fraction of the median.
    pub fn spread(&self) -> f64 {
        let median = self.median();
        if median == 0.0 { 0.0 } else { (self.quantile(0.75) - self.quantile(0.25)) / (2.0 * median.abs()) }
    }

    fn quantile(&self, fraction: f64) -> f64 {
        let at = fraction * (self.sorted.len() - 1) as f64;
        let (low, high) = (at.floor() as usize, at.ceil() as usize);
        self.sorted[low] + (self.sorted[high] - self.sorted[low]) * (at - low as f64)
    }
}

/// Seconds that `work` takes.
pub fn seconds<R>(work: impl FnOnce() -> R) -> f64 {
    let start = Instant::now();
    std::hint::black_box(work());
    start.elapsed().as_secs_f64()
}

/// Calls `ours` once to warm up and then `runs` times; each call returns what it measured.
pub fn sample(runs: usize, mut ours: impl FnMut() -> f64) -> Sample {
    ours();
    Sample::new((0..runs).map(|_| ours()).collect())
}

/// As [`sample`] for two quantities in turns; who goes first changes from run to run.
pub fn compare(runs: usize, mut ours: impl FnMut() -> f64, mut peer: impl FnMut() -> f64) -> (Sample, Sample) {
    let (mut a, mut b) = (Vec::with_capacity(runs), Vec::with_capacity(runs));
    ours();
    peer();
    for run in 0..runs {
        if run % 2 == 0 {
            a.push(ours());
            b.push(peer());
        } else {
            b.push(peer());
            a.push(ours());
        }
    }
    (Sample::new(a), Sample::new(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_and_spread_follow_the_quartiles() {
        let sample = Sample::new(vec![5.0, 1.0, 3.0, 2.0, 4.0]);
        assert_eq!(sample.median(), 3.0);
        assert_eq!(sample.spread(), (4.0 - 2.0) / 6.0);
        assert_eq!(Sample::new(vec![1.0, 2.0]).median(), 1.5);
    }

    #[test]
    fn compared_runs_take_turns() {
        let order = std::cell::RefCell::new(String::new());
        let note = |name| {
            order.borrow_mut().push(name);
            1.0
        };
        compare(3, || note('a'), || note('b'));
        assert_eq!(order.into_inner(), "ababbaab");
    }
}
