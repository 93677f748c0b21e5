//! Files of documents: what is written is read, the same bytes every time; whatever is damaged is an error or told, and
//! never wrong data; files of earlier versions open.

use std::path::Path;

use proptest::prelude::*;
use relievo_core::mesh::Crease;
use relievo_core::{Context, ErrorKind, Mesh};
use relievo_document::format::VERSION;
use relievo_document::{Blend, Document, Head, Kind, Layer, Settings, Stamps, examine, repair};

const LIMIT: u64 = 64 << 20;

/// A quad, a triangle and a pentagon that is a hole: nine tiles.
fn mesh() -> Mesh {
    let mut mesh = Mesh::new(vec![[0.0; 3]; 8], vec![4, 3, 5], vec![0, 1, 2, 3, 2, 1, 4, 3, 2, 5, 6, 7]);
    mesh.holes.push(2);
    mesh.creases.push(Crease { points: [1, 2], sharpness: 2.5 });
    mesh
}

/// Texels of a block that compress, and not to nothing.
fn texels(kind: Kind, size: usize, seed: u32) -> Vec<u8> {
    let count = (size + 2) * (size + 2) * kind.texel();
    (0..count as u32).map(|at| (at.wrapping_mul(seed) >> 9) as u8 & 0x3b).collect()
}

/// Adds a layer of the quad (at `size`) and the last sub-tile of the triangle.
fn add(document: &mut Document, name: &str, kind: Kind, size: u32, seed: u32) {
    let blank = vec![7; kind.texel()];
    let read = |tile: u32| {
        let size = if tile == 0 { size } else { (size / 2).max(8) };
        Ok(texels(kind, size as usize, seed + tile))
    };
    document.pack(&Context::serial(), (name, kind, &blank), vec![size, size, 8], &[0, 3], read).unwrap();
}

fn document() -> Document {
    let mut document = Document::new(&mesh(), "baseline").unwrap();
    add(&mut document, "displacement", Kind::Scalar, 16, 40503);
    add(&mut document, "colour", Kind::Rgba8, 8, 2654435);
    add(&mut document, "light", Kind::Rgba16, 8, 99991);
    document
}

fn write_and_examine(bytes: &[u8]) -> relievo_core::Result<(Document, Vec<relievo_document::Damage>)> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    std::fs::write(&path, bytes).unwrap();
    examine(&Context::serial(), &path)
}

#[test]
fn what_was_written_is_read_and_makes_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    let written = document();
    written.write(&path).unwrap();
    let read = Document::open(&path, LIMIT).unwrap();
    assert_eq!(read, written);
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!((read.to_bytes().unwrap(), document().to_bytes().unwrap()), (bytes.clone(), bytes.clone()));
    let layer = read.layer("displacement").unwrap();
    assert_eq!(layer.unpack(read.topology(), 0).unwrap(), texels(Kind::Scalar, 16, 40503));
    assert_eq!(layer.unpack(read.topology(), 1).unwrap(), texels(Kind::Scalar, 8, 40506));
    assert!(layer.unpack(read.topology(), 2).is_err());
    assert_eq!(layer.bytes(read.topology()), 2 * (18 * 18 + 10 * 10));
    assert_eq!(read.fit(&mesh()), Ok(None));
    assert_eq!(write_and_examine(&bytes).unwrap(), (written, vec![]));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn the_document_of_every_earlier_release_opens() {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/document-1.relievo"));
    let (golden, expected) = (Document::open(path, LIMIT).unwrap(), document());
    assert_eq!(golden.topology(), expected.topology());
    assert_eq!((golden.writer.as_str(), golden.level.as_str()), ("relievo 0.1.0", "baseline"));
    assert_eq!(golden.layers().len(), 3);
    for (golden, layer) in golden.layers().iter().zip(expected.layers()) {
        assert_eq!((golden.name(), golden.kind(), golden.blank()), (layer.name(), layer.kind(), layer.blank()));
        assert_eq!(golden.face_sizes(), layer.face_sizes());
        for at in 0..2 {
            let unpacked = golden.unpack(expected.topology(), at).unwrap();
            assert_eq!(unpacked, layer.unpack(expected.topology(), at).unwrap());
        }
    }
}

/// A layer of colour that fades, with all that a head may have.
fn fading() -> Document {
    let mut document = Document::new(&mesh(), "baseline").unwrap();
    document.time = 12.5;
    let paint = Head {
        given_sizes: vec![32, 16, 8],
        behind: vec![1, 2, 3, 255],
        settings: Settings { opacity: 0.5, blend: Blend::Screen, visible: false },
        ..Head::new(5, "frost", Kind::Rgba8, &[0; 4], vec![16, 16, 8])
    };
    let stamps = Stamps { layer: 0, texel: Kind::Scalar, delay: 2.0, duration: 8.0 };
    let stamps = Head::of_stamps(6, &paint, stamps);
    let read = |tile: u32| Ok(texels(Kind::Rgba8, if tile == 0 { 16 } else { 8 }, 40503 + tile));
    document.pack_layer(&Context::serial(), paint, &[0, 3], read).unwrap();
    let read = |tile: u32| {
        let edited = read(tile).unwrap();
        let times = (0..edited.len() / 4).flat_map(|at| (at as f32 * 0.01).to_le_bytes());
        Ok(edited.iter().copied().chain(times).collect())
    };
    document.pack_layer(&Context::serial(), stamps, &[0, 3], read).unwrap();
    document
}

#[test]
fn stamps_and_sizes_and_what_is_behind_are_kept_also_by_earlier_releases() {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/fading-3.relievo"));
    let expected = fading();
    if std::env::var_os("RELIEVO_WRITE_GOLDEN").is_some() {
        expected.write(path).unwrap();
    }
    let golden = Document::open(path, LIMIT).unwrap();
    assert_eq!(golden.time, 12.5);
    for (golden, layer) in golden.layers().iter().zip(expected.layers()) {
        assert_eq!(golden.head(), layer.head());
        for at in 0..2 {
            let unpacked = golden.unpack(expected.topology(), at).unwrap();
            assert_eq!(unpacked, layer.unpack(expected.topology(), at).unwrap());
        }
    }
    let stamps = golden.layer("stamps of layer 5").unwrap();
    assert_eq!(stamps.head().stamps, Some(Stamps { layer: 5, texel: Kind::Rgba8, delay: 2.0, duration: 8.0 }));
    assert_eq!(stamps.bytes(golden.topology()), 8 * (18 * 18 + 10 * 10));
    assert_eq!(Document::parse(&expected.to_bytes().unwrap(), LIMIT).unwrap(), expected);
    // A time that is none is damage, as everywhere.
    let mut bad = expected.clone();
    let head = bad.layers()[1].head().clone();
    bad = Document::new(&mesh(), "baseline").unwrap();
    let spoiled = |tile: u32| Ok(vec![0xff; if tile == 0 { 8 * 18 * 18 } else { 8 * 100 }]);
    bad.pack_layer(&Context::serial(), head.clone(), &[0, 3], spoiled).unwrap();
    assert_eq!(write_and_examine(&bad.to_bytes().unwrap()).unwrap().1.len(), 2);
    for spoil in [
        |head: &mut Head| head.stamps = None,
        |head: &mut Head| head.given_sizes = vec![16],
        |head: &mut Head| head.behind = vec![1],
        |head: &mut Head| head.stamps.as_mut().unwrap().duration = 0.0,
        |head: &mut Head| head.stamps.as_mut().unwrap().texel = Kind::Stamps,
    ] {
        let mut bad = head.clone();
        spoil(&mut bad);
        let mut document = Document::new(&mesh(), "baseline").unwrap();
        assert!(document.pack_layer(&Context::serial(), bad, &[], |_| Ok(Vec::new())).is_err());
    }
}

#[test]
fn every_cut_is_an_error_and_every_flipped_bit_is_one_or_a_warning() {
    let whole = document();
    let good = whole.to_bytes().unwrap();
    for length in 0..good.len() {
        let error = Document::parse(&good[..length], LIMIT).unwrap_err();
        assert!(!error.what.is_empty(), "{length}");
    }
    let [_, copies] = blocks_of(&good);
    for at in 0..good.len() {
        for bit in 0..8 {
            let mut bytes = good.clone();
            bytes[at] ^= 1 << bit;
            if at >= copies {
                // The first ones are whole: the same document, with a warning.
                let read = Document::parse(&bytes, LIMIT).unwrap();
                assert_eq!((read.layers(), read.points()), (whole.layers(), whole.points()), "{at}");
                let [note] = &read.notes[..] else { panic!("{at}: {:?}", read.notes) };
                assert!(note.contains("copies of the header") && note.contains("doc repair"), "{note}");
                continue;
            }
            let error = Document::parse(&bytes, LIMIT).unwrap_err();
            assert!(matches!(error.kind, ErrorKind::Invalid | ErrorKind::Unsupported), "{at}: {error}");
        }
    }
    let mut longer = good.clone();
    longer.push(1);
    assert!(Document::parse(&longer, LIMIT).unwrap_err().to_string().contains("head is wrong"));
}

/// Where the blocks of a file begin and end.
fn blocks_of(bytes: &[u8]) -> [usize; 2] {
    let number = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
    let start = 44 + number(16);
    [start, start + number(32)]
}

#[test]
fn repair_restores_the_header_and_the_index_and_loses_at_most_the_block_that_is_hit() {
    let (context, whole) = (Context::serial(), document());
    let good = whole.to_bytes().unwrap();
    let [start, end] = blocks_of(&good);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    for at in (0..start).chain((start..end).step_by(11)).chain(end..good.len()) {
        let mut bytes = good.clone();
        bytes[at] ^= 1 << (at % 8);
        std::fs::write(&path, &bytes).unwrap();
        let repaired = repair(&context, &path).unwrap_or_else(|error| panic!("byte {at}: {error}"));
        assert!(!repaired.damage.is_empty(), "byte {at}");
        let lost = repaired.damage.iter().filter(|damage| damage.lost).count();
        assert_eq!(lost, usize::from((start..end).contains(&at)), "byte {at}: {:?}", repaired.damage);
        let kept = Document::open(&path, LIMIT).unwrap();
        assert_eq!((kept.topology(), kept.points()), (whole.topology(), whole.points()));
        let blocks =
            |document: &Document| document.layers().iter().flat_map(Layer::blocks).cloned().collect::<Vec<_>>();
        let (kept, all) = (blocks(&kept), blocks(&whole));
        assert_eq!(kept.len(), all.len() - lost);
        assert!(kept.iter().all(|block| all.contains(block)), "byte {at}");
    }
    // A stretch of the index too, and the header with it.
    let mut bytes = good.clone();
    bytes[..start].fill(0);
    std::fs::write(&path, &bytes).unwrap();
    assert!(repair(&context, &path).unwrap().damage.iter().all(|damage| !damage.lost));
    assert_eq!(Document::open(&path, LIMIT).unwrap(), whole);
    // The first version with copies is the fourth: without them the index is lost with everything.
    let old = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/document-3.relievo"));
    let mut bytes = std::fs::read(old).unwrap();
    bytes[50] ^= 1;
    std::fs::write(&path, &bytes).unwrap();
    assert!(repair(&context, &path).unwrap_err().to_string().contains("checksum of its index"));
}

#[test]
fn examining_tells_which_tiles_are_damaged_and_keeps_the_others() {
    let (good, whole) = (document().to_bytes().unwrap(), document());
    let last = whole.layers()[2].blocks()[1].packed_bytes();
    let mut bytes = good.clone();
    let [first_block, end] = blocks_of(&good);
    bytes[first_block] ^= 1;
    bytes.truncate(end - last / 2);
    let (read, damage) = write_and_examine(&bytes).unwrap();
    let told: Vec<String> = damage.iter().map(ToString::to_string).collect();
    assert_eq!(
        told,
        [
            "layer `displacement`: tile 0 of face 0: the checksum of the block is wrong",
            "layer `light`: tile 3 of face 1: the file ends before the end of the block",
            "copies of the header and the index: they are not as the first ones"
        ]
    );
    assert!(read.layers()[0].unpack(read.topology(), 0).is_err());
    assert_eq!(read.layers()[1], whole.layers()[1]);
    let error = Document::parse(&bytes, LIMIT).unwrap_err().to_string();
    assert!(error.contains("layer `displacement`: tile 0 of face 0") && error.contains("and 2 more"), "{error}");
}

#[test]
fn numbers_that_are_not_finite_are_found() {
    let mut document = Document::new(&mesh(), "baseline").unwrap();
    let read = |_| Ok([0x00, 0x7e].repeat(100));
    let blank = [0, 0];
    document.pack(&Context::serial(), ("a", Kind::Scalar, &blank), vec![8; 3], &[0], read).unwrap();
    let (_, damage) = write_and_examine(&document.to_bytes().unwrap()).unwrap();
    assert_eq!(damage.len(), 1);
    assert!(damage[0].what.contains("not finite"));
}

#[test]
fn newer_versions_and_other_files_are_told() {
    let mut bytes = document().to_bytes().unwrap();
    bytes[8] = VERSION as u8 + 1;
    let error = Document::parse(&bytes, LIMIT).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Unsupported);
    assert_eq!(
        error.to_string(),
        format!(
            "the document has format version {}; this build reads versions up to {VERSION}: take a newer relievo",
            VERSION + 1
        )
    );
    // Also if nothing else of it is as this version has it.
    assert_eq!(Document::parse(&bytes[..12], LIMIT).unwrap_err().kind, ErrorKind::Unsupported);
    assert!(Document::parse(b"v 0 0 0", LIMIT).unwrap_err().to_string().contains("does not begin as a document"));
}

#[test]
fn a_memory_limit_holds_before_anything_is_unpacked() {
    let bytes = document().to_bytes().unwrap();
    let error = (0..LIMIT).step_by(97).map(|limit| Document::parse(&bytes, limit)).take_while(Result::is_err).last();
    assert_eq!(error.unwrap().unwrap_err().kind, ErrorKind::Memory);
    // A header that claims the world.
    let claims = |at: usize, value: u64| {
        let mut bytes = bytes.clone();
        bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
        let crc = crc(&bytes[..40]);
        bytes[40..44].copy_from_slice(&crc.to_le_bytes());
        Document::parse(&bytes, LIMIT).unwrap_err()
    };
    for at in [16, 24, 32] {
        for value in [u64::MAX, u64::MAX / 2, 1 << 40, 1] {
            claims(at, value);
        }
    }
    assert_eq!(claims(24, 1 << 40).kind, ErrorKind::Memory);
}

/// CRC-32, bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc: u32, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
    })
}

#[test]
fn another_mesh_is_told_what_differs() {
    let document = document();
    let mut other = mesh();
    other.corners.swap(1, 2);
    let error = document.fit(&other).unwrap_err().to_string();
    assert!(error.contains("1 of 3 faces differ, the first is face 0 with the points 0 1 2 3 there"), "{error}");
    let mut softer = mesh();
    softer.creases.clear();
    assert!(document.fit(&softer).unwrap().unwrap().contains("creases"));
}

#[test]
fn layers_that_do_not_belong_are_refused() {
    let mut document = document();
    let context = Context::serial();
    let mut pack = |name: &str, sizes: Vec<u32>, tiles: &[u32], bytes: usize| {
        document.pack(&context, (name, Kind::Rgba8, &[0; 4]), sizes, tiles, |_| Ok(vec![0; bytes]))
    };
    assert!(pack("colour", vec![8; 3], &[], 0).is_err(), "a name twice");
    assert!(pack("a", vec![8; 4], &[], 0).is_err(), "faces that do not exist");
    assert!(pack("a", vec![8; 3], &[9], 400).is_err(), "a tile that does not exist");
    assert!(pack("a", vec![8; 3], &[8], 396).is_err(), "a block that is too short");
    assert!(pack("", vec![8; 3], &[], 0).is_err() && pack("a\nb", vec![8; 3], &[], 0).is_err());
    assert!(pack("a", vec![12; 3], &[], 0).is_err() && pack("a", vec![8; 3], &[1, 1], 400).is_err());
    assert!(pack("a", vec![8; 3], &[8], 400).is_ok());
    assert_eq!(document.layers().len(), 4);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_document_comes_back_with_equal_bytes(
        sizes in prop::collection::vec(3u32..7, 1..20),
        corners in prop::collection::vec(any::<u32>(), 200),
        bits in prop::collection::vec(3u32..=5, 20),
        chosen in any::<u64>(),
        holes in any::<u32>(),
        seed in any::<u32>(),
    ) {
        let count: u32 = sizes.iter().sum();
        let mut mesh = Mesh::new(Vec::new(), sizes.clone(), corners[..count as usize].to_vec());
        mesh.holes = (0..sizes.len() as u32).filter(|face| holes >> face & 1 == 1).collect();
        let mut document = Document::new(&mesh, "avx2").unwrap();
        let topology = document.topology().clone();
        let tiles: Vec<u32> = (0..topology.tile_count().min(64)).filter(|tile| chosen >> tile & 1 == 1).collect();
        let face_sizes: Vec<u32> = bits[..sizes.len()].iter().map(|bits| 1 << bits).collect();
        for kind in Kind::ALL.into_iter().filter(|kind| *kind != Kind::Stamps) {
            let read = |tile: u32| {
                let (face, sub) = topology.face_of(tile).unwrap();
                let size = face_sizes[face as usize];
                let size = if sub { (size / 2).max(8) } else { size };
                Ok(texels(kind, size as usize, seed ^ tile))
            };
            let blank = vec![1; kind.texel()];
            let head = (kind.name(), kind, blank.as_slice());
            document.pack(&Context::serial(), head, face_sizes.clone(), &tiles, read).unwrap();
            let layer = document.layer(kind.name()).unwrap();
            for (at, tile) in tiles.iter().enumerate() {
                prop_assert_eq!(layer.unpack(&topology, at).unwrap(), read(*tile).unwrap());
            }
        }
        let bytes = document.to_bytes().unwrap();
        let read = Document::parse(&bytes, LIMIT).unwrap();
        prop_assert_eq!(read.to_bytes().unwrap(), bytes);
        prop_assert_eq!(&read, &document);
        let fingerprint = format!("{:016x}", topology.fingerprint());
        prop_assert!(read.to_string().contains(&fingerprint));
    }
}
