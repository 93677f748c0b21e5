//! Decals that documents keep: taken up, changed, undone; recipes that are cut or changed.

use glam::{DAffine3, Vec4};
use relievo_core::progress::Silent;
use relievo_core::{Context, Mesh};
use relievo_decal::{DecalSettings, Ground, Ink, Pin, Pose, Recipe, Sticker, nearest, next_recipe, recipes};
use relievo_detail::{DisplacedObject, History, LayeredObject};
use relievo_document::{Blend, Document, Settings, compact};
use relievo_render::Image;
use relievo_surface::{Surface, SurfaceOptions};
use relievo_tiles::{ChannelOptions, Displacement, Paint, Rgba8, uniform_rates};

pub const LIMIT: u64 = 256 << 20;

/// A flat cage of 16 quads from 0 to 4.
fn cage() -> Mesh {
    let points = (0..25).map(|index| [(index % 5) as f32, (index / 5) as f32, 0.0]);
    let corners = (0..16).flat_map(|face| {
        let first = face / 4 * 5 + face % 4;
        [first, first + 1, first + 6, first + 5]
    });
    Mesh::new(points.collect(), vec![4; 16], corners.collect())
}

fn object(context: &Context, cage: &Mesh) -> DisplacedObject {
    let surface = Surface::new(context, cage, &SurfaceOptions::default()).expect("a surface");
    let topology = surface.topology().clone();
    let options = ChannelOptions { size: 32, ..ChannelOptions::default() };
    let displacement = Displacement::new(topology.clone(), &options).expect("displacement");
    let mut object = DisplacedObject::new(context, surface, &cage.points, displacement, DAffine3::IDENTITY)
        .unwrap_or_else(|error| panic!("{error}"));
    let grey = Paint::<Rgba8>::of_color(topology, Vec4::new(0.5, 0.5, 0.5, 1.0), &options).expect("colours");
    object.set_paint(grey).expect("colours");
    object
}

/// Blocks of all layers: what an edit can change.
pub fn state(object: &impl LayeredObject) -> Vec<(u32, u32, Vec<u8>)> {
    let states = object.layer_states();
    let blocks = states.iter().flat_map(|state| {
        state
            .blocks
            .numbers()
            .into_iter()
            .filter_map(|number| Some((state.id, number, state.blocks.bytes(number)?.into_owned())))
    });
    blocks.collect()
}

/// Blocks without the numbers of their layers.
pub fn without_layers(state: Vec<(u32, u32, Vec<u8>)>) -> Vec<(u32, Vec<u8>)> {
    state.into_iter().map(|(_, number, bytes)| (number, bytes)).collect()
}

pub fn texels(object: &impl LayeredObject) -> Vec<(u32, Vec<u8>)> {
    without_layers(state(object))
}

pub fn image() -> Image {
    Image::from_data(20, 20, 3, [0.8, 0.1, 0.2].repeat(400)).expect("an image")
}

/// A sticker of 20 pixels over two units, its lower left corner at (1, 1), moved by `by`.
fn recipe(object: &DisplacedObject, cage: &Mesh, ink: Ink, by: f64) -> Recipe {
    let context = Context::serial();
    let rates = uniform_rates(object.surface().topology(), 4);
    let mesh = object.displaced().expect("a surface").tessellate(&context, cage, &rates).expect("triangles").mesh;
    let pin = |x: f64, y: f64| Pin {
        image: [x, y],
        place: nearest(&mesh, [0.1 * x + 1.0 + by, 0.1 * y + 1.0, 0.0]).expect("a place").0,
    };
    pinned_by(pin, 4, ink)
}

/// A sticker of 20 pixels with three pins, on a surface of `cells` cells an edge.
pub fn pinned_by(pin: impl Fn(f64, f64) -> Pin, cells: u32, ink: Ink) -> Recipe {
    Recipe {
        sticker: Sticker::whole([20, 20]).expect("a sticker"),
        image: 0,
        pins: vec![pin(4.0, 4.0), pin(16.0, 4.0), pin(10.0, 16.0)],
        depths: Vec::new(),
        pose: None,
        settings: DecalSettings::default(),
        cells,
        layer: 0,
        ink,
        seen: Settings { opacity: 0.75, ..Settings::of(ink.kind()) },
    }
}

#[test]
fn a_decal_is_applied_closed_opened_and_updated_with_a_moved_pin() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.relievo");
    let (context, cage, image) = (Context::serial(), cage(), image());
    let mut object = object(&context, &cage);
    let mut history = History::new(LIMIT);
    let mut document = Document::new(&cage, "baseline").expect("a document");
    object.store(&context, &mut document).expect("layers");
    history.save(&path, &document).expect("a file");
    let plain = state(&object);
    let given = recipe(&object, &cage, Ink::Color, 0.0);
    let mut ground = Ground { context: &context, object: &mut object, cage: &cage, history: &mut history };
    let applied = ground.apply(given, "label", &image, &mut Silent).unwrap_or_else(|error| panic!("{error}"));
    assert!(applied.printed.texels > 1000 && applied.printed.refused.is_empty() && applied.quality.flips == 0);
    let first = state(&object);
    assert_ne!(first, plain);
    drop(history);

    // Taken up by another program.
    let (document, mut history) = History::open(&path, LIMIT, LIMIT).expect("the document");
    assert!(document.to_string().contains("recipes: 1,"), "{document}");
    let mut again = self::object(&context, &cage);
    again.take_up(&context, &document, LIMIT).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(state(&again), first);
    let kept = recipes(&history);
    let [(id, Ok(mut kept))] = <[_; 1]>::try_from(kept).expect("one decal") else { panic!("it is sound") };
    kept.check_image(&image).expect("the image");
    assert!(kept.check_image(&Image::new(20, 20, 3).expect("an image")).is_err());
    let moved = recipe(&again, &cage, Ink::Color, 0.5);
    kept.pins = moved.pins;
    let mut ground = Ground { context: &context, object: &mut again, cage: &cage, history: &mut history };
    ground.update(id, kept, &image, &mut Silent).unwrap_or_else(|error| panic!("{error}"));

    // As if it had been applied there at first.
    let mut fresh = self::object(&context, &cage);
    let mut other = History::new(LIMIT);
    let there = recipe(&fresh, &cage, Ink::Color, 0.5);
    let mut ground = Ground { context: &context, object: &mut fresh, cage: &cage, history: &mut other };
    ground.apply(there, "label", &image, &mut Silent).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(texels(&again), texels(&fresh));

    // Undo brings back what was there, with its recipe; so does the file, whose history may be dropped.
    history.undo(&context, &mut again).expect("undone").expect("an edit");
    assert_eq!(state(&again), first);
    history.undo(&context, &mut again).expect("undone").expect("an edit");
    assert!(state(&again) == plain && recipes(&history).is_empty());
    history.redo(&context, &mut again).expect("made again").expect("an edit");
    history.redo(&context, &mut again).expect("made again").expect("an edit");
    assert_eq!(texels(&again), texels(&fresh));
    let before = recipes(&history).pop().expect("a decal").1.expect("sound");
    drop(history);
    compact(&path, LIMIT, 0).expect("compacted");
    let (_, mut history) = History::open(&path, LIMIT, LIMIT).expect("the document");
    assert_eq!(recipes(&history).pop().expect("a decal").1.expect("sound"), before);
    let mut ground = Ground { context: &context, object: &mut again, cage: &cage, history: &mut history };
    ground.remove(id).expect("removed");
    assert!(state(&again) == plain && recipes(&history).is_empty());
}

#[test]
fn a_failed_update_changes_nothing_and_a_relief_is_laid_without_itself() {
    let (context, cage, image) = (Context::serial(), cage(), image());
    let mut object = object(&context, &cage);
    let mut history = History::new(LIMIT);
    let given = recipe(&object, &cage, Ink::Relief(0.3), 0.0);
    let mut ground = Ground { context: &context, object: &mut object, cage: &cage, history: &mut history };
    let id = ground.apply(given.clone(), "relief", &image, &mut Silent).expect("applied").id;
    let before = state(&object);
    assert!(object.displaced().is_ok() && recipes(&history).len() == 1);
    let mut twice = given.clone();
    twice.pins[1].place = twice.pins[0].place;
    let mut ground = Ground { context: &context, object: &mut object, cage: &cage, history: &mut history };
    let error = ground.update(id, twice, &image, &mut Silent).expect_err("pins at one place").to_string();
    assert!(error.contains("same place"), "{error}");
    assert!(ground.update(7, given.clone(), &image, &mut Silent).is_err());
    assert_eq!(state(ground.object), before);
    // Written anew from the same recipe it is what it was.
    ground.update(id, given, &image, &mut Silent).expect("updated");
    assert_eq!(texels(&object), without_layers(before));
}

#[test]
fn recipes_that_are_cut_or_changed_are_refused() {
    let (context, cage) = (Context::serial(), cage());
    let object = object(&context, &cage);
    let mut whole = recipe(&object, &cage, Ink::Relief(-2.0), 0.25);
    whole.pose = Some(Pose { width: 2.0, up: [0.0, 1.0, 0.0] });
    whole.depths = vec![0.0, 1.0, -1.0];
    whole.seen = Settings { blend: Blend::Max, opacity: 0.5, visible: true };
    let bytes = whole.encode();
    let read = Recipe::decode(&bytes).expect("what was written");
    assert_eq!((read.encode(), read.seen, read.ink, &read.pins), (bytes.clone(), whole.seen, whole.ink, &whole.pins));
    for cut in 0..bytes.len() {
        assert!(Recipe::decode(&bytes[..cut]).is_err(), "{cut}");
    }
    for (at, bit) in (0..bytes.len()).flat_map(|at| [(at, 0x01), (at, 0x10)]) {
        let mut changed = bytes.clone();
        changed[at] ^= bit;
        assert!(Recipe::decode(&changed).is_err(), "{at}");
        // With a sum that is right it is refused, or a recipe that is written as it was read.
        if at >= 20 {
            let crc = crc32fast::hash(&changed[20..]);
            changed[16..20].copy_from_slice(&crc.to_le_bytes());
            if let Ok(read) = Recipe::decode(&changed) {
                assert_eq!(read.encode(), changed, "{at}: {bit}");
            }
        }
    }
    let mut newer = bytes;
    newer[8] = 2;
    assert!(Recipe::decode(&newer).expect_err("newer").to_string().contains("version 2"));
}

#[test]
fn numbers_of_recipes_ascend_and_end() {
    let of = |id: u32| relievo_document::Recipe { id, bytes: Vec::new() };
    assert_eq!(next_recipe(&[]).expect("the first"), 0);
    assert_eq!(next_recipe(&[of(2), of(7)]).expect("the next"), 8);
    let error = next_recipe(&[of(u32::MAX)]).expect_err("the last").to_string();
    assert!(error.contains("greatest number"), "{error}");
}
