//! The host's threads: its parallel loop as an executor of contexts, and its way to begin tasks for jobs.

use std::any::Any;
use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use relievo_core::Scheduler;

use crate::border::arithmetic::HostArithmetic;

/// `RlvLoopBody`: does the piece of a loop that has an index.
pub type RlvLoopBody = Option<unsafe extern "C" fn(*mut c_void, usize)>;

/// `RlvLoop`: NULL, or the host's parallel loop.
pub type RlvLoop = Option<unsafe extern "C" fn(*mut c_void, usize, RlvLoopBody, *mut c_void)>;

/// `RlvTask`: does all of a task.
pub type RlvTask = Option<unsafe extern "C" fn(*mut c_void)>;

/// `RlvSpawn`: NULL, or what begins a task on a thread of the host.
pub type RlvSpawn = Option<unsafe extern "C" fn(*mut c_void, RlvTask, *mut c_void)>;

/// The parallel loop of a host.
pub struct HostLoop {
    pub run: unsafe extern "C" fn(*mut c_void, usize, RlvLoopBody, *mut c_void),
    pub user: *mut c_void,
    pub threads: usize,
}

// SAFETY: the pointer is only handed back to its owner's function, which the header says runs on any thread.
unsafe impl Send for HostLoop {}
// SAFETY: as above.
unsafe impl Sync for HostLoop {}

/// One loop under way.
struct Pass<'a> {
    body: &'a (dyn Fn(usize) + Sync),
    /// Whether somebody took an index: a host that calls twice must not do a piece twice.
    taken: Vec<AtomicBool>,
    done: AtomicUsize,
    panic: Mutex<Option<Box<dyn Any + Send>>>,
}

impl Pass<'_> {
    fn call(&self, index: usize) {
        if self.taken.get(index).is_none_or(|taken| taken.swap(true, Ordering::Relaxed)) {
            return;
        }
        // No panic may cross the host's loop; it goes on where the loop was begun.
        if let Err(payload) = catch_unwind(AssertUnwindSafe(|| (self.body)(index))) {
            *self.panic.lock().unwrap_or_else(PoisonError::into_inner) = Some(payload);
        }
        self.done.fetch_add(1, Ordering::Release);
    }
}

unsafe extern "C" fn call(pass: *mut c_void, index: usize) {
    let _host = HostArithmetic::replace();
    // SAFETY: the host passes on the pointer that it got, within its loop, through which the pass lives.
    unsafe { &*pass.cast::<Pass>() }.call(index);
}

impl Scheduler for HostLoop {
    fn threads(&self) -> usize {
        self.threads
    }

    fn run(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
        let taken = (0..count).map(|_| AtomicBool::new(false)).collect();
        let pass = Pass { body, taken, done: AtomicUsize::new(0), panic: Mutex::new(None) };
        // SAFETY: the host gave this function for this pointer; the pass lives until the end of this call.
        unsafe { (self.run)(self.user, count, Some(call), std::ptr::from_ref(&pass).cast_mut().cast()) };
        if pass.done.load(Ordering::Acquire) < count {
            // What the host left out; then what it began and did not wait for.
            (0..count).for_each(|index| pass.call(index));
            while pass.done.load(Ordering::Acquire) < count {
                std::thread::yield_now();
            }
        }
        if let Some(payload) = pass.panic.into_inner().unwrap_or_else(PoisonError::into_inner) {
            resume_unwind(payload);
        }
    }
}

/// How a host begins tasks.
#[derive(Clone, Copy)]
pub struct HostSpawn {
    pub spawn: unsafe extern "C" fn(*mut c_void, RlvTask, *mut c_void),
    pub user: *mut c_void,
}

// SAFETY: as for `HostLoop`.
unsafe impl Send for HostSpawn {}
// SAFETY: as above.
unsafe impl Sync for HostSpawn {}

type Work = Box<dyn FnOnce() + Send>;

unsafe extern "C" fn run_task(work: *mut c_void) {
    let _host = HostArithmetic::replace();
    // SAFETY: the pointer is the box that `begin` gave away; the header says that a task is run once.
    let work = unsafe { Box::from_raw(work.cast::<Work>()) };
    // Jobs catch their own panics, and nobody waits for another.
    let _ = catch_unwind(AssertUnwindSafe(*work));
}

impl HostSpawn {
    /// Has the host run `work` once, on a thread of its own choice.
    pub fn begin(&self, work: Work) {
        // SAFETY: the host gave this function for this pointer, and runs the task once.
        unsafe { (self.spawn)(self.user, Some(run_task), Box::into_raw(Box::new(work)).cast()) };
    }
}
