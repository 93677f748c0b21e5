//! A progress bar with the time left, for calls that report a fraction.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use relievo_core::Progress;

/// A bar on a terminal, shown once the call has taken a second.
pub struct Bar {
    start: Instant,
    bar: Option<ProgressBar>,
}

impl Bar {
    /// Makes a bar that is not shown yet.
    pub fn new() -> Self {
        Self { start: Instant::now(), bar: None }
    }
}

impl Progress for Bar {
    fn report(&mut self, fraction: f32, stage: &str) -> bool {
        if self.bar.is_none() && self.start.elapsed() > Duration::from_secs(1) && std::io::stderr().is_terminal() {
            let style = ProgressStyle::with_template("{bar:30} {percent}%, {eta} left, {msg}");
            self.bar =
                style.ok().map(|style| ProgressBar::new(1000).with_style(style).with_elapsed(self.start.elapsed()));
        }
        if let Some(bar) = &self.bar {
            bar.set_message(stage.to_owned());
            bar.set_position((1000.0 * fraction) as u64);
        }
        true
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
