//! What descriptions have beside a block and a basin: fills, colliders, bodies, emitters, sinks and forces.

use std::path::Path;
use std::process::Output;

use crate::{DAM, files, relievo, text};

#[test]
fn colliders_emitters_sinks_and_forces_act_in_the_example() {
    let folder = tempfile::tempdir().unwrap();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/fluids/mill.toml");
    let text_of = std::fs::read_to_string(example).unwrap();
    let short = text_of.replace("frames = 48", "frames = 4").replace("spacing = 0.025", "spacing = 0.05");
    let run = |description: &str| {
        std::fs::write(folder.path().join("mill.toml"), description).unwrap();
        relievo(folder.path(), &["fluid", "sim", "mill.toml", "-o", "frames", "--restart"])
    };
    let done = run(&short);
    let info = relievo(folder.path(), &["fluid", "info", "--json", "mill.toml"]);
    let begun: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    // Layers of 9 particles, a spacing apart, at 2 m/s.
    let found = ["particles", "colliders", "bodies", "emitted_a_second"].map(|key| begun[key].as_u64());
    assert_eq!(found, [768, 1, 1, 360].map(Some), "{begun}");
    let count = |done: &Output| -> u32 { text(&done.stdout).split(' ').next().unwrap().parse().unwrap() };
    // 24 by 8 by 4 that rest, and 6 layers of a jet.
    assert!(done.status.success() && count(&done) >= 768 + 6 * 4, "{done:?}");
    let without = run(&short.replace("speed = 2", "start = 100\nspeed = 2"));
    assert!(count(&without) == 768 && count(&done) < 768 + 7 * 12, "{without:?}");
    let refused = |from: &str, to: &str, why: &str| {
        assert!(short.contains(from), "{from}");
        let done = run(&short.replace(from, to));
        assert!(done.status.code() == Some(1) && text(&done.stderr).contains(why), "{why}: {done:?}");
    };
    refused("friction = 0.2", "friction = -1", "friction");
    refused("friction = 0.2", "rubs = 1", "rubs");
    refused("friction = 0.2", "contact = \"glue\"", "slip or stop");
    refused("time = 1.4", "time = 0.4", "collider 0: keys");
    refused("speed = 2", "speed = 0", "emitter 0");
    refused("radius = 0.08", "radius = 0.001", "no layer of particles 0.05 m apart");
    refused("particles = 40000\nstop = true", "particles = 780", "budget");
    refused("kind = \"wind\"", "kind = \"magic\"", "magic");
    refused("density = 600", "density = 0", "body 0");
    refused("share = 0.2", "share = 1e9", "force 0");
    refused("scale = 0.3", "scale = 0.3\nsize = 1", "size");
    refused("box = { low = [0, 0, 0], high = [1.2, 0.4, 0.2] }", "mesh = \"none.obj\"", "none.obj");
    refused("box = { low = [0, 0, 0], high = [1.2, 0.4, 0.2] }", "", "fill 0");
}

/// An OBJ file of a box.
fn box_obj(folder: &Path, name: &str, low: [f32; 3], high: [f32; 3]) {
    let point = |at: usize| [0, 1, 2].map(|axis| if at >> axis & 1 == 0 { low[axis] } else { high[axis] });
    let points: String = (0..8).map(point).map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    std::fs::write(folder.join(name), points + faces).unwrap();
}

#[test]
fn bodies_go_on_to_the_bit_and_files_that_changed_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let low = [0.1, 0.08, 0.55];
    box_obj(folder.path(), "crate.obj", low, [0.26, 0.22, 0.7]);
    let body = "[[body]]\nmesh = \"crate.obj\"\ndensity = 400\nspin = [0.5, 2, 0]\n\
        [[collider]]\nbox = { low = [0.5, 0, 0], high = [0.6, 0.3, 0.1] }\nkeys = [{ time = 0 }, { time = 1, move = [0.1, 0, 0] }]\n";
    let sim = |frames: u32, to: &str, format: &str| {
        let text = DAM.replace("frames = 3", &format!("frames = {frames}")) + body;
        std::fs::write(folder.path().join("dam.toml"), text).unwrap();
        relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", to, "--format", format])
    };
    for format in ["cache", "vdb"] {
        let (whole, parts) = (format!("whole-{format}"), format!("parts-{format}"));
        let done = sim(8, &whole, format);
        assert!(done.status.success(), "{done:?}");
        for frames in [3, 4, 8] {
            let done = sim(frames, &parts, format);
            assert!(done.status.success() && text(&done.stderr).contains("goes on") == (frames > 3), "{done:?}");
        }
        let [expected, found] = [whole, parts].map(|name| files(&folder.path().join(name)));
        assert!(
            expected == found,
            "{:?}",
            found.keys().filter(|name| found[*name] != expected[*name]).collect::<Vec<_>>()
        );
    }
    box_obj(folder.path(), "crate.obj", low, [0.26, 0.22, 0.71]);
    let refused = sim(9, "parts-cache", "cache");
    let why = "made with another crate.obj";
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains(why), "{refused:?}");
    box_obj(folder.path(), "crate.obj", low, [0.26, 0.22, 0.7]);
    assert!(sim(9, "parts-cache", "cache").status.success());
}

#[test]
fn colliders_have_the_shapes_of_numbered_files() {
    let folder = tempfile::tempdir().unwrap();
    let shape = |frame: u32, high: f32| {
        box_obj(folder.path(), &format!("jaw{frame:03}.obj"), [-0.2, -0.1, -0.1], [high, 0.4, 0.7]);
    };
    // A wall that grows into the water by 2 cm a frame, for three frames.
    (5..9).for_each(|frame| shape(frame, 0.02 * (frame - 5) as f32));
    let description = |sequence: &str| {
        let text = DAM
            .replace("frames = 3", "frames = 6")
            .replace("low = [0, 0, 0]\nhigh = [0.3", "low = [0.05, 0, 0]\nhigh = [0.35");
        std::fs::write(folder.path().join("dam.toml"), text + "[[collider]]\n" + sequence).unwrap();
        relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames", "--restart"])
    };
    let good = "sequence = \"jaw###.obj\"\nfirst = 5\ncount = 4\n";
    let lowest = |sequence: &str| {
        let done = description(sequence);
        assert!(done.status.success(), "{done:?}");
        let info = relievo(folder.path(), &["fluid", "info", "--json", "frames/0006.rlvfluid"]);
        let found: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
        found["bounds"][0][0].as_f64().unwrap()
    };
    // It pushes what stays in the corner where it does not move.
    let (pushed, still) = (lowest(good), lowest(&good.replace("count = 4", "count = 1")));
    assert!(pushed > 0.06 && still < pushed - 0.01, "{pushed} {still}");
    let refused = |sequence: &str, why: &str| {
        let done = description(sequence);
        assert!(done.status.code() == Some(1) && text(&done.stderr).contains(why), "{why}: {done:?}");
    };
    refused(&good.replace("count = 4", "count = 5"), "jaw009.obj");
    refused(&good.replace("count = 4", ""), "count");
    refused(&good.replace("sequence", "mesh"), "no sequence");
    refused(&good.replace("###", ""), "place for the number");
    refused(&format!("{good}box = {{ low = [0, 0, 0], high = [1, 1, 1] }}\n"), "more than one shape");
    let mut open = std::fs::read_to_string(folder.path().join("jaw007.obj")).unwrap();
    open.truncate(open.rfind("f ").unwrap());
    std::fs::write(folder.path().join("jaw007.obj"), open).unwrap();
    refused(good, "8 points and 10 triangles, and the first file 8 and 12");
}

#[test]
fn bodies_on_colliders_that_change_their_shapes_go_on_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    // A step of the floor that rises by 1 cm a frame, with a box on it.
    for frame in 0..9 {
        let high = [0.9, 0.5, 0.02 + 0.01 * frame as f32];
        box_obj(folder.path(), &format!("step{frame:02}.obj"), [0.6, -0.2, -0.2], high);
    }
    let more = "[[collider]]\nsequence = \"step##.obj\"\ncount = 9\n\
        [[body]]\nbox = { low = [0.65, 0.05, 0.02], high = [0.8, 0.2, 0.17] }\ndensity = 900\n";
    let sim = |frames: u32, to: &str| {
        let text = DAM.replace("frames = 3", &format!("frames = {frames}")) + more;
        std::fs::write(folder.path().join("dam.toml"), text).unwrap();
        relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", to, "--format", "cache"])
    };
    let done = sim(8, "whole");
    assert!(done.status.success(), "{done:?}");
    for frames in [3, 8] {
        let done = sim(frames, "parts");
        assert!(done.status.success() && text(&done.stderr).contains("goes on") == (frames > 3), "{done:?}");
    }
    assert!(files(&folder.path().join("whole")) == files(&folder.path().join("parts")));
}

#[test]
fn grids_of_openvdb_are_filled_and_points_of_it_are_frames() {
    use relievo_openvdb::peer::{LevelSet, Placing, is_available};

    if !is_available() {
        return;
    }

    let folder = tempfile::tempdir().unwrap();
    // A box of 0.3 by 0.3 by 0.5 m, of voxels of 2 cm.
    let corner = |at: usize| [0, 1, 2].map(|axis| if at >> axis & 1 == 0 { 0.0 } else { [15.0, 15.0, 25.0][axis] });
    let points: Vec<[f32; 3]> = (0..8).map(corner).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let level_set = LevelSet::of_mesh(&points, &triangles, 3.0).unwrap();
    let writing = Placing { voxel: 0.02, ..Placing::default() };
    level_set.write(&folder.path().join("box.vdb"), &writing).unwrap();
    level_set.write(&folder.path().join("fog.vdb"), &Placing { is_fog: true, ..writing }).unwrap();
    let sim = |fill: &str| {
        let text = DAM.split("[[block]]").next().unwrap().replace("frames = 3", "frames = 1") + "[[fill]]\n" + fill;
        std::fs::write(folder.path().join("dam.toml"), text).unwrap();
        relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames", "--restart", "--format", "vdb"])
    };
    let count = |fill: &str| -> usize {
        let done = sim(fill);
        assert!(done.status.success(), "{done:?}");
        text(&done.stdout).split(' ').next().unwrap().parse().unwrap()
    };
    // As many as the block has.
    assert_eq!(count("grid = \"box.vdb\"\n"), 360);
    let all = count("grid = \"fog.vdb\"\ngrid_name = \"cloud\"\nthreshold = 0.0001\n");
    let half = count("grid = \"fog.vdb\"\n");
    assert!(all == 360 && half < all && half > 100, "{all} {half}");
    // What our reader refuses: doubles, a stream, a mask.
    for (name, more) in [("double", &["--kind", "double"][..]), ("stream", &["--stream"])] {
        let to = format!("{name}.vdb");
        let done = relievo(folder.path(), &[&["grid", "convert", "box.vdb", "-o", &to], more].concat());
        assert!(done.status.success(), "{done:?}");
        assert_eq!(count(&format!("grid = \"{to}\"\n")), 360, "{name}");
    }
    let info = |path: &str| {
        let done = relievo(folder.path(), &["fluid", "info", path]);
        assert!(done.status.success(), "{done:?}");
        text(&done.stdout)
    };
    let told = info("frames/0001.vdb");
    assert!(told.contains("OpenVDB") && told.contains("velocity (3)") && told.contains("spacing: 0.05"), "{told}");
    let meshed = relievo(folder.path(), &["fluid", "mesh", "frames/0001.vdb", "-o", "surface.ply"]);
    assert!(meshed.status.success(), "{meshed:?}");
    let refused = |fill: &str, why: &str| {
        let done = sim(fill);
        assert!(done.status.code() == Some(1) && text(&done.stderr).contains(why), "{why}: {done:?}");
    };
    refused("grid = \"box.vdb\"\nthreshold = 0.5\n", "no threshold");
    refused("grid = \"fog.vdb\"\nthreshold = 2\n", "nothing of the grid");
    refused("grid = \"fog.vdb\"\nthreshold = -1\n", "all of space");
    refused("grid = \"fog.vdb\"\ngrid_name = \"smoke\"\n", "cloud");
    refused("grid = \"none.vdb\"\n", "none.vdb");
    refused("box = { low = [0, 0, 0], high = [1, 1, 1] }\nthreshold = 1\n", "no grid");
}
