//! `relievo farm` as a user sees it: the files of each engine, the commands of chunks, and Slurm for real.

#![cfg(unix)]

#[path = "farm/cluster.rs"]
mod cluster;

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use cluster::Cluster;

const RELIEVO: &str = env!("CARGO_BIN_EXE_relievo");
const DAM: &str = "frames = 5\nfps = 24\n[fluid]\nspacing = 0.05\n[basin]\nlow = [0, 0, 0]\nhigh = [1.2, 0.3, 1]\n\
    [[block]]\nlow = [0, 0, 0]\nhigh = [0.4, 0.3, 0.8]\nvelocity = [2, 0, 0]\n";
/// Settings at which so small a fluid foams, and pictures that take little time.
const LOW: &str = "--energy 0.5,5 --trapped-air 0.5,5 --air-rate 300 --crest-rate 300";
const SMALL: &str = "--size 64x48 --samples 1";

fn relievo(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(RELIEVO).args(arguments).current_dir(folder).output().unwrap()
}

fn done(folder: &Path, arguments: &[&str]) -> String {
    let done = relievo(folder, arguments);
    assert!(done.status.success(), "{done:?}");
    String::from_utf8(done.stdout).unwrap()
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dam.toml"), DAM).unwrap();
    folder
}

/// The job of an engine that is written but not submitted, in chunks of 2 frames.
fn written(folder: &Path, engine: &str, more: &[&str]) {
    let fixed = ["farm", "submit", "dam.toml", "-o", "out", "--chunk", "2", "--write-only", "--engine", engine];
    done(folder, &[fixed.as_slice(), more].concat());
}

#[test]
fn the_files_of_each_engine_are_those_that_it_documents() {
    let files: [(&str, &[&str]); 3] = [
        ("slurm", &["simulate.sbatch", "mesh.sbatch", "foam.sbatch", "render.sbatch", "submit.sh", "plan.json"]),
        ("flamenco", &["job.json", "submit.sh"]),
        ("opencue", &["job.py", "submit.sh"]),
    ];
    for (engine, names) in files {
        let folder = folder();
        written(folder.path(), engine, &["--threads", "2", "--mesh-options", "--cell 0.75"]);
        for name in names {
            let text = std::fs::read_to_string(folder.path().join("out/farm").join(name)).unwrap();
            let text = text.replace(folder.path().to_str().unwrap(), "/projects");
            let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/farm").join(engine).join(name);
            assert_eq!(text, std::fs::read_to_string(&golden).unwrap(), "{}", golden.display());
        }
    }
}

#[test]
fn a_job_of_flamenco_has_what_its_schema_asks_for() {
    let folder = folder();
    written(folder.path(), "flamenco", &["--make", "mesh,render"]);
    let text = std::fs::read_to_string(folder.path().join("out/farm/job.json")).unwrap();
    let job: Value = serde_json::from_str(&text).unwrap();
    assert!(["name", "type", "submitter_platform"].iter().all(|key| job[key].is_string()) && job["priority"].is_u64());
    assert!(job["metadata"].as_object().unwrap().values().all(Value::is_string));
    // Settings have no nested structures.
    let settings = job["settings"].as_object().unwrap();
    assert!(settings.values().all(|value| value.is_string()));
    let plan: Value = serde_json::from_str(settings["plan"].as_str().unwrap()).unwrap();
    let stages: Vec<_> =
        plan["stages"].as_array().unwrap().iter().map(|stage| stage["name"].as_str().unwrap()).collect();
    assert_eq!(stages, ["simulate", "mesh", "render"]);
    // Each setting of the job is one of the job type.
    let script = std::fs::read_to_string(folder.path().join("out/farm/relievo.js")).unwrap();
    assert!(settings.keys().all(|key| script.contains(&format!("key: \"{key}\""))));
}

#[test]
fn jobs_that_cannot_be_are_refused() {
    let folder = folder();
    let at = folder.path();
    let submit = |more: &[&str]| relievo(at, &[&["farm", "submit", "dam.toml", "-o", "out"], more].concat());
    let code = |more: &[&str]| submit(more).status.code();
    assert_eq!(code(&["--engine", "slurm", "--name", "a b", "--write-only"]), Some(1));
    assert_eq!(code(&["--engine", "other"]), Some(2));
    assert_eq!(code(&["--engine", "slurm", "--chunk", "0"]), Some(2));
    assert_eq!(relievo(at, &["farm", "submit", "none.toml", "-o", "out", "--engine", "slurm"]).status.code(), Some(1));
    assert!(!at.join("out").exists());
    // Where the engine is not installed, the files stay.
    let mut alone = Command::new(RELIEVO);
    alone.args(["farm", "submit", "dam.toml", "-o", "out", "--engine", "opencue"]).current_dir(at);
    let refused =
        alone.env("PATH", "/usr/bin:/bin").env("PYTHONPATH", "").env("CUEBOT_HOSTS", "127.0.0.1:9").output().unwrap();
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("not submitted") && at.join("out/farm/job.py").exists());
}

#[test]
fn chunks_make_what_a_whole_run_makes_and_say_how_they_end() {
    let folder = folder();
    let at = folder.path();
    done(at, &["fluid", "sim", "dam.toml", "-o", "frames"]);
    done(at, &["fluid", "mesh", "frames", "-o", "whole"]);
    for frames in ["0..1", "2..3", "4..5"] {
        done(at, &["fluid", "mesh", "frames", "-o", "chunks", "--frames", frames]);
        let render = ["fluid", "render", "frames", "-o", "pictures", "--frames", frames];
        done(at, &[render.as_slice(), &SMALL.split(' ').collect::<Vec<_>>()].concat());
    }
    done(
        at,
        &[["fluid", "render", "frames", "-o", "at-once"].as_slice(), &SMALL.split(' ').collect::<Vec<_>>()].concat(),
    );
    let bytes = |path: String| std::fs::read(at.join(path)).unwrap();
    for frame in 0..=5 {
        assert!(bytes(format!("whole/{frame:04}.ply")) == bytes(format!("chunks/{frame:04}.ply")), "{frame}");
        assert!(bytes(format!("at-once/{frame:04}.png")) == bytes(format!("pictures/{frame:04}.png")), "{frame}");
    }
    let code = |arguments: &[&str]| relievo(at, arguments).status.code();
    // Frames that are not there may come: a farm tries again.
    assert_eq!(code(&["fluid", "mesh", "frames", "-o", "chunks", "--frames", "5..6"]), Some(1));
    assert_eq!(code(&["fluid", "render", "frames", "-o", "pictures", "--frames", "6..7"]), Some(1));
    assert_eq!(code(&["fluid", "mesh", "frames/0001.rlvfluid", "-o", "one.ply", "--frames", "1..1"]), Some(1));
    // Wrong usage does not get better.
    assert_eq!(code(&["fluid", "mesh", "frames", "-o", "chunks", "--frames", "3..1"]), Some(2));
    assert_eq!(code(&["fluid", "mesh", "frames", "-o", "chunks", "--frames", "all"]), Some(2));
    // A task that is run twice does the same.
    done(at, &["fluid", "sim", "dam.toml", "-o", "frames"]);
    done(at, &["fluid", "mesh", "frames", "-o", "chunks", "--frames", "2..3"]);
    assert!(bytes("whole/0003.ply".into()) == bytes("chunks/0003.ply".into()));
}

#[test]
fn slurm_runs_a_job_from_the_simulation_to_pictures() {
    let Some(cluster) = Cluster::start() else {
        println!("skipped: Slurm's slurmctld and slurmd, or munged, are not installed");
        return;
    };
    let folder = folder();
    let at = folder.path();
    let submit = |output: &str, program: &str| {
        let fixed = ["farm", "submit", "dam.toml", "-o", output, "--engine", "slurm", "--chunk", "2", "--threads", "1"];
        let options = ["--program", program, "--foam-options", LOW, "--render-options", SMALL];
        let mut command = Command::new(RELIEVO);
        let submitted = cluster.command(command.args(fixed).args(options).current_dir(at)).output().unwrap();
        assert!(submitted.status.success(), "{submitted:?}");
        let text = String::from_utf8(submitted.stdout).unwrap();
        let stages: Vec<_> = text.lines().map(|line| line.split_once(' ').unwrap().0.to_owned()).collect();
        assert_eq!(stages, ["simulate", "mesh", "foam", "render"], "{text}");
    };
    submit("out", RELIEVO);
    cluster.wait();
    done(at, &["fluid", "sim", "dam.toml", "-o", "frames", "--threads", "1"]);
    done(at, &["fluid", "mesh", "frames", "-o", "meshes"]);
    let bytes = |path: String| {
        std::fs::read(at.join(&path)).unwrap_or_else(|error| panic!("{path}: {error}; {}", cluster.log()))
    };
    for frame in 0..=5 {
        assert!(
            bytes(format!("out/frames/{frame:04}.rlvfluid")) == bytes(format!("frames/{frame:04}.rlvfluid")),
            "{frame}"
        );
        assert!(bytes(format!("out/meshes/{frame:04}.ply")) == bytes(format!("meshes/{frame:04}.ply")), "{frame}");
        assert!(bytes(format!("out/pictures/{frame:04}.png")).starts_with(b"\x89PNG"), "{frame}");
    }
    // What waits for a stage that fails is never run, and does not wait for ever.
    submit("failed", "/bin/false");
    cluster.wait();
    assert!(at.join("failed/farm/simulate.log").exists() && !at.join("failed/farm/mesh-0.log").exists());
}
