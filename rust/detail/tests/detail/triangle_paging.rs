//! Triangle meshes that page, held against meshes that need not: dabs, imprints, layers, undo, documents.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec4};
use relievo_core::{Context, Mesh};
use relievo_detail::{
    Action, Brush, Collider, Dab, Falloff, History, ImprintSettings, Imprinter, LayeredObject, Moment, PaintMode,
    SculptMode, TriangleObject,
};
use relievo_document::{Kind, PageFile, Settings};
use relievo_surface::TriangleSurface;
use relievo_testing::{Random, grid};
use relievo_tiles::Trace;
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions};

use crate::shapes::{redo_both, stored_bytes, stored_triangles, undo_both};

const LIMIT: u64 = 1 << 30;
const SIDE: u32 = 6;

fn mesh() -> Mesh {
    grid(SIDE, false, &[2], false)
}

/// A mesh with room for `room` values of 16 segments a face, each channel.
fn object(context: &Context, mesh: &Mesh, room: u64) -> TriangleObject {
    let surface = TriangleSurface::new(context, mesh).unwrap();
    let topology = surface.topology().clone();
    let vertices = topology.vertex_count() as u64;
    // Imprints are small.
    let traced = if room < 99 { 8 } else { room };
    let options = |bytes: u64| TriangleOptions { segments: 16, budget: bytes * (vertices + room * 214) };
    let displacement = TriangleChannel::displacement(topology.clone(), &options(2)).unwrap();
    let mut object = TriangleObject::new(context, surface, displacement, DAffine3::IDENTITY).unwrap();
    let base = Vec4::new(0.5, 0.25, 0.125, 1.0);
    object.set_paint(TriangleChannel::of_color(topology.clone(), base, &options(4)).unwrap()).unwrap();
    let traced = TriangleOptions { segments: 16, budget: 16 * (vertices + traced * 214) };
    object.set_traces(TriangleChannel::blank(topology.clone(), Trace::default(), &traced).unwrap()).unwrap();
    object.set_vectors(TriangleChannel::vectors(topology, &options(6)).unwrap()).unwrap();
    object
}

fn commit(context: &Context, object: &mut TriangleObject) {
    object.commit_vectors(context).unwrap();
    object.commit_paint();
    object.traces_mut().unwrap().commit();
    object.commit_displacement();
    object.report_fault().unwrap();
}

fn check_memory(object: &TriangleObject) {
    let (displacement, paint) = (object.displacement(), object.paint().unwrap());
    assert!(displacement.resident_bytes() <= displacement.budget());
    assert!(paint.resident_bytes() <= paint.budget());
    let (traces, vectors) = (object.traces().unwrap(), object.vectors().unwrap());
    assert!(traces.resident_bytes() <= traces.budget() && vectors.resident_bytes() <= vectors.budget());
}

fn dab(random: &mut Random) -> Dab {
    let mut place = || f64::from(random.unit()) * f64::from(SIDE);
    let (center, half) = (DVec3::new(place(), place(), 0.0), 0.3 + 0.3 * f64::from(random.unit()));
    let brush = Brush::new(center, DMat3::IDENTITY, DVec3::new(half, half, 3.0), Falloff::Smooth).unwrap();
    let color = [random.unit(), random.unit(), random.unit(), 1.0];
    let sculpt = |mode, height| Action::Sculpt { mode, height };
    let action = match random.below(9) {
        0 | 1 => Action::Paint { mode: PaintMode::Mix, color },
        2 => Action::Paint { mode: PaintMode::Erase, color },
        3 => Action::Paint { mode: PaintMode::Blur, color },
        4 => sculpt(SculptMode::Draw, 0.1 * random.unit()),
        5 => sculpt(SculptMode::Smooth, 0.0),
        6 | 7 => sculpt(SculptMode::Pinch, 0.05),
        _ => sculpt(SculptMode::Erase, 0.0),
    };
    Dab { brush, action, strength: 1.0 }
}

fn press(context: &Context, random: &mut Random, object: &mut TriangleObject) {
    let mut place = || f64::from(random.unit()) * f64::from(SIDE);
    let at = |k: u32| 0.4 * (f64::from(k % 2) - 0.5);
    let points = (0..8).map(|k| [at(k), at(k >> 1), at(k >> 2)].map(|value| value as f32)).collect();
    let faces = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
    let placed = DAffine3::from_translation(DVec3::new(place(), place(), 0.15));
    let cube = Collider::of_mesh(context, &Mesh::new(points, vec![4; 6], faces), placed).unwrap();
    let settings = ImprintSettings { voxels: 1 << 14, smoothing: 0.3, ..Default::default() };
    let report = Imprinter::new().imprint(context, object, &cube, &settings, Moment::default()).unwrap();
    assert_eq!(report.refused, [0u32; 0]);
    object.settle(context).unwrap();
}

fn paged(object: &TriangleObject) -> usize {
    let (traces, vectors) = (object.traces().unwrap().paged().len(), object.vectors().unwrap().paged().len());
    object.displacement().paged().len() + object.paint().unwrap().paged().len() + traces + vectors
}

/// Dabs, imprints, undos and redos at random on a mesh that pages and on one that need not.
fn session(layers: bool, seed: u64) {
    let (context, mesh) = (Context::serial(), mesh());
    let mut random = Random(seed);
    let (mut small, file) = (object(&context, &mesh, 14), PageFile::new(None));
    small.page_to(Some(Arc::new(file.clone()))).unwrap();
    let mut large = object(&context, &mesh, 1 << 20);
    let (mut history, mut model) = (History::new(20_000), History::new(LIMIT));
    let first = stored_bytes(&context, &mesh, &large);
    let mut seen = [0; 4];
    for step in 0..160 {
        match random.below(6) {
            0 => undo_both(&context, [(&mut history, &mut small), (&mut model, &mut large)]),
            1 => redo_both(&context, [(&mut history, &mut small), (&mut model, &mut large)]),
            _ => {
                let (dab, state, presses) = (dab(&mut random), random.below(1 << 30) as u64, random.below(3) == 0);
                let (kind, level) = ([Kind::Scalar, Kind::Rgba8][step / 40 % 2], u32::from(random.below(4) == 0));
                let make = |object: &mut TriangleObject, history: &mut History| {
                    history.begin(&context, object, &format!("step {step}")).unwrap();
                    if layers && step % 40 == 10 {
                        let name = format!("layer {step}");
                        object.add_layer(&context, kind, &name, Settings::of(kind), 16).unwrap();
                    }
                    if presses {
                        press(&context, &mut Random(state | 1), object);
                    } else {
                        object.set_level(level).unwrap();
                        assert_eq!(object.dab(&context, &dab).unwrap().refused, [0u32; 0]);
                        object.set_level(0).unwrap();
                    }
                    history.end(&context, object).unwrap()
                };
                assert_eq!(make(&mut small, &mut history), make(&mut large, &mut model));
            }
        }
        // How far what is displaced reaches is measured when it is committed, and imprints go by it.
        commit(&context, &mut large);
        commit(&context, &mut small);
        check_memory(&small);
        let channels = [small.displacement().paged(), small.paint().unwrap().paged()];
        let others = [small.traces().unwrap().paged(), small.vectors().unwrap().paged()];
        seen.iter_mut().zip(channels.iter().chain(&others)).for_each(|(seen, paged)| *seen += paged.len());
        if step % 8 == 7 {
            assert!(stored_bytes(&context, &mesh, &small) == stored_bytes(&context, &mesh, &large), "step {step}");
            commit(&context, &mut small);
            check_memory(&small);
        }
    }
    assert!(seen.iter().all(|paged| *paged > 20), "{seen:?}");
    // From a document of all that on a small budget.
    let document = stored_triangles(&context, &mesh, &large);
    let mut opened = object(&context, &mesh, 14);
    opened.page_to(Some(Arc::new(PageFile::new(None)))).unwrap();
    let budget = small.vectors().unwrap().budget();
    assert!(opened.take_up(&context, &document, budget).unwrap().is_empty());
    assert!(paged(&opened) > 0 && stored_bytes(&context, &mesh, &opened) == document.to_bytes().unwrap());
    // All that was there comes back to memory.
    opened.page_to(None).unwrap();
    assert!(paged(&opened) == 0 && stored_bytes(&context, &mesh, &opened) == document.to_bytes().unwrap());
    while history.undo(&context, &mut small).unwrap().is_some() {}
    assert!(stored_bytes(&context, &mesh, &small) == first);
    drop((history, small));
    assert_eq!((file.pages(), file.bytes()), (0, 0));
}

#[test]
fn edits_undone_and_made_again_are_those_of_a_mesh_that_need_not_page() {
    session(false, 7);
}

#[test]
fn layers_page_as_well() {
    session(true, 8);
}
