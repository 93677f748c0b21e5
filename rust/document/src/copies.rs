//! Second copies of the header and the index of a document.
//!
//! All blocks are found through the header and the index, so damage to these would cost everything. Since version 4 both
//! follow the blocks once more: the index, then the header. A header that is damaged is found by its copy, which a
//! search of the file recognises by its checksum and by its distance from the start of the file.

use std::io::{Read, Seek, SeekFrom};

use relievo_core::Result;

use crate::format::{HEADER, Header, MAGIC};
use crate::record::failed;

/// Bytes that are searched at a time.
const WINDOW: usize = 1 << 16;

/// Searches `source` for the copy of a header that is damaged. Returns its bytes and what they say.
pub(crate) fn find_header(source: &mut (impl Read + Seek)) -> Result<Option<(Vec<u8>, Header)>> {
    let mut start = 0;
    loop {
        let mut window = Vec::new();
        source.seek(SeekFrom::Start(start)).map_err(failed)?;
        source.take((WINDOW + HEADER) as u64).read_to_end(&mut window).map_err(failed)?;
        for at in 0..window.len().saturating_sub(HEADER - 1).min(WINDOW) {
            let bytes = &window[at..at + HEADER];
            if bytes.starts_with(&MAGIC)
                && let Ok(header) = Header::parse(bytes)
                && header.copy_at() == Some(start + at as u64)
            {
                return Ok(Some((bytes.to_vec(), header)));
            }
        }
        if window.len() < WINDOW + HEADER {
            return Ok(None);
        }
        start += WINDOW as u64;
    }
}
