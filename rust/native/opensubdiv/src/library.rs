//! Opens the private copy of OpenSubdiv that the build made.
//!
//! A host that has OpenSubdiv too, of the same version even, would otherwise answer our calls and the calls that the
//! library makes among its own functions: the dynamic linker looks a name up in the program first. The copy has names
//! of its own (`build/copy.rs`), and is part of this program as bytes, so that there is no second file to install or to
//! find. It is opened from memory when it is first needed; our calls go to it through a table (`build/jumps.rs`).

use std::ffi::{CStr, c_void};
use std::fs::File;
use std::io::Write;
use std::os::fd::FromRawFd;
use std::path::Path;
use std::sync::{Mutex, OnceLock, PoisonError};

use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
use relievo_core::{Error, ErrorKind, Result};

/// The file of the copy.
static COPY: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/opensubdiv.so"));

include!(concat!(env!("OUT_DIR"), "/symbols.rs"));

/// Opens the copy, once per process. Every function that makes a C++ object calls this first.
///
/// # Errors
/// The system gives neither memory nor a temporary file that can be executed, or lacks the C++ library.
pub fn open() -> Result<()> {
    static OPENED: OnceLock<()> = OnceLock::new();
    /// Held while it is opened, so that it is opened once. A failure is not kept: the next call tries again.
    static OPENING: Mutex<()> = Mutex::new(());
    if OPENED.get().is_some() {
        return Ok(());
    }
    let _guard = OPENING.lock().unwrap_or_else(PoisonError::into_inner);
    if OPENED.get().is_none() {
        fill(in_memory().or_else(|_| in_folder(&std::env::temp_dir()))?)?;
        OPENED.get_or_init(|| ());
    }
    Ok(())
}

/// Opens the copy from a file in memory.
fn in_memory() -> Result<Library> {
    // SAFETY: the name is a string; the result is checked before it is used.
    let made = |flags| unsafe { libc::memfd_create(c"relievo-opensubdiv".as_ptr(), libc::MFD_CLOEXEC | flags) };
    // Kernels before 6.3 do not know the flag, which newer ones may demand of what is executed.
    let number = match made(libc::MFD_EXEC) {
        -1 => made(0),
        number => number,
    };
    if number == -1 {
        return Err(failed("the system gives no file in memory", &std::io::Error::last_os_error()));
    }
    // SAFETY: the number is that of a file that was just made and belongs to nobody else.
    let mut file = unsafe { File::from_raw_fd(number) };
    file.write_all(COPY).map_err(|error| failed("there is no memory for it", &error))?;
    let library = load(Path::new(&format!("/proc/{}/fd/{number}", std::process::id())))?;
    // It stays open: the dynamic linker takes a file of the same path for this one.
    std::mem::forget(file);
    Ok(library)
}

/// Opens the copy from a file in `folder`, which is removed at once.
fn in_folder(folder: &Path) -> Result<Library> {
    let mut file = tempfile::Builder::new().prefix("relievo-").suffix(".so").tempfile_in(folder).map_err(unwritten)?;
    file.write_all(COPY).map_err(unwritten)?;
    load(file.path())
}

fn unwritten(error: std::io::Error) -> Error {
    failed("no temporary file can be written", &error)
}

fn load(path: &Path) -> Result<Library> {
    // SAFETY: its constructors fill tables of its own and do nothing else.
    unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) }.map_err(|error| {
        let cause = std::error::Error::source(&error).map_or(error.to_string(), ToString::to_string);
        failed("the dynamic linker refuses it", &cause)
    })
}

/// Fills the tables that the C++ side reaches the copy through, and keeps it loaded.
fn fill(library: Library) -> Result<()> {
    let find = |name: &CStr| {
        // SAFETY: the address alone is taken; the C++ side uses it with the type that the name encodes.
        let symbol = unsafe { library.get::<*mut c_void>(name.to_bytes()) };
        symbol.map(|symbol| symbol.as_raw_ptr()).map_err(|error| failed("it lacks a symbol", &error))
    };
    for (name, size, room) in objects() {
        let object = find(name)?;
        // SAFETY: both are as large as the symbol says, and the room is read only after this function has returned.
        unsafe { std::ptr::copy_nonoverlapping(object.cast::<u8>(), room, size) };
    }
    for (number, name) in FUNCTIONS.iter().enumerate() {
        let function = find(name)?;
        // SAFETY: the table has as many entries as there are names, and is read only after this function has returned.
        unsafe { relievo_opensubdiv_functions[number] = function };
    }
    std::mem::forget(library);
    Ok(())
}

fn failed(what: &str, cause: &dyn std::fmt::Display) -> Error {
    Error::new(ErrorKind::NotFound, format!("the copy of OpenSubdiv within Relievo cannot be opened: {what}: {cause}"))
        .advise("allow files in memory, or a folder for temporary files, to be executed")
}
