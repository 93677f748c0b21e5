//! An opened graphics device: its limits, its memory, its pipelines, and what went wrong on it.
//!
//! wgpu tells of errors in three ways: scopes around calls, a callback for what no scope caught, a callback when the
//! device is lost. All end in one place here, and every call that hands out a result looks there first. A fault stays:
//! what was computed since the last good submission cannot be trusted, so the device is to be opened anew, and the
//! processor goes on from the last committed state.

use std::collections::BTreeMap;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context as TaskContext, Poll, Waker};
use std::time::Duration;

use relievo_core::{Error, ErrorKind, Result};
use wgpu::{ErrorFilter, Features, PollType};

use crate::adapter::{AdapterSummary, DeviceOptions};
use crate::choice::{NEEDED, choose};
use crate::kernel::Kernel;
use crate::kernel_spec::Access;
use crate::timing::TimingSet;

/// A graphics device. Cloning it is cheap and shares it; it may be used from several threads.
#[derive(Clone)]
pub struct Device {
    inner: Arc<Inner>,
}

/// Longest wait for a submission. A driver resets a hung device long before.
const PATIENCE: Duration = Duration::from_secs(120);

pub(crate) struct Inner {
    instance: wgpu::Instance,
    adapter: wgpu::Adapter,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    summary: AdapterSummary,
    limits: wgpu::Limits,
    timing: bool,
    memory_limit: u64,
    memory: Arc<AtomicU64>,
    fault: Arc<Mutex<Option<Error>>>,
    pub(crate) kernels: Mutex<BTreeMap<String, Arc<Kernel>>>,
    pub(crate) layouts: Mutex<BTreeMap<Vec<Access>, wgpu::BindGroupLayout>>,
    pub(crate) timings: Mutex<Vec<TimingSet>>,
    pub(crate) readbacks: Mutex<Vec<wgpu::Buffer>>,
}

impl fmt::Debug for Device {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_tuple("Device").field(&self.inner.summary).finish()
    }
}

/// The result of a future that wgpu completes at once on everything but the web.
pub(crate) fn ready<T>(future: impl Future<Output = T>) -> Option<T> {
    match pin!(future).poll(&mut TaskContext::from_waker(Waker::noop())) {
        Poll::Ready(value) => Some(value),
        Poll::Pending => None,
    }
}

/// The content of a lock. What it guards is whole after every statement, so a panic elsewhere does not spoil it.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn lost(message: &str) -> Error {
    Error::new(ErrorKind::Device, format!("the graphics device was lost: {message}"))
        .advise("open it again, or go on with the device `cpu`; what was committed is kept")
}

fn error_of(error: &wgpu::Error) -> Error {
    match error {
        wgpu::Error::OutOfMemory { .. } => Error::memory("the graphics device is out of memory")
            .advise("use smaller tiles or a coarser level, close other programs, or use the device `cpu`"),
        wgpu::Error::Validation { description, .. } => {
            Error::internal(format!("the graphics device refused a command: {description}"))
        }
        wgpu::Error::Internal { description, .. } => {
            Error::new(ErrorKind::Device, format!("the graphics driver failed: {description}"))
                .advise("update the driver, or use the device `cpu`")
        }
    }
}

impl Device {
    /// Opens a device.
    ///
    /// # Errors
    /// Fails with `NotFound` if no adapter is as `options` say, with `Unsupported` if it has no immediate data, which
    /// every kernel needs, and with `Device` if the driver refuses to open it.
    pub fn open(options: &DeviceOptions) -> Result<Self> {
        let (instance, adapter, summary) = choose(&options.adapter)?;
        if !summary.is_usable {
            return Err(Error::unsupported(format!("{summary} has no immediate data (push constants)"))
                .advise("update the driver, or use the device `cpu`"));
        }
        let opened = ready(adapter.request_device(&Self::descriptor(&adapter)))
            .ok_or_else(|| Error::internal("a request for a graphics device did not end"))?;
        let (device, queue) = opened.map_err(|error| {
            Error::new(ErrorKind::Device, format!("{summary} cannot be opened: {error}"))
                .advise("update the driver, or use the device `cpu`")
        })?;
        Ok(Self::assemble(instance, adapter, summary, device, queue, options))
    }

    /// What is asked of a device that has the features `there`.
    pub(crate) fn features(there: Features) -> Features {
        let optional = Features::TIMESTAMP_QUERY
            | Features::POLYGON_MODE_LINE
            | Features::FLOAT32_FILTERABLE
            | Features::VERTEX_WRITABLE_STORAGE;
        NEEDED | (optional & there)
    }

    /// How a device is opened on an adapter.
    pub(crate) fn descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
        wgpu::DeviceDescriptor {
            label: Some("relievo"),
            required_features: Self::features(adapter.features()),
            required_limits: adapter.limits(),
            ..Default::default()
        }
    }

    /// The device that wgpu opened, with a place for what goes wrong on it.
    pub(crate) fn assemble(
        instance: wgpu::Instance,
        adapter: wgpu::Adapter,
        summary: AdapterSummary,
        device: wgpu::Device,
        queue: wgpu::Queue,
        options: &DeviceOptions,
    ) -> Self {
        let fault = Arc::new(Mutex::new(None));
        let keep = |fault: &Arc<Mutex<Option<Error>>>| {
            let fault = Arc::clone(fault);
            move |error: Error| {
                lock(&fault).get_or_insert(error);
            }
        };
        let uncaptured = keep(&fault);
        device.on_uncaptured_error(Arc::new(move |error| uncaptured(error_of(&error))));
        let gone = keep(&fault);
        device.set_device_lost_callback(move |_, message| gone(lost(message.trim())));
        let inner = Inner {
            limits: adapter.limits(),
            timing: options.timing && adapter.features().contains(Features::TIMESTAMP_QUERY),
            instance,
            adapter,
            device,
            queue,
            summary,
            memory_limit: if options.memory_limit == 0 { u64::MAX } else { options.memory_limit },
            memory: Arc::new(AtomicU64::new(0)),
            fault,
            kernels: Mutex::default(),
            layouts: Mutex::default(),
            timings: Mutex::default(),
            readbacks: Mutex::default(),
        };
        Self { inner: Arc::new(inner) }
    }

    /// The adapter it was opened on.
    pub fn summary(&self) -> &AdapterSummary {
        &self.inner.summary
    }

    /// What the device can do at most.
    pub fn limits(&self) -> &wgpu::Limits {
        &self.inner.limits
    }

    /// Whether passes are timed.
    pub fn is_timed(&self) -> bool {
        self.inner.timing
    }

    /// Whether it is the same opened device as `other`.
    pub fn is_same(&self, other: &Device) -> bool {
        Arc::ptr_eq(&self.inner, &other.inner)
    }

    /// Bytes of the buffers and textures that live on the device.
    pub fn memory(&self) -> u64 {
        self.inner.memory.load(Ordering::Relaxed)
    }

    /// The device of wgpu, for pipelines that draw.
    pub fn wgpu(&self) -> &wgpu::Device {
        &self.inner.device
    }

    /// The queue of wgpu.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.inner.queue
    }

    /// Makes a surface that presents pictures of `size` pixels in a window, with its configuration, which is in no colour space.
    ///
    /// # Errors
    /// Fails with `Device` if the device cannot present 8-bit pictures to the display of the window, or was lost.
    pub fn surface(
        &self,
        window: wgpu::SurfaceTarget<'static>,
        size: [u32; 2],
    ) -> Result<(wgpu::Surface<'static>, wgpu::SurfaceConfiguration)> {
        let refused = |why: String| {
            Error::new(ErrorKind::Device, format!("{} cannot present to the display{why}", self.inner.summary))
                .advise("name another graphics device, or use the commands that need no display")
        };
        let made = self.guard(|| self.inner.instance.create_surface(window))?;
        let surface = made.map_err(|error| refused(format!(": {error}")))?;
        let known = surface.get_capabilities(&self.inner.adapter).formats;
        let wanted = [wgpu::TextureFormat::Bgra8Unorm, wgpu::TextureFormat::Rgba8Unorm];
        let format = wanted.into_iter().find(|it| known.contains(it)).ok_or_else(|| refused(String::new()))?;
        let configuration = surface.get_default_config(&self.inner.adapter, size[0], size[1]);
        let configuration = configuration.ok_or_else(|| refused(String::new()))?;
        Ok((surface, wgpu::SurfaceConfiguration { format, ..configuration }))
    }

    pub(crate) fn inner(&self) -> &Inner {
        &self.inner
    }

    /// Checks that nothing went wrong on the device since it was opened.
    ///
    /// # Errors
    /// Returns the first error that the device or its driver reported outside of [`Self::guard`]: of kind `Device` if
    /// it was lost.
    pub fn check(&self) -> Result<()> {
        match &*lock(&self.inner.fault) {
            Some(error) => Err(error.clone()),
            None => Ok(()),
        }
    }

    /// Lets the device go as if its driver had lost it: whatever is asked of it from now on fails.
    pub fn abandon(&self) {
        self.inner.device.destroy();
        lock(&self.inner.fault).get_or_insert(lost("it was abandoned"));
    }

    /// Counts `bytes` of a new buffer or texture, until the [`Charge`] ends.
    ///
    /// # Errors
    /// Fails with `Memory` above the limit; the count is then undone. Fails as [`Self::check`] does.
    pub fn charge(&self, bytes: u64) -> Result<Charge> {
        self.check()?;
        let memory = &self.inner.memory;
        let used = memory.fetch_add(bytes, Ordering::Relaxed);
        let charge = Charge { memory: Arc::clone(memory), bytes };
        if used.saturating_add(bytes) > self.inner.memory_limit {
            return Err(Error::memory(format!(
                "{bytes} bytes more than {used} are over the limit of {} on the graphics device",
                self.inner.memory_limit
            ))
            .advise("raise the limit, use smaller tiles, or use the device `cpu`"));
        }
        Ok(charge)
    }

    /// Runs `work`, which makes something on the device, and returns what it made.
    ///
    /// # Errors
    /// Fails with `Memory` if the device runs out of memory, with `Internal` if it refuses what `work` asks, with
    /// `Device` if its driver fails or it is lost, and as [`Self::check`] does.
    pub fn guard<T>(&self, work: impl FnOnce() -> T) -> Result<T> {
        self.check()?;
        let device = &self.inner.device;
        let scopes = [ErrorFilter::Internal, ErrorFilter::OutOfMemory, ErrorFilter::Validation]
            .map(|filter| device.push_error_scope(filter));
        let made = catch_unwind(AssertUnwindSafe(work));
        // Scopes end in the reverse of the order they began in.
        let errors: Vec<_> = scopes.into_iter().rev().filter_map(|scope| ready(scope.pop()).flatten()).collect();
        self.check()?;
        match (errors.first(), made) {
            (Some(error), _) => Err(error_of(error)),
            (None, Ok(made)) => Ok(made),
            (None, Err(_)) => Err(lost("its driver failed while something was made")),
        }
    }

    /// Waits until the submission, or everything submitted, is done.
    pub(crate) fn wait(&self, submission: Option<wgpu::SubmissionIndex>) -> Result<()> {
        self.check()?;
        let wait = PollType::Wait { submission_index: submission, timeout: Some(PATIENCE) };
        // wgpu panics where a lost device is waited for.
        let waited = catch_unwind(AssertUnwindSafe(|| self.inner.device.poll(wait)));
        self.check()?;
        match waited {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(error)) => Err(lost(&error.to_string())),
            Err(_) => Err(lost("its driver failed while it was waited for")),
        }
    }
}

/// Bytes counted as living on a device, until this is dropped.
#[derive(Debug)]
pub struct Charge {
    memory: Arc<AtomicU64>,
    bytes: u64,
}

impl Drop for Charge {
    fn drop(&mut self) {
        self.memory.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}
