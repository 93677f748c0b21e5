//! Writes what is made from C headers and checked in; `cargo xtask bindings` builds and runs it.
//!
//! To bind another library, add a [`Binding`](binding::Binding) to `BINDINGS` in `libraries.rs`, run
//! `cargo xtask bindings`, which writes the file that it names, and include that file as a module. `--check` writes
//! nothing and fails where a file differs from what its headers give.

mod binding;
mod libraries;
mod output;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;

use output::Outputs;

#[derive(Parser)]
#[command(name = "cargo xtask bindings", about = "Writes the declarations that are made from C headers")]
struct Arguments {
    /// Compares the files with the headers and writes none
    #[arg(long)]
    check: bool,
}

/// The folder of the workspace.
fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).to_owned()
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let root = root();
    let mut outputs = Outputs::new(&root, arguments.check);
    for binding in libraries::BINDINGS {
        match binding.generate(&root)? {
            Some(text) => outputs.put(binding.output, &text)?,
            None => outputs.skip(binding.output, &binding.missing()),
        }
    }
    outputs.finish()
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
