//! Pictures of strokes that were made in one go and of the same strokes by programs that were killed and begun again;
//! and what is left of strokes that fade, on both kinds of surfaces.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use glam::DVec3;
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_detail::{
    Action, Canvas, DecayingObject, DisplacedObject, Falloff, History, LayeredObject, PaintMode, Recorded, SculptMode,
    Stroke, StrokePoint, StrokeSettings, TriangleObject,
};
use relievo_document::Document;
use relievo_scene::file::{parse, read_file};
use relievo_scene::stepper::{RunOptions, run};
use relievo_scene::world::World;

#[macro_use]
#[path = "scene/texts.rs"]
mod texts;

const LIMIT: u64 = 1 << 30;
const STROKES: usize = 12;
const SCENE: &str = concat!(
    "version = 1\n",
    ground!("4", "4"),
    r##"[details]
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
"##,
);

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

/// When a stroke that fades is made, seconds.
fn time(number: usize) -> f64 {
    0.25 * number as f64
}

/// An object whose edits fade, some of them before all strokes are made.
trait Fades: LayeredObject + Canvas {
    const SCENE: &str;

    fn of(world: &mut World) -> &mut Self;

    fn empty(world: &World) -> Document;
}

impl Fades for DisplacedObject {
    const SCENE: &str = "decay = { delay = 0.2, duration = 1.1 }\n";

    fn of(world: &mut World) -> &mut Self {
        world.surface_mut(0).unwrap()
    }

    fn empty(world: &World) -> Document {
        Document::new(world.cage(0), "baseline").unwrap()
    }
}

impl Fades for TriangleObject {
    const SCENE: &str = "decay = { delay = 0.2, duration = 1.1 }\n[surfaces.ground]\nkind = \"triangles\"\n";

    fn of(world: &mut World) -> &mut Self {
        &mut world.triangles_mut(0).unwrap().object
    }

    fn empty(world: &World) -> Document {
        Document::of_triangles(world.cage(0), "baseline").unwrap()
    }
}

fn fading_world<O: Fades>(context: &Context) -> World {
    let scene = match O::SCENE.split_once("[surfaces.ground]\n") {
        None => SCENE.replace("surface = \"ground\"\n", &format!("surface = \"ground\"\n{}", O::SCENE)),
        Some((decay, kind)) => SCENE
            .replace("mesh = \"ground\"\n", &format!("mesh = \"ground\"\n{kind}"))
            .replace("surface = \"ground\"\n", &format!("surface = \"ground\"\n{decay}")),
    };
    World::new(context, parse(Path::new("fading.toml"), &scene).unwrap(), &[]).unwrap()
}

/// What there is of it at `time`, with its stamps.
fn faded<O: Fades>(context: &Context, world: &mut World, time: f64) -> Document {
    let mut document = O::empty(world);
    let object = O::of(world);
    object.advance(context, time).unwrap();
    object.states(context).unwrap();
    object.store(context, &mut document).unwrap();
    document
}

fn make_fading<O: Fades>(context: &Context, world: &mut World, number: usize) {
    let object = O::of(world);
    object.advance(context, time(number)).unwrap();
    stroke(number).apply(context, object).unwrap();
}

/// As the process that is killed makes it: from the document, to which it goes.
fn go_on_fading<O: Fades>(context: &Context, path: &Path) {
    let mut world = fading_world::<O>(context);
    limit_files();
    let (document, mut history) = History::open(path, LIMIT, LIMIT).unwrap();
    assert!(O::of(&mut world).take_up(context, &document, LIMIT).unwrap().is_empty());
    for number in history.undo_count()..STROKES {
        O::of(&mut world).advance(context, time(number)).unwrap();
        history.begin(context, O::of(&mut world), &format!("stroke {number}")).unwrap();
        make_fading::<O>(context, &mut world, number);
        history.end(context, O::of(&mut world)).unwrap().unwrap();
    }
}

/// Runs the process again and again until it has made all strokes: each may write so much, and is killed at the byte
/// after that. `None` if that cannot be.
fn kill(path: &Path, what: &str) -> Option<u64> {
    if Command::new("prlimit").arg("--version").stdout(Stdio::null()).status().is_err() {
        println!("skipped: kills at a byte need `prlimit`");
        return None;
    }
    let mut kills = 0;
    loop {
        let length = std::fs::metadata(path).unwrap().len();
        let bytes = length + 4000 + 977 * kills;
        let status = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "strokes_until_it_is_killed", "--test-threads=1"])
            .env("RELIEVO_TEST_STROKES", path)
            .env("RELIEVO_TEST_FADING", what)
            .env("RELIEVO_TEST_BYTES", bytes.to_string())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status();
        if status.unwrap().success() {
            return Some(kills);
        }
        kills += 1;
        assert!(kills < 200, "it gets no further");
    }
}

/// Lets the system end this process where it writes a file beyond the bytes that it may. Surfaces are made before: what
/// the library itself keeps in files in memory would be such a file.
fn limit_files() {
    let bytes = std::env::var("RELIEVO_TEST_BYTES").unwrap();
    let limits = [format!("--pid={}", std::process::id()), format!("--fsize={bytes}"), "--core=0".into()];
    assert!(Command::new("prlimit").args(limits).status().unwrap().success());
}

/// The process that is killed: it makes the strokes that are still to be made.
#[test]
fn strokes_until_it_is_killed() {
    let Some(path) = std::env::var_os("RELIEVO_TEST_STROKES") else { return };
    let context = Context::serial();
    match std::env::var("RELIEVO_TEST_FADING").as_deref() {
        Ok("tiles") => return go_on_fading::<DisplacedObject>(&context, Path::new(&path)),
        Ok("triangles") => return go_on_fading::<TriangleObject>(&context, Path::new(&path)),
        _ => {}
    }
    let mut world = world(&context);
    limit_files();
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
    let options = RunOptions { out: folder.join(name), frames: None, allowed: Vec::new(), rebake: false, device: None };
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
    let Some(kills) = kill(&killed, "") else { return };
    assert!(kills > 3, "{kills}");
    let found = Document::open(&killed, LIMIT).unwrap();
    assert_eq!(found.layers(), expected.layers());
    let [a, b, c] = [&at_once, &killed, &bare].map(|path| picture(folder.path(), path));
    // To the bit, which is nearer than one in 255.
    assert!(a == b && a != c);
}

fn fades_on_after_kills<O: Fades>(what: &str) {
    let context = Context::serial();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("killed.relievo");
    let mut whole = fading_world::<O>(&context);
    faded::<O>(&context, &mut whole, 0.0).write(&path).unwrap();
    for number in 0..STROKES {
        make_fading::<O>(&context, &mut whole, number);
    }
    let Some(kills) = kill(&path, what) else { return };
    assert!(kills > 3, "{kills}");
    // With all edits of the journal, whatever of them has faded.
    let mut opened = fading_world::<O>(&context);
    let (document, mut history) = History::open(&path, LIMIT, LIMIT).unwrap();
    O::of(&mut opened).take_up(&context, &document, LIMIT).unwrap();
    assert_eq!(O::of(&mut opened).time(), time(STROKES - 1));
    for after in [0.1, 0.5] {
        let time = time(STROKES - 1) + after;
        let [a, b] = [&mut whole, &mut opened].map(|world| faded::<O>(&context, world, time));
        assert!(a.layers().iter().any(|layer| layer.name().starts_with("stamps") && !layer.blocks().is_empty()));
        assert!(a.to_bytes().unwrap() == b.to_bytes().unwrap(), "{what} {after}");
    }
    // Undone to the start and made again, it is what it was.
    let end = time(STROKES - 1) + 0.6;
    let there = faded::<O>(&context, &mut opened, end);
    while history.undo(&context, O::of(&mut opened)).unwrap().is_some() {}
    let start = faded::<O>(&context, &mut opened, end);
    assert!(start.layers().iter().all(|layer| layer.blocks().is_empty()));
    while history.redo(&context, O::of(&mut opened)).unwrap().is_some() {}
    let again = faded::<O>(&context, &mut opened, end);
    assert!(again.to_bytes().unwrap() == there.to_bytes().unwrap());
}

#[test]
fn tiles_fade_on_after_kills_as_if_there_had_been_none() {
    fades_on_after_kills::<DisplacedObject>("tiles");
}

#[test]
fn triangles_fade_on_after_kills_as_if_there_had_been_none() {
    fades_on_after_kills::<TriangleObject>("triangles");
}
