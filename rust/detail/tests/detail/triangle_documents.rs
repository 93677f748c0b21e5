//! Triangle meshes in documents, in histories and in layers: to the bit, and against sums of their own.

use glam::{DAffine3, DMat3, DVec3, Vec4};
use relievo_core::{Context, Mesh};
use relievo_detail::{
    Action, Brush, Collider, Dab, Falloff, History, ImprintSettings, Imprinter, LayeredObject, Moment, PaintMode,
    Recorded, SculptMode, Stroke, StrokePoint, StrokeSettings, TriangleObject,
};
use relievo_document::{Blend, Document, Kind, Settings, examine};
use relievo_surface::TriangleSurface;
use relievo_testing::Random;
use relievo_tiles::triangle::{
    FaceRates, Node, Pattern, TriangleChannel, TriangleField, TriangleOptions, TriangleSets,
};
use relievo_tiles::{ColorTexel, Rgba8, Rgba16, Trace};

use crate::shapes::{halved, squares, stored_bytes, stored_triangles};

const LIMIT: u64 = 1 << 30;
const BASE: Vec4 = Vec4::new(0.5, 0.25, 0.125, 1.0);

/// A square from 0 to `n`, a little bent, of squares cut in two, with a third triangle along an edge in its middle.
fn sail(n: u32) -> Mesh {
    let mut points: Vec<[f32; 3]> =
        (0..=n).flat_map(|y| (0..=n).map(move |x| [x as f32, y as f32, 0.02 * (x * y) as f32])).collect();
    let corner = |x: u32, y: u32| y * (n + 1) + x;
    let mut triangles = halved(&squares(n));
    triangles.push([corner(n / 2, n / 2), corner(n / 2 + 1, n / 2), points.len() as u32]);
    points.push([0.5 * n as f32, 0.5 * n as f32, 1.0]);
    Mesh::from_triangles(points, &triangles)
}

fn object(context: &Context, mesh: &Mesh, segments: u32, budget: u64) -> TriangleObject {
    let surface = TriangleSurface::new(context, mesh).unwrap();
    let topology = surface.topology().clone();
    let options = TriangleOptions { segments, budget };
    let displacement = TriangleChannel::displacement(topology.clone(), &options).unwrap();
    let mut object = TriangleObject::new(context, surface, displacement, DAffine3::IDENTITY).unwrap();
    object.set_paint(TriangleChannel::of_color(topology.clone(), BASE, &options).unwrap()).unwrap();
    object.set_vectors(TriangleChannel::vectors(topology, &options).unwrap()).unwrap();
    object
}

/// What is seen, to the bit.
fn seen(object: &TriangleObject) -> Vec<u8> {
    let heights = object.displacement();
    let paint = object.paint().unwrap();
    let blocks = heights.blocks().into_iter().map(|block| heights.read(block).unwrap().unwrap());
    blocks.chain(paint.blocks().into_iter().map(|block| paint.read(block).unwrap().unwrap())).flatten().collect()
}

fn dab_at(x: f64, y: f64, radius: f64, action: Action) -> Dab {
    let brush = Brush::new(DVec3::new(x, y, 0.0), DMat3::IDENTITY, DVec3::new(radius, radius, 3.0), Falloff::Smooth);
    Dab { brush: brush.unwrap(), action, strength: 1.0 }
}

fn draw(height: f32) -> Action {
    Action::Sculpt { mode: SculptMode::Draw, height }
}

fn any_dab(random: &mut Random, n: u32) -> Dab {
    let mut place = || f64::from(random.unit()) * f64::from(n);
    let (x, y) = (place(), place());
    let color = [random.unit(), random.unit(), random.unit(), 1.0];
    let action = match random.below(7) {
        0 | 1 => Action::Paint { mode: PaintMode::Mix, color },
        2 => Action::Paint { mode: PaintMode::Erase, color },
        3 => draw(0.1 * random.unit()),
        4 => Action::Sculpt { mode: SculptMode::Smooth, height: 0.0 },
        5 => Action::Sculpt { mode: SculptMode::Inflate, height: 0.05 },
        _ => Action::Sculpt { mode: SculptMode::Erase, height: 0.0 },
    };
    dab_at(x, y, 0.3 + 0.7 * f64::from(random.unit()), action)
}

/// Some edit: a dab at some level, or an imprint.
fn any_edit(context: &Context, random: &mut Random, object: &mut TriangleObject, n: u32) {
    if random.below(8) == 0 {
        let mut place = || f64::from(random.unit()) * f64::from(n);
        let (x, y) = (place(), place());
        let at = |k: u32| f64::from(k % 2) - 0.5;
        let points = (0..8).map(|k| [at(k), at(k >> 1), at(k >> 2)].map(|value| 0.5 * value as f32)).collect();
        let faces = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
        let cube = Mesh::new(points, vec![4; 6], faces);
        let place = DAffine3::from_translation(DVec3::new(x, y, 0.02 * x * y + 0.2));
        let collider = Collider::of_mesh(context, &cube, place).unwrap();
        let settings = ImprintSettings { voxels: 1 << 14, ..Default::default() };
        let moment = Moment { frame: 0, step: 0, pair: 0 };
        Imprinter::new().imprint(context, object, &collider, &settings, moment).unwrap();
        object.settle(context).unwrap();
    } else {
        object.set_level(random.below(3) as u32).unwrap();
        object.dab(context, &any_dab(random, n)).unwrap();
        object.set_level(0).unwrap();
    }
}

#[test]
fn hundreds_of_edits_are_undone_made_again_and_replayed_to_the_bit() {
    let (context, n) = (Context::serial(), 5);
    let mesh = sail(n);
    let vertices = 6 * mesh.points.len() as u64;
    // Room for fewer faces than there are, so that some are refused.
    let mut object = object(&context, &mesh, 16, vertices + 30 * 800);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("session.relievo");
    let start = stored_bytes(&context, &mesh, &object);
    let memory = [object.displacement().bytes(), object.paint().unwrap().bytes()];
    let mut random = Random(7);
    let mut history = History::new(20_000);
    let mut make = |object: &mut TriangleObject, history: &mut History, count: usize| {
        for index in 0..count {
            history.begin(&context, object, &format!("edit {index}")).unwrap();
            any_edit(&context, &mut random, object, n);
            history.end(&context, object).unwrap();
        }
    };
    make(&mut object, &mut history, 150);
    history.save(&path, &stored_triangles(&context, &mesh, &object)).unwrap();
    make(&mut object, &mut history, 450);
    let (end, shown) = (stored_bytes(&context, &mesh, &object), seen(&object));
    let count = history.undo_count();
    assert!(count > 400, "{count}");
    while history.undo(&context, &mut object).unwrap().is_some() {}
    assert!(stored_bytes(&context, &mesh, &object) == start);
    assert_eq!([object.displacement().bytes(), object.paint().unwrap().bytes()], memory);
    while history.redo(&context, &mut object).unwrap().is_some() {}
    assert!(stored_bytes(&context, &mesh, &object) == end && seen(&object) == shown);
    drop(history);

    let (document, mut history) = History::open(&path, LIMIT, 20_000).unwrap();
    document.fit_triangles(&mesh).unwrap();
    let mut object = self::object(&context, &mesh, 16, LIMIT);
    assert!(object.take_up(&context, &document, LIMIT).unwrap().is_empty());
    assert!(stored_bytes(&context, &mesh, &object) == end && seen(&object) == shown && history.undo_count() == count);
    while history.undo(&context, &mut object).unwrap().is_some() {}
    assert!(stored_bytes(&context, &mesh, &object) == start);
    drop(history);
    // Folded into its base it is the same.
    relievo_document::compact(&path, LIMIT, 0).unwrap();
    assert!(Document::open(&path, LIMIT).unwrap().to_bytes().unwrap() == start);
}

#[test]
fn documents_keep_all_kinds_of_values_and_fit_nothing_else() {
    let (context, mesh) = (Context::serial(), sail(3));
    let mut object = object(&context, &mesh, 32, LIMIT);
    object.dab(&context, &dab_at(1.2, 1.1, 0.8, draw(0.2))).unwrap();
    object.set_level(2).unwrap();
    object.dab(&context, &dab_at(2.2, 2.1, 0.8, draw(0.2))).unwrap();
    object.dab(&context, &dab_at(2.0, 1.0, 1.0, Action::Paint { mode: PaintMode::Mix, color: [1.0; 4] })).unwrap();
    let topology = object.surface().topology().clone();
    let options = TriangleOptions { segments: 8, budget: LIMIT };
    let mut traces = TriangleChannel::blank(topology.clone(), Trace::default(), &options).unwrap();
    let sets = TriangleSets { allocate: vec![3, 4], ..Default::default() };
    traces.apply(&context, Pattern::new(8).unwrap(), &sets).unwrap();
    object.set_traces(traces).unwrap();
    let mut deep = TriangleChannel::<Rgba16>::of_color(topology.clone(), BASE, &options).unwrap();
    deep.apply(&context, Pattern::new(4).unwrap(), &sets).unwrap();

    let mut document = stored_triangles(&context, &mesh, &object);
    deep.field().store(&context, &mut document, "light").unwrap();
    let kinds: Vec<Kind> = document.layers().iter().map(|layer| layer.kind()).collect();
    assert_eq!(kinds, [Kind::Scalar, Kind::Rgba8, Kind::Trace, Kind::Vector, Kind::Rgba16]);
    let parsed = Document::parse(&document.to_bytes().unwrap(), LIMIT).unwrap();
    assert_eq!((parsed.version, &parsed), (5, &document));
    let shown = parsed.to_string();
    assert!(shown.contains("segments an edge: 32") && shown.contains("17 points"), "{shown}");
    let same = TriangleChannel::<Rgba16>::stored(&context, topology.clone(), &parsed, "light", LIMIT).unwrap().unwrap();
    assert_eq!((same.blocks(), same.bytes()), (deep.blocks(), deep.bytes()));
    assert!(TriangleChannel::<Rgba8>::stored(&context, topology.clone(), &parsed, "light", LIMIT).is_err());
    assert!(TriangleChannel::<Rgba16>::stored(&context, topology, &parsed, "light", deep.bytes() - 1).is_err());
    let mut again = self::object(&context, &mesh, 8, LIMIT);
    assert_eq!(again.take_up(&context, &parsed, LIMIT).unwrap(), ["light"]);
    assert!(seen(&again) == seen(&object));

    // Polygons are fanned; their points may move.
    let mut moved = mesh.clone();
    moved.points.iter_mut().for_each(|point| point[0] *= 2.0);
    parsed.fit_triangles(&moved).unwrap();
    let refused = |error: relievo_core::Error, expected: &str| {
        assert!(error.to_string().contains(expected), "{error}");
    };
    refused(parsed.fit(&mesh).unwrap_err(), "on a surface of triangles");
    refused(parsed.fit_triangles(&sail(2)).unwrap_err(), "other triangles: it has 19 faces");
    let mut more = mesh.clone();
    more.points.push([0.0; 3]);
    refused(parsed.fit_triangles(&more).unwrap_err(), "it has 17 points, this one 18");
    refused(Document::new(&mesh, "x").unwrap().fit_triangles(&mesh).unwrap_err(), "on a Catmull-Clark surface");
    let mut other = self::object(&context, &sail(2), 8, LIMIT);
    assert!(other.take_up(&context, &parsed, LIMIT).is_err());
    let cage = Document::new(&mesh, "x").unwrap();
    assert!(object.store(&context, &mut cage.clone()).is_err());
}

#[test]
fn what_is_damaged_is_named_and_the_rest_opens() {
    let (context, mesh) = (Context::serial(), sail(3));
    let mut object = object(&context, &mesh, 16, LIMIT);
    object.dab(&context, &dab_at(1.2, 1.1, 0.8, draw(0.2))).unwrap();
    let document = stored_triangles(&context, &mesh, &object);
    let bytes = document.to_bytes().unwrap();
    let packed: usize =
        document.layers().iter().flat_map(|layer| layer.blocks()).map(|block| block.packed_bytes()).sum();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.relievo");
    let mut seen = std::collections::BTreeSet::new();
    // The header and the index stand before the blocks and once more after them.
    let mut at = (bytes.len() - packed) / 2;
    for block in document.layers().iter().flat_map(|layer| layer.blocks()) {
        let mut damaged = bytes.clone();
        damaged[at + block.packed_bytes() / 2] ^= 0x10;
        at += block.packed_bytes();
        std::fs::write(&path, &damaged).unwrap();
        let (_, damage) = examine(&context, &path).unwrap();
        let name = document.topology().block_name(block.tile());
        assert!(damage.len() == 1 && damage[0].place.contains(&name), "{damage:?}");
        seen.insert(name.split(' ').next().unwrap_or_default().to_string());
        relievo_document::repair(&context, &path).unwrap();
        let mut again = self::object(&context, &mesh, 16, LIMIT);
        again.take_up(&context, &Document::open(&path, LIMIT).unwrap(), LIMIT).unwrap();
        again.renew(&context).unwrap();
        let topology = again.surface().topology().clone();
        let field = again.displacement().field();
        for face in field.allocated() {
            assert!(topology.edges_of(face).iter().all(|edge| field.edge_pattern(*edge) >= field.face_pattern(face)));
        }
        (0..topology.face_count() as u32).for_each(|face| drop(again.piece(face).unwrap()));
    }
    assert_eq!(seen.into_iter().collect::<Vec<_>>(), ["edge", "points", "triangle"]);
}

fn scalar(blend: Blend, opacity: f32) -> Settings {
    Settings { opacity, blend, visible: true }
}

/// All vertices of the finest tessellation.
fn knots(object: &TriangleObject) -> impl Iterator<Item = (u32, Pattern, Node)> {
    let pattern = Pattern::new(64).unwrap();
    let rates = FaceRates { sides: [pattern.segments(); 3], inside: Some(pattern) };
    let faces = 0..object.surface().topology().face_count() as u32;
    faces.flat_map(move |face| rates.places().into_iter().map(move |(pattern, node)| (face, pattern, node)))
}

fn heights(object: &TriangleObject) -> Vec<f32> {
    let field: &TriangleField = object.displacement().field();
    knots(object).map(|(face, pattern, node)| field.at(face, pattern, node) as f32).collect()
}

fn difference(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn edits_go_to_the_active_layer_and_are_seen_as_they_were_made() {
    let (context, mesh) = (Context::serial(), sail(4));
    let dabs = [dab_at(1.4, 1.2, 1.1, draw(0.25)), dab_at(2.2, 1.8, 0.9, draw(-0.125))];
    let mut plain = object(&context, &mesh, 16, LIMIT);
    plain.dab(&context, &dabs[0]).unwrap();
    let below = heights(&plain);
    plain.dab(&context, &dabs[1]).unwrap();
    let both = heights(&plain);
    for (blend, opacity) in [(Blend::Add, 1.0), (Blend::Add, 0.3), (Blend::Subtract, 0.5)] {
        let mut object = object(&context, &mesh, 16, LIMIT);
        object.dab(&context, &dabs[0]).unwrap();
        let start = seen(&object);
        let (id, refused) = object.add_layer(&context, Kind::Scalar, "dents", scalar(Blend::Add, 1.0), 16).unwrap();
        assert!(refused.is_empty() && seen(&object) == start, "an empty layer shows");
        object.set_layer(&context, id, scalar(blend, opacity)).unwrap();
        object.dab(&context, &dabs[1]).unwrap();
        assert!(difference(&heights(&object), &both) < 4e-4, "{blend:?}: {}", difference(&heights(&object), &both));
        // On its own the layer is what was made, and hidden it is gone.
        object.set_layer(&context, id, Settings { visible: false, ..scalar(blend, opacity) }).unwrap();
        assert!(difference(&heights(&object), &below) == 0.0);
        assert!(object.dab(&context, &dabs[1]).is_err());
        object.set_layer(&context, id, scalar(blend, opacity)).unwrap();
        let shown = heights(&object);
        object.merge_layer(&context, id).unwrap();
        assert!(object.layers().len() == 3 - 1 && difference(&heights(&object), &shown) < 1e-6);
    }
}

#[test]
fn layers_of_other_segments_are_linear_between_theirs() {
    let (context, mesh) = (Context::serial(), sail(4));
    let mut coarse = object(&context, &mesh, 8, LIMIT);
    coarse.dab(&context, &dab_at(1.4, 1.2, 1.1, draw(0.25))).unwrap();
    let expected = heights(&coarse);
    let bytes = coarse.displacement().bytes();
    let (id, _) = coarse.add_layer(&context, Kind::Scalar, "fine", scalar(Blend::Add, 1.0), 32).unwrap();
    assert_eq!(coarse.displacement().field().pattern().segments(), 32);
    // Where no finer layer has anything the composite keeps the fewer values.
    assert!(difference(&heights(&coarse), &expected) == 0.0 && coarse.displacement().bytes() == bytes);
    coarse.dab(&context, &dab_at(1.6, 1.3, 0.5, draw(0.1))).unwrap();
    assert!(coarse.displacement().field().allocated().any(|face| {
        coarse.displacement().field().face_pattern(face).is_some_and(|pattern| pattern.segments() == 32)
    }));
    coarse.remove_layer(&context, id).unwrap();
    assert!(difference(&heights(&coarse), &expected) == 0.0);
    assert_eq!(coarse.displacement().bytes(), bytes);
}

#[test]
fn colour_layers_blend_and_whatever_is_done_to_layers_is_undone_to_the_bit() {
    let (context, n) = (Context::serial(), 4);
    let mesh = sail(n);
    let mut object = object(&context, &mesh, 16, LIMIT);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("layers.relievo");
    let mut history = History::new(LIMIT);
    history.save(&path, &stored_triangles(&context, &mesh, &object)).unwrap();
    let mut random = Random(3);
    let state = |object: &mut TriangleObject| {
        object.states(&context).unwrap();
        (stored_bytes(&context, &mesh, object), seen(object))
    };
    let mut states = vec![state(&mut object)];
    let mut names = 0;
    for step in 0..120 {
        history.begin(&context, &mut object, &format!("step {step}")).unwrap();
        let layers = object.layers();
        let any = layers[random.below(layers.len())].clone();
        match random.below(12) {
            0 if layers.len() < 7 => {
                names += 1;
                let kind = if random.below(2) == 0 { Kind::Scalar } else { Kind::Rgba8 };
                let size = [8, 16, 32][random.below(3)];
                object.add_layer(&context, kind, &format!("layer {names}"), Settings::of(kind), size).unwrap();
            }
            1 => {
                let blend = if any.kind == Kind::Scalar { Blend::Subtract } else { Blend::Screen };
                let to = Settings { opacity: 0.3 + 0.7 * random.unit(), blend, visible: random.below(4) > 0 };
                object.set_layer(&context, any.id, to).unwrap();
            }
            2 => drop(object.place_layer(&context, any.id, random.below(3))),
            3 => drop(object.merge_layer(&context, any.id)),
            4 => drop(object.remove_layer(&context, any.id)),
            5 if random.below(3) == 0 => drop(object.flatten_layers(&context).unwrap()),
            6 => object.set_active_layer(&context, any.id).unwrap(),
            _ => {
                object.set_level(random.below(3) as u32).unwrap();
                // The active layer may be hidden.
                drop(object.dab(&context, &any_dab(&mut random, n)));
                object.set_level(0).unwrap();
            }
        }
        if history.end(&context, &mut object).unwrap().is_some() {
            states.push(state(&mut object));
        }
    }
    let last = states.len() - 1;
    assert!(last > 60, "{last}");
    for expected in states[..last].iter().rev() {
        history.undo(&context, &mut object).unwrap().unwrap();
        let found = state(&mut object);
        assert!(found.0 == expected.0);
        let difference = found.1.len() == expected.1.len();
        assert!(difference && found.1 == expected.1, "what is seen differs");
    }
    for expected in &states[1..] {
        history.redo(&context, &mut object).unwrap().unwrap();
        assert!(state(&mut object) == *expected);
    }
    drop(history);
    let document = Document::open(&path, LIMIT).unwrap();
    let mut again = self::object(&context, &mesh, 16, LIMIT);
    again.take_up(&context, &document, LIMIT).unwrap();
    assert!(state(&mut again) == states[last]);
}

#[test]
fn painting_on_a_transparent_layer_covers_what_is_below() {
    let (context, mesh) = (Context::serial(), sail(4));
    let mut object = object(&context, &mesh, 16, LIMIT);
    let (id, _) = object.add_layer(&context, Kind::Rgba8, "glaze", Settings::of(Kind::Rgba8), 16).unwrap();
    let red = Action::Paint { mode: PaintMode::Mix, color: [0.8, 0.05, 0.02, 1.0] };
    let settings = StrokeSettings { radius: 0.8, ..Default::default() };
    let points = [[0.6, 0.9, 0.02], [3.1, 3.0, 0.1]];
    let points = points.iter().map(|p| StrokePoint::new(DVec3::from(*p), 1.0)).collect();
    Stroke::new(points, settings, Falloff::Constant, red).apply(&context, &mut object).unwrap();
    let nearest = |object: &TriangleObject, color: Vec4| {
        let field = object.paint().unwrap().field();
        let off = |texel: Rgba8| texel.0.iter().zip(Rgba8::of_color(color).0).map(|(a, b)| a.abs_diff(b)).max();
        knots(object).filter(|(face, pattern, node)| off(field.texel(*face, *pattern, *node)) <= Some(1)).count()
    };
    let whole = nearest(&object, Vec4::new(0.8, 0.05, 0.02, 1.0));
    assert!(whole > 1000, "{whole}");
    object.set_layer(&context, id, Settings { opacity: 0.5, ..Settings::of(Kind::Rgba8) }).unwrap();
    let half = nearest(&object, 0.5 * (Vec4::new(0.8, 0.05, 0.02, 1.0) + BASE));
    assert!(half >= whole, "{half} {whole}");
    assert_eq!(nearest(&object, Vec4::new(0.8, 0.05, 0.02, 1.0)), 0);
}
