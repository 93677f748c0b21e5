//! Sessions of models without a window: strokes along rays, edits that are undone, layers, and files.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use glam::DVec3;
use relievo_core::{Context, ContextOptions};
use relievo_detail::{PaintMode, SculptMode};
use relievo_document::{Document, Settings};
use relievo_render::{Image, write_png};
use relievo_view::model::{Held, Opening, Session, SurfaceKind, Tool};

/// A square of 4 × 4 quads from −2 to 2 in the plane z = 0.
fn square(folder: &Path) -> PathBuf {
    let mut text = String::new();
    for at in 0..25 {
        writeln!(text, "v {} {} 0", at % 5 - 2, at / 5 - 2).unwrap();
    }
    for at in 0..16 {
        let first = 1 + at % 4 + 5 * (at / 4);
        writeln!(text, "f {} {} {} {}", first, first + 1, first + 6, first + 5).unwrap();
    }
    let path = folder.join("square.obj");
    std::fs::write(&path, text).unwrap();
    path
}

fn open(file: &Path, kind: Option<SurfaceKind>) -> Session {
    let context = Context::new(&ContextOptions::default()).unwrap();
    Session::open(context, &Opening { file: file.to_owned(), mesh: None, kind, cells: Some(16) }).unwrap()
}

fn down(x: f64, y: f64) -> (DVec3, DVec3) {
    (DVec3::new(x, y, 9.0), DVec3::NEG_Z)
}

/// How high the surface is over a place.
fn height(session: &mut Session, x: f64, y: f64) -> f64 {
    session.pick(down(x, y)).unwrap().unwrap().point.z
}

fn stroke(session: &mut Session, held: Held, places: &[(f64, f64)]) {
    session.begin_stroke(held).unwrap();
    for (x, y) in places {
        session.extend_stroke(&[(down(*x, *y), 1.0)]).unwrap();
    }
    session.end_stroke().unwrap();
}

#[test]
fn a_dab_is_as_high_as_the_brush_says_on_either_kind_of_surface() {
    for kind in [SurfaceKind::Surface, SurfaceKind::Triangles] {
        let folder = tempfile::tempdir().unwrap();
        let mut session = open(&square(folder.path()), Some(kind));
        assert_eq!(session.face_count(), 16);
        let before = height(&mut session, -0.9, 0.1);
        let brush = &mut session.brush;
        (brush.radius, brush.height, brush.strength, brush.symmetry) = (0.8, 0.25, 1.0, true);
        stroke(&mut session, Held::default(), &[(1.0, 0.0)]);
        // The height is 0.25 of the radius; the mirror image is as high, and beyond the radius nothing rises.
        for x in [1.0, -1.0] {
            assert!((height(&mut session, x, 0.0) - 0.2).abs() < 0.01, "{kind:?}: {}", height(&mut session, x, 0.0));
            assert!(height(&mut session, x, 1.2).abs() < 1e-6, "{kind:?}");
        }
        session.brush.symmetry = false;
        stroke(&mut session, Held { inverts: true, ..Held::default() }, &[(1.0, 0.0)]);
        assert!(height(&mut session, 1.0, 0.0).abs() < 0.01 && height(&mut session, -1.0, 0.0) > 0.19, "{kind:?}");
        let peak = height(&mut session, -1.0, 0.0);
        stroke(&mut session, Held { smooths: true, ..Held::default() }, &[(-1.0, 0.0); 1]);
        assert!(height(&mut session, -1.0, 0.0) < peak, "{kind:?}");
        // All of it goes to the bit, and comes back.
        let after = height(&mut session, -0.9, 0.1);
        let (labels, done) = session.edits();
        assert_eq!((labels, done), (&["draw", "draw, inverted", "smooth"].map(String::from)[..], 3));
        session.go_to(0).unwrap();
        assert_eq!(height(&mut session, -0.9, 0.1), before);
        session.go_to(3).unwrap();
        assert_eq!(height(&mut session, -0.9, 0.1), after);
        // A stroke that is taken back, and one beside the surface, are no edits.
        session.begin_stroke(Held::default()).unwrap();
        session.extend_stroke(&[(down(0.5, 0.5), 1.0)]).unwrap();
        session.cancel_stroke().unwrap();
        stroke(&mut session, Held::default(), &[(5.0, 5.0)]);
        assert_eq!((height(&mut session, -0.9, 0.1), session.edits().1), (after, 3));
        // Edits on another branch replace the edits that are undone.
        session.undo().unwrap();
        session.brush.tool = Tool::Sculpt(SculptMode::Flatten);
        stroke(&mut session, Held::default(), &[(-1.0, 0.0), (-0.6, 0.1), (-0.2, 0.2)]);
        assert_eq!(session.edits().0.last().map(String::as_str), Some("flatten"));
        assert!(session.costs.last().is_some());
    }
}

#[test]
fn a_tool_sinks_by_the_strength_of_the_brush_and_leaves_its_track() {
    for kind in [SurfaceKind::Surface, SurfaceKind::Triangles] {
        let folder = tempfile::tempdir().unwrap();
        let mut session = open(&square(folder.path()), Some(kind));
        assert!(session.begin_press(down(0.0, 0.0), 1.0).is_err(), "there is no tool yet");
        let cube = folder.path().join("cube.obj");
        let corners: String = (0..8).map(|at| format!("v {} {} {}\n", at & 1, at >> 1 & 1, at >> 2 & 1)).collect();
        std::fs::write(&cube, corners + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n").unwrap();
        session.open_tool(&cube).unwrap();
        assert_eq!(session.tool(), Some("cube"));
        (session.brush.radius, session.brush.strength) = (0.8, 0.5);
        // The tool has edges of 2 · 0.8 / √3 and sinks by half of 0.8, by half of that at first. Until its rear edge has gone over
        // the place where it began it is deeper by 0.2 of half an edge.
        assert!(session.begin_press(down(-0.5, 0.0), 0.5).unwrap() && session.is_drawing());
        session.press_to(down(0.5, 0.0), 1.0).unwrap();
        session.end_press().unwrap();
        for (x, depth) in [(0.5, 0.4), (-0.5, 0.2 + 0.2 * 0.46)] {
            let found = height(&mut session, x, 0.0);
            assert!((found + depth).abs() < 0.05, "{kind:?}: {found} at {x}, not {}", -depth);
        }
        assert!((-0.42..-0.3).contains(&height(&mut session, 0.0, 0.0)), "{kind:?}");
        assert!(height(&mut session, 0.5, 0.8).abs() < 1e-6, "{kind:?}");
        assert_eq!(session.edits(), (&["press cube".to_owned()][..], 1));
        // What is taken back, and what misses, is no edit.
        assert!(session.begin_press(down(1.0, 1.0), 1.0).unwrap());
        session.cancel_stroke().unwrap();
        assert!(!session.begin_press(down(9.0, 0.0), 1.0).unwrap() && !session.is_drawing());
        assert!(height(&mut session, 1.0, 1.0).abs() < 1e-6 && session.edits().1 == 1, "{kind:?}");
        session.undo().unwrap();
        assert!(height(&mut session, 0.5, 0.0).abs() < 1e-6, "{kind:?}");
    }
}

#[test]
fn layers_are_hidden_renamed_added_and_removed_as_edits() {
    let folder = tempfile::tempdir().unwrap();
    let mut session = open(&square(folder.path()), None);
    (session.brush.radius, session.brush.strength) = (0.8, 1.0);
    stroke(&mut session, Held::default(), &[(0.0, 0.0)]);
    let low = height(&mut session, 0.0, 0.0);
    session.add_layer(false).unwrap();
    stroke(&mut session, Held::default(), &[(0.0, 0.0)]);
    let both = height(&mut session, 0.0, 0.0);
    assert!(low > 0.1 && (both - 2.0 * low).abs() < 0.01, "{low} {both}");
    let relief = |session: &Session| session.layers().into_iter().rfind(|layer| !layer.kind.is_color()).unwrap();
    let layer = relief(&session);
    assert!(layer.name == "relief 1" && layer.active);
    session.set_layer(&layer, Settings { visible: false, ..layer.settings }).unwrap();
    assert!((height(&mut session, 0.0, 0.0) - low).abs() < 1e-3);
    let layer = relief(&session);
    session.set_layer(&layer, Settings { visible: true, opacity: 0.5, ..layer.settings }).unwrap();
    assert!((height(&mut session, 0.0, 0.0) - 1.5 * low).abs() < 0.01);
    session.rename_layer(&layer, "scales").unwrap();
    let layer = relief(&session);
    assert_eq!(layer.name, "scales");
    session.remove_layer(&layer).unwrap();
    assert!((height(&mut session, 0.0, 0.0) - low).abs() < 1e-3);
    session.undo().unwrap();
    assert_eq!(relief(&session).name, "scales");
    // The last of a kind stays, and nothing is recorded.
    let done = session.edits().1;
    let color = session.layers().into_iter().find(|layer| layer.kind.is_color()).unwrap();
    assert!(session.remove_layer(&color).is_err());
    assert_eq!(session.edits().1, done);
}

#[test]
fn what_is_not_saved_is_kept_and_taken_up_again() {
    let folder = tempfile::tempdir().unwrap();
    let file = square(folder.path());
    let kept = folder.path().join("square.autosave.relievo");
    let mut session = open(&file, None);
    assert!(!session.is_unsaved() && session.recoverable().is_none());
    session.brush.tool = Tool::Paint(PaintMode::Mix);
    stroke(&mut session, Held::default(), &[(0.0, 0.0), (1.0, 0.5)]);
    assert!(session.is_unsaved() && kept.is_file());
    // The session ends as a killed program does.
    drop(session);
    let mut session = open(&file, None);
    assert_eq!(session.recoverable(), Some(kept.as_path()));
    session.recover().unwrap();
    assert!(session.is_unsaved() && session.recoverable().is_none() && session.edits().1 == 1);
    let wrong = session.save_as(&folder.path().join("square.obj")).unwrap_err();
    assert!(wrong.to_string().contains(".relievo"), "{wrong}");
    let saved = session.save().unwrap();
    assert!(saved == folder.path().join("square.relievo") && !kept.exists() && !session.is_unsaved());
    // Later edits go there as they are made, and the document can be opened with its mesh beside it.
    stroke(&mut session, Held::default(), &[(-1.0, -1.0)]);
    drop(session);
    let mut session = open(&saved, None);
    assert_eq!(session.edits().1, 2);
    let painted = |session: &Session| session.layers().iter().find(|layer| layer.kind.is_color()).unwrap().tiles;
    let count = painted(&session);
    session.go_to(0).unwrap();
    assert!(count > 0 && painted(&session) == 0);
    drop(session);
    assert!(Document::open(&saved, 1 << 30).is_ok());
    // What is thrown away is not offered again.
    let mut session = open(&file, None);
    stroke(&mut session, Held::default(), &[(0.0, 0.0)]);
    assert!(kept.is_file());
    session.discard();
    assert!(!kept.exists());
}

#[test]
fn an_image_is_laid_its_pins_are_dragged_and_it_is_written_as_one_edit() {
    for kind in [SurfaceKind::Surface, SurfaceKind::Triangles] {
        let folder = tempfile::tempdir().unwrap();
        let mut session = open(&square(folder.path()), Some(kind));
        let at = |session: &mut Session, x: f64, y: f64| session.pick(down(x, y)).unwrap().unwrap();
        let file = folder.path().join("flag.png");
        write_png(&file, &Image::from_data(16, 16, 3, vec![0.25; 768]).unwrap()).unwrap();
        session.brush.radius = 0.5;
        let first = at(&mut session, 0.1, 0.2);
        assert!(session.add_pin(&first, DVec3::Y).unwrap_err().to_string().contains("no image"));
        session.open_decal(&file).unwrap();
        assert_eq!(session.add_pin(&first, DVec3::Y).unwrap(), 0);
        let quality = *session.decal().unwrap().quality().unwrap();
        assert!(quality.flips == 0 && quality.l2 < 1.001 && quality.coverage > 0.999, "{quality:?}");
        // The image is as wide as the brush: 0.6 to the right of its middle there is nothing to put a pin on.
        let beside = at(&mut session, 0.7, 0.2);
        assert!(session.add_pin(&beside, DVec3::Y).unwrap_err().to_string().contains("does not lie there"));
        assert!(session.decal().unwrap().fault().is_some() && session.decal().unwrap().pins().len() == 1);
        let second = at(&mut session, 0.4, 0.5);
        assert_eq!(session.add_pin(&second, DVec3::Y).unwrap(), 1);
        let place = |session: &Session| session.decal().unwrap().pins()[1].0;
        for step in 1..=4 {
            let picked = at(&mut session, 0.4 + 0.05 * f64::from(step), 0.5);
            session.drag_pin(1, &picked).unwrap();
            assert!(place(&session).distance(picked.point) < 1e-5, "{step}");
        }
        session.end_pin().unwrap();
        let moved = DVec3::new(0.6, 0.5, 0.0);
        let quality = *session.decal().unwrap().quality().unwrap();
        assert!(place(&session).distance(moved) < 1e-5 && quality.flips == 0, "{quality:?}");
        // Far beyond the image the pin takes it along; what was dragged goes back to where it was.
        let far = at(&mut session, 1.2, 1.3);
        session.drag_pin(1, &far).unwrap();
        assert!(place(&session).distance(far.point) < 1e-5);
        session.cancel_pin().unwrap();
        assert!(place(&session).distance(moved) < 1e-5);
        session.remove_pin(1).unwrap();
        assert!(session.remove_pin(1).is_err() && session.decal().unwrap().pins().len() == 1);
        let painted = |session: &mut Session| {
            let document = session.to_document().unwrap();
            document.layers().iter().any(|layer| layer.kind().is_color() && !layer.blocks().is_empty())
        };
        assert!(!painted(&mut session));
        session.write_decal().unwrap();
        assert!(session.edits() == (&["decal flag.png".to_owned()][..], 1) && !session.is_laid());
        assert!(painted(&mut session) && session.write_decal().is_err());
        session.undo().unwrap();
        assert!(!painted(&mut session));
        // A damaged image is refused, and the one before stays.
        let bytes = std::fs::read(&file).unwrap();
        std::fs::write(&file, &bytes[..40]).unwrap();
        assert!(session.open_decal(&file).is_err() && session.open_stamp(&file).is_err());
        assert!(session.decal().unwrap().name() == "flag.png" && session.brush.stamp.is_none());
        // An image that is laid follows the surface when this is raised under it.
        session.add_pin(&first, DVec3::Y).unwrap();
        (session.brush.height, session.brush.strength) = (0.25, 1.0);
        stroke(&mut session, Held::default(), &[(0.1, 0.2)]);
        let raised = at(&mut session, 0.1, 0.2);
        session.write_decal().unwrap();
        assert!(raised.point.z > 0.1 && painted(&mut session));
    }
}
