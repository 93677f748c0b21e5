//! Bytes in memory in place of a file; see `include/relievo/bytes.h`.

use relievo_core::Result;

use crate::border::array::{Input, present, put};
use crate::border::registry::{self, handle};

handle!(RlvBytes, 34, BytesObject);

/// What a file would hold. Empty bytes point to a place that is not NULL, as those of a vector always do.
pub struct BytesObject(Vec<u8>);

/// Makes an object of bytes.
///
/// # Errors
/// Fails with `Memory` if there are too many objects.
pub fn register(bytes: Vec<u8>) -> Result<RlvBytes> {
    registry::insert(BytesObject(bytes))
}

/// Makes an object of bytes and writes its handle to `out`.
///
/// # Errors
/// As for [`register`].
///
/// # Safety
/// `out` is valid for a write.
pub unsafe fn give(bytes: Vec<u8>, out: *mut RlvBytes) -> Result<()> {
    let handle = register(bytes)?;
    // SAFETY: promised by the caller.
    unsafe { put(out, handle) };
    Ok(())
}

/// A copy of the bytes that C lends.
///
/// # Errors
/// Fails with `Invalid` if the pointer is NULL and `size` is not 0, and with `Memory` if they are more than `limit` or
/// the machine does not have room for them.
///
/// # Safety
/// The caller promises `size` readable bytes, or NULL if `size` is 0.
pub unsafe fn take(bytes: *const u8, size: usize, limit: u64) -> Result<Vec<u8>> {
    // SAFETY: promised by the caller.
    unsafe { Input::new("bytes", bytes, size, 0) }?.to_vec("bytes", limit)
}

entry! {
    fn rlv_bytes_retain(bytes: RlvBytes) {
        registry::retain(bytes)
    }

    fn rlv_bytes_release(bytes: RlvBytes) {
        registry::release(bytes)
    }

    fn rlv_bytes_get(bytes: RlvBytes, data: *mut *const u8, size: *mut usize) {
        present("data", data)?;
        present("size", size)?;
        let object = registry::get(bytes)?;
        // SAFETY: checked above.
        unsafe {
            put(data, object.0.as_ptr());
            put(size, object.0.len());
        }
        Ok(())
    }
}
