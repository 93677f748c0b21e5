//! Documents in memory and in storage that fails: the same as in files.

use std::io::{Cursor, Error, Read, Result, Seek, SeekFrom, Write};

use relievo_core::ErrorKind;
use relievo_document::{Document, Journal, Storage};

use crate::model::Model;

const LIMIT: u64 = 64 << 20;

/// Writes `count` edits of a model into `journal`.
fn edited(journal: &mut Journal, count: u32) -> Document {
    let mut model = Model::new();
    for number in 0..count {
        let after = model.clone().changed(number);
        journal.input(&format!("edit {number}")).unwrap();
        journal.edit(&model.edit(&after)).unwrap();
        model = after;
    }
    model.document()
}

#[test]
fn a_document_in_memory_has_the_bytes_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    let mut filed = Journal::create(&path, &Model::new().document()).unwrap();
    let mut held = Journal::create_in(Box::new(Cursor::new(Vec::new())), &Model::new().document()).unwrap();
    edited(&mut filed, 12);
    let last = edited(&mut held, 12);
    let bytes = held.into_bytes().unwrap();
    assert!(bytes == std::fs::read(&path).unwrap());

    let (document, log, mut again) = Journal::open_in(Box::new(Cursor::new(bytes.clone())), LIMIT).unwrap();
    assert_eq!(document.to_bytes().unwrap(), last.to_bytes().unwrap());
    assert_eq!(log.done.len(), 12);
    assert_eq!(again.read_input(log.done[3].input.unwrap()).unwrap(), "edit 3");
    again.undo(log.done[11].sequence).unwrap();
    let bytes = again.into_bytes().unwrap();
    assert_eq!(Journal::open_in(Box::new(Cursor::new(bytes)), LIMIT).unwrap().1.undone.len(), 1);
}

#[test]
fn bytes_of_a_cut_document_open_without_the_edit_that_was_under_way() {
    let mut held = Journal::create_in(Box::new(Cursor::new(Vec::new())), &Model::new().document()).unwrap();
    edited(&mut held, 2);
    let whole = held.into_bytes().unwrap();
    let cut = whole[..whole.len() - 3].to_vec();
    let (document, log, mut again) = Journal::open_in(Box::new(Cursor::new(cut)), LIMIT).unwrap();
    assert_eq!(log.done.len(), 1);
    assert!(!document.notes.is_empty());
    // What was cut off is gone, so that the next edit follows the last whole one.
    let model = Model::new().changed(0);
    again.edit(&model.edit(&model.clone().changed(1))).unwrap();
    let bytes = again.into_bytes().unwrap();
    assert_eq!(Journal::open_in(Box::new(Cursor::new(bytes)), LIMIT).unwrap().1.done.len(), 2);
}

#[test]
fn documents_of_earlier_versions_are_written_anew_in_memory() {
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/document-1.relievo");
    let old = std::fs::read(golden).unwrap();
    let (document, _, journal) = Journal::open_in(Box::new(Cursor::new(old.clone())), LIMIT).unwrap();
    let renewed = journal.into_bytes().unwrap();
    assert_ne!(renewed, old);
    let again = Document::parse(&renewed, LIMIT).unwrap();
    assert_eq!((again.layers(), again.topology()), (document.layers(), document.topology()));
}

/// Memory that fails at the write after `left` ones.
#[derive(Debug)]
struct Failing(Cursor<Vec<u8>>, usize);

impl Read for Failing {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize> {
        self.0.read(bytes)
    }
}

impl Write for Failing {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.1 = self.1.checked_sub(1).ok_or_else(|| Error::other("the host has no room"))?;
        // Half of it is there when it fails next.
        self.0.write(&bytes[..bytes.len().div_ceil(2)])
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

impl Seek for Failing {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        self.0.seek(to)
    }
}

impl Storage for Failing {
    fn cut(&mut self, length: u64) -> Result<()> {
        self.0.cut(length)
    }

    fn sync(&self) -> Result<()> {
        Ok(())
    }
}

#[test]
fn a_write_that_fails_halfway_leaves_the_edits_before_it() {
    let base = Model::new().document().to_bytes().unwrap();
    let storage = Failing(Cursor::new(base), 8);
    let (_, _, mut journal) = Journal::open_in(Box::new(storage), LIMIT).unwrap();
    let model = Model::new();
    let payload = model.edit(&model.clone().changed(0));
    let failure = (0..20).find_map(|_| journal.edit(&payload).err()).expect("no write failed");
    assert_eq!(failure.kind, ErrorKind::Io);
    assert!(failure.to_string().contains("no room"), "{failure}");
    let bytes = journal.into_bytes().unwrap();
    let (document, log, _) = Journal::open_in(Box::new(Cursor::new(bytes)), LIMIT).unwrap();
    assert!(document.notes.is_empty() && log.torn == 0);

    let refused = Journal::create_in(Box::new(Failing(Cursor::new(Vec::new()), 1)), &model.document());
    assert_eq!(refused.unwrap_err().kind, ErrorKind::Io);
}
