//! A server and a client whose system clock jumps by years each time that it is read: no time-out ends early, no wait lasts
//! longer, and frames are the same.

use std::io::{Read, Write};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, SystemTime};

use relievo_client::{Activity, Hello, Nothing, Status, Submit, VERSION, Wait, request};
use relievo_core::progress::Silent;

use super::faults::{greeted, raw};
use super::{DAM, connect, fetched, local_frames, options, scene, start};

const YEAR: Duration = Duration::from_secs(365 * 86400);

/// A library that takes the place of the system's function: the clock of the day is a year ahead and a year late in turn.
const CLOCK: &str = "
#define _GNU_SOURCE
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
int clock_gettime(clockid_t which, struct timespec *out) {
    static unsigned calls;
    long result = syscall(SYS_clock_gettime, which, out);
    if (result == 0 && which == CLOCK_REALTIME) {
        out->tv_sec += __sync_fetch_and_add(&calls, 1) % 2 ? 31536000 : -31536000;
    }
    return (int)result;
}
";

/// The process of the next test.
#[test]
fn lives_by_a_clock_that_jumps() {
    let Some(folder) = std::env::var_os("RELIEVO_TEST_CLOCK") else { return };
    let times: [SystemTime; 4] = std::array::from_fn(|_| SystemTime::now());
    let distance = |a: SystemTime, b: SystemTime| a.duration_since(b).unwrap_or_else(|error| error.duration());
    assert!(times.windows(2).all(|pair| distance(pair[0], pair[1]) > YEAR), "{times:?}");

    let server = start(options(&Path::new(&folder).join("cache")));
    // A greeting that has not ended, and a connection that is idle.
    let hello = request(1, "hello", &Hello { version: VERSION, client: String::new(), token: String::new() }).unwrap();
    let (begin, end) = hello.split_at(5);
    let mut slow = raw(&server);
    slow.write_all(begin).unwrap();
    let mut idle = greeted(&server);
    let mut client = connect(&server);
    client.submit(&scene("dam", DAM)).unwrap();
    assert_eq!(client.wait("dam", 6, &mut Silent).unwrap().state, Activity::Done);
    let expected = local_frames(DAM);
    assert!((0..7).all(|frame| fetched(&mut client, "dam", frame) == expected[frame as usize]));
    // A wait for a frame that does not come ends.
    client.submit(&Submit { forced: true, ..scene("forced", DAM) }).unwrap();
    client.wait("forced", 0, &mut Silent).unwrap();
    let waiting = Wait { scene: "forced".into(), frame: 1, seconds: 0.05 };
    let status: Status = client.call("scene.wait", &waiting).unwrap();
    assert_eq!((status.state, status.ready), (Activity::Forces, 1));

    slow.write_all(end).unwrap();
    idle.write_all(&request(2, "stats", &Nothing {}).unwrap()).unwrap();
    let mut answer = [0; 4];
    slow.read_exact(&mut answer).unwrap();
    assert_eq!(answer, [0x94, 1, 1, 0xc0]);
    println!("all answered");
}

#[test]
fn a_clock_that_jumps_ends_no_connection_and_no_wait_early_or_late() {
    let folder = tempfile::tempdir().unwrap();
    let [source, library] = ["clock.c", "clock.so"].map(|name| folder.path().join(name));
    std::fs::write(&source, CLOCK).unwrap();
    let built = Command::new("cc").args(["-shared", "-fPIC", "-O1", "-o"]).args([&library, &source]).status().unwrap();
    assert!(built.success());
    let done = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "clock::lives_by_a_clock_that_jumps", "--nocapture", "--test-threads=1"])
        .env("RELIEVO_TEST_CLOCK", folder.path())
        .env("LD_PRELOAD", &library)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&done.stdout);
    assert!(done.status.success() && text.contains("all answered"), "{text}{}", String::from_utf8_lossy(&done.stderr));
}
