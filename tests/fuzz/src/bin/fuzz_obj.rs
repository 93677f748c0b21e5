//! Any bytes as an OBJ file: refused, or a model that can be used.
#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo_fuzz::{MEMORY_LIMIT, sound};
use relievo_meshio::read_obj;

fuzz_target!(|data: &[u8]| sound(read_obj(data, MEMORY_LIMIT)));
