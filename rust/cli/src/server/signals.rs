//! What asks the server to stop: SIGTERM, and SIGINT, which Ctrl+C on its terminal is.

use std::io::Result;

use signal_hook::consts::{SIGINT, SIGTERM};

#[cfg(unix)]
pub struct Signals(signal_hook::iterator::Signals);

#[cfg(unix)]
impl Signals {
    /// Takes the signals from now on.
    pub fn new() -> Result<Self> {
        signal_hook::iterator::Signals::new([SIGTERM, SIGINT]).map(Self)
    }

    /// Waits for one of them.
    pub fn wait(&mut self) {
        self.0.forever().next();
    }
}

/// Set by a signal: other systems have no call that waits for one.
#[cfg(not(unix))]
pub struct Signals(std::sync::Arc<std::sync::atomic::AtomicBool>);

#[cfg(not(unix))]
impl Signals {
    /// Takes the signals from now on.
    pub fn new() -> Result<Self> {
        let flag = std::sync::Arc::default();
        for signal in [SIGTERM, SIGINT] {
            signal_hook::flag::register(signal, std::sync::Arc::clone(&flag))?;
        }
        Ok(Self(flag))
    }

    /// Waits for one of them.
    pub fn wait(&mut self) {
        while !self.0.swap(false, std::sync::atomic::Ordering::Relaxed) {
            std::thread::sleep(std::time::Duration::from_millis(50));
        }
    }
}
