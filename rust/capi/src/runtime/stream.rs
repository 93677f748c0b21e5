//! Storage of the host; see `include/relievo/stream.h`.

use std::ffi::c_void;
use std::fmt;
use std::io::{Error as Failure, Read, Seek, SeekFrom, Write};

use relievo_core::{Error, Result};
use relievo_document::Storage;

use crate::border::descriptor::read_descriptor;

pub type RlvStreamRead = Option<unsafe extern "C" fn(*mut c_void, u64, *mut u8, usize) -> u32>;
pub type RlvStreamWrite = Option<unsafe extern "C" fn(*mut c_void, u64, *const u8, usize) -> u32>;
pub type RlvStreamLength = Option<unsafe extern "C" fn(*mut c_void, *mut u64) -> u32>;
pub type RlvStreamCut = Option<unsafe extern "C" fn(*mut c_void, u64) -> u32>;
pub type RlvStreamSync = Option<unsafe extern "C" fn(*mut c_void) -> u32>;
pub type RlvStreamClose = Option<unsafe extern "C" fn(*mut c_void)>;

descriptor! {
    pub struct RlvStream {
        struct_size: u32,
        reserved: u32,
        user: *mut c_void,
        read: RlvStreamRead,
        write: RlvStreamWrite,
        length: RlvStreamLength,
        cut: RlvStreamCut,
        sync: RlvStreamSync,
        close: RlvStreamClose,
    }
}

const NONE: RlvStream = RlvStream {
    struct_size: 0,
    reserved: 0,
    user: std::ptr::null_mut(),
    read: None,
    write: None,
    length: None,
    cut: None,
    sync: None,
    close: None,
};

/// A stream of the host, which is closed when it is dropped.
pub struct HostStream {
    stream: RlvStream,
    at: u64,
}

// SAFETY: the header says that callbacks run on the threads of calls, one at a time, and that `close` may run on any.
unsafe impl Send for HostStream {}

impl HostStream {
    /// Reads the callbacks of a stream.
    ///
    /// # Errors
    /// Fails with `Invalid` if the descriptor is NULL, its `struct_size` is none of the type, or a callback other than
    /// `close` is NULL, and with `Unsupported` if a field that this library lacks is not zero.
    ///
    /// # Safety
    /// `stream` is NULL or a descriptor that starts with its size, whose callbacks work as the header says until `close`.
    pub unsafe fn read(stream: *const RlvStream) -> Result<Box<Self>> {
        // SAFETY: promised by the caller.
        let stream = Box::new(Self { stream: unsafe { read_descriptor(stream, NONE) }?, at: 0 });
        let there = [
            ("read", stream.stream.read.is_some()),
            ("write", stream.stream.write.is_some()),
            ("length", stream.stream.length.is_some()),
            ("cut", stream.stream.cut.is_some()),
        ];
        match there.iter().find(|(_, there)| !there) {
            Some((name, _)) => {
                Err(Error::invalid("the callback is NULL").at(format!("stream.{name}")).advise("set it"))
            }
            None => Ok(stream),
        }
    }

    fn length(&self) -> std::io::Result<u64> {
        let mut length = 0;
        let callback = self.stream.length.ok_or(std::io::ErrorKind::Unsupported)?;
        // SAFETY: the caller of `read` promised that the callback works as the header says.
        answer("length", unsafe { callback(self.stream.user, &mut length) })?;
        Ok(length)
    }
}

/// Turns what a callback returned into a failure, unless it is 0.
fn answer(callback: &str, code: u32) -> std::io::Result<()> {
    if code == 0 { Ok(()) } else { Err(Failure::other(format!("the stream's {callback} callback failed with {code}"))) }
}

impl fmt::Debug for HostStream {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("HostStream").field("at", &self.at).finish_non_exhaustive()
    }
}

impl Read for HostStream {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        let left = usize::try_from(self.length()?.saturating_sub(self.at)).unwrap_or(usize::MAX);
        let size = bytes.len().min(left);
        if size > 0 {
            let callback = self.stream.read.ok_or(std::io::ErrorKind::Unsupported)?;
            // SAFETY: as for `length`; `bytes` has room for `size`.
            answer("read", unsafe { callback(self.stream.user, self.at, bytes.as_mut_ptr(), size) })?;
            self.at += size as u64;
        }
        Ok(size)
    }
}

impl Write for HostStream {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if !bytes.is_empty() {
            let callback = self.stream.write.ok_or(std::io::ErrorKind::Unsupported)?;
            // SAFETY: as for `length`; `bytes` can be read.
            answer("write", unsafe { callback(self.stream.user, self.at, bytes.as_ptr(), bytes.len()) })?;
            self.at += bytes.len() as u64;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Seek for HostStream {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        let place = match to {
            SeekFrom::Start(place) => Some(place),
            SeekFrom::End(step) => self.length()?.checked_add_signed(step),
            SeekFrom::Current(step) => self.at.checked_add_signed(step),
        };
        self.at = place.ok_or(std::io::ErrorKind::InvalidInput)?;
        Ok(self.at)
    }
}

impl Storage for HostStream {
    fn cut(&mut self, length: u64) -> std::io::Result<()> {
        if length >= self.length()? {
            return Ok(());
        }
        let callback = self.stream.cut.ok_or(std::io::ErrorKind::Unsupported)?;
        // SAFETY: as for `length`.
        answer("cut", unsafe { callback(self.stream.user, length) })
    }

    fn sync(&self) -> std::io::Result<()> {
        // SAFETY: as for `length`.
        self.stream.sync.map_or(Ok(()), |callback| answer("sync", unsafe { callback(self.stream.user) }))
    }
}

impl Drop for HostStream {
    fn drop(&mut self) {
        if let Some(close) = self.stream.close {
            // SAFETY: as for `length`; it is called once, and no other callback follows.
            unsafe { close(self.stream.user) };
        }
    }
}
