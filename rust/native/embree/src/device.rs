//! An Embree device: what scenes and geometries are made from.

use std::ffi::{CStr, c_char, c_void};
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

impl Device {
    /// Makes a device.
    ///
    /// # Errors
    /// Embree is missing, of another version, or makes no device.
    pub fn new() -> Result<Self> {
        let table = table()?;
        let handle = match &table.arena {
            Some(arena) => {
                let made = std::sync::atomic::AtomicPtr::new(std::ptr::null_mut());
                arena.run(&|| {
                    // SAFETY: the configuration is a terminated string.
                    let handle = unsafe { table.embree.rtcNewDevice(c"set_affinity=0".as_ptr()) };
                    made.store(handle, std::sync::atomic::Ordering::Release);
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
        Ok(Self { inner: Arc::new(Inner { table, handle, message }) })
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
