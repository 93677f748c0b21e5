//! Who computes which frame: workers take scenes in turn, one frame at a time.
//!
//! The next frame is one of the user who has used the fewest seconds of computation, and of that user's scenes the one whose
//! turn is longest ago. A user who comes back begins with no less than the busy users have used, so that nobody waits for
//! what others saved up.
//!
//! Each worker has a writer beside it, so that the next frame is computed while one is brought to the disk. Clients hear of a
//! frame when it is there.

use std::collections::{BTreeMap, HashMap};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, SyncSender};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use relievo_client::{Activity, Failure, FileMap, Hash, Status};
use relievo_core::{Context, Error, ErrorKind, Result};
use tokio::sync::watch;

use crate::kind::{Kind, Opening, Simulation};
use crate::library::Library;
use crate::metrics::Metrics;
use crate::options::Limits;
use crate::record::{Record, Segment, Wish};
use crate::scene::{Scene, Work};
use crate::store::Store;

/// A user and the name of one of the user's scenes.
pub type Id = (String, String);

/// The scenes of a server and the workers that compute their frames.
pub struct Scheduler {
    pub context: Context,
    pub store: Store,
    pub library: Library,
    pub limits: Limits,
    pub metrics: Metrics,
    kinds: Vec<Box<dyn Kind>>,
    records: PathBuf,
    state: Mutex<State>,
    /// Wakes workers.
    work: Condvar,
    /// Counts changes of scenes, for waiting threads.
    changes: watch::Sender<u64>,
}

#[derive(Default)]
struct State {
    scenes: BTreeMap<Id, Scene>,
    /// Seconds of computation that users have used.
    spent: HashMap<String, f64>,
    turn: u64,
    is_stopping: bool,
}

/// A frame to compute.
struct Job {
    id: Id,
    frame: u64,
    key: Hash,
    before: Option<Hash>,
    /// The frame before, where it is stored.
    pinned: Option<Hash>,
    force: Option<Hash>,
    kind: String,
    segment: Segment,
    files: FileMap,
    live: Option<Box<dyn Simulation>>,
    work: Work,
}

/// A frame for the disk.
pub struct Made {
    id: Id,
    key: Hash,
    content: Vec<u8>,
}

/// What became of it.
enum Outcome {
    /// It is computed and encoded.
    Made(Box<dyn Simulation>, Vec<u8>),
    /// The frame before it is no longer in the cache.
    Lost,
    /// The worker was asked to stop.
    Stopped,
    Failed(Error),
}

impl Scheduler {
    /// Returns the scheduler of the scenes that are recorded in the folder of the cache.
    pub fn open(context: Context, limits: Limits, kinds: Vec<Box<dyn Kind>>, cache: &std::path::Path) -> Result<Self> {
        let store = Store::open(cache, limits.cache)?;
        let library = Library::open(cache, limits.files)?;
        let records = cache.join("scenes");
        let mut state = State::default();
        for record in Record::all(&records)? {
            let mut scene = Scene::new(record);
            scene.catch_up(&store, context.level().name());
            let id = (scene.record.user.clone(), scene.record.name.clone());
            tracing::info!(user = id.0, scene = id.1, frames = scene.keys.len(), "took up a scene");
            state.scenes.insert(id, scene);
        }
        let (metrics, state) = (Metrics::default(), Mutex::new(state));
        let (work, changes) = (Condvar::new(), watch::Sender::new(0));
        Ok(Self { context, store, library, limits, metrics, kinds, records, state, work, changes })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns a receiver that hears of every change of a scene.
    pub fn changes(&self) -> watch::Receiver<u64> {
        self.changes.subscribe()
    }

    fn notify(&self) {
        self.changes.send_modify(|count| *count += 1);
        self.work.notify_all();
    }

    /// Returns a kind of simulations by its name.
    pub fn kind(&self, name: &str) -> Result<&dyn Kind> {
        let found = self.kinds.iter().find(|kind| kind.name() == name);
        found.map(|kind| &**kind).ok_or_else(|| {
            let names: Vec<_> = self.kinds.iter().map(|kind| kind.name()).collect();
            Error::unsupported(format!("the server makes no simulations of the kind {name:?}"))
                .advise(format!("ask for {}", names.join(" or ")))
        })
    }

    /// Returns the names of all kinds.
    pub fn kinds(&self) -> Vec<String> {
        self.kinds.iter().map(|kind| kind.name().to_owned()).collect()
    }

    /// Opens a simulation.
    fn open_simulation(
        &self,
        user: &str,
        kind: &str,
        description: &str,
        files: &FileMap,
    ) -> Result<Box<dyn Simulation>> {
        let files = Arc::new(self.library.files(user, files)?);
        let opening = Opening { description, files, elements: self.limits.particles };
        let simulation = self.kind(kind)?.open(&self.context, &opening)?;
        if simulation.last() >= self.limits.frames {
            let what = format!("{} frames are more than {}", simulation.last() + 1, self.limits.frames);
            return Err(Error::memory(what).at("frames").advise("simulate them in several scenes"));
        }
        Ok(simulation)
    }

    /// Opens a simulation of a scene that was submitted before. Fails where it would make other frames now, since the server
    /// has another device, other limits or another version.
    fn open_again(&self, user: &str, kind: &str, segment: &Segment, files: &FileMap) -> Result<Box<dyn Simulation>> {
        let simulation = self.open_simulation(user, kind, &segment.description, files)?;
        match simulation.identity() == segment.identity {
            true => Ok(simulation),
            false => Err(Error::unsupported("this server would make other frames than those that the scene has")
                .advise("start it with the same device, limits and version, or remove the scene and submit it again")),
        }
    }

    /// Adds a scene. Submitting the same again changes nothing. Fails where it cannot be simulated, another scene has its
    /// name, or the user has too many.
    pub fn submit(&self, user: &str, scene: &relievo_client::Submit) -> Result<Status> {
        let id = (user.to_owned(), scene.scene.clone());
        if let Some(there) = self.state().scenes.get(&id) {
            let Record { kind, files, forced, segments, .. } = &there.record;
            let theirs = (kind, files, *forced, &segments[0].description);
            return match theirs == (&scene.kind, &scene.files, scene.forced, &scene.description) {
                true => Ok(there.status()),
                false => Err(Error::invalid("another scene has this name")
                    .at(&scene.scene)
                    .advise("take another name, or remove that scene")),
            };
        }
        let simulation = self.open_simulation(user, &scene.kind, &scene.description, &scene.files)?;
        let segment = Segment {
            from: 0,
            description: scene.description.clone(),
            identity: simulation.identity().to_owned(),
            last: simulation.last(),
        };
        let record = Record::new(user, &scene.scene, &scene.kind, scene.files.clone(), scene.forced, segment);
        let mut added = Scene::new(record);
        added.particles = simulation.elements();
        added.live = Some(simulation);
        added.catch_up(&self.store, self.context.level().name());
        if !added.keys.is_empty() {
            added.live = None;
        }
        let mut state = self.state();
        if state.is_stopping {
            return Err(
                Error::new(ErrorKind::Busy, "the server is about to stop").advise("submit the scene again later")
            );
        }
        if state.scenes.keys().filter(|(owner, _)| owner == user).count() >= self.limits.scenes {
            return Err(Error::memory(format!("a user may have {} scenes", self.limits.scenes)).advise("remove some"));
        }
        if state.scenes.contains_key(&id) {
            return Err(Error::new(ErrorKind::Busy, "the scene is being submitted elsewhere").advise("submit it again"));
        }
        added.record.save(&self.records)?;
        state.wake_user(user);
        let status = added.status();
        tracing::info!(user, scene = scene.scene, frames = status.frames, particles = status.particles, "submitted");
        state.scenes.insert(id, added);
        drop(state);
        self.notify();
        Ok(status)
    }

    /// Does something with a scene. Fails if the user has none of the name.
    fn with<R>(&self, user: &str, name: &str, task: impl FnOnce(&mut Scene) -> Result<R>) -> Result<R> {
        let mut state = self.state();
        let scene = state.scenes.get_mut(&(user.to_owned(), name.to_owned()));
        task(scene.ok_or_else(|| {
            Error::new(ErrorKind::NotFound, "there is no such scene").at(name).advise("`scene.list` lists the scenes")
        })?)
    }

    /// Returns what a scene is doing.
    pub fn status(&self, user: &str, name: &str) -> Result<Status> {
        self.with(user, name, |scene| Ok(scene.status()))
    }

    /// Returns what the scenes of a user are doing.
    pub fn list(&self, user: &str) -> Vec<Status> {
        self.state().scenes.iter().filter(|((owner, _), _)| owner == user).map(|(_, scene)| scene.status()).collect()
    }

    /// Sets what the user wants of a scene.
    pub fn wish(&self, user: &str, name: &str, wish: Wish) -> Result<Status> {
        let status = self.with(user, name, |scene| {
            let mut record = scene.record.clone();
            record.wish = wish;
            record.save(&self.records)?;
            scene.record = record;
            match wish {
                Wish::Run => scene.failure = None,
                Wish::Cancel => {
                    scene.cut(scene.keys.len() as u64);
                    scene.live = None;
                    scene.work.iter().for_each(|work| work.stop.store(true, Ordering::Relaxed));
                }
                Wish::Pause => {}
            }
            Ok(scene.status())
        })?;
        if wish == Wish::Run {
            self.state().wake_user(user);
        }
        tracing::info!(user, scene = name, ?wish, "changed the state of a scene");
        self.notify();
        Ok(status)
    }

    /// Removes a scene and those of its files that no other scene of the user names. Its frames stay in the cache until
    /// room is needed.
    pub fn remove(&self, user: &str, name: &str) -> Result<()> {
        let mut state = self.state();
        let id = (user.to_owned(), name.to_owned());
        let scene =
            state.scenes.get(&id).ok_or_else(|| Error::new(ErrorKind::NotFound, "there is no such scene").at(name))?;
        scene.record.remove(&self.records)?;
        scene.work.iter().for_each(|work| work.stop.store(true, Ordering::Relaxed));
        let Record { mut files, forces, .. } = scene.record.clone();
        state.scenes.remove(&id);
        let others = || state.scenes.iter().filter(|((owner, _), _)| owner == user).map(|(_, scene)| &scene.record);
        files.retain(|_, hash| !others().any(|record| record.files.values().any(|other| other == hash)));
        let mut forces: Vec<Hash> = forces.into_values().collect();
        forces.retain(|hash| !others().any(|record| record.forces.values().any(|other| other == hash)));
        self.library.remove(user, &files, &forces);
        drop(state);
        tracing::info!(user, scene = name, "removed a scene");
        self.notify();
        Ok(())
    }

    /// Changes keys of a description after a frame: later frames are computed anew. The same change twice changes nothing.
    pub fn steer(&self, user: &str, name: &str, frame: u64, changes: &str) -> Result<Status> {
        let record = self.with(user, name, |scene| Ok(scene.record.clone()))?;
        let old = record.segment(frame + 1).description.clone();
        let description = self.kind(&record.kind)?.change(&old, changes)?;
        if description == old {
            return self.status(user, name);
        }
        let simulation = self.open_simulation(user, &record.kind, &description, &record.files)?;
        let segment =
            Segment { from: frame, description, identity: simulation.identity().to_owned(), last: simulation.last() };
        drop(simulation);
        let status = self.with(user, name, |scene| {
            if frame > scene.record.last() {
                return Err(Error::invalid(format!("frame {frame} is after the last one")).at(name));
            }
            let mut changed = scene.record.clone();
            changed.segments.retain(|segment| segment.from < frame || segment.from == 0 && frame > 0);
            if frame == 0 {
                // Frame 0 stays that of the first description.
                changed.segments = vec![scene.record.segments[0].clone()];
            }
            changed.segments.push(segment);
            changed.forces.retain(|at, _| *at <= frame);
            changed.save(&self.records)?;
            scene.record = changed;
            scene.failure = None;
            scene.cut(frame + 1);
            Ok(scene.status())
        })?;
        self.state().wake_user(user);
        tracing::info!(user, scene = name, frame, "steered");
        self.notify();
        Ok(status)
    }

    /// Takes a part of the accelerations on the way from a frame to the next. Returns how many bytes are there.
    pub fn force(&self, user: &str, name: &str, part: &relievo_client::Force) -> Result<Status> {
        let status = self.with(user, name, |scene| {
            let last = (scene.keys.len() as u64).checked_sub(1);
            if !scene.record.forced {
                return Err(Error::invalid("the scene takes no accelerations")
                    .at(name)
                    .advise("submit it with `forced`"));
            }
            if scene.record.forces.contains_key(&part.frame) {
                return Ok(scene.status());
            }
            if last != Some(part.frame) {
                return Err(Error::new(ErrorKind::Busy, format!("the scene is not at frame {}", part.frame)).at(name));
            }
            let count = scene.particles as usize;
            let (_, mut bytes) = scene.arriving.take().filter(|(at, _)| *at == part.frame).unwrap_or_default();
            if part.first.saturating_mul(12) == bytes.len() as u64 {
                if bytes.len() + part.accelerations.len() > 12 * count || !part.accelerations.len().is_multiple_of(12) {
                    return Err(
                        Error::invalid(format!("frame {} has {count} particles of 12 bytes", part.frame)).at(name)
                    );
                }
                bytes.extend_from_slice(&part.accelerations);
            }
            if bytes.len() < 12 * count {
                scene.arriving = Some((part.frame, bytes));
                return Ok(scene.status());
            }
            let mut record = scene.record.clone();
            record.forces.insert(part.frame, self.library.put_forces(user, &bytes)?);
            record.save(&self.records)?;
            scene.record = record;
            Ok(scene.status())
        })?;
        self.notify();
        Ok(status)
    }

    /// Returns the key of a frame. Fails if it is not stored.
    pub fn key(&self, user: &str, name: &str, frame: u64) -> Result<(Hash, String)> {
        self.with(user, name, |scene| {
            let at = |error: Error| Err(error.at(format!("{name}, frame {frame}")));
            if let Some(key) = usize::try_from(frame).ok().and_then(|frame| scene.keys.get(frame)) {
                return Ok((*key, scene.record.kind.clone()));
            }
            if frame > scene.record.last() {
                return at(Error::new(ErrorKind::NotFound, "the scene has no such frame"));
            }
            match (scene.activity(), &scene.failure) {
                (Activity::Failed, Some(failure)) => at(failure.clone().into()),
                _ => {
                    at(Error::new(ErrorKind::Busy, "the frame is not computed yet")
                        .advise("wait for it by `scene.wait`"))
                }
            }
        })
    }

    /// Takes back the frames from `frame` on, whose file is gone or damaged, so that it is computed again.
    pub fn lost(&self, user: &str, name: &str, frame: u64) {
        let cut = self.with(user, name, |scene| {
            scene.cut(frame);
            Ok(())
        });
        if cut.is_ok() {
            tracing::warn!(user, scene = name, frame, "computes a frame again that the cache no longer has");
            self.notify();
        }
    }

    /// Returns gauges of the scenes and the cache by their Prometheus names.
    pub fn gauges(&self) -> BTreeMap<&'static str, f64> {
        let (bytes, files) = self.store.size();
        let state = self.state();
        let count =
            |activity: Activity| state.scenes.values().filter(|scene| scene.activity() == activity).count() as f64;
        BTreeMap::from([
            ("relievo_scenes", state.scenes.len() as f64),
            ("relievo_scenes_running", count(Activity::Running)),
            ("relievo_scenes_failed", count(Activity::Failed)),
            (
                "relievo_simulations_in_memory",
                state.scenes.values().filter(|scene| scene.live.is_some()).count() as f64,
            ),
            ("relievo_cache_bytes", bytes as f64),
            ("relievo_cache_frames", files as f64),
        ])
    }

    /// Has workers return after the frames that they compute.
    pub fn stop(&self) {
        self.state().is_stopping = true;
        self.notify();
    }

    /// Computes frames and hands them to a writer, until the scheduler is stopped.
    pub fn run(&self, writer: &SyncSender<Made>) {
        while let Some(job) = self.next() {
            let begin = Instant::now();
            let Job { id, frame, key, pinned, work, .. } = &job;
            let (id, frame, key, pinned, work) = (id.clone(), *frame, *key, *pinned, work.clone());
            let outcome = catch_unwind(AssertUnwindSafe(|| self.compute(job)));
            let outcome = outcome.unwrap_or_else(|_| Outcome::Failed(Error::internal("the simulation panicked")));
            pinned.iter().for_each(|key| self.store.unpin(*key));
            if let Some(content) = self.settle(&id, (frame, key), &work, outcome, begin.elapsed().as_secs_f64()) {
                // The writer lives as long as its sender.
                let _ = writer.send(Made { id, key, content });
            }
        }
    }

    /// Stores frames until no worker hands any more.
    pub fn write(&self, frames: &Receiver<Made>) {
        while let Ok(Made { id, key, content }) = frames.recv() {
            let outcome = catch_unwind(AssertUnwindSafe(|| self.store.put(key, &content)));
            let outcome = outcome.unwrap_or_else(|_| Err(Error::internal("the cache panicked")));
            if let Err(error) = &outcome {
                tracing::error!(user = id.0, scene = id.1, %error, "a frame could not be stored");
            }
            if let Some(scene) = self.state().scenes.get_mut(&id) {
                scene.stored(key, outcome);
            }
            self.notify();
        }
    }

    /// Waits for a frame to compute; `None` when the scheduler is stopped.
    fn next(&self) -> Option<Job> {
        let mut state = self.state();
        loop {
            if state.is_stopping {
                return None;
            }
            let level = self.context.level().name();
            let mut caught_up = false;
            for scene in state.scenes.values_mut().filter(|scene| scene.is_ready()) {
                let before = scene.keys.len();
                scene.catch_up(&self.store, level);
                if scene.keys.len() > before {
                    (scene.live, caught_up) = (None, true);
                }
            }
            if caught_up {
                self.changes.send_modify(|count| *count += 1);
            }
            let spent = |user: &String| state.spent.get(user).copied().unwrap_or(0.0);
            let ready = state.scenes.iter().filter(|(_, scene)| scene.is_ready());
            let next = ready.min_by(|((a, _), first), ((b, _), second)| {
                spent(a).total_cmp(&spent(b)).then(first.turn.cmp(&second.turn))
            });
            let Some(id) = next.map(|(id, _)| id.clone()) else {
                state = self.work.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            state.turn += 1;
            let turn = state.turn;
            let scene = state.scenes.get_mut(&id)?;
            scene.turn = turn;
            let frame = scene.next();
            let (before, is_stored) = scene.last_key();
            let pinned = before.filter(|_| is_stored);
            let work = Work { frame, ..Work::default() };
            scene.work = Some(work.clone());
            pinned.iter().for_each(|key| self.store.pin(*key));
            return Some(Job {
                frame,
                key: scene.record.key(frame, before, level),
                before,
                pinned,
                force: frame.checked_sub(1).and_then(|frame| scene.record.forces.get(&frame).copied()),
                kind: scene.record.kind.clone(),
                segment: scene.record.segment(frame).clone(),
                files: scene.record.files.clone(),
                live: scene.live.take(),
                work,
                id,
            });
        }
    }

    fn compute(&self, job: Job) -> Outcome {
        let stop = job.work.stop.clone();
        match self.advance(job) {
            Ok(outcome) => outcome,
            Err(_) if stop.load(Ordering::Relaxed) => Outcome::Stopped,
            Err(error) => Outcome::Failed(error),
        }
    }

    /// Simulates and encodes a frame.
    fn advance(&self, job: Job) -> Result<Outcome> {
        let Job { id: (user, _), frame, before, force, kind, segment, files, live, work, .. } = job;
        let at = frame.saturating_sub(1);
        let live = live.filter(|live| live.identity() == segment.identity && live.frame() == at);
        let mut simulation = match (live, before) {
            (Some(live), _) => live,
            (None, None) => self.open_again(&user, &kind, &segment, &files)?,
            (None, Some(before)) => {
                let Ok(stored) = self.store.get(before) else { return Ok(Outcome::Lost) };
                let mut simulation = self.open_again(&user, &kind, &segment, &files)?;
                simulation.restore(&self.context, &stored)?;
                simulation
            }
        };
        if let Some(force) = force {
            simulation.accelerate(&self.library.forces(&user, force)?)?;
        }
        if frame > 0 {
            simulation.advance(&self.context, &mut |fraction| {
                work.fraction.store(fraction.to_bits(), Ordering::Relaxed);
                match work.stop.load(Ordering::Relaxed) {
                    true => Err(Error::new(ErrorKind::Cancelled, "the frame is no longer wanted")),
                    false => Ok(()),
                }
            })?;
        }
        if simulation.elements() > self.limits.particles {
            let what = format!("{} particles are more than {}", simulation.elements(), self.limits.particles);
            return Err(Error::memory(what).advise("give the fluid a budget or fewer emitters"));
        }
        let content = simulation.encode(&self.context)?;
        Ok(Outcome::Made(simulation, content))
    }

    /// Gives a scene back with what became of its frame. Returns the content that is to be stored.
    fn settle(
        &self,
        id: &Id,
        (frame, key): (u64, Hash),
        work: &Work,
        outcome: Outcome,
        seconds: f64,
    ) -> Option<Vec<u8>> {
        let mut made = None;
        let mut state = self.state();
        *state.spent.entry(id.0.clone()).or_default() += seconds;
        let is_stopped = work.stop.load(Ordering::Relaxed);
        // A scene that was removed meanwhile, or removed and submitted anew, is another one.
        let scene = state
            .scenes
            .get_mut(id)
            .filter(|it| it.work.as_ref().is_some_and(|its| Arc::ptr_eq(&its.stop, &work.stop)));
        if let Some(scene) = scene {
            scene.work = None;
            let is_next = !is_stopped && scene.next() == frame;
            match outcome {
                Outcome::Made(simulation, content) if is_next => {
                    scene.computed(key, simulation);
                    scene.took(seconds);
                    tracing::debug!(user = id.0, scene = id.1, frame, seconds, "computed a frame");
                    made = Some(content);
                }
                Outcome::Made(..) | Outcome::Stopped => {}
                Outcome::Lost if is_next => scene.cut(frame.saturating_sub(1)),
                Outcome::Lost => {}
                Outcome::Failed(error) => {
                    tracing::error!(user = id.0, scene = id.1, frame, %error, "the simulation failed");
                    scene.failure = Some(Failure::from(&error));
                }
            }
        }
        self.metrics.frames.add(1);
        self.metrics.microseconds.add((1e6 * seconds) as u64);
        state.bound_memory(self.limits.memory);
        drop(state);
        self.notify();
        made
    }
}

impl State {
    /// Raises what a user has spent to the least that busy users have, if the user was idle.
    fn wake_user(&mut self, user: &str) {
        let is_busy = |scene: &Scene| scene.work.is_some() || scene.is_ready();
        let mut busy: Vec<&String> =
            self.scenes.iter().filter(|(_, it)| is_busy(it)).map(|((user, _), _)| user).collect();
        busy.dedup();
        if busy.iter().any(|other| *other == user) {
            return;
        }
        let spent = |user: &String| self.spent.get(user).copied().unwrap_or(0.0);
        let least = busy.into_iter().map(spent).min_by(f64::total_cmp);
        if let Some(least) = least {
            let own = self.spent.entry(user.to_owned()).or_default();
            *own = own.max(least);
        }
    }

    /// Drops the simulations whose turn is longest ago until the others fit into the limit.
    fn bound_memory(&mut self, limit: u64) {
        loop {
            let live =
                || self.scenes.iter().filter_map(|(id, scene)| Some((scene.turn, id, scene.live.as_ref()?.memory())));
            if live().map(|(_, _, bytes)| bytes).sum::<u64>() <= limit {
                return;
            }
            let Some(oldest) = live().min().map(|(_, id, _)| id.clone()) else { return };
            if let Some(scene) = self.scenes.get_mut(&oldest) {
                scene.live = None;
            }
        }
    }
}
