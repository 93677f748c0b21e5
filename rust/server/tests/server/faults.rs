//! Strangers and faults: nothing that was confirmed is lost, and nobody else notices.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use relievo_client::{Address, Client, ClientOptions, FileList, FilePut, Hash, Hello, Submit, VERSION, request};
use relievo_core::progress::Silent;
use relievo_core::{ErrorKind, Result};
use relievo_server::{FluidKind, Limits, Server, ServerOptions};

use super::{DAM, client_options, connect, fetched, limited, local_frames, options, scene, start};

pub fn raw(server: &Server) -> TcpStream {
    let Address::Tcp { port, .. } = server.address() else { panic!("a TCP server") };
    let stream = TcpStream::connect(("127.0.0.1", *port)).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    stream
}

/// A connection that has said hello.
pub fn greeted(server: &Server) -> TcpStream {
    let mut stream = raw(server);
    let hello = Hello { version: VERSION, client: String::new(), token: String::new() };
    stream.write_all(&request(1, "hello", &hello).unwrap()).unwrap();
    let mut answer = [0; 4];
    stream.read_exact(&mut answer).unwrap();
    assert_eq!(answer, [0x94, 1, 1, 0xc0]);
    stream
}

/// Reads until the server closes the connection.
pub fn rest(mut stream: TcpStream) -> Vec<u8> {
    let mut bytes = Vec::new();
    // A connection that is reset is closed too.
    let _ = stream.read_to_end(&mut bytes);
    bytes
}

fn contains(bytes: &[u8], text: &str) -> bool {
    bytes.windows(text.len()).any(|window| window == text.as_bytes())
}

#[test]
fn tokens_open_the_scenes_of_their_users_and_no_others() {
    let folder = tempfile::tempdir().unwrap();
    let tokens = folder.path().join("tokens");
    let [anna, berta] = ["a-token-of-anna-0001", "a-token-of-berta-0002"];
    std::fs::write(&tokens, format!("# users\nanna {anna}\n\nberta {berta}\n")).unwrap();
    let server = start(ServerOptions { tokens: Some(tokens.clone()), ..options(&folder.path().join("cache")) });
    let connect =
        |token: &str| Client::connect(ClientOptions { token: token.into(), ..client_options(server.address()) });
    for wrong in ["", "anna", "a-token-of-anna-0002", &anna[1..], &format!("{anna} ")] {
        let error = connect(wrong).err().expect("a wrong token");
        assert!(error.what.contains("token") && !error.to_string().contains(anna), "{error}");
    }
    let (mut anna, mut berta) = (connect(anna).unwrap(), connect(berta).unwrap());
    assert_eq!((anna.welcome().user.as_str(), berta.welcome().user.as_str()), ("anna", "berta"));
    anna.submit(&scene("dam", DAM)).unwrap();
    assert_eq!(berta.status("dam").unwrap_err().kind, ErrorKind::NotFound);
    // The file of a mesh is its owner's alone, also for clients that know its hash.
    let put = |data: &[u8]| FilePut {
        name: "a.obj".into(),
        hash: Hash::of(data),
        size: data.len() as u64,
        offset: 0,
        data: data.to_vec(),
    };
    let content = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let _: relievo_client::FilePutResult = anna.call("file.put", &put(content)).unwrap();
    let list = FileList { files: [("a.obj".to_owned(), Hash::of(content))].into() };
    let missing = |client: &mut Client| client.call::<FileList>("file.missing", &list).unwrap().files.len();
    assert_eq!((missing(&mut anna), missing(&mut berta)), (0, 1));

    for text in ["", "anna", "anna short", "anna a-token-of-anna-0001\nanna a-token-of-anna-0003"] {
        std::fs::write(&tokens, text).unwrap();
        let options = ServerOptions { tokens: Some(tokens.clone()), ..options(&folder.path().join("other")) };
        let error = Server::start(options, vec![Box::new(FluidKind::default())]).err().expect("a wrong file of tokens");
        assert!(!error.to_string().contains("0003"), "the error shows a token: {error}");
    }
}

#[test]
fn listening_for_other_machines_needs_tokens_and_encryption() {
    let folder = tempfile::tempdir().unwrap();
    let try_start = |insecure: bool| -> Result<Server> {
        let listen = Address::Tcp { host: "0.0.0.0".into(), port: 0, tls: false };
        Server::start(
            ServerOptions { listen, insecure, ..options(folder.path()) },
            vec![Box::new(FluidKind::default())],
        )
    };
    let error = try_start(false).err().expect("a server for everybody");
    assert!(error.remedy.contains("--allow-remote-connections-without-encryption"), "{error}");
    assert!(try_start(true).is_ok());
    let metrics = Some(Address::Tcp { host: "0.0.0.0".into(), port: 0, tls: false });
    let options = ServerOptions { metrics, ..options(folder.path()) };
    assert!(Server::start(options, vec![Box::new(FluidKind::default())]).is_err());
}

#[test]
fn wrong_messages_end_their_connection_and_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let server = limited(folder.path(), Limits { message: Duration::from_millis(300), ..Limits::default() });
    let mut client = connect(&server);
    client.submit(&scene("dam", DAM)).unwrap();
    let deep = vec![0x91; 100_000];
    let long_text = [&b"\x94\x00\x01\xdb\xff\xff\xff\xff"[..], &[b'a'; 1000]].concat();
    let wide = b"\x94\x00\x01\xa4ping\xdd\xff\xff\xff\xff".to_vec();
    for (name, bytes) in [("deep", &deep), ("long", &long_text), ("wide", &wide), ("no MessagePack", &vec![0xc1; 10])] {
        let mut stream = greeted(&server);
        stream.write_all(bytes).unwrap();
        let answer = rest(stream);
        assert!(contains(&answer, "kind"), "{name}: an answer says why");
    }
    // Before hello, less is taken.
    let mut stream = raw(&server);
    stream.write_all(&[&b"\x94\x00\x01\xa5hello\x91\x81\xa1a\xc5\x20\x00"[..], &[0; 5000]].concat()).ok();
    rest(stream);
    let mut stream = raw(&server);
    stream.write_all(&request(3, "scene.list", &relievo_client::Nothing {}).unwrap()).unwrap();
    assert!(contains(&rest(stream), "hello"), "the first call is hello");
    // A message that does not go on, and a client that goes within one.
    let mut slow = greeted(&server);
    slow.write_all(b"\x94\x00\x01\xa4pi").unwrap();
    rest(slow);
    let mut gone = greeted(&server);
    gone.write_all(b"\x94\x00\x01\xa4pi").unwrap();
    drop(gone);
    // Calls that are wrong fail alone.
    for (method, bytes) in
        [("no.method", &b"\x91\x80"[..]), ("scene.status", b"\x91\x80"), ("scene.status", b"\x91\x81\xa5scene\x01")]
    {
        let mut stream = greeted(&server);
        let call = [&b"\x94\x00\x02"[..], &[0xa0 | method.len() as u8], method.as_bytes(), bytes].concat();
        stream.write_all(&[call, request(3, "ping", &relievo_client::Nothing {}).unwrap()].concat()).unwrap();
        stream.shutdown(std::net::Shutdown::Write).unwrap();
        let answer = rest(stream);
        assert!(contains(&answer, "what") && answer.ends_with(b"\x94\x01\x03\xc0\x80"), "{method}: {answer:x?}");
    }
    client.wait("dam", 6, &mut Silent).unwrap();
    assert!(fetched(&mut client, "dam", 6) == local_frames(DAM)[6]);
}

#[test]
fn neighbouring_versions_are_understood_and_others_refused() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(options(folder.path()));
    // As a client of a later minor version says hello, with a key that this version does not have.
    let mut stream = raw(&server);
    stream.write_all(b"\x94\x00\x01\xa5hello\x91\x82\xa7version\x92\x01\x09\xa6future\xc3").unwrap();
    // As one of version 1.0 asks for all scenes, with no map of parameters.
    stream.write_all(b"\x94\x00\x02\xaascene.list\x90").unwrap();
    stream.shutdown(std::net::Shutdown::Write).unwrap();
    let answer = rest(stream);
    assert!(answer.ends_with(b"\x94\x01\x02\xc0\x81\xa6scenes\x90"), "{answer:x?}");
    let mut stream = raw(&server);
    stream.write_all(b"\x94\x00\x01\xa5hello\x91\x81\xa7version\x92\x02\x00").unwrap();
    let answer = rest(stream);
    assert!(contains(&answer, "unsupported") && contains(&answer, "protocol 2.0"), "{answer:x?}");
}

#[test]
fn hundreds_of_half_open_connections_do_not_keep_users_out() {
    let folder = tempfile::tempdir().unwrap();
    let limits = Limits { half_open: 32, connections: 64, ..Limits::default() };
    let server = limited(folder.path(), limits);
    let held: Vec<TcpStream> = (0..400).map(|_| raw(&server)).collect();
    let begin = Instant::now();
    let mut client = connect(&server);
    client.submit(&scene("dam", DAM)).unwrap();
    let more: Vec<TcpStream> = (0..200).map(|_| raw(&server)).collect();
    client.wait("dam", 6, &mut Silent).unwrap();
    drop((held, more));
    let stats: relievo_client::Stats = client.call("stats", &relievo_client::Nothing {}).unwrap();
    assert!(stats.values["relievo_connections_accepted_total"] >= 601.0);
    assert!(stats.values["relievo_connections_dropped_total"] >= 500.0, "{:?} in {:?}", stats, begin.elapsed());
}

#[test]
fn users_have_limits() {
    let folder = tempfile::tempdir().unwrap();
    let limits =
        Limits { scenes: 2, particles: 5000, frames: 100, files: 1000, user_connections: 2, ..Limits::default() };
    let server = limited(folder.path(), limits);
    let mut client = connect(&server);
    let limit = |client: &mut Client, submit: &Submit| {
        let error = client.submit(submit).unwrap_err();
        assert_eq!(error.kind, ErrorKind::Memory, "{error}");
    };
    limit(&mut client, &scene("fine", &DAM.replace("0.05", "0.0005")));
    limit(&mut client, &scene("long", &DAM.replace("frames = 6", "frames = 100")));
    for name in ["", "a\nb", &"x".repeat(200)] {
        assert_eq!(client.submit(&scene(name, DAM)).unwrap_err().kind, ErrorKind::Invalid);
    }
    // Names are keys and no paths.
    client.submit(&scene("../../etc/passwd", DAM)).unwrap();
    client.submit(&scene("..", DAM)).unwrap();
    limit(&mut client, &scene("third", DAM));
    let put = |size: u64, data: &[u8], name: &str| FilePut {
        name: name.into(),
        hash: Hash::of(data),
        size,
        offset: 0,
        data: data.to_vec(),
    };
    let mut refused = |put: &FilePut| client.call::<relievo_client::FilePutResult>("file.put", put).unwrap_err().kind;
    assert_eq!(refused(&put(2000, b"x", "a.obj")), ErrorKind::Memory);
    assert_eq!(refused(&put(1, b"xx", "a.obj")), ErrorKind::Invalid);
    for name in ["../../a.sh", "a", "a.gltf", "a.usda", "/etc/passwd"] {
        assert_eq!(refused(&put(1, b"x", name)), ErrorKind::Unsupported, "{name}");
    }
    assert_eq!(refused(&put(4, b"glTF", "a.obj")), ErrorKind::Unsupported);
    let mut wrong = put(3, b"abc", "a.obj");
    wrong.hash = Hash::of(b"abd");
    assert_eq!(refused(&wrong), ErrorKind::Invalid);
    let _second = connect(&server);
    let third = Client::connect(client_options(server.address()));
    assert_eq!(third.err().expect("a third connection").kind, ErrorKind::Busy);
    assert!(!folder.path().parent().unwrap().join("a.sh").exists());
}

#[test]
fn damaged_and_removed_frames_are_computed_again() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(options(folder.path()));
    let mut client = connect(&server);
    client.submit(&scene("dam", DAM)).unwrap();
    client.wait("dam", 6, &mut Silent).unwrap();
    let expected = local_frames(DAM);
    let info = |client: &mut Client, frame: u64| -> relievo_client::FrameInfo {
        client.call("frame.info", &relievo_client::FrameName { scene: "dam".into(), frame }).unwrap()
    };
    let path = |key: &str| folder.path().join("frames").join(&key[..2]).join(key);
    let [third, fourth] = [3, 4].map(|frame| path(&info(&mut client, frame).key));
    let mut bytes = std::fs::read(&fourth).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    std::fs::write(&fourth, bytes).unwrap();
    std::fs::remove_file(&third).unwrap();
    let part = relievo_client::FilePart { scene: "dam".into(), frame: 4, offset: 0, length: 1 << 22 };
    let error = client.call::<relievo_client::FilePartResult>("frame.file", &part).expect_err("a damaged frame");
    assert_eq!(error.kind, ErrorKind::Busy, "{error}");
    // To compute frame 4, frame 3 is computed again too, since it is gone.
    client.wait("dam", 6, &mut Silent).unwrap();
    assert!((0..7).all(|frame| fetched(&mut client, "dam", frame) == expected[frame as usize]));
}

#[test]
fn a_failing_simulation_and_a_full_cache_say_why_and_others_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let server = limited(folder.path(), Limits { cache: 60_000, ..Limits::default() });
    let mut client = connect(&server);
    // Fixed steps far beyond what is stable.
    let unstable = DAM.replace("viscosity", "time_step = 0.04\nviscosity");
    client.submit(&scene("unstable", &unstable)).unwrap();
    client.submit(&scene("large", &DAM.replace("0.05", "0.02"))).unwrap();
    client.submit(&scene("dam", DAM)).unwrap();
    client.wait("dam", 6, &mut Silent).unwrap();
    let error = client.wait("large", 6, &mut Silent).unwrap_err();
    assert!(error.to_string().contains("cache"), "{error}");
    let _ = client.wait("unstable", 6, &mut Silent);
}

#[test]
fn health_and_metrics_are_served_over_http() {
    let folder = tempfile::tempdir().unwrap();
    let metrics = Some(Address::Tcp { host: "127.0.0.1".into(), port: 0, tls: false });
    let server = start(ServerOptions { metrics, ..options(folder.path()) });
    let Some(Address::Tcp { port, .. }) = server.metrics() else { panic!("metrics over TCP") };
    let get = |path: &str| {
        let mut stream = TcpStream::connect(("127.0.0.1", *port)).unwrap();
        stream.write_all(format!("GET {path} HTTP/1.1\r\nHost: a\r\n\r\n").as_bytes()).unwrap();
        String::from_utf8(rest(stream)).unwrap()
    };
    assert!(get("/healthz").starts_with("HTTP/1.1 200 OK") && get("/healthz").ends_with("ok\n"));
    let text = get("/metrics");
    assert!(text.contains("# TYPE relievo_requests_total counter\nrelievo_requests_total 0\n"), "{text}");
    assert!(get("/other").starts_with("HTTP/1.1 404"));
}
