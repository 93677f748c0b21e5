//! Bench `surface`: evaluation of limit surfaces over tile grids, beside OpenSubdiv's evaluators and beside the time
//! that merely storing as many numbers takes, which is the floor.

use std::hint::black_box;

use relievo_core::Result;

use crate::measure::{sample, seconds};
use crate::report::{Goal, Report};

/// Bytes of the buffer stored to: more than any cache holds.
const BUFFER: usize = 256 << 20;

/// Measures every case into `report`.
pub fn run(report: &mut Report) -> Result<()> {
    let mut buffer = vec![0.0f32; BUFFER / size_of::<f32>()];
    let mut value = 0.0;
    let floor = sample(9, || {
        value += 1.0;
        let time = seconds(|| black_box(&mut buffer).fill(black_box(value)));
        BUFFER as f64 / time / 1e9
    });
    report.add("store constants, 1 thread", &floor, None, "GB/s", Goal::None);
    Ok(())
}
