//! `relievo foam generate`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use glam::DVec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, ErrorKind, Progress, Result, file};
use relievo_fluid::{Diffuse, DiffuseOptions, DiffuseReport, DiffuseSettings, FluidFrame, positions_and_velocities};
use relievo_particleio::{Format, FrameNumber, Particles, frames, read_frame, write, write_frame};
use relievo_scene::foam::Identity;

use crate::Outcome;
use crate::args::limits::Limits;
use crate::args::numbers::vector;
use crate::fluid::FrameFormat;

/// The name of the file that a run goes on from whose frames have no state.
const CHECKPOINT: &str = "checkpoint";

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

/// The fluid, and the settings of diffuse particles.
#[derive(clap::Args)]
struct Options {
    /// Distance between particles of the fluid at rest, in metres; without it, what the files say.
    #[arg(long, value_name = "METRES")]
    spacing: Option<f32>,
    /// Acceleration of spray, in m/s².
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, default_value = "0,0,-9.81")]
    gravity: DVec3,
    /// The box outside of which particles are removed: two corners.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, num_args = 2)]
    bounds: Option<Vec<DVec3>>,
    #[command(flatten)]
    settings: Settings,
}

/// The options of [`DiffuseSettings::entries`], whose names have `-` in place of `_`.
#[derive(Clone, Copy)]
struct Settings(DiffuseSettings);

impl clap::Args for Settings {
    fn augment_args(command: clap::Command) -> clap::Command {
        DiffuseSettings::entries().into_iter().fold(command, |command, entry| {
            let default: Vec<String> = entry.fields.iter().map(|field| field.default.to_string()).collect();
            let units: Vec<_> = entry.fields.iter().map(|field| field.unit).filter(|unit| !unit.is_empty()).collect();
            let help = entry.help.trim_end_matches('.');
            let help = units.first().map_or(help.to_owned(), |unit| format!("{help} ({unit})"));
            let value_name = if entry.fields.len() == 2 { "LOW,HIGH" } else { "NUMBER" };
            // The command keeps the names and defaults of options for as long as the program runs.
            let (long, default): (&'static str, &'static str) =
                (entry.name.replace('_', "-").leak(), default.join(",").leak());
            command.arg(
                clap::Arg::new(entry.name)
                    .long(long)
                    .value_name(value_name)
                    .value_parser(list)
                    .default_value(default)
                    .help(help),
            )
        })
    }

    fn augment_args_for_update(command: clap::Command) -> clap::Command {
        Self::augment_args(command)
    }
}

impl clap::FromArgMatches for Settings {
    fn from_arg_matches(matches: &clap::ArgMatches) -> std::result::Result<Self, clap::Error> {
        let mut settings = Self(DiffuseSettings::default());
        settings.update_from_arg_matches(matches)?;
        Ok(settings)
    }

    fn update_from_arg_matches(&mut self, matches: &clap::ArgMatches) -> std::result::Result<(), clap::Error> {
        for entry in DiffuseSettings::entries() {
            let Some(List(values)) = matches.get_one(entry.name) else { continue };
            let refused =
                |error: Error| clap::Error::raw(clap::error::ErrorKind::ValueValidation, format!("{error}\n"));
            self.0.set_entry(entry.name, values).map_err(refused)?;
        }
        Ok(())
    }
}

/// Numbers with commas between them.
#[derive(Clone, Debug)]
struct List(Vec<f64>);

fn list(text: &str) -> std::result::Result<List, String> {
    let number = |part: &str| part.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    let values: Option<_> = text.split(',').map(number).collect();
    values.map(List).ok_or_else(|| format!("{text:?} is not a number, or numbers with commas between them"))
}

impl Options {
    /// Returns the settings for frames like this one. Fails if nothing gives the spacing.
    fn diffuse(&self, particles: &Particles) -> Result<DiffuseOptions> {
        let spacing = self.spacing.or(particles.spacing).ok_or_else(|| {
            Error::invalid("the file does not say how far particles are apart").advise("give --spacing")
        })?;
        let bounds = self.bounds.as_deref().and_then(|corners| match corners {
            [low, high] => Some([low.as_vec3(), high.as_vec3()]),
            _ => None,
        });
        Ok(DiffuseOptions { spacing, gravity: self.gravity.as_vec3(), bounds, settings: self.settings.0 })
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

/// A run whose frames of foam go to a folder.
pub struct Run<'a> {
    /// The fluid's frames in order.
    pub fluid: &'a [(FrameNumber, PathBuf)],
    /// The folder that they are in.
    pub folder: &'a Path,
    /// The folder of the frames of foam.
    pub output: &'a Path,
    /// The format of the frames.
    pub format: Format,
    /// Whether it begins anew in place of the frames that are there.
    pub restarts: bool,
    /// Frames a second, where the files have no time.
    pub fps: f64,
}

/// What a run did.
pub struct Done {
    /// Frames there are.
    pub frames: usize,
    /// Particles in the last one.
    pub count: usize,
    /// What became of particles in the frames that were made.
    pub report: DiffuseReport,
    /// Particles there may be at a time.
    pub most: u32,
}

impl Run<'_> {
    fn output(&self) -> Folder<'_> {
        Folder { path: self.output, format: self.format }
    }

    /// Says what decides the particles besides the fluid's frames.
    fn settings(&self, options: &DiffuseOptions) -> String {
        format!("{options:?}, {} frames a second", self.fps)
    }

    /// Returns whether the first frame of foam that is there was made with these settings, of this fluid; `None` without
    /// one.
    #[cfg(feature = "view")]
    pub fn fits(&self, context: &Context, options: &DiffuseOptions) -> Result<Option<bool>> {
        let Some((_, first)) = self.fluid.first() else { return Ok(None) };
        let path = self.output().file(first);
        if !path.exists() {
            return Ok(None);
        }
        let Ok(frame) = read_frame(context, &file::load(&path, context.memory_limit())?) else {
            return Ok(Some(false));
        };
        let expected = identities(&self.settings(options), &self.fluid[..1])?;
        let resumed = Diffuse::resume(*options, &frame).ok().flatten();
        Ok(Some(resumed.is_some_and(|(identity, _)| expected.contains(&identity))))
    }

    /// Removes the frames of foam that are there.
    #[cfg(feature = "view")]
    pub fn clear(&self) -> Result<()> {
        let folder = self.output();
        let files = self.fluid.iter().map(|(_, path)| folder.file(path)).filter(|path| path.exists());
        files.into_iter().try_for_each(|path| std::fs::remove_file(&path).map_err(|error| Error::io(&path, &error)))
    }

    /// Makes the frames that are missing; `choose` returns the settings for frames like the first. Cancelled, it leaves the
    /// frames before whole.
    pub fn go(
        &self,
        context: &Context,
        choose: &dyn Fn(&Particles) -> Result<DiffuseOptions>,
        progress: &mut dyn Progress,
    ) -> Result<Done> {
        let fluid = self.fluid;
        let Some((_, first)) = fluid.first() else {
            return Err(Error::invalid("there are no frames in the folder")
                .at(self.folder.display().to_string())
                .advise("frames are called `0000.rlvfluid`, or `0000.250.ply`"));
        };
        let mut before = crate::fluid::read(context, first)?;
        let options = choose(&before).map_err(|error| error.at(first.display().to_string()))?;
        let folder = self.output();
        std::fs::create_dir_all(folder.path).map_err(|error| Error::io(folder.path, &error))?;
        let identities = identities(&self.settings(&options), fluid)?;
        let resumed = match self.restarts {
            true => None,
            false => folder.last(context, &options, &identities, fluid)?,
        };
        let (mut diffuse, done) = match resumed {
            Some((diffuse, done)) => (diffuse, done),
            None => (Diffuse::new(options)?, 0),
        };
        let mut total = DiffuseReport::default();
        for (number, (frame_number, path)) in fluid.iter().enumerate().skip(done) {
            let share = number as f32 / fluid.len() as f32;
            progress.step(share, &format!("{} particles", diffuse.particles().len()))?;
            let named = |error: Error| error.at(path.display().to_string());
            let seconds = |particles: &Particles| particles.time.unwrap_or(frame_number.0 as f64 / 1000.0 / self.fps);
            let time = if number == 0 {
                seconds(&before)
            } else {
                if number == done && number > 1 {
                    before = crate::fluid::read(context, &fluid[number - 1].1)?;
                }
                let after = crate::fluid::read(context, path)?;
                let step = match (before.time, after.time) {
                    (Some(before), Some(after)) => after - before,
                    _ => (frame_number.0 - fluid[number - 1].0.0) as f64 / 1000.0 / self.fps,
                };
                let (positions, velocities) = positions_and_velocities(&before, &after, step as f32).map_err(named)?;
                let frame = FluidFrame { positions: &positions, velocities: &velocities };
                let report = diffuse.advance(context, frame, step as f32, &mut Silent).map_err(named)?;
                total.born += report.born;
                total.gone += report.gone;
                total.refused += report.refused;
                let time = seconds(&after);
                before = after;
                time
            };
            let particles = diffuse.particles().to_file(time, options.spacing).map_err(named)?;
            folder.store(context, path, &particles, &diffuse.state(&identities[number]))?;
        }
        progress.report(1.0, &format!("{} particles", diffuse.particles().len()));
        let count = diffuse.particles().len();
        Ok(Done { frames: fluid.len(), count, report: total, most: options.settings.most })
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    if !(arguments.fps > 0.0 && arguments.fps.is_finite()) {
        return Err(Error::invalid(format!("there cannot be {} frames a second", arguments.fps)).at("--fps").into());
    }
    let fluid = frames(&arguments.frames)?;
    let run = Run {
        fluid: &fluid,
        folder: &arguments.frames,
        output: &arguments.output,
        format: arguments.format.format(),
        restarts: arguments.restart,
        fps: arguments.fps,
    };
    let mut bar = crate::fluid::FrameBar::new(fluid.len() as u64)?;
    let done = run.go(&context, &|first| arguments.options.diffuse(first), &mut bar)?;
    drop(bar);
    let DiffuseReport { born, gone, refused, .. } = done.report;
    if refused > 0 {
        eprintln!("note: {refused} particles were not made: there may be {} at a time", done.most);
    }
    crate::print(&format!(
        "{} frames, {} particles in the last, {born} born and {gone} gone\n",
        done.frames, done.count
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// Returns what a run is of after each frame: its settings, and a checksum of the beginnings of all files so far.
fn identities(settings: &str, fluid: &[(FrameNumber, PathBuf)]) -> Result<Vec<String>> {
    let mut identity = Identity::new(settings.to_owned());
    fluid.iter().map(|(_, path)| identity.add(path)).collect()
}
