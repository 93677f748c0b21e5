//! Frames that were decoded for requests, so that the chunks of a frame are cut from one decoding. Bounded in bytes; the
//! one that was used longest ago goes first.

use std::sync::{Arc, Mutex, PoisonError};

use relievo_client::{Hash, Particles as Wanted};
use relievo_core::Result;
use relievo_particleio::Particles;

/// Decoded frames, the last used at the end.
pub struct Decoded {
    limit: u64,
    frames: Mutex<Vec<(Hash, Wanted, Arc<Particles>)>>,
}

fn bytes(particles: &Particles) -> u64 {
    let channels = particles.channels.iter().map(|channel| channel.values.len());
    4 * (3 * particles.points.len() + particles.numbers.iter().map(Vec::len).sum::<usize>() + channels.sum::<usize>())
        as u64
}

impl Decoded {
    /// Returns an empty list of at most `limit` bytes.
    pub fn new(limit: u64) -> Self {
        Self { limit, frames: Mutex::default() }
    }

    /// Returns the particles of a frame, which `decode` decodes if they are not there.
    pub fn get(&self, key: Hash, wanted: Wanted, decode: impl FnOnce() -> Result<Particles>) -> Result<Arc<Particles>> {
        let lock = || self.frames.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut frames = lock();
            if let Some(at) = frames.iter().position(|(theirs, kind, _)| *theirs == key && *kind == wanted) {
                let found = frames.remove(at);
                let particles = found.2.clone();
                frames.push(found);
                return Ok(particles);
            }
        }
        let particles = Arc::new(decode()?);
        let mut frames = lock();
        let mut total: u64 = frames.iter().map(|(_, _, particles)| bytes(particles)).sum::<u64>() + bytes(&particles);
        while total > self.limit && !frames.is_empty() {
            total -= bytes(&frames.remove(0).2);
        }
        if total <= self.limit {
            frames.push((key, wanted, particles.clone()));
        }
        Ok(particles)
    }
}
