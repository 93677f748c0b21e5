//! Journals of edits: what was confirmed is made again, wherever the file was cut.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, Falloff};
use relievo_detail::{
    Action, Curve, SculptMode, Stamp, StampChannel, StampImage, StampSettings, Stroke, StrokePoint, StrokeSettings,
};
use relievo_document::Journal;
use relievo_lod::Progressive;
use relievo_lod::progressive::{
    ActiveMesh, BuildOptions, Cut, Edit, EditJournal, Extents, Extract, Front, Handle, Input, Recovered, Region, View,
};

use crate::shapes::lifted;

fn mesh(height: f32) -> Arc<Progressive> {
    let (points, triangles) = lifted(30, |x, y| height * (6.0 * x).sin() * y);
    let options = BuildOptions { faces: 60, ..BuildOptions::default() };
    Arc::new(Progressive::build(&Context::serial(), &points, &triangles, &options, &mut Silent).unwrap())
}

fn pull(x: f32) -> Edit {
    let region = Region { center: [x, 0.5, 0.0], radius: 0.4, falloff: Falloff::Smooth };
    let handle = Handle { region, translation: [0.0, 0.03, 0.2], axis: [0.0, 0.6, 0.8], angle: 0.3 };
    Edit { handles: vec![handle], anchors: vec![Region { radius: 0.1, ..region }] }
}

fn stamp() -> Stamp {
    let pixels: Vec<f32> = (0..8).flat_map(|at| [0.1 * at as f32, 0.9, 0.3, 0.5 + 0.05 * at as f32]).collect();
    let settings = StampSettings { angle: 0.3, ..StampSettings::default() };
    Stamp::new(StampImage::new(4, 2, 4, &pixels).unwrap(), settings, StampChannel::Green).unwrap()
}

fn stroke(stamp: Option<&Stamp>) -> Stroke {
    let point = |x: f64| StrokePoint { time: Some(0.1 + x), ..StrokePoint::new(DVec3::new(x, 0.4, 0.0), 0.7) };
    let settings = StrokeSettings { radius: 0.2, rate: 3.0, seed: 7, jitter_size: 0.3, ..StrokeSettings::default() };
    let action = Action::Sculpt { mode: SculptMode::Clay, height: 0.07 };
    let mut stroke = Stroke::new([0.3, 0.6].map(point).to_vec(), settings, Falloff::Sphere, action);
    stroke.curves.strength = Curve::new(vec![[0.0, 0.1], [1.0, 0.9]]).unwrap();
    stroke.stamp = stamp.cloned();
    stroke
}

/// Whether two meshes are the same but for last bits, which follow from the levels that a mesh went through.
fn is_near(a: &Extract, b: &Extract) -> bool {
    let mut points = a.points.as_flattened().iter().zip(b.points.as_flattened());
    a.triangles == b.triangles && points.all(|(a, b)| (a - b).abs() < 1e-5)
}

/// A mesh at its finest, as a journal leaves it.
fn taken_up(mesh: &Arc<Progressive>, path: &Path) -> (ActiveMesh, EditJournal, Recovered) {
    let mut active = ActiveMesh::new(mesh);
    active.adapt(&Context::serial(), Cut::FINEST);
    let (journal, found) = EditJournal::open(&Context::serial(), path, &mut active).unwrap();
    assert_eq!(active.cut(), Cut::FINEST);
    (active, journal, found)
}

#[test]
fn edits_that_were_confirmed_are_made_again_wherever_the_file_was_cut() {
    let (context, mesh, folder) = (Context::serial(), mesh(0.1), tempfile::tempdir().unwrap());
    let path = folder.path().join("level.journal");
    let length = || std::fs::metadata(&path).unwrap().len();
    let (mut active, mut journal, found) = taken_up(&mesh, &path);
    assert_eq!(found, Recovered::default());
    // What is seen after each edit, the bytes of the file then, and what the edits are.
    let stamp = stamp();
    let mut seen: Vec<(u64, Extract)> = vec![(length(), active.extract())];
    let mut inputs = Vec::new();
    for number in 0..6 {
        let cut = [Cut::FINEST, Cut::of_faces(&mesh, 400), Cut::of_error(0.004)][number % 3];
        active.adapt(&context, cut);
        if number % 2 == 0 {
            let edit = pull(0.1 * number as f32 + 0.2);
            assert!(journal.edit(&context, &mut active, &edit).unwrap() > 0);
            inputs.push((Front::Cut(cut), Input::Edit(edit)));
        } else {
            // The image is in the journal once.
            let stroke = stroke((number > 1).then_some(&stamp));
            assert!(journal.sculpt(&context, &mut active, &stroke).unwrap().vertices > 0);
            inputs.push((Front::Cut(cut), Input::Stroke(Box::new(stroke))));
        }
        active.adapt(&context, Cut::FINEST);
        seen.push((length(), active.extract()));
    }
    // What fails leaves nothing.
    assert!(journal.edit(&context, &mut active, &Edit { handles: Vec::new(), ..pull(0.0) }).is_err());
    assert_eq!(length(), seen[6].0);
    drop(journal);
    let bytes = std::fs::read(&path).unwrap();
    for cut in (seen[0].0..=seen[6].0).step_by(7).chain(seen.iter().flat_map(|(end, _)| [*end - 1, *end])) {
        if cut < seen[0].0 {
            continue;
        }
        std::fs::write(&path, &bytes[..cut as usize]).unwrap();
        let whole = seen.iter().filter(|(end, _)| *end <= cut).count() - 1;
        let (mut active, mut journal, found) = taken_up(&mesh, &path);
        assert_eq!(found.edits, inputs[..whole], "{cut}");
        assert!(is_near(&active.extract(), &seen[whole].1), "{cut}");
        assert_eq!(found.note.is_some(), cut > seen[whole].0, "{cut}");
        // It goes on from there.
        assert_eq!(journal.undo(&context, &mut active).unwrap(), whole > 0);
        assert!(is_near(&active.extract(), &seen[whole.saturating_sub(1)].1), "{cut}");
    }
}

#[test]
fn what_was_taken_back_can_be_made_again_by_another_program() {
    let (context, mesh, folder) = (Context::serial(), mesh(0.1), tempfile::tempdir().unwrap());
    let path = folder.path().join("level.journal");
    let (mut active, mut journal, _) = taken_up(&mesh, &path);
    let (stamp, mut seen) = (stamp(), vec![active.extract()]);
    for x in [0.3, 0.6] {
        journal.sculpt(&context, &mut active, &stroke(Some(&stamp))).unwrap();
        seen.push(active.extract());
        journal.edit(&context, &mut active, &pull(x)).unwrap();
        seen.push(active.extract());
    }
    // The first stroke, whose image the other one has, is taken back and no longer made; then another edit follows.
    for _ in 0..3 {
        assert!(journal.undo(&context, &mut active).unwrap());
    }
    assert!(journal.redo(&context, &mut active).unwrap());
    drop((active, journal));
    let (mut active, mut journal, found) = taken_up(&mesh, &path);
    assert_eq!((found.edits.len(), found.undone), (2, 2));
    for at in [2, 3, 4] {
        assert!(is_near(&active.extract(), &seen[at]), "{at}");
        assert_eq!(journal.redo(&context, &mut active).unwrap(), at < 4);
    }
    for at in [3, 2, 1, 0] {
        assert!(journal.undo(&context, &mut active).unwrap() && is_near(&active.extract(), &seen[at]), "{at}");
    }
    // The image that a stroke refers to is that of one that is not made any more.
    journal.edit(&context, &mut active, &pull(0.5)).unwrap();
    journal.sculpt(&context, &mut active, &stroke(Some(&stamp))).unwrap();
    let last = active.extract();
    drop((active, journal));
    let (active, _journal, found) = taken_up(&mesh, &path);
    assert!(found.edits.len() == 2 && found.undone == 0 && is_near(&active.extract(), &last));
}

#[test]
fn journals_of_others_and_damaged_ones_are_refused_and_nothing_changes() {
    let (context, folder) = (Context::serial(), tempfile::tempdir().unwrap());
    let (mesh, other) = (mesh(0.1), mesh(0.2));
    let path = folder.path().join("level.journal");
    let (mut active, mut journal, _) = taken_up(&mesh, &path);
    journal.edit(&context, &mut active, &pull(0.3)).unwrap();
    journal.sculpt(&context, &mut active, &stroke(Some(&stamp()))).unwrap();
    let refused = |mesh: &Arc<Progressive>, text: &str| {
        let mut active = ActiveMesh::new(mesh);
        let before = active.extract();
        let error = EditJournal::open(&context, &path, &mut active).unwrap_err().to_string();
        assert!(error.contains(text) && error.contains("level.journal"), "{error}");
        assert!(active.extract() == before && active.edits() == [0, 0]);
    };
    refused(&mesh, "another program");
    let error = EditJournal::open(&context, &folder.path().join("other"), &mut active).unwrap_err();
    assert!(error.to_string().contains("edits already"), "{error}");
    drop((active, journal));
    refused(&other, "no journal of this");
    let bytes = std::fs::read(&path).unwrap();
    for at in (0..bytes.len()).step_by(11) {
        let mut bytes = bytes.clone();
        bytes[at] ^= 4;
        std::fs::write(&path, &bytes).unwrap();
        let mut active = ActiveMesh::new(&mesh);
        let found = EditJournal::open(&context, &path, &mut active);
        // A record at the end that claims more bytes than there are looks like one that was cut.
        assert!(found.is_err() || found.unwrap().1.edits.len() < 2, "{at}");
    }
    // Sound records of what is no edit.
    let head = bytes[..24].to_vec();
    for input in [&b""[..], b"nonsense", &[0; 17], &[1; 40]] {
        let mut journal = Journal::beside(&path, &head).unwrap();
        journal.input_bytes(input).unwrap();
        journal.edit(&7u64.to_le_bytes()).unwrap();
        drop(journal);
        refused(&mesh, "");
    }
}

#[test]
fn edits_of_meshes_for_views_are_made_again() {
    let (context, mesh, folder) = (Context::serial(), mesh(0.1), tempfile::tempdir().unwrap());
    let path = folder.path().join("level.journal");
    let view = View { eye: [0.2, 0.4, 0.5], pixels: 300.0, tolerance: 2.0, outline: 1.0, planes: Vec::new() };
    let (mut active, mut journal, _) = taken_up(&mesh, &path);
    active.adapt_to(&context, &view, &Extents::new(&mesh)).unwrap();
    let front = active.front();
    journal.edit(&context, &mut active, &pull(0.3)).unwrap();
    journal.sculpt(&context, &mut active, &stroke(None)).unwrap();
    assert!(active.front() == front && matches!(front, Front::View(_)));
    active.adapt(&context, Cut::FINEST);
    drop(journal);
    let (again, journal, found) = taken_up(&mesh, &path);
    assert!(is_near(&again.extract(), &active.extract()) && found.note.is_none());
    assert!(found.edits.len() == 2 && found.edits.iter().all(|(at, _)| *at == front));
    drop(journal);
    // Other bits: what stands on splits that are not there is refused, and whatever is taken is a mesh.
    let bytes = std::fs::read(&path).unwrap();
    let (head, record) = bytes.split_at(24);
    let length = u64::from_le_bytes(record[16..24].try_into().unwrap()) as usize;
    let input = &record[28..28 + length];
    let length = u32::from_le_bytes(input[9..13].try_into().unwrap()) as usize;
    let bits = zstd::bulk::decompress(&input[13..13 + length], 1 << 20).unwrap();
    let (base, mut refused) = (ActiveMesh::new(&mesh).extract(), 0);
    for at in 0..bits.len() {
        let mut changed = bits.clone();
        changed[at] ^= 0x24;
        let packed = zstd::bulk::compress(&changed, 1).unwrap();
        let other = [&input[..9], &(packed.len() as u32).to_le_bytes(), &packed, &input[13 + length..]].concat();
        let mut journal = Journal::beside(&path, head).unwrap();
        journal.input_bytes(&other).unwrap();
        journal.edit(&7u64.to_le_bytes()).unwrap();
        drop(journal);
        let mut active = ActiveMesh::new(&mesh);
        let found = EditJournal::open(&context, &path, &mut active);
        if found.is_err() {
            refused += 1;
            assert!(active.extract() == base && active.edits() == [0, 0]);
        } else {
            active.adapt(&context, Cut::FINEST);
            assert_eq!(active.triangle_count(), mesh.triangle_count());
            assert!(active.undo(&context) && active.extract() == at_rest(&mesh));
        }
    }
    assert!(refused > 0);
}

fn at_rest(mesh: &Arc<Progressive>) -> Extract {
    let mut active = ActiveMesh::new(mesh);
    active.adapt(&Context::serial(), Cut::FINEST);
    active.extract()
}
