//! What each stage of each frame cost: as a table for people, and as a trace that Perfetto and Chrome open.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::time::Duration;

use relievo_core::stats::Event;
use serde_json::{Value, json};

/// The stages of all frames.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    frames: Vec<(u32, Vec<Event>)>,
}

/// What a stage cost per frame in which it ran, milliseconds.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost {
    /// The stage.
    pub stage: &'static str,
    /// Frames in which it ran.
    pub frames: usize,
    /// Times it ran in all.
    pub calls: usize,
    /// Mean over those frames.
    pub mean: f64,
    /// Median over those frames.
    pub median: f64,
    /// Largest of those frames.
    pub max: f64,
}

impl Trace {
    /// Adds the stages of a frame.
    pub fn add(&mut self, frame: u32, events: Vec<Event>) {
        self.frames.push((frame, events));
    }

    /// The cost of every stage, in the order in which stages first began.
    pub fn costs(&self) -> Vec<Cost> {
        let mut order: Vec<&'static str> = Vec::new();
        let mut sums: BTreeMap<&'static str, (usize, Vec<f64>)> = BTreeMap::new();
        for (_, events) in &self.frames {
            let mut frame: BTreeMap<&'static str, f64> = BTreeMap::new();
            let mut sorted: Vec<&Event> = events.iter().collect();
            sorted.sort_by_key(|event| (event.start, std::cmp::Reverse(event.length)));
            for event in sorted {
                if !order.contains(&event.stage) {
                    order.push(event.stage);
                }
                *frame.entry(event.stage).or_default() += event.length.as_secs_f64() * 1e3;
                sums.entry(event.stage).or_default().0 += 1;
            }
            for (stage, sum) in frame {
                sums.entry(stage).or_default().1.push(sum);
            }
        }
        order
            .into_iter()
            .filter_map(|stage| {
                let (calls, mut list) = sums.remove(stage)?;
                list.sort_by(f64::total_cmp);
                let middle = list.len() / 2;
                let median = if list.len() % 2 == 1 { list[middle] } else { (list[middle - 1] + list[middle]) * 0.5 };
                let mean = list.iter().sum::<f64>() / list.len() as f64;
                let max = list.last().copied().unwrap_or(0.0);
                Some(Cost { stage, frames: list.len(), calls, mean, median, max })
            })
            .collect()
    }

    /// The costs as a table.
    pub fn table(&self) -> String {
        let costs = self.costs();
        let width = costs.iter().map(|cost| cost.stage.len()).max().unwrap_or(0).max(5);
        let mut out = format!(
            "{:width$}  {:>7}  {:>7}  {:>9}  {:>9}  {:>9}\n",
            "stage", "frames", "calls", "mean ms", "median ms", "max ms"
        );
        for cost in costs {
            let Cost { stage, frames, calls, mean, median, max } = cost;
            let _ = writeln!(out, "{stage:width$}  {frames:>7}  {calls:>7}  {mean:>9.3}  {median:>9.3}  {max:>9.3}");
        }
        out
    }

    /// The stages in the JSON form of the trace event format, times in microseconds.
    pub fn json(&self) -> Value {
        let mut list: Vec<Value> = Vec::new();
        let mut lanes: Vec<Vec<Duration>> = Vec::new();
        for (frame, events) in &self.frames {
            let mut sorted: Vec<&Event> = events.iter().collect();
            sorted.sort_by_key(|event| (event.start, std::cmp::Reverse(event.length)));
            for event in sorted {
                let lane = lane_of(&mut lanes, event.start, event.start + event.length);
                let mut counts = serde_json::Map::new();
                counts.insert("frame".into(), (*frame).into());
                counts.extend(event.counts.iter().map(|(name, value)| ((*name).to_string(), Value::from(*value))));
                list.push(json!({
                    "name": event.stage,
                    "cat": event.stage.split('.').next().unwrap_or(""),
                    "ph": "X",
                    "ts": event.start.as_secs_f64() * 1e6,
                    "dur": event.length.as_secs_f64() * 1e6,
                    "pid": 1,
                    "tid": lane + 1,
                    "args": counts,
                }));
            }
        }
        json!({ "displayTimeUnit": "ms", "traceEvents": list })
    }
}

/// The first lane on which the event fits between or inside the others; stages of one lane nest.
fn lane_of(lanes: &mut Vec<Vec<Duration>>, start: Duration, end: Duration) -> usize {
    for (at, open) in lanes.iter_mut().enumerate() {
        while open.last().is_some_and(|last| *last <= start) {
            open.pop();
        }
        if open.last().is_none_or(|last| end <= *last) {
            open.push(end);
            return at;
        }
    }
    lanes.push(vec![end]);
    lanes.len() - 1
}

#[cfg(test)]
mod tests {
    use relievo_core::stats::Counts;

    use super::*;

    fn event(stage: &'static str, start: u64, length: u64) -> Event {
        let milliseconds = Duration::from_millis;
        let mut counts = Counts::default();
        counts.note("tiles", 4);
        Event { stage, start: milliseconds(start), length: milliseconds(length), counts }
    }

    fn trace() -> Trace {
        let mut trace = Trace::default();
        trace.add(0, vec![event("imprint.cast", 2, 1), event("imprint", 1, 4), event("imprint.cast", 3, 1)]);
        trace.add(1, vec![event("imprint", 10, 8), event("render", 12, 20)]);
        trace
    }

    #[test]
    fn costs_are_per_frame_in_order_of_first_start() {
        let costs = trace().costs();
        let row = |stage, frames, calls, mean, median, max| Cost { stage, frames, calls, mean, median, max };
        assert_eq!(
            costs,
            [
                row("imprint", 2, 2, 6.0, 6.0, 8.0),
                row("imprint.cast", 1, 2, 2.0, 2.0, 2.0),
                row("render", 1, 1, 20.0, 20.0, 20.0)
            ]
        );
        assert_eq!(trace().table().lines().count(), 4);
    }

    #[test]
    fn overlapping_stages_get_their_own_lane() {
        let json = trace().json();
        let events = json["traceEvents"].as_array().unwrap();
        let lane = |name: &str| events.iter().rev().find(|event| event["name"] == name).unwrap()["tid"].clone();
        assert_eq!(events.len(), 5);
        assert_eq!((lane("imprint"), lane("imprint.cast"), lane("render")), (json!(1), json!(1), json!(2)));
        assert_eq!(events[0]["args"], json!({ "frame": 0, "tiles": 4 }));
    }
}
