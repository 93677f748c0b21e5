//! The calls of a client that was built when the protocol was of version 1.0, recorded on their way over the wire, and the same
//! as a version before it.

use std::io::{Read, Write};

use relievo_client::{
    Activity, Chunk, Failure, FilePartResult, FrameInfo, MAX_MESSAGE, Message, Scanner, SceneList, Status, Values,
    Welcome, decode, parse,
};
use relievo_core::{Error, ErrorKind};

use super::faults::{raw, rest};
use super::{local_frames, options, start};

/// `hello`, `file.missing`, `scene.submit`, `scene.wait`, `frame.info`, `frame.fetch`, `frame.file`, `scene.list` and
/// `scene.remove`, with the numbers 0 to 8.
const CALLS: &[u8] = include_bytes!("../../../../tests/golden/exchange-1.0.msgpack");
/// What is simulated in it.
const SCENE: &str = "frames = 2\n[fluid]\nspacing = 0.05\n[basin]\nlow = [0, 0, 0]\nhigh = [0.4, 0.4, 0.4]\n[[block]]\n\
    low = [0, 0, 0]\nhigh = [0.2, 0.2, 0.2]\n";

/// Returns the whole messages of bytes.
fn messages(mut bytes: &[u8]) -> Vec<&[u8]> {
    let mut found = Vec::new();
    while let Some(length) = Scanner::new(MAX_MESSAGE).scan(bytes).unwrap() {
        found.push(&bytes[..length]);
        bytes = &bytes[length..];
    }
    found
}

#[test]
fn a_client_of_version_1_0_gets_what_it_asks_for() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(options(folder.path()));
    let mut stream = raw(&server);
    stream.write_all(CALLS).unwrap();
    let mut bytes = Vec::new();
    while messages(&bytes).len() < 9 {
        let mut part = [0; 4096];
        let read = stream.read(&mut part).unwrap();
        assert!(read > 0, "the server closed the connection");
        bytes.extend_from_slice(&part[..read]);
    }
    let results: Vec<&[u8]> = (0..)
        .zip(messages(&bytes))
        .map(|(number, message)| match parse(message).unwrap() {
            Message::Response { id, error: [0xc0], result } if id == number => result,
            other => panic!("call {number}: {other:x?}"),
        })
        .collect();
    assert_eq!(results.len(), 9);
    assert_eq!(decode::<Welcome>(results[0]).unwrap().version[0], 1);
    let status: Status = decode(results[3]).unwrap();
    assert_eq!((status.state, status.ready, status.particles), (Activity::Done, 3, 64));
    assert_eq!(decode::<FrameInfo>(results[4]).unwrap().count, 64);
    let chunk: Chunk = decode(results[5]).unwrap();
    let Values::Floats(places) = chunk.columns[0].values(chunk.count).unwrap() else { panic!("floats") };
    assert!(places.len() == 3 * 64 && places.iter().all(|place| (0.0..0.4).contains(place)));
    let file: FilePartResult = decode(results[6]).unwrap();
    assert!(file.data == local_frames(SCENE)[2]);
    assert_eq!(decode::<SceneList>(results[7]).unwrap().scenes.len(), 1);
}

#[test]
fn a_client_of_an_older_protocol_gets_a_typed_error_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(options(folder.path()));
    // The same calls, of version 0.9.
    let version = CALLS.windows(10).position(|bytes| bytes == b"version\x92\x01\x00").unwrap() + 8;
    let mut older = CALLS.to_vec();
    older[version..version + 2].copy_from_slice(&[0, 9]);
    let mut stream = raw(&server);
    stream.write_all(&older).unwrap();
    stream.shutdown(std::net::Shutdown::Write).unwrap();
    let answer = rest(stream);
    let answers: Vec<Message> = messages(&answer).into_iter().map(|it| parse(it).unwrap()).collect();
    let [Message::Response { id: 0, error, result: [0xc0] }] = answers[..] else { panic!("{answer:x?}") };
    let error = Error::from(decode::<Failure>(error).unwrap());
    assert_eq!(error.kind, ErrorKind::Unsupported);
    assert!(error.what.contains("0.9") && !error.remedy.is_empty(), "{error}");
    // Nothing of what followed was done.
    let mut client = super::connect(&server);
    let scenes: SceneList = client.call("scene.list", &relievo_client::Nothing {}).unwrap();
    assert!(scenes.scenes.is_empty());
}
