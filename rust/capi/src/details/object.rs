//! Any object: whether a call is at work on it, and waiting until none is; see `include/relievo/object.h`.

use std::time::Duration;

use relievo_core::{Error, Result};

use crate::border::array::fixed;
use crate::border::descriptor::{check_optional, write_optional};
use crate::border::registry;
use crate::border::work;
use crate::runtime::context::RLV_NAME_SIZE;

descriptor! {
    pub struct RlvObjectInfo {
        struct_size: u32,
        is_busy: u32,
        noun: [u8; RLV_NAME_SIZE as usize],
        worker: [u8; RLV_NAME_SIZE as usize],
    }
}

/// The time that C gives as seconds; `None` for as long as it takes.
///
/// # Errors
/// Fails with `Invalid` if it is negative but not -1, or not a number.
pub fn duration(seconds: f64) -> Result<Option<Duration>> {
    if seconds == -1.0 {
        return Ok(None);
    }
    // Longer than a process lives is as long as it takes.
    match Duration::try_from_secs_f64(seconds) {
        Ok(time) => Ok(Some(time)),
        Err(_) if seconds.is_finite() && seconds > 0.0 => Ok(None),
        Err(_) => Err(Error::invalid(format!("{seconds} seconds cannot be waited for"))
            .at("seconds")
            .advise("use -1 for as long as it takes, or 0 or more")),
    }
}

entry! {
    fn rlv_object_wait(id: u64, seconds: f64, out: *mut RlvObjectInfo) {
        let time = duration(seconds)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { check_optional(out) }?;
        let (noun, object) = registry::any(id)?;
        let first = std::ptr::from_ref(&*object).cast::<u8>().addr();
        let worker = work::wait(&(first..first + size_of_val(&*object)), time);
        let info = RlvObjectInfo {
            struct_size: 0,
            is_busy: u32::from(worker.is_some()),
            noun: fixed(noun),
            worker: fixed(worker.unwrap_or("")),
        };
        // SAFETY: as above.
        unsafe { write_optional(out, info) }
    }
}
