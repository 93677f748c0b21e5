//! Damaged files are errors, or the same kind of grid, within the memory limit.

use std::path::Path;

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions};
use relievo_openvdb::peer::is_available;
use relievo_openvdb::{Grid, Kind, Packing, Survey, Writing, read, write};

use crate::shapes::{block, level_set};

const LIMIT: u64 = 32 << 20;

/// The most memory that this process has occupied, in bytes.
fn peak() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = text.lines().find(|line| line.starts_with("VmHWM")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() << 10
}

fn try_all(context: &Context, path: &Path) {
    let Ok(survey) = Survey::of_file(path, LIMIT) else { return };
    for grid in &survey.grids {
        if let Ok(found) = read(context, path, Some(&grid.name), None, &mut Silent) {
            assert!(found.info().is_ok_and(|info| info.memory_bytes < 2 * LIMIT));
        }
    }
}

#[test]
fn truncations_bit_flips_and_large_sizes_stay_within_the_limit() {
    if !is_available() {
        return;
    }
    let context = Context::new(&ContextOptions { threads: 1, memory_limit: LIMIT }).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (path, bad) = (folder.path().join("a.vdb"), folder.path().join("bad.vdb"));
    let surface = level_set([0.0; 3], [1.0; 3], 0.1);
    let of = |kind| {
        let mut grid = Grid::new(kind, [0.0; 3], 1.0).unwrap();
        grid.set_name(kind.name()).unwrap();
        grid.set_block(&context, &block(kind, [1, 2, 3], [9, 5, 4]), 0.0).unwrap();
        grid
    };
    let others = [of(Kind::Mask), of(Kind::Bool), of(Kind::Vec3d)];
    let list = [&surface, &others[0], &others[1], &others[2]];
    for (packing, is_stream) in [
        (Packing::default(), false),
        (Packing { zip: true, active: false, blosc: false }, false),
        (Packing { zip: false, active: true, blosc: false }, true),
    ] {
        let writing = Writing { packing, is_stream, metadata: Vec::new() };
        write(&context, &path, &list, &writing, &mut Silent).unwrap();
        let whole = std::fs::read(&path).unwrap();
        try_all(&context, &path);
        let before = peak();
        let mut state = 1u64;
        let mut random = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        let check = |bytes: &[u8]| {
            std::fs::write(&bad, bytes).unwrap();
            try_all(&context, &bad);
        };
        for _ in 0..30 {
            check(&whole[..random(whole.len())]);
        }
        for round in 0..80 {
            let mut bytes = whole.clone();
            // Half of them in the head, where sizes and counts are.
            let at = random(if round % 2 == 0 { 1500.min(whole.len()) } else { whole.len() });
            bytes[at] ^= 1 << random(8);
            check(&bytes);
        }
        // Sizes that are far too large, at every place of the head and at some of the rest.
        for round in 0..80 {
            let mut bytes = whole.clone();
            let at = if round < 60 { 8 + 13 * round } else { random(whole.len() - 8) };
            let large: [u8; 8] =
                if round % 2 == 0 { [0xff, 0xff, 0xff, 0x7f, 0, 0, 0, 0] } else { [0, 0, 0, 0, 0x40, 0, 0, 0] };
            bytes[at..at + 8].copy_from_slice(&large);
            check(&bytes);
        }
        let grown = peak().saturating_sub(before);
        assert!(grown < 8 * LIMIT, "{grown} bytes were allocated");
    }
}
