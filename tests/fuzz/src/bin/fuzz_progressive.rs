//! Any bytes as a progressive mesh, and a sound one with some of its numbers changed and its sums made right again. They
//! are refused, or make meshes of indices in range at every level; piece by piece as at once.
#![no_main]

use std::sync::{Arc, LazyLock};

use libfuzzer_sys::fuzz_target;
use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, ContextOptions, Domain, Mesh, Values};
use relievo_fuzz::MEMORY_LIMIT;
use relievo_lod::progressive::{ActiveMesh, Arrival, BuildOptions, Cut, Extract};
use relievo_lod::{AttributeOptions, Progressive};

/// Bytes of the head of a file, with its sum.
const HEAD: usize = 60;

/// A file: its head, and the bytes of its chunks.
type File = (Vec<u8>, Vec<Vec<u8>>);

/// A sound file, and one with attributes of all kinds.
static SOUND: LazyLock<[File; 2]> = LazyLock::new(|| [false, true].map(sound));

fn sound(has_attributes: bool) -> File {
    let height = |x: u32, y: u32| ((x * 7 + y * 11) % 5) as f32 * 0.3;
    let points: Vec<_> =
        (0..100).map(|at| (at % 10, at / 10)).map(|(x, y)| [x as f32, y as f32, height(x, y)]).collect();
    let squares = (0..90u32).filter(|at| at % 10 < 9);
    let triangles: Vec<_> = squares.flat_map(|at| [[at, at + 1, at + 11], [at, at + 11, at + 10]]).collect();
    let options = BuildOptions { faces: 8, ..BuildOptions::default() };
    let mut mesh = Mesh::from_triangles(points, &triangles);
    if has_attributes {
        let mut add = |name: &str, domain: Domain, width: u32, values: Values| {
            mesh.attributes.push(Attribute { name: name.into(), domain, width, values, indices: None });
        };
        // A seam between columns, and islands of materials.
        let uv = |corner: usize| [corner as f32 % 7.0, if corner / 3 % 18 < 8 { 0.25 } else { 0.75 }];
        add("uv", Domain::Corner, 2, Values::F32((0..3 * triangles.len()).flat_map(uv).collect()));
        add("color", Domain::Point, 3, Values::F32((0..300).map(|at| at as f32 / 300.0).collect()));
        let materials = (0..triangles.len() as u32).map(|at| at / 90).collect();
        add("material", Domain::Face, 1, Values::U32(materials));
    }
    let attributes = AttributeOptions::default();
    let built = Progressive::build_mesh(&Context::serial(), &mesh, &options, &attributes, &mut Silent);
    let (mesh, _) = built.expect("a mesh");
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
}

fuzz_target!(|data: &[u8]| {
    match data.split_first() {
        Some((which @ 1..=2, changes)) => read(&changed(usize::from(which - 1), changes)),
        _ => read(data),
    }
});

/// A sound file with some bytes changed: two that tell the place, one what it becomes.
fn changed(which: usize, changes: &[u8]) -> Vec<u8> {
    let (mut head, mut chunks) = SOUND[which].clone();
    for change in changes.as_chunks::<3>().0 {
        let place = usize::from(u16::from_le_bytes([change[0], change[1]]));
        let parts = std::iter::once(&mut head).chain(&mut chunks);
        let mut left = place % 16384;
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
    let mesh = Progressive::read(&context, &mut &*bytes, usize::MAX).map(Arc::new);
    let mut arrival = Arrival::new(&context);
    let is_taken = bytes.chunks(97).all(|piece| arrival.push(&context, piece).is_ok());
    assert_eq!(is_taken && arrival.is_complete(), mesh.is_ok());
    let Ok(mesh) = mesh else { return };
    let mut active = ActiveMesh::new(&mesh);
    let (base, mut kept) = (active.extract(), Extract::default());
    let half = Cut::of_faces(&mesh, (mesh.triangle_count() + base.triangles.len()) / 2);
    for cut in [half, Cut::FINEST, half, Cut::of_error(0.1), Cut::FINEST, Cut::BASE] {
        active.adapt(&context, cut);
        let made = active.extract();
        assert!(made.triangles.as_flattened().iter().all(|vertex| (*vertex as usize) < made.points.len()));
        let (whole, vertices) = active.to_mesh();
        assert_eq!((whole.face_count(), whole.points.len()), (made.triangles.len(), vertices.len()));
        assert!(whole.corners.iter().all(|point| (*point as usize) < whole.points.len()));
        let update = active.update(&mut kept, false);
        let wedges = kept.wedges.iter().take(update.triangles).flatten();
        assert!(wedges.clone().all(|wedge| (*wedge as usize) < update.wedges));
    }
    assert_eq!(active.extract(), base);
}
