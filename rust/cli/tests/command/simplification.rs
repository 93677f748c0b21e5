//! `relievo mesh simplify`.

use crate::{relievo, text};

/// A bowl of 400 squares.
pub fn bowl() -> String {
    let bowl = |index: u32| {
        let (x, y) = (index % 21, index / 21);
        let (x, y) = (f64::from(x) / 10.0 - 1.0, f64::from(y) / 10.0 - 1.0);
        format!("v {x} {y} {}\n", 0.3 * (x * x + y * y))
    };
    let square = |index: u32| {
        let at = index / 20 * 21 + index % 20 + 1;
        format!("f {at} {} {} {}\n", at + 1, at + 22, at + 21)
    };
    (0..441).map(bowl).chain((0..400).map(square)).collect()
}

#[test]
fn a_mesh_is_simplified_to_a_share_a_number_or_a_deviation() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bowl.obj"), bowl()).unwrap();
    let simplify = |goal: &[&str]| {
        relievo(folder.path(), &[&["mesh", "simplify", "bowl.obj", "-o", "less.ply"][..], goal].concat())
    };
    let faces = || {
        let info = relievo(folder.path(), &["info", "--json", "less.ply"]);
        let found: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
        found["faces"].as_u64().unwrap()
    };
    let done = simplify(&["--ratio", "0.25"]);
    assert!(done.status.success() && text(&done.stdout).starts_with("800 triangles, "), "{done:?}");
    assert!((199..=200).contains(&faces()), "{}", faces());
    assert!(simplify(&["--faces", "100", "--threads", "1"]).status.success());
    assert!((99..=100).contains(&faces()), "{}", faces());
    assert!(simplify(&["--error", "0.02"]).status.success());
    assert!((8..100).contains(&faces()), "{}", faces());
    assert_eq!(simplify(&[]).status.code(), Some(2));
    let refused = simplify(&["--ratio", "1.5"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("use 0 to 1"), "{refused:?}");
}

#[test]
fn a_deviation_is_a_bound_or_called_an_estimate() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bowl.obj"), bowl()).unwrap();
    let mesh = |name: &str| {
        let mesh = relievo_meshio::read(&relievo_core::Context::serial(), &folder.path().join(name)).unwrap();
        let triangles = mesh.triangles();
        (mesh.points, triangles)
    };
    let simplify = |goal: &[&str]| {
        let done = relievo(folder.path(), &[&["mesh", "simplify", "bowl.obj", "-o", "less.ply"][..], goal].concat());
        assert!(done.status.success(), "{done:?}");
        let said = text(&done.stdout).trim().to_owned();
        let (rest, number) = said.rsplit_once(' ').unwrap();
        let (before, less) = (mesh("bowl.obj"), mesh("less.ply"));
        let both = [&before, &less].map(|(points, triangles)| (&points[..], &triangles[..]));
        let context = relievo_core::Context::serial();
        let apart = relievo_lod::distance(&context, both, &mut relievo_core::progress::Silent).unwrap();
        (rest.to_owned(), number.parse::<f32>().unwrap(), apart, less.1.len())
    };
    let (said, number, apart, faces) = simplify(&["--error", "0.02"]);
    assert!(said.ends_with("distance at most") && number <= 0.02 && apart.at_least <= number, "{said} {number}");
    // The diagonal of the bowl is √8.36.
    let (_, same, _, relative) = simplify(&["--error-relative", "0.0069171"]);
    assert!(relative == faces && same == number, "{relative} {faces}");
    let (said, number, ..) = simplify(&["--error-estimate", "0.02"]);
    assert!(said.ends_with("estimated deviation") && number <= 0.02, "{said} {number}");
    let (.., locked) = simplify(&["--error", "0.02", "--lock-border"]);
    assert!(locked > faces, "{locked} {faces}");
    let refused = relievo(folder.path(), &["mesh", "simplify", "bowl.obj", "-o", "less.ply", "--error-relative=-1"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("--error-relative"), "{refused:?}");
}

#[test]
fn several_goals_make_as_many_files() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bowl.obj"), bowl()).unwrap();
    let simplify = |goal: &[&str]| {
        relievo(folder.path(), &[&["mesh", "simplify", "bowl.obj", "-o", "less.ply"][..], goal].concat())
    };
    let faces = |name: &str| {
        let mesh = relievo_meshio::read(&relievo_core::Context::serial(), &folder.path().join(name)).unwrap();
        mesh.face_count()
    };
    let done = simplify(&["--ratio", "0.5,0.25,0.1"]);
    assert!(done.status.success() && text(&done.stdout).starts_with("less-1.ply: 800 triangles, "), "{done:?}");
    assert_eq!(text(&done.stdout).lines().count(), 3);
    for (name, most) in [("less-1.ply", 400), ("less-2.ply", 200), ("less-3.ply", 80)] {
        assert!((most - 1..=most).contains(&faces(name)), "{name}: {}", faces(name));
    }
    assert!(!folder.path().join("less.ply").exists());
    // A level is as it would be alone, and one value is for all levels.
    assert!(simplify(&["--ratio", "0.25"]).status.success());
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(bytes("less.ply"), bytes("less-2.ply"));
    let done = simplify(&["--error-relative", "0.02,0.001", "--faces", "30"]);
    assert!(done.status.success() && faces("less-1.ply") < faces("less-2.ply"), "{done:?}");
    let refused = simplify(&["--error", "0.02,0.01", "--faces", "400,200,100"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("--error"), "{refused:?}");
}

#[test]
fn an_exported_level_is_within_the_bound() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bowl.obj"), bowl()).unwrap();
    let run = |arguments: &[&str]| relievo(folder.path(), &[&["progressive"], arguments].concat());
    assert!(run(&["build", "bowl.obj", "-o", "bowl.rlvpm", "--faces", "20"]).status.success());
    let number = |said: &str, after: &str| said.split(after).nth(1).and_then(|it| it.trim().parse::<f32>().ok());
    let done = run(&["export", "bowl.rlvpm", "-o", "level.ply", "--error", "0.02"]);
    assert!(done.status.success(), "{done:?}");
    assert!(number(&text(&done.stdout), "distance at most ").is_some_and(|it| it <= 0.02), "{done:?}");
    assert!(run(&["export", "bowl.rlvpm", "-o", "level.ply", "--error-estimate", "0.02"]).status.success());
    let both = run(&["export", "bowl.rlvpm", "-o", "level.ply", "--error", "0.02", "--faces", "3"]);
    assert_eq!(both.status.code(), Some(2));
}

/// The bowl with texture coordinates: columns 0 to 10 are on the left half of the texture, 10 to 20 on the right half, and
/// both have column 10.
pub fn map() -> String {
    let place = |index: u32| [index % 21, index / 21].map(|it| f64::from(it) / 20.0);
    let coordinates = |shift: f64| (0..441).map(place).map(move |[x, y]| format!("vt {} {y}\n", 0.4 * x + shift));
    let square = |index: u32| {
        let (column, at) = (index % 20, index / 20 * 21 + index % 20 + 1);
        let corner = |at: u32| format!("{at}/{}", if column < 10 { at } else { at + 441 });
        format!("f {} {} {} {}\n", corner(at), corner(at + 1), corner(at + 22), corner(at + 21))
    };
    let points = bowl().lines().filter(|line| line.starts_with('v')).fold(String::new(), |all, line| all + line + "\n");
    let coordinates: String = coordinates(0.0).chain(coordinates(0.5)).collect();
    let faces: String = (0..400).map(square).collect();
    points + &coordinates + &faces
}

/// Checks the texture coordinates of a bowl with fewer triangles, each within tolerances. Returns how many corners it has.
pub fn corners_of_map(less: &str, [most_u, most_v]: [f64; 2]) -> usize {
    let numbers = |keyword: &str| -> Vec<Vec<f64>> {
        let lines = less.lines().filter_map(|line| line.strip_prefix(keyword));
        lines.map(|line| line.split(' ').map(|number| number.parse().unwrap()).collect()).collect()
    };
    let (points, coordinates) = (numbers("v "), numbers("vt "));
    let (mut corners, mut at_seam) = (0, std::collections::HashSet::new());
    for corner in less.lines().filter_map(|line| line.strip_prefix("f ")).flat_map(|line| line.split(' ')) {
        let (point, value) = corner.split_once('/').unwrap();
        let [point, value] = [point, value].map(|number| number.parse::<usize>().unwrap() - 1);
        let (x, y) = ((points[point][0] + 1.0) / 2.0, (points[point][1] + 1.0) / 2.0);
        let [u, v] = [coordinates[value][0], coordinates[value][1]];
        let shift = if u > 0.45 { 0.5 } else { 0.0 };
        assert!((u - shift - 0.4 * x).abs() < most_u && (v - y).abs() < most_v, "{x} {y}: {u} {v}");
        if (x - 0.5).abs() < 1e-3 {
            at_seam.insert((point, shift > 0.0));
        }
        corners += 1;
    }
    assert!(at_seam.len() >= 4 && at_seam.iter().all(|(point, side)| at_seam.contains(&(*point, !side))));
    corners
}

#[test]
fn a_simplified_mesh_keeps_its_texture_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("map.obj"), map()).unwrap();
    let simplify = |more: &[&str]| {
        relievo(
            folder.path(),
            &[&["mesh", "simplify", "map.obj", "-o", "less.obj", "--faces", "200"][..], more].concat(),
        )
    };
    let done = simplify(&["--weight", "uv=0.05"]);
    assert!(done.status.success() && done.stderr.is_empty(), "{done:?}");
    let less = std::fs::read_to_string(folder.path().join("less.obj")).unwrap();
    let corners = corners_of_map(&less, [0.01, 0.02]);
    assert!((597..=600).contains(&corners), "{corners}");
    assert!(simplify(&["--without", "uv"]).status.success());
    assert!(!std::fs::read_to_string(folder.path().join("less.obj")).unwrap().contains("vt "));
    assert!(text(&simplify(&["--weight", "paint=1"]).stderr).contains("no attribute `paint`"));
}

/// Writes a strip of six triangles with a skin of one joint, an animation, a morph target, two textures and names, as
/// `strip.gltf` and `strip.bin`.
fn strip(folder: &std::path::Path) {
    let points: Vec<f32> = (0..8u8).flat_map(|at| [f32::from(at / 2), f32::from(at % 2), 0.0]).collect();
    let corners = (0..3u16).flat_map(|at| [0, 2, 3, 0, 3, 1].map(|corner| 2 * at + corner));
    let floats = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let weights = [1.0, 0.0, 0.0, 0.0].repeat(8);
    let chunks = [
        (5126, 8, "VEC3", floats(&points)),
        (5123, 18, "SCALAR", corners.flat_map(u16::to_le_bytes).collect()),
        (5121, 8, "VEC4", vec![0; 32]),
        (5126, 8, "VEC4", floats(&weights)),
        (5126, 8, "VEC3", vec![0; 96]),
        (5126, 1, "SCALAR", vec![0; 4]),
        (5126, 1, "VEC3", vec![0; 12]),
    ];
    let (mut bytes, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    for (view, (component, count, kind, chunk)) in chunks.into_iter().enumerate() {
        views.push(serde_json::json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": chunk.len() }));
        let mut accessor =
            serde_json::json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        if matches!(view, 0 | 4) {
            accessor["min"] = serde_json::json!([0.0, 0.0, 0.0]);
            accessor["max"] = serde_json::json!([3.0, 1.0, 0.0]);
        }
        if view == 5 {
            accessor["min"] = serde_json::json!([0.0]);
            accessor["max"] = serde_json::json!([0.0]);
        }
        accessors.push(accessor);
        bytes.extend(chunk);
    }
    let strip = serde_json::json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "uri": "strip.bin", "byteLength": bytes.len() }],
        "bufferViews": views,
        "accessors": accessors,
        "images": [{ "uri": "paint.png" }],
        "textures": [{ "source": 0 }, { "source": 0 }],
        "materials": [{ "name": "skin", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
        "meshes": [{ "name": "strip", "primitives": [{
            "attributes": { "POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3 },
            "indices": 1, "material": 0, "targets": [{ "POSITION": 4 }],
        }] }],
        "nodes": [{ "name": "joint" }, { "name": "shown", "mesh": 0, "skin": 0 }],
        "scenes": [{ "nodes": [0, 1] }],
        "skins": [{ "joints": [0] }],
        "animations": [{
            "name": "walk",
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
            "samplers": [{ "input": 5, "output": 6 }],
        }],
    });
    std::fs::write(folder.join("strip.gltf"), strip.to_string()).unwrap();
    std::fs::write(folder.join("strip.bin"), bytes).unwrap();
}

#[test]
fn what_a_gltf_file_has_around_its_meshes_is_noted() {
    let folder = tempfile::tempdir().unwrap();
    strip(folder.path());
    let simplify = |from: &str, to: &str| {
        let done = relievo(folder.path(), &["mesh", "simplify", from, "-o", to, "--ratio", "0.5"]);
        assert!(done.status.success(), "{done:?}");
        text(&done.stderr)
    };
    let said = simplify("strip.gltf", "less.glb");
    let parts = ["1 skin is", "1 animation is", "1 morph target is", "2 nodes are", "1 mesh name is"];
    for part in parts.into_iter().chain(["1 material name is", "2 textures are"]) {
        assert!(said.contains(&format!("note: {part} left out\n")), "{part}: {said}");
    }
    // The binary file that was written has the name of its mesh alone.
    let said = simplify("less.glb", "least.glb");
    assert!(said.contains("note: 1 mesh name is left out\n"), "{said}");
    assert!(["skin", "animation", "texture", "target"].iter().all(|part| !said.contains(part)), "{said}");
}
