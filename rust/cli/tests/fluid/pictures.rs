//! Pictures of fluids, alone and in scenes, what of their particles they need, and plots.

use crate::{DAM, relievo, text};

#[test]
fn fluids_are_rendered_directly_and_as_meshes_alike() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dam.toml"), DAM).unwrap();
    assert!(relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames"]).status.success());
    let render = |name: &str, more: &[&str]| {
        let first = ["fluid", "render", "frames/0000.rlvfluid", "frames/0003.rlvfluid", "--size", "96x64"];
        let done = relievo(folder.path(), &[&first[..], &["-o", name], more].concat());
        assert!(done.status.success(), "{done:?}");
        let lines = text(&done.stdout);
        assert!(lines.lines().count() == 2 && lines.contains("frames/0003.rlvfluid: 360 particles, "), "{lines}");
        assert!(more.contains(&"--particles") == lines.contains("% blind"), "{lines}");
        relievo_render::read_png(&folder.path().join(name), 1 << 24).unwrap()
    };
    // The mean distance of linear colours.
    let apart = |a: &relievo_render::Image, b: &relievo_render::Image| {
        let distances: Vec<f32> = a.data().iter().zip(b.data()).map(|(a, b)| (a - b).abs()).collect();
        distances.iter().sum::<f32>() / distances.len() as f32
    };
    for material in ["opaque", "water"] {
        let direct = render("direct.png", &["--material", material]);
        assert_eq!((direct.width(), direct.height()), (192, 64));
        let threads = render("threads.png", &["--material", material, "--threads", "1"]);
        assert_eq!(direct.data(), threads.data());
        let mesh = render("mesh.png", &["--material", material, "--mesh", "0.25"]);
        let blind = render("blind.png", &["--material", material, "--particles", "blind"]);
        let bare = render("bare.png", &["--material", material, "--particles", "surface"]);
        let [mesh, blind, bare] = [mesh, blind, bare].map(|other| apart(&direct, &other));
        assert!(mesh < 0.02 && blind < 1e-3, "{material} {mesh} {blind}");
        // What was left out is seen from outside through water alone.
        assert!(material == "opaque" || bare > 5.0 * blind.max(1e-3), "{bare}");
    }
    let blurred = render("blurred.png", &["--shutter", "0.05"]);
    assert!(apart(&blurred, &render("still.png", &[])) > 1e-3);
    let refused = |arguments: &[&str], why: &str| {
        let done = relievo(folder.path(), &[&["fluid", "render"], arguments].concat());
        assert!(!done.status.success() && text(&done.stderr).contains(why), "{why}: {done:?}");
    };
    let good = ["frames/0000.rlvfluid", "-o"];
    refused(&[&good[..], &["a.bmp"]].concat(), ".png");
    refused(&[&good[..], &["a.png", "--eye", "1,2"]].concat(), "X,Y,Z");
    refused(&[&good[..], &["a.png", "--fov", "200"]].concat(), "field of view");
    refused(&[&good[..], &["a.png", "--shutter=-1"]].concat(), "shutter");
    refused(&[&good[..], &["a.png", "--mesh", "9"]].concat(), "cell size");
    refused(&[&good[..], &["a.png", "--spacing", "0"]].concat(), "support radius");
}

#[test]
fn particles_that_the_surface_does_not_need_are_left_out_of_any_file() {
    let folder = tempfile::tempdir().unwrap();
    let block = "frames = 0\n[fluid]\nspacing = 0.05\n[[block]]\nlow = [0, 0, 0]\nhigh = [0.8, 0.8, 0.8]\n";
    std::fs::write(folder.path().join("block.toml"), block).unwrap();
    let done = |arguments: &[&str]| {
        let done = relievo(folder.path(), &[&["fluid"], arguments].concat());
        assert!(done.status.success(), "{done:?}");
        text(&done.stdout)
    };
    done(&["sim", "block.toml", "-o", "frames"]);
    let frame = "frames/0000.rlvfluid";
    let told = done(&["convert", frame, "kept.vtk", "--particles", "blind"]);
    // 16 by 16 by 16 without what is 5 or more layers within.
    let number = |text: &str, after: &str| -> f64 {
        let rest = text.split_once(after).unwrap_or_else(|| panic!("{text}")).1;
        rest.split(' ').next().unwrap().parse().unwrap()
    };
    let kept = number(&told, "4096 particles, ");
    assert!((60.0..99.0).contains(&kept) && number(&told, " s, ") > 0.5 * (100.0 - kept), "{told}");
    assert!(told.contains("1 files, 4096 particles"), "{told}");
    let missing = ["--device", "gpu", "--adapter", "no such device"];
    let refused =
        relievo(folder.path(), &[&["fluid", "convert", frame, "a.vtk", "--particles", "blind"], &missing[..]].concat());
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("no such device"), "{refused:?}");
    if !relievo_gpu::adapters().is_empty() {
        let told = done(&["convert", frame, "device.vtk", "--particles", "blind", "--device", "gpu"]);
        assert!(number(&told, "4096 particles, ") == kept, "{told}");
        let [here, there] = ["kept.vtk", "device.vtk"].map(|name| std::fs::read(folder.path().join(name)).unwrap());
        assert!(here == there);
    }
    let info = done(&["info", "kept.vtk"]);
    assert!(info.contains("blind (1)") && info.contains("velocity (3)"), "{info}");
    // The mesh of what was kept is that of all, and has no inner side.
    let mesh = |from: &str, to: &str, more: &[&str]| {
        let all = [&["mesh", from, "-o", to], more].concat();
        (done(&all), std::fs::read(folder.path().join(to)).unwrap())
    };
    let (_, whole) = mesh(frame, "whole.ply", &[]);
    let (told, left) = mesh(frame, "left.ply", &["--particles", "blind"]);
    assert!(number(&told, "4096 particles, ") == kept && left == whole, "{told}");
    let (_, again) = mesh("kept.vtk", "again.ply", &[]);
    assert!(again == whole);
    let (_, bare) = mesh(frame, "bare.ply", &["--particles", "surface"]);
    assert!(bare.len() > whole.len());
    let refused = relievo(folder.path(), &["fluid", "mesh", "kept.vtk", "-o", "kept.vdb"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("blind"), "{refused:?}");
    let sizes = ["--size", "32x24", "-o", "a.png"];
    let told = done(&[&["render", frame, "--particles", "blind", "--compare"], &sizes[..]].concat());
    assert!(number(&told, "4096 particles, ") == kept && told.contains(" with all\n"), "{told}");
    // What is not there cannot be compared with.
    let told = done(&[&["render", "kept.vtk", "--particles", "blind", "--compare"], &sizes[..]].concat());
    assert!(told.contains("100.0 % kept") && !told.contains("with all"), "{told}");
}

const SCENE: &str = "version = 1\n[meshes.water]\nsequence = \"frames/%04d.ply\"\ncount = 4\n\
    [meshes.floor]\nshape = \"plane\"\nsize = [4, 4, 1]\n[objects.floor]\nmesh = \"floor\"\n\
    [objects.water]\nmesh = \"water\"\ndielectric = { index = 1.333 }\n\
    [camera]\nposition = [2, -2, 1.5]\ntarget = [0.5, 0.15, 0.2]\n\
    [output]\nframes = 1\nwidth = 64\nheight = 48\n[objects.water.fluid]\nspacing = 0.05\n";

#[test]
fn fluids_stand_in_scenes_beside_other_objects() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dam.toml"), DAM).unwrap();
    assert!(relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames", "--format", "ply"]).status.success());
    let run = |name: &str, scene: &str| {
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let done = relievo(folder.path(), &["scene", "run", "scene.toml", "--out", name]);
        assert!(done.status.success(), "{done:?}");
        let picture = folder.path().join(name).join("beauty-000000.png");
        relievo_render::read_png(&picture, 1 << 24).unwrap()
    };
    let apart = |a: &relievo_render::Image, b: &relievo_render::Image| {
        let distances = a.data().iter().zip(b.data()).map(|(a, b)| (a - b).abs());
        distances.sum::<f32>() / a.data().len() as f32
    };
    let direct = run("direct", SCENE);
    let mesh = run("mesh", &format!("{SCENE}cell = 0.25\n"));
    let opaque = run("opaque", &SCENE.replace("dielectric = { index = 1.333 }\n", ""));
    let none = run("none", &SCENE.replace("mesh = \"water\"", "mesh = \"water\"\nvisible = false"));
    assert!(apart(&direct, &mesh) < 1e-3, "{}", apart(&direct, &mesh));
    for (a, b) in [(&direct, &opaque), (&direct, &none), (&opaque, &none)] {
        assert!(apart(a, b) > 2e-3, "{}", apart(a, b));
    }
}

#[test]
fn fluids_are_blobs_and_grids_in_scenes_for_pov_ray() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dam.toml"), DAM).unwrap();
    assert!(relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames", "--format", "ply"]).status.success());
    let export = |form: &str| {
        let scene = format!("{SCENE}povray = \"{form}\"\n");
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let done = relievo(folder.path(), &["scene", "export", "pov", "scene.toml", "--out", form]);
        assert!(done.status.success(), "{done:?}");
        std::fs::read_to_string(folder.path().join(form).join("scene-000000.pov")).unwrap()
    };
    let blobs = export("blobs");
    assert_eq!((blobs.matches("blob {").count(), blobs.matches("\n  sphere {").count()), (1, 360));
    assert!(export("mesh").matches("mesh2 {").count() == 2 && blobs.matches("mesh2 {").count() == 1);
    let grid = export("df3");
    assert!(grid.contains("isosurface {") && grid.contains("density_file df3 \"fluid-water-000000.df3\""), "{grid}");
    let file = std::fs::read(folder.path().join("df3/fluid-water-000000.df3")).unwrap();
    let (sizes, values) = file.split_at(6);
    let sizes: Vec<usize> = sizes.chunks(2).map(|size| usize::from(u16::from_be_bytes([size[0], size[1]]))).collect();
    assert_eq!(values.len(), 2 * sizes.iter().product::<usize>());
    // Cells of half a spacing: as many within as fill the block of 0.3 by 0.3 by 0.5 m, whose edges are round.
    let within = values.chunks(2).filter(|value| value[0] >= 128).count() as f64 * 0.025f64.powi(3);
    assert!((0.7..1.05).contains(&(within / 0.045)), "{within}");
}

#[test]
fn statistics_are_plotted() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dam.toml"), DAM).unwrap();
    assert!(
        relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames", "--format", "cache"]).status.success()
    );
    let plot = |from: &str, to: &str| relievo(folder.path(), &["fluid", "plot", from, "-o", to]);
    for (from, to) in [("frames", "a.png"), ("frames/statistics.csv", "a.svg")] {
        let done = plot(from, to);
        assert!(done.status.success() && text(&done.stdout) == "4 frames\n", "{done:?}");
    }
    assert!(std::fs::read(folder.path().join("a.png")).unwrap().starts_with(b"\x89PNG"));
    let drawing = text(&std::fs::read(folder.path().join("a.svg")).unwrap());
    assert!(
        ["Too dense (%)", "Kinetic energy (J)", "corrections", "Time a frame (s)"]
            .iter()
            .all(|it| drawing.contains(it))
    );
    let refused = plot("frames", "a.gif");
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains(".png or .svg"), "{refused:?}");
    let refused = plot("dam.toml", "a.png");
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("statistics"), "{refused:?}");
}
