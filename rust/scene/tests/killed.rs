//! Pictures of strokes that were made in one go and of the same strokes by programs that were killed and begun again.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use glam::DVec3;
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_detail::{
    Action, DisplacedObject, Falloff, History, LayeredObject, PaintMode, SculptMode, Stroke, StrokePoint,
    StrokeSettings,
};
use relievo_document::Document;
use relievo_scene::file::{parse, read_file};
use relievo_scene::stepper::{RunOptions, run};
use relievo_scene::world::World;

const LIMIT: u64 = 1 << 30;
const STROKES: usize = 12;
const SCENE: &str = r##"version = 1
[meshes.ground]
shape = "plane"
size = [4, 4, 1]
faces = 4
[surfaces.ground]
mesh = "ground"
[details]
tile_size = 32
paint_size = 32
[objects.ground]
surface = "ground"
[[objects.ground.layers]]
name = "colours"
kind = "colour"
[output]
width = 128
height = 96
frames = 1
mesh = "none"
"##;

fn stroke(number: usize) -> Stroke {
    let y = -1.6 + 0.28 * number as f64;
    let points = (0..6).map(|i| StrokePoint::new(DVec3::new(-1.5 + 0.6 * f64::from(i), y, 0.0), 1.0)).collect();
    let action = match number % 3 {
        0 => Action::Sculpt { mode: SculptMode::Draw, height: 0.05 },
        1 => Action::Paint { mode: PaintMode::Mix, color: [0.9, 0.05 * number as f32, 0.1, 1.0] },
        _ => Action::Sculpt { mode: SculptMode::Smooth, height: 0.0 },
    };
    Stroke::new(points, StrokeSettings { radius: 0.35, ..StrokeSettings::default() }, Falloff::Smooth, action)
}

fn world(context: &Context) -> World {
    World::new(context, parse(Path::new("killed.toml"), SCENE).unwrap(), &[]).unwrap()
}

fn document(context: &Context, world: &mut World) -> Document {
    let mut document = Document::new(world.cage(0), context.level().name()).unwrap();
    surface(world).store(context, &mut document).unwrap();
    document
}

fn surface(world: &mut World) -> &mut DisplacedObject {
    world.surface_mut(0).unwrap()
}

/// The process that is killed: it makes the strokes that are still to be made.
#[test]
fn strokes_until_it_is_killed() {
    let Some(path) = std::env::var_os("RELIEVO_TEST_STROKES") else { return };
    let context = Context::serial();
    let mut world = world(&context);
    let (document, mut history) = History::open(Path::new(&path), LIMIT, LIMIT).unwrap();
    let surface = surface(&mut world);
    assert!(surface.take_up(&context, &document, LIMIT).unwrap().is_empty());
    for number in history.undo_count()..STROKES {
        history.begin(&context, surface, &format!("stroke {number}")).unwrap();
        stroke(number).apply(&context, surface).unwrap();
        history.end(&context, surface).unwrap().unwrap();
    }
}

/// The picture of a scene whose object starts from `document`.
fn picture(folder: &Path, document: &Path) -> Vec<u8> {
    let name = document.file_stem().unwrap().to_str().unwrap();
    let scene = folder.join(format!("{name}.toml"));
    let from = format!("surface = \"ground\"\ndocument = \"{name}.relievo\"\n");
    std::fs::write(&scene, SCENE.replace("surface = \"ground\"\n", &from)).unwrap();
    let options = RunOptions { out: folder.join(name), frames: None, allowed: Vec::new(), rebake: false };
    let done = run(&Context::serial(), read_file(&scene).unwrap(), &options, &mut Silent).unwrap();
    let png: &PathBuf = done.files.iter().find(|file| file.extension().is_some_and(|e| e == "png")).unwrap();
    std::fs::read(png).unwrap()
}

#[test]
fn pictures_are_the_same_after_kills_in_the_middle_of_strokes() {
    let context = Context::serial();
    let folder = tempfile::tempdir().unwrap();
    let [at_once, killed, bare] =
        ["at-once", "killed", "bare"].map(|name| folder.path().join(format!("{name}.relievo")));
    let mut whole = world(&context);
    let empty = document(&context, &mut whole);
    empty.write(&killed).unwrap();
    empty.write(&bare).unwrap();
    for number in 0..STROKES {
        stroke(number).apply(&context, surface(&mut whole)).unwrap();
    }
    let expected = document(&context, &mut whole);
    expected.write(&at_once).unwrap();
    let mut kills = 0;
    loop {
        let length = std::fs::metadata(&killed).unwrap().len();
        // Each may write so much, and is killed at the byte after that.
        let bytes = length + 4000 + 977 * kills;
        let status = Command::new("prlimit")
            .arg(format!("--fsize={bytes}"))
            .args(["--core=0", "--"])
            .arg(std::env::current_exe().unwrap())
            .args(["--exact", "strokes_until_it_is_killed", "--test-threads=1"])
            .env("RELIEVO_TEST_STROKES", &killed)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status();
        let Ok(status) = status else {
            println!("skipped: kills at a byte need `prlimit`");
            return;
        };
        if status.success() {
            break;
        }
        kills += 1;
        assert!(kills < 200, "it gets no further");
    }
    assert!(kills > 3, "{kills}");
    let found = Document::open(&killed, LIMIT).unwrap();
    assert_eq!(found.layers(), expected.layers());
    let [a, b, c] = [&at_once, &killed, &bare].map(|path| picture(folder.path(), path));
    // To the bit, which is nearer than one in 255.
    assert!(a == b && a != c);
}
