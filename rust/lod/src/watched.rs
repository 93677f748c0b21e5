//! Long work on the threads of a context that tells its progress on the thread of its caller, where hosts expect it.
//!
//! All of it stays on the threads of the context: one that goes there anew for every round, so that progress can be told
//! in between, finds nothing of the last round in its caches. It does not wait for the answer, which it finds when it tells
//! more: two threads that wake each other take longer than a step of a small mesh.

use std::panic::resume_unwind;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

use relievo_core::{Context, Error, ErrorKind, Progress, Result};

/// Progress that is reported elsewhere.
struct Relay {
    told: Sender<(f32, String)>,
    answers: Receiver<bool>,
    /// How often something was told to which no answer was found yet.
    open: usize,
}

impl Relay {
    /// Waits for all answers. Returns whether they were wishes to go on.
    fn wait(&mut self) -> bool {
        (0..std::mem::take(&mut self.open)).all(|_| self.answers.recv().unwrap_or(false))
    }
}

impl Progress for Relay {
    fn report(&mut self, fraction: f32, stage: &str) -> bool {
        while let Ok(is_wanted) = self.answers.try_recv() {
            self.open -= 1;
            if !is_wanted {
                return false;
            }
        }
        self.open += 1;
        // Where nobody listens any more there is nothing to go on for.
        self.told.send((fraction, stage.to_owned())).is_ok()
    }
}

fn cancelled() -> Error {
    Error::new(ErrorKind::Cancelled, "the caller cancelled the operation")
}

/// Does `work` within a context. Fails as it does, and if the system gives no thread to wait with.
pub fn watched<T: Send>(
    context: &Context,
    progress: &mut dyn Progress,
    work: impl FnOnce(&mut dyn Progress) -> Result<T> + Send,
) -> Result<T> {
    if context.threads() == 1 {
        return work(progress);
    }
    let (told, heard) = channel();
    let (answer, answers) = channel();
    thread::scope(|scope| {
        let there = move || {
            context.within(|| {
                let mut relay = Relay { told, answers, open: 0 };
                let made = work(&mut relay)?;
                if relay.wait() { Ok(made) } else { Err(cancelled()) }
            })
        };
        let working = thread::Builder::new().spawn_scoped(scope, there).map_err(|error| {
            Error::memory(format!("the system gives no thread: {error}")).advise("close other programs")
        })?;
        let mut is_wanted = true;
        for (fraction, stage) in heard {
            // Who wants no more hears no more.
            is_wanted = is_wanted && progress.report(fraction, &stage);
            // The end of the work is heard first if it has ended meanwhile.
            let _ = answer.send(is_wanted);
        }
        working.join().unwrap_or_else(|panic| resume_unwind(panic))
    })
}
