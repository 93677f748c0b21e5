//! Any bytes as an OpenVDB file: refused, or sound particles, or a grid of floats; and the list of its grids, by which a file
//! is checked before OpenVDB reads it.
#![no_main]

use std::cell::RefCell;

use libfuzzer_sys::fuzz_target;
use relievo_fuzz::MEMORY_LIMIT;
use relievo_openvdb::Survey;
use relievo_particleio::{read_grid, read_vdb_points};

thread_local! {
    static FILE: RefCell<tempfile::NamedTempFile> = RefCell::new(tempfile::NamedTempFile::new().expect("a temporary file"));
}

fuzz_target!(|data: &[u8]| {
    if let Ok(read) = read_vdb_points(data, MEMORY_LIMIT) {
        read.particles.check().expect("particles that were read");
    }
    if let Ok(grid) = read_grid(data, None, MEMORY_LIMIT) {
        let ends = grid.bounds(0.0, grid.is_level_set);
        grid.sample(ends.map_or([0.5; 3], |[low, _]| low));
    }
    FILE.with_borrow_mut(|file| {
        std::fs::write(file.path(), data).expect("the temporary file is written");
        if let Ok(survey) = Survey::of_file(file.path(), MEMORY_LIMIT) {
            for grid in &survey.grids {
                // A leaf has a mask of 64 bytes at least.
                assert!(grid.leaf_count * 64 <= data.len() as u64);
            }
        }
    });
});
