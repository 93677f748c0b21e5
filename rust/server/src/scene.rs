//! A scene in memory: how far it is, and the simulation that goes on from there.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use relievo_client::{Activity, Failure, Hash, Status};
use relievo_core::Error;

use crate::kind::Simulation;
use crate::record::{Record, Wish};
use crate::store::Store;

/// The share of a new frame in the mean of the seconds a frame takes.
const WEIGHT: f64 = 0.3;

/// A scene of a user.
pub struct Scene {
    pub record: Record,
    /// Keys of the frames that are stored, from frame 0 on.
    pub keys: Vec<Hash>,
    /// Keys of the frames after them, which are computed and on their way to the disk, and whether each is there; clients do
    /// not see one before those ahead of it are stored.
    unstored: VecDeque<(Hash, bool)>,
    /// The simulation at the last frame that is computed, if it is in memory.
    pub live: Option<Box<dyn Simulation>>,
    pub failure: Option<Failure>,
    pub particles: u64,
    /// Mean seconds that a frame took.
    pub pace: Option<f64>,
    /// The worker's frame, while a worker has the scene.
    pub work: Option<Work>,
    /// When a worker had it last, in turns.
    pub turn: u64,
    /// Accelerations that are on their way: of which frame, and the bytes so far.
    pub arriving: Option<(u64, Vec<u8>)>,
}

/// What a worker and its scene share.
#[derive(Clone, Default)]
pub struct Work {
    /// The frame that is computed.
    pub frame: u64,
    /// Asks the worker to give the frame up.
    pub stop: Arc<AtomicBool>,
    /// The bits of the part that is done, as a float.
    pub fraction: Arc<AtomicU32>,
}

impl Work {
    /// Returns the part of the frame that is done, 0 to 1.
    pub fn fraction(&self) -> f32 {
        f32::from_bits(self.fraction.load(Ordering::Relaxed))
    }
}

impl Scene {
    /// Returns a scene of which nothing was looked up yet.
    pub fn new(record: Record) -> Self {
        let (keys, unstored, arriving) = (Vec::new(), VecDeque::new(), None);
        let (live, failure, pace, work) = (None, None, None, None);
        Self { record, keys, unstored, live, failure, particles: 0, pace, work, turn: 0, arriving }
    }

    /// Returns the frame to compute next.
    pub fn next(&self) -> u64 {
        (self.keys.len() + self.unstored.len()) as u64
    }

    /// Returns the key of the last frame that is computed, and whether it is stored.
    pub fn last_key(&self) -> (Option<Hash>, bool) {
        match self.unstored.back() {
            Some((key, _)) => (Some(*key), false),
            None => (self.keys.last().copied(), true),
        }
    }

    /// Takes a frame that is computed, before it is stored.
    pub fn computed(&mut self, key: Hash, simulation: Box<dyn Simulation>) {
        self.unstored.push_back((key, false));
        self.particles = simulation.elements();
        self.live = Some(simulation);
    }

    /// Takes what became of a frame on its way to the disk: clients see it once it and all before it are there. Where it
    /// could not be stored, the scene fails, and the frames after it are given up.
    pub fn stored(&mut self, key: Hash, outcome: Result<(), Error>) {
        let Some(place) = self.unstored.iter().position(|(other, _)| *other == key) else { return };
        match outcome {
            Ok(()) => {
                self.unstored[place].1 = true;
                while let Some((key, _)) = self.unstored.pop_front_if(|(_, is_there)| *is_there) {
                    self.keys.push(key);
                }
            }
            Err(error) => {
                self.failure = Some(Failure::from(&error));
                self.cut((self.keys.len() + place) as u64);
            }
        }
    }

    /// Counts frames that the cache has already.
    pub fn catch_up(&mut self, store: &Store, level: &str) {
        while self.unstored.is_empty() && self.has_next() {
            let key = self.record.key(self.keys.len() as u64, self.keys.last().copied(), level);
            if !store.contains(key) {
                break;
            }
            self.keys.push(key);
        }
    }

    /// Returns whether there is a next frame whose accelerations, if it needs some, are there.
    fn has_next(&self) -> bool {
        self.next() <= self.record.last() && !self.is_waiting_for_forces()
    }

    fn is_waiting_for_forces(&self) -> bool {
        let last = self.next().checked_sub(1);
        self.record.forced && last.is_some_and(|last| !self.record.forces.contains_key(&last))
    }

    /// Returns whether a worker can compute its next frame.
    pub fn is_ready(&self) -> bool {
        // A frame that is not stored yet cannot be read again.
        let has_last = self.unstored.is_empty() || self.live.is_some();
        self.work.is_none() && self.failure.is_none() && self.record.wish == Wish::Run && self.has_next() && has_last
    }

    /// Takes back the frames from `frame` on. A worker that computes a later one is asked to stop.
    pub fn cut(&mut self, frame: u64) {
        if self.next() > frame {
            self.unstored.truncate((frame as usize).saturating_sub(self.keys.len()));
            self.keys.truncate(frame as usize);
            self.live = None;
        }
        if let Some(work) = self.work.as_ref().filter(|work| work.frame >= frame) {
            work.stop.store(true, Ordering::Relaxed);
        }
    }

    /// Counts the seconds that a frame took.
    pub fn took(&mut self, seconds: f64) {
        self.pace = Some(self.pace.map_or(seconds, |pace| pace + WEIGHT * (seconds - pace)));
    }

    /// Returns what the scene is doing.
    pub fn activity(&self) -> Activity {
        let is_done = self.keys.len() as u64 > self.record.last();
        match self.record.wish {
            _ if self.failure.is_some() => Activity::Failed,
            Wish::Cancel => Activity::Cancelled,
            _ if is_done => Activity::Done,
            Wish::Pause => Activity::Paused,
            Wish::Run if self.is_waiting_for_forces() => Activity::Forces,
            Wish::Run => Activity::Running,
        }
    }

    /// Returns its status.
    pub fn status(&self) -> Status {
        let (ready, frames) = (self.keys.len() as u64, self.record.last() + 1);
        let fraction = self.work.as_ref().map_or(0.0, Work::fraction);
        let left = (frames.saturating_sub(ready) as f64 - f64::from(fraction)).max(0.0);
        Status {
            scene: self.record.name.clone(),
            state: self.activity(),
            ready,
            frames,
            fraction,
            seconds_left: self.pace.map(|pace| pace * left),
            particles: self.particles,
            error: self.failure.clone(),
        }
    }
}
