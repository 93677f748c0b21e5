//! Where a MessagePack message ends, found while its bytes arrive, before anything is decoded or allocated.
//!
//! MessagePack-RPC puts messages one after another without their lengths. The scanner walks over the items of a message
//! once, however it is cut into packets, and refuses a message as soon as its head says that it is too long or too deep.

use relievo_core::{Error, Result};

use crate::protocol::MAX_DEPTH;

/// A walk over the message at the beginning of a buffer.
#[derive(Clone, Debug)]
pub struct Scanner {
    limit: usize,
    /// Bytes of whole items so far.
    at: usize,
    /// Items that the open lists and maps still lack, outermost first.
    open: Vec<u64>,
}

/// What an item begins with.
struct Head {
    /// Bytes of the marker and of the length behind it.
    head: usize,
    /// Bytes behind the head.
    body: u64,
    /// Items within, of a list or a map.
    items: Option<u64>,
}

impl Scanner {
    /// Returns a scanner of messages of at most `limit` bytes.
    pub fn new(limit: usize) -> Self {
        Self { limit, at: 0, open: Vec::new() }
    }

    /// Returns the length of the message that `bytes` begins with, or `None` until it is complete. `bytes` are those of
    /// the call before and what has arrived since.
    ///
    /// # Errors
    /// Fails with `Memory` if the message is longer than the limit, and with `Invalid` if it is deeper than
    /// [`MAX_DEPTH`] or is not MessagePack; nothing can be read from the connection after that.
    pub fn scan(&mut self, bytes: &[u8]) -> Result<Option<usize>> {
        loop {
            let Some(Head { head, body, items }) = head(&bytes[self.at..])? else { return Ok(None) };
            let end = (self.at as u64).saturating_add(head as u64).saturating_add(body);
            // An item has one byte at least.
            if end.saturating_add(items.unwrap_or(0)) > self.limit as u64 {
                return Err(Error::memory(format!("a message is longer than {} bytes", self.limit))
                    .advise("send large data in several messages"));
            }
            if end > bytes.len() as u64 {
                return Ok(None);
            }
            self.at = end as usize;
            match items {
                Some(items) if items > 0 => {
                    if self.open.len() == MAX_DEPTH {
                        return Err(Error::invalid(format!("a message is deeper than {MAX_DEPTH} lists and maps")));
                    }
                    self.open.push(items);
                    continue;
                }
                _ => {}
            }
            while let Some(left) = self.open.last_mut() {
                *left -= 1;
                if *left > 0 {
                    break;
                }
                self.open.pop();
            }
            if self.open.is_empty() {
                return Ok(Some(std::mem::take(&mut self.at)));
            }
        }
    }
}

/// Reads the head of an item; `None` if it is not there yet.
fn head(bytes: &[u8]) -> Result<Option<Head>> {
    let Some(&marker) = bytes.first() else { return Ok(None) };
    let length = |size: usize| -> Option<u64> {
        let bytes = bytes.get(1..1 + size)?;
        Some(bytes.iter().fold(0, |value, byte| value << 8 | u64::from(*byte)))
    };
    let plain = |body: u64| Some(Head { head: 1, body, items: None });
    let sized =
        |size: usize, more: u64| length(size).map(|body| Head { head: 1 + size, body: body + more, items: None });
    let list =
        |size: usize, each: u64| length(size).map(|items| Head { head: 1 + size, body: 0, items: Some(each * items) });
    Ok(match marker {
        0x00..=0x7f | 0xe0..=0xff | 0xc0 | 0xc2 | 0xc3 => plain(0),
        0x80..=0x8f => Some(Head { head: 1, body: 0, items: Some(2 * u64::from(marker & 0xf)) }),
        0x90..=0x9f => Some(Head { head: 1, body: 0, items: Some(u64::from(marker & 0xf)) }),
        0xa0..=0xbf => plain(u64::from(marker & 0x1f)),
        0xc4 | 0xd9 => sized(1, 0),
        0xc5 | 0xda => sized(2, 0),
        0xc6 | 0xdb => sized(4, 0),
        0xc7 => sized(1, 1),
        0xc8 => sized(2, 1),
        0xc9 => sized(4, 1),
        0xca | 0xce | 0xd2 => plain(4),
        0xcb | 0xcf | 0xd3 => plain(8),
        0xcc | 0xd0 => plain(1),
        0xcd | 0xd1 => plain(2),
        // An extension has a byte for its type.
        0xd4..=0xd8 => plain(1 + (1 << (marker - 0xd4))),
        0xdc => list(2, 1),
        0xdd => list(4, 1),
        0xde => list(2, 2),
        0xdf => list(4, 2),
        0xc1 => return Err(Error::invalid("the byte c1 begins no MessagePack item").advise("speak MessagePack-RPC")),
    })
}
