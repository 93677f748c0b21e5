//! What the methods of the protocol do.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use relievo_client::*;
use relievo_core::{Error, Result, file};
use relievo_particleio::Particles as Decoded;
use serde::Serialize;

use crate::decoded;
use crate::metrics;
use crate::record::Wish;
use crate::scheduler::Scheduler;

/// The methods, for the users that connections introduced.
pub struct Service {
    pub scheduler: Arc<Scheduler>,
    decoded: decoded::Decoded,
    /// Held while a surface is made: one at a time, each once.
    surfaces: Mutex<()>,
}

/// A call of a user.
pub struct Call<'a> {
    pub user: &'a str,
    pub id: u32,
    pub method: &'a str,
    pub parameters: &'a [u8],
}

/// The name of the channel of positions, of which every frame has one.
const POSITION: &str = "position";
/// The name of the channel of numbers, by which particles are found again in other frames.
const NUMBER: &str = "number";

/// Returns whether a method answers without reading or computing anything large.
pub fn is_quick(method: &str) -> bool {
    matches!(method, "scene.status" | "scene.list" | "stats" | "ping")
}

/// Fails unless a name of a scene is 1 to [`MAX_NAME`] bytes without control characters. It never becomes a path.
fn check_name(name: &str) -> Result<()> {
    match name.is_empty() || name.len() > MAX_NAME || name.chars().any(char::is_control) {
        true => {
            Err(Error::invalid(format!("the name of a scene has 1 to {MAX_NAME} bytes, and no control characters")))
        }
        false => Ok(()),
    }
}

impl Service {
    /// Returns the methods of a scheduler.
    pub fn new(scheduler: Arc<Scheduler>) -> Self {
        let decoded = decoded::Decoded::new(scheduler.limits.decoded);
        Self { scheduler, decoded, surfaces: Mutex::default() }
    }

    /// Calls a method and returns the response message. `hello` and `scene.wait` are those of the connection.
    pub fn call(&self, call: &Call<'_>) -> Result<Vec<u8>> {
        let Call { user, id, method, parameters } = *call;
        let scheduler = &self.scheduler;
        fn named<T: serde::de::DeserializeOwned>(bytes: &[u8]) -> Result<T> {
            relievo_client::parameters(bytes)
        }
        fn answer(id: u32, result: &impl Serialize) -> Result<Vec<u8>> {
            response(id, result)
        }
        let wish = |wish: Wish| {
            let SceneName { scene } = named(parameters)?;
            answer(id, &scheduler.wish(user, &scene, wish)?)
        };
        match method {
            "ping" => answer(id, &Nothing {}),
            "stats" => answer(id, &Stats { values: self.values() }),
            "file.missing" => {
                let FileList { files } = named(parameters)?;
                answer(id, &FileList { files: scheduler.library.missing(user, &files)? })
            }
            "file.put" => answer(id, &FilePutResult { received: scheduler.library.put(user, &named(parameters)?)? }),
            "scene.submit" => {
                let scene: Submit = named(parameters)?;
                check_name(&scene.scene)?;
                answer(id, &scheduler.submit(user, &scene)?)
            }
            "scene.list" => answer(id, &SceneList { scenes: scheduler.list(user) }),
            "scene.status" => {
                let SceneName { scene } = named(parameters)?;
                answer(id, &scheduler.status(user, &scene)?)
            }
            "scene.pause" => wish(Wish::Pause),
            "scene.resume" => wish(Wish::Run),
            "scene.cancel" => wish(Wish::Cancel),
            "scene.remove" => {
                let SceneName { scene } = named(parameters)?;
                scheduler.remove(user, &scene)?;
                answer(id, &Nothing {})
            }
            "scene.steer" => {
                let Steer { scene, frame, changes } = named(parameters)?;
                answer(id, &scheduler.steer(user, &scene, frame, &changes)?)
            }
            "scene.force" => {
                let part: Force = named(parameters)?;
                answer(id, &scheduler.force(user, &part.scene, &part)?)
            }
            "frame.info" => answer(id, &self.info(user, &named(parameters)?)?),
            "frame.fetch" => answer(id, &self.fetch(user, &named(parameters)?)?),
            "frame.surface" => answer(id, &self.surface(user, &named(parameters)?)?),
            "frame.file" => answer(id, &self.file(user, &named(parameters)?)?),
            other => Err(Error::unsupported(format!("there is no method {other:?}"))
                .advise("see docs/protocol.md for the methods of this version")),
        }
    }

    /// Returns counters and gauges by their Prometheus names.
    pub fn values(&self) -> std::collections::BTreeMap<String, f64> {
        let all = self.scheduler.metrics.values().into_iter().chain(self.scheduler.gauges());
        all.map(|(name, value)| (name.to_owned(), value)).collect()
    }

    /// Returns counters and gauges as Prometheus reads them.
    pub fn metrics(&self) -> String {
        metrics::text(&self.values())
    }

    /// Returns the particles of a frame that are wanted, and the frame's key.
    fn particles(&self, user: &str, scene: &str, frame: u64, wanted: Particles) -> Result<(Arc<Decoded>, Hash)> {
        let scheduler = &self.scheduler;
        let (key, kind) = scheduler.key(user, scene, frame)?;
        let kind = scheduler.kind(&kind)?;
        let read = || {
            let stored = self.stored(user, (scene, frame), scheduler.store.get(key))?;
            kind.particles(&scheduler.context, &stored)
        };
        let all = || self.decoded.get(key, Particles::All, read);
        let particles = match wanted {
            Particles::All => all()?,
            wanted => self.decoded.get(key, wanted, || kind.select(&scheduler.context, &*all()?, wanted))?,
        };
        Ok((particles, key))
    }

    /// Returns what was read from the cache. Where it is gone or damaged, the frame is computed again, and the error says
    /// to wait.
    fn stored<T>(&self, user: &str, (scene, frame): (&str, u64), read: Result<T>) -> Result<T> {
        read.map_err(|error| {
            self.scheduler.lost(user, scene, frame);
            Error::new(relievo_core::ErrorKind::Busy, format!("the frame is computed again: {}", error.what))
                .at(format!("{scene}, frame {frame}"))
                .advise("wait for it by `scene.wait`")
        })
    }

    fn info(&self, user: &str, name: &FrameName) -> Result<FrameInfo> {
        let (particles, key) = self.particles(user, &name.scene, name.frame, Particles::All)?;
        let mut channels = vec![ChannelInfo { name: POSITION.into(), width: 3 }];
        channels.extend(particles.numbers.iter().map(|_| ChannelInfo { name: NUMBER.into(), width: 1 }));
        let others = particles.channels.iter();
        channels.extend(others.map(|it| ChannelInfo { name: it.name.clone(), width: it.width }));
        let bytes = self.stored(user, (&name.scene, name.frame), self.scheduler.store.content_size(key))?;
        Ok(FrameInfo {
            count: particles.points.len() as u64,
            seconds: particles.time.unwrap_or_default(),
            spacing: particles.spacing.unwrap_or_default(),
            channels,
            key: key.to_string(),
            bytes,
        })
    }

    fn fetch(&self, user: &str, fetch: &Fetch) -> Result<Chunk> {
        let (particles, key) = self.particles(user, &fetch.scene, fetch.frame, fetch.particles)?;
        let total = particles.points.len();
        let first = usize::try_from(fetch.first).unwrap_or(usize::MAX).min(total);
        let count = if fetch.count == 0 { MAX_CHUNK } else { fetch.count.min(MAX_CHUNK) };
        let range = first..(first + count as usize).min(total);
        let layout = match (fetch.differences, fetch.packing) {
            (true, _) => Layout::Differences,
            (false, Packing::None) => Layout::Rows,
            (false, _) => Layout::Planes,
        };
        let is_wanted = |name: &str| fetch.channels.is_empty() || fetch.channels.iter().any(|wanted| wanted == name);
        let mut columns = Vec::new();
        let floats = |name: &str, width: u32, values: &[f32]| {
            let words = range.start * width as usize..range.end * width as usize;
            Column::of_floats(name, width, &values[words], fetch.half, layout, fetch.packing)
        };
        if is_wanted(POSITION) {
            columns.push(floats(POSITION, 3, particles.points.as_flattened())?);
        }
        if let Some(numbers) = particles.numbers.as_ref().filter(|_| is_wanted(NUMBER)) {
            columns.push(Column::of_integers(NUMBER, &numbers[range.clone()], layout, fetch.packing)?);
        }
        for channel in particles.channels.iter().filter(|channel| is_wanted(&channel.name)) {
            columns.push(floats(&channel.name, channel.width, &channel.values)?);
        }
        let (first, count, total) = (first as u64, range.len() as u32, total as u64);
        Ok(Chunk { first, count, total, key: key.to_string(), columns })
    }

    fn file(&self, user: &str, part: &FilePart) -> Result<FilePartResult> {
        let (key, _) = self.scheduler.key(user, &part.scene, part.frame)?;
        let length = (part.length as usize).min(MAX_PART);
        let read = self.scheduler.store.part(key, part.offset, length);
        let (data, size) = self.stored(user, (&part.scene, part.frame), read)?;
        Ok(FilePartResult { size, key: key.to_string(), data })
    }

    /// Returns a part of the surface of a frame, which is made if the cache does not have it.
    fn surface(&self, user: &str, part: &SurfacePart) -> Result<FilePartResult> {
        let SurfacePart { scene, frame, form, settings, offset, length } = part;
        if settings.len() > MAX_SETTINGS {
            return Err(Error::invalid(format!("the settings have more than {MAX_SETTINGS} bytes")).at("settings"));
        }
        let scheduler = &self.scheduler;
        let (of, kind) = scheduler.key(user, scene, *frame)?;
        let (kind, store) = (scheduler.kind(&kind)?, &scheduler.store);
        let mut hasher = Hasher::default();
        let name = format!("relievo surface 1 {form:?} {}", scheduler.context.level().name());
        [name.as_bytes(), &of.0, settings.as_bytes()].into_iter().for_each(|part| hasher.add_part(part));
        let key = hasher.finish();
        let make = || {
            let _turn = self.surfaces.lock().unwrap_or_else(PoisonError::into_inner);
            if store.contains(key) {
                return Ok(());
            }
            let stored = self.stored(user, (scene, *frame), store.get(of))?;
            let path = store.scratch();
            let made = kind
                .surface(&scheduler.context, &stored, (*form, settings), &path)
                .and_then(|()| file::load(&path, scheduler.context.memory_limit()));
            // What cannot be removed now is removed when the cache is opened next.
            let _ = std::fs::remove_file(&path);
            store.put(key, &made?)
        };
        let read = || store.part(key, *offset, (*length as usize).min(MAX_PART));
        // A file that turns out to be damaged is removed from the cache, and made again.
        make()?;
        let found = match read() {
            Err(_) if !store.contains(key) => make().and_then(|()| read()),
            found => found,
        };
        let (data, size) = found?;
        Ok(FilePartResult { size, key: key.to_string(), data })
    }

    /// Waits for a frame, or until its scene stops, at most as long as the parameters say.
    pub async fn wait(&self, user: &str, parameters: &[u8]) -> Result<Status> {
        let Wait { scene, frame, seconds } = relievo_client::parameters(parameters)?;
        let seconds = if seconds > 0.0 { seconds.min(MAX_WAIT) } else { 0.0 };
        let end = Instant::now() + Duration::from_secs_f64(seconds);
        let mut changes = self.scheduler.changes();
        loop {
            let status = self.scheduler.status(user, &scene)?;
            let is_waiting = matches!(status.state, Activity::Running | Activity::Forces);
            let left = end.saturating_duration_since(Instant::now());
            if status.ready > frame || !is_waiting || left.is_zero() {
                return Ok(status);
            }
            // Whether it changed or the time is over, the status says.
            let _ = tokio::time::timeout(left, changes.changed()).await;
        }
    }
}
