//! Messages to the host: the callback of a context, and the queues of jobs, which hold messages until the host polls.

use std::cell::RefCell;
use std::ffi::{CString, c_char, c_void};
use std::sync::{Arc, Mutex, PoisonError};

/// `RlvLog`: NULL, or a function that gets its user pointer, a level and a text.
pub type RlvLog = Option<unsafe extern "C" fn(*mut c_void, u32, *const c_char)>;

/// A host's callback for messages.
#[derive(Clone, Copy)]
pub struct HostLog {
    pub callback: RlvLog,
    pub user: *mut c_void,
}

// SAFETY: the pointer is not dereferenced here, only handed back to its owner's callback; the header says that the
// callback runs on whichever thread calls into the library.
unsafe impl Send for HostLog {}

impl HostLog {
    /// Calls the host.
    pub fn send(&self, level: u32, text: &str) {
        let Some(callback) = self.callback else { return };
        let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
        // SAFETY: the host gave this function for this pointer, and the text lives through the call.
        unsafe { callback(self.user, level, text.as_ptr()) };
    }
}

/// Messages that wait for the host, each with its level.
#[derive(Default)]
pub struct Queue(Mutex<Vec<(u32, String)>>);

impl Queue {
    /// Takes out the waiting messages, oldest first.
    pub fn take(&self) -> Vec<(u32, String)> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

thread_local! {
    /// The queue that takes the messages of this thread.
    static QUEUE: RefCell<Option<Arc<Queue>>> = const { RefCell::new(None) };
}

/// Runs `work` with the messages of this thread going to `queue`.
pub fn collect<T>(queue: &Arc<Queue>, work: impl FnOnce() -> T) -> T {
    QUEUE.set(Some(Arc::clone(queue)));
    let result = work();
    QUEUE.set(None);
    result
}

/// Adds a message to the queue of this thread; returns false if it has none.
pub fn enqueue(level: u32, text: &str) -> bool {
    let queue = QUEUE.try_with(|queue| queue.borrow().clone()).ok().flatten();
    if let Some(queue) = &queue {
        queue.0.lock().unwrap_or_else(PoisonError::into_inner).push((level, text.to_owned()));
    }
    queue.is_some()
}
