//! `[[crowds]]` of scenes.

use relievo_core::Context;
use relievo_render::{Image, read_png};
use relievo_scene::file::{parse, read_file};
use relievo_scene::world::World;

use crate::support::run_in;

const SCENE: &str = concat!(
    r##"version = 1
fps = 10
[meshes.ground]
shape = "plane"
size = [4, 4, 1]
[objects.ground]
mesh = "ground"
colour = [0.5, 0.5, 0.5]
"##,
    seen_from_above!(),
    r##"samples = 1
pictures = ["beauty"]
mesh = "none"
[[crowds]]
file = "block.obj"
agents = "agents.txt"
colour = [0.8, 0.02, 0.02]
"##,
);

/// A block of 0.6 × 0.2 × 0.6 units whose lower side is at the height 0, with y up.
const BLOCK: &str = "v -0.3 0 -0.3\nv 0.3 0 -0.3\nv -0.3 0.2 -0.3\nv 0.3 0.2 -0.3\n\
    v -0.3 0 0.3\nv 0.3 0 0.3\nv -0.3 0.2 0.3\nv 0.3 0.2 0.3\n\
    f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

fn write(folder: &std::path::Path, agents: &str) {
    std::fs::write(folder.join("block.obj"), BLOCK).unwrap();
    std::fs::write(folder.join("agents.txt"), agents).unwrap();
}

/// Returns the columns whose pixel is red in a row of a picture.
fn red(image: &Image, row: u32) -> Vec<u32> {
    let is_red = |column: &u32| {
        let [red, green, _] = image.color(*column, row);
        red > 3.0 * green
    };
    (0..image.width()).filter(is_red).collect()
}

#[test]
fn agents_walk_through_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // One walks along x, which is x of the scene; one stands at z = 1, which is y = -1 where z is up.
    write(folder, "1 0 0 90 1 0 0 0 8\n1 0 1 0 1 rest 0\n");
    run_in(folder, "walk", SCENE, None, 2);
    let picture =
        |name: &str, frame: u32| read_png(&folder.join(format!("{name}/beauty-{frame:06}.png")), u64::MAX).unwrap();
    let middle = |frame: u32| {
        let columns = red(&picture("walk", frame), 32);
        assert!((6..=12).contains(&columns.len()), "{columns:?}");
        f64::from(columns[0] + columns[columns.len() - 1]) / 2.0
    };
    // A unit of the top of the block is 32 / (5.8 tan 0.35) pixels.
    let pixels = 32.0 / (5.8 * 0.35f64.tan());
    for (frame, place) in [(0, 0.0), (1, 0.8), (2, 1.6)] {
        let (found, wanted) = (middle(frame), 31.5 + pixels * place);
        assert!((found - wanted).abs() <= 1.5, "frame {frame}: {found} is not {wanted}");
        assert!(red(&picture("walk", frame), 32 + pixels as u32).contains(&32));
    }
    // A later frame alone is the same picture.
    run_in(folder, "late", SCENE, Some((2, 2)), 1);
    assert_eq!(picture("late", 2), picture("walk", 2));
}

#[test]
fn agents_out_of_sight_throw_shadows_into_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // The sun is at the side of x, where an agent stands beside the picture; its shadow is 0.55 units long.
    let scene = SCENE.replace("[camera]", "[sun]\nelevation = 20\nazimuth = 0\n[camera]");
    let brightness = |name: &str, agents: &str| {
        write(folder, agents);
        run_in(folder, name, &scene, Some((0, 0)), 1);
        let picture = read_png(&folder.join(format!("{name}/beauty-000000.png")), u64::MAX).unwrap();
        let place = |row: u32| (58..61).map(move |column| (column, row));
        (29..35).flat_map(place).map(|(column, row)| picture.color(column, row)[1]).sum::<f32>()
    };
    let (lit, dark) = (brightness("lit", "30 0 0 0 1 0 0\n"), brightness("dark", "3.6 0 0 0 1 0 0\n"));
    assert!(dark < 0.8 * lit, "{dark} of {lit}");
}

#[test]
fn unusable_crowds_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let refused = |text: &str, agents: &str, word: &str| {
        write(folder, agents);
        let path = folder.join("scene.toml");
        std::fs::write(&path, text).unwrap();
        let scene = match parse(&path, text) {
            Err(faults) => return assert!(faults.to_string().contains(word), "{faults}"),
            Ok(_) => read_file(&path).unwrap(),
        };
        let failure = World::new(&Context::serial(), scene, &[]).unwrap_err().to_string();
        assert!(failure.contains(word), "{failure}");
    };
    refused(SCENE, "1 0 0 90 1 0 0\n1 0 0 90 1 jump 0\n", "line 2");
    refused(SCENE, "1 0 0 90 0 0 0\n", "agent 0");
    refused(&SCENE.replace("block.obj", "blok.obj"), "", "block.obj");
    refused(&SCENE.replace("agents = \"agents.txt\"\n", ""), "", "`agents`");
    refused(&format!("{SCENE}pixels = 0\n"), "", "pixels");
    refused(&format!("{SCENE}clip = \"walk\"\n"), "", "walk");
}
