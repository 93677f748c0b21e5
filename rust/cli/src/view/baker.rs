//! A bake in the background, while the window goes on.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use relievo_core::{Progress, Result};
use relievo_view::show::Bake;

/// Work on a thread of its own. Dropped, it is asked to stop and waited for, so that the file it writes is whole.
pub struct Baker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// What a bake shares with its thread.
#[derive(Default)]
struct Shared {
    state: Mutex<Bake>,
    stops: AtomicBool,
}

impl Shared {
    /// Changes the state, which is whole after every statement.
    fn set(&self, change: impl FnOnce(&mut Bake)) {
        change(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

impl Drop for Baker {
    fn drop(&mut self) {
        self.stop();
        // A panic of the thread was printed when it happened.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

impl Baker {
    /// Starts work, which returns what it made in a sentence.
    pub fn start(work: impl FnOnce(&mut dyn Progress) -> Result<String> + Send + 'static) -> Self {
        let shared = Arc::new(Shared::default());
        shared.set(|state| state.is_running = true);
        let inside = Arc::clone(&shared);
        let run = move || {
            let mut progress = |share: f32, stage: &str| {
                inside.set(|state| (state.share, state.stage) = (share, stage.to_owned()));
                !inside.stops.load(Ordering::Relaxed)
            };
            let done = work(&mut progress);
            inside.set(|state| {
                state.is_running = false;
                (state.has_failed, state.stage) = match done {
                    Ok(made) => (false, made),
                    Err(_) if inside.stops.load(Ordering::Relaxed) => (false, "stopped".to_owned()),
                    Err(error) => (true, error.to_string()),
                };
            });
        };
        let thread = std::thread::Builder::new().name("relievo-bake".into()).spawn(run);
        if let Err(error) = &thread {
            shared.set(|state| *state = Bake { has_failed: true, stage: error.to_string(), ..Bake::default() });
        }
        Self { shared, thread: thread.ok() }
    }

    /// Returns how far it is, but for the count of frames.
    pub fn state(&self) -> Bake {
        self.shared.state.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Asks the work to stop, and does not wait.
    pub fn stop(&self) {
        self.shared.stops.store(true, Ordering::Relaxed);
    }
}
