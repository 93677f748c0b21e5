//! Frame after frame: physics, imprints, cache, pictures and meshes. Frame n is at n / fps seconds.
//!
//! Frames that the cache already has are opened, others are computed from the one before. Bodies are not cached: their
//! physics repeats itself exactly and is cheap, so it runs again from the start where it is needed.

use std::path::{Path, PathBuf};

use relievo_core::{Context, Error, Progress};
use relievo_detail::{DecayingObject, Volumes};
use relievo_gpu::Device;
use relievo_meshio::StageWriter;

use crate::format::description::Scene;
use crate::format::diagnostic::Failure;
use crate::out::blender;
use crate::out::export;
use crate::out::forecast;
use crate::out::output::Folder;
use crate::out::picture::Studio;
use crate::out::pictures::write_pictures;
use crate::out::povray;
use crate::out::stages::{self, Stages};
use crate::run::cache::{Cache, Frame, Identity, State};
use crate::run::foam;
use crate::run::folds;
use crate::run::refusals::Refusals;
use crate::run::simulate::{self, Changes, Simulator};
use crate::run::trace::Trace;
use crate::state::documents;
use crate::state::tissue;
use crate::state::world::{Item, World};

/// How a scene is run.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// The folder that everything is written to.
    pub out: PathBuf,
    /// First and last frame; all if left out.
    pub frames: Option<(u32, u32)>,
    /// Folders besides the scene's that files may be read from.
    pub allowed: Vec<PathBuf>,
    /// Whether cached frames are computed again.
    pub rebake: bool,
    /// The graphics device that makes imprints, evaluates dabs and draws pictures, as far as it can.
    pub device: Option<Device>,
}

/// What a run did.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    /// Files for the user, in the order written.
    pub files: Vec<PathBuf>,
    /// What each stage of each frame cost.
    pub trace: Trace,
    /// What the user should know.
    pub notes: Vec<String>,
    /// Frames that were computed.
    pub baked: u32,
    /// Frames that were opened from the cache.
    pub opened: u32,
    /// Bytes of allocated tiles at the end, and if all were.
    pub tile_bytes: [u64; 2],
    /// Allocated tiles at the end, and all there are.
    pub tiles: [u64; 2],
}

impl Summary {
    /// Returns the table of stages and the counts of frames, tiles and files as text; `out` is the folder that is named.
    pub fn report(&self, out: &Path) -> String {
        let mut text = self.trace.table();
        let [tiles, all_tiles] = self.tiles;
        let [bytes, all_bytes] = self.tile_bytes.map(|bytes| bytes as f64 / f64::from(1 << 20));
        text.push_str(&format!(
            "\nframes: {} computed, {} opened from the cache\n\
             tiles: {tiles} of {all_tiles} allocated, {bytes:.1} of {all_bytes:.1} MiB\n\
             files: {} in {}\n",
            self.baked,
            self.opened,
            self.files.len(),
            out.display()
        ));
        text
    }
}

/// The name of the cache's folder in the output folder.
pub const CACHE_FOLDER: &str = "cache";

/// Runs `scene`.
///
/// # Errors
/// Fails, leaving the frames before whole, with [`Failure::Scene`] if the scene cannot be used, and with
/// [`Failure::Other`] if the frames do not exist, a file cannot be read or written, memory or the room of the device
/// does not suffice, an edit cannot be made, or `progress` asks to stop.
pub fn run(
    context: &Context,
    scene: Scene,
    options: &RunOptions,
    progress: &mut dyn Progress,
) -> Result<Summary, Failure> {
    Run::prepare(context, scene, options, progress)?.finish(context, progress)
}

/// As [`run`], of frames as they are in the cache if all of them are, whatever computed them: another instruction level
/// or a graphics device.
///
/// # Errors
/// Fails as [`run`].
pub fn run_baked(
    context: &Context,
    scene: Scene,
    options: &RunOptions,
    progress: &mut dyn Progress,
) -> Result<Summary, Failure> {
    let mut run = Run::prepare(context, scene, options, progress)?;
    if !options.rebake {
        let (first, last) = run.frames;
        run.stepper.cache.adopt(first, last);
    }
    run.finish(context, progress)
}

/// A scene that was read, before its first frame.
#[derive(Debug)]
pub struct Run {
    stepper: Stepper,
    /// First and last.
    frames: (u32, u32),
    rebake: bool,
}

impl Run {
    /// Reads what `scene` needs.
    ///
    /// # Errors
    /// Fails as [`run`] does before its first frame.
    pub fn prepare(
        context: &Context,
        scene: Scene,
        options: &RunOptions,
        progress: &mut dyn Progress,
    ) -> Result<Self, Failure> {
        let last_frame = scene.output.frames - 1;
        let (first, last) = options.frames.unwrap_or((0, last_frame));
        if first > last || last > last_frame {
            return Err(Error::invalid(format!("there are no frames {first}..{last}"))
                .advise(format!("the scene has frames 0..{last_frame}"))
                .into());
        }
        progress.step(0.0, "load")?;
        let mut world = World::new(context, scene, &options.allowed)?;
        world.use_device(options.device.as_ref())?;
        let mut stepper = Stepper::new(context, world, &options.out)?;
        stepper.device = options.device.clone();
        stepper.summary.notes.extend(stepper.world.notes());
        Ok(Self { stepper, frames: (first, last), rebake: options.rebake })
    }

    /// Estimates the bytes of the meshes that the run writes, if objects stay as they are divided now. Where tiles get
    /// displacement in the run there are more; fluids are not counted.
    ///
    /// # Errors
    /// Fails if the vectors of an object do not fit its displacement.
    pub fn mesh_bytes(&self) -> relievo_core::Result<u64> {
        forecast::mesh_bytes(&self.stepper.world, self.frames)
    }

    /// Computes and writes the frames.
    ///
    /// # Errors
    /// Fails as [`run`].
    pub fn finish(self, context: &Context, progress: &mut dyn Progress) -> Result<Summary, Failure> {
        let Self { mut stepper, frames: (first, last), rebake } = self;
        let last_frame = stepper.world.scene.output.frames - 1;
        let start = stepper.begin(first, rebake)?;
        let load = context.stats().take();
        stepper.summary.trace.add(start, load);
        let count = f64::from(last - start + 1);
        for frame in start..=last {
            let done = f64::from(frame - start);
            progress.step((done / count) as f32, &format!("frame {frame}"))?;
            let changes = stepper.step(context, frame, rebake && frame >= first)?;
            if frame >= first {
                stepper.write(context, frame, last_frame, &changes)?;
            }
            stepper.summary.trace.add(frame, context.stats().take());
        }
        stepper.write_stages(context, progress)?;
        stepper.summary.trace.add(last, context.stats().take());
        stepper.note_folds(context)?;
        progress.step(1.0, "done")?;
        Ok(stepper.finish())
    }
}

/// What a graphics device adds to the instruction level, since its results differ in the last bit too.
const ON_DEVICE: u32 = 1 << 8;

/// A world on its way through the frames.
#[derive(Debug)]
pub struct Stepper {
    world: World,
    simulator: Simulator,
    cache: Cache,
    /// The cached form of the state the world is in.
    current: Option<Frame>,
    studio: Option<Studio>,
    /// What draws pictures, as long as it can.
    device: Option<Device>,
    /// Changes that no picture has shown yet.
    unseen: Vec<Changes>,
    folder: Folder,
    summary: Summary,
    refusals: Refusals,
    clamped: u64,
    volumes: Volumes,
    /// Sub-steps that colliders needed beyond their limit.
    missed: u64,
    /// Dabs of strokes that were too far from their surface.
    missed_dabs: u64,
    unstamped: u64,
    /// Tiles of layers that fade that made room for others.
    lost: u64,
    /// What is written when all frames are done.
    stages: Stages,
}

impl Stepper {
    /// A world before its first frame, whose files go to `out`.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if a folder cannot be made.
    pub fn new(context: &Context, mut world: World, out: &Path) -> relievo_core::Result<Self> {
        let folder = Folder::new(out)?;
        let level = context.level() as u32 | if world.is_on_device() { ON_DEVICE } else { 0 };
        world.keep_tissue(&folder.sub(CACHE_FOLDER)?)?;
        let identity = Identity { scene: world.fingerprint(), level };
        let cache = Cache::new(&folder.path().join(CACHE_FOLDER), identity)?;
        Ok(Self {
            world,
            simulator: Simulator::default(),
            cache,
            current: None,
            studio: None,
            device: None,
            unseen: Vec::new(),
            folder,
            summary: Summary::default(),
            refusals: Refusals::default(),
            clamped: 0,
            volumes: Volumes::default(),
            missed: 0,
            missed_dabs: 0,
            unstamped: 0,
            lost: 0,
            stages: Stages::default(),
        })
    }

    /// The world as it is.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The baked frames.
    pub fn cache(&self) -> &Cache {
        &self.cache
    }

    /// Decides at which frame to begin so that `first` can be reached: at `first` itself if the frame before is baked.
    /// A stale cache is emptied and said.
    fn begin(&mut self, first: u32, rebake: bool) -> relievo_core::Result<u32> {
        let stale = (0..self.world.scene.output.frames).any(|frame| self.cache.state(frame) == State::Stale);
        if stale {
            self.summary.notes.push(
                "the cache was baked from another version of the scene, at another instruction level or on another device; \
                 it is baked anew"
                    .into(),
            );
            self.cache.truncate(0)?;
        }
        let baked = |frame: u32| self.cache.state(frame) == State::Baked;
        let before = (0..first).rev().find(|frame| baked(*frame));
        let start = before.unwrap_or(0);
        let missing = before.map_or(0, |frame| frame + 1);
        if missing < first {
            let which = match first - missing {
                1 => format!("frame {missing} is not baked yet; it is"),
                _ => format!("frames {missing} to {} are not baked yet; they are", first - 1),
            };
            self.summary.notes.push(format!("{which} computed first"));
        }
        if rebake {
            self.cache.truncate(first)?;
            foam::truncate(&self.folder.sub(CACHE_FOLDER)?, first)?;
            tissue::truncate(&self.folder.sub(CACHE_FOLDER)?, first)?;
        }
        Ok(start.min(first))
    }

    /// Goes to `frame`, which must be the next one, or the first after [`Self::begin`]: opens it if it is baked, else
    /// computes it from the frame before.
    fn step(&mut self, context: &Context, frame: u32, rebake: bool) -> relievo_core::Result<Changes> {
        if !rebake && self.cache.state(frame) == State::Baked {
            let opened = context.stats().time("cache.open", || self.open(context, frame));
            match opened {
                Ok(changes) => return Ok(changes),
                Err(error) => self.summary.notes.push(format!("{error}; the frame is computed again")),
            }
        }
        let changes = if frame == 0 {
            self.simulator.start(context, &mut self.world)?
        } else {
            // After opened frames the bodies are still where they began.
            context.stats().time("physics.replay", || {
                while self.world.physics.frame() + 1 < frame {
                    self.world.physics.advance();
                }
            });
            self.simulator.advance(context, &mut self.world, frame)?
        };
        let _stage = context.stats().begin("cache.write");
        let blocks = simulate::blocks(context, &self.world, &changes)?;
        let baked = self.cache.write(context, frame, self.world.transforms(), self.current.as_ref(), &blocks)?;
        self.current = Some(baked);
        self.summary.baked += 1;
        self.refusals.merge(&changes.refusals);
        self.clamped += changes.report.clamped;
        self.volumes += changes.report.volumes;
        self.missed += changes.report.sub_steps_wanted.saturating_sub(changes.report.sub_steps);
        self.missed_dabs += changes.strokes.missed;
        self.unstamped += changes.unstamped;
        self.lost += changes.lost;
        Ok(changes)
    }

    /// Opens a baked frame, whichever frame the world is at.
    ///
    /// # Errors
    /// Fails as [`Cache::open`] and [`simulate::restore`].
    pub fn open(&mut self, context: &Context, frame: u32) -> relievo_core::Result<Changes> {
        let opened = self.cache.open(context, frame)?;
        let changes = simulate::restore(context, &mut self.world, &opened, self.current.as_ref())?;
        self.current = Some(opened);
        self.summary.opened += 1;
        Ok(changes)
    }

    /// Writes what the scene asks for at `frame`.
    fn write(&mut self, context: &Context, frame: u32, last: u32, changes: &Changes) -> relievo_core::Result<()> {
        let output = &self.world.scene.output;
        let (pictures, mesh, tiles) = (output.picture_frames, output.mesh, output.tiles);
        let documents = output.documents;
        if pictures.includes(frame, last) && !output.pictures.is_empty() && !output.images.is_empty() {
            let drawn = self.draw(context, frame, changes);
            let written = match (drawn, self.device.take()) {
                (Err(fault), Some(_)) => {
                    let note = format!("pictures are drawn by the processor from frame {frame} on: {fault}");
                    self.summary.notes.push(note);
                    self.studio = None;
                    self.draw(context, frame, changes)?
                }
                (drawn, device) => {
                    self.device = device;
                    drawn?
                }
            };
            self.summary.files.extend(written);
        } else if self.studio.is_some() {
            self.unseen.push(changes.clone());
        }
        if mesh.includes(frame, last) {
            self.summary.files.extend(export::write_meshes(context, &self.world, &self.folder, frame)?);
            self.stages.note(&self.world, frame)?;
        }
        if tiles.includes(frame, last) {
            self.summary.files.extend(export::write_tiles(context, &self.world, &self.folder, frame)?);
        }
        if documents.includes(frame, last) {
            self.summary.files.extend(documents::write(context, &self.world, &self.folder, frame)?);
        }
        if self.world.scene.output.povray.includes(frame, last) {
            self.summary.files.push(povray::write(context, &self.world, &self.folder, frame)?);
        }
        if self.world.scene.output.blender.includes(frame, last) {
            self.summary.files.extend(blender::write(context, &self.world, &self.folder, frame)?);
        }
        Ok(())
    }

    /// Writes the pictures of `frame` and returns their files.
    fn draw(&mut self, context: &Context, frame: u32, changes: &Changes) -> relievo_core::Result<Vec<PathBuf>> {
        let studio = match &mut self.studio {
            Some(studio) => studio,
            none => {
                let cache = self.folder.sub(CACHE_FOLDER)?;
                none.insert(Studio::new(context, &self.world, self.device.as_ref(), &cache)?)
            }
        };
        for unseen in self.unseen.drain(..) {
            studio.update(context, &self.world, &unseen.for_pictures())?;
        }
        studio.update(context, &self.world, &changes.for_pictures())?;
        let written = write_pictures(context, &self.world, studio, &self.folder, frame);
        self.summary.notes.extend(studio.take_notes());
        written
    }

    /// Writes the stage of all frames, which are opened again from the cache; the world already is in the last.
    fn write_stages(&mut self, context: &Context, progress: &mut dyn Progress) -> relievo_core::Result<()> {
        let stages = std::mem::take(&mut self.stages);
        let count = stages.frames().len();
        if count == 0 {
            return Ok(());
        }
        let mut writer = StageWriter::new(&stages::options(&self.world.scene), context.memory_limit())?;
        for (index, frame) in stages.frames().iter().enumerate() {
            progress.step(index as f32 / count as f32, &format!("mesh of frame {frame}"))?;
            if count > 1 {
                let opened = self.cache.open(context, *frame)?;
                simulate::restore(context, &mut self.world, &opened, self.current.as_ref())?;
                self.current = Some(opened);
            }
            stages.add(context, &self.world, *frame, &mut writer)?;
        }
        self.summary.files.push(stages.finish(writer, &self.folder)?);
        Ok(())
    }

    /// Notes which surfaces are folded in the last frame.
    fn note_folds(&mut self, context: &Context) -> relievo_core::Result<()> {
        for (index, folded) in folds::count(context, &self.world)? {
            let name = self.world.scene.objects.get(index).map_or("", |entry| entry.name.text.as_str());
            self.summary.notes.push(format!(
                "object `{name}` is folded: {folded}; press less deep there, or lower `max_displacement`"
            ));
        }
        Ok(())
    }

    fn finish(mut self) -> Summary {
        self.summary.notes.extend(self.world.take_tissue_notes());
        self.summary.notes.extend(self.refusals.notes(&self.world));
        self.summary.notes.extend(self.world.take_device_faults());
        if self.clamped > 0 {
            self.summary.notes.push(format!(
                "{} times a surface could not give way far enough; raise `max_displacement` of the collider",
                self.clamped
            ));
        }
        if self.missed > 0 {
            self.summary.notes.push(format!(
                "colliders moved too fast for their limit {} times, so trails may have gaps; raise `sub_steps` of [imprints]",
                self.missed
            ));
        }
        if self.volumes.pushed > 0.0 {
            let Volumes { pushed, raised } = self.volumes;
            let share = 100.0 * raised / pushed;
            self.summary.notes.push(format!(
                "imprints pushed {pushed:.4} cubic units of the surfaces away, of which {raised:.4} ({share:.0} %) rose as rims"
            ));
        }
        if self.unstamped > 0 {
            self.summary.notes.push(format!(
                "edits of {} tiles will not fade: their time stamps exceed the budget; raise `budget` of `detail`",
                self.unstamped
            ));
        }
        if self.lost > 0 {
            self.summary.notes.push(format!(
                "{} tiles of layers that fade were lost before their time, the oldest first, to make room for newer ones; \
                 raise `budget` of `detail`",
                self.lost
            ));
        }
        if self.missed_dabs > 0 {
            self.summary.notes.push(format!(
                "{} dabs of strokes were too far from their surface and left out; move the points or raise `reach`",
                self.missed_dabs
            ));
        }
        for item in self.world.items() {
            if let Item::Triangles(item) = item {
                let object = &item.object;
                let faces = object.surface().topology().face_count() as u64;
                let displacement = object.displacement();
                let paint = object.paint().map(|it| (it.bytes(), it.full_bytes(), it.allocated_count()));
                let halves = object.half_paint().map(|it| (it.bytes(), it.full_bytes(), it.allocated_count()));
                let traces = object.traces().map(|it| (it.bytes(), it.full_bytes(), it.allocated_count()));
                let vectors = object.vectors().map(|it| (it.bytes(), it.full_bytes(), it.allocated_count()));
                let own = (displacement.bytes(), displacement.full_bytes(), displacement.allocated_count());
                self.summary.tile_bytes[0] += object.stamp_bytes();
                let channels = [Some(own), paint, halves, traces, vectors].into_iter();
                for (bytes, full, count) in channels.flatten() {
                    self.summary.tile_bytes[0] += bytes;
                    self.summary.tile_bytes[1] += full;
                    self.summary.tiles[0] += count as u64;
                    self.summary.tiles[1] += faces;
                }
            }
            if let Item::Surface(surface) = item {
                let displacement = surface.displacement();
                self.summary.tile_bytes[0] += displacement.bytes();
                self.summary.tile_bytes[1] += displacement.full_bytes();
                self.summary.tiles[0] += displacement.field().allocated().count() as u64;
                self.summary.tiles[1] += displacement.field().tile_count() as u64;
                if let Some(paint) = surface.paint() {
                    self.summary.tile_bytes[0] += paint.bytes();
                    self.summary.tile_bytes[1] += paint.full_bytes();
                    self.summary.tiles[0] += paint.allocated_count() as u64;
                    self.summary.tiles[1] += paint.field().tile_count() as u64;
                }
                if let Some(paint) = surface.half_paint() {
                    self.summary.tile_bytes[0] += paint.bytes();
                    self.summary.tile_bytes[1] += paint.full_bytes();
                    self.summary.tiles[0] += paint.allocated_count() as u64;
                    self.summary.tiles[1] += paint.field().tile_count() as u64;
                }
                if let Some(vectors) = surface.vectors() {
                    self.summary.tile_bytes[0] += vectors.bytes();
                    self.summary.tile_bytes[1] += vectors.full_bytes();
                    self.summary.tiles[0] += vectors.allocated_count() as u64;
                    self.summary.tiles[1] += vectors.field().tile_count() as u64;
                }
                self.summary.tile_bytes[0] += surface.stamp_bytes();
                if let Some(traces) = surface.traces() {
                    self.summary.tile_bytes[0] += traces.bytes();
                    self.summary.tile_bytes[1] += traces.full_bytes();
                    self.summary.tiles[0] += traces.allocated_count() as u64;
                    self.summary.tiles[1] += traces.field().tile_count() as u64;
                }
            }
        }
        self.summary
    }
}
