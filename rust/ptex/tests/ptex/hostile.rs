//! Damaged files: the reader returns, with what can be used or with an error, within its memory, and never panics.

use proptest::prelude::*;
use relievo_ptex::{Borders, DataType, Face, Format, MeshType, MetaValue, Neighbor, Reader, Summary, Writer};

const LIMIT: u64 = 1 << 20;

/// A small file with all but tiles in it: reductions, constants, neighbours, small and large meta data, an edit.
fn seed(data_type: DataType) -> Vec<u8> {
    let format = Format { mesh: MeshType::Quad, data_type, channels: 2, alpha: Some(1) };
    let mut writer = Writer::new(format, Borders::default(), 3).unwrap();
    let neighbors = [None, Some(Neighbor { face: 1, edge: 3 }), None, None];
    let texels = |count: usize| (0..count * format.texel_size()).map(|index| (index / 3) as u8).collect::<Vec<_>>();
    writer.set(0, &Face { neighbors, ..Face::new(4, 3) }, &texels(128)).unwrap();
    writer.set(1, &Face::new(3, 3), &texels(64)).unwrap();
    writer.set_constant(2, &Face::new(5, 5), &texels(1)).unwrap();
    writer.set_meta("a", MetaValue::Text("text".into()));
    writer.set_meta("b", MetaValue::F64(vec![1.0; 130]));
    let mut bytes = writer.bytes().unwrap();
    // The edit makes face 1 constant.
    let mut edit = vec![1, 0, 0, 0, 2, 2, 0, 1];
    edit.extend([255; 16]);
    edit.extend([0; 4]);
    edit.extend(texels(1));
    bytes.push(0);
    bytes.extend((edit.len() as u32).to_le_bytes());
    bytes.extend(&edit);
    bytes[64 + 24..64 + 32].copy_from_slice(&(edit.len() as u64 + 5).to_le_bytes());
    bytes
}

/// A file of one face in tiles: its texels have so many channels that two fill a tile.
fn tiled() -> Vec<u8> {
    let format = Format { mesh: MeshType::Quad, data_type: DataType::U8, channels: 33_000, alpha: None };
    let mut writer = Writer::new(format, Borders::default(), 1).unwrap();
    let texels: Vec<u8> = (0..4 * 33_000).map(|index| (index / 50_000) as u8).collect();
    writer.set(0, &Face::new(1, 1), &texels).unwrap();
    writer.bytes().unwrap()
}

/// Whatever opens can be used.
fn check(bytes: &[u8]) {
    let Ok(reader) = Reader::new(bytes, LIMIT) else { return };
    let size = reader.format().texel_size();
    for face in 0..reader.face_count() {
        let resolution = reader.face(face).unwrap().resolution;
        assert_eq!(reader.average(face).unwrap().len(), size);
        if let Ok(texels) = reader.texels(face) {
            assert_eq!(texels.len() as u64, resolution.texels() * size as u64);
        }
        for level in 0..=reader.level_count() {
            let _ = reader.reduction(face, level);
        }
    }
    let summary = Summary::of(&reader);
    assert!(!summary.to_string().is_empty());
}

#[test]
fn the_seeds_are_good() {
    for data_type in [DataType::U8, DataType::U16, DataType::F16, DataType::F32] {
        let reader = Reader::new(seed(data_type), LIMIT).unwrap();
        reader.check().unwrap();
        assert_eq!((reader.edit_count(), reader.meta().len(), reader.level_count()), (1, 2, 3 - 1));
        assert!(reader.constant(1).is_some());
    }
}

#[test]
fn a_file_that_is_cut_off_anywhere_is_refused() {
    for bytes in [seed(DataType::U16), tiled()] {
        Reader::new(&bytes, LIMIT).unwrap().check().unwrap();
        for length in 0..bytes.len() {
            assert!(Reader::new(&bytes[..length], LIMIT).is_err(), "{length} of {} bytes", bytes.len());
        }
    }
}

#[test]
fn a_bit_that_is_turned_over_anywhere_does_no_harm() {
    for bytes in [seed(DataType::U8), seed(DataType::F32), tiled()] {
        for bit in 0..8 * bytes.len() {
            let mut bytes = bytes.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            check(&bytes);
        }
    }
}

/// Sizes that a header only claims cost nothing.
#[test]
fn claims_are_checked_before_memory_is_taken() {
    let bytes = seed(DataType::U8);
    for field in (20..64).step_by(4) {
        for value in [u32::MAX, 0x7fff_ffff, 0x0100_0000] {
            let mut bytes = bytes.clone();
            bytes[field..field + 4].copy_from_slice(&value.to_le_bytes());
            if let Ok(reader) = Reader::new(&bytes, u64::MAX) {
                // The minor version says nothing.
                assert_eq!(field, 44);
                reader.check().unwrap();
            }
        }
    }
    for field in (64 + 8..64 + 40).step_by(4) {
        let mut bytes = bytes.clone();
        bytes[field..field + 4].copy_from_slice(&[255; 4]);
        assert!(Reader::new(&bytes, u64::MAX).is_err(), "field at {field}");
    }
}

/// A constant tile of a few bytes can be a face of billions of texels: the memory limit holds.
#[test]
fn faces_larger_than_the_memory_limit_are_refused() {
    let format = Format { mesh: MeshType::Quad, data_type: DataType::F32, channels: 4, alpha: None };
    let mut writer = Writer::new(format, Borders::default(), 1).unwrap();
    writer.set_constant(0, &Face::new(16, 16), &[1; 16]).unwrap();
    let reader = Reader::new(writer.bytes().unwrap(), LIMIT).unwrap();
    let error = reader.texels(0).unwrap_err();
    assert_eq!(error.kind, relievo_core::ErrorKind::Memory);
    assert_eq!(reader.constant(0), Some([1; 16].as_slice()));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damage_in_many_places(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8)) {
        let mut bytes = seed(DataType::U8);
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        check(&bytes);
    }

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        check(&[b"Ptex\x01\0\0\0\x01\0\0\0", bytes.as_slice()].concat());
    }
}
