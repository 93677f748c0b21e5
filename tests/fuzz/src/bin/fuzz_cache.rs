//! Files of baked frames: arbitrary bytes, and files whose checksums are right and whose contents are not.
#![no_main]

use std::path::PathBuf;
use std::sync::LazyLock;

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use relievo_core::{Context, ContextOptions};
use relievo_scene::cache::{Cache, Identity};

/// A folder of this process.
static FOLDER: LazyLock<PathBuf> =
    LazyLock::new(|| std::env::temp_dir().join(format!("relievo-fuzz-{}", std::process::id())));

/// Header, index and blocks of a frame. Sizes are mostly what is there.
fn file(bytes: &mut Unstructured) -> Result<Vec<u8>> {
    let (objects, entries) = (bytes.int_in_range(0..=2_u32)?, bytes.int_in_range(0..=4_u64)?);
    let mut index = Vec::new();
    for _ in 0..12 * objects {
        index.extend(f64::from(bytes.arbitrary::<i8>()?).to_le_bytes());
    }
    let blocks = bytes.int_in_range(0..=3)?;
    let mut stored = Vec::new();
    for at in 0..entries {
        let content: Vec<u8> = bytes.bytes(usize::from(bytes.peek_bytes(1).map_or(0, |peek| peek[0] % 16)))?.to_vec();
        let packed = if at < blocks { zstd::bulk::compress(&content, 1).unwrap_or_default() } else { content.clone() };
        let small = |bytes: &mut Unstructured| bytes.int_in_range(0..=2_u32);
        for word in [small(bytes)?, small(bytes)?, small(bytes)?, crc32fast::hash(&packed)] {
            index.extend(word.to_le_bytes());
        }
        let offset = if bytes.ratio(1, 8)? { bytes.arbitrary()? } else { stored.len() as u64 };
        index.extend(offset.to_le_bytes());
        for length in [packed.len(), content.len()] {
            let length = if bytes.ratio(1, 8)? { bytes.arbitrary()? } else { length as u32 };
            index.extend(length.to_le_bytes());
        }
        stored.extend(packed);
    }
    let packed = zstd::bulk::compress(&index, 1).unwrap_or_default();
    let mut file = b"RLVCACHE".to_vec();
    for word in [1_u32, 0] {
        file.extend(word.to_le_bytes());
    }
    file.extend(7_u64.to_le_bytes());
    for word in [bytes.int_in_range(0..=1_u32)?, objects] {
        file.extend(word.to_le_bytes());
    }
    for number in [entries, packed.len() as u64, stored.len() as u64] {
        let number = if bytes.ratio(1, 8)? { bytes.arbitrary()? } else { number };
        file.extend(number.to_le_bytes());
    }
    file.extend(crc32fast::hash(&packed).to_le_bytes());
    file.extend(crc32fast::hash(&file).to_le_bytes());
    file.extend(packed);
    file.extend(stored);
    Ok(file)
}

fuzz_target!(|data: &[u8]| {
    let mut bytes = Unstructured::new(data);
    let Ok(raw) = bytes.ratio(1, 16) else { return };
    let content = if raw { data.to_vec() } else { file(&mut bytes).unwrap_or_default() };
    let Ok(context) = Context::new(&ContextOptions { threads: 1, memory_limit: 1 << 24 }) else { return };
    let Ok(cache) = Cache::new(&FOLDER, Identity { scene: 7, level: 0 }) else { return };
    if std::fs::write(FOLDER.join("frame-000000.rlvcache"), content).is_err() {
        return;
    }
    cache.state(0);
    if let Ok(frame) = cache.open(&context, 0) {
        let _ = frame.read(&context);
    }
});
