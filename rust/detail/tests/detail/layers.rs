//! Layers of objects: against sums of their own, against blending formulas, and through every kind of undoing.

use glam::{DAffine3, DVec3, Vec4};
use relievo_core::simd::Level;
use relievo_core::{Context, Mesh};
use relievo_detail::{
    Action, Brush, Dab, DisplacedObject, Falloff, History, LayeredObject, PaintMode, Recorded, SculptMode,
};
use relievo_document::{Blend, Document, Kind, Settings};
use relievo_surface::Place;
use relievo_testing::{Random, grid};
use relievo_tiles::{ColorTexel, Field, Rgba8};

use crate::shapes::painted;

const LIMIT: u64 = 1 << 30;
const BASE: Vec4 = Vec4::new(0.5, 0.25, 0.125, 1.0);

fn object(context: &Context, mesh: &Mesh, size: u32) -> DisplacedObject {
    painted(context, mesh, size, BASE, DAffine3::IDENTITY)
}

fn plane() -> Mesh {
    grid(4, false, &[2, 2, 1, 2, 0, 2], false)
}

fn dab_at(x: f64, y: f64, radius: f64, action: Action) -> Dab {
    faded(Falloff::Smooth, x, y, radius, action)
}

fn faded(falloff: Falloff, x: f64, y: f64, radius: f64, action: Action) -> Dab {
    let half = DVec3::new(radius, radius, 2.0);
    let brush = Brush::on_surface(DVec3::new(x, y, 0.0), DVec3::Z, DVec3::X, half, falloff).unwrap();
    Dab { brush, action, strength: 1.0 }
}

fn draw(height: f32) -> Action {
    Action::Sculpt { mode: SculptMode::Draw, height }
}

fn paint(mode: PaintMode, color: [f32; 3]) -> Action {
    Action::Paint { mode, color: [color[0], color[1], color[2], 1.0] }
}

fn scalar(blend: Blend, opacity: f32) -> Settings {
    Settings { opacity, blend, visible: true }
}

/// Everything, layers and composites.
fn bytes(context: &Context, mesh: &Mesh, object: &mut DisplacedObject) -> [Vec<u8>; 2] {
    let mut layers = Document::new(mesh, "baseline").unwrap();
    object.store(context, &mut layers).unwrap();
    let mut seen = Document::new(mesh, "baseline").unwrap();
    object.displacement().field().store(context, &mut seen, "displacement").unwrap();
    object.paint().unwrap().field().store(context, &mut seen, "colour").unwrap();
    [layers.to_bytes().unwrap(), seen.to_bytes().unwrap()]
}

fn height(field: &Field, place: Place) -> f32 {
    field.point(Level::Baseline, field.canonical(place)).d
}

fn places(mesh: &Mesh) -> Vec<Place> {
    let tiles: u32 = mesh.face_sizes.iter().map(|size| if *size == 4 { 1 } else { *size }).sum();
    let at = |k: u32| (k as f32 + 0.37) / 9.0;
    (0..tiles).flat_map(|tile| (0..81).map(move |k| Place::new(tile, at(k % 9), at(k / 9)))).collect()
}

fn heights(object: &DisplacedObject, mesh: &Mesh) -> Vec<f32> {
    places(mesh).into_iter().map(|place| height(object.displacement().field(), place)).collect()
}

fn difference(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn edits_go_to_the_active_layer_and_are_seen_as_they_were_made() {
    let (context, mesh) = (Context::serial(), plane());
    let mut plain = object(&context, &mesh, 16);
    let dabs = [dab_at(1.4, 1.2, 1.1, draw(0.25)), dab_at(2.2, 1.8, 0.9, draw(-0.125))];
    dabs[0].apply(&context, &mut plain).unwrap();
    let below = heights(&plain, &mesh);
    dabs[1].apply(&context, &mut plain).unwrap();
    let both = heights(&plain, &mesh);
    for (blend, opacity) in [(Blend::Add, 1.0), (Blend::Add, 0.3), (Blend::Subtract, 0.5), (Blend::Min, 1.0)] {
        let mut object = object(&context, &mesh, 16);
        dabs[0].apply(&context, &mut object).unwrap();
        let start = bytes(&context, &mesh, &mut object);
        let (id, refused) = object.add_layer(&context, Kind::Scalar, "dents", scalar(Blend::Add, 1.0), 16).unwrap();
        assert!(refused.is_empty() && bytes(&context, &mesh, &mut object)[1] == start[1], "an empty layer shows");
        object.set_layer(&context, id, scalar(blend, opacity)).unwrap();
        let seen = heights(&object, &mesh);
        dabs[1].apply(&context, &mut object).unwrap();
        let expected: Vec<f32> = match blend {
            // Empty places of such a layer are at zero: what is lower stays.
            Blend::Min => both.iter().zip(&below).map(|(both, below)| both - below).collect(),
            _ => both.clone(),
        };
        let now: Vec<f32> = match blend {
            Blend::Min => heights(&object, &mesh).iter().zip(&seen).map(|(now, seen)| now - seen).collect(),
            _ => heights(&object, &mesh),
        };
        // Where the brush meets another surface its weights are a little different.
        let allowed = if blend == Blend::Min { 0.02 } else { 4e-4 };
        assert!(difference(&now, &expected) < allowed, "{blend:?}: {}", difference(&now, &expected));
        let layers = object.layers();
        assert!(layers[1].tiles > 0 && layers[1].active && !layers[0].active && layers[1].name == "dents");
        // Hidden, what is below shows to the bit; flattened, nothing moves.
        object.set_layer(&context, id, Settings { visible: false, ..scalar(blend, opacity) }).unwrap();
        assert!(bytes(&context, &mesh, &mut object)[1] == start[1]);
        let refused = dabs[1].apply(&context, &mut object).unwrap_err().to_string();
        assert!(refused.contains("layer `dents`") && refused.contains("cannot be seen"), "{refused}");
        object.set_layer(&context, id, scalar(blend, opacity)).unwrap();
        let before = bytes(&context, &mesh, &mut object);
        object.flatten_layers(&context).unwrap();
        let after = bytes(&context, &mesh, &mut object);
        assert!(after[1] == before[1] && object.layers().len() == 2, "displacement and colour");
    }
}

#[test]
fn layers_of_other_sizes_are_subdivided_exactly() {
    let (context, mesh) = (Context::serial(), plane());
    let mut coarse = object(&context, &mesh, 8);
    dab_at(1.4, 1.2, 1.3, draw(0.25)).apply(&context, &mut coarse).unwrap();
    let below = heights(&coarse, &mesh);
    let (id, _) = coarse.add_layer(&context, Kind::Scalar, "fine", scalar(Blend::Add, 1.0), 32).unwrap();
    let finer = heights(&coarse, &mesh);
    assert!(difference(&below, &finer) < 6e-4, "{}", difference(&below, &finer));
    dab_at(2.0, 1.5, 0.4, draw(0.125)).apply(&context, &mut coarse).unwrap();
    let mut alone = object(&context, &mesh, 32);
    dab_at(2.0, 1.5, 0.4, draw(0.125)).apply(&context, &mut alone).unwrap();
    let seen = heights(&coarse, &mesh);
    let sum: Vec<f32> = finer.iter().zip(heights(&alone, &mesh)).map(|(a, b)| a + b).collect();
    // The brush is put on a surface that is a little apart.
    assert!(difference(&seen, &sum) < 0.02, "{}", difference(&seen, &sum));
    // Edits of a coarse layer below keep what is fine.
    let base = coarse.layers()[0].id;
    coarse.set_active_layer(&context, base).unwrap();
    dab_at(1.0, 2.5, 1.2, draw(0.25)).apply(&context, &mut coarse).unwrap();
    let both = heights(&coarse, &mesh);
    coarse.set_layer(&context, base, Settings { visible: false, ..scalar(Blend::Add, 1.0) }).unwrap();
    let fine = heights(&coarse, &mesh);
    coarse.set_layer(&context, base, scalar(Blend::Add, 1.0)).unwrap();
    coarse.set_layer(&context, id, Settings { visible: false, ..scalar(Blend::Add, 1.0) }).unwrap();
    let sum: Vec<f32> = heights(&coarse, &mesh).iter().zip(fine).map(|(a, b)| a + b).collect();
    assert!(difference(&both, &sum) < 6e-4, "{}", difference(&both, &sum));
}

#[test]
fn colour_layers_are_transparent_and_blend_in_linear_light() {
    let (context, mesh) = (Context::serial(), plane());
    let mut object = object(&context, &mesh, 16);
    dab_at(1.2, 1.2, 1.2, paint(PaintMode::Mix, [0.9, 0.2, 0.1])).apply(&context, &mut object).unwrap();
    let below = object.paint().unwrap().field().clone();
    let (id, _) = object.add_layer(&context, Kind::Rgba8, "glaze", Settings::of(Kind::Rgba8), 16).unwrap();
    assert!(object.paint().unwrap().field().differing(&below).is_empty());
    let color = [0.3, 0.6, 0.2];
    let cover = paint(PaintMode::Mix, color);
    faded(Falloff::Constant, 1.8, 1.5, 0.8, cover).apply(&context, &mut object).unwrap();
    let covered = object.paint().unwrap().field().clone();
    let middle = |field: &Field<Rgba8>, tile: u32| {
        let at = field.size(tile) as usize / 2;
        field.block(tile).map_or(field.blank(), |block| block[at * (2 * at + 2) + at])
    };
    // Without a layer the same strokes give the same colours, but for rounding.
    let mut flat = self::object(&context, &mesh, 16);
    dab_at(1.2, 1.2, 1.2, paint(PaintMode::Mix, [0.9, 0.2, 0.1])).apply(&context, &mut flat).unwrap();
    faded(Falloff::Constant, 1.8, 1.5, 0.8, cover).apply(&context, &mut flat).unwrap();
    for tile in 0..below.tile_count() as u32 {
        let (a, b) = (middle(&covered, tile), middle(flat.paint().unwrap().field(), tile));
        let apart = a.0.iter().zip(b.0).map(|(a, b)| a.abs_diff(b)).max().unwrap();
        assert!(apart <= 2, "{tile}: {a:?} {b:?}");
    }
    // Multiplied: where the layer is opaque, the product.
    object.set_layer(&context, id, Settings { blend: Blend::Multiply, ..Settings::of(Kind::Rgba8) }).unwrap();
    let seen = object.paint().unwrap().field().clone();
    let changed = seen.differing(&below);
    assert!(!changed.is_empty());
    let mut opaque = 0;
    for tile in 0..below.tile_count() as u32 {
        let is = middle(&covered, tile).color();
        let (now, was) = (middle(&seen, tile).color(), middle(&below, tile).color());
        if (is.truncate() - glam::Vec3::from(color)).abs().max_element() < 0.005 {
            opaque += 1;
            let product = was.truncate() * glam::Vec3::from(color);
            assert!((now.truncate() - product).abs().max_element() < 0.01, "{now} {product}");
        }
    }
    assert!(opaque > 0);
    object.remove_layer(&context, id).unwrap();
    assert!(object.paint().unwrap().field().differing(&below).is_empty());
    assert!(object.remove_layer(&context, object.layers()[1].id).unwrap_err().to_string().contains("last layer"));
}

#[test]
fn merged_layers_look_as_they_did() {
    let (context, mesh) = (Context::serial(), plane());
    let mut object = object(&context, &mesh, 16);
    dab_at(1.2, 1.2, 1.2, draw(0.25)).apply(&context, &mut object).unwrap();
    let (one, _) = object.add_layer(&context, Kind::Scalar, "one", scalar(Blend::Add, 0.5), 16).unwrap();
    dab_at(1.6, 1.2, 0.8, draw(0.25)).apply(&context, &mut object).unwrap();
    let (two, _) = object.add_layer(&context, Kind::Scalar, "two", scalar(Blend::Subtract, 0.75), 32).unwrap();
    dab_at(1.6, 1.8, 0.7, draw(-0.125)).apply(&context, &mut object).unwrap();
    let (three, _) = object.add_layer(&context, Kind::Scalar, "three", scalar(Blend::Max, 1.0), 16).unwrap();
    assert!(object.merge_layer(&context, three).unwrap_err().to_string().contains("flatten"));
    let before = heights(&object, &mesh);
    object.merge_layer(&context, two).unwrap();
    assert!(difference(&before, &heights(&object, &mesh)) < 5e-4);
    assert_eq!(object.layers().iter().filter(|layer| layer.kind == Kind::Scalar).count(), 3);
    object.merge_layer(&context, one).unwrap();
    assert!(difference(&before, &heights(&object, &mesh)) < 5e-4);
    object.merge_layer(&context, three).unwrap();
    assert!(difference(&before, &heights(&object, &mesh)) < 5e-4);
    let names: Vec<String> = object.layers().into_iter().map(|layer| layer.name).collect();
    assert_eq!(names, ["displacement", "colour"]);
    assert!(object.merge_layer(&context, 0).unwrap_err().to_string().contains("no layer below"));
}

/// Some operation on layers or texels.
fn operate(context: &Context, random: &mut Random, object: &mut DisplacedObject, number: usize, sizes: usize) {
    let layers = object.layers();
    let layer = &layers[random.below(layers.len())];
    let (x, y) = (4.0 * f64::from(random.unit()), 4.0 * f64::from(random.unit()));
    let color = [random.unit(), random.unit(), random.unit()];
    let is_color = layer.kind == Kind::Rgba8;
    let blends: Vec<Blend> =
        Blend::NAMES.into_iter().map(|(blend, _)| blend).filter(|blend| blend.suits(layer.kind)).collect();
    let settings =
        Settings { opacity: random.unit(), blend: blends[random.below(blends.len())], visible: random.below(5) != 0 };
    // What is refused changes nothing, which is an edit too.
    let _ = match random.below(14) {
        0 => object
            .add_layer(context, layer.kind, &format!("layer {number}"), settings, 8 << random.below(sizes))
            .map(drop),
        1 => object.set_layer(context, layer.id, settings).map(drop),
        2 => object.place_layer(context, layer.id, random.below(4)).map(drop),
        3 => object.set_active_layer(context, layer.id),
        4 => object.rename_layer(layer.id, &format!("name {number}")),
        5 if random.below(2) == 0 => object.remove_layer(context, layer.id).map(drop),
        6 => object.merge_layer(context, layer.id).map(drop),
        7 if random.below(6) == 0 => object.flatten_layers(context).map(drop),
        _ if is_color => {
            let mode = [PaintMode::Mix, PaintMode::Add, PaintMode::Erase][random.below(3)];
            dab_at(x, y, 0.6, paint(mode, color)).apply(context, object).map(drop)
        }
        _ => {
            let mode = [SculptMode::Draw, SculptMode::Draw, SculptMode::Smooth, SculptMode::Erase][random.below(4)];
            dab_at(x, y, 0.6, Action::Sculpt { mode, height: random.unit() - 0.5 }).apply(context, object).map(drop)
        }
    };
}

#[test]
fn whatever_is_done_to_layers_is_undone_made_again_and_replayed_to_the_bit() {
    let (context, mesh) = (Context::serial(), plane());
    let folder = tempfile::tempdir().unwrap();
    for seed in 0..4 {
        let path = folder.path().join(format!("{seed}.relievo"));
        let sizes = if seed < 2 { 1 } else { 2 };
        let mut object = object(&context, &mesh, 8);
        let mut random = Random(seed);
        let mut history = History::new(20_000);
        let mut document = Document::new(&mesh, "baseline").unwrap();
        object.store(&context, &mut document).unwrap();
        history.save(&path, &document).unwrap();
        let mut states = vec![bytes(&context, &mesh, &mut object)];
        for number in 0..120 {
            history.begin(&context, &mut object, &format!("step {number}")).unwrap();
            operate(&context, &mut random, &mut object, number, sizes);
            match history.end(&context, &mut object) {
                Ok(Some(_)) => states.push(bytes(&context, &mesh, &mut object)),
                Ok(None) => {}
                Err(error) => panic!("{error}"),
            }
        }
        assert!(states.len() > 60 && history.undo_count() == states.len() - 1);
        let layers: Vec<_> = object.states(&context).unwrap().iter().map(|layer| layer.head()).collect();
        assert!(layers.len() > 2, "seed {seed}");
        for state in states.iter().rev().skip(1) {
            history.undo(&context, &mut object).unwrap().unwrap();
            assert!(bytes(&context, &mesh, &mut object)[0] == state[0], "layers, seed {seed}");
            assert!(bytes(&context, &mesh, &mut object)[1] == state[1], "composite, seed {seed}");
        }
        for state in states.iter().skip(1) {
            history.redo(&context, &mut object).unwrap().unwrap();
            assert!(bytes(&context, &mesh, &mut object) == *state, "seed {seed}");
        }
        drop(history);
        let (document, mut history) = History::open(&path, LIMIT, LIMIT).unwrap();
        let mut again = self::object(&context, &mesh, 8);
        assert!(again.take_up(&context, &document, LIMIT).unwrap().is_empty());
        assert!(
            bytes(&context, &mesh, &mut again)[0] == states.last().unwrap()[0],
            "layers from the journal, seed {seed}"
        );
        // Where tiles of different sizes meet, averages at corners round apart when all is computed at once.
        let same = bytes(&context, &mesh, &mut again)[1] == states.last().unwrap()[1];
        let close = difference(&heights(&again, &mesh), &heights(&object, &mesh)) < 1e-3
            && places(&mesh).into_iter().all(|place| {
                let of = |object: &DisplacedObject| object.paint().unwrap().field().color(place);
                (of(&again) - of(&object)).abs().max_element() < 0.02
            });
        assert!(if sizes == 1 { same } else { close }, "their composite, seed {seed}");
        while history.undo(&context, &mut again).unwrap().is_some() {}
        assert!(bytes(&context, &mesh, &mut again) == states[0], "seed {seed}");
    }
}

#[test]
fn what_is_changed_outside_of_edits_survives_undo_and_redo() {
    let (context, mesh) = (Context::serial(), plane());
    let mut object = object(&context, &mesh, 16);
    let mut history = History::new(1 << 20);
    let opacity = |object: &DisplacedObject, name: &str| {
        let layers = object.layers();
        layers.iter().find(|layer| layer.name == name).map(|layer| (layer.settings.opacity, layer.settings.visible))
    };
    history.begin(&context, &mut object, "add").unwrap();
    let (id, _) = object.add_layer(&context, Kind::Scalar, "dents", scalar(Blend::Add, 1.0), 16).unwrap();
    history.end(&context, &mut object).unwrap();
    // Of the layer that the edit made, and of one that it left alone.
    let base = object.layers()[0].clone();
    object.set_layer(&context, id, scalar(Blend::Add, 0.25)).unwrap();
    object.rename_layer(id, "scratches").unwrap();
    object.set_layer(&context, base.id, Settings { visible: false, ..base.settings }).unwrap();
    history.undo(&context, &mut object).unwrap().unwrap();
    assert_eq!((opacity(&object, "scratches"), opacity(&object, &base.name)), (None, Some((1.0, false))));
    history.redo(&context, &mut object).unwrap().unwrap();
    assert_eq!(opacity(&object, "scratches"), Some((0.25, true)));
    assert_eq!(opacity(&object, &base.name), Some((1.0, false)));
    // What is newer counts for a layer that the edit left alone.
    history.undo(&context, &mut object).unwrap().unwrap();
    object.set_layer(&context, base.id, base.settings).unwrap();
    history.redo(&context, &mut object).unwrap().unwrap();
    assert_eq!(opacity(&object, &base.name), Some((1.0, true)));
    // Of a layer whose settings the edit changes: each side keeps its own.
    history.begin(&context, &mut object, "set").unwrap();
    object.set_layer(&context, id, scalar(Blend::Add, 0.5)).unwrap();
    history.end(&context, &mut object).unwrap();
    object.set_layer(&context, id, scalar(Blend::Add, 0.75)).unwrap();
    history.undo(&context, &mut object).unwrap().unwrap();
    assert_eq!(opacity(&object, "scratches"), Some((0.25, true)));
    object.set_layer(&context, id, scalar(Blend::Add, 0.125)).unwrap();
    history.redo(&context, &mut object).unwrap().unwrap();
    assert_eq!(opacity(&object, "scratches"), Some((0.75, true)));
    history.undo(&context, &mut object).unwrap().unwrap();
    assert_eq!(opacity(&object, "scratches"), Some((0.125, true)));
}
