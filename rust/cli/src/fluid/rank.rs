//! `relievo fluid rank`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_client::Address;
use relievo_core::Error;
use relievo_server::{RankOptions, RpcRanks};
use relievo_simulation::simulate_on_rank;

use crate::Outcome;
use crate::args::limits::Limits;

const EXAMPLE: &str = "Example, each line in a process of its own:\n  \
    relievo fluid rank dam.toml -o frames --ranks 127.0.0.1:7351,127.0.0.1:7352 --rank 0\n  \
    relievo fluid rank dam.toml -o frames --ranks 127.0.0.1:7351,127.0.0.1:7352 --rank 1";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// What is simulated, in TOML, as `relievo fluid sim` reads it; the same on all ranks.
    description: PathBuf,
    /// The folder for the frames, which all ranks see and rank 0 writes. Where a run was interrupted, it goes on from the last
    /// frame there.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Where each rank listens, host:port, in the order of ranks; the same list on all of them.
    #[arg(long, value_name = "ADDRESS,ADDRESS", value_delimiter = ',', required = true)]
    ranks: Vec<Address>,
    /// The number of this rank in the list, from 0.
    #[arg(long, value_name = "NUMBER")]
    rank: usize,
    /// A file with a token; ranks with another one are refused.
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// Allows ranks on other machines although what they send is not encrypted.
    #[arg(long)]
    allow_remote_connections_without_encryption: bool,
    #[command(flatten)]
    limits: Limits,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let options = RankOptions {
        addresses: arguments.ranks.clone(),
        rank: arguments.rank,
        token: crate::server::connection::token(arguments.token_file.as_deref())?,
        insecure: arguments.allow_remote_connections_without_encryption,
        limit: arguments.limits.memory_limit,
        ..RankOptions::default()
    };
    let named = |error: Error| error.at(format!("rank {}", arguments.rank));
    let ranks = RpcRanks::join(&options).map_err(named)?;
    let report =
        simulate_on_rank(&context, &arguments.description, &arguments.output, Box::new(ranks)).map_err(named)?;
    if let Some(report) = report {
        crate::print(&report)?;
    }
    Ok(ExitCode::SUCCESS)
}
