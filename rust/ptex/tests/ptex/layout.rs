//! Files byte by byte against the published description of the format: one that is written is taken apart field by
//! field, and ones that are put together by hand are read.

use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use relievo_ptex::{
    BorderMode, Borders, DataType, EdgeFilter, Face, Format, MeshType, MetaValue, Neighbor, Reader, Resolution,
    Summary, Writer,
};

const LIMIT: u64 = 1 << 20;

fn zip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn unzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    ZlibDecoder::new(bytes).read_to_end(&mut out).unwrap();
    out
}

/// Takes a file apart.
struct Pieces<'a>(&'a [u8]);

impl<'a> Pieces<'a> {
    fn next(&mut self, count: usize) -> &'a [u8] {
        let (piece, rest) = self.0.split_at(count);
        self.0 = rest;
        piece
    }

    fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.next(2).try_into().unwrap())
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.next(4).try_into().unwrap())
    }

    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.next(8).try_into().unwrap())
    }
}

#[test]
fn a_written_file_has_the_documented_fields() {
    let format = Format { mesh: MeshType::Quad, data_type: DataType::U8, channels: 2, alpha: Some(1) };
    let borders = Borders { u: BorderMode::Black, v: BorderMode::Periodic, edge_filter: EdgeFilter::TangentVector };
    let mut writer = Writer::new(format, borders, 2).unwrap();
    let at = |face, edge| Some(Neighbor { face, edge });
    let constant = Face { neighbors: [None, at(1, 3), None, None], ..Face::new(1, 0) };
    let varied = Face { neighbors: [None, None, None, at(0, 1)], subface: true, ..Face::new(3, 3) };
    // Opaque: coverage 255 does not change the colour.
    let texels: Vec<u8> = (0..64).flat_map(|index| [index, 255]).collect();
    writer.set(1, &varied, &texels).unwrap();
    writer.set(0, &constant, &[9, 128, 9, 128]).unwrap();
    writer.set_meta("Name", MetaValue::Text("ab".into()));
    writer.set_meta("Numbers", MetaValue::I16(vec![-2, 300]));
    writer.set_meta("Large", MetaValue::F32(vec![1.5; 400]));
    let bytes = writer.bytes().unwrap();

    let mut file = Pieces(&bytes);
    assert_eq!(file.next(4), b"Ptex");
    assert_eq!((file.u32(), file.u32(), file.u32(), file.u32()), (1, 1, 0, 1), "version, mesh, data type, alpha");
    assert_eq!((file.u16(), file.u16(), file.u32()), (2, 2, 2), "channels, levels, faces");
    let (extended, face_info, constants, level_info) = (file.u32(), file.u32(), file.u32(), file.u32());
    assert_eq!((extended, level_info), (40, 32));
    assert_eq!(file.u32(), 4, "minor version");
    let level_data = file.u64();
    let (meta_zipped, meta) = (file.u32(), file.u32());

    assert_eq!([file.u16(), file.u16(), file.u16(), file.u16()], [1, 0, 2, 1], "border modes, edge filter");
    let (large_zipped, large) = (file.u32(), file.u32());
    let (large_data, edits, edits_at) = (file.u64(), file.u64(), file.u64());
    assert_eq!((edits, edits_at), (0, bytes.len() as u64));

    let none = [255; 4];
    let faces = unzip(file.next(face_info as usize));
    assert_eq!(faces.len(), 40);
    assert_eq!(faces[..4], [1, 0, 3 << 2, 1], "log2 of u and v, edges, constant");
    assert_eq!(faces[4..20], [none, [1, 0, 0, 0], none, none].concat());
    assert_eq!(faces[20..24], [3, 3, 1 << 6, 8], "log2 of u and v, edges, sub-face");
    assert_eq!(faces[24..], [none, none, none, [0; 4]].concat());
    // The mean of 0..63 is 31.5.
    assert_eq!(unzip(file.next(constants as usize)), [9, 128, 32, 255]);

    let levels: Vec<_> = (0..2).map(|_| (file.u64(), file.u32(), file.u32())).collect();
    assert_eq!(levels.iter().map(|level| level.0).sum::<u64>(), level_data);
    assert_eq!((levels[0].2, levels[1].2), (2, 1), "faces per level");
    let sizes = unzip(file.next(levels[0].1 as usize));
    assert_eq!(sizes[..4], [0; 4], "constant faces have no texels in levels");
    let size = u32::from_le_bytes(sizes[4..].try_into().unwrap());
    assert_eq!(size >> 30, 2, "zipped differences");
    let block = unzip(file.next(size as usize & 0x3fff_ffff));
    // Channels apart, each value as the difference from the one before.
    let first: Vec<u8> = std::iter::once(0).chain([1; 63]).collect();
    let second: Vec<u8> = std::iter::once(255u8.wrapping_sub(63)).chain([0; 63]).collect();
    assert_eq!(block, [first, second].concat());
    let sizes = unzip(file.next(levels[1].1 as usize));
    let size = u32::from_le_bytes(sizes.try_into().unwrap());
    let block = unzip(file.next(size as usize & 0x3fff_ffff));
    let summed = |range: std::ops::Range<usize>| block[range].iter().fold(0u8, |sum, value| sum.wrapping_add(*value));
    // The first texel is the mean of 0, 1, 8 and 9; the last of 54, 55, 62 and 63.
    assert_eq!((block.len(), block[0], summed(0..16), summed(0..32)), (32, 5, 59, 255));

    let small = unzip(file.next(meta_zipped as usize));
    assert_eq!(small.len(), meta as usize);
    assert_eq!(small, b"\x05Name\0\x00\x03\0\0\0ab\0\x08Numbers\0\x02\x04\0\0\0\xfe\xff\x2c\x01");
    assert_eq!(file.u64(), 0, "compatibility barrier");
    let names = unzip(file.next(large_zipped as usize));
    assert_eq!(names.len(), large as usize);
    assert_eq!(names[..12], *b"\x06Large\0\x04\x40\x06\0\0");
    assert_eq!(u64::from(u32::from_le_bytes(names[12..].try_into().unwrap())), large_data);
    assert_eq!(unzip(file.next(large_data as usize)), 1.5f32.to_le_bytes().repeat(400));
    assert!(file.0.is_empty());
}

/// A file put together by hand: quads of one channel of bytes.
struct ByHand {
    /// Bytes of the extended header that are stored.
    extended: usize,
    records: Vec<[u8; 20]>,
    constants: Vec<u8>,
    /// Sizes with encoding, and blocks, of every level.
    levels: Vec<Vec<(u32, Vec<u8>)>>,
    meta: Vec<u8>,
    edits: Vec<u8>,
    /// Data type and channels.
    kind: (u32, u16),
    /// Zero bytes behind the meta data, in files with the whole extended header.
    barrier: usize,
}

fn record(u: u8, v: u8, flags: u8) -> [u8; 20] {
    let mut bytes = [255; 20];
    bytes[..4].copy_from_slice(&[u, v, 0, flags]);
    bytes
}

fn block(encoding: u32, bytes: Vec<u8>) -> (u32, Vec<u8>) {
    (encoding << 30 | bytes.len() as u32, bytes)
}

impl ByHand {
    fn new(records: Vec<[u8; 20]>, constants: &[u8], level: Vec<(u32, Vec<u8>)>) -> Self {
        let constants = constants.to_vec();
        Self {
            extended: 40,
            records,
            constants,
            levels: vec![level],
            meta: vec![],
            edits: vec![],
            kind: (0, 1),
            barrier: 8,
        }
    }

    fn bytes(&self) -> Vec<u8> {
        let (records, constants) = (zip(&self.records.concat()), zip(&self.constants));
        let (mut info, mut data) = (Vec::new(), Vec::new());
        for level in &self.levels {
            let sizes: Vec<u8> = level.iter().flat_map(|(size, _)| size.to_le_bytes()).collect();
            let sizes = zip(&sizes);
            let blocks: Vec<u8> = level.iter().flat_map(|(_, block)| block.clone()).collect();
            info.extend(((sizes.len() + blocks.len()) as u64).to_le_bytes());
            info.extend((sizes.len() as u32).to_le_bytes());
            info.extend((level.len() as u32).to_le_bytes());
            data.extend(sizes);
            data.extend(blocks);
        }
        let meta = zip(&self.meta);
        let mut out = b"Ptex".to_vec();
        for field in [1, 1, self.kind.0, u32::MAX] {
            out.extend(u32::to_le_bytes(field));
        }
        out.extend(self.kind.1.to_le_bytes());
        out.extend((self.levels.len() as u16).to_le_bytes());
        let sizes = [self.records.len(), self.extended, records.len(), constants.len(), info.len(), 3];
        sizes.iter().for_each(|size| out.extend((*size as u32).to_le_bytes()));
        out.extend((data.len() as u64).to_le_bytes());
        out.extend((meta.len() as u32).to_le_bytes());
        out.extend((self.meta.len() as u32).to_le_bytes());
        let barrier = if self.extended < 40 { 0 } else { self.barrier };
        let end = out.len() + self.extended + records.len() + constants.len() + info.len() + data.len() + meta.len();
        let mut extended = vec![0; 24];
        extended.extend((self.edits.len() as u64).to_le_bytes());
        extended.extend(((end + barrier) as u64).to_le_bytes());
        out.extend(&extended[..self.extended]);
        for piece in [records, constants, info, data, meta] {
            out.extend(piece);
        }
        out.extend(vec![0; barrier]);
        out.extend(&self.edits);
        out
    }
}

/// An edit of a face, by the published layout.
fn face_edit(face: u32, record: [u8; 20], header: u32, value: &[u8], block: &[u8]) -> Vec<u8> {
    let mut edit = face.to_le_bytes().to_vec();
    edit.extend(record);
    edit.extend(header.to_le_bytes());
    edit.extend(value);
    edit.extend(block);
    [&[0], (edit.len() as u32).to_le_bytes().as_slice(), &edit].concat()
}

fn meta_edit(entries: &[u8]) -> Vec<u8> {
    let zipped = zip(entries);
    let mut edit = (zipped.len() as u32).to_le_bytes().to_vec();
    edit.extend((entries.len() as u32).to_le_bytes());
    edit.extend(zipped);
    [&[1], (edit.len() as u32).to_le_bytes().as_slice(), &edit].concat()
}

#[test]
fn all_encodings_are_read() {
    let plain: Vec<u8> = (0..8).collect();
    // Tiles of 2 x 1 in a face of 4 x 2: one constant, one zipped, one of differences, one constant again.
    let tiles = [block(0, vec![5]), block(1, zip(&[1, 2])), block(2, zip(&[7, 1])), block(0, vec![6])];
    let sizes = zip(&tiles.iter().flat_map(|(size, _)| size.to_le_bytes()).collect::<Vec<_>>());
    let mut tiled = vec![1, 0];
    tiled.extend((sizes.len() as u32).to_le_bytes());
    tiled.extend(sizes);
    tiles.iter().for_each(|(_, block)| tiled.extend(block));
    let level = vec![
        block(1, zip(&plain)),
        block(2, zip(&[250, 10, 1, 1, 1, 1, 1, 1])),
        block(3, tiled),
        block(0, vec![77]),
        (0, Vec::new()),
    ];
    let records = [[record(2, 1, 0); 4].as_slice(), &[record(2, 1, 1)]].concat();
    let bytes = ByHand::new(records, &[1, 2, 3, 4, 5], level).bytes();
    let reader = Reader::new(&bytes, LIMIT).unwrap();
    assert_eq!(reader.texels(0).unwrap(), plain);
    assert_eq!(reader.texels(1).unwrap(), [250, 4, 5, 6, 7, 8, 9, 10]);
    assert_eq!(reader.texels(2).unwrap(), [5, 5, 1, 2, 7, 8, 6, 6]);
    assert_eq!(reader.texels(3).unwrap(), [77; 8]);
    assert_eq!(reader.texels(4).unwrap(), [5; 8]);
    assert_eq!((reader.constant(4), reader.constant(3)), (Some([5].as_slice()), None));
    assert!(reader.texels(5).is_err() && reader.face(5).is_err());
    assert_eq!(Summary::of(&reader).problem, None);
}

#[test]
fn channels_are_apart_and_whole_numbers_have_two_bytes() {
    let plane = |values: [u16; 2]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    // Differences run on from channel to channel.
    let planes = [plane([65535, 2]), plane([255, 1])].concat();
    let mut file = ByHand::new(vec![record(1, 0, 0)], &[0; 4], vec![block(2, zip(&planes))]);
    file.kind = (1, 2);
    let reader = Reader::new(file.bytes(), LIMIT).unwrap();
    assert_eq!(reader.texels(0).unwrap(), [65535u16, 256, 1, 257].map(u16::to_le_bytes).concat());
    // Floats have no differences.
    let planes: Vec<u8> = [1.0f32, 2.0, 3.0, 4.0].iter().flat_map(|value| value.to_le_bytes()).collect();
    for encoding in [1, 2] {
        let mut file = ByHand::new(vec![record(1, 0, 0)], &[0; 8], vec![block(encoding, zip(&planes))]);
        file.kind = (3, 2);
        let reader = Reader::new(file.bytes(), LIMIT).unwrap();
        assert_eq!(DataType::F32.decode(&reader.texels(0).unwrap()), [1.0, 3.0, 2.0, 4.0]);
    }
}

#[test]
fn edits_are_applied_in_order() {
    // Whole headers; without the zero bytes, as some programs write them where there is no meta data; older ones.
    for (extended, barrier) in [(40, 8), (40, 0), (24, 0), (0, 0)] {
        let level = vec![block(1, zip(&[1, 2])), block(1, zip(&[3, 4])), (0, Vec::new())];
        let mut file = ByHand::new(vec![record(1, 0, 0), record(1, 0, 0), record(0, 0, 1)], &[1, 3, 9], level);
        (file.extended, file.barrier) = (extended, barrier);
        file.meta = b"\x02k\0\x00\x02\0\0\0a\0\x02l\0\x01\x01\0\0\0\xff".to_vec();
        let larger = zip(&[5, 6, 7, 8]);
        file.edits = [
            face_edit(0, record(1, 0, 0), block(1, zip(&[50, 60])).0, &[55], &zip(&[50, 60])),
            // A kind of a later version.
            vec![9, 3, 0, 0, 0, 1, 2, 3],
            face_edit(0, record(1, 1, 0), 1 << 30 | larger.len() as u32, &[6], &larger),
            meta_edit(b"\x02k\0\x00\x03\0\0\0bc\0"),
            // What was constant is not any more, and the other way round; flags of the reader do not count.
            face_edit(1, record(3, 3, 3), 0, &[42], &[]),
            face_edit(2, record(1, 0, 0), block(2, zip(&[1, 1])).0, &[1], &zip(&[1, 1])),
        ]
        .concat();
        let reader = Reader::new(file.bytes(), LIMIT).unwrap();
        assert_eq!(reader.edit_count(), 6);
        assert_eq!(reader.face(0).unwrap().resolution, Resolution::new(1, 1));
        assert_eq!((reader.texels(0).unwrap(), reader.average(0).unwrap()), (vec![5, 6, 7, 8], [6].as_slice()));
        assert_eq!((reader.constant(1), reader.texels(1).unwrap()), (Some([42].as_slice()), vec![42; 64]));
        assert_eq!((reader.constant(2), reader.texels(2).unwrap()), (None, vec![1, 2]));
        assert_eq!(reader.meta()["k"], MetaValue::Text("bc".into()));
        assert_eq!(reader.meta()["l"], MetaValue::I8(vec![-1]));
        assert!((0..3).all(|face| reader.is_edited(face)));
        let shown = Summary::of(&reader).to_string();
        assert!(shown.contains("3 edited") && shown.contains("k: 2 string"), "{shown}");
    }
}

/// Reductions are in the order of sizes before the edits, and those of edited faces are out of date.
#[test]
fn reductions_are_found_by_size() {
    let zeros = |u: u32, v: u32| block(1, zip(&vec![0; 1 << (u + v)]));
    let full = vec![zeros(3, 4), (0, vec![]), zeros(5, 4), zeros(3, 3), zeros(2, 6), zeros(4, 4)];
    let records =
        vec![record(3, 4, 0), record(8, 8, 1), record(5, 4, 0), record(3, 3, 0), record(2, 6, 0), record(4, 4, 0)];
    let mut file = ByHand::new(records, &[0; 6], full);
    let half = |value: u8, u: u32, v: u32| block(1, zip(&vec![value; 1 << (u + v)]));
    file.levels.push(vec![half(2, 4, 3), half(5, 3, 3), half(0, 2, 3), half(3, 2, 2)]);
    file.levels.push(vec![half(12, 3, 2), half(15, 2, 2)]);
    file.edits = face_edit(5, record(6, 6, 1), 0, &[1], &[]);
    let reader = Reader::new(file.bytes(), LIMIT).unwrap();
    let found = |face, level| reader.reduction(face, level).unwrap().map(|texels| (texels.len(), texels[0]));
    assert_eq!(
        [0, 1, 2, 3, 4, 5].map(|face| found(face, 1)),
        [Some((32, 0)), None, Some((128, 2)), Some((16, 3)), None, None]
    );
    assert_eq!([0, 1, 2, 3, 4, 5].map(|face| found(face, 2)), [None, None, Some((32, 12)), None, None, None]);
    assert_eq!((found(2, 0), found(2, 3)), (None, None));
    assert!(reader.check().is_ok());
}

/// What a file says in few bytes takes no time that its length does not justify: 20,000 faces of 2^32 texels.
#[test]
fn large_faces_of_one_value_are_checked_at_once() {
    let count = 20_000;
    let mut file = ByHand::new(vec![record(16, 16, 0); count], &vec![0; count], vec![block(0, vec![7]); count]);
    let reader = Reader::new(file.bytes(), u64::MAX).unwrap();
    assert_eq!(reader.face(1).unwrap().resolution.texels(), 1 << 32);
    assert_eq!(Summary::of(&reader).problem, None);
    file.levels[0][count - 1] = block(0, vec![7, 7]);
    let error = Reader::new(file.bytes(), u64::MAX).unwrap().check().unwrap_err().to_string();
    assert!(error.starts_with("face 19999, level 0: "), "{error}");
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let good = || ByHand::new(vec![record(1, 0, 0)], &[1], vec![block(1, zip(&[1, 2]))]);
    let error = |bytes: Vec<u8>| match Reader::new(bytes, LIMIT) {
        Err(error) => error.to_string(),
        Ok(reader) => reader.check().unwrap_err().to_string(),
    };
    let with = |at: usize, value: u8| {
        let mut bytes = good().bytes();
        bytes[at] = value;
        bytes
    };
    assert!(Reader::new(good().bytes(), LIMIT).unwrap().check().is_ok());
    for (bytes, expected) in [
        (b"Photo".to_vec(), "does not begin with `Ptex`"),
        (with(4, 2), "byte 4: the file is of version 2"),
        (with(8, 2), "byte 8: there is no mesh type 2"),
        (with(12, 4), "byte 12: there is no data type 4"),
        (
            with(16, 0)
                .into_iter()
                .enumerate()
                .map(|(at, byte)| if (17..20).contains(&at) { 0 } else { byte })
                .collect(),
            "",
        ),
        (with(20, 0), "byte 16: texels have no channels"),
        (with(24, 2), "the list of faces: byte 118: the compressed data is damaged, or is not of 40 bytes"),
        (with(64, 3), "byte 64: there is no border mode 3"),
        (with(70, 9), "byte 70: there is no edge filter mode 9"),
        (ByHand { records: vec![record(1, 17, 0)], ..good() }.bytes(), "face 0: it has 2^1 by 2^17 texels"),
        (ByHand { records: vec![record(2, 0, 0)], ..good() }.bytes(), "face 0, level 0: byte"),
        (ByHand { levels: vec![], ..good() }.bytes(), "face 0, level 0: the file has no texels of it"),
        (ByHand { levels: vec![vec![]], ..good() }.bytes(), "level 0: byte"),
        (ByHand { meta: vec![0], ..good() }.bytes(), "decompressed: byte 0: meta data has no key"),
        (ByHand { edits: face_edit(1, record(0, 0, 1), 0, &[1], &[]), ..good() }.bytes(), "face 1 of 1"),
        (ByHand { edits: vec![0, 200, 0, 0, 0], ..good() }.bytes(), "200 bytes are expected, but 0 are left"),
    ] {
        if expected.is_empty() {
            // Channel 0 as alpha is fine.
            assert_eq!(Reader::new(bytes, LIMIT).unwrap().format().alpha, Some(0));
            continue;
        }
        let found = error(bytes);
        assert!(found.contains(expected) && found.contains(';'), "{expected}: {found}");
    }
}
