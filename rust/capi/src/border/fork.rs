//! Forks of the host's process.
//!
//! A forked child has the memory of its parent and none of its threads but the one that forked. A call that waits for a
//! thread of the parent, of a context's pool or of a graphics driver, would never return, so the registry refuses objects
//! made before the fork. The fork waits for the locks of the registry and of the list of workers, so that the child never
//! inherits them locked by a thread that is gone.

// Other systems have no forks to watch.
#![cfg_attr(not(unix), allow(dead_code))]

use std::cell::RefCell;
#[cfg(unix)]
use std::ffi::c_int;
use std::sync::Once;

use crate::border::registry::{self, Locked};
use crate::border::work::{self, Workers};

thread_local! {
    /// The locks of the registry and of the list of workers while this thread forks.
    static LOCKED: RefCell<Option<(Locked, Workers)>> = const { RefCell::new(None) };
}

#[cfg(unix)]
unsafe extern "C" {
    fn pthread_atfork(
        prepare: Option<extern "C" fn()>,
        parent: Option<extern "C" fn()>,
        child: Option<extern "C" fn()>,
    ) -> c_int;
}

/// Installs the handlers that run at every fork. Every context calls it, before the first object exists.
pub fn watch() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // SAFETY: the handlers live as long as the library, which is never unloaded. Without memory for them forks stay
        // unnoticed, and all else works.
        #[cfg(unix)]
        unsafe {
            pthread_atfork(Some(prepare), Some(parent), Some(child));
        }
    });
}

extern "C" fn prepare() {
    // A thread that is being torn down has no place for the locks; then it forks without.
    let _ = LOCKED.try_with(|locked| *locked.borrow_mut() = Some((registry::lock(), work::lock())));
}

extern "C" fn parent() {
    let _ = LOCKED.try_with(|locked| locked.borrow_mut().take());
}

extern "C" fn child() {
    registry::forked();
    let _ = LOCKED.try_with(|locked| {
        if let Some((_, workers)) = locked.borrow_mut().as_mut() {
            workers.forget();
        }
    });
    parent();
}
