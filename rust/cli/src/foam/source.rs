//! A frame of foam in a file, chunk by chunk, so that frames larger than memory can be drawn.

use std::path::Path;

use glam::DVec3;
use relievo_core::{Context, Error, Result};
use relievo_particleio::{Format, FrameStream, Particles, VELOCITY};

/// The channels that drawing and exporting need.
const CHANNELS: [&str; 4] = ["type", "age", "lifetime", VELOCITY];

/// A frame of foam.
pub enum Source {
    /// A frame of a cache, of which a chunk is in memory at a time.
    Stream(FrameStream),
    /// A frame of another format, which is read as a whole.
    Whole(Particles),
}

impl Source {
    /// Opens a frame. Fails if it cannot be read.
    pub fn open(context: &Context, path: &Path) -> Result<Self> {
        let is_cache = Format::named(path).is_ok_and(|format| format == Format::Cache);
        match is_cache {
            true => FrameStream::open(context, path).map(Self::Stream),
            false => crate::fluid::read(context, path).map(Self::Whole),
        }
    }

    /// Returns the number of particles.
    pub fn count(&self) -> usize {
        match self {
            Self::Stream(stream) => stream.count(),
            Self::Whole(particles) => particles.points.len(),
        }
    }

    /// Returns the distance between particles of the fluid at rest, in metres, where the file has it.
    pub fn spacing(&self) -> Option<f32> {
        match self {
            Self::Stream(stream) => stream.spacing(),
            Self::Whole(particles) => particles.spacing,
        }
    }

    /// Calls `work` with one part of the particles after the other. Each has numbers. Fails if a part is damaged, or `work`
    /// fails.
    pub fn for_each(&mut self, mut work: impl FnMut(&Particles) -> Result<()>) -> Result<()> {
        match self {
            Self::Stream(stream) => {
                let mut first = 0;
                for chunk in 0..stream.chunks() {
                    let mut particles = stream.read(chunk, &CHANNELS)?;
                    let end = first + particles.points.len() as u32;
                    particles.numbers.get_or_insert_with(|| (first..end).collect());
                    first = end;
                    work(&particles)?;
                }
                Ok(())
            }
            Self::Whole(particles) => work(particles),
        }
    }

    /// Returns the corners of the box around the particles. Fails if there are no particles.
    pub fn bounds(&mut self) -> Result<(DVec3, DVec3)> {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.for_each(|particles| {
            for point in &particles.points {
                let point = DVec3::from(point.map(f64::from));
                (low, high) = (low.min(point), high.max(point));
            }
            Ok(())
        })?;
        match low.is_finite() {
            true => Ok((low, high)),
            false => Err(Error::invalid("there are no particles of foam").advise("take a frame that has some")),
        }
    }
}
