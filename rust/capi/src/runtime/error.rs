//! Results and the calling thread's last error; see `include/relievo/error.h`.

use std::cell::RefCell;
use std::ffi::{CString, c_char};

use relievo_core::{Error, ErrorKind};

use crate::border::descriptor::write_descriptor;
use crate::border::element;

pub type RlvResult = i32;

constants! {
    i32:
    RLV_OK = 0,
    RLV_ERROR_INVALID = 1,
    RLV_ERROR_UNSUPPORTED = 2,
    RLV_ERROR_NOT_FOUND = 3,
    RLV_ERROR_IO = 4,
    RLV_ERROR_MEMORY = 5,
    RLV_ERROR_BUSY = 6,
    RLV_ERROR_CANCELLED = 7,
    RLV_ERROR_INTERNAL = 8,
    RLV_ERROR_DEVICE = 9,
    RLV_ELEMENT_NONE = 0,
    RLV_ELEMENT_POINT = 1,
    RLV_ELEMENT_CORNER = 2,
    RLV_ELEMENT_EDGE = 3,
    RLV_ELEMENT_FACE = 4,
    RLV_ELEMENT_TRIANGLE = 5,
    RLV_ELEMENT_TILE = 6,
    RLV_ELEMENT_PATCH = 7,
    RLV_ELEMENT_ITEM = 8,
    RLV_ELEMENT_PARTICLE = 9,
    RLV_ELEMENT_LINE = 10,
    RLV_ELEMENT_PIN = 11,
    RLV_ELEMENT_CREASE = 12,
}

descriptor! {
    pub struct RlvError {
        struct_size: u32,
        result: i32,
        message: *const c_char,
        what: *const c_char,
        place: *const c_char,
        remedy: *const c_char,
        code: u32,
        element_kind: u32,
        element: u64,
    }
}

/// The texts that the pointers of [`RlvError`] point into.
struct Last {
    result: RlvResult,
    message: CString,
    what: CString,
    place: CString,
    remedy: CString,
    code: u32,
    element: (u32, u64),
}

thread_local! {
    static LAST: RefCell<Last> = RefCell::new(Last {
        result: RLV_OK,
        message: CString::default(),
        what: CString::default(),
        place: CString::default(),
        remedy: CString::default(),
        code: 0,
        element: (RLV_ELEMENT_NONE as u32, 0),
    });
}

pub fn result_of(kind: ErrorKind) -> RlvResult {
    match kind {
        ErrorKind::Invalid => RLV_ERROR_INVALID,
        ErrorKind::Unsupported => RLV_ERROR_UNSUPPORTED,
        ErrorKind::NotFound => RLV_ERROR_NOT_FOUND,
        ErrorKind::Io => RLV_ERROR_IO,
        ErrorKind::Memory => RLV_ERROR_MEMORY,
        ErrorKind::Busy => RLV_ERROR_BUSY,
        ErrorKind::Cancelled => RLV_ERROR_CANCELLED,
        ErrorKind::Internal => RLV_ERROR_INTERNAL,
        ErrorKind::Device => RLV_ERROR_DEVICE,
    }
}

/// A C string of `text`; NUL characters, which only hostile input has, become spaces.
fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

/// Makes `failure` the last error of this thread.
pub fn remember(failure: Error) -> RlvResult {
    let result = result_of(failure.kind);
    // A thread that is being torn down has no last error any more; the result still says what kind it was.
    let _ = LAST.try_with(|last| {
        *last.borrow_mut() = Last {
            result,
            message: c_string(&failure.to_string()),
            what: c_string(&failure.what),
            place: c_string(&failure.place),
            remedy: c_string(&failure.remedy),
            code: element::code(&failure.what),
            element: element::element(&failure.place, &failure.what),
        };
    });
    result
}

#[unsafe(no_mangle)]
pub extern "C" fn rlv_error_last() -> *const c_char {
    // The text lives until this thread's next failure; C reads it before.
    LAST.try_with(|last| last.borrow().message.as_ptr()).unwrap_or(c"".as_ptr())
}

entry! {
    fn rlv_error_get(out: *mut RlvError) {
        LAST.with(|last| {
            let last = last.borrow();
            let error = RlvError {
                struct_size: 0,
                result: last.result,
                message: last.message.as_ptr(),
                what: last.what.as_ptr(),
                place: last.place.as_ptr(),
                remedy: last.remedy.as_ptr(),
                code: last.code,
                element_kind: last.element.0,
                element: last.element.1,
            };
            // SAFETY: the caller gives a descriptor that starts with its size, or NULL.
            unsafe { write_descriptor(out, error) }
        })
    }
}
