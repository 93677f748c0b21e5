//! What the stages of an event cost.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// The stages of a brush event: the ray, the dabs, the triangles and what is written to the device.
pub const STAGES: [&str; 4] = ["pick", "dabs", "triangles", "upload"];

/// Frames whose times are remembered.
const MAX_FRAMES: usize = 1 << 12;

/// Milliseconds of the stages of the brush events of a session, and of its frames.
#[derive(Clone, Debug, Default)]
pub struct Costs {
    /// Of each event.
    events: Vec<[f32; STAGES.len()]>,
    /// Of the stages of the event under way.
    current: [f32; STAGES.len()],
    /// Between frames that followed one another at once, the last [`MAX_FRAMES`] of them.
    frames: VecDeque<f32>,
    /// When the first frame was drawn.
    first: Option<Instant>,
    /// Of what was done last that is no brush event, by name.
    pub(crate) others: Vec<(&'static str, f32)>,
}

impl Costs {
    /// Measures `work` as a stage of the event under way, by its place in [`STAGES`].
    pub(crate) fn stage<R>(&mut self, stage: usize, work: impl FnOnce() -> R) -> R {
        let start = Instant::now();
        let done = work();
        self.current[stage] += milliseconds(start.elapsed());
        done
    }

    /// Measures `work` as a stage of the event that ended last.
    pub(crate) fn after<R>(&mut self, stage: usize, work: impl FnOnce() -> R) -> R {
        let start = Instant::now();
        let done = work();
        if let Some(event) = self.events.last_mut().filter(|event| event[stage] == 0.0) {
            event[stage] = milliseconds(start.elapsed());
        }
        done
    }

    /// Measures `work` that is no brush event.
    pub(crate) fn other<R>(&mut self, name: &'static str, work: impl FnOnce() -> R) -> R {
        let start = Instant::now();
        let done = work();
        let time = milliseconds(start.elapsed());
        match self.others.iter_mut().find(|(other, _)| *other == name) {
            Some((_, known)) => *known = time,
            None => self.others.push((name, time)),
        }
        done
    }

    /// Ends an event; without `counts` it is forgotten.
    pub(crate) fn end_event(&mut self, counts: bool) {
        let event = std::mem::take(&mut self.current);
        if counts {
            self.events.push(event);
        }
    }

    /// Counts a frame that was drawn, `since` the one before began if that called for it at once.
    pub(crate) fn end_frame(&mut self, since: Option<Duration>) {
        self.first.get_or_insert_with(Instant::now);
        self.frames.extend(since.map(milliseconds));
        if self.frames.len() > MAX_FRAMES {
            self.frames.pop_front();
        }
    }

    /// When the first frame was drawn, if one was.
    pub fn first_frame(&self) -> Option<Instant> {
        self.first
    }

    /// Milliseconds of the stages of the last event.
    pub fn last(&self) -> Option<[f32; STAGES.len()]> {
        self.events.last().copied()
    }

    /// Says what the events cost: their number, median and most, and the medians of their stages; and the time between
    /// frames.
    pub fn summary(&self) -> String {
        let median = |of: &dyn Fn(&[f32; STAGES.len()]) -> f32| middle(self.events.iter().map(of));
        let total = |event: &[f32; STAGES.len()]| event.iter().sum::<f32>();
        let most = self.events.iter().map(total).fold(0.0, f32::max);
        let mut text =
            format!("brush events: {}, median {:.2} ms, most {most:.2} ms\n", self.events.len(), median(&total));
        for (stage, name) in STAGES.iter().enumerate() {
            text += &format!("  {name}: median {:.2} ms\n", median(&|event| event[stage]));
        }
        for (name, time) in &self.others {
            text += &format!("  {name}: {time:.1} ms\n");
        }
        if !self.frames.is_empty() {
            let time = middle(self.frames.iter().copied());
            text += &format!("frames: {}, median {time:.1} ms, {:.0} a second\n", self.frames.len(), 1e3 / time);
        }
        text
    }
}

/// Returns the median of some values; 0 without one.
fn middle(values: impl Iterator<Item = f32>) -> f32 {
    let mut all: Vec<f32> = values.collect();
    all.sort_by(f32::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or_default()
}

fn milliseconds(time: Duration) -> f32 {
    1e3 * time.as_secs_f32()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_summed_and_forgotten_where_they_do_not_count() {
        let mut costs = Costs { current: [1.0, 2.0, 3.0, 4.0], ..Costs::default() };
        costs.end_event(true);
        costs.current = [9.0; 4];
        costs.end_event(false);
        assert_eq!(costs.last(), Some([1.0, 2.0, 3.0, 4.0]));
        let summary = costs.summary();
        assert!(summary.contains("brush events: 1, median 10.00 ms, most 10.00 ms"), "{summary}");
        assert!(!summary.contains("frames") && costs.first_frame().is_none(), "{summary}");
        for since in [None, Some(20), Some(40), Some(25)] {
            costs.end_frame(since.map(Duration::from_millis));
        }
        let summary = costs.summary();
        assert!(summary.contains("frames: 3, median 25.0 ms, 40 a second"), "{summary}");
        assert!(costs.first_frame().is_some());
    }
}
