//! The host's monitor of memory: it hears of what large objects take and give back, and can refuse.

use std::ffi::c_void;
use std::sync::{Arc, Mutex, PoisonError};

use relievo_core::{Error, Mesh, Result, Values};

/// `RlvMemoryMonitor`: NULL, or a function that gets its user pointer and bytes, and answers `RlvProgressAnswer`.
pub type RlvMemoryMonitor = Option<unsafe extern "C" fn(*mut c_void, i64) -> u32>;

#[derive(Clone, Copy)]
struct HostMonitor {
    callback: RlvMemoryMonitor,
    user: *mut c_void,
}

// SAFETY: the pointer is only handed back to its owner's callback, which the header says runs on any thread.
unsafe impl Send for HostMonitor {}

/// The monitor of a context, which its objects share.
pub struct Memory(Mutex<HostMonitor>);

impl Default for Memory {
    fn default() -> Self {
        Self(Mutex::new(HostMonitor { callback: None, user: std::ptr::null_mut() }))
    }
}

impl Memory {
    pub fn set(&self, callback: RlvMemoryMonitor, user: *mut c_void) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = HostMonitor { callback, user };
    }

    /// Tells the host of bytes that are taken or, below 0, given back; returns whether it lets them be taken.
    pub fn ask(&self, bytes: i64) -> bool {
        // Copied out, so that a callback which calls back finds the lock free.
        let monitor = *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: the host gave this function for this pointer.
        monitor.callback.is_none_or(|callback| unsafe { callback(monitor.user, bytes) == 0 })
    }

    /// Takes `bytes` for something called `noun`, until the result is dropped.
    ///
    /// # Errors
    /// Fails with `Memory` if the host's memory monitor refuses.
    pub fn admit(self: &Arc<Self>, noun: &str, bytes: u64) -> Result<Admitted> {
        let signed = i64::try_from(bytes).unwrap_or(i64::MAX);
        if !self.ask(signed) {
            return Err(Error::memory(format!("the host's memory monitor refuses {bytes} bytes"))
                .at(noun)
                .advise("release objects, or answer RLV_PROGRESS_CONTINUE"));
        }
        Ok(Admitted { memory: Arc::clone(self), bytes: signed })
    }
}

/// Bytes that the host let be taken.
pub struct Admitted {
    memory: Arc<Memory>,
    bytes: i64,
}

impl Drop for Admitted {
    fn drop(&mut self) {
        self.memory.ask(-self.bytes);
    }
}

/// Bytes of the arrays of a mesh.
pub fn mesh_bytes(mesh: &Mesh) -> u64 {
    let attributes = mesh.attributes.iter().map(|attribute| {
        let values = match &attribute.values {
            Values::F32(values) => values.len(),
            Values::U32(values) => values.len(),
        };
        4 * (values + attribute.indices.as_ref().map_or(0, Vec::len))
    });
    let own = 12 * mesh.points.len() + 4 * (mesh.face_sizes.len() + mesh.corners.len());
    (own + attributes.sum::<usize>()) as u64
}
