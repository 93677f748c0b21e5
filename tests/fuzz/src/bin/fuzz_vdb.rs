//! Any bytes as an OpenVDB file: refused, or sound particles, or a grid of floats.
#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo_fuzz::MEMORY_LIMIT;
use relievo_particleio::{read_grid, read_vdb_points};

fuzz_target!(|data: &[u8]| {
    if let Ok(read) = read_vdb_points(data, MEMORY_LIMIT) {
        read.particles.check().expect("particles that were read");
    }
    if let Ok(grid) = read_grid(data, None, MEMORY_LIMIT) {
        let ends = grid.bounds(0.0, grid.is_level_set);
        grid.sample(ends.map_or([0.5; 3], |[low, _]| low));
    }
});
