//! Frames of particles: read, listed, chosen, and counted by a bar.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use relievo_core::{Context, Error, Progress, Result};
use relievo_particleio::Particles;

/// Reads particles, and prints what was left out.
pub fn read(context: &Context, path: &Path) -> Result<Particles> {
    let read = relievo_particleio::read(context, path)?;
    read.notes.iter().for_each(|note| eprintln!("note: {}: {note}", path.display()));
    Ok(read.particles)
}

/// The frames in a folder in order, with the names of their files without the extension. There is one at least.
pub fn frames(folder: &Path) -> Result<Vec<(String, PathBuf)>> {
    let frames = relievo_particleio::frames(folder)?.into_iter();
    let named = |(_, path): (_, PathBuf)| (stem(&path), path);
    let frames: Vec<_> = frames.map(named).collect();
    match frames.is_empty() {
        true => Err(Error::invalid("there are no frames in the folder")
            .at(folder.display().to_string())
            .advise("frames are called `0000.rlvfluid`, or `0000.250.ply`")),
        false => Ok(frames),
    }
}

/// Returns those of the frames in a folder that lie from a first to a last one, both included, with the sub-frames after each.
/// Fails if a whole frame is missing.
pub fn chunk(folder: &Path, range: Option<(u32, u32)>) -> Result<Vec<(String, PathBuf)>> {
    let Some((first, last)) = range else { return frames(folder) };
    let [low, high] = [u64::from(first) * 1000, u64::from(last) * 1000 + 999];
    let frames = relievo_particleio::frames(folder)?.into_iter();
    let frames: Vec<_> = frames.filter(|(number, _)| (low..=high).contains(&number.0)).collect();
    let is_there =
        |frame: &u32| frames.binary_search_by_key(&(u64::from(*frame) * 1000), |(number, _)| number.0).is_ok();
    if let Some(missing) = (first..=last).find(|frame| !is_there(frame)) {
        return Err(Error::invalid(format!("there is no frame {missing}"))
            .at(folder.display().to_string())
            .advise("simulate up to it first"));
    }
    Ok(frames.into_iter().map(|(_, path)| (stem(&path), path)).collect())
}

/// Fails if frames are chosen from a path that is no folder.
pub fn needs_folder(path: &Path, range: Option<(u32, u32)>) -> Result<()> {
    match range {
        None => Ok(()),
        Some(_) => Err(Error::invalid("frames are chosen from a folder, and this is none")
            .at(path.display().to_string())
            .advise("name a folder of frames, or leave out --frames")),
    }
}

/// The name of a file without its extension.
fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// A bar of so many frames on a terminal; elsewhere nothing is shown.
pub fn bar(frames: u64) -> Result<ProgressBar> {
    if !std::io::stderr().is_terminal() {
        return Ok(ProgressBar::hidden());
    }
    let style = ProgressStyle::with_template("{bar:30} frame {pos} of {len}, {eta} left {msg}");
    let bar = ProgressBar::new(frames);
    bar.set_style(style.map_err(|error| Error::internal(error.to_string()))?);
    Ok(bar)
}

/// A bar of frames for calls that report the share of them that is done. The time left is that from where the call begins.
pub struct FrameBar {
    bar: ProgressBar,
    has_begun: bool,
}

impl FrameBar {
    /// Makes a bar of so many frames.
    pub fn new(frames: u64) -> Result<Self> {
        Ok(Self { bar: bar(frames)?, has_begun: false })
    }
}

impl Progress for FrameBar {
    fn report(&mut self, fraction: f32, stage: &str) -> bool {
        self.bar.set_position((fraction * self.bar.length().unwrap_or(0) as f32).round() as u64);
        self.bar.set_message(stage.to_owned());
        if !std::mem::replace(&mut self.has_begun, true) {
            self.bar.reset_eta();
        }
        true
    }
}

impl Drop for FrameBar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
