//! Any bytes as a glTF file: refused, or a model that can be used. Other files it names are short and all alike.
#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo_fuzz::{MEMORY_LIMIT, sound};
use relievo_meshio::read_gltf;

fuzz_target!(|data: &[u8]| sound(read_gltf(data, MEMORY_LIMIT, &|_, _| Ok(vec![0; 64]))));
