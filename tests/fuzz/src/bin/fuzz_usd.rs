//! Any bytes as a USD stage: refused, or a model that can be used. Files that it names are not there.
//!
//! The crate that reads layers panics at some damaged ones, which our reader turns into an error; the fuzzer must not
//! take that for a fault of ours.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use relievo_fuzz::{MEMORY_LIMIT, sound};
use relievo_meshio::{Root, read_usd};

fuzz_target!(
    init: {
        let fatal = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |information| {
            let place = information.location().map_or("", |location| location.file());
            if !place.contains("/openusd-") {
                fatal(information);
            }
        }));
    },
    |data: &[u8]| sound(read_usd(data.to_vec(), MEMORY_LIMIT, Path::new("."), &Root::none()))
);
