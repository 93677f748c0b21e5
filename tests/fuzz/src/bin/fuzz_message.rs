//! Messages of the simulation server and its client: the scanner finds the same end however they are cut, and what is decoded
//! is harmless, the parameters and results of every method.
#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo_client::{
    Chunk, Failure, Fetch, FileList, FilePart, FilePartResult, FilePut, FilePutResult, Force, FrameInfo, FrameName,
    Hello, MAX_CHUNK, Message, Nothing, Scanner, SceneList, SceneName, Stats, Status, Steer, Submit, SurfacePart, Wait,
    Welcome, decode, failure, parameters, parse, request,
};
use relievo_core::Error;

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
        Ok(Message::Request { id, method, parameters }) => {
            called(parameters);
            // What is decoded is encoded as a message that is understood.
            if let Ok(scene) = relievo_client::parameters::<SceneName>(parameters) {
                let again = request(id, method, &scene).expect("a request");
                let Ok(Message::Request { id: same, method: name, .. }) = parse(&again) else { panic!("a request") };
                assert_eq!((same, name), (id, method));
            }
        }
        Ok(Message::Notification { parameters, .. }) => called(parameters),
        Ok(Message::Response { id, error, result }) => answered(id, error, result),
        Err(error) => assert!(!error.what.is_empty()),
    }
});

/// What a server does with the parameters of a call.
fn called(bytes: &[u8]) {
    let _ = parameters::<Hello>(bytes);
    let _ = parameters::<Submit>(bytes);
    let _ = parameters::<FilePut>(bytes);
    let _ = parameters::<FileList>(bytes);
    let _ = parameters::<Wait>(bytes);
    let _ = parameters::<Steer>(bytes);
    let _ = parameters::<Force>(bytes);
    let _ = parameters::<FrameName>(bytes);
    let _ = parameters::<Fetch>(bytes);
    let _ = parameters::<FilePart>(bytes);
    let _ = parameters::<SurfacePart>(bytes);
    let _ = parameters::<Nothing>(bytes);
}

/// What a client does with the answer to a call.
fn answered(id: u32, error: &[u8], result: &[u8]) {
    if let Ok(refused) = decode::<Failure>(error) {
        let error = Error::from(refused);
        let again = failure(id, &Failure::from(&error)).expect("a failure");
        let Ok(Message::Response { error: found, .. }) = parse(&again) else { panic!("a failure") };
        assert_eq!(Error::from(decode::<Failure>(found).expect("a failure")), error);
    }
    let _ = decode::<Welcome>(result);
    let _ = decode::<Status>(result);
    let _ = decode::<SceneList>(result);
    let _ = decode::<FileList>(result);
    let _ = decode::<FilePutResult>(result);
    let _ = decode::<FrameInfo>(result);
    let _ = decode::<FilePartResult>(result);
    let _ = decode::<Stats>(result);
    let Ok(chunk) = decode::<Chunk>(result) else { return };
    for column in &chunk.columns {
        if let Ok(values) = column.values(chunk.count) {
            assert!(chunk.count <= MAX_CHUNK, "{} particles", chunk.count);
            drop(values);
        }
    }
}
