//! Undo, redo and journals of objects: to the bit, whatever was done, and after whatever end.

use glam::{DAffine3, DVec3, Vec4};
use relievo_core::{Context, Mesh};
use relievo_detail::{
    Action, Brush, Dab, DisplacedObject, Falloff, History, LayeredObject, PaintMode, Recorded, SculptMode, Stroke,
    StrokePoint, StrokeSettings,
};
use relievo_document::{Document, Kind, Settings};
use relievo_surface::{Surface, SurfaceOptions};
use relievo_testing::Random;
use relievo_tiles::{ChannelOptions, Displacement, Paint, Sets, Vector, VectorDisplacement};

const LIMIT: u64 = 1 << 30;

/// A square from 0 to `n` in z = 0, of unit faces, one of them cut into triangles.
fn plane(n: u32) -> Mesh {
    let points = (0..=n).flat_map(|y| (0..=n).map(move |x| [x as f32, y as f32, 0.0])).collect();
    let corner = |x: u32, y: u32| y * (n + 1) + x;
    let mut mesh = Mesh::new(points, Vec::new(), Vec::new());
    for (x, y) in (0..n).flat_map(|y| (0..n).map(move |x| (x, y))) {
        let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
        if (x, y) == (1, 1) {
            mesh.face_sizes.extend([3, 3]);
            mesh.corners.extend([a, b, c, a, c, d]);
        } else {
            mesh.face_sizes.push(4);
            mesh.corners.extend([a, b, c, d]);
        }
    }
    mesh
}

fn object(context: &Context, mesh: &Mesh, size: u32, budget: u64) -> DisplacedObject {
    let surface = Surface::new(context, mesh, &SurfaceOptions::default()).unwrap();
    let options = ChannelOptions { size, budget, ..ChannelOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    let paint = Paint::of_color(surface.topology().clone(), Vec4::new(0.5, 0.25, 0.125, 1.0), &options).unwrap();
    let mut object = DisplacedObject::new(context, surface, &mesh.points, displacement, DAffine3::IDENTITY).unwrap();
    object.set_paint(paint).unwrap();
    object
}

/// All of an object as a document.
fn stored(context: &Context, mesh: &Mesh, object: &DisplacedObject) -> Document {
    let mut document = Document::new(mesh, context.level().name()).unwrap();
    object.displacement().field().store(context, &mut document, "displacement").unwrap();
    object.paint().unwrap().field().store(context, &mut document, "colour").unwrap();
    document
}

fn bytes(context: &Context, mesh: &Mesh, object: &DisplacedObject) -> Vec<u8> {
    stored(context, mesh, object).to_bytes().unwrap()
}

/// The object that a document holds.
fn opened(context: &Context, mesh: &Mesh, document: &Document) -> DisplacedObject {
    let mut object = object(context, mesh, 8, LIMIT);
    let topology = object.surface().topology().clone();
    let displacement = Displacement::stored(context, topology.clone(), document, "displacement", LIMIT);
    *object.displacement_mut() = displacement.unwrap().unwrap();
    object.set_paint(Paint::stored(context, topology, document, "colour", LIMIT).unwrap().unwrap()).unwrap();
    object
}

fn dab(random: &mut Random, n: u32) -> Dab {
    let mut place = || f64::from(random.unit()) * f64::from(n);
    let center = DVec3::new(place(), place(), 0.0);
    let half = DVec3::new(0.25, 0.25, 0.5) * (0.5 + f64::from(random.unit()));
    let brush = Brush::on_surface(center, DVec3::Z, DVec3::X, half, Falloff::Smooth).unwrap();
    let sculpt = |mode, height| Action::Sculpt { mode, height };
    let colour = [random.unit(), random.unit(), random.unit(), 1.0];
    let action = match random.below(6) {
        0 | 1 => Action::Paint { mode: PaintMode::Mix, color: colour },
        2 => Action::Paint { mode: PaintMode::Erase, color: colour },
        3 => sculpt(SculptMode::Draw, 0.1 * random.unit()),
        4 => sculpt(SculptMode::Smooth, 0.0),
        _ => sculpt(SculptMode::Erase, 0.0),
    };
    Dab { brush, action, strength: 1.0 }
}

#[test]
fn ten_thousand_dabs_are_undone_made_again_and_replayed_to_the_bit() {
    const DABS: usize = 10_000;
    let (context, n) = (Context::serial(), 8);
    let mesh = plane(n);
    // Room for fewer tiles than there are, so that some are refused.
    let mut object = object(&context, &mesh, 8, 60 * 200);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("session.relievo");
    let mut random = Random(1);
    let start = bytes(&context, &mesh, &object);
    // Most edits do not stay in memory; the first ones come before there is a document.
    let mut history = History::new(100_000);
    let mut make = |object: &mut DisplacedObject, history: &mut History, count: usize| {
        for index in 0..count {
            history.begin(&context, object, &format!("dab {index}")).unwrap();
            dab(&mut random, n).apply(&context, object).unwrap();
            history.end(&context, object).unwrap();
            assert!(history.bytes() <= 100_000);
        }
    };
    make(&mut object, &mut history, DABS / 4);
    history.save(&path, &stored(&context, &mesh, &object)).unwrap();
    make(&mut object, &mut history, DABS - DABS / 4);
    let end = bytes(&context, &mesh, &object);
    let count = history.undo_count();
    assert!(count > DABS / 2, "{count}");

    while history.undo(&context, &mut object).unwrap().is_some() {}
    assert!(bytes(&context, &mesh, &object) == start && history.redo_count() == count);
    assert_eq!((object.displacement().bytes(), object.paint().unwrap().bytes()), (0, 0));
    while history.redo(&context, &mut object).unwrap().is_some() {}
    assert!(bytes(&context, &mesh, &object) == end);
    drop(history);

    let (document, mut history) = History::open(&path, LIMIT, 100_000).unwrap();
    let mut object = opened(&context, &mesh, &document);
    assert!(bytes(&context, &mesh, &object) == end && history.undo_count() == count);
    for _ in 0..count {
        history.undo(&context, &mut object).unwrap().unwrap();
    }
    assert!(bytes(&context, &mesh, &object) == start);
}

#[test]
fn a_new_edit_drops_what_was_undone_and_nothing_is_an_edit_that_changes_nothing() {
    let (context, mesh) = (Context::serial(), plane(4));
    let mut object = object(&context, &mesh, 16, LIMIT);
    let mut history = History::new(LIMIT);
    let mut random = Random(5);
    let mut states = vec![bytes(&context, &mesh, &object)];
    for number in 0..6 {
        history.begin(&context, &mut object, &format!("edit {number}")).unwrap();
        assert!(history.begin(&context, &mut object, "another").is_err());
        assert!(history.undo_count() == 0 || history.undo(&context, &mut object).is_err());
        dab(&mut random, 4).apply(&context, &mut object).unwrap();
        if history.end(&context, &mut object).unwrap().is_some() {
            states.push(bytes(&context, &mesh, &object));
        }
    }
    let last = states.len() - 1;
    assert_eq!(history.undo_count(), last);
    for at in (1..=3).rev() {
        history.undo(&context, &mut object).unwrap().unwrap();
        assert!(bytes(&context, &mesh, &object) == states[last - 4 + at]);
    }
    history.begin(&context, &mut object, "nothing").unwrap();
    assert_eq!(history.end(&context, &mut object).unwrap(), None);
    assert_eq!(history.redo_count(), 3);
    history.begin(&context, &mut object, "given up").unwrap();
    dab(&mut random, 4).apply(&context, &mut object).unwrap();
    history.abandon(&context, &mut object).unwrap();
    assert!(bytes(&context, &mesh, &object) == states[last - 3] && history.redo_count() == 3);
    assert!(history.end(&context, &mut object).is_err() && history.abandon(&context, &mut object).is_err());
    // Another edit than the ones that were undone.
    history.begin(&context, &mut object, "a bump").unwrap();
    let brush = Brush::on_surface(DVec3::new(3.0, 3.0, 0.0), DVec3::Z, DVec3::X, DVec3::ONE, Falloff::Smooth).unwrap();
    let action = Action::Sculpt { mode: SculptMode::Draw, height: 0.5 };
    let drawn = Dab { brush, action, strength: 1.0 }.apply(&context, &mut object).unwrap();
    let changed = history.end(&context, &mut object).unwrap().unwrap();
    assert_eq!((history.redo_count(), changed.input.as_str(), changed.blocks[0].0), (0, "a bump", 0));
    assert!(drawn.changed.iter().all(|tile| changed.blocks[0].1.contains(tile)));
    // What is done beside the history makes it unfit, and it says so rather than mix states.
    let brush = Brush::on_surface(DVec3::new(3.0, 3.0, 0.5), DVec3::Z, DVec3::X, DVec3::ONE, Falloff::Smooth).unwrap();
    Dab { brush, action, strength: 1.0 }.apply(&context, &mut object).unwrap();
    let before = bytes(&context, &mesh, &object);
    assert!(history.undo(&context, &mut object).unwrap_err().to_string().contains("without its history"));
    assert!(bytes(&context, &mesh, &object) == before);
}

#[test]
fn a_stroke_is_the_same_after_save_kill_and_reopening() {
    let (context, mesh) = (Context::serial(), plane(4));
    let stroke = |from: f64, sculpt: bool| {
        let points = (0..5).map(|i| StrokePoint::new(DVec3::new(0.5 + 0.6 * f64::from(i), from, 0.0), 1.0)).collect();
        let action = if sculpt {
            Action::Sculpt { mode: SculptMode::Draw, height: 0.05 }
        } else {
            Action::Paint { mode: PaintMode::Mix, color: [0.9, 0.1, 0.2, 1.0] }
        };
        let settings = StrokeSettings { radius: 0.4, ..StrokeSettings::default() };
        Stroke::new(points, settings, Falloff::Smooth, action)
    };
    let strokes = [stroke(1.0, true), stroke(1.2, false), stroke(1.5, true), stroke(2.5, false)];
    let mut at_once = object(&context, &mesh, 16, LIMIT);
    for stroke in &strokes {
        stroke.apply(&context, &mut at_once).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    let mut object = object(&context, &mesh, 16, LIMIT);
    let mut history = History::new(LIMIT);
    history.save(&path, &stored(&context, &mesh, &object)).unwrap();
    for (number, stroke) in strokes.iter().enumerate() {
        history.begin(&context, &mut object, &format!("stroke {number}")).unwrap();
        // Its input is written when the program ends, and nothing else.
        let killed = folder.path().join("killed.relievo");
        std::fs::copy(&path, &killed).unwrap();
        stroke.apply(&context, &mut object).unwrap();
        history.end(&context, &mut object).unwrap().unwrap();
        drop(history);
        let (document, reopened) = History::open(&killed, LIMIT, LIMIT).unwrap();
        let note = format!("an edit was under way when the document was left, and is not in it: stroke {number}");
        assert_eq!((document.notes.as_slice(), reopened.undo_count()), (&[note][..], number));
        let (document, reopened) = History::open(&path, LIMIT, LIMIT).unwrap();
        assert!(document.notes.is_empty());
        object = opened(&context, &mesh, &document);
        history = reopened;
    }
    assert!(bytes(&context, &mesh, &object) == bytes(&context, &mesh, &at_once));
    assert_eq!(object.states(&context).unwrap().len(), 2);
}

/// All of an object with its layers as a document.
fn whole(context: &Context, mesh: &Mesh, object: &mut DisplacedObject) -> Document {
    object.states(context).unwrap();
    let mut document = Document::new(mesh, context.level().name()).unwrap();
    object.store(context, &mut document).unwrap();
    document
}

/// What an object is after the edits of a session: sizes that faces were given, blocks, and what is composed of them.
fn state(context: &Context, mesh: &Mesh, object: &mut DisplacedObject) -> (Vec<u8>, Vec<u8>) {
    let whole = whole(context, mesh, object).to_bytes().unwrap();
    (whole, bytes(context, mesh, object))
}

#[test]
fn a_channel_that_an_object_is_given_between_edits_is_in_its_document() {
    let (context, mesh) = (Context::serial(), plane(4));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    let mut made = object(&context, &mesh, 8, LIMIT);
    let mut history = History::new(LIMIT);
    history.save(&path, &whole(&context, &mesh, &mut made)).unwrap();
    let mut random = Random(5);
    let mut paint = |history: &mut History, made: &mut DisplacedObject| {
        history.begin(&context, made, "dab").unwrap();
        dab(&mut random, 4).apply(&context, made).unwrap();
        history.end(&context, made).unwrap();
    };
    paint(&mut history, &mut made);
    made.set_vectors(VectorDisplacement::on(made.surface(), &ChannelOptions::default()).unwrap()).unwrap();
    paint(&mut history, &mut made);
    history.begin(&context, &mut made, "vectors").unwrap();
    let vectors = made.others_mut().1.unwrap();
    vectors.apply(&Sets { allocate: vec![3], ..Sets::default() }).unwrap();
    let changes = vectors.edit(&context, &[3], |_, texels| texels.row_mut(1).fill(Vector([half::f16::ONE; 3])));
    vectors.settle(&context, &changes.unwrap()).unwrap();
    assert!(history.end(&context, &mut made).unwrap().is_some());
    let count = history.undo_count();
    history.undo(&context, &mut made).unwrap().unwrap();
    history.redo(&context, &mut made).unwrap().unwrap();
    paint(&mut history, &mut made);
    drop(history);
    let (document, history) = History::open(&path, LIMIT, LIMIT).unwrap();
    assert!(history.undo_count() >= count);
    let mut reopened = object(&context, &mesh, 8, LIMIT);
    assert!(reopened.take_up(&context, &document, LIMIT).unwrap().is_empty());
    assert!(
        whole(&context, &mesh, &mut reopened).to_bytes().unwrap()
            == whole(&context, &mesh, &mut made).to_bytes().unwrap()
    );
}

#[test]
fn edits_at_all_levels_are_undone_made_again_and_replayed_to_the_bit() {
    for layered in [false, true] {
        let (context, n) = (Context::serial(), 5);
        let mesh = plane(n);
        let mut object = object(&context, &mesh, 32, LIMIT);
        if layered {
            let heights = Settings { opacity: 0.5, ..Settings::of(Kind::Scalar) };
            object.add_layer(&context, Kind::Scalar, "heights", heights, 16).unwrap();
            object.add_layer(&context, Kind::Rgba8, "colours", Settings::of(Kind::Rgba8), 64).unwrap();
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("levels.relievo");
        let mut history = History::new(40_000);
        let mut random = Random(11);
        history.save(&path, &whole(&context, &mesh, &mut object)).unwrap();
        let mut states = vec![state(&context, &mesh, &mut object)];
        let mut sizes = std::collections::BTreeSet::new();
        let mut at = 0;
        for number in 0..240 {
            if number % 9 == 7 {
                for _ in 0..random.below(4).min(at) {
                    history.undo(&context, &mut object).unwrap().unwrap();
                    at -= 1;
                    assert!(state(&context, &mesh, &mut object) == states[at], "undo {number} {layered}");
                }
                while random.below(3) > 0 && history.redo(&context, &mut object).unwrap().is_some() {
                    at += 1;
                    assert!(state(&context, &mesh, &mut object) == states[at], "redo {number} {layered}");
                }
            }
            history.begin(&context, &mut object, &format!("dab {number}")).unwrap();
            let report = dab(&mut random, n).apply_at(&context, &mut object, random.below(3) as u32).unwrap();
            assert!(report.refused.is_empty());
            if history.end(&context, &mut object).unwrap().is_some() {
                at += 1;
                states.truncate(at);
                states.push(state(&context, &mesh, &mut object));
            }
            sizes.extend(object.states(&context).unwrap().iter().flat_map(|layer| layer.blocks.face_sizes()));
        }
        assert!(sizes.len() > 2 && at > 100, "{sizes:?} {at}");
        drop(history);
        // As it is opened again, the edits that it makes next are the same too.
        let (document, mut history) = History::open(&path, LIMIT, LIMIT).unwrap();
        let mut opened = self::object(&context, &mesh, 32, LIMIT);
        assert!(opened.take_up(&context, &document, LIMIT).unwrap().is_empty());
        if layered {
            for name in ["heights", "colours"] {
                opened.set_active_layer(&context, opened.layer(name).unwrap()).unwrap();
            }
        }
        assert!(state(&context, &mesh, &mut opened) == states[at], "{layered}");
        for level in [0, 2, 1] {
            let dab = dab(&mut random, n);
            for object in [&mut object, &mut opened] {
                dab.apply_at(&context, object, level).unwrap();
            }
            assert!(state(&context, &mesh, &mut object) == state(&context, &mesh, &mut opened), "{layered} {level}");
        }
        let mut opened = self::object(&context, &mesh, 32, LIMIT);
        opened.take_up(&context, &document, LIMIT).unwrap();
        while history.undo(&context, &mut opened).unwrap().is_some() {
            at -= 1;
            assert!(state(&context, &mesh, &mut opened) == states[at], "undo to {at} {layered}");
        }
        assert_eq!(at, 0);
        while history.redo(&context, &mut opened).unwrap().is_some() {
            at += 1;
            assert!(state(&context, &mesh, &mut opened) == states[at], "redo to {at} {layered}");
        }
        assert_eq!(at + 1, states.len());
        assert!(opened.displacement().full_bytes() == object_bytes(&opened), "counts follow sizes");
    }
}

/// Bytes of the displacement if all tiles were allocated, by the formula.
fn object_bytes(object: &DisplacedObject) -> u64 {
    let field = object.displacement().field();
    (0..field.tile_count() as u32).map(|tile| field.block_bytes(tile)).sum()
}
