//! `relievo foam` as a user sees it.

mod program;

use std::path::Path;
use std::process::Command;

use program::{done, relievo};

const DAM: &str = "frames = 8\nfps = 24\n[fluid]\nspacing = 0.05\n[basin]\nlow = [0, 0, 0]\nhigh = [1.2, 0.3, 1]\n\
    [[block]]\nlow = [0, 0, 0]\nhigh = [0.4, 0.3, 0.8]\nvelocity = [2, 0, 0]\n";
/// Settings at which so small a fluid foams.
const LOW: [&str; 8] = ["--energy", "0.5,5", "--trapped-air", "0.5,5", "--air-rate", "300", "--crest-rate", "300"];

#[test]
fn foam_of_a_dam_is_made_resumed_rendered_and_composited() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("dam.toml"), DAM).unwrap();
    done(at, &["fluid", "sim", "dam.toml", "-o", "frames"]);
    let generate = |output: &str, more: &[&str]| {
        relievo(at, &[&["foam", "generate", "frames", "-o", output], LOW.as_slice(), more].concat())
    };
    let made = generate("foam", &[]);
    assert!(made.status.success(), "{made:?}");
    let bytes = |folder: &str, frame: u32| std::fs::read(at.join(format!("{folder}/{frame:04}.rlvfluid"))).unwrap();
    let rows: serde_json::Value = serde_json::from_str(&done(at, &["foam", "info", "foam", "--json"])).unwrap();
    let last = &rows[8];
    assert!(last["particles"].as_u64().unwrap() > 500, "{rows}");
    assert_eq!(
        last["particles"].as_u64(),
        ["spray", "foam", "bubbles"].map(|kind| last[kind].as_u64().unwrap()).iter().sum::<u64>().into()
    );
    // One thread, interrupted after frame 4.
    assert!(generate("again", &["--threads", "1"]).status.success());
    (5..9).for_each(|frame| std::fs::remove_file(at.join(format!("again/{frame:04}.rlvfluid"))).unwrap());
    let resumed = generate("again", &["--threads", "1"]);
    assert!(String::from_utf8_lossy(&resumed.stderr).contains("goes on from again/0004.rlvfluid"), "{resumed:?}");
    assert!((0..9).all(|frame| bytes("foam", frame) == bytes("again", frame)));
    let other = generate("again", &["--seed", "2"]);
    assert!(!other.status.success() && String::from_utf8_lossy(&other.stderr).contains("--restart"));
    assert!(generate("again", &["--seed", "2", "--restart"]).status.success());
    assert_ne!(bytes("foam", 8), bytes("again", 8));
    // Other formats have the same particles, and velocities are found by numbers where files have none.
    assert!(generate("vtk", &["--format", "vtk"]).status.success() && at.join("vtk/0008.vtk").exists());
    let view = ["--eye", "2.5,-1.5,1.4", "--target", "0.6,0.15,0.3", "--set", "radius=0.03"];
    let render = |more: &[&str]| {
        let fixed = ["foam", "render", "foam/0008.rlvfluid", "--fluid", "frames/0008.rlvfluid", "--size", "96x64"];
        done(at, &[&fixed, view.as_slice(), more].concat())
    };
    let line = render(&["-o", "wave.png", "--layers", "layers.exr", "--samples", "1"]);
    assert!(line.contains("particles of foam in ") && !line.contains("in 0.0 %"), "{line}");
    render(&["-o", "wave.exr", "--samples", "1"]);
    let composite = |more: &[&str]| {
        let fixed = ["foam", "composite", "foam/0008.rlvfluid", "--picture", "wave.exr", "-o", "over.png"];
        relievo(at, &[&fixed, view.as_slice(), more].concat())
    };
    assert!(composite(&[]).status.success());
    // A graphics device draws the same picture.
    if !relievo_gpu::adapters().is_empty() {
        let picture = || relievo_render::read_png(&at.join("over.png"), u64::MAX).unwrap();
        let first = picture();
        let drawn = composite(&["--device", "gpu"]);
        assert!(drawn.status.success(), "{drawn:?}");
        // Bytes beside each other are at most 2.3/255 apart as colours.
        let is_far = |(a, b): &(&f32, &f32)| (*a - *b).abs() > 2.5 / 255.0;
        let far = first.data().iter().zip(picture().data()).filter(is_far).count();
        assert!(far <= 96 * 64 * 3 / 1000, "{far}");
        render(&["-o", "wave.png", "--samples", "1", "--device", "gpu"]);
    }
    let missing = composite(&["--solids", "wave.png"]);
    assert!(!missing.status.success(), "{missing:?}");
    let unknown = composite(&["--set", "rho_mop=2"]);
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("rho_mod"), "{unknown:?}");
    check_exports(at, last["particles"].as_u64().unwrap());
    assert!(!relievo(at, &["foam", "render", "frames/0008.rlvfluid", "-o", "a.txt"]).status.success());
    assert!(done(at, &["foam", "info", "--settings"]).contains("ao_max_occl_dist"));
    assert!(!relievo(at, &["foam", "info", "frames"]).status.success());
}

/// Renders an exported medium from above by POV-Ray, a pixel for each column of cells, and compares with the light that these
/// scatter.
fn check_medium(at: &Path, declared: &str, [width, depth, height]: [usize; 3], cells: &[u8], most: f64) {
    let numbers = |word: &str| -> Vec<f64> {
        let list = declared.split_once(&format!("{word} <")).unwrap().1.split('>').next().unwrap();
        list.split(',').map(|number| number.trim().parse().unwrap()).collect()
    };
    let (extent, low) = (numbers("scale"), numbers("translate"));
    let [x, y] = [0, 1].map(|axis| low[axis] + 0.5 * extent[axis]);
    let scene = format!(
        "#version 3.7;\nglobal_settings {{ assumed_gamma 1 }}\n#include \"all.inc\"\n\
         camera {{ orthographic location <{x}, {y}, 50> direction -z right x * {} up y * {} }}\n\
         light_source {{ <{x}, {y}, 1000> rgb 1 parallel point_at <{x}, {y}, 0> }}\nobject {{ Relievo_Foam }}\n",
        extent[0], extent[1]
    );
    std::fs::write(at.join("medium.pov"), scene).unwrap();
    let size = [format!("+W{width}"), format!("+H{depth}")];
    let mut povray = Command::new("povray");
    povray.args(["+Imedium.pov", "+Omedium.png", "-D", "-A"]).args(size).current_dir(at);
    let drawn = match povray.output() {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            println!("skipped: povray is not installed");
            return;
        }
        drawn => drawn.unwrap(),
    };
    assert!(drawn.status.success(), "{}", String::from_utf8_lossy(&drawn.stderr));
    let picture = relievo_render::read_png(&at.join("medium.png"), u64::MAX).unwrap();
    let cell = extent[2] / height as f64;
    let value = |index: usize| f64::from(u16::from_be_bytes([cells[2 * index], cells[2 * index + 1]])) / 65_535.0;
    let seen: Vec<_> = (0..width * depth)
        .map(|pixel| f64::from(picture.color((pixel % width) as u32, (pixel / width) as u32)[0]))
        .collect();
    let expected = |column: usize, row: usize| {
        let through: f64 = (0..height).map(|z| value((z * depth + depth - 1 - row) * width + column)).sum();
        1.0 - (-most * cell * through).exp()
    };
    // How alike both are, as they stand and with the columns or the rows in reverse.
    let [alike, across, along] = [[false, false], [true, false], [false, true]].map(|[is_across, is_along]| {
        let place = |pixel: usize| {
            let [column, row] = [pixel % width, pixel / width];
            [if is_across { width - 1 - column } else { column }, if is_along { depth - 1 - row } else { row }]
        };
        let pairs = || (0..width * depth).map(|pixel| (place(pixel), seen[pixel]));
        let pairs: Vec<_> = pairs().map(|([column, row], seen)| [expected(column, row), seen]).collect();
        let mean = [0, 1].map(|which| pairs.iter().map(|pair| pair[which]).sum::<f64>() / pairs.len() as f64);
        let moment = |a: usize, b: usize| pairs.iter().map(|it| (it[a] - mean[a]) * (it[b] - mean[b])).sum::<f64>();
        moment(0, 1) / (moment(0, 0) * moment(1, 1)).sqrt()
    });
    assert!(alike > 0.8 && alike > across + 0.05 && alike > along + 0.02, "{alike} {across} {along}");
}

/// Exports the last frame of a folder for other renderers and reads the files again.
fn check_exports(at: &Path, count: u64) {
    let export = |more: &[&str]| relievo(at, &[&["foam", "export", "foam/0008.rlvfluid"], more].concat());
    let radius = ["--set", "radius=0.03"];
    assert!(export(&[&["-o", "all.df3", "--cell", "0.05"], &radius[..]].concat()).status.success());
    let (file, declared) =
        (std::fs::read(at.join("all.df3")).unwrap(), std::fs::read_to_string(at.join("all.inc")).unwrap());
    let sizes: Vec<_> = file[..6].chunks(2).map(|size| usize::from(u16::from_be_bytes([size[0], size[1]]))).collect();
    assert_eq!(file.len(), 6 + 2 * sizes.iter().product::<usize>());
    // The greatest value is full, and its coefficient is declared. Together they are the cross sections of the particles.
    let values = file[6..].chunks(2).map(|value| f64::from(u16::from_be_bytes([value[0], value[1]])) / 65_535.0);
    assert_eq!(values.clone().fold(0.0, f64::max), 1.0);
    let most: f64 = declared.split_once("rgb ").unwrap().1.split(' ').next().unwrap().parse().unwrap();
    let sections = values.sum::<f64>() * most * 0.05f64.powi(3);
    // Sizes are r/1 to r/5, so that the mean of squares is 0.29 of r² without lifetimes and bubbles.
    let greatest = count as f64 * std::f64::consts::PI * 0.03 * 0.03;
    assert!((0.05..0.33).contains(&(sections / greatest)), "{sections} {greatest}");
    assert!(declared.contains("density_file df3 \"all.df3\""), "{declared}");
    check_medium(at, &declared, [sizes[0], sizes[1], sizes[2]], &file[6..], most);

    let all = export(&[&["-o", "all.ply"], &radius[..]].concat());
    assert!(String::from_utf8_lossy(&all.stdout).contains(&format!("{count} particles")), "{all:?}");
    let context = relievo_core::Context::serial();
    let mut found = 0;
    for (kind, number) in [("spray", 0.0), ("foam", 1.0), ("bubbles", 2.0)] {
        assert!(export(&[&["-o", "some.ply", "--kind", kind], &radius[..]].concat()).status.success());
        let some = relievo_particleio::read(&context, &at.join("some.ply")).unwrap().particles;
        let types = &some.channel("type").unwrap().values;
        assert!(types.iter().all(|value| *value == number), "{kind}");
        let radii = &some.channel("radius").unwrap().values;
        let greatest = if kind == "bubbles" { 0.015 } else { 0.03 };
        assert!(radii.iter().all(|value| *value <= greatest && *value >= 0.2 * greatest - 1e-6), "{kind}");
        found += some.points.len() as u64;
    }
    assert_eq!(found, count);
    for wrong in [["-o", "a.df3", "--cell", "0"], ["-o", "a.df3", "--cell", "1e-6"], ["-o", "a.txt", "--cell", "1"]] {
        assert!(!export(&wrong).status.success(), "{wrong:?}");
    }
}

#[test]
fn foam_of_a_scene_is_laid_over_its_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("dam.toml"), DAM).unwrap();
    done(at, &["fluid", "sim", "dam.toml", "-o", "frames", "--format", "ply"]);
    let scene = |more: &str| {
        format!(
            "version = 1\n[meshes.water]\nsequence = \"frames/%04d.ply\"\ncount = 9\n[objects.water]\nmesh = \"water\"\n\
             dielectric = {{ index = 1.333 }}\n[camera]\nposition = [2.5, -1.5, 1.4]\ntarget = [0.6, 0.15, 0.3]\n\
             [output]\nframes = 9\nwidth = 64\nheight = 48\n[objects.water.fluid]\nspacing = 0.05\n{more}"
        )
    };
    const FOAM: &str = "[objects.water.fluid.foam]\nair_min = 0.5\nair_max = 5\nenergy_min = 0.5\nenergy_max = 5\n\
        air_rate = 300\ncrest_rate = 300\n[objects.water.fluid.foam.look]\nradius = 0.03\n";
    let run = |name: &str, text: &str, more: &[&str]| {
        std::fs::write(at.join("scene.toml"), text).unwrap();
        relievo(at, &[&["scene", "run", "scene.toml", "--out", name], more].concat())
    };
    let picture = |name: &str, frame: u32| std::fs::read(at.join(format!("{name}/beauty-{frame:06}.png"))).unwrap();
    let ran = run("with", &scene(FOAM), &[]);
    assert!(ran.status.success(), "{ran:?}");
    assert!(run("without", &scene(""), &[]).status.success());
    assert!(run("meshed", &scene(&format!("cell = 0.5\n{FOAM}")), &[]).status.success());
    assert!(run("plain", &scene("cell = 0.5\n"), &[]).status.success());
    // Foam is born on the way, and the solids' depths leave the fluid as it was.
    for (with, without) in [("with", "without"), ("meshed", "plain")] {
        assert!(picture(with, 0) == picture(without, 0) && picture(with, 8) != picture(without, 8), "{with}");
    }
    check_cached_frames(at, &scene(FOAM));
    let refused = |text: &str, says: &str| {
        let done = run("refused", text, &[]);
        let told = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(!done.status.success() && told.contains(says), "{says}: {told}");
    };
    refused(&scene(&FOAM.replace("air_rate = 300", "air_rat = 300")), "air_rate");
    refused(&scene(&FOAM.replace("air_max = 5", "air_max = 0.1")), "air_max");
    refused(
        &scene(FOAM).replace("sequence = \"frames/%04d.ply\"\ncount = 9", "file = \"frames/0004.ply\""),
        "sequence",
    );
}

/// Runs a scene whose foam is in the folder `with` again. Its frames of foam are opened from the cache as long as they are of
/// this scene, and made again where they are missing, damaged or of other settings.
fn check_cached_frames(at: &Path, text: &str) {
    let cached = |frame: u32| at.join(format!("with/cache/foam/water-{frame:06}.rlvfluid"));
    let bytes = |frame: u32| std::fs::read(cached(frame)).unwrap();
    let picture = || std::fs::read(at.join("with/beauty-000008.png")).unwrap();
    let run = |text: &str, more: &[&str]| {
        std::fs::write(at.join("scene.toml"), text).unwrap();
        let fixed = ["scene", "run", "scene.toml", "--out", "with", "--frames", "8..8", "--trace", "trace.json"];
        let done = relievo(at, &[&fixed, more].concat());
        assert!(done.status.success(), "{done:?}");
        let trace = std::fs::read_to_string(at.join("trace.json")).unwrap();
        let stages = ["foam.open", "foam.generate"].map(|stage| trace.matches(&format!("\"{stage}\"")).count());
        (stages, String::from_utf8_lossy(&done.stdout).into_owned() + &String::from_utf8_lossy(&done.stderr))
    };
    let (first, last) = (picture(), bytes(8));
    assert_eq!(run(text, &[]).0, [1, 0]);
    assert!(picture() == first);
    (6..9).for_each(|frame| std::fs::remove_file(cached(frame)).unwrap());
    assert_eq!(run(text, &[]).0, [1, 3]);
    assert!(picture() == first && bytes(8) == last);
    let mut damaged = last.clone();
    damaged[last.len() / 2] ^= 1;
    std::fs::write(cached(8), damaged).unwrap();
    let (stages, output) = run(text, &[]);
    assert!(stages == [1, 1] && output.contains("the foam of the frame is made again"), "{stages:?} {output}");
    assert!(picture() == first && bytes(8) == last);
    assert_eq!(run(text, &["--rebake"]).0, [1, 1]);
    let other = text.replace("air_rate = 300", "air_rate = 200");
    assert_eq!(run(&other, &[]).0, [1, 8]);
    assert!(picture() != first && bytes(8) != last);
    assert_eq!(run(&other.replace("radius = 0.03", "radius = 0.02"), &[]).0, [1, 0], "how it is drawn does not matter");
}
