//! Any bytes as the recipe of a decal: refused, or a recipe that is written as it was read and can be laid on a mesh and on the
//! faces of a displaced triangle mesh, or not, with a reason. Sums are made right, so that what is behind them is read.
#![no_main]

use std::sync::LazyLock;

use glam::DAffine3;
use libfuzzer_sys::fuzz_target;
use relievo_core::progress::Silent;
use relievo_core::{Context, Mesh};
use relievo_decal::{DecalSettings, Ink, Pin, Place, Pose, Printable, Recipe, Sticker};
use relievo_detail::TriangleObject;
use relievo_document::Settings;
use relievo_surface::TriangleSurface;
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions, TriangleTessellation};

/// Bytes before those that the sum is of.
const HEAD: usize = 20;
/// Triangles, pins and corners of decals that are laid.
const MAX: usize = 64;

static SOUND: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let pin = |x: f64, face: u32| Pin { image: [x, 3.0], place: Place { face, barycentric: [0.2, 0.3, 0.5] } };
    let recipe = Recipe {
        sticker: Sticker::whole([8, 8]).expect("a sticker"),
        image: 1,
        pins: vec![pin(2.0, 0), pin(5.0, 3)],
        depths: vec![0.0, 1.0],
        pose: Some(Pose { width: 1.0, up: [0.0, 1.0, 0.0] }),
        settings: DecalSettings::default(),
        cells: 4,
        layer: 2,
        ink: Ink::Relief(0.5),
        seen: Settings::of(Ink::Relief(0.5).kind()),
    };
    recipe.encode()
});

/// A sheet of 32 triangles.
static SHEET: LazyLock<Mesh> = LazyLock::new(|| {
    let points = (0..25).map(|at| [(at % 5) as f32, (at / 5) as f32, 0.1 * (at % 3) as f32]).collect();
    let cells = (0..16).map(|cell| cell / 4 * 5 + cell % 4);
    let triangles: Vec<[u32; 3]> = cells.flat_map(|at| [[at, at + 1, at + 6], [at, at + 6, at + 5]]).collect();
    Mesh::from_triangles(points, &triangles)
});

/// The triangles of the sheet as an object.
static TRIANGLES: LazyLock<TriangleTessellation> = LazyLock::new(|| {
    let context = Context::serial();
    let surface = TriangleSurface::new(&context, &SHEET).expect("a surface");
    let options = TriangleOptions { segments: 8, budget: u64::MAX };
    let displacement = TriangleChannel::displacement(surface.topology().clone(), &options).expect("displacement");
    let mut object = TriangleObject::new(&context, surface, displacement, DAffine3::IDENTITY).expect("an object");
    object.triangles(&context, &SHEET, 1).expect("triangles")
});

fuzz_target!(|data: &[u8]| {
    match data.split_first() {
        Some((1, changes)) => read(&sealed(&changed(changes))),
        Some((2, rest)) => read(&sealed(&[&SOUND[..HEAD], rest].concat())),
        _ => read(data),
    }
});

/// A sound recipe with some bytes changed: two that give the place, one what it becomes.
fn changed(changes: &[u8]) -> Vec<u8> {
    let mut bytes = SOUND.clone();
    for change in changes.as_chunks::<3>().0 {
        let place = usize::from(u16::from_le_bytes([change[0], change[1]])) % bytes.len();
        bytes[place] = change[2];
    }
    bytes
}

/// With the length and the sum that its bytes have.
fn sealed(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let (length, crc) = ((bytes.len() - HEAD) as u32, crc32fast::hash(&bytes[HEAD..]));
    bytes[12..16].copy_from_slice(&length.to_le_bytes());
    bytes[16..HEAD].copy_from_slice(&crc.to_le_bytes());
    bytes
}

fn read(bytes: &[u8]) {
    let Ok(mut recipe) = Recipe::decode(bytes) else { return };
    assert!(Recipe::is_one(bytes) && recipe.encode() == bytes, "it is written as it was read");
    if recipe.pins.len() > MAX || bytes.len() > 64 * MAX {
        return;
    }
    recipe.settings.triangles = recipe.settings.triangles.min(MAX as u32);
    recipe.settings.steps = recipe.settings.steps.min(4);
    let on_triangles = recipe.lay_on::<TriangleObject>(&TRIANGLES, &mut Silent);
    for laid in [recipe.lay(&SHEET, &mut Silent), on_triangles] {
        if let Err(error) = laid {
            assert!(!error.what.is_empty());
        }
    }
}
