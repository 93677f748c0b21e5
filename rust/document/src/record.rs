//! The records of a journal: what follows the base of a document, one after the other, only ever appended to.
//!
//! A record, little-endian: `RLVR`, kind (u32), sequence number (u64, counted from 0), bytes of the payload (u64),
//! CRC-32 of the 24 bytes before; the payload; its CRC-32. A record that a killed process was writing is a prefix of
//! one at the end of the file, or ends in the zeros that file systems leave there after a power failure: a torn tail,
//! and not damage. Whatever else is wrong is damage, and reading goes on at the next head whose checksum is right.

use std::io::{Read, Seek, SeekFrom};

use relievo_core::{Error, ErrorKind, Result};

use crate::code::Encoder;

const MAGIC: [u8; 4] = *b"RLVR";
/// Bytes in front of the payload.
pub(crate) const HEAD: usize = 28;
/// Bytes after the payload.
pub(crate) const TAIL: usize = 4;
/// Bytes that are read at a time where the next head is searched for.
const WINDOW: usize = 1 << 16;

/// What a record says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordKind {
    /// What an edit is going to be: a text. Written before the edit is made.
    Input,
    /// What an edit changed, see [`Edit`](crate::Edit). With it the edit is confirmed.
    Edit,
    /// The edit with the sequence number in the payload was undone.
    Undo,
    /// It was made again.
    Redo,
    /// What an edit changed that the base has already: it can be undone.
    Past,
    /// What an edit changed that was undone before the base was written: it can be made again.
    Future,
    /// The layers of what the document was opened on, which no edit made: an [`Edit`](crate::Edit) that cannot be
    /// undone.
    Layers,
}

impl RecordKind {
    const ALL: [RecordKind; 7] = [
        RecordKind::Input,
        RecordKind::Edit,
        RecordKind::Undo,
        RecordKind::Redo,
        RecordKind::Past,
        RecordKind::Future,
        RecordKind::Layers,
    ];

    fn number(self) -> u32 {
        self as u32 + 1
    }
}

/// Where the payload of a record is in its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Location {
    /// Bytes from the start of the file.
    pub offset: u64,
    /// Bytes of the payload.
    pub length: u64,
    /// Its CRC-32.
    pub crc: u32,
}

/// The bytes of a record.
pub(crate) fn frame(kind: RecordKind, sequence: u64, payload: &[u8]) -> (Vec<u8>, u32) {
    let mut out = Encoder(Vec::with_capacity(HEAD + payload.len() + TAIL));
    out.0.extend_from_slice(&MAGIC);
    out.u32(kind.number());
    out.u64(sequence);
    out.u64(payload.len() as u64);
    out.u32(crc32fast::hash(&out.0));
    out.0.extend_from_slice(payload);
    let crc = crc32fast::hash(payload);
    out.u32(crc);
    (out.0, crc)
}

/// A head whose checksum is right.
#[derive(Clone, Copy, Debug)]
struct Head {
    kind: u32,
    sequence: u64,
    length: u64,
}

impl Head {
    fn parse(bytes: &[u8]) -> Option<Self> {
        let (body, crc) = bytes.get(..HEAD)?.split_at(HEAD - 4);
        let number = |at: usize| Some(u64::from_le_bytes(body.get(at..at + 8)?.try_into().ok()?));
        let sound = body.starts_with(&MAGIC) && crc32fast::hash(body).to_le_bytes() == crc;
        sound.then_some(())?;
        Some(Self { kind: (number(0)? >> 32) as u32, sequence: number(8)?, length: number(16)? })
    }
}

/// What a reader of records meets.
#[derive(Debug)]
pub(crate) enum Item {
    /// A sound record.
    Record { kind: RecordKind, sequence: u64, location: Location, payload: Vec<u8> },
    /// The end, in the middle of a record that was being written.
    Torn { bytes: u64 },
    /// Something else; `next` is the sequence number that would have been its own.
    Damaged { offset: u64, what: &'static str, next: u64 },
}

/// Reads the records of `source` from byte `at` on.
#[derive(Debug)]
pub(crate) struct Reader<R> {
    source: R,
    at: u64,
    end: u64,
    next: u64,
    /// Bytes that a payload may have.
    limit: u64,
}

impl<R: Read + Seek> Reader<R> {
    pub fn new(mut source: R, at: u64, limit: u64) -> Result<Self> {
        let end = source.seek(SeekFrom::End(0)).map_err(failed)?;
        Ok(Self { source, at, end: end.max(at), next: 0, limit })
    }

    /// Where the next record begins.
    pub fn position(&self) -> u64 {
        self.at
    }

    /// The sequence number that is expected next.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// Reads the payload at `location`, whose record was met before.
    pub fn payload(&mut self, location: Location) -> Result<Vec<u8>> {
        read_payload(&mut self.source, location)
    }

    fn bytes(&mut self, at: u64, count: usize) -> Result<Vec<u8>> {
        let mut bytes = vec![0; count];
        self.source.seek(SeekFrom::Start(at)).and_then(|_| self.source.read_exact(&mut bytes)).map_err(failed)?;
        Ok(bytes)
    }

    /// Whether there is nothing but zeros from `at` on.
    fn is_zero(&mut self, mut at: u64) -> Result<bool> {
        while at < self.end {
            let count = (self.end - at).min(WINDOW as u64);
            if self.bytes(at, count as usize)?.iter().any(|byte| *byte != 0) {
                return Ok(false);
            }
            at += count;
        }
        Ok(true)
    }

    /// The next record; `None` at the end. After damage it goes on at the next sound head.
    pub fn read(&mut self) -> Result<Option<Item>> {
        let (at, left) = (self.at, self.end - self.at);
        if left == 0 {
            return Ok(None);
        }
        let torn = |this: &mut Self| {
            this.at = this.end;
            Ok(Some(Item::Torn { bytes: left }))
        };
        let whole = (HEAD + TAIL) as u64;
        let bytes = self.bytes(at, left.min(HEAD as u64) as usize)?;
        let Some(head) = Head::parse(&bytes) else {
            // The beginning of a head, and perhaps zeros; of a whole one at least the last byte was not written.
            let written = bytes.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
            let begun = bytes.starts_with(&MAGIC) || MAGIC.starts_with(&bytes[..written]);
            if begun && (left < HEAD as u64 || self.is_zero(at + HEAD as u64 - 1)?) {
                return torn(self);
            }
            let next = self.next;
            self.resume(at + 1)?;
            return Ok(Some(Item::Damaged { offset: at, what: "the checksum of the record's head is wrong", next }));
        };
        if head.length > left.saturating_sub(whole) {
            return torn(self);
        }
        if head.length > self.limit {
            return Err(Error::memory(format!("a record of {} bytes exceeds the memory limit", head.length))
                .advise("raise the memory limit"));
        }
        let body = self.bytes(at + HEAD as u64, head.length as usize + TAIL)?;
        let (payload, crc) = body.split_at(head.length as usize);
        let location = Location { offset: at + HEAD as u64, length: head.length, crc: crc32fast::hash(payload) };
        let end = at + whole + head.length;
        if location.crc.to_le_bytes() != *crc {
            if self.is_zero(end - 1)? {
                return torn(self);
            }
            self.at = end;
            self.next = head.sequence.saturating_add(1);
            let what = "the checksum of the record is wrong";
            return Ok(Some(Item::Damaged { offset: at, what, next: head.sequence }));
        }
        if head.sequence != self.next {
            // Records before it are missing; it is met again as the one that is expected.
            let next = std::mem::replace(&mut self.next, head.sequence);
            return Ok(Some(Item::Damaged { offset: at, what: "records before it are missing", next }));
        }
        self.at = end;
        self.next = head.sequence.saturating_add(1);
        let Some(kind) = RecordKind::ALL.into_iter().find(|kind| kind.number() == head.kind) else {
            return Ok(Some(Item::Damaged {
                offset: at,
                what: "the record is of an unknown kind",
                next: head.sequence,
            }));
        };
        let mut payload = body;
        payload.truncate(head.length as usize);
        Ok(Some(Item::Record { kind, sequence: head.sequence, location, payload }))
    }

    /// Goes to the first sound head from `at` on, or to the end.
    fn resume(&mut self, mut at: u64) -> Result<()> {
        while at + HEAD as u64 <= self.end {
            let count = (self.end - at).min(WINDOW as u64) as usize;
            let bytes = self.bytes(at, count)?;
            let found = (0..=count - HEAD).find_map(|from| Some((from, Head::parse(&bytes[from..])?)));
            if let Some((from, head)) = found {
                (self.at, self.next) = (at + from as u64, head.sequence);
                return Ok(());
            }
            at += (count - HEAD + 1) as u64;
        }
        self.at = self.end;
        Ok(())
    }
}

/// Reads a payload from a file.
pub(crate) fn read_payload(source: &mut (impl Read + Seek), location: Location) -> Result<Vec<u8>> {
    let end = source.seek(SeekFrom::End(0)).map_err(failed)?;
    let fits = location.offset.checked_add(location.length).is_some_and(|after| after <= end);
    if !fits {
        return Err(changed());
    }
    let length = usize::try_from(location.length).map_err(|_| changed())?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length).map_err(|_| Error::memory("the system has no memory for a record"))?;
    bytes.resize(length, 0);
    source.seek(SeekFrom::Start(location.offset)).and_then(|_| source.read_exact(&mut bytes)).map_err(failed)?;
    if crc32fast::hash(&bytes) == location.crc { Ok(bytes) } else { Err(changed()) }
}

/// An error of the operating system. Records are read within the length that the file had, so it was cut meanwhile where
/// it ends too early.
pub(crate) fn failed(error: std::io::Error) -> Error {
    match error.kind() {
        std::io::ErrorKind::UnexpectedEof => changed(),
        _ => Error::new(ErrorKind::Io, error.to_string()),
    }
}

fn changed() -> Error {
    Error::invalid("the journal was changed by another program").advise("open the document again")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn three() -> (Vec<u8>, Vec<usize>) {
        let (mut bytes, mut ends) = (Vec::new(), vec![0]);
        for (sequence, kind) in [RecordKind::Input, RecordKind::Edit, RecordKind::Undo].into_iter().enumerate() {
            bytes.extend(frame(kind, sequence as u64, &vec![7 + sequence as u8; 20 * sequence + 3]).0);
            ends.push(bytes.len());
        }
        (bytes, ends)
    }

    fn read(bytes: &[u8]) -> Vec<Item> {
        let mut reader = Reader::new(Cursor::new(bytes), 0, 1 << 20).unwrap();
        std::iter::from_fn(|| reader.read().unwrap()).collect()
    }

    fn records(items: &[Item]) -> Vec<u64> {
        let sequence = |item: &Item| if let Item::Record { sequence, .. } = item { Some(*sequence) } else { None };
        items.iter().filter_map(sequence).collect()
    }

    #[test]
    fn a_cut_anywhere_is_a_torn_tail_and_keeps_what_is_whole() {
        let (bytes, ends) = three();
        for cut in 0..=bytes.len() {
            let items = read(&bytes[..cut]);
            let whole = ends.iter().filter(|end| **end <= cut).count() - 1;
            assert_eq!(records(&items), (0..whole as u64).collect::<Vec<_>>(), "{cut}");
            let torn = matches!(items.last(), Some(Item::Torn { .. }));
            assert_eq!((torn, items.len()), (!ends.contains(&cut), whole + usize::from(torn)), "{cut}");
            // As file systems leave it after a power failure.
            let mut zeros = bytes[..cut].to_vec();
            zeros.resize(cut + 100, 0);
            let items = read(&zeros);
            assert!(matches!(items.last(), Some(Item::Torn { .. })), "{cut}: {items:?}");
            assert_eq!((records(&items).len(), items.len()), (whole, whole + 1), "{cut}");
        }
    }

    #[test]
    fn a_flipped_bit_is_damage_and_costs_one_record() {
        let (bytes, ends) = three();
        for at in 0..bytes.len() {
            for bit in 0..8 {
                let mut bytes = bytes.clone();
                bytes[at] ^= 1 << bit;
                let items = read(&bytes);
                let hit = ends.iter().filter(|end| **end <= at).count() as u64 - 1;
                let rest: Vec<u64> = (0..3).filter(|sequence| *sequence != hit).collect();
                assert_eq!(records(&items), rest, "{at} {bit}: {items:?}");
                assert!(items.iter().any(|item| matches!(item, Item::Damaged { .. })), "{at} {bit}");
            }
        }
    }
}
