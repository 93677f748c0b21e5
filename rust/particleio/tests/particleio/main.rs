//! Files of particles: what is written is read again, what others wrote is read, and nothing that is damaged is.

mod bgeo;
mod frame;
mod hostile;
mod models;
mod ply;
mod sequence;
mod vdb;
mod vdb_points;
mod vtk;

use relievo_particleio::{Channel, Particles};

/// Some particles with all there can be.
pub fn particles(count: usize) -> Particles {
    let value = |at: usize| (at as f32 * 0.37).sin();
    let channel = |name: &str, width: u32, shift: usize| Channel {
        name: name.into(),
        width,
        values: (0..count * width as usize).map(|at| value(at + shift)).collect(),
    };
    Particles {
        points: (0..count).map(|at| [value(at), value(3 * at + 1), at as f32 * 0.01]).collect(),
        time: Some(0.625),
        spacing: Some(0.02),
        numbers: Some((0..count as u32).map(|at| (at * 7) % count as u32 + at / 7 * 1000).collect()),
        channels: vec![channel("velocity", 3, 5), channel("age", 1, 9), channel("weights", 4, 2), channel("st", 2, 1)],
    }
}
