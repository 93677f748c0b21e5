//! Frames of diffuse particles as the foam of pictures.

use relievo_core::{Context, Error, Result};
use relievo_particleio::Particles;
use relievo_render::foam::{Foam, FoamKind, FoamParticle};

/// Particles that are converted at a time, so that a frame is not in memory twice.
const CHUNK: usize = 1 << 18;

/// Adds a frame of particles to a picture, as [`for_each_part`] understands it.
///
/// # Errors
/// Fails as [`for_each_part`], with `Invalid` if a number is not finite, and with `Device` or `Memory` if a device that
/// draws the foam is lost or has no memory.
pub fn add_frame(context: &Context, foam: &mut Foam, particles: &Particles) -> Result<()> {
    for_each_part(particles, |part, velocities| match velocities {
        Some(velocities) => foam.add_moving(context, part, velocities),
        None => foam.add(context, part),
    })
}

/// Calls `work` with one part of a frame of particles after the other, and its velocities where the frame has some. The
/// channel `type` holds 0 for spray, 1 for foam and 2 for bubbles, and all are foam without it; `age` and `lifetime`
/// hold seconds, and all are as if just born without them.
///
/// # Errors
/// Fails with `Invalid` if a type is unknown, and with the error of `work`.
pub fn for_each_part(
    particles: &Particles,
    mut work: impl FnMut(&[FoamParticle], Option<&[[f32; 3]]>) -> Result<()>,
) -> Result<()> {
    let column = |name: &str| {
        let found = particles.channel(name).filter(|channel| channel.width == 1);
        found.map(|channel| channel.values.as_slice())
    };
    let (types, ages, lifetimes) = (column("type"), column("age"), column("lifetime"));
    let kind = |at: usize| match types.map_or(1.0, |types| types[at]) {
        0.0 => Ok(FoamKind::Spray),
        1.0 => Ok(FoamKind::Foam),
        2.0 => Ok(FoamKind::Bubble),
        other => Err(Error::invalid(format!("a particle of foam has the type {other}"))
            .at(format!("particle {at}"))
            .advise("use 0 for spray, 1 for foam and 2 for bubbles")),
    };
    let life = |at: usize| match (ages, lifetimes) {
        (Some(ages), Some(lifetimes)) => {
            let (age, left) = (ages[at].max(0.0), lifetimes[at].max(0.0));
            if age > 0.0 { age / (age + left) } else { 0.0 }
        }
        _ => 0.0,
    };
    let numbers = particles.numbers.as_deref();
    let count = particles.points.len();
    for first in (0..count).step_by(CHUNK) {
        let particle = |at: usize| {
            let id = numbers.map_or(at as u32, |numbers| numbers[at]);
            Ok(FoamParticle { position: particles.points[at], life: life(at), id, kind: kind(at)? })
        };
        let chunk = (first..count.min(first + CHUNK)).map(particle).collect::<Result<Vec<_>>>()?;
        let velocities = particles.velocities().map(|all| &all[first..first + chunk.len()]);
        work(&chunk, velocities)?;
    }
    Ok(())
}
