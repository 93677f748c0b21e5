//! Any bytes as a journal of edits, and sound records of inputs with some of their bytes changed. They are refused, or the
//! edits are made, at every level, and taken back.
#![no_main]

use std::path::PathBuf;
use std::sync::{Arc, LazyLock};

use glam::DVec3;
use libfuzzer_sys::fuzz_target;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Falloff};
use relievo_detail::{
    Action, SculptMode, Stamp, StampChannel, StampImage, StampSettings, Stroke, StrokePoint, StrokeSettings,
};
use relievo_document::Journal;
use relievo_fuzz::MEMORY_LIMIT;
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, BuildOptions, Cut, Edit, EditJournal, Handle, Region};

/// Bytes of the head of a journal, and around the payload of a record.
const HEAD: usize = 24;
const RECORD: usize = 28;
const TAIL: usize = 4;

/// A file of this process.
static FILE: LazyLock<PathBuf> =
    LazyLock::new(|| std::env::temp_dir().join(format!("relievo-fuzz-{}.journal", std::process::id())));

struct Sound {
    mesh: Arc<Progressive>,
    head: Vec<u8>,
    /// What a journal says that edits are going to be.
    inputs: Vec<Vec<u8>>,
}

static SOUND: LazyLock<Sound> = LazyLock::new(|| {
    let context = Context::serial();
    let height = |x: u32, y: u32| ((x * 7 + y * 11) % 5) as f32 * 0.3;
    let points: Vec<_> =
        (0..100).map(|at| (at % 10, at / 10)).map(|(x, y)| [x as f32, y as f32, height(x, y)]).collect();
    let squares = (0..90u32).filter(|at| at % 10 < 9);
    let triangles: Vec<_> = squares.flat_map(|at| [[at, at + 1, at + 11], [at, at + 11, at + 10]]).collect();
    let options = BuildOptions { faces: 8, ..BuildOptions::default() };
    let mesh = Arc::new(Progressive::build(&context, &points, &triangles, &options, &mut Silent).expect("a mesh"));
    let mut active = ActiveMesh::new(&mesh);
    active.adapt(&context, Cut::of_faces(&mesh, 80));
    _ = std::fs::remove_file(&*FILE);
    let (mut journal, _) = EditJournal::open(&context, &FILE, &mut active).expect("a journal");
    let region = Region { center: [4.0, 4.0, 0.5], radius: 3.0, falloff: Falloff::Smooth };
    let handle = Handle { region, translation: [0.0, 0.0, 1.0], axis: [0.0, 0.0, 1.0], angle: 0.5 };
    let edit = Edit { handles: vec![handle], anchors: vec![Region { radius: 0.5, ..region }] };
    journal.edit(&context, &mut active, &edit).expect("an edit");
    let settings = StrokeSettings { radius: 2.0, ..StrokeSettings::default() };
    let way = [2.0, 6.0].map(|x| StrokePoint::new(DVec3::new(x, 4.0, 0.5), 1.0)).to_vec();
    let action = Action::Sculpt { mode: SculptMode::Draw, height: 0.2 };
    let image = StampImage::new(2, 2, 1, &[0.2, 0.4, 0.6, 0.8]).expect("an image");
    let stamp = Stamp::new(image, StampSettings::default(), StampChannel::Red).expect("a stamp");
    let mut stroke = Stroke::new(way, settings, Falloff::Smooth, action);
    for stamp in [None, Some(stamp.clone()), Some(stamp)] {
        stroke.stamp = stamp;
        journal.sculpt(&context, &mut active, &stroke).expect("a stroke");
    }
    drop(journal);
    let file = std::fs::read(&*FILE).expect("a file of ours");
    let (head, mut rest) = file.split_at(HEAD);
    let mut inputs = Vec::new();
    while !rest.is_empty() {
        let length = u64::from_le_bytes(rest[16..24].try_into().expect("eight bytes")) as usize;
        if rest[4] == 1 {
            inputs.push(rest[RECORD..RECORD + length].to_vec());
        }
        rest = &rest[RECORD + length + TAIL..];
    }
    Sound { mesh, head: head.to_vec(), inputs }
});

fuzz_target!(|data: &[u8]| {
    let sound = &*SOUND;
    match data.split_first() {
        Some((1, said)) => write(sound, said),
        _ => std::fs::write(&*FILE, [&sound.head[..], data].concat()).expect("a file of ours"),
    }
    let context = Context::new(&ContextOptions { threads: 1, memory_limit: MEMORY_LIMIT }).expect("one thread");
    let mut active = ActiveMesh::new(&sound.mesh);
    let base = active.extract();
    let Ok((mut journal, found)) = EditJournal::open(&context, &FILE, &mut active) else {
        assert!(active.edits() == [0, 0] && active.extract() == base);
        return;
    };
    assert_eq!(active.edits(), [found.edits.len(), found.undone]);
    for cut in [Cut::FINEST, Cut::of_error(0.1), Cut::BASE] {
        active.adapt(&context, cut);
        let made = active.extract();
        assert!(made.triangles.as_flattened().iter().all(|vertex| (*vertex as usize) < made.points.len()));
    }
    for _ in &found.edits {
        assert!(journal.undo(&context, &mut active).expect("a file that can be written"));
    }
    assert!(!journal.undo(&context, &mut active).expect("a file that can be written"));
});

/// Writes a journal of up to six records. Of an edit the first byte says what it is, the next how many of its bytes are
/// changed, and for each of these two tell the place and one what it becomes.
fn write(sound: &Sound, said: &[u8]) {
    let mut said = said.iter().copied();
    let mut byte = || said.next().unwrap_or_default();
    let mut journal = Journal::beside(&FILE, &sound.head).expect("a file of ours");
    let mut made = Vec::new();
    for _ in 0..byte() % 7 {
        let what = usize::from(byte());
        match sound.inputs.get(what % 8) {
            Some(input) => {
                let mut input = input.clone();
                for _ in 0..byte() % 8 {
                    let (low, high, value) = (byte(), byte(), byte());
                    let place = usize::from(u16::from_le_bytes([low, high])) % input.len();
                    input[place] = value;
                }
                journal.input_bytes(&input).expect("a record");
                made.push(journal.edit(&u64::from(byte()).to_le_bytes()).expect("a record").1);
            }
            None if what & 8 == 0 => journal.undo(made.last().copied().unwrap_or(u64::from(byte()))).expect("a record"),
            None => journal.redo(made.last().copied().unwrap_or(u64::from(byte()))).expect("a record"),
        }
    }
}
