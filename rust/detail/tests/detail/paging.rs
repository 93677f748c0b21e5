//! Objects that page, held against objects that need not: strokes, layers, undo, journals, documents.

use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec4};
use relievo_core::{Context, Mesh};
use relievo_detail::{
    Action, Brush, Dab, DisplacedObject, Falloff, History, LayeredObject, PaintMode, Recorded, SculptMode, Stroke,
    StrokePoint, StrokeSettings,
};
use relievo_document::{Document, Kind, PageFile, Settings};
use relievo_surface::{Surface, SurfaceOptions};
use relievo_testing::{Random, grid};
use relievo_tiles::{ChannelOptions, Displacement, Paint, Traces, VectorDisplacement};

use crate::shapes::{redo_both, undo_both};

const LIMIT: u64 = 1 << 30;
const FACES: u32 = 8;
/// Bytes of a tile of 8 texels a side: of displacement, and of colour with its mips.
const TILE: [u64; 2] = [200, 400 + 4 * (36 + 16)];

fn mesh() -> Mesh {
    grid(FACES, false, &[2], false)
}

fn object(context: &Context, mesh: &Mesh, room: u64) -> DisplacedObject {
    let surface = Surface::new(context, mesh, &SurfaceOptions::default()).unwrap();
    let options = |tile: u64| ChannelOptions { size: 8, budget: room * tile, ..ChannelOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options(TILE[0])).unwrap();
    let white = Vec4::new(0.5, 0.25, 0.125, 1.0);
    let paint = Paint::of_color(surface.topology().clone(), white, &options(TILE[1])).unwrap();
    let vectors = VectorDisplacement::on(&surface, &options(3 * TILE[0])).unwrap();
    let traces = Traces::of(displacement.field(), 4 * room * TILE[0]).unwrap();
    let mut object = DisplacedObject::new(context, surface, &mesh.points, displacement, DAffine3::IDENTITY).unwrap();
    object.set_paint(paint).unwrap();
    object.set_traces(traces).unwrap();
    object.set_vectors(vectors).unwrap();
    object
}

/// One whose tiles page when there are more than `room` of a kind.
fn paging(context: &Context, mesh: &Mesh, room: u64) -> (DisplacedObject, PageFile) {
    let (mut object, file) = (object(context, mesh, room), PageFile::new(None));
    object.page_to(Some(Arc::new(file.clone()))).unwrap();
    (object, file)
}

fn stored(context: &Context, mesh: &Mesh, object: &DisplacedObject) -> Document {
    let mut document = Document::new(mesh, context.level().name()).unwrap();
    object.store(context, &mut document).unwrap();
    document
}

fn bytes(context: &Context, mesh: &Mesh, object: &DisplacedObject) -> Vec<u8> {
    stored(context, mesh, object).to_bytes().unwrap()
}

fn check_memory(object: &DisplacedObject) {
    let (displacement, paint) = (object.displacement(), object.paint().unwrap());
    assert!(displacement.resident_bytes() <= displacement.budget());
    assert!(paint.resident_bytes() <= paint.budget());
}

fn commit(object: &mut DisplacedObject) {
    object.commit_displacement();
    object.commit_paint();
    object.report_fault().unwrap();
}

fn dab(random: &mut Random) -> Dab {
    let mut place = || f64::from(random.unit()) * f64::from(FACES);
    let center = DVec3::new(place(), place(), 0.0);
    let half = DVec3::new(0.4, 0.4, 1.0) * (0.5 + f64::from(random.unit()));
    let brush = Brush::on_surface(center, DVec3::Z, DVec3::X, half, Falloff::Smooth).unwrap();
    let sculpt = |mode, height| Action::Sculpt { mode, height };
    let colour = [random.unit(), random.unit(), random.unit(), 1.0];
    let action = match random.below(7) {
        0 | 1 => Action::Paint { mode: PaintMode::Mix, color: colour },
        2 => Action::Paint { mode: PaintMode::Erase, color: colour },
        3 => Action::Paint { mode: PaintMode::Blur, color: colour },
        4 => sculpt(SculptMode::Draw, 0.1 * random.unit()),
        5 => sculpt(SculptMode::Smooth, 0.0),
        _ => sculpt(SculptMode::Erase, 0.0),
    };
    Dab { brush, action, strength: 1.0 }
}

/// Dabs, undos and redos at random on an object that pages and on one that need not.
fn session(path: Option<&Path>, layers: bool, seed: u64) -> Vec<Vec<u8>> {
    let (context, mesh) = (Context::serial(), mesh());
    let mut random = Random(seed);
    let (mut small, file) = paging(&context, &mesh, 20);
    let mut large = object(&context, &mesh, 1 << 20);
    let (mut history, mut model) = (History::new(20_000), History::new(LIMIT));
    if let Some(path) = path {
        history.save(path, &stored(&context, &mesh, &small)).unwrap();
    }
    let mut states = vec![bytes(&context, &mesh, &large)];
    let mut paged = 0;
    for step in 0..120 {
        match random.below(6) {
            0 => undo_both(&context, [(&mut history, &mut small), (&mut model, &mut large)]),
            1 => redo_both(&context, [(&mut history, &mut small), (&mut model, &mut large)]),
            _ => {
                let dab = dab(&mut random);
                let kind = [Kind::Scalar, Kind::Rgba8][step / 40 % 2];
                let make = |object: &mut DisplacedObject, history: &mut History| {
                    history.begin(&context, object, &format!("step {step}")).unwrap();
                    if layers && step % 40 == 10 {
                        let name = format!("layer {step}");
                        object.add_layer(&context, kind, &name, Settings::of(kind), 8).unwrap();
                    }
                    assert_eq!(dab.apply(&context, object).unwrap().refused, [0u32; 0]);
                    history.end(&context, object).unwrap()
                };
                assert_eq!(make(&mut small, &mut history), make(&mut large, &mut model));
            }
        }
        commit(&mut small);
        check_memory(&small);
        paged += small.displacement().paged_count() + small.paint().unwrap().paged_count();
        states.push(bytes(&context, &mesh, &large));
        if step % 8 == 7 {
            assert!(bytes(&context, &mesh, &small) == states[step + 1], "step {step}");
            commit(&mut small);
            check_memory(&small);
        }
    }
    assert!(paged > 50, "{paged}");
    while history.undo(&context, &mut small).unwrap().is_some() {}
    assert!(bytes(&context, &mesh, &small) == states[0]);
    assert_eq!((small.displacement().bytes(), small.paint().unwrap().bytes()), (0, 0));
    drop(history);
    drop(small);
    assert_eq!((file.pages(), file.bytes()), (0, 0));
    states
}

#[test]
fn edits_undone_and_made_again_are_those_of_an_object_that_need_not_page() {
    session(None, false, 7);
}

#[test]
fn layers_page_as_well() {
    session(None, true, 8);
}

#[test]
fn a_document_that_was_paged_beside_opens_after_a_kill_at_any_byte() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("session.relievo");
    let states = session(Some(&path), true, 8);
    let (context, mesh) = (Context::serial(), mesh());
    let (whole, mut random) = (std::fs::read(&path).unwrap(), Random(3));
    let base = Document::parse(&states[0], LIMIT).unwrap().to_bytes().unwrap().len();
    for kill in 0..60 {
        let cut = if kill == 0 { whole.len() } else { base + random.below(whole.len() - base) };
        let killed = folder.path().join("killed.relievo");
        std::fs::write(&killed, &whole[..cut]).unwrap();
        let (document, mut history) = History::open(&killed, LIMIT, 20_000).unwrap();
        // It opens on a budget that it does not fit, and goes on there.
        let (mut small, _) = paging(&context, &mesh, 20);
        small.take_up(&context, &document, 20 * TILE[1]).unwrap();
        let now = bytes(&context, &mesh, &small);
        assert!(states.contains(&now), "{cut} of {}", whole.len());
        commit(&mut small);
        check_memory(&small);
        if history.undo(&context, &mut small).unwrap().is_some() {
            assert!(states.contains(&bytes(&context, &mesh, &small)), "{cut} of {}", whole.len());
            history.redo(&context, &mut small).unwrap().unwrap();
        }
        assert!(bytes(&context, &mesh, &small) == now, "{cut} of {}", whole.len());
    }
}

#[test]
fn a_stroke_over_more_than_the_budget_makes_the_document_that_it_makes_without() {
    let (context, mesh) = (Context::serial(), mesh());
    let stroke = |action| {
        let at = |k: u32| DVec3::new(0.3 + f64::from(k % 9), f64::from(k / 9) * 1.8, 0.0);
        let points = (0..45).map(|k| StrokePoint::new(at(k), 1.0)).collect();
        let settings = StrokeSettings { radius: 0.8, reach: 9.0, ..StrokeSettings::default() };
        Stroke::new(points, settings, Falloff::Smooth, action)
    };
    let strokes = [
        stroke(Action::Sculpt { mode: SculptMode::Draw, height: 0.05 }),
        stroke(Action::Paint { mode: PaintMode::Mix, color: [0.9, 0.1, 0.2, 1.0] }),
        stroke(Action::Sculpt { mode: SculptMode::Layer, height: 0.05 }),
    ];
    let [(mut small, file), (mut large, _)] = [24, 1 << 20].map(|room| paging(&context, &mesh, room));
    for stroke in &strokes {
        for object in [&mut small, &mut large] {
            assert_eq!(stroke.apply(&context, object).unwrap().report.refused, [0u32; 0]);
        }
    }
    commit(&mut small);
    check_memory(&small);
    let tiles = (FACES * FACES) as usize;
    let (there, paged) = (small.displacement().allocated_count(), small.displacement().paged_count());
    assert!(there > tiles - 16 && paged + 24 >= there, "{there} {paged}");
    assert!(small.states(&context).is_ok() && file.bytes() > 0);
    assert!(bytes(&context, &mesh, &small) == bytes(&context, &mesh, &large));
    assert_eq!(large.displacement().paged_count(), 0);
    // All that was there comes back to memory.
    small.page_to(None).unwrap();
    assert_eq!((small.displacement().bytes(), file.bytes()), (large.displacement().bytes(), 0));
    assert!(bytes(&context, &mesh, &small) == bytes(&context, &mesh, &large));
}
