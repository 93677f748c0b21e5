//! `relievo server cache`

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Subcommand;
use relievo_core::{Error, Result, file};
use relievo_server::Store;
use serde_json::{Value, json};

use crate::Outcome;

const EXAMPLE: &str = "Example: relievo server cache ls";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
    /// The folder of the cache; left out, `relievo` in your folder for caches.
    #[arg(long, value_name = "DIR", global = true)]
    cache: Option<PathBuf>,
}

#[derive(Subcommand)]
enum Task {
    /// Lists the frames, least recently used first.
    Ls {
        /// Print JSON for programs.
        #[arg(long)]
        json: bool,
    },
    /// Checks every frame. The exit code is 3 where some are damaged.
    Verify {
        /// Removes damaged frames.
        #[arg(long)]
        remove: bool,
    },
    /// Removes the frames that were used longest ago. The server must not run.
    Gc {
        /// Bytes that stay at most, with K, M, G or T.
        #[arg(long, value_name = "BYTES", value_parser = crate::bytes)]
        keep: u64,
    },
    /// Writes a frame as the file that `relievo fluid` reads.
    Export {
        /// The key of the frame, as `relievo server cache ls` and `frame.info` say it.
        key: String,
        /// The file to write.
        output: PathBuf,
    },
}

fn ls(store: &Store, json: bool) -> Result<String> {
    let frames = store.list()?;
    if json {
        let values = frames.iter().map(|it| json!({ "key": it.key, "bytes": it.bytes, "idle_seconds": it.idle }));
        return Ok(format!("{:#}\n", Value::from_iter(values)));
    }
    let bytes: u64 = frames.iter().map(|frame| frame.bytes).sum();
    let lines = frames.iter().map(|it| format!("{} {:>12} bytes, used {} s ago\n", it.key, it.bytes, it.idle));
    Ok(lines.collect::<String>() + &format!("{} frames, {:.1} MB\n", frames.len(), bytes as f64 / 1e6))
}

pub fn run(arguments: &Arguments) -> Outcome {
    let folder = arguments.cache.clone().map_or_else(super::run::default_cache, Ok)?;
    match &arguments.task {
        Task::Ls { json } => crate::print(&ls(&Store::look(&folder)?, *json)?)?,
        Task::Verify { remove } => {
            let store = Store::look(&folder)?;
            let damaged = store.verify(*remove)?;
            for (key, error) in &damaged {
                crate::print(&format!("{key}: {error}\n"))?;
            }
            crate::print(&format!("{} frames, {} damaged\n", store.size().1, damaged.len()))?;
            if !damaged.is_empty() {
                return Ok(ExitCode::from(3));
            }
        }
        Task::Gc { keep } => {
            // Opened as a server does, so that none uses it meanwhile.
            Store::look(&folder)?;
            let removed = Store::open(&folder, u64::MAX)?.collect(*keep)?;
            crate::print(&format!("{removed} frames removed\n"))?;
        }
        Task::Export { key, output } => {
            let key = key.parse().map_err(|error: Error| error.at(key.clone()))?;
            let content = Store::look(&folder)?.get(key)?;
            file::store(output, |out| out.write_all(&content))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
