//! Decals that documents of triangle meshes keep: taken up, changed, undone; pins that stay where edits divide faces.

use glam::{DAffine3, Vec4};
use relievo_core::progress::Silent;
use relievo_core::{Context, Mesh};
use relievo_decal::{Ground, Ink, Pin, Place, Printable, Recipe, nearest, recipes};
use relievo_detail::{History, LayeredObject, TriangleObject};
use relievo_document::Document;
use relievo_surface::TriangleSurface;
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions};

use crate::recipes::{LIMIT, image, pinned_by, state, texels, without_layers};
use crate::sheets::sheet;

fn mesh() -> Mesh {
    sheet(4, |u, v| [4.0 * u, 4.0 * v, 0.0])
}

fn object(context: &Context, mesh: &Mesh) -> TriangleObject {
    let surface = TriangleSurface::new(context, mesh).expect("a surface");
    let topology = surface.topology().clone();
    let options = TriangleOptions { segments: 16, budget: LIMIT };
    let displacement = TriangleChannel::displacement(topology.clone(), &options).expect("displacement");
    let mut object = TriangleObject::new(context, surface, displacement, DAffine3::IDENTITY).expect("an object");
    let grey = TriangleChannel::of_color(topology, Vec4::new(0.5, 0.5, 0.5, 1.0), &options).expect("colours");
    object.set_paint(grey).expect("colours");
    object
}

/// A sticker of 20 pixels over two units, its lower left corner at (1, 1), moved by `by`.
fn recipe(object: &mut TriangleObject, mesh: &Mesh, ink: Ink, by: f64) -> Recipe {
    let triangles = object.triangles(&Context::serial(), mesh, 1).expect("triangles");
    let pin = |x: f64, y: f64| {
        let place = nearest(TriangleObject::mesh(&triangles), [0.1 * x + 1.0 + by, 0.1 * y + 1.0, 0.0]);
        let place = TriangleObject::kept(&triangles, place.expect("a place").0).expect("a place of the mesh");
        Pin { image: [x, y], place }
    };
    pinned_by(pin, 1, ink)
}

#[test]
fn a_decal_on_triangles_is_applied_closed_opened_and_updated_with_a_moved_pin() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.relievo");
    let (context, mesh, image) = (Context::serial(), mesh(), image());
    let mut object = object(&context, &mesh);
    let mut history = History::new(LIMIT);
    let mut document = Document::of_triangles(&mesh, "baseline").expect("a document");
    object.store(&context, &mut document).expect("layers");
    history.save(&path, &document).expect("a file");
    let plain = state(&object);
    let given = recipe(&mut object, &mesh, Ink::Color, 0.0);
    let mut ground = Ground { context: &context, object: &mut object, cage: &mesh, history: &mut history };
    let applied = ground.apply(given, "label", &image, &mut Silent).unwrap_or_else(|error| panic!("{error}"));
    assert!(applied.printed.texels > 500 && applied.printed.refused.is_empty() && applied.quality.flips == 0);
    let first = state(&object);
    assert_ne!(first, plain);
    drop(history);

    // Taken up by another program.
    let (document, mut history) = History::open(&path, LIMIT, LIMIT).expect("the document");
    let mut again = self::object(&context, &mesh);
    again.take_up(&context, &document, LIMIT).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(state(&again), first);
    let [(id, Ok(mut kept))] = <[_; 1]>::try_from(recipes(&history)).expect("one decal") else { panic!("sound") };
    kept.check_image(&image).expect("the image");
    // The faces under the decal are divided: their numbers are others than where it was applied, the places are not.
    let mut fresh = self::object(&context, &mesh);
    let there = recipe(&mut fresh, &mesh, Ink::Color, 0.5);
    let found = recipe(&mut again, &mesh, Ink::Color, 0.5).pins;
    for (a, b) in found.iter().zip(&there.pins) {
        let is_near = a.place.barycentric.iter().zip(b.place.barycentric).all(|(a, b)| (a - b).abs() < 1e-5);
        assert!(a.place.face == b.place.face && is_near, "{a:?} {b:?}");
    }
    kept.pins.clone_from(&there.pins);
    kept.seen.opacity = 0.25;
    let mut ground = Ground { context: &context, object: &mut again, cage: &mesh, history: &mut history };
    ground.update(id, kept, &image, &mut Silent).unwrap_or_else(|error| panic!("{error}"));
    let label = again.layers().into_iter().find(|layer| layer.name == "label").expect("its layer");
    assert_eq!(label.settings.opacity, 0.25);

    // As if it had been applied there at first.
    let mut other = History::new(LIMIT);
    let mut ground = Ground { context: &context, object: &mut fresh, cage: &mesh, history: &mut other };
    ground.apply(there, "label", &image, &mut Silent).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(texels(&again), texels(&fresh));

    // Undo brings back what was there, with its recipe.
    history.undo(&context, &mut again).expect("undone").expect("an edit");
    assert_eq!(state(&again), first);
    history.undo(&context, &mut again).expect("undone").expect("an edit");
    assert!(state(&again) == plain && recipes(&history).is_empty());
    history.redo(&context, &mut again).expect("made again").expect("an edit");
    history.redo(&context, &mut again).expect("made again").expect("an edit");
    assert_eq!(texels(&again), texels(&fresh));
    let mut ground = Ground { context: &context, object: &mut again, cage: &mesh, history: &mut history };
    ground.remove(id).expect("removed");
    assert!(state(&again) == plain && recipes(&history).is_empty());
}

#[test]
fn a_decal_stays_where_it_is_after_edits_divided_the_faces_below_it() {
    let (context, mesh, image) = (Context::serial(), mesh(), image());
    let mut object = object(&context, &mesh);
    let mut history = History::new(LIMIT);
    let label = recipe(&mut object, &mesh, Ink::Color, 0.0);
    let mut ground = Ground { context: &context, object: &mut object, cage: &mesh, history: &mut history };
    let id = ground.apply(label, "label", &image, &mut Silent).expect("applied").id;
    let painted = |object: &TriangleObject| {
        let label = object.layer("label").expect("its layer");
        let blocks = state(object).into_iter().filter(|(layer, ..)| *layer == label);
        without_layers(blocks.collect())
    };
    let before = painted(&object);
    // A relief that is too low to stretch the sticker divides other faces.
    let relief = recipe(&mut object, &mesh, Ink::Relief(1e-4), -0.8);
    let mut ground = Ground { context: &context, object: &mut object, cage: &mesh, history: &mut history };
    ground.apply(relief, "relief", &image, &mut Silent).expect("applied");
    let kept = recipes(&history).into_iter().find(|(other, _)| *other == id).expect("a decal").1.expect("it is sound");
    let mut ground = Ground { context: &context, object: &mut object, cage: &mesh, history: &mut history };
    let updated = ground.update(id, kept, &image, &mut Silent).expect("updated");
    assert!(updated.quality.triangles > 100, "the faces are divided: {:?}", updated.quality);
    let after = painted(&object);
    assert_eq!(before.len(), after.len());
    // Texels at the outline may change, where the triangles of the decal end elsewhere.
    let (mut all, mut changed) = (0, 0);
    for ((number, old), (other, new)) in before.iter().zip(&after) {
        assert_eq!((number, old.len()), (other, new.len()));
        all += old.len();
        changed += old.iter().zip(new).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    }
    assert!(20 * changed < all, "{changed} of {all} bytes changed");
}

#[test]
fn a_failed_update_on_triangles_changes_nothing_and_a_relief_is_laid_without_itself() {
    let (context, mesh, image) = (Context::serial(), mesh(), image());
    let mut object = object(&context, &mesh);
    let mut history = History::new(LIMIT);
    let given = recipe(&mut object, &mesh, Ink::Relief(0.3), 0.0);
    let mut ground = Ground { context: &context, object: &mut object, cage: &mesh, history: &mut history };
    let id = ground.apply(given.clone(), "relief", &image, &mut Silent).expect("applied").id;
    let before = state(&object);
    let mut twice = given.clone();
    twice.pins[1].place = twice.pins[0].place;
    let mut beyond = given.clone();
    beyond.pins[2].place = Place { face: 32, barycentric: [1.0, 0.0, 0.0] };
    let mut ground = Ground { context: &context, object: &mut object, cage: &mesh, history: &mut history };
    for (recipe, why) in [(twice, "same place"), (beyond, "pin 2: face 32 does not exist")] {
        let error = ground.update(id, recipe, &image, &mut Silent).expect_err("no place").to_string();
        assert!(error.contains(why), "{error}");
    }
    assert!(ground.update(7, given.clone(), &image, &mut Silent).is_err());
    assert_eq!(state(ground.object), before);
    // Written anew from the same recipe it is what it was.
    ground.update(id, given, &image, &mut Silent).expect("updated");
    assert_eq!(texels(&object), without_layers(before));
}
