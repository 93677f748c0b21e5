//! How a long call of the module runs: threads, progress and cancelling; and its errors.

use std::ffi::{c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use relievo_core::{Context, Error, ErrorKind, Progress, Result};

use crate::abi;

/// An error record for one call.
pub(crate) fn record() -> abi::RlvdbError {
    abi::RlvdbError { text: [0; 512] }
}

/// Turns a result of the module into ours.
pub(crate) fn check(result: i32, error: &abi::RlvdbError) -> Result<()> {
    let kind = match result as u32 {
        abi::RLVDB_OK => return Ok(()),
        abi::RLVDB_CANCELLED => return Err(Error::new(ErrorKind::Cancelled, "the caller cancelled the operation")),
        abi::RLVDB_MEMORY => ErrorKind::Memory,
        abi::RLVDB_INVALID => ErrorKind::Invalid,
        abi::RLVDB_NOT_FOUND => ErrorKind::NotFound,
        _ => ErrorKind::Internal,
    };
    Err(Error::new(kind, format!("OpenVDB: {}", text(&error.text))))
}

/// Returns a text that ends with a zero.
pub(crate) fn text(bytes: &[c_char]) -> String {
    let bytes: Vec<u8> = bytes.iter().take_while(|byte| **byte != 0).map(|byte| *byte as u8).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// What the callback of a call reaches.
struct Watch<'a> {
    progress: &'a mut dyn Progress,
    stage: &'static str,
    fraction: f32,
    panic: Option<Box<dyn std::any::Any + Send>>,
}

/// The callback: percentages become fractions that never fall.
unsafe extern "C" fn report(user: *mut c_void, percent: i32) -> i32 {
    // SAFETY: `run` passed a watch that lives until the call returns, and the module calls back on this thread alone.
    let watch = unsafe { &mut *user.cast::<Watch>() };
    if percent >= 0 {
        watch.fraction = watch.fraction.max((percent as f32 / 100.0).min(1.0));
    }
    let reported = catch_unwind(AssertUnwindSafe(|| watch.progress.report(watch.fraction, watch.stage)));
    i32::from(reported.unwrap_or_else(|panic| {
        watch.panic = Some(panic);
        false
    }))
}

/// Runs a call of the module called `stage` in progress reports. It uses as many threads as the context has.
pub(crate) fn run(
    context: &Context,
    stage: &'static str,
    progress: &mut dyn Progress,
    call: impl FnOnce(&abi::RlvdbCall, &mut abi::RlvdbError) -> i32,
) -> Result<()> {
    let mut watch = Watch { progress, stage, fraction: 0.0, panic: None };
    let user = (&raw mut watch).cast();
    let how = abi::RlvdbCall { threads: context.threads().max(1) as u32, user, progress: Some(report) };
    let mut error = record();
    let result = call(&how, &mut error);
    if let Some(panic) = watch.panic {
        resume_unwind(panic);
    }
    check(result, &error).map_err(|error| error.at(stage))
}
