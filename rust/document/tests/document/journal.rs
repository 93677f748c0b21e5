//! Journals: edits go on after the base of a document and come back; after a cut at any byte the confirmed ones are
//! there, after a flipped bit what can be kept is kept.

use std::path::{Path, PathBuf};

use relievo_core::{Context, ErrorKind};
use relievo_document::format::VERSION;
use relievo_document::{Document, Journal, compact, examine, repair};

use crate::model::{Model, SIZE, head, mesh};

const LIMIT: u64 = 64 << 20;
/// A journal of `count` steps in `folder`: its path, what its document is after every record, the bytes of the file
/// then, and what was being done.
struct Session {
    path: PathBuf,
    states: Vec<(u64, Document)>,
}

fn session(folder: &Path, count: u32) -> Session {
    let path = folder.join("a.relievo");
    let mut model = Model::new();
    let mut journal = Journal::create(&path, &model.document()).unwrap();
    let mut states = vec![(journal.bytes(), model.document())];
    let (mut done, mut undone): (Vec<(u64, Model)>, Vec<(u64, Model)>) = Default::default();
    for number in 0..count {
        let before = model.clone();
        if number % 6 == 4 && !done.is_empty() {
            let (sequence, was) = done.pop().unwrap();
            journal.undo(sequence).unwrap();
            undone.push((sequence, std::mem::replace(&mut model, was)));
        } else if number % 6 == 5 && !undone.is_empty() && number % 4 == 1 {
            let (sequence, again) = undone.pop().unwrap();
            journal.redo(sequence).unwrap();
            done.push((sequence, before));
            model = again;
        } else {
            journal.input(&format!("edit {number}")).unwrap();
            states.push((journal.bytes(), model.document()));
            model = before.changed(number);
            let (_, sequence) = journal.edit(&before.edit(&model)).unwrap();
            done.push((sequence, before));
            undone.clear();
        }
        states.push((journal.bytes(), model.document()));
    }
    Session { path, states }
}

fn same(a: &Document, b: &Document) -> bool {
    a.to_bytes().unwrap() == b.to_bytes().unwrap()
}

#[test]
fn edits_come_back_and_go_on_where_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let Session { path, states } = session(folder.path(), 40);
    let (document, log, mut journal) = Journal::open(&path, LIMIT).unwrap();
    assert!(same(&document, &states.last().unwrap().1) && document.notes.is_empty());
    assert!(log.done.len() > 10 && log.under_way.is_none() && log.torn == 0);
    for entry in &log.done {
        assert!(journal.read_input(entry.input.unwrap()).unwrap().starts_with("edit "));
    }
    // Nobody else may append meanwhile.
    assert_eq!(Journal::open(&path, LIMIT).unwrap_err().kind, ErrorKind::Busy);
    assert_eq!(compact(&path, LIMIT, 0).unwrap_err().kind, ErrorKind::Busy);
    journal.undo(log.done.last().unwrap().sequence).unwrap();
    drop(journal);
    let (_, again, _) = Journal::open(&path, LIMIT).unwrap();
    assert_eq!(again.done, log.done[..log.done.len() - 1]);
    assert_eq!(again.undone.last(), log.done.last());
}

#[test]
fn after_a_kill_at_any_byte_no_confirmed_edit_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let Session { path, states } = session(folder.path(), 30);
    let whole = std::fs::read(&path).unwrap();
    let base = states[0].0;
    let cut = folder.path().join("cut.relievo");
    let mut under_way = 0;
    for length in base..=whole.len() as u64 {
        let expected = &states.iter().rev().find(|(end, _)| *end <= length).unwrap();
        let document = Document::parse(&whole[..length as usize], LIMIT).unwrap();
        assert!(same(&document, &expected.1), "{length}");
        under_way += usize::from(document.notes.iter().any(|note| note.contains("not in it: edit ")));
        // Whatever was cut off, the next edit follows what was whole.
        if length % 41 == 0 {
            std::fs::write(&cut, &whole[..length as usize]).unwrap();
            let (_, log, mut journal) = Journal::open(&cut, LIMIT).unwrap();
            let (now, next) = (Model::new(), Model::new());
            journal.edit(&now.edit(&next)).unwrap();
            drop(journal);
            let (after, count) = Journal::open(&cut, LIMIT).map(|(after, log, _)| (after, log.done.len())).unwrap();
            assert!(same(&after, &expected.1) && after.notes.is_empty() && count == log.done.len() + 1, "{length}");
        }
    }
    assert!(under_way > 100);
}

#[test]
fn a_flipped_bit_is_damage_and_what_can_be_kept_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let Session { path, states } = session(folder.path(), 30);
    let whole = std::fs::read(&path).unwrap();
    let context = Context::serial();
    let bad = folder.path().join("bad.relievo");
    let last = &states.last().unwrap().1;
    for at in (states[0].0 as usize..whole.len()).step_by(29) {
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << (at % 8);
        std::fs::write(&bad, &bytes).unwrap();
        let (_, damage) = examine(&context, &bad).unwrap();
        assert!(!damage.is_empty(), "{at}");
        assert!(Document::open(&bad, LIMIT).is_err(), "{at}");
        let repaired = repair(&context, &bad).unwrap();
        assert_eq!(repaired.damage, damage);
        assert_eq!(std::fs::read(repaired.kept.unwrap()).unwrap(), bytes);
        let kept = Document::open(&bad, LIMIT).unwrap();
        // A block is as it should be, or reported, or its edit is reported as a whole.
        let told: String = damage.iter().map(|damage| format!("{damage}\n")).collect();
        for layer in kept.layers() {
            let Some(right) = last.layer(layer.name()) else {
                assert!(told.contains("journal: record"));
                continue;
            };
            let differs = layer.blocks() != right.blocks();
            assert!(!differs || told.contains("are lost there") || told.contains("journal: record"), "{at}: {told}");
        }
    }
    // Damage of one edit leaves the blocks that it did not touch.
    let mut bytes = whole.clone();
    let at = states[2].0 as usize - 6;
    bytes[at] ^= 1;
    std::fs::write(&bad, &bytes).unwrap();
    let (document, damage) = examine(&context, &bad).unwrap();
    assert!(damage[0].to_string().contains("journal: record 1"), "{}", damage[0]);
    assert!(damage[0].what.contains("an edit: edit 0"), "{}", damage[0]);
    assert!(document.layers()[0].blocks().iter().any(|block| last.layers()[0].blocks().contains(block)));
}

#[test]
fn compacting_keeps_what_is_seen_and_drops_the_history() {
    let folder = tempfile::tempdir().unwrap();
    let Session { path, states } = session(folder.path(), 40);
    let before = std::fs::metadata(&path).unwrap().len();
    let done = compact(&path, LIMIT, 0).unwrap();
    assert!(done.edits > 10 && done.bytes[0] == before && done.bytes[1] < before && done.note.is_none());
    let (document, log, _) = Journal::open(&path, LIMIT).unwrap();
    assert!(same(&document, &states.last().unwrap().1) && log.done.is_empty());
    assert_eq!(std::fs::read(&path).unwrap(), states.last().unwrap().1.to_bytes().unwrap());
    // Or keeps some of it.
    let kept = tempfile::tempdir().unwrap();
    let Session { path: other, states } = session(kept.path(), 40);
    let (_, whole, _) = Journal::open(&other, LIMIT).unwrap();
    let some = compact(&other, LIMIT, 3).unwrap();
    assert_eq!((some.edits, some.undone), (whole.done.len() - 3, 0));
    let (document, log, mut journal) = Journal::open(&other, LIMIT).unwrap();
    assert!(same(&document, &states.last().unwrap().1) && log.done.len() == 3);
    assert_eq!(log.undone.len(), whole.undone.len());
    journal.undo(log.done[2].sequence).unwrap();
    drop(journal);
    let undone = Document::open(&other, LIMIT).unwrap();
    assert!(states.iter().any(|(_, state)| same(&undone, state)) && !same(&undone, &document));
    // What was under way is cut off by a repair, which finds nothing damaged.
    let (_, _, mut journal) = Journal::open(&path, LIMIT).unwrap();
    journal.input("the next stroke").unwrap();
    drop(journal);
    let repaired = repair(&Context::serial(), &path).unwrap();
    assert!(repaired.damage.is_empty() && repaired.kept.is_none());
    assert!(repaired.note.unwrap().ends_with("not in it: the next stroke"));
    assert_eq!(std::fs::metadata(&path).unwrap().len(), done.bytes[1]);
}

#[test]
fn the_journal_of_every_earlier_release_opens() {
    let golden = |version: u32| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden");
        folder.join(format!("document-{version}.relievo"))
    };
    let folder = tempfile::tempdir().unwrap();
    let Session { path: new, states } = session(folder.path(), 16);
    // How it was made; a release that changes the format adds a file and keeps this one.
    if std::env::var_os("RELIEVO_WRITE_GOLDEN").is_some() {
        std::fs::copy(&new, golden(VERSION)).unwrap();
    }
    let expected = &states.last().unwrap().1;
    for version in 2..=VERSION {
        let found = Document::open(&golden(version), LIMIT).unwrap();
        assert_eq!((found.version, found.points()), (version, &mesh().points[..]));
        assert_eq!(found.layers().len(), expected.layers().len());
        assert_eq!(found.recipes(), if version < 5 { &[] } else { expected.recipes() });
        for (found, layer) in found.layers().iter().zip(expected.layers()) {
            assert_eq!((found.head(), found.blocks().len()), (layer.head(), layer.blocks().len()));
            for at in 0..layer.blocks().len() {
                let topology = expected.topology();
                assert_eq!(found.unpack(topology, at).unwrap(), layer.unpack(topology, at).unwrap());
            }
        }
    }
    // Old documents become new ones when they are worked on, and keep their history.
    for version in 1..VERSION {
        let copy = folder.path().join("old.relievo");
        std::fs::copy(golden(version), &copy).unwrap();
        let (before, log, mut journal) = Journal::open(&copy, LIMIT).unwrap();
        assert_eq!(before.version, VERSION);
        match log.done.last() {
            Some(last) => {
                assert!(journal.read_input(last.input.unwrap()).unwrap().starts_with("edit "));
                journal.undo(last.sequence).unwrap();
                journal.redo(last.sequence).unwrap();
            }
            None => assert_eq!(version, 1),
        }
        journal.input("nothing yet").unwrap();
        drop(journal);
        let after = Document::open(&copy, LIMIT).unwrap();
        assert!(same(&before, &after) && after.points().is_empty() == (version == 1) && after.notes.len() == 1);
    }
}

#[test]
fn layers_that_no_edit_made_stay_when_edits_are_undone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    let before = Model::new();
    let mut journal = Journal::create(&path, &before.document()).unwrap();
    // An edit of layers, then layers of what the document is opened on, then an edit of one of those.
    let mut edited = before.clone();
    edited.heads.push(head(6, "added"));
    let (_, first) = journal.edit(&before.edit(&edited)).unwrap();
    let mut opened = edited.clone();
    opened.heads.push(head(9, "of the object"));
    journal.layers(&edited.edit(&opened)).unwrap();
    let mut last = opened.clone();
    last.blocks.insert((9, 3), vec![7; SIZE]);
    let (_, second) = journal.edit(&opened.edit(&last)).unwrap();
    assert!(same(&Document::open(&path, LIMIT).unwrap(), &last.document()));
    journal.undo(second).unwrap();
    assert!(same(&Document::open(&path, LIMIT).unwrap(), &opened.document()));
    journal.undo(first).unwrap();
    let mut expected = before.clone();
    expected.heads.push(head(9, "of the object"));
    assert!(same(&Document::open(&path, LIMIT).unwrap(), &expected.document()));
}
