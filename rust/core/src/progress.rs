//! Progress of long calls, which the caller can cancel.

use crate::{Error, ErrorKind, Result};

/// Receives progress on the calling thread.
pub trait Progress {
    /// `fraction` is in 0..=1, `stage` names what is being done. Returning `false` asks the call to stop.
    fn report(&mut self, fraction: f32, stage: &str) -> bool;

    /// As [`Progress::report`].
    ///
    /// # Errors
    /// Fails with `Cancelled` if the report asks to stop.
    fn step(&mut self, fraction: f32, stage: &str) -> Result<()> {
        if self.report(fraction, stage) {
            Ok(())
        } else {
            Err(Error::new(ErrorKind::Cancelled, "the caller cancelled the operation").at(stage))
        }
    }
}

/// Progress that nobody watches and that never cancels.
pub struct Silent;

impl Progress for Silent {
    fn report(&mut self, _: f32, _: &str) -> bool {
        true
    }
}

impl<F: FnMut(f32, &str) -> bool> Progress for F {
    fn report(&mut self, fraction: f32, stage: &str) -> bool {
        self(fraction, stage)
    }
}
