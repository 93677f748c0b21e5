//! The host's allocator, from which all memory of Rust comes; see `include/relievo/allocator.h`.
//!
//! A block is given back to where it came from. Blocks from before the host's allocator was set are few, since only a
//! library without any context takes one, so their addresses are kept in a table.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ffi::c_void;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicI64, AtomicU8, AtomicUsize, Ordering};

use relievo_core::{Error, Result, memory};

use crate::border::descriptor::{read_descriptor, write_descriptor};

/// `RlvAllocate`: takes its user pointer, a size and an alignment in bytes.
pub type RlvAllocate = Option<unsafe extern "C" fn(*mut c_void, usize, usize) -> *mut c_void>;

/// `RlvFree`: takes its user pointer, a block, and the size and alignment it was allocated with.
pub type RlvFree = Option<unsafe extern "C" fn(*mut c_void, *mut c_void, usize, usize)>;

descriptor! {
    pub struct RlvAllocator {
        struct_size: u32,
        reserved: u32,
        allocate: RlvAllocate,
        free: RlvFree,
        user: *mut c_void,
    }
}

descriptor! {
    pub struct RlvAllocatorInfo {
        struct_size: u32,
        is_set: u32,
        bytes: u64,
        limit: u64,
    }
}

/// The functions of a host.
struct Host {
    allocate: unsafe extern "C" fn(*mut c_void, usize, usize) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void, *mut c_void, usize, usize),
    user: *mut c_void,
}

// SAFETY: the pointer is only handed back to its owner's functions, which the header says run on any thread.
unsafe impl Send for Host {}
// SAFETY: as above.
unsafe impl Sync for Host {}

static HOST: OnceLock<Host> = OnceLock::new();

/// Blocks come from the system and are written down, so that a host may still set its allocator.
const EARLY: u8 = 0;
/// Blocks come from the system for good.
const SYSTEM: u8 = 1;
/// Blocks come from the host, but for those in the table.
const GIVEN: u8 = 2;

static STATE: AtomicU8 = AtomicU8::new(EARLY);

/// Places for addresses of blocks: 0 for one that was never used, 1 for one whose block was given back.
const ROOM: usize = 4096;
/// Blocks that are written down; beyond, it is too late to set an allocator, and the table has gaps at which searches end.
const MAX: usize = ROOM / 2;

static BLOCKS: [AtomicUsize; ROOM] = [const { AtomicUsize::new(0) }; ROOM];
static WRITTEN: AtomicUsize = AtomicUsize::new(0);
/// Blocks of the table that were not given back.
static LEFT: AtomicUsize = AtomicUsize::new(0);

/// The places of the table in the order in which an address is looked for.
fn places(address: usize) -> impl Iterator<Item = &'static AtomicUsize> {
    let first = (address >> 4).wrapping_mul(0x9e37_79b9) >> 8;
    (0..ROOM).filter_map(move |step| BLOCKS.get(first.wrapping_add(step) % ROOM))
}

/// Writes down a block of the system.
fn write_down(block: *mut u8) {
    if block.is_null() {
        return;
    }
    if WRITTEN.fetch_add(1, Ordering::Relaxed) >= MAX {
        // Only from here on nobody asks the table.
        let _ = STATE.compare_exchange(EARLY, SYSTEM, Ordering::AcqRel, Ordering::Acquire);
        return;
    }
    LEFT.fetch_add(1, Ordering::Relaxed);
    for place in places(block.addr()) {
        if place.compare_exchange(0, block.addr(), Ordering::AcqRel, Ordering::Acquire).is_ok() {
            return;
        }
    }
}

/// Returns whether a block is in the table, and takes it out.
fn strike_out(block: *mut u8) -> bool {
    if LEFT.load(Ordering::Relaxed) == 0 {
        return false;
    }
    for place in places(block.addr()) {
        match place.load(Ordering::Acquire) {
            0 => return false,
            address
                if address == block.addr()
                    && place.compare_exchange(address, 1, Ordering::AcqRel, Ordering::Acquire).is_ok() =>
            {
                LEFT.fetch_sub(1, Ordering::Relaxed);
                return true;
            }
            _ => {}
        }
    }
    false
}

impl Host {
    /// # Safety
    /// As for [`GlobalAlloc::alloc`].
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the host gave this function for this pointer.
        let block = unsafe { (self.allocate)(self.user, layout.size(), layout.align()) };
        if !block.addr().is_multiple_of(layout.align()) {
            // SAFETY: as above; the block is its own.
            unsafe { (self.free)(self.user, block, layout.size(), layout.align()) };
            return std::ptr::null_mut();
        }
        block.cast()
    }
}

/// Counters of bytes, so that threads seldom share one; on cache lines of their own.
const COUNTERS: usize = 64;

#[repr(align(128))]
struct Counter(AtomicI64);

/// Bytes that were allocated less bytes that were given back. A block may be given back on another thread, so that only the
/// sum means something.
static OCCUPIED: [Counter; COUNTERS] = [const { Counter(AtomicI64::new(0)) }; COUNTERS];
static THREADS: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// Which counter the thread uses, plus 1; 0 before its first block. It has no destructor, so that it is there to the end.
    static COUNTER: Cell<usize> = const { Cell::new(0) };
}

/// Counts bytes that were allocated or, below 0, given back.
fn count(bytes: i64) {
    let counter = COUNTER.with(|counter| {
        if counter.get() == 0 {
            counter.set(THREADS.fetch_add(1, Ordering::Relaxed) % COUNTERS + 1);
        }
        counter.get()
    });
    if let Some(counter) = OCCUPIED.get(counter - 1) {
        counter.0.fetch_add(bytes, Ordering::Relaxed);
    }
}

/// Returns how many bytes the blocks of the library occupy.
fn occupied() -> u64 {
    OCCUPIED.iter().map(|counter| counter.0.load(Ordering::Relaxed)).sum::<i64>().max(0).unsigned_abs()
}

/// The allocator of the library.
struct Allocator;

#[global_allocator]
static ALLOCATOR: Allocator = Allocator;

// SAFETY: blocks are those of the system or of the host, whose promises are those of the trait, and each goes back to where it
// came from.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let block = match STATE.load(Ordering::Acquire) {
            // SAFETY: promised by the caller.
            SYSTEM => unsafe { System.alloc(layout) },
            EARLY => {
                // SAFETY: promised by the caller.
                let block = unsafe { System.alloc(layout) };
                write_down(block);
                block
            }
            // SAFETY: promised by the caller.
            _ => HOST.get().map_or(std::ptr::null_mut(), |host| unsafe { host.alloc(layout) }),
        };
        if !block.is_null() {
            count(layout.size() as i64);
        }
        block
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        count(-(layout.size() as i64));
        let state = STATE.load(Ordering::Acquire);
        let is_early = state != SYSTEM && strike_out(block);
        match HOST.get() {
            // SAFETY: the host gave this function for this pointer, and the block is of the host.
            Some(host) if state == GIVEN && !is_early => unsafe {
                (host.free)(host.user, block.cast(), layout.size(), layout.align());
            },
            // SAFETY: promised by the caller; the block is of the system.
            _ => unsafe { System.dealloc(block, layout) },
        }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if STATE.load(Ordering::Acquire) == SYSTEM {
            // SAFETY: promised by the caller.
            let block = unsafe { System.alloc_zeroed(layout) };
            if !block.is_null() {
                count(layout.size() as i64);
            }
            return block;
        }
        // SAFETY: promised by the caller.
        let block = unsafe { self.alloc(layout) };
        if !block.is_null() {
            // SAFETY: the block has so many bytes.
            unsafe { block.write_bytes(0, layout.size()) };
        }
        block
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if STATE.load(Ordering::Acquire) == SYSTEM {
            // SAFETY: promised by the caller.
            let next = unsafe { System.realloc(block, layout, size) };
            if !next.is_null() {
                count(size as i64 - layout.size() as i64);
            }
            return next;
        }
        // SAFETY: the caller promises a size that does not overflow with this alignment.
        let next = unsafe { self.alloc(Layout::from_size_align_unchecked(size, layout.align())) };
        if !next.is_null() {
            // SAFETY: both blocks have so many bytes, and the old one is given up.
            unsafe {
                next.copy_from_nonoverlapping(block, layout.size().min(size));
                self.dealloc(block, layout);
            }
        }
        next
    }
}

/// Leaves all blocks to the system from now on, unless the host has set its allocator.
pub fn settle() {
    let _ = STATE.compare_exchange(EARLY, SYSTEM, Ordering::AcqRel, Ordering::Acquire);
}

/// Takes blocks from the host from now on.
fn set(host: Host) -> Result<()> {
    let refused = |what: &str| Error::invalid(what).at("allocator");
    if STATE.load(Ordering::Acquire) == SYSTEM {
        return Err(refused("it is too late: a context was made, or much memory taken")
            .advise("set the allocator before any other function of the library is called"));
    }
    let set_before = || refused("an allocator is set").advise("set one for the life of the process");
    HOST.set(host).map_err(|_| set_before())?;
    // A context may have been made on another thread since.
    STATE
        .compare_exchange(EARLY, GIVEN, Ordering::AcqRel, Ordering::Acquire)
        .map(|_| ())
        .map_err(|_| refused("a context was made meanwhile").advise("set the allocator first"))
}

entry! {
    fn rlv_allocator_set(allocator: *const RlvAllocator) {
        let none = RlvAllocator { struct_size: 0, reserved: 0, allocate: None, free: None, user: std::ptr::null_mut() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(allocator, none) }?;
        let missing = |name: &str| Error::invalid("a function is missing").at(name).advise("give both functions");
        let allocate = given.allocate.ok_or_else(|| missing("allocate"))?;
        let free = given.free.ok_or_else(|| missing("free"))?;
        set(Host { allocate, free, user: given.user })
    }

    fn rlv_allocator_info(out: *mut RlvAllocatorInfo) {
        let info = RlvAllocatorInfo {
            struct_size: 0,
            is_set: u32::from(STATE.load(Ordering::Acquire) == GIVEN),
            bytes: occupied(),
            limit: if memory::limit() == u64::MAX { 0 } else { memory::limit() },
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_allocator_set_limit(bytes: u64) {
        memory::count_with(occupied);
        memory::set_limit(if bytes == 0 { u64::MAX } else { bytes });
        Ok(())
    }
}
