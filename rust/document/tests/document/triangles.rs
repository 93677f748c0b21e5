//! Documents of triangle meshes: blocks of triangles, edges and points in the sizes of a pattern, and files of earlier
//! versions.

use std::path::Path;

use proptest::prelude::*;
use relievo_core::{Context, ErrorKind, Mesh};
use relievo_document::format::VERSION;
use relievo_document::{Document, Kind};

const LIMIT: u64 = 64 << 20;

/// Two triangles of a square, and a third: 3 faces, 7 edges, 300 points.
fn mesh() -> Mesh {
    let points = (0..300).map(|k| [k as f32, 0.5, 0.25]).collect();
    Mesh::from_triangles(points, &[[0, 1, 2], [2, 1, 3], [0, 2, 299]])
}

fn values(kind: Kind, count: usize) -> Vec<u8> {
    (0..(count * kind.texel()) as u32).map(|at| (at.wrapping_mul(40503) >> 9) as u8 & 0x3b).collect()
}

/// Blocks of T, T/2 and T/4 of triangles and edges, and of points.
const BLOCKS: [(u32, usize); 7] = [(0, 169), (1, 37), (2, 7), (3, 15), (4, 7), (9, 3), (11, 44)];

fn document() -> Document {
    let mut document = Document::of_triangles(&mesh(), "baseline").unwrap();
    for kind in [Kind::Scalar, Kind::Rgba16] {
        let count = |block: u32| BLOCKS.iter().find(|(at, _)| *at == block).map_or(0, |(_, count)| *count);
        let read = |block: u32| Ok(values(kind, count(block)));
        let head = (kind.name(), kind, &vec![0; kind.texel()][..]);
        document.pack(&Context::serial(), head, vec![16; 3], &BLOCKS.map(|(block, _)| block), read).unwrap();
    }
    document
}

#[test]
fn blocks_of_every_size_are_read_as_they_were_written() {
    let written = document();
    let bytes = written.to_bytes().unwrap();
    let read = Document::parse(&bytes, LIMIT).unwrap();
    assert_eq!((read.version, &read), (VERSION, &written));
    assert_eq!(read.to_bytes().unwrap(), bytes);
    let layer = &read.layers()[1];
    for (at, (_, count)) in BLOCKS.into_iter().enumerate() {
        assert_eq!(layer.unpack(read.topology(), at).unwrap(), values(Kind::Rgba16, count));
    }
    assert_eq!(layer.bytes(read.topology()), BLOCKS.iter().map(|(_, count)| 8 * *count as u64).sum());
    assert_eq!(read.topology().block_count(), 12);
    read.fit_triangles(&mesh()).unwrap();
}

#[test]
fn what_needs_more_memory_than_the_limit_is_not_called_damaged() {
    let bytes = document().to_bytes().unwrap();
    let enough = (0..).map(|step| 64 * step).find(|limit| match Document::parse(&bytes, *limit) {
        Ok(_) => true,
        Err(error) => {
            assert_eq!(error.kind, ErrorKind::Memory, "{limit}: {error}");
            false
        }
    });
    assert!(enough.is_some_and(|limit| limit > 1000));
}

#[test]
fn what_is_no_block_of_a_triangle_mesh_is_refused() {
    let pack = |sizes: Vec<u32>, block: u32, count: usize| {
        let mut document = Document::of_triangles(&mesh(), "baseline").unwrap();
        let read = |_| Ok(vec![0; 2 * count]);
        document.pack(&Context::serial(), ("a", Kind::Scalar, &[0, 0]), sizes, &[block], read)
    };
    pack(vec![16; 3], 0, 37).unwrap();
    for (sizes, block, count) in [
        (vec![16; 3], 0, 36),
        (vec![16; 3], 0, 1),
        (vec![16; 3], 3, 169),
        (vec![16; 3], 12, 256),
        (vec![16; 3], 11, 256),
        (vec![16, 16, 8], 0, 37),
        (vec![128; 3], 0, 37),
        (vec![16; 2], 0, 37),
    ] {
        assert!(pack(sizes.clone(), block, count).is_err(), "{sizes:?} {block} {count}");
    }
    let mut corner = mesh();
    corner.corners[0] = 300;
    assert!(Document::of_triangles(&corner, "baseline").is_err());
    // Polygons are fanned, holes left out.
    let quads = Mesh { holes: vec![1], ..Mesh::new(vec![[0.0; 3]; 6], vec![4, 4], vec![0, 1, 2, 3, 3, 2, 4, 5]) };
    let document = Document::of_triangles(&quads, "baseline").unwrap();
    assert_eq!(document.topology().corners(), [0, 1, 2, 0, 2, 3]);
    document.fit_triangles(&quads).unwrap();
}

proptest! {
    #[test]
    fn bytes_that_differ_are_an_error_or_a_warning_and_never_a_panic(at: prop::sample::Index, bit in 0..8u32) {
        let mut bytes = document().to_bytes().unwrap();
        let at = at.index(bytes.len());
        bytes[at] ^= 1u8 << bit;
        // Where second copies alone are hit, the document is as it was.
        if let Ok(read) = Document::parse(&bytes, LIMIT) {
            prop_assert!(read.layers() == document().layers() && read.notes.len() == 1);
        }
    }
}

#[test]
fn the_file_of_every_earlier_release_opens() {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/triangles-3.relievo"));
    // How it was made; a release that changes the format adds a file and keeps this one.
    if std::env::var_os("RELIEVO_WRITE_GOLDEN").is_some() {
        document().write(path).unwrap();
    }
    let golden = Document::open(path, LIMIT).unwrap();
    let expected = document();
    assert_eq!((golden.points(), golden.topology()), (expected.points(), expected.topology()));
    for (golden, layer) in golden.layers().iter().zip(expected.layers()) {
        assert_eq!((golden.head(), golden.blocks().len()), (layer.head(), layer.blocks().len()));
        for at in 0..layer.blocks().len() {
            let topology = expected.topology();
            assert_eq!(golden.unpack(topology, at).unwrap(), layer.unpack(topology, at).unwrap());
        }
    }
}
