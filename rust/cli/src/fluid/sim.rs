//! `relievo fluid sim`

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::ValueEnum;
use relievo_core::{Context, Error, Progress, Result, file};
use relievo_fluid::{Checkpoint, StepStatistics, Totals};
use relievo_particleio::{Format, FrameNumber, frames, path, read_frame, write, write_frame};
use relievo_simulation::{Description, Making, Simulation};

use super::files::beside;
use super::statistics::{NAME, Row, Statistics};
use crate::Outcome;
use crate::args::device::{Adapter, Device};
use crate::args::limits::Limits;

/// The name of the file that a run goes on from whose frames have no state.
const CHECKPOINT: &str = "checkpoint";

#[derive(clap::Args)]
pub struct Arguments {
    /// What is simulated: a fluid, and what it meets, in TOML. `relievo fluid info` says what it begins as.
    description: PathBuf,
    /// The folder for the frames: `0000.rlvfluid` is what the fluid begins as. Where a run was interrupted, it goes on
    /// from the last frame there.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// The format of the frames.
    #[arg(long, value_enum, default_value_t = FrameFormat::Cache)]
    format: FrameFormat,
    /// Files a frame: with 4, `0001.250.rlvfluid` follows `0001.000.rlvfluid`.
    #[arg(long, value_name = "NUMBER", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    sub_frames: u32,
    /// Begins anew, in place of the frames that are there.
    #[arg(long)]
    restart: bool,
    /// What makes the steps. A graphics device has blocks, fills, basins, colliders and forces, but no bodies, emitters and
    /// sinks.
    #[arg(long, value_enum, default_value = "cpu")]
    device: Device,
    #[command(flatten)]
    adapter: Adapter,
    #[command(flatten)]
    limits: Limits,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub enum FrameFormat {
    /// Frames of a cache, `.rlvfluid`, compressed, from which a run goes on.
    Cache,
    /// Houdini's classic geometry.
    Bgeo,
    /// VTK's legacy form.
    Vtk,
    /// PLY.
    Ply,
    /// OpenVDB's points.
    Vdb,
}

impl FrameFormat {
    pub fn format(self) -> Format {
        match self {
            Self::Cache => Format::Cache,
            Self::Bgeo => Format::Bgeo,
            Self::Vtk => Format::Vtk,
            Self::Ply => Format::Ply,
            Self::Vdb => Format::Vdb,
        }
    }
}

/// A folder of frames, and how its files are written.
struct Folder<'a> {
    path: &'a Path,
    format: Format,
    parts: u32,
    /// What the frames are of.
    identity: String,
    spacing: f32,
}

impl Folder<'_> {
    fn file(&self, step: u64) -> PathBuf {
        path(self.path, step, self.parts, self.format)
    }

    /// The number of a frame.
    fn number(&self, step: u64) -> String {
        FrameNumber::of_step(step, self.parts).to_string()
    }

    /// The file from which a run in another format goes on.
    fn checkpoint(&self) -> PathBuf {
        self.path.join(CHECKPOINT).with_extension(Format::Cache.extension())
    }

    /// Writes a frame, and what a run goes on from.
    fn store(&self, context: &Context, simulation: &Simulation) -> Result<()> {
        let (checkpoint, step) = (simulation.checkpoint(), simulation.step());
        let mut particles = checkpoint.state.particles(self.spacing);
        let state = checkpoint.encode();
        if self.format == Format::Cache {
            return write_frame(context, &self.file(step), &particles, Some(&state));
        }
        // The frame comes first: with a checkpoint there is a frame.
        let unsorted = particles.clone();
        particles.sort();
        write(context, &self.file(step), &particles)?;
        write_frame(context, &self.checkpoint(), &unsorted, Some(&state))
    }

    /// The last whole frame from which a run may go on. A damaged one is left out, with a note.
    fn last(&self, context: &Context) -> Result<Option<Checkpoint>> {
        let files: Vec<PathBuf> = match self.format {
            Format::Cache => {
                let files = frames(self.path)?.into_iter().rev().map(|(_, path)| path);
                files.filter(|path| Format::named(path) == Ok(Format::Cache)).collect()
            }
            _ => Some(self.checkpoint()).into_iter().filter(|path| path.exists()).collect(),
        };
        for path in files {
            let named = |error: Error| error.at(path.display().to_string());
            let bytes = file::load(&path, context.memory_limit())?;
            let frame = match read_frame(context, &bytes) {
                Ok(frame) => frame,
                Err(error) if error.kind == relievo_core::ErrorKind::Invalid => {
                    eprintln!("note: {}", named(error));
                    continue;
                }
                Err(error) => return Err(named(error)),
            };
            let level = frame.level.clone();
            let other = |what: &str, advice: &str| {
                let what = format!("frames {what} are there");
                Err(named(
                    Error::invalid(what)
                        .advise(format!("{advice}, or name another folder, or begin anew by --restart")),
                ))
            };
            let Some(checkpoint) = Checkpoint::of(frame).map_err(named)? else {
                return other("that no simulation can go on from", "move them");
            };
            if checkpoint.identity != self.identity {
                // Where the description is the same, it is a file that it names.
                let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
                let (theirs, ours) = (lines(&checkpoint.identity), lines(&self.identity));
                let changed =
                    ours.iter().filter(|line| !theirs.contains(line)).filter_map(|line| line.splitn(3, ' ').nth(2));
                if let (true, Some(name)) = (theirs.first() == ours.first(), changed.into_iter().next()) {
                    return other(
                        &format!("made with another {name}"),
                        "take the file that it was, and those that it names",
                    );
                }
                return other("of another description, of another format or of other sub-frames", "take that one");
            }
            if level != context.level().name() {
                return other(&format!("of the instruction level {level}"), &format!("set RELIEVO_SIMD={level}"));
            }
            return Ok(Some(checkpoint));
        }
        Ok(None)
    }

    /// Removes frames that are there.
    fn clear(&self) -> Result<()> {
        let frames = frames(self.path)?.into_iter().map(|(_, path)| path);
        for path in frames.chain([self.checkpoint(), self.path.join(NAME)]).filter(|path| path.exists()) {
            std::fs::remove_file(&path).map_err(|error| Error::io(&path, &error))?;
        }
        Ok(())
    }
}

/// A run whose frames go to a folder.
pub struct Run<'a> {
    /// The file of the description, beside which the files are that it names.
    pub file: &'a Path,
    /// The folder of the frames.
    pub output: &'a Path,
    /// The format of the frames.
    pub format: Format,
    /// Files a frame.
    pub parts: u32,
    /// Whether it begins anew in place of the frames that are there.
    pub restarts: bool,
    /// What makes the steps in place of the processor.
    pub device: Option<relievo_gpu::Device>,
}

/// What a run did.
pub struct Done {
    /// Particles at the end.
    pub count: usize,
    /// Metres between them at rest.
    pub spacing: f32,
    /// Frames after the first.
    pub frames: u32,
    /// Steps of the solver.
    pub totals: Totals,
}

impl Run<'_> {
    /// Computes the frames that are missing, and reports progress after each step of the solver. Prints what the user should
    /// know. Cancelled, it leaves the frames before whole.
    pub fn go(&self, context: &Context, description: Description, progress: &mut dyn Progress) -> Result<Done> {
        let named = |error: Error| error.at(self.file.display().to_string());
        let (frames, spacing) = (description.frames, description.spacing());
        let making =
            Making { format: self.format.extension().to_owned(), parts: self.parts, device: self.device.clone() };
        let files = beside(self.file);
        let mut simulation = Simulation::begin(context, description, &files, making).map_err(named)?;
        if simulation.fluid().is_empty() && simulation.emitters() == 0 {
            let path = self.file.display();
            eprintln!("note: {path}: there is no fluid; give it a block, a fill or an emitter");
        }
        let folder = Folder {
            path: self.output,
            format: self.format,
            parts: self.parts,
            identity: simulation.identity().to_owned(),
            spacing,
        };
        std::fs::create_dir_all(folder.path).map_err(|error| Error::io(folder.path, &error))?;
        if self.restarts {
            folder.clear()?;
        }
        let last = folder.last(context)?;
        let mut statistics = Statistics::open(folder.path, last.as_ref().map_or(0, |last| last.step as usize + 1))?;
        match last {
            Some(last) => {
                simulation.restore(last)?;
                eprintln!("note: goes on from {}", folder.file(simulation.step()).display());
            }
            None => {
                let fluid = simulation.fluid();
                let row = Row { particles: fluid.len(), energy: fluid.kinetic_energy(), ..Row::default() };
                statistics.add("0", &row)?;
                folder.store(context, &simulation)?;
            }
        }
        let share = |step: u64, last: u64| step as f32 / last.max(1) as f32;
        while simulation.step() < simulation.last() {
            let begin = Instant::now();
            let mut row = Row::default();
            let (before, step, last) = (simulation.totals().steps, simulation.step(), simulation.last());
            simulation.advance(context, |done: &StepStatistics| {
                row.add(done);
                progress.step(share(step, last), &format!("after {} steps", before + row.steps))
            })?;
            let fluid = simulation.fluid();
            (row.seconds, row.particles, row.energy) = (fluid.seconds(), fluid.len(), fluid.kinetic_energy());
            row.duration = begin.elapsed().as_secs_f64();
            // The row comes first: where a frame is there its row is, and later ones are dropped.
            statistics.add(&folder.number(simulation.step()), &row)?;
            folder.store(context, &simulation)?;
            progress.step(share(simulation.step(), last), &format!("after {} steps", before + row.steps))?;
        }
        Ok(Done { count: simulation.fluid().len(), spacing, frames, totals: simulation.totals() })
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let description = Description::read(&arguments.description)?;
    let run = Run {
        file: &arguments.description,
        output: &arguments.output,
        format: arguments.format.format(),
        parts: arguments.sub_frames,
        restarts: arguments.restart,
        device: arguments.adapter.open(arguments.device, arguments.limits.memory_limit)?,
    };
    let length = u64::from(description.frames) * u64::from(arguments.sub_frames);
    let done = run.go(&context, description, &mut super::frames::FrameBar::new(length)?)?;
    let Totals { steps, corrections, most } = done.totals;
    crate::print(&format!(
        "{} particles {} m apart, {} frames in {steps} steps with {corrections} corrections, at most {:.2} % too dense\n",
        done.count,
        done.spacing,
        done.frames,
        100.0 * most
    ))?;
    Ok(ExitCode::SUCCESS)
}
