//! A one-thread arena of the TBB that Embree schedules its builds with.
//!
//! Embree's own option for the number of threads sets TBB's process-wide limit, which would slow the host down as long
//! as our device lives. A device that is made inside an arena takes that arena's width instead, and nothing global
//! changes. Builds then stay on the calling thread, which also makes hierarchies, and so the choice among hits at
//! exactly the same distance, independent of the number of threads.
//!
//! The entry points and structures are those of oneTBB's stable binary interface, `libtbb.so.12`. They are looked for in
//! the Embree that was opened and in what it is linked to, so that a host's own TBB is never taken for it.

use std::ffi::{c_int, c_uint, c_void};

use crate::loader::Library;

/// The three calls an arena needs.
pub struct Arena {
    /// Keeps the functions loaded; a test looks for another one in it.
    #[cfg_attr(not(test), expect(dead_code))]
    embree: Library,
    initialize: unsafe extern "C" fn(*mut Settings),
    execute: unsafe extern "C" fn(*mut Settings, *const Delegate),
    terminate: unsafe extern "C" fn(*mut Settings),
}

/// `task_arena_base`.
#[repr(C)]
struct Settings {
    version_and_traits: isize,
    state: c_int,
    arena: *mut c_void,
    max_concurrency: c_int,
    reserved_slots: c_uint,
    priority: c_int,
    numa: c_int,
    core_type: c_int,
    threads_per_core: c_int,
}

/// `delegate_base`: an object with a table of virtual functions, and the work.
#[repr(C)]
struct Delegate {
    methods: *const Methods,
    work: *const (),
    call: unsafe fn(*const ()),
}

/// Call operator and the two destructors, in the order of the Itanium C++ ABI.
#[repr(C)]
struct Methods {
    call: unsafe extern "C" fn(*const Delegate) -> bool,
    destroy: unsafe extern "C" fn(*const Delegate),
    delete: unsafe extern "C" fn(*const Delegate),
}

static METHODS: Methods = Methods { call: call_delegate, destroy: keep_delegate, delete: keep_delegate };

unsafe extern "C" fn call_delegate(delegate: *const Delegate) -> bool {
    // SAFETY: `run` passes a delegate that lives through the call and whose `call` fits its `work`.
    unsafe { ((*delegate).call)((*delegate).work) };
    true
}

unsafe extern "C" fn keep_delegate(_: *const Delegate) {}

impl Arena {
    /// The arena of the TBB that `embree` is linked to, if it is.
    pub fn find(embree: Library) -> Option<Self> {
        // SAFETY: the symbols' names encode their C++ signatures.
        unsafe {
            let initialize = *embree.get(b"_ZN3tbb6detail2r110initializeERNS0_2d115task_arena_baseE").ok()?;
            let execute =
                *embree.get(b"_ZN3tbb6detail2r17executeERNS0_2d115task_arena_baseERNS2_13delegate_baseE").ok()?;
            let terminate = *embree.get(b"_ZN3tbb6detail2r19terminateERNS0_2d115task_arena_baseE").ok()?;
            Some(Self { embree, initialize, execute, terminate })
        }
    }

    /// Runs `work` on the calling thread, inside an arena of one thread. `work` must not panic.
    pub fn run(&self, work: &(impl Fn() + Sync)) {
        unsafe fn call<F: Fn()>(work: *const ()) {
            // SAFETY: `work` is the reference that `run` was given.
            unsafe { (*work.cast::<F>())() }
        }
        fn caller<F: Fn()>(_: &F) -> unsafe fn(*const ()) {
            call::<F>
        }
        const NORMAL: c_int = 2 * (c_int::MAX / 4);
        const AUTOMATIC: c_int = -1;
        let mut settings = Settings {
            version_and_traits: 1,
            state: 0,
            arena: std::ptr::null_mut(),
            max_concurrency: 1,
            reserved_slots: 1,
            priority: NORMAL,
            numa: AUTOMATIC,
            core_type: AUTOMATIC,
            threads_per_core: AUTOMATIC,
        };
        let delegate = Delegate { methods: &METHODS, work: std::ptr::from_ref(work).cast(), call: caller(work) };
        // SAFETY: the structures are laid out as the interface wants them and outlive the calls; an arena with one
        // reserved slot runs the delegate before `execute` returns.
        unsafe {
            (self.initialize)(&mut settings);
            (self.execute)(&mut settings, &delegate);
            (self.terminate)(&mut settings);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Device;

    #[test]
    fn a_device_leaves_the_limit_of_tbb_as_it_is() {
        let first = Device::new().unwrap();
        let Some(arena) = &first.table().arena else {
            println!("skipped: this Embree does not share TBB");
            return;
        };
        // SAFETY: the symbol's name encodes its signature.
        let limit = || unsafe {
            let value: crate::loader::Symbol<unsafe extern "C" fn(c_int) -> usize> =
                arena.embree.get(b"_ZN3tbb6detail2r127global_control_active_valueEi").unwrap();
            value(0)
        };
        let with_one = limit();
        drop(first);
        assert_eq!(limit(), with_one);
        if std::thread::available_parallelism().unwrap().get() > 1 {
            assert!(with_one > 1);
        }
    }
}
