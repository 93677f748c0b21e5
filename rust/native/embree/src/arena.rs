//! A one-thread arena of the TBB that Embree schedules its builds with.
//!
//! Embree's own option for the number of threads sets TBB's process-wide limit, which would slow the host down as long
//! as our device lives. A device that is made inside an arena takes that arena's width instead, and nothing global
//! changes. Builds then stay on the calling thread, which also makes hierarchies, and so the choice among hits at
//! exactly the same distance, independent of the number of threads.
//!
//! The entry points and structures are those of oneTBB's stable binary interface, `libtbb.so.12`. They are looked for in
//! the Embree that was opened and in what it is linked to, so that a host's own TBB is never taken for it. Windows looks in one
//! library only, so there it is the `tbb12.dll` that Embree has loaded.

use std::ffi::{c_int, c_uint, c_void};

use crate::loader::Library;

/// The three calls an arena needs.
pub struct Arena {
    /// Keeps the functions loaded; a test looks for another one in it.
    #[cfg_attr(not(test), expect(dead_code))]
    library: Library,
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

/// The names of the functions that begin an arena, run work in it and end it. They encode the C++ signatures.
#[cfg(unix)]
const NAMES: [&[u8]; 3] = [
    b"_ZN3tbb6detail2r110initializeERNS0_2d115task_arena_baseE",
    b"_ZN3tbb6detail2r17executeERNS0_2d115task_arena_baseERNS2_13delegate_baseE",
    b"_ZN3tbb6detail2r19terminateERNS0_2d115task_arena_baseE",
];
/// The same of Microsoft's compiler, which TBB's files for Windows are made by. Its tables of virtual functions begin alike.
#[cfg(windows)]
const NAMES: [&[u8]; 3] = [
    b"?initialize@r1@detail@tbb@@YAXAEAVtask_arena_base@d1@23@@Z",
    b"?execute@r1@detail@tbb@@YAXAEAVtask_arena_base@d1@23@AEAVdelegate_base@523@@Z",
    b"?terminate@r1@detail@tbb@@YAXAEAVtask_arena_base@d1@23@@Z",
];

impl Arena {
    /// The arena of the TBB that `embree` is linked to, if it is.
    pub fn find(embree: Library) -> Option<Self> {
        #[cfg(unix)]
        let library = embree;
        #[cfg(windows)]
        let (library, _) = (Library::open_already_loaded("tbb12.dll").ok()?, embree);
        let [initialize, execute, terminate] = NAMES;
        // SAFETY: the symbols' names encode their C++ signatures.
        unsafe {
            let initialize = *library.get(initialize).ok()?;
            let execute = *library.get(execute).ok()?;
            let terminate = *library.get(terminate).ok()?;
            Some(Self { library, initialize, execute, terminate })
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
                arena.library.get(b"_ZN3tbb6detail2r127global_control_active_valueEi").unwrap();
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
