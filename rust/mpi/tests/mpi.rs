//! `relievo-mpi` with mpirun: the frames of one process, and a rank that is killed.

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use relievo_simulation::{Description, Making, Simulation, in_folder};

const DAM: &str = "frames = 6\nfps = 24\n[fluid]\nspacing = 0.05\nsolver = \"dfsph\"\n[basin]\nlow = [0, 0, 0]\n\
    high = [1.2, 0.3, 1]\n[[block]]\nlow = [0, 0, 0]\nhigh = [0.4, 0.3, 0.8]\nvelocity = [2, 0, 0]\n";
/// A jet into the dam, rain that lives for a short time, and a sink.
const SOURCES: &str = "[[emitter]]\ndisc = { middle = [0.2, 0.15, 0.9], normal = [1, 0, 0], radius = 0.1 }\n\
    speed = 3\ncolor = [0.2, 0.4, 0.8]\n[[emitter]]\nspeed = 2\nlifetime = 0.1\n\
    rectangle = { middle = [0.9, 0.15, 0.8], sides = [[0.1, 0, 0], [0, -0.1, 0]] }\n\
    [[sink]]\nbox = { low = [1, 0, 0], high = [1.2, 0.3, 0.1] }\n";
/// The longest wait for a frame.
const PATIENCE: Duration = Duration::from_secs(60);

/// The command on so many ranks, whatever the cores and whoever runs it. Ranks of one machine need no network.
fn command(folder: &Path, ranks: usize, output: &str) -> Command {
    let mut command = Command::new("mpirun");
    command.args(["--oversubscribe", "--allow-run-as-root", "--mca", "btl", "self,vader", "-n", &ranks.to_string()]);
    // Processes of a container may not read each other's memory.
    command.args(["--mca", "btl_vader_single_copy_mechanism", "none"]);
    command.arg(env!("CARGO_BIN_EXE_relievo-mpi")).args(["dam.toml", "-o", output]).current_dir(folder);
    command
}

fn run(folder: &Path, ranks: usize, output: &str) -> Output {
    command(folder, ranks, output).output().unwrap()
}

fn has_mpirun() -> bool {
    let found = Command::new("mpirun").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    let found = found.is_ok_and(|status| status.success());
    if !found {
        println!("skipped: mpirun is not installed");
    }
    found
}

fn folder(description: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dam.toml"), description).unwrap();
    folder
}

/// The frames of one process, as files have them.
fn frames(description: &str) -> Vec<Vec<u8>> {
    let context = relievo_core::Context::serial();
    let making = Making { format: "rlvfluid".into(), parts: 1, device: None };
    let description = Description::parse(description).unwrap();
    let mut simulation = Simulation::begin(&context, description, &in_folder(Path::new("")), making).unwrap();
    let mut frames = vec![simulation.encode(&context).unwrap()];
    while simulation.step() < simulation.last() {
        simulation.advance(&context, |_| Ok(())).unwrap();
        frames.push(simulation.encode(&context).unwrap());
    }
    frames
}

fn are_same(folder: &Path, output: &str, expected: &[Vec<u8>]) {
    for (number, expected) in expected.iter().enumerate() {
        let path = folder.join(output).join(format!("{number:04}.rlvfluid"));
        assert!(std::fs::read(&path).unwrap() == *expected, "{}", path.display());
    }
}

#[test]
fn ranks_make_the_frames_of_one_process_to_the_bit() {
    if !has_mpirun() {
        return;
    }
    let (folder, expected) = (folder(DAM), frames(DAM));
    for ranks in [1, 2, 4] {
        let output = format!("frames-{ranks}");
        let done = run(folder.path(), ranks, &output);
        assert!(done.status.success(), "{done:?}");
        let text = String::from_utf8_lossy(&done.stdout);
        println!("{text}");
        assert!(text.contains("imbalance") && text.lines().count() == 3 + ranks, "{text}");
        are_same(folder.path(), &output, &expected);
    }
}

#[test]
fn emitters_and_sinks_do_on_ranks_what_they_do_in_one_process() {
    if !has_mpirun() {
        return;
    }
    let description = format!("{DAM}{SOURCES}");
    let (folder, expected) = (folder(&description), frames(&description));
    assert!(expected[6].len() > expected[0].len(), "particles were emitted");
    for ranks in [2, 3] {
        let output = format!("frames-{ranks}");
        let done = run(folder.path(), ranks, &output);
        assert!(done.status.success(), "{done:?}");
        are_same(folder.path(), &output, &expected);
    }
}

#[test]
fn a_rank_that_is_killed_costs_a_restart_from_the_last_frame() {
    if !has_mpirun() {
        return;
    }
    let long = DAM.replace("frames = 6", "frames = 24");
    let (folder, expected) = (folder(&long), frames(&long));
    let mut running = command(folder.path(), 2, "frames").stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let begin = Instant::now();
    while !folder.path().join("frames/0003.rlvfluid").exists() {
        assert!(begin.elapsed() < PATIENCE && running.try_wait().unwrap().is_none(), "there is no frame 3");
        std::thread::sleep(Duration::from_millis(5));
    }
    kill_a_rank(&running);
    let ended = running.wait().unwrap();
    assert!(!ended.success());
    let there = std::fs::read_dir(folder.path().join("frames")).unwrap().count();
    assert!((4..25).contains(&there), "{there}");
    // More ranks go on from what fewer have made.
    let done = run(folder.path(), 3, "frames");
    assert!(done.status.success(), "{done:?}");
    are_same(folder.path(), "frames", &expected);
}

/// Kills the last child of mpirun, a rank.
fn kill_a_rank(mpirun: &Child) {
    let children = std::fs::read_to_string(format!("/proc/{0}/task/{0}/children", mpirun.id())).unwrap();
    let rank = children.split_whitespace().last().unwrap();
    assert!(Command::new("kill").args(["-9", rank]).status().unwrap().success());
}

#[test]
fn what_cannot_be_simulated_ends_all_ranks_with_a_message() {
    if !has_mpirun() {
        return;
    }
    let folder = folder("frames = no");
    let done = run(folder.path(), 2, "frames");
    assert!(!done.status.success() && String::from_utf8_lossy(&done.stderr).contains("rank "), "{done:?}");
}
