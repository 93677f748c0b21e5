//! Files of the cache of the simulation server: arbitrary bytes, and files whose head is right so far and whose contents are
//! not. What is read is written back the same, whole and in parts.
#![no_main]

use std::io::Cursor;

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;

// The server's reader alone, without its network.
#[path = "../../../../rust/server/src/object.rs"]
mod object;

use object::Object;

/// A file that says what it should about itself, mostly.
fn file(bytes: &mut Unstructured) -> Result<Vec<u8>> {
    let key: [u8; 32] = bytes.arbitrary()?;
    let version = if bytes.ratio(1, 16)? { bytes.arbitrary()? } else { 1_u32 };
    let repeats = *bytes.choose(&[1_usize, 1, 1, 1, 70_000])?;
    let [size, sums] = [bytes.ratio(1, 8)?, bytes.ratio(1, 8)?];
    let wrong: [u64; 2] = bytes.arbitrary()?;
    let content = bytes.bytes(bytes.len())?.repeat(repeats);
    let content = &content[..content.len().min(3 << 20)];
    let mut file = b"RLVCACHE".to_vec();
    file.extend(version.to_le_bytes());
    file.extend(key);
    file.extend(if size { wrong[0] } else { content.len() as u64 }.to_le_bytes());
    file.extend(crc32fast::hash(&file).to_le_bytes());
    let mut table: Vec<u8> = content.chunks(1 << 20).flat_map(|chunk| crc32fast::hash(chunk).to_le_bytes()).collect();
    if sums && !table.is_empty() {
        let at = wrong[1] as usize % table.len();
        table[at] ^= 1;
    }
    let sum = crc32fast::hash(&table);
    file.extend(table);
    file.extend(sum.to_le_bytes());
    file.extend(content);
    Ok(file)
}

fuzz_target!(|data: &[u8]| {
    let made = match data.split_first() {
        Some((1, rest)) => file(&mut Unstructured::new(rest)).unwrap_or_default(),
        _ => data.to_vec(),
    };
    let Ok(mut found) = Object::open(Cursor::new(&made), made.len() as u64) else { return };
    assert_eq!(object::file_size(found.size()), made.len() as u64);
    let Ok(content) = found.part(0, usize::MAX) else { return };
    assert_eq!(content.len() as u64, found.size());
    let mut again = Vec::new();
    object::write(&mut again, found.key(), &content).expect("a vector");
    assert!(again == made, "it is written as it was read");
    let step = (content.len() / 3).max(1);
    let parts = (0..content.len()).step_by(step).map(|at| found.part(at as u64, step).expect("a part"));
    assert!(parts.flatten().eq(content.iter().copied()), "its parts are the whole");
    assert!(found.part(u64::MAX, usize::MAX).is_ok_and(|part| part.is_empty()));
});
