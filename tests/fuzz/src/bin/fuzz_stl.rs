//! Any bytes as an STL file: refused, or a model that can be used.
#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo_fuzz::{MEMORY_LIMIT, sound};
use relievo_meshio::read_stl;

fuzz_target!(|data: &[u8]| sound(read_stl(data, MEMORY_LIMIT)));
