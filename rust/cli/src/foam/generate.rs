//! `relievo foam generate`

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use glam::DVec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, ErrorKind, Result, file};
use relievo_fluid::{
    Diffuse, DiffuseOptions, DiffuseReport, DiffuseSettings, FluidFrame, positions_and_velocities,
};
use relievo_particleio::{Format, FrameNumber, Particles, frames, read_frame, write, write_frame};

use crate::Outcome;
use crate::fluid::FrameFormat;
use crate::limits::Limits;
use crate::numbers::{numbers, vector};

/// The name of the file that a run goes on from whose frames have no state.
const CHECKPOINT: &str = "checkpoint";
/// Bytes from the beginning of a frame that say whether it is the same as before: caches have their checksums there.
const HEAD: u64 = 1 << 16;

#[derive(clap::Args)]
pub struct Arguments {
    /// The folder of the fluid's frames, in any format of particles, with velocities or with numbers.
    frames: PathBuf,
    /// The folder for the frames of foam, which have the names of the fluid's.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// The format of the frames.
    #[arg(long, value_enum, default_value_t = FrameFormat::Cache)]
    format: FrameFormat,
    /// Begins anew, in place of the frames that are there.
    #[arg(long)]
    restart: bool,
    /// Frames a second, where the files have no time.
    #[arg(long, default_value_t = 24.0)]
    fps: f64,
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    limits: Limits,
}

/// The settings of diffuse particles.
#[derive(clap::Args)]
struct Options {
    /// Distance between particles of the fluid at rest, in metres; without it, what the files say.
    #[arg(long, value_name = "METRES")]
    spacing: Option<f32>,
    /// Acceleration of spray, in m/s².
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, default_value = "0,0,-9.81")]
    gravity: DVec3,
    /// Limits of the potential of trapped air, in m/s.
    #[arg(long, value_name = "LOW,HIGH", value_parser = pair, default_value = "5,20")]
    trapped_air: Pair,
    /// Limits of the potential of wave crests.
    #[arg(long, value_name = "LOW,HIGH", value_parser = pair, default_value = "2,8")]
    crests: Pair,
    /// Limits of the kinetic energy of a kilogram, in J.
    #[arg(long, value_name = "LOW,HIGH", value_parser = pair, default_value = "5,50")]
    energy: Pair,
    /// Particles a second that a particle of the fluid makes at most by trapped air.
    #[arg(long, default_value_t = 4000.0)]
    air_rate: f32,
    /// Particles a second that a particle of the fluid makes at most in crests.
    #[arg(long, default_value_t = 4000.0)]
    crest_rate: f32,
    /// Seconds that foam of the least and of the greatest potential lives.
    #[arg(long, value_name = "SHORT,LONG", value_parser = pair, default_value = "2,5")]
    lifetime: Pair,
    /// A particle with fewer neighbours in the fluid is spray.
    #[arg(long, default_value_t = 6)]
    spray_below: u32,
    /// A particle with more neighbours in the fluid is a bubble.
    #[arg(long, default_value_t = 20)]
    bubbles_above: u32,
    /// How much faster bubbles rise than bodies fall.
    #[arg(long, default_value_t = 2.0)]
    buoyancy: f32,
    /// The share of the difference to the fluid's velocity that bubbles lose in a step.
    #[arg(long, default_value_t = 0.8)]
    drag: f32,
    /// Steps a frame.
    #[arg(long, default_value_t = 2)]
    steps: u32,
    /// The box outside of which particles are removed: two corners.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, num_args = 2)]
    bounds: Option<Vec<DVec3>>,
    /// Particles at a time at most; further ones are not made, and are counted.
    #[arg(long, default_value_t = 100_000_000)]
    most: u32,
    /// The seed of all that is random.
    #[arg(long, default_value_t = 1)]
    seed: u32,
}

/// Two numbers.
#[derive(Clone, Copy, Debug)]
struct Pair([f32; 2]);

fn pair(text: &str) -> std::result::Result<Pair, String> {
    numbers(text).map(|pair: [f64; 2]| Pair(pair.map(|number| number as f32)))
}

impl Options {
    /// Returns the settings for frames like this one. Fails if nothing gives the spacing.
    fn diffuse(&self, particles: &Particles) -> Result<DiffuseOptions> {
        let spacing = self.spacing.or(particles.spacing).ok_or_else(|| {
            Error::invalid("the file does not say how far particles are apart").advise("give --spacing")
        })?;
        let [Pair([air_min, air_max]), Pair([crest_min, crest_max])] = [self.trapped_air, self.crests];
        let [Pair([energy_min, energy_max]), Pair([lifetime_min, lifetime_max])] = [self.energy, self.lifetime];
        let settings = DiffuseSettings {
            air_min,
            air_max,
            crest_min,
            crest_max,
            energy_min,
            energy_max,
            air_rate: self.air_rate,
            crest_rate: self.crest_rate,
            lifetime_min,
            lifetime_max,
            spray_below: self.spray_below,
            bubbles_above: self.bubbles_above,
            buoyancy: self.buoyancy,
            drag: self.drag,
            steps: self.steps,
            most: self.most,
            seed: self.seed,
        };
        let bounds = self.bounds.as_deref().and_then(|corners| match corners {
            [low, high] => Some([low.as_vec3(), high.as_vec3()]),
            _ => None,
        });
        Ok(DiffuseOptions { spacing, gravity: self.gravity.as_vec3(), bounds, settings })
    }
}

/// The folder of the frames of foam.
struct Folder<'a> {
    path: &'a Path,
    format: Format,
}

impl Folder<'_> {
    /// Returns the file of the frame of foam that belongs to one of the fluid.
    fn file(&self, fluid: &Path) -> PathBuf {
        let stem = fluid.file_stem().unwrap_or_default().to_string_lossy();
        self.path.join(format!("{stem}.{}", self.format.extension()))
    }

    /// Returns the file from which a run in another format than the cache goes on.
    fn checkpoint(&self) -> PathBuf {
        self.path.join(CHECKPOINT).with_extension(Format::Cache.extension())
    }

    /// Writes a frame, and what a run goes on from.
    fn store(&self, context: &Context, fluid: &Path, particles: &Particles, state: &[u8]) -> Result<()> {
        if self.format == Format::Cache {
            return write_frame(context, &self.file(fluid), particles, Some(state));
        }
        // The frame comes first: with a checkpoint there is a frame.
        write(context, &self.file(fluid), particles)?;
        write_frame(context, &self.checkpoint(), particles, Some(state))
    }

    /// Returns the run after the last whole frame, and the number of frames it has behind it. Damaged frames are left out,
    /// with a note. Fails if a frame is of other settings or of other frames of the fluid.
    fn last(
        &self,
        context: &Context,
        options: &DiffuseOptions,
        identities: &[String],
        fluid: &[(FrameNumber, PathBuf)],
    ) -> Result<Option<(Diffuse, usize)>> {
        let files: Vec<PathBuf> = match self.format {
            Format::Cache => fluid.iter().rev().map(|(_, path)| self.file(path)).collect(),
            _ => vec![self.checkpoint()],
        };
        for path in files.into_iter().filter(|path| path.exists()) {
            let named = |error: Error| error.at(path.display().to_string());
            let frame = match read_frame(context, &file::load(&path, context.memory_limit())?) {
                Ok(frame) => frame,
                Err(error) if error.kind == ErrorKind::Invalid => {
                    eprintln!("note: {}", named(error));
                    continue;
                }
                Err(error) => return Err(named(error)),
            };
            let resumed = Diffuse::resume(*options, &frame).map_err(named)?;
            let fits = |(identity, run): &(String, Diffuse)| {
                identities.get(run.progress().0 as usize).is_some_and(|expected| expected == identity)
            };
            let Some((_, run)) = resumed.filter(fits) else {
                return Err(named(
                    Error::invalid("frames of other settings or of another fluid are there")
                        .advise("take those, or name another folder, or begin anew by --restart"),
                ));
            };
            let done = run.progress().0 as usize + 1;
            eprintln!("note: goes on from {}", path.display());
            return Ok(Some((run, done)));
        }
        Ok(None)
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let fluid = frames(&arguments.frames)?;
    let Some((_, first)) = fluid.first() else {
        return Err(Error::invalid("there are no frames in the folder")
            .at(arguments.frames.display().to_string())
            .advise("frames are called `0000.rlvfluid`, or `0000.250.ply`")
            .into());
    };
    if !(arguments.fps > 0.0 && arguments.fps.is_finite()) {
        return Err(Error::invalid(format!("there cannot be {} frames a second", arguments.fps)).at("--fps").into());
    }
    let mut before = crate::fluid::read(&context, first)?;
    let options = arguments.options.diffuse(&before).map_err(|error| error.at(first.display().to_string()))?;
    let folder = Folder { path: &arguments.output, format: arguments.format.format() };
    std::fs::create_dir_all(folder.path).map_err(|error| Error::io(folder.path, &error))?;
    let identities = identities(&format!("{options:?}, {} frames a second", arguments.fps), &fluid)?;
    let resumed = match arguments.restart {
        true => None,
        false => folder.last(&context, &options, &identities, &fluid)?,
    };
    let (mut diffuse, done) = match resumed {
        Some((diffuse, done)) => (diffuse, done),
        None => (Diffuse::new(options)?, 0),
    };
    let bar = crate::fluid::bar(fluid.len() as u64)?.with_position(done as u64);
    bar.reset_eta();
    let mut total = DiffuseReport::default();
    for (number, (frame_number, path)) in fluid.iter().enumerate().skip(done) {
        let named = |error: Error| error.at(path.display().to_string());
        let seconds = |particles: &Particles| particles.time.unwrap_or(frame_number.0 as f64 / 1000.0 / arguments.fps);
        let time = if number == 0 {
            seconds(&before)
        } else {
            if number == done && number > 1 {
                before = crate::fluid::read(&context, &fluid[number - 1].1)?;
            }
            let after = crate::fluid::read(&context, path)?;
            let step = match (before.time, after.time) {
                (Some(before), Some(after)) => after - before,
                _ => (frame_number.0 - fluid[number - 1].0.0) as f64 / 1000.0 / arguments.fps,
            };
            let (positions, velocities) = positions_and_velocities(&before, &after, step as f32).map_err(named)?;
            let frame = FluidFrame { positions: &positions, velocities: &velocities };
            let report = diffuse.advance(&context, frame, step as f32, &mut Silent).map_err(named)?;
            total.born += report.born;
            total.gone += report.gone;
            total.refused += report.refused;
            let time = seconds(&after);
            before = after;
            time
        };
        let particles = diffuse.particles().to_file(time, options.spacing).map_err(named)?;
        folder.store(&context, path, &particles, &diffuse.state(&identities[number]))?;
        bar.set_message(format!("{} particles", diffuse.particles().len()));
        bar.inc(1);
    }
    bar.finish_and_clear();
    if total.refused > 0 {
        eprintln!("note: {} particles were not made: there may be {} at a time", total.refused, options.settings.most);
    }
    crate::print(&format!(
        "{} frames, {} particles in the last, {} born and {} gone\n",
        fluid.len(),
        diffuse.particles().len(),
        total.born,
        total.gone
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// Returns what a run is of after each frame: its settings, and a checksum of the beginnings of all files so far.
fn identities(settings: &str, fluid: &[(FrameNumber, PathBuf)]) -> Result<Vec<String>> {
    let mut checksum = 0;
    let mut identities = Vec::with_capacity(fluid.len());
    for (_, path) in fluid {
        let failed = |error: std::io::Error| Error::io(path, &error);
        let opened = file::open(path)?;
        let length = opened.metadata().map_err(failed)?.len();
        let mut head = Vec::new();
        opened.take(HEAD).read_to_end(&mut head).map_err(failed)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let text = format!("{checksum} {name} {length} {}", crc32fast::hash(&head));
        checksum = crc32fast::hash(text.as_bytes());
        identities.push(format!("{settings}, of {checksum:08x}"));
    }
    Ok(identities)
}
