//! `relievo doc` and what `relievo info` says of documents.

use crate::{CUBE, relievo, text};

#[test]
fn documents_are_looked_into_and_checked() {
    let folder = tempfile::tempdir().unwrap();
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/document-1.relievo");
    let path = folder.path().join("a.relievo");
    std::fs::copy(golden, &path).unwrap();
    let info = relievo(folder.path(), &["info", "a.relievo", "--json"]);
    let info: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    assert_eq!((&info["faces"], &info["tiles"], &info["version"]), (&3.into(), &9.into(), &1.into()));
    assert_eq!((&info["layers"][1]["name"], &info["layers"][1]["tiles"]), (&"colour".into(), &2.into()));
    let shown = text(&relievo(folder.path(), &["info", "a.relievo"]).stdout);
    assert!(shown.contains("layer `displacement`: scalar displacement, f16, tiles of 8 to 16, 2 of 9"), "{shown}");
    let check = relievo(folder.path(), &["doc", "check", "a.relievo"]);
    assert!(check.status.success() && text(&check.stdout).contains("no damage, 6 blocks of 3 layers"), "{check:?}");
    let mut bytes = std::fs::read(&path).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&path, &bytes).unwrap();
    let check = relievo(folder.path(), &["doc", "check", "a.relievo"]);
    assert_eq!(check.status.code(), Some(1));
    let told = text(&check.stdout);
    assert!(told.contains("a.relievo: layer `light`: tile 3 of face 1: the checksum"), "{told}");
    assert!(told.contains("1 parts are damaged, of 6 blocks"), "{told}");
    // Opening it says so as well.
    let info = relievo(folder.path(), &["info", "a.relievo"]);
    assert!(info.status.code() == Some(1) && text(&info.stderr).contains("relievo doc check"), "{info:?}");
    let repair = relievo(folder.path(), &["doc", "repair", "a.relievo"]);
    let told = text(&repair.stdout);
    assert!(told.contains("lost: layer `light`: tile 3") && told.contains("as it was: a.relievo.damaged"), "{told}");
    let shown = text(&relievo(folder.path(), &["info", "a.relievo"]).stdout);
    assert!(shown.contains("format version 5") && shown.contains("layer `light`: colour, RGBA16F, tiles of 8, 1 of 9"));
}

#[test]
fn a_document_goes_to_another_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/document-2.relievo");
    std::fs::copy(golden, folder.path().join("a.relievo")).unwrap();
    // The document's strip is 6 by 1; this one is half as long.
    let half = "v 0 0 0\nv 3 0 0\nv 3 1 0\nv 0 1 0\nf 1 2 3 4\n";
    std::fs::write(folder.path().join("half.obj"), half).unwrap();
    let moved = relievo(folder.path(), &["doc", "transfer", "a.relievo", "half.obj", "-o", "b.relievo"]);
    assert!(moved.status.success(), "{moved:?}");
    let told = text(&moved.stdout);
    assert!(told.contains("0.00 %) of the new surface") && told.contains("has no place on the new mesh"), "{told}");
    let info = text(&relievo(folder.path(), &["info", "b.relievo"]).stdout);
    assert!(info.contains("mesh: 1 faces") && info.contains("layer `first`"), "{info}");
}

#[test]
fn the_edits_of_a_document_are_checked_and_folded() {
    let folder = tempfile::tempdir().unwrap();
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/document-2.relievo");
    let bytes = std::fs::read(golden).unwrap();
    let path = folder.path().join("a.relievo");
    std::fs::write(&path, &bytes[..bytes.len() - 9]).unwrap();
    let check = relievo(folder.path(), &["doc", "check", "a.relievo"]);
    assert!(check.status.success(), "{check:?}");
    let told = text(&check.stdout);
    assert!(told.contains("an edit was under way when the document was left, and is not in it: edit 15"), "{told}");
    assert!(told.contains("no damage"), "{told}");
    let compact = relievo(folder.path(), &["doc", "compact", "a.relievo"]);
    let told = text(&compact.stdout);
    assert!(told.contains("edits are folded into its layers and can no longer be undone"), "{told}");
    assert!(std::fs::metadata(&path).unwrap().len() < bytes.len() as u64);
    let check = text(&relievo(folder.path(), &["doc", "check", "a.relievo"]).stdout);
    assert!(check.contains("no damage") && !check.contains("under way"), "{check}");
}

#[test]
fn edits_are_listed_undone_and_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/document-2.relievo");
    let path = folder.path().join("a.relievo");
    std::fs::copy(golden, &path).unwrap();
    let shown = |arguments: &[&str]| {
        let output = relievo(folder.path(), arguments);
        assert!(output.status.success(), "{arguments:?}: {output:?}");
        text(&output.stdout)
    };
    let list = || {
        let list: serde_json::Value = serde_json::from_str(&shown(&["doc", "log", "a.relievo", "--json"])).unwrap();
        let edits = list["edits"].as_array().unwrap().clone();
        edits.into_iter().map(|edit| (edit["done"] == true, edit["input"].as_str().unwrap().to_string())).collect()
    };
    let before: Vec<(bool, String)> = list();
    let done = before.iter().filter(|(done, _)| *done).count();
    assert!(done >= 2 && before.iter().all(|(_, input)| input.starts_with("edit ")), "{before:?}");
    let layers = || {
        let info: serde_json::Value = serde_json::from_str(&shown(&["info", "a.relievo", "--json"])).unwrap();
        info["layers"].clone()
    };
    let first = layers();
    assert!(shown(&["doc", "undo", "a.relievo", "--edits", "2"]).contains("2 edits are undone"));
    let after = list();
    assert_eq!(after.iter().filter(|(done, _)| *done).count(), done - 2);
    let inputs = |edits: &[(bool, String)]| edits.iter().map(|(_, input)| input.clone()).collect::<Vec<_>>();
    assert_eq!(inputs(&after), inputs(&before));
    assert_ne!(layers(), first);
    let log = shown(&["doc", "log", "a.relievo"]);
    assert!(log.contains(&format!("{}: undone, ", done - 1)), "{log}");
    assert!(shown(&["info", "a.relievo"]).contains(&format!("edits: {} can be undone", done - 2)));
    // More than there are: nothing changes.
    let refused = relievo(folder.path(), &["doc", "undo", "a.relievo", "--edits", "1000"]);
    assert!(!refused.status.success() && text(&refused.stderr).contains("1000 are asked for"), "{refused:?}");
    assert_eq!(list(), after);
    shown(&["doc", "redo", "a.relievo", "--edits", "2"]);
    assert_eq!((list(), layers()), (before, first));
    assert!(shown(&["doc", "check", "a.relievo"]).contains("no damage"));
}

#[test]
fn strokes_that_fold_the_surface_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cube.obj"), CUBE).unwrap();
    let stroke = |height: f64, more: &[&str]| {
        let list = format!(
            "version = 1\n[[strokes]]\nradius = 0.3\nsculpt = \"draw\"\nheight = {height}\n\
             [[strokes.points]]\nposition = [0, 0, 0.8]\n"
        );
        std::fs::write(folder.path().join("list.toml"), list).unwrap();
        let command = ["doc", "stroke", "cube.obj", "list.toml", "-o", "dent.obj"];
        let done = relievo(folder.path(), &[&command[..], more].concat());
        assert!(done.status.success(), "{done:?}");
        text(&done.stderr)
    };
    // The surface ends 0.8 below the dent.
    for (more, place) in [(&[][..], "tile"), (&["--triangles"], "face")] {
        let said = stroke(-2.0, more);
        let numbers: Vec<u64> = said.split(' ').filter_map(|word| word.trim_end_matches(';').parse().ok()).collect();
        let [folded, triangles, _] = numbers[..] else { panic!("{said}") };
        let told = format!("note: cube.obj is folded: its displacement turns {folded} of {triangles} triangles over");
        assert!(said.contains(&told) && said.contains(&format!("most of them on {place} ")), "{said}");
        assert!(0 < folded && folded <= triangles, "{said}");
        assert_eq!(stroke(-0.05, more), "");
    }
}
