//! A client in another language, with nothing but `msgpack`.

use std::process::Command;

use relievo_client::Address;
use relievo_server::Server;

use super::{DAM, local_frames, options, start};

/// The client: submits, waits, fetches the last frame twice, as a file and as columns, and prints what it got.
const CLIENT: &str = r#"
import hashlib, socket, struct, sys
import msgpack

host, port, description = "127.0.0.1", int(sys.argv[1]), sys.argv[2]
link = socket.create_connection((host, port))
unpacker = msgpack.Unpacker(raw=False, max_buffer_size=1 << 25)
count = 0

def call(method, **parameters):
    global count
    count += 1
    link.sendall(msgpack.packb([0, count, method, [parameters]]))
    while True:
        for message in unpacker:
            kind, number, error, result = message
            assert (kind, number) == (1, count), message
            if error is not None:
                raise RuntimeError(error)
            return result
        data = link.recv(1 << 16)
        assert data, "the server closed the connection"
        unpacker.feed(data)

welcome = call("hello", version=[1, 0], client="python")
assert welcome["user"] == "local" and "fluid" in welcome["kinds"], welcome
call("scene.submit", scene="from python", kind="fluid", description=description)
while True:
    status = call("scene.wait", scene="from python", frame=6, seconds=5.0)
    assert status["state"] in ("running", "done"), status
    if status["ready"] == 7:
        break
file = b""
while True:
    part = call("frame.file", scene="from python", frame=6, offset=len(file), length=1000)
    file += part["data"]
    if len(file) == part["size"]:
        break
chunk = call("frame.fetch", scene="from python", frame=6, channels=["position"])
column, = chunk["columns"]
assert (column["form"], column["layout"], column["packing"]) == ("f32", "rows", "none"), column
points = struct.unpack("<%df" % (3 * chunk["total"]), column["data"])
assert min(points) >= -0.1 and max(points) <= 0.9
try:
    call("scene.status", scene="none")
    raise SystemExit("there is no such scene")
except RuntimeError as error:
    assert error.args[0]["kind"] == "not_found", error
print(hashlib.sha256(file).hexdigest(), chunk["total"])
"#;

fn port(server: &Server) -> u16 {
    let Address::Tcp { port, .. } = server.address() else { panic!("a TCP server") };
    *port
}

#[test]
fn a_client_in_python_gets_the_frames_of_a_local_run() {
    let python = std::env::var("RELIEVO_MSGPACK_PYTHON").unwrap_or_else(|_| "python3".into());
    let has_msgpack = Command::new(&python).args(["-c", "import msgpack"]).output().is_ok_and(|it| it.status.success());
    if !has_msgpack {
        println!("skipped: {python} has no msgpack; set RELIEVO_MSGPACK_PYTHON to one that has");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let server = start(options(folder.path()));
    let run = Command::new(&python).args(["-c", CLIENT, &port(&server).to_string(), DAM]).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let expected = relievo_client::Hash::of(&local_frames(DAM)[6]).to_string();
    let printed = String::from_utf8(run.stdout).unwrap();
    let (hash, count) = printed.trim().split_once(' ').unwrap();
    assert_eq!((hash, count), (expected.as_str(), "256"));
}
