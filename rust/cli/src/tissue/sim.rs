//! `relievo tissue sim`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::ValueEnum;
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Mesh, Result};
use relievo_scene::tissue::Motion;
use relievo_tissue::{SavedState, Simulation};

use super::Limits;
use crate::Outcome;
use crate::args::device::{Adapter, Device};
use crate::bar::Bar;

const EXAMPLE: &str = "Example: relievo tissue sim examples/tissue/press.toml -o frames\n\n\
    A run that was interrupted goes on from the last frame in the folder.";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// What is simulated, in TOML: a model, what moves it, and frames (see `docs/tissue.md`).
    description: PathBuf,
    /// The folder for the frames: `0000.rtstate` is how it begins.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Writes the bound surfaces of each frame too, as `NAME.0000.ply` or another format of meshes.
    #[arg(long, value_enum, value_name = "FORMAT")]
    surfaces: Option<MeshFormat>,
    /// Writes each frame for VTK too, as `0000.vtu`, with stress, strain and contact pressure.
    #[arg(long)]
    vtu: bool,
    /// Writes grids of each frame for OpenVDB too, as `0000.vdb`: materials, stresses and volumes of the elements at rest.
    #[arg(long)]
    vdb: bool,
    /// Begins anew, in place of the frames that are there.
    #[arg(long)]
    restart: bool,
    /// What takes the steps. A graphics device has elements, muscles, moved nodes, floors and balls; what it does not do, the
    /// processor does.
    #[arg(long, value_enum, default_value = "cpu")]
    device: Device,
    #[command(flatten)]
    adapter: Adapter,
    #[command(flatten)]
    limits: Limits,
}

#[derive(Clone, Copy, ValueEnum)]
enum MeshFormat {
    /// Polygon file format.
    Ply,
    /// Wavefront.
    Obj,
    /// Binary glTF.
    Glb,
}

impl MeshFormat {
    fn extension(self) -> &'static str {
        match self {
            Self::Ply => "ply",
            Self::Obj => "obj",
            Self::Glb => "glb",
        }
    }
}

/// Returns the file of a frame.
fn frame_path(folder: &Path, frame: u32) -> PathBuf {
    folder.join(format!("{frame:04}.rtstate"))
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let motion = Motion::read(&arguments.description)?;
    let named = |error: Error| error.at(arguments.description.display().to_string());
    let model = super::model(&context, &motion.model())?;
    let identity = motion.identity(&context, &model).map_err(named)?;
    let mut simulation = motion.begin(&context, model).map_err(named)?;
    let device = arguments.adapter.open(arguments.device, arguments.limits.memory_limit)?;
    simulation.use_device(device.as_ref());
    if let Some(reason) = simulation.device_refusal() {
        eprintln!("note: the processor takes the steps, for {reason}");
        simulation.use_device(None);
    }
    let level = match simulation.has_device() {
        true => format!("{} with a graphics device", context.level().name()),
        false => context.level().name().to_owned(),
    };
    let folder = &arguments.output;
    std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, &error))?;
    let steps = simulation.steps().clone();
    let added = if steps.added_mass > 0.0 {
        format!(", {:.2} % of mass added", 100.0 * steps.added_mass)
    } else {
        String::new()
    };
    crate::print(&format!(
        "{} elements, steps of {:.4e} s (stable to {:.4e} s by element {}){added}\n",
        simulation.model().elements.len(),
        steps.step,
        steps.stable,
        steps.element
    ))?;
    let mut first = 0;
    match last(&context, arguments, (identity, &level))? {
        Some((frame, saved)) => {
            first = frame;
            simulation.set_state(saved.state)?;
            eprintln!("note: goes on from {}", frame_path(folder, frame).display());
        }
        None => {
            if motion.relax {
                let relaxation = simulation.relax(&context, 1e-3, 20_000, &mut Bar::new())?;
                let [unbalanced, most] = relaxation.unbalanced;
                let how = if relaxation.is_at_rest { "at rest" } else { "not yet at rest" };
                let steps = relaxation.steps;
                crate::print(&format!("{how} after {steps} steps, {unbalanced:.2e} N of {most:.2e} N unbalanced\n"))?;
            }
            store(&context, arguments, (identity, &level), &simulation, 0)?;
        }
    }
    let bar = crate::fluid::bar(u64::from(motion.frames))?.with_position(u64::from(first));
    bar.reset_eta();
    for frame in first + 1..=motion.frames {
        let end = f64::from(frame) / motion.fps;
        // A whole number of steps that ends at or just after the frame.
        let left = (end - simulation.state().seconds) / f64::from(steps.step);
        let outcome = simulation.advance(&context, (left - 1e-6).ceil().max(0.0) as u64, &mut Silent);
        outcome.map_err(|error| error.at(format!("frame {frame}")))?;
        if let Some(fault) = simulation.take_device_fault() {
            // Its frames would not be those of one executor.
            return Err(fault
                .at(format!("frame {frame}"))
                .advise("go on with --restart on another device, or on the processor")
                .into());
        }
        store(&context, arguments, (identity, &level), &simulation, frame)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let energies = simulation.energies(&context)?;
    crate::print(&format!(
        "{} frames in {} steps; {:.3e} J of motion, {:.3e} J of deformation\n",
        motion.frames,
        simulation.state().steps,
        energies.kinetic,
        energies.elastic
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// Writes a frame and what was asked for beside it.
fn store(
    context: &Context,
    arguments: &Arguments,
    (identity, level): (u32, &str),
    simulation: &Simulation,
    frame: u32,
) -> Result<()> {
    let folder = &arguments.output;
    if let Some(format) = arguments.surfaces {
        for binding in &simulation.model().bindings {
            let points = binding.points(context, simulation.model(), &simulation.state().displacements);
            let name: String =
                binding.name.chars().map(|letter| if letter.is_alphanumeric() { letter } else { '_' }).collect();
            let path = folder.join(format!("{name}.{frame:04}.{}", format.extension()));
            relievo_meshio::write(&path, &Mesh::from_triangles(points, &binding.triangles))?;
        }
    }
    if arguments.vtu {
        let states = simulation.element_states(context)?;
        let pressures = simulation.contact_pressures(context)?;
        simulation.write_vtu(&folder.join(format!("{frame:04}.vtu")), &states, &pressures)?;
    }
    if arguments.vdb {
        let states = simulation.element_states(context)?;
        simulation.write_vdb(context, &folder.join(format!("{frame:04}.vdb")), &states)?;
    }
    // The frame comes last: where it is, what belongs to it is there too.
    SavedState { identity, level: level.to_owned(), state: simulation.state().clone() }
        .write(&frame_path(folder, frame))
}

/// Returns the last whole frame in the folder. Fails if it is of another simulation.
fn last(context: &Context, arguments: &Arguments, (identity, level): (u32, &str)) -> Result<Option<(u32, SavedState)>> {
    let folder = &arguments.output;
    let entries = std::fs::read_dir(folder).map_err(|error| Error::io(folder, &error))?;
    let number = |path: PathBuf| path.file_stem()?.to_str()?.parse::<u32>().ok();
    let frames = entries.filter_map(|entry| entry.ok().map(|entry| entry.path()));
    let mut frames: Vec<u32> = frames.filter(|path| super::is_named(path, "rtstate")).filter_map(number).collect();
    frames.sort_unstable();
    if arguments.restart {
        for path in frames.iter().map(|frame| frame_path(folder, *frame)) {
            std::fs::remove_file(&path).map_err(|error| Error::io(&path, &error))?;
        }
        return Ok(None);
    }
    for frame in frames.into_iter().rev() {
        let path = frame_path(folder, frame);
        let saved = match SavedState::read(context, &path) {
            Ok(saved) => saved,
            Err(error) if error.kind == relievo_core::ErrorKind::Invalid => {
                eprintln!("note: {error}");
                continue;
            }
            Err(error) => return Err(error),
        };
        let refuse = |what: &str, advice: String| {
            Err(Error::invalid(what)
                .at(path.display().to_string())
                .advise(format!("{advice}, or begin anew by --restart")))
        };
        if saved.identity != identity {
            return refuse("frames of another simulation are there", "name another folder".into());
        }
        if saved.level != level {
            return refuse(
                "frames of another instruction level or device are there",
                format!("go on at {}, by RELIEVO_SIMD and --device", saved.level),
            );
        }
        return Ok(Some((frame, saved)));
    }
    Ok(None)
}
