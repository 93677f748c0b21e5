//! Writes what is made from C headers and checked in; `cargo xtask bindings` builds and runs it.
//!
//! - Rust declarations of libraries: to bind another one, add a [`Binding`](binding::Binding) to `BINDINGS` in
//!   `libraries.rs`, run `cargo xtask bindings`, which writes the file that it names, and include that file as a module.
//! - From the headers of the C ABI: Python's declarations, the list of exported symbols, and the test that compares the
//!   headers with `rust/capi`. A new noun needs no change here.
//!
//! `--check` writes nothing and fails where a file differs from what its headers give. `--pages` writes the reference
//! pages of the C ABI instead.

mod abi;
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
    /// Writes the pages of the C ABI to this folder instead, and fails where something is undocumented
    #[arg(long, value_name = "FOLDER", conflicts_with = "check")]
    pages: Option<PathBuf>,
}

/// The folder of the workspace.
fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).to_owned()
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let root = root();
    let abi = abi::reader::read(&root.join("include"))?;
    if let Some(folder) = &arguments.pages {
        return write_pages(&abi, folder);
    }
    let mut outputs = Outputs::new(&root, arguments.check);
    for binding in libraries::BINDINGS {
        match binding.generate(&root)? {
            Some(text) => outputs.put(binding.output, &text)?,
            None => outputs.skip(binding.output, &binding.missing()),
        }
    }
    outputs.put("rust/capi/tests/header/comparison.rs", &abi::rust::comparison(&abi))?;
    outputs.put("plugins/python/librelievo/abi.py", &abi::python::module(&abi)?)?;
    outputs.put("tests/c/symbols.txt", &(abi.symbols().join("\n") + "\n"))?;
    outputs.finish()
}

fn write_pages(abi: &abi::Abi, folder: &Path) -> Result<(), String> {
    let (pages, faults) = abi::page::pages(abi);
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for (name, text) in &pages {
        let path = folder.join(name);
        std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    println!("{} pages in {}", pages.len(), folder.display());
    match faults.is_empty() {
        true => Ok(()),
        false => Err(format!("{} gaps in the comments of include/relievo:\n  {}", faults.len(), faults.join("\n  "))),
    }
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
