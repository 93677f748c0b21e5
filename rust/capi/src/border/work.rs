//! Who is at work on which object: the functions that hold locks, for the errors of calls that find them held and for
//! callers that wait until an object is idle.
//!
//! Locks lie inside their objects, so the address of a lock says which object it belongs to.

use std::cell::Cell;
use std::fmt;
use std::ops::{Deref, DerefMut, Range};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};

use relievo_core::{Error, ErrorKind, Result};

thread_local! {
    /// The function that this thread runs for the host.
    static FUNCTION: Cell<&'static str> = const { Cell::new("") };
}

/// The function that this thread ran before, which it runs again when the value is dropped.
struct Before(&'static str);

impl Drop for Before {
    fn drop(&mut self) {
        let _ = FUNCTION.try_with(|function| function.set(self.0));
    }
}

/// Runs `body` as the function called `name`.
pub fn named<T>(name: &'static str, body: impl FnOnce() -> T) -> T {
    let _before = Before(FUNCTION.try_with(|function| function.replace(name)).unwrap_or(""));
    body()
}

/// The function that this thread runs, "" if it runs none.
pub fn function() -> &'static str {
    FUNCTION.try_with(Cell::get).unwrap_or("")
}

/// Somebody who holds a lock: its address, and the function.
type Holder = (usize, &'static str);

/// Few at a time, so a list that is searched, and whose room is used again.
static HELD: Mutex<Vec<Holder>> = Mutex::new(Vec::new());
static FREED: Condvar = Condvar::new();
/// How many wait: without any, nobody is woken, which would be a call of the system each time.
static WAITING: AtomicUsize = AtomicUsize::new(0);

// The list is whole after every statement.
fn held() -> MutexGuard<'static, Vec<Holder>> {
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The list of workers, locked: no other thread begins or ends work.
pub struct Workers(MutexGuard<'static, Vec<Holder>>);

/// Locks the list of workers.
pub fn lock() -> Workers {
    Workers(held())
}

impl Workers {
    /// Forgets who was at work, in a forked child that lacks their threads.
    pub fn forget(&mut self) {
        self.0.clear();
    }
}

/// The function of a holder of a lock at one of the addresses.
fn holder(held: &[Holder], addresses: &Range<usize>) -> Option<&'static str> {
    held.iter().find(|(address, _)| addresses.contains(address)).map(|(_, function)| *function)
}

/// The entry of one holder, which goes with it.
struct Entry(usize);

impl Entry {
    fn new(address: usize) -> Self {
        held().push((address, function()));
        Self(address)
    }
}

impl Drop for Entry {
    fn drop(&mut self) {
        let mut held = held();
        // Readers of one lock are alike.
        if let Some(index) = held.iter().rposition(|(address, _)| *address == self.0) {
            held.swap_remove(index);
        }
        // Changed under the same lock only.
        if WAITING.load(Ordering::Relaxed) > 0 {
            FREED.notify_all();
        }
    }
}

/// A lock's guard, and the entry that says who has it.
pub struct Held<G> {
    // Freed before threads that wait are woken.
    guard: G,
    #[expect(dead_code, reason = "held until it is dropped")]
    entry: Entry,
}

impl<G> fmt::Debug for Held<G> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("Held")
    }
}

impl<G: Deref> Deref for Held<G> {
    type Target = G::Target;

    fn deref(&self) -> &G::Target {
        &self.guard
    }
}

impl<G: DerefMut> DerefMut for Held<G> {
    fn deref_mut(&mut self) -> &mut G::Target {
        &mut self.guard
    }
}

/// Takes what `tried` got of `lock`.
///
/// # Errors
/// Fails with `Busy`, naming who has it, while another call is at work, and with `Internal` if an earlier panic left it
/// broken.
pub fn hold<L, G>(lock: &L, tried: std::result::Result<G, TryLockError<G>>, noun: &str) -> Result<Held<G>> {
    let address = std::ptr::from_ref(lock).addr();
    match tried {
        Ok(guard) => Ok(Held { guard, entry: Entry::new(address) }),
        Err(TryLockError::WouldBlock) => Err(busy(noun, worker(address..address + 1))),
        Err(TryLockError::Poisoned(_)) => Err(broken(noun)),
    }
}

/// As [`hold`], of a lock that guards no data, which an earlier panic cannot break.
///
/// # Errors
/// Fails with `Busy`, naming who has it, while another call is at work.
pub fn hold_empty<'a>(lock: &'a Mutex<()>, noun: &str) -> Result<Held<MutexGuard<'a, ()>>> {
    let tried = match lock.try_lock() {
        Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
        other => other,
    };
    hold(lock, tried, noun)
}

/// The function that holds a lock at one of the addresses.
pub fn worker(addresses: Range<usize>) -> Option<&'static str> {
    holder(&held(), &addresses)
}

/// Waits until nobody holds a lock at one of the addresses, or the time is up; returns who does then.
pub fn wait(addresses: &Range<usize>, time: Option<Duration>) -> Option<&'static str> {
    let end = time.and_then(|time| Instant::now().checked_add(time));
    let mut held = held();
    loop {
        let worker = holder(&held, addresses);
        if worker.is_none() || time == Some(Duration::ZERO) {
            return worker;
        }
        let left = end.map(|end| end.saturating_duration_since(Instant::now()));
        if left.is_some_and(|left| left.is_zero()) {
            return worker;
        }
        WAITING.fetch_add(1, Ordering::Relaxed);
        held = match left {
            None => FREED.wait(held).unwrap_or_else(PoisonError::into_inner),
            Some(left) => FREED.wait_timeout(held, left).unwrap_or_else(PoisonError::into_inner).0,
        };
        WAITING.fetch_sub(1, Ordering::Relaxed);
    }
}

/// The error of a call that cannot have an object for itself.
pub fn busy(noun: &str, worker: Option<&str>) -> Error {
    let who = worker.filter(|worker| !worker.is_empty()).map(|worker| format!(": `{worker}`")).unwrap_or_default();
    Error::new(ErrorKind::Busy, format!("another call is at work on it{who}")).at(noun).advise(
        "call again when that call has returned, or wait with rlv_object_wait; calls that change an object need it alone",
    )
}

/// The error of an object that a panic left in an unknown state.
pub fn broken(noun: &str) -> Error {
    Error::internal("an earlier call failed inside and left it unusable").at(noun).advise("release it and make another")
}
