//! Time, memory and counts per stage, kept in one place per context: the table of `relievo run`, its trace file, the
//! benches and the C ABI's statistics all read from here.

use std::ops::Deref;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// One finished stage.
#[derive(Clone, Debug)]
pub struct Event {
    /// The stage, a fixed name such as `imprint.voxelise`.
    pub stage: &'static str,
    /// Start, since the context was made.
    pub start: Duration,
    /// How long it took.
    pub length: Duration,
    /// What was counted while it ran, by name.
    pub counts: Counts,
}

/// Counts of a stage, by name: few, so that a stage asks for no memory.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    list: [(&'static str, u64); MAX_COUNTS],
    count: usize,
}

/// Counts that a stage notes at most.
const MAX_COUNTS: usize = 4;

impl Counts {
    /// Adds a count, of four at most.
    pub fn note(&mut self, name: &'static str, value: u64) {
        debug_assert!(self.count < MAX_COUNTS, "{name} is one count too many");
        if let Some(place) = self.list.get_mut(self.count) {
            *place = (name, value);
            self.count += 1;
        }
    }
}

impl Deref for Counts {
    type Target = [(&'static str, u64)];

    fn deref(&self) -> &Self::Target {
        &self.list[..self.count]
    }
}

/// The stages a context has run, oldest first.
#[derive(Debug)]
pub struct Stats {
    origin: Instant,
    events: Mutex<Vec<Event>>,
}

/// Events kept at most; later ones are dropped until [`Stats::take`] empties the list, so that a host that never
/// asks does not leak.
const CAPACITY: usize = 1 << 20;

impl Default for Stats {
    fn default() -> Self {
        Self { origin: Instant::now(), events: Mutex::new(Vec::new()) }
    }
}

impl Stats {
    /// Runs `work` as the stage `name`.
    pub fn time<R>(&self, name: &'static str, work: impl FnOnce() -> R) -> R {
        let stage = self.begin(name);
        let result = work();
        stage.end();
        result
    }

    /// Starts a stage, which ends when the returned guard is dropped.
    pub fn begin(&self, stage: &'static str) -> Stage<'_> {
        Stage { stats: self, stage, start: self.origin.elapsed(), counts: Counts::default() }
    }

    /// Adds a stage of known length that has just ended, such as one that a graphics device timed.
    pub fn add(&self, stage: &'static str, length: Duration) {
        let start = self.origin.elapsed().saturating_sub(length);
        self.push(Event { stage, start, length, counts: Counts::default() });
    }

    fn push(&self, event: Event) {
        let mut events = self.lock();
        if events.len() < CAPACITY {
            events.push(event);
        }
    }

    /// The events so far, which are removed.
    pub fn take(&self) -> Vec<Event> {
        std::mem::take(&mut *self.lock())
    }

    /// Calls `each` with the events so far, which are removed, if there are at least `least`. Their room is used again.
    pub fn drain(&self, least: usize, each: impl FnMut(Event)) {
        let mut events = self.lock();
        if events.len() >= least {
            events.drain(..).for_each(each);
        }
    }

    /// A copy of the events so far.
    pub fn events(&self) -> Vec<Event> {
        self.lock().clone()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Event>> {
        self.events.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// A running stage.
#[derive(Debug)]
pub struct Stage<'a> {
    stats: &'a Stats,
    stage: &'static str,
    start: Duration,
    counts: Counts,
}

impl Stage<'_> {
    /// Notes a count of this stage, of four at most.
    pub fn count(&mut self, name: &'static str, value: u64) {
        self.counts.note(name, value);
    }

    /// Ends the stage, as dropping it does.
    pub fn end(self) {}
}

impl Drop for Stage<'_> {
    fn drop(&mut self) {
        let length = self.stats.origin.elapsed().saturating_sub(self.start);
        let event = Event { stage: self.stage, start: self.start, length, counts: std::mem::take(&mut self.counts) };
        self.stats.push(event);
    }
}
