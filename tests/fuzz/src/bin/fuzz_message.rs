//! Messages of the simulation server: the scanner finds the same end however they are cut, and what is decoded is harmless.
#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo_client::{
    Chunk, FilePartResult, FilePut, Force, Hello, Message, Scanner, Status, Steer, Submit, SurfacePart, Wait, decode, parameters,
    parse,
};

/// Bytes of a message at most.
const LIMIT: usize = 8 << 10;

fuzz_target!(|data: &[u8]| {
    let [step, data @ ..] = data else { return };
    let at_once = Scanner::new(LIMIT).scan(data);
    let mut scanner = Scanner::new(LIMIT);
    let mut in_pieces = Ok(None);
    for end in (0..data.len()).step_by(usize::from(*step) + 1).chain([data.len()]) {
        in_pieces = scanner.scan(&data[..end]);
        if !matches!(in_pieces, Ok(None)) {
            break;
        }
    }
    assert_eq!(at_once, in_pieces);
    let Ok(Some(length)) = at_once else { return };
    assert!(length <= LIMIT.min(data.len()));
    match parse(&data[..length]) {
        Ok(Message::Request { parameters: bytes, .. } | Message::Notification { parameters: bytes, .. }) => {
            let _ = parameters::<Hello>(bytes);
            let _ = parameters::<Submit>(bytes);
            let _ = parameters::<FilePut>(bytes);
            let _ = parameters::<Wait>(bytes);
            let _ = parameters::<Steer>(bytes);
            let _ = parameters::<Force>(bytes);
            let _ = parameters::<SurfacePart>(bytes);
        }
        Ok(Message::Response { result, .. }) => {
            let _ = decode::<Status>(result);
            let _ = decode::<FilePartResult>(result);
            let Ok(chunk) = decode::<Chunk>(result) else { return };
            for column in &chunk.columns {
                let _ = column.values(chunk.count);
            }
        }
        Err(_) => {}
    }
});
