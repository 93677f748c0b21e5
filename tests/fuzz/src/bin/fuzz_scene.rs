//! Scene files: any text is a scene or a list of faults that point into it. No file the text names is opened.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    match relievo_scene::file::parse(Path::new("fuzz.toml"), text) {
        Ok(scene) => drop(scene),
        Err(faults) => assert!(!faults.to_string().is_empty()),
    }
});
