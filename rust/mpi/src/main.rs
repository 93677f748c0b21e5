//! The `relievo-mpi` command: `relievo fluid sim` over the ranks of MPI. Its frames are the same to the bit, and each of the
//! two goes on from the other's.
//!
//! Exit codes: 0 done, 1 failed on any rank, 2 wrong usage.

mod world;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use relievo_core::{Context, ContextOptions, Result};
use relievo_fluid::Transport;
use relievo_openmpi::World;
use relievo_simulation::simulate_on_rank;

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

fn run(arguments: &Arguments, ranks: Ranks) -> Result<()> {
    let context = Context::new(&ContextOptions { threads: arguments.threads, memory_limit: arguments.memory_limit })?;
    if let Some(report) = simulate_on_rank(&context, &arguments.description, &arguments.output, Box::new(ranks))? {
        print!("{report}");
    }
    Ok(())
}
