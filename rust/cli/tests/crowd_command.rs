//! `relievo crowd` as a user sees it.

mod program;

#[cfg(feature = "view")]
mod display;

use std::path::Path;
use std::sync::OnceLock;

use serde_json::{Value, json};

use program::{done, relievo};

fn read(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&done(folder, arguments)).unwrap()
}

/// Checks that a command fails and says a text.
fn fails(folder: &Path, arguments: &[&str], text: &str) {
    let done = relievo(folder, arguments);
    let told = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(!done.status.success() && told.contains(text), "{arguments:?}: {told}");
    // Rust's own words for a file that ends too early.
    assert!(!told.contains("failed to fill"), "{arguments:?}: {told}");
}

const RINGS: usize = 41;
const SIDES: usize = 24;
const TRIANGLES: u64 = (2 * (RINGS - 1) * SIDES) as u64;

/// Writes a tube along y from 0 to 2 as glTF. Its upper half bends by 90 degrees within a second, in one clip about z and in
/// another about x.
fn write_arm(folder: &Path) {
    let mut parts: [Vec<u8>; 7] = Default::default();
    for ring in 0..RINGS {
        for side in 0..SIDES {
            let (angle, height) =
                (std::f32::consts::TAU * side as f32 / SIDES as f32, 2.0 * ring as f32 / (RINGS - 1) as f32);
            let radius = 0.2 + 0.01 * (5.0 * angle).sin() * (9.0 * height).cos();
            let share = (2.5 * height - 2.0).clamp(0.0, 1.0);
            let mut add = |part: usize, values: &[f32]| {
                parts[part].extend(values.iter().flat_map(|value| value.to_le_bytes()));
            };
            add(0, &[radius * angle.cos(), height, radius * angle.sin()]);
            add(2, &[1.0 - share, share, 0.0, 0.0]);
            parts[1].extend([0, 1, 0, 0]);
        }
    }
    for ring in 0..RINGS - 1 {
        for side in 0..SIDES {
            let (low, high, next) = (ring * SIDES, (ring + 1) * SIDES, (side + 1) % SIDES);
            let corners = [low + side, high + side, high + next, low + side, high + next, low + next];
            parts[3].extend(corners.iter().flat_map(|corner| (*corner as u32).to_le_bytes()));
        }
    }
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let floats = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    parts[4] = floats(&[0.0, 1.0]);
    parts[5] = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]);
    parts[6] = floats(&[0.0, 0.0, 0.0, 1.0, half, 0.0, 0.0, half]);
    let points = RINGS * SIDES;
    let accessor = |part: usize, kind: u32, count: usize, form: &str| json!({ "bufferView": part, "componentType": kind, "count": count, "type": form });
    let mut accessors = vec![
        accessor(0, 5126, points, "VEC3"),
        accessor(1, 5121, points, "VEC4"),
        accessor(2, 5126, points, "VEC4"),
        accessor(3, 5125, 3 * TRIANGLES as usize, "SCALAR"),
        accessor(4, 5126, 2, "SCALAR"),
        accessor(5, 5126, 2, "VEC4"),
        accessor(6, 5126, 2, "VEC4"),
    ];
    (accessors[0]["min"], accessors[0]["max"]) = (json!([-0.3, 0.0, -0.3]), json!([0.3, 2.0, 0.3]));
    (accessors[4]["min"], accessors[4]["max"]) = (json!([0.0]), json!([1.0]));
    let mut start = 0;
    let views = parts.iter().map(|part| {
        start += part.len();
        json!({ "buffer": 0, "byteOffset": start - part.len(), "byteLength": part.len() })
    });
    let views: Vec<Value> = views.collect();
    let clip = |name: &str, output: u32| {
        json!({
            "name": name,
            "channels": [{ "sampler": 0, "target": { "node": 2, "path": "rotation" } }],
            "samplers": [{ "input": 4, "output": output }],
        })
    };
    let file = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [
            { "mesh": 0, "skin": 0 },
            { "name": "lower", "children": [2] },
            { "name": "upper" },
        ],
        "skins": [{ "joints": [1, 2] }],
        "meshes": [{
            "primitives": [{ "attributes": { "POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2 }, "indices": 3 }],
        }],
        "animations": [clip("bow", 5), clip("nod", 6)],
        "buffers": [{ "uri": "arm.bin", "byteLength": parts.concat().len() }],
        "bufferViews": views,
        "accessors": accessors,
    });
    std::fs::write(folder.join("arm.bin"), parts.concat()).unwrap();
    std::fs::write(folder.join("arm.gltf"), file.to_string()).unwrap();
}

/// Writes the model of the arm as `arm.rcrowd`, which the first test that needs it builds by the command.
fn write_model(folder: &Path) {
    static BUILT: OnceLock<Vec<u8>> = OnceLock::new();
    let bytes = BUILT.get_or_init(|| {
        write_arm(folder);
        done(
            folder,
            &["crowd", "build", "arm.gltf", "-o", "arm.rcrowd", "--pose-rate", "4", "--cluster-triangles", "40"],
        );
        std::fs::read(folder.join("arm.rcrowd")).unwrap()
    });
    std::fs::write(folder.join("arm.rcrowd"), bytes).unwrap();
}

#[test]
fn a_crowd_is_built_described_viewed_rendered_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_arm(at);
    let build = ["crowd", "build", "arm.gltf", "--pose-rate", "6", "--cluster-triangles", "40"];
    let made = read(at, &[&build[..], &["-o", "arm.rcrowd", "--clip", "bow", "--json"]].concat());
    assert_eq!(made["triangles"].as_u64(), Some(TRIANGLES));
    assert_eq!((made["bones"].as_u64(), made["poses"].as_u64()), (Some(2), Some(6)));
    // One thread writes the same bytes, and all clips are taken without names.
    done(at, &[&build[..], &["-o", "one.rcrowd", "--clip", "0", "--threads", "1"]].concat());
    let bytes = |name: &str| std::fs::read(at.join(name)).unwrap();
    assert_eq!(bytes("arm.rcrowd"), bytes("one.rcrowd"));
    done(at, &[&build[..], &["-o", "both.rcrowd"]].concat());

    let info = read(at, &["crowd", "info", "both.rcrowd", "--json"]);
    let names: Vec<&str> = info["clips"].as_array().unwrap().iter().filter_map(|clip| clip["name"].as_str()).collect();
    assert_eq!(names, ["bow", "nod"]);
    assert_eq!(info["poses"].as_u64(), Some(12));
    let cuts: Vec<u64> =
        info["cuts"].as_array().unwrap().iter().map(|cut| cut["triangles"].as_u64().unwrap()).collect();
    assert!(cuts.is_sorted_by(|a, b| a >= b) && cuts[0] <= TRIANGLES && cuts[4] < TRIANGLES / 3, "{cuts:?}");
    let levels = info["levels"].as_array().unwrap();
    assert_eq!(levels.iter().map(|it| it["groups"].as_u64().unwrap()).sum::<u64>(), info["groups"].as_u64().unwrap());
    for level in levels {
        let largest = |poses: &str| level[poses]["largest"].as_f64().unwrap();
        assert!(
            largest("chosen") <= largest("all") && level["exceeding"].as_u64() <= level["groups"].as_u64(),
            "{level}"
        );
    }
    let text = done(at, &["crowd", "info", "arm.rcrowd"]);
    assert!(text.contains("6, of which"), "{text}");
    // A line for each level, below the head.
    let own = read(at, &["crowd", "info", "arm.rcrowd", "--json"])["levels"].as_array().unwrap().len();
    let table: Vec<&str> = text.lines().skip_while(|line| !line.starts_with("level  groups")).collect();
    assert!(own > 1 && table.len() == 1 + own && table[1].starts_with("    1 "), "{text}");
    let old = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/model-1.rcrowd");
    assert!(done(at, &["crowd", "info", old.to_str().unwrap()]).contains("of an older version"));

    // A refit of the same file changes nothing, one of another clip has poses of that.
    let refit = |output: &str, clip: &str| {
        let fixed = ["crowd", "refit", "arm.rcrowd", "arm.gltf", "--pose-rate", "6", "--json"];
        read(at, &[&fixed[..], &["-o", output, "--clip", clip]].concat())
    };
    let same = refit("same.rcrowd", "bow");
    assert_eq!(bytes("arm.rcrowd"), bytes("same.rcrowd"));
    assert_eq!((same["grown_groups"].as_u64(), same["rebuild_due"].as_bool()), (Some(0), Some(false)));
    assert_eq!(refit("nod.rcrowd", "nod")["clips"][0]["name"], "nod");

    let view = |more: &[&str]| read(at, &[&["crowd", "view", "both.rcrowd", "--json"], more].concat());
    let (fine, coarse) = (view(&["--square", "100"]), view(&["--square", "100", "--pixels", "4"]));
    assert_eq!(fine["agents"].as_u64(), Some(100));
    assert!(fine["in_view"].as_u64().unwrap() > 20, "{fine}");
    assert!(coarse["triangles"].as_u64() < fine["triangles"].as_u64(), "{fine} {coarse}");
    // Errors hold for both ways to blend bones, so that dual quaternions need more triangles.
    let dual = view(&["--square", "100", "--blend", "dual"]);
    assert!(dual["triangles"].as_u64() > fine["triangles"].as_u64(), "{dual} {fine}");
    assert_eq!(view(&["--square", "100", "--blend", "linear"]), fine);
    fails(
        at,
        &["crowd", "view", "both.rcrowd", "--square", "9", "--blend", "dual", "--budget", "1"],
        "leave out --budget",
    );
    std::fs::write(at.join("agents.txt"), "# x y z heading scale clip phase\n0 0 0 0 1 nod 0.5\n2 0 0 90 1.5 bow 0\n")
        .unwrap();
    let near = ["--agents", "agents.txt", "--eye", "1,1,8", "--target", "1,1,0"];
    assert_eq!(view(&near)["in_view"].as_u64(), Some(2));

    if !relievo_gpu::adapters().is_empty() {
        let device = ["--device", "gpu", "--frames", "2", "--step", "0.3"];
        let both = view(&[&["--square", "100"], &device[..]].concat());
        assert_eq!(both, view(&["--square", "100", "--frames", "2", "--step", "0.3"]));
        assert_eq!(view(&[&near[..], &device].concat())[0]["in_view"].as_u64(), Some(2));
        // The same options as on the processor.
        for more in [&["--geomorph", "--pixels", "3"][..], &["--impostors", "--pixels", "6"]] {
            let fixed = [&["--square", "100"], more].concat();
            assert_eq!(view(&[&fixed[..], &["--device", "gpu"]].concat()), view(&fixed), "{more:?}");
        }
        // Agents behind the front row are hidden from a low camera, and a device culls no more of them.
        let row = |z: i32| {
            (0..15).map(move |x| format!("{} 0 {} {} 1 bow 0\n", 0.5 * f64::from(x) - 3.5, -1.5 * f64::from(z), 40 * x))
        };
        std::fs::write(at.join("rows.txt"), (0..10).flat_map(row).collect::<String>()).unwrap();
        let low = ["--agents", "rows.txt", "--eye", "0,1.2,4", "--target", "0,1.2,-5", "--occlusion"];
        let (by_device, by_processor) = (view(&[&low[..], &["--device", "gpu"]].concat()), view(&low));
        for counted in ["agents", "in_view", "full_triangles"] {
            assert_eq!(by_device[counted], by_processor[counted], "{counted}");
        }
        let hidden = |view: &Value| view["hidden"].as_u64().unwrap();
        assert!(hidden(&by_device) > 5, "{by_device}");
        assert!(hidden(&by_device) <= hidden(&by_processor), "{by_device} {by_processor}");
        let shown = |view: &Value| view["triangles"].as_u64().unwrap() + view["hidden_triangles"].as_u64().unwrap();
        assert_eq!(shown(&by_device), shown(&by_processor));
    }

    let render = |name: &str, more: &[&str]| {
        let fixed = ["crowd", "render", "both.rcrowd", "-o", name, "--size", "96x72", "--samples", "1"];
        done(at, &[&fixed[..], &near, more].concat());
        bytes(name)
    };
    let shaded = render("shaded.png", &[]);
    for (name, more) in [("clusters.png", &["--show", "clusters"][..]), ("later.png", &["--time", "0.3"])] {
        assert_ne!(render(name, more), shaded, "{name}");
    }
    render("levels.png", &["--show", "levels", "--wireframe"]);
    render("dual.png", &["--blend", "dual"]);
    // Vertices on their way are elsewhere than those of a cut.
    let coarse = ["--pixels", "6"];
    assert_ne!(render("moving.png", &[&coarse[..], &["--geomorph"]].concat()), render("still.png", &coarse));
    if !relievo_gpu::adapters().is_empty() {
        let image = |name: &str| relievo_render::read_png(&at.join(name), u64::MAX).unwrap();
        // Lines are as wide as differences from pixel to pixel say on devices, and as rays do on the processor.
        let lines = ["--unshadowed", "--show", "levels", "--wireframe"];
        let moving = ["--unshadowed", "--geomorph", "--pixels", "6", "--blend", "dual"];
        for (more, share) in [(&lines[..1], 0.002), (&lines[..3], 0.002), (&lines[..], 0.03), (&moving, 0.002)] {
            render("rays.png", more);
            render("device.png", &[more, &["--device", "gpu"]].concat());
            let (rays, device) = (image("rays.png"), image("device.png"));
            let far = rays.data().iter().zip(device.data()).filter(|(a, b)| (*a - *b).abs() > 0.02).count();
            println!("{more:?}: {far} of {} numbers differ", rays.data().len());
            assert!((far as f64) < share * rays.data().len() as f64, "{more:?}: {far} numbers differ");
        }
    }

    let export = |name: &str, more: &[&str]| {
        let line = done(at, &[&["crowd", "export", "both.rcrowd", "-o", name], more].concat());
        line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap()
    };
    assert_eq!(export("full.ply", &[]), TRIANGLES);
    let json = read(at, &["crowd", "export", "both.rcrowd", "-o", "half.obj", "--error-relative", "0.02", "--json"]);
    assert_eq!((json["input_triangles"].as_u64(), json["output"].as_str()), (Some(TRIANGLES), Some("half.obj")));
    assert!(json["triangles"].as_u64() < Some(TRIANGLES / 2) && json["error"].as_f64() > Some(0.0), "{json}");
    let few = export("far.glb", &["--error-relative", "0.02", "--clip", "nod", "--time", "0.5"]);
    assert!(few > 0 && few < TRIANGLES / 3, "{few}");
    assert!(at.join("far.glb").exists());
}

#[test]
fn far_agents_are_quads_that_cover_the_same_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_model(at);
    std::fs::write(at.join("agents.txt"), "-4 0 0 0 1 bow 0.5\n0 0 0 40 1 nod 0.5\n4 0 0 90 1 bow 0\n").unwrap();
    std::fs::write(at.join("none.txt"), "-4 0 150 0 1 bow 0\n0 0 150 0 1 nod 0\n4 0 150 0 1 bow 0\n").unwrap();
    let seen = ["arm.rcrowd", "--eye", "0,12,60", "--target", "0,1,0", "--size", "160x64", "--pixels", "0.7"];
    let agents = ["--agents", "agents.txt"];
    let view = |more: &[&str]| read(at, &[&["crowd", "view", "--json"], &seen[..], &agents, more].concat());
    let (meshes, quads) = (view(&[]), view(&["--impostors"]));
    assert_eq!((quads["in_view"].as_u64(), quads["triangles"].as_u64()), (Some(3), Some(6)), "{quads}");
    assert!(meshes["triangles"].as_u64() > Some(30), "{meshes}");
    let picture = |more: &[&str]| {
        let fixed = ["crowd", "render", "-o", "picture.png", "--samples", "64", "--show", "agents", "--unshadowed"];
        done(at, &[&fixed[..], &seen, more].concat());
        relievo_render::read_png(&at.join("picture.png"), u64::MAX).unwrap()
    };
    let (full, impostors) = (picture(&agents), picture(&[&agents[..], &["--impostors"]].concat()));
    let ground = picture(&["--agents", "none.txt"]);
    let [width, height] = [160u32, 64];
    let covered = |image: &relievo_render::Image, x: u32, y: u32| {
        let (a, b) = (image.color(x, y), ground.color(x, y));
        (0..3).any(|axis| (a[axis] - b[axis]).abs() > 0.01)
    };
    // Whatever one picture covers, the other covers there or at a pixel beside it.
    let mut counts = [0, 0];
    // Below the horizon, which is where the ground of each picture ends.
    for (x, y) in (20..height - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y))) {
        for (at, [one, other]) in [[&full, &impostors], [&impostors, &full]].into_iter().enumerate() {
            if covered(one, x, y) {
                counts[at] += 1;
                let mut around = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y)));
                assert!(around.any(|(x, y)| covered(other, x, y)), "pixel {x}, {y} of picture {at}");
            }
        }
    }
    println!("{counts:?} pixels");
    assert!(counts[0] > 12 && counts[1] >= counts[0] && counts[1] < 3 * counts[0], "{counts:?}");
}

#[test]
fn agents_walk_and_hide_others() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_model(at);
    // A large arm, a small one behind it, and a third that leaves the view to the right.
    std::fs::write(at.join("agents.txt"), "0 0 0 0 3 bow 0\n0 1 -5 0 0.1 bow 0\n2 0 0 90 1 nod 0 0 40\n").unwrap();
    let shared = ["arm.rcrowd", "--agents", "agents.txt", "--eye", "0,1,8", "--target", "0,1,0"];
    let view = |more: &[&str]| read(at, &[&["crowd", "view"], &shared[..], &["--json"], more].concat());
    let (all, fewer) = (view(&[]), view(&["--occlusion"]));
    assert_eq!((all["in_view"].as_u64(), fewer["in_view"].as_u64()), (Some(3), Some(3)));
    assert_eq!((all["hidden"].as_u64(), fewer["hidden"].as_u64()), (None, Some(1)));
    let triangles = |value: &Value, key: &str| value[key].as_u64().unwrap();
    assert!(triangles(&fewer, "hidden_triangles") > 0);
    let left = triangles(&fewer, "triangles") + triangles(&fewer, "hidden_triangles");
    assert_eq!(left, triangles(&all, "triangles"));
    let frames = view(&["--frames", "3", "--step", "0.5"]);
    let in_view: Vec<_> = frames.as_array().unwrap().iter().map(|frame| frame["in_view"].as_u64()).collect();
    assert_eq!(in_view, [Some(3), Some(2), Some(2)]);
    assert_eq!(frames[0]["triangles"], all["triangles"]);

    let render = |name: &str, more: &[&str]| {
        let fixed = ["crowd", "render", "-o", name, "--size", "64x48", "--samples", "1", "--show", "agents"];
        done(at, &[&fixed[..], &shared, more].concat());
        relievo_render::read_png(&at.join(name), u64::MAX).unwrap()
    };
    let one = render("one.png", &[]);
    // Agents that are left out change no pixel, and where there are shadows none is.
    let unshadowed = render("unshadowed.png", &["--unshadowed"]);
    assert_eq!(render("culled.png", &["--unshadowed", "--occlusion"]), unshadowed);
    assert_eq!(render("thrown.png", &["--occlusion"]), one);
    if !relievo_gpu::adapters().is_empty() {
        let on_device = ["--device", "gpu", "--unshadowed", "--frames", "2", "--step", "0.5"];
        let culled = [&on_device[..], &["--occlusion"]].concat();
        assert_eq!(render("gpu_culled.png", &culled), render("gpu.png", &on_device));
    }
    let strip = render("strip.png", &["--frames", "2", "--step", "0.5"]);
    assert_eq!((strip.width(), strip.height()), (64, 96));
    let (first, second) = strip.data().split_at(one.data().len());
    assert!(first == one.data() && second != first);
    // The second frame of the strip is the picture at its time, so nothing of the first is left in it.
    assert_eq!(second, render("second.png", &["--time", "0.5"]).data());
    fails(at, &[&["crowd", "view"], &shared[..], &["--frames", "0"]].concat(), "--frames");
    fails(at, &[&["crowd", "view"], &shared[..], &["--step", "inf"]].concat(), "--step");
}

#[test]
fn wrong_arguments_and_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_arm(at);
    fails(at, &["crowd", "build", "arm.gltf", "-o", "a.rcrowd", "--clip", "bew"], "bow");
    fails(at, &["crowd", "build", "arm.gltf", "-o", "a.rcrowd", "--cluster-triangles", "2"], "cluster_triangles");
    fails(at, &["crowd", "build", "nothing.glb", "-o", "a.rcrowd"], "nothing.glb");
    assert!(!at.join("a.rcrowd").exists());
    done(at, &["crowd", "build", "arm.gltf", "-o", "a.rcrowd", "--pose-rate", "2", "--clip", "bow"]);
    let mut bytes = std::fs::read(at.join("a.rcrowd")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    std::fs::write(at.join("wrong.rcrowd"), &bytes).unwrap();
    fails(at, &["crowd", "view", "wrong.rcrowd", "--square", "1"], "wrong.rcrowd");
    // Cut within its head, before the head of a chunk, within that, and within the chunk.
    for length in [0, 7, 40, 52, 58, 70] {
        std::fs::write(at.join("short.rcrowd"), &bytes[..length]).unwrap();
        fails(at, &["crowd", "info", "short.rcrowd"], "the file ends too early");
    }
    std::fs::write(at.join("short.rcrowd"), &bytes[..middle]).unwrap();
    fails(at, &["info", "short.rcrowd"], "short.rcrowd");
    std::fs::write(at.join("agents.txt"), "0 0 0 0 1 bow 0\n1 0 0 0 1 bow\n").unwrap();
    fails(at, &["crowd", "view", "a.rcrowd", "--agents", "agents.txt"], "line 2");
    fails(at, &["crowd", "view", "a.rcrowd", "--square", "0"], "--square");
    fails(at, &["crowd", "view", "a.rcrowd"], "--agents");
    fails(at, &["crowd", "view", "a.rcrowd", "--square", "4", "--pixels", "0"], "pixels");
    std::fs::write(at.join("other.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    fails(at, &["crowd", "refit", "a.rcrowd", "other.obj", "-o", "b.rcrowd"], "other triangles");
    fails(at, &["crowd", "export", "a.rcrowd", "-o", "a.ply", "--error=-1"], "error");
    fails(at, &["crowd", "export", "a.rcrowd", "-o", "a.ply", "--clip", "nod"], "nod");
}

#[test]
fn levels_of_detail_are_written_for_other_engines() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_model(at);
    let text = done(at, &["crowd", "export", "arm.rcrowd", "-o", "levels.glb", "--levels", "3", "--pixels", "2"]);
    assert!(text.contains(&format!("level 0: {TRIANGLES} triangles")) && text.contains("level 2"), "{text}");
    let bytes = std::fs::read(at.join("levels.glb")).unwrap();
    let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    let file: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    assert_eq!(file["nodes"][0]["extensions"]["MSFT_lod"]["ids"], json!([1, 2]));
    let coverages: Vec<f64> = file["nodes"][0]["extras"]["MSFT_screencoverage"]
        .as_array()
        .unwrap()
        .iter()
        .map(|value| value.as_f64().unwrap())
        .collect();
    // Coarser levels have larger errors, so they cover less where they are good enough.
    assert!(coverages.len() == 3 && coverages[0] > coverages[1] && coverages[2] == 0.0, "{coverages:?}");
    // The scene has the finest level and the bones, none below another.
    assert_eq!(file["scenes"][0]["nodes"], json!([0, 3, 4]));
    assert_eq!(file["animations"].as_array().unwrap().len(), 2);
    fails(at, &["crowd", "export", "arm.rcrowd", "-o", "levels.ply", "--levels", "3"], ".glb");

    let export = ["crowd", "export", "arm.rcrowd", "-o", "each.glb", "--levels", "3", "--json"];
    let (together, each) = (read(at, &export), read(at, &[&export[..], &["--separate"]].concat()));
    let outputs = |value: &Value| -> Vec<String> {
        value["levels"].as_array().unwrap().iter().map(|level| level["output"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(outputs(&together), ["each.glb"; 3]);
    assert_eq!(outputs(&each), ["each_LOD0.glb", "each_LOD1.glb", "each_LOD2.glb"]);
    for (level, output) in outputs(&each).iter().enumerate() {
        let [one, other] = [&together, &each].map(|value| value["levels"][level]["triangles"].as_u64());
        assert_eq!(one, other);
        let about = read(at, &["info", output, "--json"]);
        assert_eq!(about["faces"].as_u64(), one, "{about}");
    }
    fails(at, &["crowd", "export", "arm.rcrowd", "-o", "a.glb", "--separate"], "--levels");
    fails(at, &["crowd", "export", "arm.rcrowd", "-o", "levels.glb", "--levels", "3", "--error", "1"], "--error");
}

#[test]
fn point_instancers_of_a_stage_place_agents() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_model(at);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // Centimetres with z up; the third copy is off.
    let stage = format!(
        r#"#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Z"
)
def PointInstancer "people" (
    inactiveIds = [7]
)
{{
    rel prototypes = [</people/tall>, </people/small>]
    int[] protoIndices = [0, 1, 0]
    int64[] ids = [3, 5, 7]
    point3f[] positions = [(0, 0, 0), (200, 100, 0), (0, 0, 0)]
    quatf[] orientationsf = [(1, 0, 0, 0), ({half}, 0, 0, {half}), (1, 0, 0, 0)]
    float3[] scales = [(1, 1, 1), (1.5, 1.5, 1.5), (1, 1, 1)]
    vector3f[] velocities = [(0, 0, 0), (40, 0, 0), (0, 0, 0)]
    string[] primvars:clip = ["nod", "bow", "bow"]
    float[] primvars:phase = [0.5, 0, 0]
    def Xform "tall" {{ }}
    def Xform "small" {{ }}
}}
"#
    );
    std::fs::write(at.join("agents.usda"), stage).unwrap();
    std::fs::write(at.join("agents.txt"), "0 0 0 0 1 nod 0.5 0\n2 0 -1 90 1.5 bow 0 1 0.4\n").unwrap();
    let fixed = ["arm.rcrowd", "arm.rcrowd", "--eye", "1,1,8", "--target", "1,1,0", "--time", "0.5"];
    let view = |agents: &str| read(at, &[&["crowd", "view"], &fixed[..], &["--json", "--agents", agents]].concat());
    let (stage, list) = (view("agents.usda"), view("agents.txt"));
    assert_eq!(list["in_view"].as_u64(), Some(2));
    assert_eq!(stage, list);
    let render = |agents: &str, name: &str| {
        let more = ["crowd", "render", "-o", name, "--size", "64x48", "--samples", "1", "--agents", agents];
        done(at, &[&more[..], &fixed].concat());
        relievo_render::read_png(&at.join(name), u64::MAX).unwrap()
    };
    let (one, other) = (render("agents.usda", "stage.png"), render("agents.txt", "list.png"));
    let far = one.data().iter().zip(other.data()).filter(|(a, b)| a != b).count();
    assert!(far <= one.data().len() / 100, "{far} of {} numbers differ", one.data().len());
    fails(at, &["crowd", "view", "arm.rcrowd", "--agents", "agents.usda"], "prototype 1");
    std::fs::write(at.join("none.usda"), "#usda 1.0\ndef Xform \"a\" { }\n").unwrap();
    fails(at, &["crowd", "view", "arm.rcrowd", "--agents", "none.usda"], "point instancer");
}

#[test]
fn clusters_are_read_while_a_crowd_is_viewed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_model(at);
    std::fs::write(at.join("agents.txt"), "0 0 0 0 1 bow 0\n1 0 -9 0 1 bow 0\n").unwrap();
    let shared = ["crowd", "view", "arm.rcrowd", "--agents", "agents.txt", "--eye", "0,1,4", "--target", "0,1,0"];
    let view = |more: &[&str]| read(at, &[&shared[..], &["--json"], more].concat());
    let whole = view(&[]);
    let frames = view(&["--budget", "1", "--read", "8", "--frames", "40", "--step", "0"]);
    let number = |frame: &Value, key: &str| frame[key].as_u64().unwrap();
    let frames = frames.as_array().unwrap();
    assert!(frames.iter().all(|frame| number(frame, "read_clusters") <= 8), "{frames:?}");
    assert!(number(&frames[0], "read_clusters") > 0 && number(&frames[0], "missing_clusters") > 0, "{frames:?}");
    assert!(number(&frames[0], "triangles") < number(&whole, "triangles"));
    assert_eq!(frames[0]["wanted_triangles"], whole["triangles"]);
    // In the end the cut is there.
    assert_eq!(number(&frames[39], "missing_clusters"), 0);
    assert_eq!(frames[39]["triangles"], whole["triangles"]);
    let few = view(&["--budget", "0.01"]);
    assert!(number(&few, "missing_clusters") > 0 && number(&few, "triangles") < number(&whole, "triangles"), "{few}");
    fails(at, &[&shared[..], &["--budget", "0.0001"]].concat(), "budget");
    fails(at, &[&shared[..], &["--budget", "1", "--impostors"]].concat(), "--impostors");
    // A picture of whole models is that of clusters that were read.
    let render = |more: &[&str]| {
        let view = ["crowd", "render", "arm.rcrowd", "--agents", "agents.txt", "--eye", "0,1,4", "--target", "0,1,0"];
        let size = ["--size", "64x48", "--samples", "1", "--pixels", "0.02", "-o", "arm.png"];
        done(at, &[&view[..], &size, more].concat());
        std::fs::read(at.join("arm.png")).unwrap()
    };
    let picture = render(&[]);
    assert_eq!(picture, render(&["--budget", "1"]));
    assert_ne!(picture, render(&["--budget", "0.002"]));
    let dual = ["crowd", "render", "arm.rcrowd", "--square", "1", "--budget", "1", "--blend", "dual", "-o", "a.png"];
    fails(at, &dual, "--blend");
}

#[cfg(feature = "view")]
#[test]
fn a_window_shows_what_an_error_leaves_of_a_crowd() {
    if !display::is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_model(folder);
    let script = "resize 1000 620\nwait_frames 1\npress error\npoint 0.02 0.02\nwait_frames 2\nscreenshot fine.png\n\
        press Error\npoint 0.02 0.02\nwait_frames 2\nscreenshot coarse.png\nkey Right\nkey Right\nkey Right\nkey Right\n\
        wait_frames 2\nscreenshot later.png\nquit\n";
    display::view(folder, &["arm.rcrowd", "--square", "9"], script);
    let [fine, coarse, later] = display::pictures(folder, ["fine", "coarse", "later"]);
    // Blue stands for what was simplified often, which is enough here for half a pixel. With twelve the outlines differ.
    let is_blue = |[r, g, b]: [f32; 3]| b > 0.01 && b > 3.0 * r && b > 1.5 * g;
    let blue = [&fine, &coarse].map(|image| display::share(image, [0.4, 0.1, 0.95, 0.7], is_blue));
    assert!(blue.iter().all(|share| *share > 0.01), "{blue:?}");
    assert!(display::difference(&fine, &coarse) > 0.001, "{}", display::difference(&fine, &coarse));
    assert!(display::difference(&coarse, &later) > 0.001, "{}", display::difference(&coarse, &later));
}
