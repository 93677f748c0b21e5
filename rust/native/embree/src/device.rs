//! An Embree device: what scenes and geometries are made from.

use std::ffi::{CStr, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicI64, AtomicPtr, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use relievo_core::{Error, Result};

use crate::abi::{
    RTCBufferType, RTCBuildQuality, RTCDevice, RTCError, RTCFormat, RTCGeometry, RTCGeometryType, RTCScene,
    RTCSceneFlags,
};
use crate::table::{Table, table};

/// An Embree device. Cloning it is cheap and shares it. It works on the threads that call it and starts none.
#[derive(Clone)]
pub struct Device {
    inner: Arc<Inner>,
}

struct Inner {
    table: &'static Table,
    handle: RTCDevice,
    message: Box<Message>,
    /// Boxed, since Embree has its address.
    #[expect(dead_code, reason = "called by Embree until the device is released")]
    monitor: Option<Box<Monitored>>,
}

/// Hears of bytes that Embree takes or, below 0, gives back, on any thread. Where it answers false to bytes above 0, these
/// are not given back later, and the call that needs them fails with [`ErrorKind::Memory`](relievo_core::ErrorKind::Memory).
pub type Monitor = Arc<dyn Fn(i64) -> bool + Send + Sync>;

/// A monitor and the refused bytes that Embree allocated nevertheless and will free: it asks before some allocations and
/// after others.
struct Monitored {
    monitor: Monitor,
    refused: AtomicI64,
}

impl Monitored {
    fn ask(&self, bytes: i64, after: bool) -> bool {
        if bytes >= 0 {
            let granted = (self.monitor)(bytes);
            if !granted && after {
                self.refused.fetch_add(bytes, Ordering::Relaxed);
            }
            return granted;
        }
        let part = |refused: i64| Some(refused - refused.min(-bytes));
        let refused = self.refused.fetch_update(Ordering::Relaxed, Ordering::Relaxed, part).unwrap_or(0);
        let freed = bytes + refused.min(-bytes);
        freed == 0 || (self.monitor)(freed)
    }
}

/// The last error message, written by Embree's callback.
type Message = Mutex<Option<String>>;

// SAFETY: Embree devices may be used from several threads at once; the message is behind a lock.
unsafe impl Send for Inner {}
// SAFETY: as above.
unsafe impl Sync for Inner {}

unsafe extern "C" fn note_error(user: *mut c_void, code: RTCError, message: *const c_char) {
    // SAFETY: `user` is the device's message, which outlives the device; Embree passes a terminated string or null.
    let (slot, text) = unsafe {
        let text = if message.is_null() { "".into() } else { CStr::from_ptr(message).to_string_lossy() };
        (&*user.cast::<Message>(), text.into_owned())
    };
    *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(format!("{text} (Embree's error {code})"));
}

unsafe extern "C" fn ask_monitor(user: *mut c_void, bytes: isize, after: bool) -> bool {
    // SAFETY: `user` is the device's monitor, which outlives the device.
    let monitored = unsafe { &*user.cast::<Monitored>() };
    catch_unwind(AssertUnwindSafe(|| monitored.ask(bytes as i64, after))).unwrap_or(true)
}

impl Device {
    /// Makes a device.
    ///
    /// # Errors
    /// Embree is missing, of another version, or makes no device.
    pub fn new() -> Result<Self> {
        Self::with_monitor(None)
    }

    /// Makes a device whose allocations `monitor` hears of.
    ///
    /// # Errors
    /// As for [`Self::new`].
    pub fn with_monitor(monitor: Option<Monitor>) -> Result<Self> {
        let table = table()?;
        let handle = match &table.arena {
            Some(arena) => {
                let made = AtomicPtr::new(std::ptr::null_mut());
                arena.run(&|| {
                    // SAFETY: the configuration is a terminated string.
                    let handle = unsafe { table.embree.rtcNewDevice(c"set_affinity=0".as_ptr()) };
                    made.store(handle, Ordering::Release);
                });
                made.into_inner()
            }
            // Where Embree brings its own scheduler, its option concerns nobody else.
            // SAFETY: the configuration is a terminated string.
            None => unsafe { table.embree.rtcNewDevice(c"threads=1,set_affinity=0".as_ptr()) },
        };
        if handle.is_null() {
            // SAFETY: a null device asks for the error of device creation.
            let code = unsafe { table.embree.rtcGetDeviceError(std::ptr::null_mut()) };
            return Err(Error::internal(format!("Embree makes no device (its error {code})")));
        }
        let message = Box::new(Message::default());
        // SAFETY: the message is boxed and lives as long as the device.
        unsafe {
            let message = std::ptr::from_ref(&*message).cast_mut().cast();
            table.embree.rtcSetDeviceErrorFunction(handle, Some(note_error), message);
        }
        let monitor = monitor.map(|monitor| Box::new(Monitored { monitor, refused: AtomicI64::new(0) }));
        if let Some(monitor) = &monitor {
            // SAFETY: the monitor is boxed and lives as long as the device.
            unsafe {
                let user = std::ptr::from_ref(&**monitor).cast_mut().cast();
                table.embree.rtcSetDeviceMemoryMonitorFunction(handle, Some(ask_monitor), user);
            }
        }
        Ok(Self { inner: Arc::new(Inner { table, handle, message, monitor }) })
    }

    /// Builds what changed in a scene, on the calling thread alone: outside of an arena TBB would start threads.
    ///
    /// # Safety
    /// The scene is alive, of this device, and nobody else uses it.
    pub(crate) unsafe fn commit(&self, scene: RTCScene) {
        let scene = AtomicPtr::new(scene);
        // SAFETY: promised by the caller.
        let commit = || unsafe { self.table().embree.rtcCommitScene(scene.load(Ordering::Acquire)) };
        match &self.table().arena {
            Some(arena) => arena.run(&commit),
            None => commit(),
        }
    }

    pub(crate) fn table(&self) -> &'static Table {
        self.inner.table
    }

    /// Fails if Embree has reported an error since the last call.
    pub(crate) fn check(&self) -> Result<()> {
        match self.inner.message.lock().unwrap_or_else(PoisonError::into_inner).take() {
            None => Ok(()),
            Some(message) if message.contains("memory") => Err(Error::memory(message)),
            Some(message) => Err(Error::internal(message)),
        }
    }

    pub(crate) fn scene(&self, flags: RTCSceneFlags, quality: RTCBuildQuality) -> Result<SceneOwner> {
        let embree = &self.table().embree;
        // SAFETY: the device is alive, and so is the scene it returns unless null.
        let handle = unsafe {
            let handle = embree.rtcNewScene(self.inner.handle);
            if !handle.is_null() {
                embree.rtcSetSceneFlags(handle, flags);
                embree.rtcSetSceneBuildQuality(handle, quality);
            }
            handle
        };
        self.check()?;
        let owner = SceneOwner { device: self.clone(), handle };
        if owner.handle.is_null() { Err(Error::memory("Embree makes no scene")) } else { Ok(owner) }
    }

    pub(crate) fn geometry(&self, kind: RTCGeometryType) -> Result<GeometryOwner> {
        // SAFETY: the device is alive.
        let handle = unsafe { self.table().embree.rtcNewGeometry(self.inner.handle, kind) };
        self.check()?;
        let owner = GeometryOwner { device: self.clone(), handle };
        if owner.handle.is_null() { Err(Error::memory("Embree makes no geometry")) } else { Ok(owner) }
    }
}

impl std::fmt::Debug for Device {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "Device(Embree {:?})", self.inner.table.version)
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: scenes and geometries hold the device, so none is left; the callback's data dies after the device.
        unsafe { self.table.embree.rtcReleaseDevice(self.handle) }
    }
}

/// A reference to an Embree scene.
pub(crate) struct SceneOwner {
    pub device: Device,
    pub handle: RTCScene,
}

// SAFETY: Embree scenes are not bound to a thread.
unsafe impl Send for SceneOwner {}
// SAFETY: a shared scene is only traced, which may happen from any number of threads.
unsafe impl Sync for SceneOwner {}

impl Drop for SceneOwner {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: this owner holds one reference.
            unsafe { self.device.table().embree.rtcReleaseScene(self.handle) }
        }
    }
}

/// A reference to an Embree geometry.
pub(crate) struct GeometryOwner {
    pub device: Device,
    pub handle: RTCGeometry,
}

// SAFETY: Embree geometries are not bound to a thread.
unsafe impl Send for GeometryOwner {}
// SAFETY: a shared geometry is only read.
unsafe impl Sync for GeometryOwner {}

impl Drop for GeometryOwner {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: this owner holds one reference.
            unsafe { self.device.table().embree.rtcReleaseGeometry(self.handle) }
        }
    }
}

impl GeometryOwner {
    /// Makes a buffer of `count` items of `stride` bytes, which may be a power of two above the item, and fills it.
    pub fn fill<T: Copy>(&self, kind: RTCBufferType, format: RTCFormat, items: &[T]) -> Result<()> {
        if items.is_empty() {
            return Ok(());
        }
        let stride = size_of::<T>();
        let embree = &self.device.table().embree;
        // SAFETY: the geometry is alive.
        let data = unsafe { embree.rtcSetNewGeometryBuffer(self.handle, kind, 0, format, stride, items.len()) };
        self.device.check()?;
        if data.is_null() {
            return Err(Error::memory(format!("Embree has no room for {} items of {stride} bytes", items.len())));
        }
        // SAFETY: Embree made room for `len` items of `stride` bytes, aligned to at least 16; nobody else writes there.
        unsafe { std::ptr::copy_nonoverlapping(items.as_ptr(), data.cast::<T>(), items.len()) };
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    /// A grid of 2 × 60 × 60 triangles.
    fn build(device: &Device) -> Result<Scene> {
        let points: Vec<[f32; 3]> = (0..61 * 61).map(|k| [(k % 61) as f32, (k / 61) as f32, 0.0]).collect();
        let triangles: Vec<[u32; 3]> = (0..60 * 60)
            .map(|k| k / 60 * 61 + k % 60)
            .flat_map(|first| [[first, first + 1, first + 62], [first, first + 62, first + 61]])
            .collect();
        let mut scene = Scene::new(device)?;
        let object = scene.add_object()?;
        scene.set_mesh(object, 0, &points, &triangles)?;
        scene.commit()?;
        Ok(scene)
    }

    #[test]
    fn a_monitor_hears_of_every_byte_and_refuses() {
        let (taken, most) = (Arc::new(AtomicI64::new(0)), Arc::new(AtomicI64::new(i64::MAX)));
        let (sum, limit) = (Arc::clone(&taken), Arc::clone(&most));
        let monitor: Monitor = Arc::new(move |bytes| {
            let granted = bytes <= 0 || sum.load(Ordering::Relaxed) + bytes <= limit.load(Ordering::Relaxed);
            if granted {
                sum.fetch_add(bytes, Ordering::Relaxed);
            }
            granted
        });
        let device = Device::with_monitor(Some(monitor)).unwrap();
        let empty = taken.load(Ordering::Relaxed);
        drop(build(&device).unwrap());
        assert_eq!(taken.load(Ordering::Relaxed), empty);
        let scene = build(&device).unwrap();
        let whole = taken.load(Ordering::Relaxed) - empty;
        assert!(whole > 12 * 61 * 61 + 12 * 2 * 60 * 60);
        drop(scene);
        for share in 0..4 {
            most.store(empty + whole * share / 4, Ordering::Relaxed);
            let refused = build(&device).err().map(|error| error.kind);
            assert_eq!(refused, Some(relievo_core::ErrorKind::Memory));
            assert_eq!(taken.load(Ordering::Relaxed), empty, "after a share of {share} in 4");
        }
        most.store(i64::MAX, Ordering::Relaxed);
        drop(build(&device).unwrap());
        drop(device);
        assert_eq!(taken.load(Ordering::Relaxed), 0);
    }
}
