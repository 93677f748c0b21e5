//! The cache on disk: bounds, damage, and two servers.

use relievo_client::Hash;
use relievo_core::ErrorKind;
use relievo_server::Store;

fn key(number: u8) -> Hash {
    Hash::of(&[number])
}

/// The file of a key.
fn file(folder: &std::path::Path, key: Hash) -> std::path::PathBuf {
    folder.join("frames").join(&key.to_string()[..2]).join(key.to_string())
}

#[test]
fn what_is_stored_is_read_whole_and_in_parts() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path(), 1 << 30).unwrap();
    for length in [0, 1, (1 << 20) - 1, 1 << 20, (1 << 20) + 1, 5 << 19] {
        let content: Vec<u8> = (0..length).map(|at: usize| ((at * at) >> 3) as u8).collect();
        let key = Hash::of(&content);
        store.put(key, &content).unwrap();
        assert!(store.get(key).unwrap() == content);
        for (offset, part) in [(0, 10), (7, 1 << 20), (length.saturating_sub(3), 100), (length, 5), (length + 9, 5)] {
            let end = (offset + part).min(length);
            let expected = &content[offset.min(end)..end];
            assert!(store.part(key, offset as u64, part).unwrap() == (expected.to_vec(), length as u64));
        }
    }
    assert_eq!(store.get(key(1)).unwrap_err().kind, ErrorKind::NotFound);
    assert_eq!(Store::open(folder.path(), 1 << 30).err().unwrap().kind, ErrorKind::Busy, "a second server");
}

#[test]
fn every_truncation_and_bit_flip_is_found_and_the_frame_removed() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path(), 1 << 30).unwrap();
    let content: Vec<u8> = (0..200u8).collect();
    store.put(key(1), &content).unwrap();
    let path = file(folder.path(), key(1));
    let whole = std::fs::read(&path).unwrap();
    let mut damaged: Vec<Vec<u8>> = (0..whole.len()).map(|length| whole[..length].to_vec()).collect();
    damaged.push([whole.clone(), vec![0]].concat());
    for bit in (0..8 * whole.len()).step_by(3) {
        let mut flipped = whole.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        damaged.push(flipped);
    }
    for bytes in damaged {
        std::fs::write(&path, bytes).unwrap();
        assert!(store.get(key(1)).is_err());
        assert!(!path.exists() && !store.contains(key(1)), "a damaged frame stays");
        store.put(key(1), &content).unwrap();
    }
    // A file that is gone is forgotten; one that cannot be opened now stays.
    std::fs::remove_file(&path).unwrap();
    assert_eq!(store.get(key(1)).unwrap_err().kind, ErrorKind::NotFound);
    assert!(!store.contains(key(1)));
    store.put(key(1), &content).unwrap();
    #[cfg(unix)]
    {
        let aside = path.with_extension("aside");
        std::fs::rename(&path, &aside).unwrap();
        std::os::unix::fs::symlink(&path, &path).unwrap();
        assert_eq!(store.get(key(1)).unwrap_err().kind, ErrorKind::Io);
        std::fs::rename(&aside, &path).unwrap();
        assert!(store.get(key(1)).unwrap() == content, "a frame that could not be opened once is lost");
    }
    // A whole file under another name is not taken for that frame.
    store.put(key(2), b"other").unwrap();
    std::fs::copy(&path, file(folder.path(), key(2))).unwrap();
    assert_eq!(store.verify(false).unwrap().len(), 1);
    assert_eq!(store.verify(true).unwrap()[0].0, key(2).to_string());
    assert_eq!(store.verify(true).unwrap(), []);
}

#[test]
fn the_frames_that_were_used_longest_ago_go_first_and_pinned_ones_stay() {
    let folder = tempfile::tempdir().unwrap();
    let content = vec![7; 1000];
    let size = 1000 + 56 + 8;
    let store = Store::open(folder.path(), 3 * size).unwrap();
    (0..3).for_each(|number| store.put(key(number), &content).unwrap());
    store.get(key(0)).unwrap();
    store.pin(key(1));
    store.put(key(3), &content).unwrap();
    let there = |store: &Store| (0..5).filter(|number| store.contains(key(*number))).collect::<Vec<_>>();
    assert_eq!(there(&store), [0, 1, 3], "2 was used longest ago of those without a pin");
    assert_eq!(store.size(), (3 * size, 3));
    store.pin(key(0));
    store.pin(key(3));
    assert_eq!(store.put(key(4), &content).unwrap_err().kind, ErrorKind::Memory);
    store.unpin(key(3));
    store.put(key(4), &content).unwrap();
    assert_eq!(there(&store), [0, 1, 4]);
    assert!(store.put(key(9), &vec![0; 4000]).is_err(), "larger than the cache");
    assert!(file(folder.path(), key(0)).exists() && !file(folder.path(), key(2)).exists());
    drop(store);
    // The order outlives the server, and so does the bound.
    let store = Store::open(folder.path(), 3 * size).unwrap();
    assert_eq!(there(&store), [0, 1, 4]);
    assert_eq!(store.collect(size).unwrap(), 2);
    assert_eq!(there(&store), [4]);
}

#[test]
fn unfinished_files_are_removed_when_the_cache_is_opened() {
    let folder = tempfile::tempdir().unwrap();
    drop(Store::open(folder.path(), 1 << 20).unwrap());
    let unfinished = folder.path().join("unfinished/77-1");
    std::fs::write(&unfinished, b"half").unwrap();
    let store = Store::open(folder.path(), 1 << 20).unwrap();
    assert!(!unfinished.exists());
    assert_eq!(store.size(), (0, 0));
}
