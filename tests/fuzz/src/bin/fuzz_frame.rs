//! Frames of a cache of particles: arbitrary bytes, and files whose checksums are right and whose contents are not.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use relievo_core::{Context, ContextOptions};
use relievo_fuzz::MEMORY_LIMIT;
use relievo_particleio::read_frame;

static CONTEXT: LazyLock<Context> = LazyLock::new(|| {
    let options = ContextOptions { threads: 1, memory_limit: MEMORY_LIMIT };
    Context::new(&options).expect("a thread")
});

/// Header, index and chunks of a frame. Sizes are mostly what is there.
fn file(bytes: &mut Unstructured) -> Result<Vec<u8>> {
    let count = bytes.int_in_range(0..=3_u32)?;
    let sections = bytes.int_in_range(0..=5_u32)?;
    let mut index = bytes.arbitrary::<f64>()?.to_le_bytes().to_vec();
    index.extend(bytes.arbitrary::<f32>()?.to_le_bytes());
    index.push(0);
    for word in [count, sections] {
        index.extend(word.to_le_bytes());
    }
    let mut chunks = Vec::new();
    for section in 0..sections {
        let kind = if section == 0 && !bytes.ratio(1, 8)? { 0 } else { bytes.int_in_range(0..=4_u8)? };
        let width = [3, 1, bytes.int_in_range(0..=5_u8)?, 1, 1][usize::from(kind)];
        let items = match bytes.int_in_range(0..=9)? {
            0 => bytes.arbitrary()?,
            1 => 70_000,
            _ => u64::from(count),
        };
        let name: [u8; 2] = bytes.arbitrary()?;
        index.extend([kind, 2, name[0] & 0x7f, name[1] & 0x7f, width]);
        index.extend(items.to_le_bytes());
        for _ in 0..items.div_ceil(1 << 16).min(3) {
            let whole = items as usize % 100_000 * usize::from(width) * if kind == 3 { 1 } else { 4 };
            let mut content = bytes.bytes(bytes.len().min(whole))?.to_vec();
            content.resize(whole, 0);
            let packed = zstd::bulk::compress(&content, 1).unwrap_or_default();
            let length = if bytes.ratio(1, 16)? { bytes.arbitrary()? } else { packed.len() as u32 };
            for word in [length, crc32fast::hash(&packed)] {
                index.extend(word.to_le_bytes());
            }
            chunks.extend(packed);
        }
    }
    let packed = zstd::bulk::compress(&index, 1).unwrap_or_default();
    let mut file = b"RLVFLUID\x01\0\0\0".to_vec();
    file.extend(crc32fast::hash(&packed).to_le_bytes());
    for number in [packed.len(), index.len(), chunks.len()] {
        let number = if bytes.ratio(1, 16)? { bytes.arbitrary()? } else { number as u64 };
        file.extend(number.to_le_bytes());
    }
    file.extend(crc32fast::hash(&file).to_le_bytes());
    file.extend(packed);
    file.extend(chunks);
    Ok(file)
}

fuzz_target!(|data: &[u8]| {
    let made = match data.split_first() {
        Some((1, rest)) => file(&mut Unstructured::new(rest)).unwrap_or_default(),
        _ => data.to_vec(),
    };
    if let Ok(frame) = read_frame(&CONTEXT, &made) {
        frame.particles.check().expect("particles that were read");
    }
});
