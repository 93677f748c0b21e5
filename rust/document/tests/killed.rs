//! A thousand kills of processes that work on documents, most of them at a byte: what was confirmed is there. Alone in
//! its program, since for a moment a process that is begun holds the locks of the one that begins it.

use std::path::Path;
use std::process::{Command, Stdio};

use relievo_document::{Document, Journal};

#[path = "document/model/mod.rs"]
mod model;
use model::Model;

const LIMIT: u64 = 64 << 20;

fn same(a: &Document, b: &Document) -> bool {
    a.to_bytes().unwrap() == b.to_bytes().unwrap()
}

/// Edits of a series at most.
const SERIES: u32 = 200;

/// The process that the next test kills: it goes on with edits until it is gone, and says how many are confirmed.
#[test]
fn appends_until_it_is_killed() {
    let Some(path) = std::env::var_os("RELIEVO_TEST_JOURNAL") else { return };
    let (document, log, mut journal) = Journal::open(Path::new(&path), LIMIT).unwrap();
    let done = log.done.len() as u32;
    let mut model = (0..done).fold(Model::new(), |model, number| model.changed(number));
    assert!(same(&document, &model.document()));
    for number in done..SERIES {
        let next = model.changed(number);
        journal.input(&format!("edit {number}")).unwrap();
        journal.edit(&model.edit(&next)).unwrap();
        model = next;
        println!("confirmed {}", number + 1);
    }
    // Until it is killed after all.
    std::thread::sleep(std::time::Duration::from_secs(20));
}

/// Lets a process go on with the document at `path`, kills it, and returns how many edits it confirmed, if it said so.
/// With `bytes` it is killed when it writes beyond that many bytes of the file, at the very byte; else after some time.
fn killed(path: &Path, bytes: Option<u64>, micros: u64) -> Option<u32> {
    let own = std::env::current_exe().unwrap();
    let mut command = match bytes {
        // The signal of a file that is too large ends the process like any other that nobody awaits.
        Some(bytes) => {
            let mut command = Command::new("prlimit");
            command.arg(format!("--fsize={bytes}")).arg("--core=0").arg("--").arg(own);
            command
        }
        None => Command::new(own),
    };
    let mut child = command
        .args(["--exact", "appends_until_it_is_killed", "--nocapture", "--test-threads=1"])
        .env("RELIEVO_TEST_JOURNAL", path)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = std::io::BufRead::lines(std::io::BufReader::new(child.stdout.take().unwrap()));
    let number = |line: String| line.rsplit_once("confirmed ").and_then(|(_, rest)| rest.parse::<u32>().ok());
    let mut confirmed = None;
    if bytes.is_none() {
        while confirmed.is_none() {
            let Some(line) = lines.next() else {
                child.wait().unwrap();
                return None;
            };
            confirmed = number(line.unwrap());
        }
        std::thread::sleep(std::time::Duration::from_micros(micros));
        child.kill().unwrap();
    }
    confirmed = lines.map_while(Result::ok).filter_map(number).last().or(confirmed);
    assert!(!child.wait().unwrap().success(), "it was killed");
    confirmed
}

#[test]
fn a_thousand_kills_lose_no_confirmed_edit() {
    const KILLS: u32 = 1000;
    let is_there = Command::new("prlimit").arg("--version").stdout(Stdio::null()).status().is_ok();
    if !is_there {
        println!("skipped: kills at a byte need `prlimit`");
    }
    let folder = tempfile::tempdir().unwrap();
    let mut states = vec![Model::new()];
    (0..SERIES).for_each(|number| states.push(states[number as usize].changed(number)));
    let states: Vec<Document> = states.iter().map(Model::document).collect();
    let mut seed = 1u64;
    let mut random = |below: u64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) % below
    };
    let path = folder.path().join("a.relievo");
    let (mut done, mut at_the_byte, mut under_way) = (SERIES as usize, 0, 0);
    for kill in 0..KILLS {
        // Document after document: each is killed again and again, and goes on.
        if done + 40 > SERIES as usize {
            states[0].write(&path).unwrap();
            done = 0;
        }
        let length = std::fs::metadata(&path).unwrap().len();
        let bytes = (is_there && kill % 10 != 0).then(|| length + random(3000));
        let confirmed = killed(&path, bytes, random(3000)).map_or(done, |count| count as usize);
        let now = std::fs::metadata(&path).unwrap().len();
        at_the_byte += u32::from(Some(now) == bytes);
        let document = Document::open(&path, LIMIT).unwrap();
        under_way += u32::from(!document.notes.is_empty());
        // All that were confirmed, and perhaps one that was written and not said any more.
        let found = (confirmed..=confirmed + 1).find(|count| states.get(*count).is_some_and(|s| same(s, &document)));
        done = found.unwrap_or_else(|| panic!("kill {kill} of {bytes:?} bytes: {confirmed} edits were confirmed"));
    }
    assert!(!is_there || at_the_byte > 800 && under_way > 500, "{at_the_byte} {under_way}");
}
