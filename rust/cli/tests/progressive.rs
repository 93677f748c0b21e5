//! `relievo progressive edit` on a graphics device.

mod program;

use relievo_core::{Context, Mesh, Values};

use program::{build_bowl, relievo, text};

/// A bowl with normals.
fn bowl() -> String {
    let place = |index: u32| [f64::from(index % 31) / 15.0 - 1.0, f64::from(index / 31) / 15.0 - 1.0];
    let places = (0..961).map(place);
    let points = places.clone().map(|[x, y]| format!("v {x} {y} {}\n", 0.3 * (x * x + y * y)));
    let normals = places.map(|[x, y]| format!("vn {} {} 1\n", -0.6 * x, -0.6 * y));
    let square = |index: u32| {
        let at = index / 30 * 31 + index % 30 + 1;
        let [a, b, c, d] = [at, at + 1, at + 32, at + 31];
        format!("f {a}//{a} {b}//{b} {c}//{c} {d}//{d}\n")
    };
    points.chain(normals).chain((0..900).map(square)).collect()
}

#[test]
fn edits_of_a_list_are_made_on_a_device_as_on_the_processor() {
    if relievo_gpu::adapters().is_empty() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let run = |arguments: &[&str]| relievo(folder.path(), &[&["progressive"], arguments].concat());
    build_bowl(folder.path(), &bowl());
    let strokes = "version = 1\n[[strokes]]\nsculpt = \"draw\"\nheight = 0.3\n\
                   radius = 0.5\nfalloff = \"smooth\"\npoints = [{ position = [-0.4, 0, 0] }]\n";
    std::fs::write(path("strokes.toml"), strokes).unwrap();
    let edits = "[[edit]]\nfaces = 300\n[[edit.handle]]\ncenter = [0, 0, 0]\nradius = 0.8\n\
                 translation = [0, 0.1, 0.4]\naxis = [0, 0, 1]\nangle = 40\n\
                 [[edit]]\n[[edit.handle]]\ncenter = [0.5, 0, 0.25]\nradius = 0.4\ntranslation = [0, 0.3, 0]\n";
    let with_strokes = format!("{edits}[[edit]]\nfaces = 600\nstrokes = \"strokes.toml\"\n");
    std::fs::write(path("edits.toml"), edits).unwrap();
    std::fs::write(path("strokes_too.toml"), with_strokes).unwrap();
    let edit = |script: &str, device: &str, output: &str| {
        run(&["edit", "bowl.rlvpm", "--script", script, "--device", device, "-o", output])
    };
    let level = |file: &str, faces: &str| -> Mesh {
        assert!(run(&["export", file, "--faces", faces, "-o", "level.ply"]).status.success());
        relievo_meshio::read(&Context::serial(), &path("level.ply")).unwrap()
    };
    for script in ["edits.toml", "strokes_too.toml"] {
        let [cpu, gpu] = ["cpu", "gpu"].map(|device| edit(script, device, &format!("{device}.rlvpm")));
        assert!(cpu.status.success() && gpu.status.success(), "{cpu:?} {gpu:?}");
        // As many vertices were reached, and the same told of the order of splits.
        assert!(cpu.stdout == gpu.stdout && text(&gpu.stdout).starts_with("edit 1: "), "{cpu:?} {gpu:?}");
        let is_told = text(&gpu.stderr).contains("edit 3: strokes are made by the processor");
        assert_eq!(is_told, script == "strokes_too.toml", "{gpu:?}");
        assert!(!path("gpu.rlvpm.journal").exists());
        for (faces, most) in [("1800", 1e-5), ("700", 2e-3), ("100", 2e-3)] {
            let [cpu, gpu] = ["cpu.rlvpm", "gpu.rlvpm"].map(|file| level(file, faces));
            assert!(cpu.points.len() == gpu.points.len() && cpu.corners == gpu.corners);
            let worst =
                |one: &[f32], other: &[f32]| one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            let far = worst(cpu.points.as_flattened(), gpu.points.as_flattened());
            let values = [&cpu, &gpu].map(|mesh| &mesh.attribute("normal").unwrap().values);
            let [Values::F32(cpu), Values::F32(gpu)] = values else { panic!("normals are no numbers") };
            let turned = worst(cpu, gpu);
            assert!(cpu.len() == gpu.len() && far < most && turned < 20.0 * most, "{faces}: {far} {turned}");
        }
    }
    // A journal of the processor is not passed over.
    std::fs::write(path("other.rlvpm.journal"), "").unwrap();
    let refused = edit("edits.toml", "gpu", "other.rlvpm");
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("--device cpu"), "{refused:?}");
}
