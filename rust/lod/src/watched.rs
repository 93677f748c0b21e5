//! Long work on the threads of a context that tells its progress on the thread of its caller, where hosts expect it.
//!
//! All of it stays on the threads of the context: one that goes there anew for every round, so that progress can be told
//! in between, finds nothing of the last round in its caches.

use std::panic::resume_unwind;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

use relievo_core::{Context, Error, Progress, Result};

/// Progress that is told elsewhere.
struct Relay {
    told: Sender<(f32, String)>,
    answers: Receiver<bool>,
}

impl Progress for Relay {
    fn report(&mut self, fraction: f32, stage: &str) -> bool {
        // Where nobody listens any more there is nothing to go on for.
        self.told.send((fraction, stage.to_owned())).is_ok() && self.answers.recv().unwrap_or(false)
    }
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
        let there = move || context.within(|| work(&mut Relay { told, answers }));
        let working = thread::Builder::new().spawn_scoped(scope, there).map_err(|error| {
            Error::memory(format!("the system gives no thread: {error}")).advise("close other programs")
        })?;
        for (fraction, stage) in heard {
            // The end of the work is heard first if it has ended meanwhile.
            let _ = answer.send(progress.report(fraction, &stage));
        }
        working.join().unwrap_or_else(|panic| resume_unwind(panic))
    })
}
