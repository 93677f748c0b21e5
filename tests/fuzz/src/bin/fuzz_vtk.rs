//! Any bytes as a legacy VTK file: refused, or sound particles.
#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo_fuzz::MEMORY_LIMIT;
use relievo_particleio::read_vtk;

fuzz_target!(|data: &[u8]| {
    if let Ok(read) = read_vtk(data, MEMORY_LIMIT) {
        read.particles.check().expect("particles that were read");
    }
});
