//! The `relievo-mpi` command: `relievo fluid sim` over the ranks of MPI. Its frames are the same to the bit, and each of the
//! two goes on from the other's.
//!
//! Exit codes: 0 done, 1 failed on any rank, 2 wrong usage.

mod folder;
mod report;
mod world;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use relievo_core::{Context, ContextOptions, Error, Result};
use relievo_fluid::Transport;
use relievo_openmpi::World;
use relievo_simulation::{Description, Making, Simulation, in_folder};

use self::folder::Folder;
use self::world::Ranks;

/// Simulates a fluid in domains, one on each rank of MPI: `mpirun -n 4 relievo-mpi dam.toml -o frames`.
#[derive(Parser)]
#[command(name = "relievo-mpi", version)]
struct Arguments {
    /// What is simulated, in TOML, as `relievo fluid sim` reads it.
    description: PathBuf,
    /// The folder for the frames, which all ranks see. Where a run was interrupted, it goes on from the last frame there.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Threads of each rank; 0 for one per core. Results do not depend on it.
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    threads: usize,
    /// Bytes that files and what is made of them may occupy on a rank; 0 for no limit.
    #[arg(long, value_name = "BYTES", default_value_t = 8 << 30)]
    memory_limit: u64,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let ranks = match World::start() {
        Ok(world) => Ranks::new(world),
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    match run(&arguments, ranks.clone()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("rank {}: {error}", ranks.rank());
            // The other ranks wait for this one.
            ranks.abort()
        }
    }
}

fn run(arguments: &Arguments, mut ranks: Ranks) -> Result<()> {
    let context = Context::new(&ContextOptions { threads: arguments.threads, memory_limit: arguments.memory_limit })?;
    let description = Description::read(&arguments.description)?;
    let (frames, spacing) = (description.frames, description.spacing());
    let files = in_folder(arguments.description.parent().unwrap_or(Path::new("")));
    let making = Making { format: Folder::FORMAT.extension().into(), parts: 1, device: None };
    let named = |error: Error| error.at(arguments.description.display().to_string());
    let mut simulation = Simulation::begin(&context, description, &files, making).map_err(named)?;
    let folder = Folder { path: &arguments.output, spacing };
    let is_first = ranks.rank() == 0;
    // One rank looks, since frames may appear in the meantime.
    let last = match is_first {
        true => folder.last(&context, simulation.identity())?.map_or(0, |step| step + 1),
        false => 0,
    };
    let last = ranks.gather(last.to_le_bytes().to_vec())?;
    let last = last[0].as_slice().try_into().map(u64::from_le_bytes).unwrap_or(0);
    if last > 0 {
        simulation.restore(folder.read(&context, last - 1)?)?;
    } else if is_first {
        folder.write(&context, &simulation.checkpoint())?;
    }
    simulation.distribute(Box::new(ranks.clone()))?;
    let (begin, before) = (Instant::now(), simulation.totals().steps);
    while simulation.step() < simulation.last() {
        simulation.advance(&context, |_| Ok(()))?;
        if let Some(checkpoint) = simulation.gather()? {
            folder.write(&context, &checkpoint)?;
        }
    }
    let totals = simulation.totals();
    let steps = totals.steps - before;
    let report = report::ranks(&mut ranks, simulation.fluid().traffic(), steps, begin.elapsed().as_secs_f64())?;
    if is_first {
        println!("{frames} frames in {} steps with {} corrections", totals.steps, totals.corrections);
        print!("{report}");
    }
    Ok(())
}
