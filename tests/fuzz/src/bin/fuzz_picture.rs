//! Any bytes as a PNG or an EXR: they are refused, or they are a picture of as many numbers as it says.
#![no_main]

use std::io::Cursor;

use libfuzzer_sys::fuzz_target;
use relievo_render::{Samples, decode_exr, decode_png};

/// Bytes a picture may take.
const LIMIT: u64 = 1 << 24;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(image) = decode_png(Cursor::new(bytes), LIMIT) {
        let count = u64::from(image.width()) * u64::from(image.height()) * u64::from(image.channels());
        assert_eq!(image.data().len() as u64, count);
        assert!(image.data().iter().all(|value| (0.0..=1.0).contains(value)));
    }
    for layer in decode_exr(Cursor::new(bytes), LIMIT).unwrap_or_default() {
        let count = layer.width as usize * layer.height as usize;
        for channel in &layer.channels {
            let length = match &channel.samples {
                Samples::F16(values) => values.len(),
                Samples::F32(values) => values.len(),
                Samples::U32(values) => values.len(),
            };
            assert_eq!(length, count);
        }
    }
});
