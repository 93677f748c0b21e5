//! Servers that are killed at any moment go on at the last whole frame.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use relievo_client::{Activity, Address, Client};
use relievo_core::progress::Silent;
use relievo_server::ServerOptions;

use super::{DAM, client_options, fetched, local_frames, options, scene, start};

/// Kills. Each lets the server get a bit farther.
const KILLS: u64 = 40;

/// The process that the next test kills: a server.
#[test]
fn serves_until_it_is_killed() {
    let Some(folder) = std::env::var_os("RELIEVO_TEST_SERVER") else { return };
    let folder = Path::new(&folder);
    let listen = Address::Unix(folder.join("socket"));
    let _server = start(ServerOptions { listen, ..options(&folder.join("cache")) });
    std::thread::sleep(Duration::from_secs(60));
}

fn begin(folder: &Path) -> Child {
    Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "killed::serves_until_it_is_killed", "--nocapture", "--test-threads=1"])
        .env("RELIEVO_TEST_SERVER", folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

#[cfg(unix)]
#[test]
fn nothing_that_was_confirmed_is_lost_by_kills() {
    let folder = tempfile::tempdir().unwrap();
    let description = DAM.replace("frames = 6", "frames = 30");
    let address = Address::Unix(folder.path().join("socket"));
    let mut server = begin(folder.path());
    let mut client = Client::connect(client_options(&address)).unwrap();
    client.submit(&scene("dam", &description)).unwrap();
    let mut confirmed = 0;
    for kill in 0..KILLS {
        // From at once to some frames later, at odd moments.
        std::thread::sleep(Duration::from_micros(kill * 7919 % 60_000));
        confirmed = client.status("dam").unwrap().ready.max(confirmed);
        server.kill().unwrap();
        server.wait().unwrap();
        server = begin(folder.path());
        let status = client.status("dam").unwrap();
        assert!(status.ready >= confirmed, "{} frames of {confirmed} after kill {kill}", status.ready);
        confirmed = status.ready;
    }
    let status = client.wait("dam", 30, &mut Silent).unwrap();
    assert_eq!(status.state, Activity::Done);
    let expected = local_frames(&description);
    assert!((0..31).all(|frame| fetched(&mut client, "dam", frame) == expected[frame as usize]));
    server.kill().unwrap();
    server.wait().unwrap();
}
