//! Disks that are full, writers that are killed, clocks that jump, and files that somebody forged.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, SystemTime};

use relievo_client::{Activity, Address, Client, Hash, SceneName, Status};
use relievo_core::progress::Silent;
use relievo_server::{ServerOptions, Store};

use super::{DAM, client_options, fetched, local_frames, options, scene, start};

/// Kills of a writer.
const KILLS: u32 = 200;
/// Bytes of the cache of the writer.
const LIMIT: u64 = 8 << 20;

/// The content with a number: 0 to 300 kB.
fn content(number: u64) -> Vec<u8> {
    let length = number.wrapping_mul(7_919_077) % 300_000;
    (0..length).map(|at| (at.wrapping_mul(number | 1) >> 5) as u8).collect()
}

fn key(number: u64) -> Hash {
    Hash::of(&number.to_le_bytes())
}

/// Runs one of this program's tests in a process of its own, on a folder.
fn child(test: &str, folder: &Path, before: &str) -> Child {
    Command::new("sh")
        .args(["-c", &format!("{before} exec \"$0\" \"$@\"")])
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", test, "--nocapture", "--test-threads=1"])
        .env("RELIEVO_TEST_DISK", folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// The process that the next test kills: writes one content after the other, and prints the number of each that is stored.
#[test]
fn writes_until_it_is_killed() {
    let Some(folder) = std::env::var_os("RELIEVO_TEST_DISK") else { return };
    let folder = Path::new(&folder);
    let begin: u64 = std::fs::read_to_string(folder.join("begin")).unwrap().parse().unwrap();
    let store = Store::open(&folder.join("cache"), LIMIT).unwrap();
    for number in begin.. {
        store.put(key(number), &content(number)).unwrap();
        println!("\nstored {number}");
    }
}

#[cfg(unix)]
#[test]
fn a_writer_that_is_killed_at_any_moment_leaves_whole_files_and_what_it_confirmed() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let (mut begin, mut unfinished) = (0, 0);
    let mut draw = 12345u32;
    for kill in 0..KILLS {
        std::fs::write(folder.path().join("begin"), begin.to_string()).unwrap();
        let mut writer = child("disk::writes_until_it_is_killed", folder.path(), "");
        let mut out = BufReader::new(writer.stdout.take().unwrap());
        let mut printed = String::new();
        while !printed.contains("stored") {
            assert!(out.read_line(&mut printed).unwrap() > 0, "the writer ended: {printed}");
        }
        draw = draw.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        std::thread::sleep(Duration::from_micros(u64::from(draw >> 16) % 8000));
        writer.kill().unwrap();
        writer.wait().unwrap();
        out.read_to_string(&mut printed).unwrap();
        let stored = printed.lines().filter_map(|line| line.strip_prefix("stored ")?.parse::<u64>().ok());
        let stored: Vec<u64> = stored.collect();
        if let Ok(entries) = std::fs::read_dir(cache.join("unfinished")) {
            unfinished += entries.count();
        }
        let store = Store::open(&cache, LIMIT).unwrap();
        assert!(store.verify(false).unwrap().is_empty(), "a damaged file after kill {kill}");
        // Older ones may have made room.
        for number in stored.iter().rev().take(5) {
            assert!(store.get(key(*number)).unwrap() == content(*number), "content {number} after kill {kill}");
        }
        assert_eq!(std::fs::read_dir(cache.join("unfinished")).unwrap().count(), 0);
        // What was written last may be there without having been confirmed.
        begin = stored.last().map_or(begin, |last| last + 2);
    }
    assert!(begin > u64::from(KILLS), "{begin} contents were stored");
    println!("{begin} contents, {unfinished} kills in the middle of one");
}

/// The process of the next test: a server whose files cannot grow beyond a size.
#[test]
fn serves_with_little_space() {
    let Some(folder) = std::env::var_os("RELIEVO_TEST_DISK") else { return };
    let folder = Path::new(&folder);
    let listen = Address::Unix(folder.join("socket"));
    let _server = start(ServerOptions { listen, ..options(&folder.join("cache")) });
    for _ in 0..1200 {
        if folder.join("room").exists() {
            let _ = std::fs::remove_file(folder.join("cache/ballast"));
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// How a disk is filled in the middle of a scene.
#[derive(Clone, Copy, Debug)]
enum Filling {
    /// A small file system with a large file on it: the system has no space left.
    Mount,
    /// A limit of the sizes of files, where file systems cannot be mounted.
    Limit,
}

/// Starts a process that serves with space for `room` bytes of frames of `all`.
#[cfg(target_os = "linux")]
fn on_a_small_disk(folder: &Path, [room, all]: [u64; 2]) -> (Filling, Child) {
    let mount = format!("cd \"$RELIEVO_TEST_DISK\" && mkdir -p cache && mount -t tmpfs -o size={all} none cache");
    let in_space = |command: &str| {
        let mut unshare = Command::new("unshare");
        unshare.args(["--user", "--map-root-user", "--mount", "sh", "-c", command]).env("RELIEVO_TEST_DISK", folder);
        unshare.stdout(Stdio::null()).stderr(Stdio::null());
        unshare
    };
    if !in_space(&mount).status().is_ok_and(|status| status.success()) {
        return (Filling::Limit, child("disk::serves_with_little_space", folder, "trap '' XFSZ;"));
    }
    let serve = format!("{mount} && head -c {} /dev/zero > cache/ballast && exec \"$0\" \"$@\"", all - room);
    let program = std::env::current_exe().unwrap();
    let arguments = ["--exact", "disk::serves_with_little_space", "--nocapture", "--test-threads=1"];
    (Filling::Mount, in_space(&serve).arg(program).args(arguments).spawn().unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_costs_no_frame_and_the_scene_goes_on_with_space() {
    let folder = tempfile::tempdir().unwrap();
    // Frames grow, so that a limit of their sizes too lets the first ones pass.
    let jet = "[[emitter]]\nspeed = 3\ndisc = { middle = [0.5, 0.2, 0.3], normal = [1, 0, 0], radius = 0.1 }\n";
    let description = format!("{}{jet}", DAM.replace("frames = 6", "frames = 12"));
    let expected = local_frames(&description);
    let pages = |frames: &[Vec<u8>]| frames.iter().map(|frame| (frame.len() as u64 / 4096 + 2) * 4096).sum::<u64>();
    let room = pages(&expected[..5]);
    let (filling, mut server) = on_a_small_disk(folder.path(), [room, 2 * pages(&expected)]);
    println!("{filling:?}");
    let limit = |size: String| {
        let pid = server.id().to_string();
        assert!(Command::new("prlimit").args(["--pid", &pid, &format!("--fsize={size}:")]).status().unwrap().success());
    };
    let address = Address::Unix(folder.path().join("socket"));
    let mut client = Client::connect(client_options(&address)).unwrap();
    if let Filling::Limit = filling {
        limit((expected[5].len() + 80).to_string());
    }
    client.submit(&scene("dam", &description)).unwrap();
    let error = client.wait("dam", 12, &mut Silent).unwrap_err().to_string();
    // What, where, and what to do.
    let what = if let Filling::Mount = filling { "No space left on device" } else { "File too large" };
    assert!([what, "cache/frames", "make space on its disk"].iter().all(|part| error.contains(part)), "{error}");
    let status = client.status("dam").unwrap();
    assert!(status.state == Activity::Failed && (2..11).contains(&status.ready), "{status:?}");
    let ready = status.ready;
    assert!((0..ready).all(|frame| fetched(&mut client, "dam", frame) == expected[frame as usize]));
    // Without space it fails again at the same frame.
    let resume = SceneName { scene: "dam".into() };
    let tried = client.call::<Status>("scene.resume", &resume).and_then(|_| client.wait("dam", ready, &mut Silent));
    assert!(tried.is_err() && client.status("dam").unwrap().ready == ready);
    match filling {
        Filling::Mount => std::fs::write(folder.path().join("room"), "").unwrap(),
        Filling::Limit => limit("unlimited".into()),
    }
    // The large file goes a little later.
    while client.call::<Status>("scene.resume", &resume).and_then(|_| client.wait("dam", 12, &mut Silent)).is_err() {}
    assert!((0..13).all(|frame| fetched(&mut client, "dam", frame) == expected[frame as usize]));
    server.kill().unwrap();
    server.wait().unwrap();
}

#[test]
fn clocks_that_jump_change_the_order_of_the_cache_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path(), 1 << 20).unwrap();
    (0..6).for_each(|number| store.put(key(number), &content(9)).unwrap());
    drop(store);
    let path = |number: u64| {
        let name = key(number).to_string();
        folder.path().join("frames").join(&name[..2]).join(name)
    };
    let year = Duration::from_secs(365 * 86400);
    let set = |number: u64, time: SystemTime| {
        std::fs::File::options().write(true).open(path(number)).unwrap().set_modified(time).unwrap();
    };
    // A clock that was far ahead, one at its beginning, and one before that.
    set(0, SystemTime::now() + 80 * year);
    set(1, SystemTime::UNIX_EPOCH);
    set(2, SystemTime::UNIX_EPOCH - year);
    let size = std::fs::metadata(path(0)).unwrap().len();
    let store = Store::open(folder.path(), 6 * size).unwrap();
    let listed = store.list().unwrap();
    assert_eq!((listed.len(), listed[0].key.clone()), (6, key(2).to_string()));
    assert_eq!((listed[5].key.clone(), listed[5].idle), (key(0).to_string(), 0));
    assert!((0..6).all(|number| store.get(key(number)).unwrap() == content(9)));
    // Within a run the order is that of uses, whatever the clock says.
    (0..6).for_each(|number| set(number, SystemTime::now() + (80 - number as u32) * year));
    store.get(key(0)).unwrap();
    store.put(key(6), &content(9)).unwrap();
    assert!(store.contains(key(0)) && !store.contains(key(1)));
}

#[test]
fn forged_heads_are_errors_and_ask_for_no_memory() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path(), 1 << 30).unwrap();
    let key = key(1);
    let name = key.to_string();
    let path = folder.path().join("frames").join(&name[..2]).join(&name);
    let body = content(3);
    store.put(key, &body).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let sizes =
        [0, 1, body.len() as u64, body.len() as u64 + 1, 1 << 20, 1 << 30, 1 << 38, 1 << 40, u64::MAX / 2, u64::MAX];
    let mut draw = 7u64;
    let mut read = 0;
    for round in 0..2000 {
        let mut forged = whole.clone();
        let mut next = || {
            draw = draw.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            draw >> 33
        };
        if round % 3 == 0 {
            forged[44..52].copy_from_slice(&sizes[next() as usize % sizes.len()].to_le_bytes());
        }
        for _ in 0..next() % 4 {
            let at = next() as usize % forged.len().min(100);
            forged[at] ^= 1 << (next() % 8);
        }
        if round % 5 == 0 {
            forged.truncate(next() as usize % forged.len());
        }
        // The checksums of the head are made right, so that what it says is believed so far.
        if forged.len() > 64 {
            let sum = crc32fast::hash(&forged[..52]);
            forged[52..56].copy_from_slice(&sum.to_le_bytes());
            let sum = crc32fast::hash(&forged[56..60]);
            forged[60..64].copy_from_slice(&sum.to_le_bytes());
        }
        std::fs::write(&path, &forged).unwrap();
        match store.get(key) {
            Ok(found) => {
                assert!(found == body);
                read += 1;
            }
            Err(_) => store.put(key, &body).unwrap(),
        }
    }
    assert!((100..1900).contains(&read), "{read} files were read");
}
