//! Any bytes as a PLY file: refused, or a model that can be used, and particles.
#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo_fuzz::{MEMORY_LIMIT, sound};
use relievo_meshio::read_ply;

fuzz_target!(|data: &[u8]| {
    sound(read_ply(data, MEMORY_LIMIT));
    if let Ok(read) = relievo_particleio::read_ply(data, MEMORY_LIMIT) {
        read.particles.check().expect("particles that were read");
    }
});
