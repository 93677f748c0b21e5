//! Any bytes as an OFF file: refused, or a model that can be used.
#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo_fuzz::{MEMORY_LIMIT, sound};
use relievo_meshio::read_off;

fuzz_target!(|data: &[u8]| sound(read_off(data, MEMORY_LIMIT)));
