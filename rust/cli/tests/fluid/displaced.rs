//! Displaced surfaces among the shapes of descriptions, and files that meshes name.

use std::path::Path;

use relievo_ptex::{Borders, DataType, Face, Format, MeshType, Writer};

use crate::{DAM, relievo, text};

/// A floor of four faces along x, from -0.2 to 1.2, wider than the basin.
fn floor(folder: &Path) {
    let points = (0..10).map(|at| format!("v {} {} 0\n", 0.35 * (at / 2) as f32 - 0.2, 1.2 * (at % 2) as f32 - 0.3));
    let faces = (0..4).map(|face| 2 * face).map(|at| format!("f {} {} {} {}\n", at + 1, at + 3, at + 4, at + 2));
    std::fs::write(folder.join("floor.obj"), points.chain(faces).collect::<String>()).unwrap();
}

/// A document of the floor with heights of its faces.
fn bumps(folder: &Path, heights: [f32; 4]) {
    let format = Format { mesh: MeshType::Quad, data_type: DataType::F16, channels: 1, alpha: None };
    let mut writer = Writer::new(format, Borders::default(), 4).unwrap();
    for (face, height) in (0..).zip(heights) {
        writer.set_constant(face, &Face::new(4, 4), &DataType::F16.encode(&[height])).unwrap();
    }
    writer.write(&folder.join("bumps.ptx")).unwrap();
    let done = relievo(folder, &["doc", "import", "bumps.ptx", "floor.obj", "-o", "bumps.relievo"]);
    assert!(done.status.success(), "{done:?}");
}

#[test]
fn fluid_rests_on_displaced_surfaces_and_not_on_their_meshes() {
    let folder = tempfile::tempdir().unwrap();
    floor(folder.path());
    bumps(folder.path(), [0.0, 0.0, 0.15, 0.15]);
    let sim = |mesh: &str, frames: u32| {
        let text = DAM.split("[[block]]").next().unwrap().replace("frames = 3", &format!("frames = {frames}"))
            + "[[fill]]\nbox = { low = [0, 0, 0.2], high = [1, 0.3, 0.4] }\n[[collider]]\nmesh = "
            + mesh;
        std::fs::write(folder.path().join("dam.toml"), text).unwrap();
        relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames", "--format", "cache"])
    };
    // The least height of particles left of a place and right of one.
    let lowest = |mesh: &str| {
        std::fs::remove_dir_all(folder.path().join("frames")).unwrap_or_default();
        let done = sim(mesh, 30);
        assert!(done.status.success(), "{done:?}");
        let ply = ["fluid", "convert", "frames/0030.rlvfluid", "rest.ply"];
        assert!(relievo(folder.path(), &ply).status.success());
        let context = relievo_core::Context::serial();
        let points = relievo_particleio::read(&context, &folder.path().join("rest.ply")).unwrap().particles.points;
        let least = |is_there: fn(f32) -> bool| {
            points.iter().filter(|at| is_there(at[0])).map(|at| at[2]).fold(f32::INFINITY, f32::min)
        };
        [least(|x| x < 0.3), least(|x| x > 0.7)]
    };
    let [left, right] = lowest("\"floor.obj\"\n");
    assert!(left < 0.08 && right < 0.08, "{left} {right}");
    let displaced = "{ file = \"floor.obj\", document = \"bumps.relievo\", cells = 4 }\n";
    let [left, right] = lowest(displaced);
    // Nothing is below the faces that are 15 cm higher.
    assert!(left < 0.08 && (0.15..0.22).contains(&right), "{left} {right}");
    let refused = |mesh: &str, why: &str| {
        let done = sim(mesh, 31);
        assert!(done.status.code() == Some(1) && text(&done.stderr).contains(why), "{why}: {done:?}");
    };
    refused(&displaced.replace("cells = 4", "cells = 3"), "cells");
    refused(&displaced.replace("cells = 4", "layer = \"bark\""), "no layer `bark`");
    refused(&displaced.replace("cells = 4", "level = 4"), "level");
    refused(&displaced.replace("bumps.relievo", "none.relievo"), "none.relievo");
    refused("{ file = \"floor.obj\" }\n", "document");
    refused("4\n", "a file, or { file");
    bumps(folder.path(), [0.0, 0.0, 0.15, 0.1]);
    refused(displaced, "made with another bumps.relievo");
    bumps(folder.path(), [0.0, 0.0, 0.15, 0.15]);
    assert!(sim(displaced, 31).status.success());
}

/// A tetrahedron whose points are in a file of their own.
fn tetrahedron(folder: &Path, top: f32) {
    let points = [[0.5, 0.1, 0.0], [0.7, 0.1, 0.0], [0.6, 0.25, 0.0], [0.6, 0.15, top]];
    let corners: [u32; 12] = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];
    let bytes: Vec<u8> = points.iter().flatten().flat_map(|value: &f32| value.to_le_bytes()).collect();
    let bytes = [bytes, corners.iter().flat_map(|corner| corner.to_le_bytes()).collect()].concat();
    std::fs::write(folder.join("points.bin"), bytes).unwrap();
    let gltf = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},
        {"bufferView":1,"componentType":5125,"count":12,"type":"SCALAR"}],
        "bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":48}],
        "buffers":[{"byteLength":96,"uri":"points.bin"}]}"#;
    std::fs::write(folder.join("rock.gltf"), gltf).unwrap();
}

#[test]
fn runs_do_not_go_on_where_files_that_meshes_name_have_changed() {
    let folder = tempfile::tempdir().unwrap();
    let sim = |frames: u32| {
        let text = DAM.replace("frames = 3", &format!("frames = {frames}"))
            + "[[collider]]\nmesh = \"rock.gltf\"\ncontact = \"stop\"\n";
        std::fs::write(folder.path().join("dam.toml"), text).unwrap();
        relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames", "--format", "cache"])
    };
    tetrahedron(folder.path(), 0.2);
    let done = sim(1);
    assert!(done.status.success(), "{done:?}");
    tetrahedron(folder.path(), 0.21);
    let refused = sim(2);
    let why = "made with another rock.gltf";
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains(why), "{refused:?}");
    tetrahedron(folder.path(), 0.2);
    // What is no part of the shape may change.
    let gltf = std::fs::read_to_string(folder.path().join("rock.gltf")).unwrap();
    std::fs::write(folder.path().join("rock.gltf"), gltf.replace("\"asset\"", "\"extras\":{\"note\":1},\"asset\""))
        .unwrap();
    let done = sim(2);
    assert!(done.status.success() && text(&done.stderr).contains("goes on"), "{done:?}");
}
