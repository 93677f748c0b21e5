//! Crowds that press into surfaces.

use std::path::Path;

use relievo_core::Context;
use relievo_scene::file::{parse, read_file};
use relievo_scene::stepper::Summary;
use relievo_scene::world::World;
use relievo_testing::{Limb, write_limbs};

use crate::support::{bytes, run_in};

/// A field of snow in a scene with y up, as crowds have it.
const FIELD: &str = "version = 1\nup = \"y\"\nfps = 10\n[meshes.snow]\nshape = \"plane\"\nsize = [4, 4, 1]\nfaces = 8\n\
    [surfaces.snow]\nmesh = \"snow\"\n[objects.snow]\nsurface = \"snow\"\n[details]\ntile_size = 32\n\
    [imprints]\nmax_displacement = 0.2\n[output]\nframes = 21\npictures = []\nmesh = \"last\"\nmesh_formats = [\"obj\"]\n\
    mesh_rate = 32\n";

/// Lets the crowd of a file press into the snow.
fn crowd(file: &str) -> String {
    format!(
        "[[crowds]]\nname = \"walkers\"\nfile = \"{file}\"\nagents = \"agents.txt\"\n[colliders.feet]\ncrowd = \"walkers\"\n"
    )
}

/// A block of 0.6 × 0.2 × 0.6 units whose lower side is 0.05 units below 0.
const BLOCK: &str = "v -0.3 -0.05 -0.3\nv 0.3 -0.05 -0.3\nv -0.3 0.15 -0.3\nv 0.3 0.15 -0.3\n\
    v -0.3 -0.05 0.3\nv 0.3 -0.05 0.3\nv -0.3 0.15 0.3\nv 0.3 0.15 0.3\n\
    f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

/// A foot that stands for half a second while its body goes on by half a unit, and is lifted over the next half.
fn foot() -> Limb {
    let mut foot = Limb {
        times: vec![0.0, 0.5, 0.5 + 1.0 / 30.0, 1.0 - 1.0 / 30.0, 1.0],
        places: vec![[0.0, 0.0, 0.25], [0.0, 0.0, -0.25], [0.0, 0.4, -0.25], [0.0, 0.4, 0.25], [0.0, 0.0, 0.25]],
        turns: vec![[0.0, 0.0, 0.0, 1.0]; 5],
        ..Limb::default()
    };
    foot.add_box([-0.1, -0.05, -0.1], [0.1, 0.3, 0.1]);
    foot
}

fn write(folder: &Path, agents: &str) {
    std::fs::write(folder.join("block.obj"), BLOCK).unwrap();
    write_limbs(&folder.join("foot.gltf"), &[foot()]);
    std::fs::write(folder.join("agents.txt"), agents).unwrap();
}

/// Points of the mesh of the snow that a run wrote last.
fn points(folder: &Path, name: &str, frame: u32) -> Vec<[f64; 3]> {
    let text = String::from_utf8(bytes(folder, name, &format!("mesh-{frame:06}-snow.obj"))).unwrap();
    let numbers = |line: &str| line.split(' ').map(|number| number.parse().unwrap()).collect::<Vec<f64>>();
    text.lines().filter_map(|line| line.strip_prefix("v ")).map(|line| numbers(line)[..3].try_into().unwrap()).collect()
}

/// How often a stage ran.
fn calls(summary: &Summary, stage: &str) -> usize {
    summary.trace.costs().iter().find(|cost| cost.stage == stage).map_or(0, |cost| cost.calls)
}

#[test]
fn an_agent_that_stands_presses_as_its_mesh_does() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "0.3 0 0.2 0 1 0 0\n");
    let field = FIELD.replace("frames = 21", "frames = 2");
    run_in(folder, "agent", &format!("{field}{}", crowd("block.obj")), None, 1);
    let mesh = "[meshes.block]\nfile = \"block.obj\"\n[objects.block]\nmesh = \"block\"\ntranslation = [0.3, 0, 0.2]\n\
        visible = false\n[colliders.block]\n";
    run_in(folder, "mesh", &format!("{field}{mesh}"), None, 1);
    let [agent, mesh] = ["agent", "mesh"].map(|name| points(folder, name, 1));
    assert!(agent.iter().any(|point| (point[1] + 0.05).abs() < 1e-3), "nothing was pressed");
    // The mesh has its points in another order, by which the box, and so the voxels, may turn.
    assert_eq!(agent.len(), mesh.len());
    let farthest = agent.iter().zip(&mesh).flat_map(|(a, b)| (0..3).map(|axis| (a[axis] - b[axis]).abs()));
    let farthest = farthest.fold(0.0, f64::max);
    assert!(farthest < 1e-4, "{farthest}");
}

#[test]
fn a_walking_agent_leaves_prints_where_its_foot_stands() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // It walks a unit a second along z from -1, with its foot 0.25 before it when it comes down.
    write(folder, "0 0 -1 0 1 0 0 0 1\n");
    run_in(folder, "walk", &format!("{FIELD}{}", crowd("foot.gltf")), None, 2);
    let pressed: Vec<[f64; 3]> = points(folder, "walk", 20).into_iter().filter(|point| point[1] < -0.01).collect();
    for stand in [-0.75, 0.25, 1.25] {
        let depth = |point: &&[f64; 3]| point[0].abs() < 0.06 && (point[2] - stand).abs() < 0.06;
        let under: Vec<f64> = pressed.iter().filter(depth).map(|point| point[1]).collect();
        assert!(!under.is_empty() && under.iter().all(|depth| (depth + 0.05).abs() < 0.01), "{stand}: {under:?}");
    }
    // A foot that is lifted within a thirtieth of a second drags by as much as the body goes meanwhile.
    let is_print =
        |[x, _, z]: &[f64; 3]| x.abs() < 0.15 && [-0.75, 0.25, 1.25].iter().any(|stand| (z - stand).abs() < 0.2);
    assert!(pressed.iter().all(is_print), "{:?}", pressed.iter().find(|point| !is_print(point)));
}

#[test]
fn agents_far_away_are_neither_posed_nor_pressed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let field = FIELD.replace("frames = 21", "frames = 6");
    let scene = format!("{field}{}", crowd("foot.gltf"));
    write(folder, "0 0 -1 0 1 0 0 0 1\n");
    let alone = run_in(folder, "alone", &scene, None, 1);
    let far: String = (0..200).map(|at| format!("{at} 0 {} 0 1 0 0 0 1\n", 4 + at / 10)).collect();
    write(folder, &format!("0 0 -1 0 1 0 0 0 1\n{far}"));
    let with_others = run_in(folder, "others", &scene, None, 1);
    for stage in ["imprint.obb", "collider.refit", "imprint.raycast"] {
        assert!(calls(&alone, stage) > 0, "{stage}");
        assert_eq!(calls(&alone, stage), calls(&with_others, stage), "{stage}");
    }
    assert_eq!(points(folder, "alone", 5), points(folder, "others", 5));
}

#[test]
fn a_run_that_goes_on_has_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "0 0 -1 0 1 0 0 0 1\n0.3 0 -1.2 10 1.1 0 0.3 0 0.8\n");
    let field = FIELD.replace("frames = 21", "frames = 9");
    let scene = format!("{field}{}triangles = 1000\nrim = 0.5\nrim_width = 0.1\n", crowd("foot.gltf"));
    run_in(folder, "whole", &scene, None, 2);
    run_in(folder, "parts", &scene, Some((0, 3)), 1);
    let rest = run_in(folder, "parts", &scene, None, 1);
    assert_eq!((rest.opened, rest.baked), (4, 5));
    let file = "mesh-000008-snow.obj";
    assert_eq!(bytes(folder, "whole", file), bytes(folder, "parts", file));
    // Other agents are another scene.
    std::fs::write(folder.join("agents.txt"), "0 0 -1 0 1 0 0 0 1\n").unwrap();
    let other = run_in(folder, "parts", &scene, None, 1);
    assert_eq!(other.baked, 9);
    assert_ne!(bytes(folder, "whole", file), bytes(folder, "parts", file));
}

#[test]
fn a_surface_that_carries_the_agents_is_not_scratched() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // The snow goes along as fast as the block that stands on it.
    write(folder, "0 0 -1 0 1 0 0 0 1\n");
    let field = FIELD.replace("frames = 21", "frames = 11");
    let body = "[bodies.snow]\nshape = \"none\"\nkeyframes = [{ time = 0 }, { time = 1, translation = [0, 0, 1] }]\n";
    run_in(folder, "carried", &format!("{field}{body}{}", crowd("block.obj")), None, 1);
    let pressed: Vec<[f64; 3]> = points(folder, "carried", 10).into_iter().filter(|point| point[1] < -0.01).collect();
    assert!(!pressed.is_empty());
    // The snow began at 0 and the block at -1: at the end the block is at 0.
    assert!(pressed.iter().all(|[x, _, z]| x.abs() < 0.35 && z.abs() < 0.35), "{:?}", pressed[0]);
}

#[test]
fn triangles_give_way_to_agents_too() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "0.3 0 0.2 0 1 0 0\n");
    let field = FIELD
        .replace("frames = 21", "frames = 1")
        .replace("mesh = \"snow\"\n[objects", "mesh = \"snow\"\nkind = \"triangles\"\n[objects");
    let field = field.replace("tile_size = 32", "tile_size = 32\nsegments = 32");
    run_in(folder, "triangles", &format!("{field}{}", crowd("block.obj")), None, 1);
    let pressed: Vec<[f64; 3]> = points(folder, "triangles", 0).into_iter().filter(|point| point[1] < -0.01).collect();
    assert!(!pressed.is_empty());
    assert!(pressed.iter().all(|[x, _, z]| (x - 0.3).abs() < 0.35 && (z - 0.2).abs() < 0.35));
}

#[test]
fn unusable_colliders_of_crowds_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "0 0 0 0 1 0 0\n");
    let good = format!("{FIELD}{}", crowd("block.obj"));
    let more = "[colliders.more]\ncrowd = \"walkers\"\n";
    let second = "[[crowds]]\nname = \"walkers\"\nfile = \"block.obj\"\nagents = \"agents.txt\"\n";
    let block =
        "[meshes.block]\nfile = \"block.obj\"\n[objects.block]\nmesh = \"block\"\n[colliders.block]\ntriangles = 9\n";
    let cases = [
        (good.replace("crowd = \"walkers\"", "crowd = \"walker\""), "did you mean `walkers`?"),
        (good.replace("name = \"walkers\"\n", ""), "give the crowd `name = \"walkers\"`"),
        (format!("{good}object = \"snow\"\n"), "either an object or a crowd"),
        (format!("{good}tool = {{ force = [0, 0, -1] }}\n"), "a force cannot press a crowd"),
        (format!("{good}triangles = 0\n"), "`triangles` is out of range"),
        (format!("{good}{more}"), "two colliders press the same crowd"),
        (format!("{good}{second}"), "two crowds are called `walkers`"),
        (format!("{good}{block}"), "`triangles` means nothing for an object"),
    ];
    let path = folder.join("scene.toml");
    for (text, word) in cases {
        let faults = parse(&path, &text).unwrap_err().to_string();
        assert!(faults.contains(word), "{word}: {faults}");
    }
    std::fs::write(&path, &good).unwrap();
    World::new(&Context::serial(), read_file(&path).unwrap(), &[]).unwrap();
}
