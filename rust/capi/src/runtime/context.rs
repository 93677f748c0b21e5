//! Contexts, progress and log callbacks, statistics; see `include/relievo/context.h`.

use std::collections::BTreeMap;
use std::ffi::{CString, c_char, c_void};
use std::sync::{Arc, Mutex, PoisonError};

use relievo_core::{Context, ContextOptions, Error, Progress, Result};
use relievo_gpu::{AdapterChoice, Device, DeviceOptions};

use crate::border::array::{Output, fixed, present, put, text};
use crate::border::descriptor::{check_descriptor, read_optional};
use crate::border::fork;
use crate::border::host::{HostLoop, HostSpawn};
use crate::border::log::{self, HostLog};
use crate::border::memory::Memory;
use crate::border::registry::{self, handle};
use crate::runtime::allocator;

pub use crate::border::host::{RlvLoop, RlvLoopBody, RlvSpawn, RlvTask};
pub use crate::border::log::RlvLog;
pub use crate::border::memory::RlvMemoryMonitor;

handle!(RlvContext, 1, ContextObject);

constants! {
    u32:
    RLV_DEVICE_CPU = 0,
    RLV_DEVICE_GPU = 1,
    RLV_DEVICE_AUTO = 2,
    RLV_PROGRESS_CONTINUE = 0,
    RLV_PROGRESS_CANCEL = 1,
    RLV_LOG_INFO = 0,
    RLV_LOG_WARNING = 1,
    RLV_NAME_SIZE = 48,
    RLV_TEXT_SIZE = 256,
}

descriptor! {
    pub struct RlvContextOptions {
        struct_size: u32,
        device: u32,
        threads: u32,
        reserved: u32,
        memory_limit: u64,
        device_memory_limit: u64,
        adapter: *const c_char,
        shared: RlvContext,
        host_loop: RlvLoop,
        host_spawn: RlvSpawn,
        host_user: *mut c_void,
    }
}

descriptor! {
    pub struct RlvContextInfo {
        struct_size: u32,
        device: u32,
        threads: u32,
        reserved: u32,
        memory_limit: u64,
        simd: [u8; RLV_NAME_SIZE as usize],
        device_memory_limit: u64,
        device_memory: u64,
        adapter: [u8; RLV_TEXT_SIZE as usize],
        fallback: [u8; RLV_TEXT_SIZE as usize],
    }
}

descriptor! {
    pub struct RlvContextStat {
        stage: [u8; RLV_NAME_SIZE as usize],
        quantity: [u8; RLV_NAME_SIZE as usize],
        total: f64,
        samples: u64,
    }
}

/// `RlvProgress`: NULL, or a function that gets its user pointer, a fraction and a stage.
pub type RlvProgress = Option<unsafe extern "C" fn(*mut c_void, f32, *const c_char) -> u32>;

/// Sum and number of samples by stage and quantity.
type Totals = BTreeMap<(&'static str, &'static str), (f64, u64)>;

/// A graphics device, or why there is none though one was asked for.
pub type Opened = std::result::Result<Device, Option<Error>>;

/// A context with what only C needs of it.
pub struct ContextObject {
    pub context: Context,
    device: Opened,
    device_memory_limit: u64,
    /// How the host runs jobs, if it does.
    pub spawn: Option<HostSpawn>,
    /// The host's monitor of memory.
    pub memory: Arc<Memory>,
    log: Mutex<HostLog>,
    totals: Mutex<Totals>,
}

impl ContextObject {
    /// The graphics device that edits details, as long as nothing is wrong with it.
    pub fn device(&self) -> Option<&Device> {
        self.device.as_ref().ok().filter(|device| device.check().is_ok())
    }

    /// The graphics device, whatever became of it.
    ///
    /// # Errors
    /// Fails if there is none: with the reason why it was not opened, or with `Unsupported` if it was not asked for.
    pub fn opened_device(&self) -> Result<&Device> {
        self.device.as_ref().map_err(|reason| {
            let none = || Error::unsupported("it has no graphics device").advise("make it with RLV_DEVICE_GPU");
            reason.clone().unwrap_or_else(none).at("context")
        })
    }

    /// Why the processor works where a graphics device was asked for.
    fn fallback(&self) -> Option<String> {
        match &self.device {
            Ok(device) => device.check().err().map(|reason| reason.to_string()),
            Err(reason) => reason.as_ref().map(ToString::to_string),
        }
    }

    /// Sends a message to the host on the calling thread; a job's waits until the host asks for the job.
    pub fn log(&self, level: u32, text: &str) {
        if log::enqueue(level, text) {
            return;
        }
        // Copied out, so that a callback which calls back finds the lock free.
        let log = *self.log.lock().unwrap_or_else(PoisonError::into_inner);
        log.send(level, text);
    }

    /// Adds the events since the last call to the totals, so that the list of events stays short.
    fn settle(&self) -> std::sync::MutexGuard<'_, Totals> {
        let mut totals = self.totals.lock().unwrap_or_else(PoisonError::into_inner);
        self.add_events(&mut totals, 0);
        totals
    }

    /// Adds the events to the totals once there are many, so that calls of every frame need no more and more room.
    pub fn gather(&self) {
        if let Ok(mut totals) = self.totals.try_lock() {
            self.add_events(&mut totals, MANY_EVENTS);
        }
    }

    fn add_events(&self, totals: &mut Totals, least: usize) {
        self.context.stats().drain(least, |event| {
            let seconds = [("seconds", event.length.as_secs_f64())];
            let counts = event.counts.iter().map(|(name, value)| (*name, *value as f64));
            for (quantity, value) in seconds.into_iter().chain(counts) {
                let row = totals.entry((event.stage, quantity)).or_insert((0.0, 0));
                row.0 += value;
                row.1 += 1;
            }
        });
    }
}

/// Threads that a context may have.
pub const MAX_THREADS: u32 = 1024;

/// Events after which they are added up.
const MANY_EVENTS: usize = 256;

/// A host's progress callback.
pub struct HostProgress {
    pub callback: RlvProgress,
    pub user: *mut c_void,
}

impl Progress for HostProgress {
    fn report(&mut self, fraction: f32, stage: &str) -> bool {
        let Some(callback) = self.callback else { return true };
        let stage = CString::new(stage.replace('\0', " ")).unwrap_or_default();
        // SAFETY: the host gave this function for this pointer, and the text lives through the call.
        unsafe { callback(self.user, fraction, stage.as_ptr()) == RLV_PROGRESS_CONTINUE }
    }
}

/// The graphics device that is asked for; `unnamed` is which, if it has no name.
///
/// # Safety
/// The adapter is NULL or a NUL-terminated text.
unsafe fn open(options: &RlvContextOptions, unnamed: AdapterChoice) -> Result<Device> {
    // SAFETY: promised by the caller.
    let name = if options.adapter.is_null() { "" } else { unsafe { text("adapter", options.adapter) }? };
    let adapter = if name.is_empty() { unnamed } else { AdapterChoice::Named(name.to_owned()) };
    let options = DeviceOptions { adapter, timing: false, memory_limit: options.device_memory_limit };
    Device::open(&options).map_err(|error| error.at("device"))
}

/// The executor that is asked for: on threads of its own, of another context, or of the host.
fn executor_of(given: &RlvContextOptions) -> Result<Context> {
    if given.threads > MAX_THREADS {
        return Err(Error::invalid(format!("{} threads are too many", given.threads))
            .at("threads")
            .advise(format!("ask for at most {MAX_THREADS}, or 0 for one per core")));
    }
    let threads = given.threads as usize;
    if given.shared.id != 0 {
        if given.host_loop.is_some() || threads != 0 {
            return Err(Error::invalid("a context that shares threads has none of its own")
                .at("shared")
                .advise("leave threads 0 and host_loop NULL"));
        }
        return Context::sharing(&registry::get(given.shared)?.context, given.memory_limit);
    }
    let Some(run) = given.host_loop else {
        return Context::new(&ContextOptions { threads, memory_limit: given.memory_limit });
    };
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = if threads == 0 { cores() } else { threads };
    Context::scheduled(Arc::new(HostLoop { run, user: given.host_user, threads }), given.memory_limit)
}

/// The options in a descriptor, the defaults for NULL.
///
/// # Errors
/// Fails with `Invalid` if `struct_size` is none of the type, and with `Unsupported` if a field that this library lacks
/// is not zero.
///
/// # Safety
/// It is NULL or a descriptor that starts with its size.
pub unsafe fn read(options: *const RlvContextOptions) -> Result<RlvContextOptions> {
    let default = RlvContextOptions {
        struct_size: 0,
        device: RLV_DEVICE_CPU,
        threads: 0,
        reserved: 0,
        memory_limit: 0,
        device_memory_limit: 0,
        adapter: std::ptr::null(),
        shared: RlvContext { id: 0 },
        host_loop: None,
        host_spawn: None,
        host_user: std::ptr::null_mut(),
    };
    // SAFETY: promised by the caller.
    unsafe { read_optional(options, default) }
}

/// Makes a context with the device that `open` returns, or with the reason why there is none.
///
/// # Errors
/// Fails with `Invalid` if there are too many threads, or some beside those of a context that is shared; as
/// [`Context::new`] does; and as `open` does.
pub fn make(given: &RlvContextOptions, open: impl FnOnce() -> Result<Opened>) -> Result<RlvContext> {
    fork::watch();
    allocator::settle();
    let context = executor_of(given)?;
    registry::insert(ContextObject {
        context,
        device: open()?,
        device_memory_limit: given.device_memory_limit,
        spawn: given.host_spawn.map(|spawn| HostSpawn { spawn, user: given.host_user }),
        memory: Arc::default(),
        log: Mutex::new(HostLog { callback: None, user: std::ptr::null_mut() }),
        totals: Mutex::default(),
    })
}

entry! {
    fn rlv_context_create(options: *const RlvContextOptions, out: *mut RlvContext) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read(options) }?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let open = |unnamed| unsafe { open(&given, unnamed) };
        let handle = make(&given, || match given.device {
            RLV_DEVICE_CPU => Ok(Err(None)),
            RLV_DEVICE_GPU => Ok(Ok(open(AdapterChoice::Best)?)),
            RLV_DEVICE_AUTO => Ok(open(AdapterChoice::Hardware).map_err(Some)),
            other => Err(Error::invalid(format!("{other} is no device")).at("device").advise("use an RLV_DEVICE_ value")),
        })?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_context_retain(context: RlvContext) {
        registry::retain(context)
    }

    fn rlv_context_release(context: RlvContext) {
        registry::release(context)
    }

    fn rlv_context_info(context: RlvContext, out: *mut RlvContextInfo) {
        let object = registry::get(context)?;
        let limit = object.context.own_memory_limit();
        let fallback = object.fallback();
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe {
            write_fields!(out: RlvContextInfo {
                device: if object.device().is_some() { RLV_DEVICE_GPU } else { RLV_DEVICE_CPU },
                threads: u32::try_from(object.context.threads()).unwrap_or(u32::MAX),
                reserved: 0,
                memory_limit: if limit == u64::MAX { 0 } else { limit },
                device_memory_limit: object.device_memory_limit,
                device_memory: object.device.as_ref().map_or(0, Device::memory),
            } texts {
                simd: object.context.level().name(),
                adapter: object.device.as_ref().map_or("", |device| &device.summary().name),
                fallback: fallback.as_deref().unwrap_or(""),
            })
        }
    }

    fn rlv_context_close_device(context: RlvContext) {
        if let Ok(device) = &registry::get(context)?.device {
            device.abandon();
        }
        Ok(())
    }

    fn rlv_context_set_log(context: RlvContext, callback: RlvLog, user: *mut c_void) {
        let object = registry::get(context)?;
        *object.log.lock().unwrap_or_else(PoisonError::into_inner) = HostLog { callback, user };
        Ok(())
    }

    fn rlv_context_set_memory_monitor(context: RlvContext, callback: RlvMemoryMonitor, user: *mut c_void) {
        registry::get(context)?.memory.set(callback, user);
        Ok(())
    }

    fn rlv_context_stats(context: RlvContext, stats: *mut RlvContextStat, capacity: usize, count: *mut usize) {
        present("count", count)?;
        // SAFETY: the caller gives room for `capacity` rows, or NULL to ask for the count alone.
        let stats = unsafe { Output::optional("stats", stats, capacity, 0) }?;
        let object = registry::get(context)?;
        let totals = object.settle();
        // SAFETY: checked above.
        unsafe { put(count, totals.len()) };
        if let Some(stats) = stats {
            stats.holds("stats", totals.len())?.fill(totals.iter().map(|((stage, quantity), (total, samples))| {
                RlvContextStat { stage: fixed(stage), quantity: fixed(quantity), total: *total, samples: *samples }
            }));
        }
        Ok(())
    }

    fn rlv_context_reset_stats(context: RlvContext) {
        registry::get(context)?.settle().clear();
        Ok(())
    }
}

impl Default for RlvContextStat {
    fn default() -> Self {
        Self { stage: fixed(""), quantity: fixed(""), total: 0.0, samples: 0 }
    }
}

// SAFETY: bytes, then a double and an integer at a multiple of eight: no padding, no invalid patterns.
unsafe impl crate::border::array::Plain for RlvContextStat {}

/// The object of a context handle and its executor.
///
/// # Errors
/// Fails with `Invalid` if the handle is NULL, dead or of another noun.
pub fn executor(context: RlvContext) -> Result<(std::sync::Arc<ContextObject>, Context)> {
    let object = registry::get(context)?;
    let executor = object.context.clone();
    Ok((object, executor))
}
