//! One fluid in several processes that connect by TCP.

use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::{DAM, relievo, text};

/// The longest wait for a frame.
const PATIENCE: Duration = Duration::from_secs(60);

/// Begins all ranks, on free ports of this machine.
fn begin(folder: &Path, ranks: usize, output: &str) -> Vec<Child> {
    let listeners: Vec<_> = (0..ranks).map(|_| TcpListener::bind(("127.0.0.1", 0)).unwrap()).collect();
    let address = |listener: &TcpListener| listener.local_addr().unwrap().to_string();
    let addresses = listeners.iter().map(address).collect::<Vec<_>>().join(",");
    drop(listeners);
    let rank = |number: usize| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_relievo"));
        command.args(["fluid", "rank", "dam.toml", "-o", output, "--threads", "1", "--token-file", "token"]);
        command.args(["--ranks", &addresses, "--rank", &number.to_string()]).current_dir(folder);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    (0..ranks).map(rank).collect()
}

fn end(ranks: Vec<Child>) -> Vec<Output> {
    ranks.into_iter().map(|rank| rank.wait_with_output().unwrap()).collect()
}

/// Fails unless a folder has the frames that one process made, to the bit.
fn are_same(folder: &Path, output: &str, frames: u32) {
    for number in 0..=frames {
        let read = |output: &str| std::fs::read(folder.join(output).join(format!("{number:04}.rlvfluid"))).unwrap();
        assert!(read(output) == read("whole"), "{output}: frame {number}");
    }
}

#[test]
fn processes_make_the_frames_of_one_and_go_on_where_one_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let jet = "[[emitter]]\ndisc = { middle = [0.6, 0.15, 0.4], normal = [1, 0, 0], radius = 0.1 }\nspeed = 2\n";
    let long = DAM.replace("frames = 3", "frames = 16").replace("[fluid]", "[fluid]\nsolver = \"dfsph\"");
    std::fs::write(folder.join("dam.toml"), long + jet).unwrap();
    std::fs::write(folder.join("token"), "a secret of this run\n").unwrap();
    let done = relievo(folder, &["fluid", "sim", "dam.toml", "-o", "whole"]);
    assert!(done.status.success(), "{done:?}");

    let done = end(begin(folder, 2, "two"));
    assert!(done.iter().all(|rank| rank.status.success()), "{done:?}");
    let table = text(&done[0].stdout);
    assert!(table.contains("16 frames in ") && table.contains("imbalance: ") && done[1].stdout.is_empty(), "{table}");
    are_same(folder, "two", 16);

    let mut ranks = begin(folder, 2, "killed");
    let start = Instant::now();
    while !folder.join("killed/0002.rlvfluid").exists() {
        assert!(start.elapsed() < PATIENCE && ranks[0].try_wait().unwrap().is_none(), "there is no frame 2");
        std::thread::sleep(Duration::from_millis(1));
    }
    ranks[1].kill().unwrap();
    let done = end(ranks);
    let said = text(&done[0].stderr);
    assert!(done[0].status.code() == Some(1) && said.contains("rank 1: a domain of the fluid has ended"), "{done:?}");
    // More ranks go on from what fewer have made.
    let done = end(begin(folder, 3, "killed"));
    assert!(done.iter().all(|rank| rank.status.success()), "{done:?}");
    are_same(folder, "killed", 16);
}

#[test]
fn ranks_of_other_descriptions_or_machines_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let others = tempfile::tempdir().unwrap();
    for (folder, description) in [(&folder, DAM.to_owned()), (&others, DAM.replace("0.5]\n", "0.45]\n"))] {
        std::fs::write(folder.path().join("dam.toml"), description).unwrap();
        std::fs::write(folder.path().join("token"), "a secret of this run\n").unwrap();
    }
    let begin = |folder: &Path, addresses: &str, number: &str| {
        let arguments = ["fluid", "rank", "dam.toml", "-o", "frames", "--ranks", addresses, "--rank", number];
        Command::new(env!("CARGO_BIN_EXE_relievo")).args(arguments).current_dir(folder).stderr(Stdio::piped()).spawn()
    };
    let listener = TcpListener::bind(("127.0.0.1", 0)).unwrap();
    // The last rank does not listen.
    let addresses = format!("{},127.0.0.1:1", listener.local_addr().unwrap());
    drop(listener);
    let ranks = [begin(folder.path(), &addresses, "0").unwrap(), begin(others.path(), &addresses, "1").unwrap()];
    for rank in end(ranks.into()) {
        let said = text(&rank.stderr);
        assert!(rank.status.code() == Some(1) && said.contains("do not simulate the same"), "{said}");
    }
    let remote =
        relievo(folder.path(), &["fluid", "rank", "dam.toml", "-o", "x", "--ranks", "192.0.2.1", "--rank", "0"]);
    assert!(
        remote.status.code() == Some(1) && text(&remote.stderr).contains("--allow-remote-connections"),
        "{remote:?}"
    );
}
