//! Scenes that are written to a folder and run there.
// No test uses all of it.
#![allow(dead_code)]

use std::path::{Path, PathBuf};

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions};
use relievo_scene::file::read_file;
use relievo_scene::stepper::{RunOptions, Summary, run};

/// Makes options of a run on the processor of all frames, which writes into `out`.
pub fn plain_options(out: PathBuf) -> RunOptions {
    RunOptions { out, frames: None, allowed: Vec::new(), rebake: false, device: None }
}

/// Runs the scene `text` as `name.toml` in `folder`, with its output beside it in `name`.
pub fn run_in(folder: &Path, name: &str, text: &str, frames: Option<(u32, u32)>, threads: usize) -> Summary {
    let scene = folder.join(format!("{name}.toml"));
    std::fs::write(&scene, text).unwrap();
    let options = RunOptions { frames, ..plain_options(folder.join(name)) };
    let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
    run(&context, read_file(&scene).unwrap(), &options, &mut Silent).unwrap()
}

/// A file that the scene `name` wrote.
pub fn bytes(folder: &Path, name: &str, file: &str) -> Vec<u8> {
    std::fs::read(folder.join(name).join(file)).unwrap()
}
