//! Any bytes as a Ptex file, and files put together from them whose compressed blocks are sound, so that what is in
//! the blocks is reached. They are refused, or can be used; what all of its faces are can be written and read again.
#![no_main]

use std::io::Write;

use flate2::{Compression, write::ZlibEncoder};
use libfuzzer_sys::fuzz_target;
use relievo_fuzz::MEMORY_LIMIT;
use relievo_ptex::{Reader, Summary, Writer};

/// Bytes of texels that are written again, at most.
const REWRITTEN: u64 = 1 << 16;

fuzz_target!(|data: &[u8]| {
    match data.split_first() {
        Some((1, rest)) => sound(&Source(rest).file()),
        _ => sound(data),
    }
});

fn sound(bytes: &[u8]) {
    let Ok(reader) = Reader::new(bytes, MEMORY_LIMIT) else { return };
    let size = reader.format().texel_size() as u64;
    let mut total = 0u64;
    for index in 0..reader.face_count() {
        let face = reader.face(index).expect("a face of the file");
        assert_eq!(reader.average(index).expect("a face of the file").len() as u64, size);
        total = total.saturating_add(face.resolution.texels() * size);
    }
    if total > REWRITTEN {
        return;
    }
    let summary = Summary::of(&reader);
    assert!(!summary.to_string().is_empty());
    if summary.problem.is_some() {
        return;
    }
    let mut writer = Writer::new(*reader.format(), reader.borders(), reader.face_count()).expect("a checked format");
    for index in 0..reader.face_count() {
        let face = reader.face(index).expect("a face of the file");
        writer.set(index, face, &reader.texels(index).expect("checked texels")).expect("a checked face");
    }
    let keys = reader.meta().iter().filter(|(key, _)| !key.is_empty() && key.len() < 255);
    keys.clone().for_each(|(key, value)| writer.set_meta(key.clone(), value.clone()));
    let again = Reader::new(writer.bytes().expect("all faces"), MEMORY_LIMIT).expect("a file of ours");
    for index in 0..reader.face_count() {
        assert_eq!(again.face(index), reader.face(index));
        assert_eq!(again.texels(index), reader.texels(index));
    }
    assert_eq!(again.meta().len(), keys.count());
}

/// Bytes that a file is made of.
struct Source<'a>(&'a [u8]);

impl<'a> Source<'a> {
    fn byte(&mut self) -> u8 {
        self.take(1).first().copied().unwrap_or_default()
    }

    fn take(&mut self, count: usize) -> &'a [u8] {
        let (piece, rest) = self.0.split_at(count.min(self.0.len()));
        self.0 = rest;
        piece
    }

    /// As many bytes as asked for, zeros behind the end.
    fn padded(&mut self, count: usize) -> Vec<u8> {
        let mut bytes = self.take(count).to_vec();
        bytes.resize(count, 0);
        bytes
    }

    /// Size with encoding, and bytes, of a block of texels.
    fn block(&mut self) -> (u32, Vec<u8>) {
        let (encoding, length) = (self.byte() & 3, usize::from(self.byte()));
        let bytes = match encoding {
            0 => self.take(length).to_vec(),
            3 => {
                let mut out = vec![self.byte() & 7, self.byte() & 7];
                let tiles: Vec<_> = (0..length % 5).map(|_| self.block()).collect();
                let sizes = zip(&tiles.iter().flat_map(|(size, _)| size.to_le_bytes()).collect::<Vec<_>>());
                out.extend((sizes.len() as u32).to_le_bytes());
                out.extend(sizes);
                out.extend(tiles.into_iter().flat_map(|(_, block)| block));
                out
            }
            _ => zip(self.take(length)),
        };
        (u32::from(encoding) << 30 | bytes.len() as u32, bytes)
    }

    fn edit(&mut self, texel: usize) -> Vec<u8> {
        let kind = self.byte() & 1;
        let edit = if kind == 0 {
            let face = u32::from(self.byte() & 7);
            let record = self.padded(20);
            let (size, block) = self.block();
            [&face.to_le_bytes(), record.as_slice(), &size.to_le_bytes(), &self.padded(texel), &block].concat()
        } else {
            let length = usize::from(self.byte());
            let bytes = self.padded(length);
            let zipped = zip(&bytes);
            [&(zipped.len() as u32).to_le_bytes(), (bytes.len() as u32).to_le_bytes().as_slice(), &zipped].concat()
        };
        [&[kind], (edit.len() as u32).to_le_bytes().as_slice(), &edit].concat()
    }

    fn file(mut self) -> Vec<u8> {
        let (mesh, data_type) = (u32::from(self.byte() & 1), u32::from(self.byte() & 3));
        let (channels, alpha) = (u16::from(self.byte() & 3) + 1, i32::from(self.byte() as i8 >> 4) as u32);
        let (levels, faces) = (usize::from(self.byte() & 3), usize::from(self.byte() & 7));
        let texel = usize::from(channels) << [0, 1, 1, 2][data_type as usize];
        let records = zip(&self.padded(20 * faces));
        let constants = zip(&self.padded(texel * faces));
        let (mut info, mut data) = (Vec::new(), Vec::new());
        for level in 0..levels {
            let count = if level == 0 { faces } else { usize::from(self.byte()) % (faces + 1) };
            let blocks: Vec<_> = (0..count).map(|_| self.block()).collect();
            let sizes = zip(&blocks.iter().flat_map(|(size, _)| size.to_le_bytes()).collect::<Vec<_>>());
            let texels: Vec<u8> = blocks.into_iter().flat_map(|(_, block)| block).collect();
            info.extend(((sizes.len() + texels.len()) as u64).to_le_bytes());
            info.extend([sizes.len() as u32, count as u32].iter().flat_map(|field| field.to_le_bytes()));
            data.extend(sizes);
            data.extend(texels);
        }
        let length = usize::from(self.byte());
        let meta = self.padded(length);
        let zipped = zip(&meta);
        let edits: Vec<u8> = (0..self.byte() & 3).flat_map(|_| self.edit(texel)).collect();
        let mut out = b"Ptex".to_vec();
        out.extend([1, mesh, data_type, alpha].iter().flat_map(|field| field.to_le_bytes()));
        out.extend([channels, levels as u16].iter().flat_map(|field| field.to_le_bytes()));
        let sizes = [faces, 40, records.len(), constants.len(), info.len(), 4];
        out.extend(sizes.iter().flat_map(|size| (*size as u32).to_le_bytes()));
        out.extend((data.len() as u64).to_le_bytes());
        out.extend([zipped.len(), meta.len()].iter().flat_map(|size| (*size as u32).to_le_bytes()));
        let end = 104 + records.len() + constants.len() + info.len() + data.len() + zipped.len() + 8;
        out.extend([0; 24]);
        out.extend([edits.len(), end].iter().flat_map(|size| (*size as u64).to_le_bytes()));
        out.extend([records, constants, info, data, zipped, vec![0; 8], edits].concat());
        out
    }
}

fn zip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).expect("a list takes all");
    encoder.finish().expect("a list takes all")
}
