//! The folder of the frames of a run on ranks.

use std::path::Path;

use relievo_core::{Context, Error, ErrorKind, Result, file};
use relievo_fluid::Checkpoint;
use relievo_particleio::{Format, frames, path, write_frame};

use crate::simulation::Simulation;

/// A folder of frames, which are as far apart at rest, in metres.
pub struct Folder<'a> {
    pub path: &'a Path,
    pub spacing: f32,
}

impl Folder<'_> {
    /// The format of the frames.
    pub const FORMAT: Format = Format::Cache;

    /// Returns the last whole frame from which a simulation with an identity goes on. Damaged frames are left out, with a
    /// note. Fails if a frame is of another simulation or instruction level.
    pub fn last(&self, context: &Context, identity: &str) -> Result<Option<u64>> {
        std::fs::create_dir_all(self.path).map_err(|error| Error::io(self.path, &error))?;
        for (number, path) in frames(self.path)?.into_iter().rev() {
            if Format::named(&path) != Ok(Self::FORMAT) {
                continue;
            }
            let named = |error: Error| error.at(path.display().to_string());
            let checkpoint = match self.read(context, number.0 / 1000) {
                Ok(checkpoint) => checkpoint,
                Err(error) if error.kind == ErrorKind::Invalid => {
                    eprintln!("note: {}", named(error));
                    continue;
                }
                Err(error) => return Err(named(error)),
            };
            return match checkpoint.identity == identity {
                true => Ok(Some(checkpoint.step)),
                false => {
                    Err(named(Error::invalid("frames of another simulation are there").advise("name another folder")))
                }
            };
        }
        Ok(None)
    }

    /// Reads what a simulation goes on from at a frame.
    pub fn read(&self, context: &Context, step: u64) -> Result<Checkpoint> {
        let bytes = file::load(&path(self.path, step, 1, Self::FORMAT), context.memory_limit())?;
        Simulation::decode(context, &bytes)
    }

    /// Writes a frame, with what a simulation goes on from.
    pub fn write(&self, context: &Context, checkpoint: &Checkpoint) -> Result<()> {
        let file = path(self.path, checkpoint.step, 1, Self::FORMAT);
        write_frame(context, &file, &checkpoint.state.particles(self.spacing), Some(&checkpoint.encode()))
    }
}
