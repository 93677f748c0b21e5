//! Measurements: runs of ours and the peer's take turns, so that what else the machine does falls on both.

use std::process::Command;
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

/// Bytes the process has, or had at its peak, where the system tells.
pub fn memory(what: &str) -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(what)?.strip_prefix(':'))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024.0)
}

/// Bytes that this program prints when it is called anew to do one thing; `None` where it prints none.
pub fn peak_of(name: &str, option: &str, value: &str) -> Option<f64> {
    printed(&mut anew(name, option, value)?)
}

/// This program, to be called anew to do one thing.
pub fn anew(name: &str, option: &str, value: &str) -> Option<Command> {
    let mut command = Command::new(std::env::current_exe().ok()?);
    command.args([name, option, value]);
    Some(command)
}

/// The number that a program prints; `None` where it prints none.
pub fn printed(command: &mut Command) -> Option<f64> {
    String::from_utf8(command.output().ok()?.stdout).ok()?.trim().parse().ok()
}

/// Seconds that all threads of this process have worked; 0 where the system does not tell.
pub fn core_seconds() -> f64 {
    let told = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name of the program, in brackets, may have spaces. Times are in hundredths of a second.
    let fields = told.rsplit(')').next().unwrap_or_default().split_whitespace();
    fields.skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
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
