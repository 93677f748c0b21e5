//! Any bytes as a progressive mesh, and a sound one with some of its numbers changed and its sums made right again. They
//! are refused, or make meshes of indices in range at every level.
#![no_main]

use std::sync::{Arc, LazyLock};

use libfuzzer_sys::fuzz_target;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions};
use relievo_fuzz::MEMORY_LIMIT;
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, BuildOptions, Cut};

/// Bytes of the head of a file, with its sum.
const HEAD: usize = 60;

/// A sound file: its head, and the bytes of its chunks.
static SOUND: LazyLock<(Vec<u8>, Vec<Vec<u8>>)> = LazyLock::new(|| {
    let height = |x: u32, y: u32| ((x * 7 + y * 11) % 5) as f32 * 0.3;
    let points: Vec<_> =
        (0..100).map(|at| (at % 10, at / 10)).map(|(x, y)| [x as f32, y as f32, height(x, y)]).collect();
    let squares = (0..90u32).filter(|at| at % 10 < 9);
    let triangles: Vec<_> = squares.flat_map(|at| [[at, at + 1, at + 11], [at, at + 11, at + 10]]).collect();
    let options = BuildOptions { faces: 8, ..BuildOptions::default() };
    let mesh = Progressive::build(&Context::serial(), &points, &triangles, &options, &mut Silent).expect("a mesh");
    let mut bytes = Vec::new();
    mesh.write(&Context::serial(), &mut bytes).expect("bytes in memory");
    let (head, mut rest) = bytes.split_at(HEAD);
    let mut chunks = Vec::new();
    while !rest.is_empty() {
        let word = |at: usize| u32::from_le_bytes(rest[at..at + 4].try_into().expect("four bytes")) as usize;
        let (packed, after) = rest[12..].split_at(word(4));
        chunks.push(zstd::bulk::decompress(packed, word(0)).expect("a chunk"));
        rest = after;
    }
    (head.to_vec(), chunks)
});

fuzz_target!(|data: &[u8]| {
    match data.split_first() {
        Some((1, changes)) => read(&changed(changes)),
        _ => read(data),
    }
});

/// The sound file with some bytes changed: two that tell the place, one what it becomes.
fn changed(changes: &[u8]) -> Vec<u8> {
    let (mut head, mut chunks) = SOUND.clone();
    for change in changes.as_chunks::<3>().0 {
        let place = usize::from(u16::from_le_bytes([change[0], change[1]]));
        let parts = std::iter::once(&mut head).chain(&mut chunks);
        let mut left = place % 8192;
        for part in parts {
            if let Some(byte) = part.get_mut(left) {
                *byte = change[2];
                break;
            }
            left -= part.len();
        }
    }
    let sum = crc32fast::hash(&head[..HEAD - 4]);
    head[HEAD - 4..].copy_from_slice(&sum.to_le_bytes());
    for chunk in chunks {
        let packed = zstd::bulk::compress(&chunk, 1).expect("a chunk");
        head.extend(
            [chunk.len() as u32, packed.len() as u32, crc32fast::hash(&packed)].into_iter().flat_map(u32::to_le_bytes),
        );
        head.extend(packed);
    }
    head
}

fn read(bytes: &[u8]) {
    let context = Context::new(&ContextOptions { threads: 1, memory_limit: MEMORY_LIMIT }).expect("one thread");
    let Ok(mesh) = Progressive::read(&context, &mut &*bytes, usize::MAX).map(Arc::new) else { return };
    let mut active = ActiveMesh::new(&mesh);
    let base = active.extract();
    let half = Cut::of_faces(&mesh, (mesh.triangle_count() + base.triangles.len()) / 2);
    for cut in [half, Cut::FINEST, half, Cut::of_error(0.1), Cut::FINEST, Cut::BASE] {
        active.adapt(&context, cut);
        let made = active.extract();
        assert!(made.triangles.as_flattened().iter().all(|vertex| (*vertex as usize) < made.points.len()));
    }
    assert_eq!(active.extract(), base);
}
