//! Writes particles as Houdini's classic geometry, `.bgeo` version 5: see [`crate::read_bgeo`].

use std::io::Write;
use std::path::Path;

use relievo_core::{Error, Result, file};

use crate::bgeo::{FLOAT, INTEGER, KNOWN, MAGIC, NUMBER, RADIUS, TIME, VECTOR, VERSION};
use crate::particles::{Channel, Particles};

/// What classic files end with: no more sections follow.
const END: [u8; 2] = [0x00, 0xff];

/// Writes particles as classic `.bgeo`, not packed. The time is kept in 32 bits.
///
/// # Errors
/// Fails, and leaves no file: as [`Particles::check`] does, with `Unsupported` if a number has more than 31 bits or two
/// channels have one name there, and with `NotFound` or `Io` if the system refuses.
pub fn write_bgeo(path: &Path, particles: &Particles) -> Result<()> {
    let named = |error: Error| error.at(path.display().to_string());
    particles.check().map_err(named)?;
    let numbers = particles.numbers.as_deref();
    if let Some(number) = numbers.and_then(|numbers| numbers.iter().find(|number| i32::try_from(**number).is_err())) {
        let error = Error::unsupported(format!("particle {number} has a number of more than 31 bits"));
        return Err(named(error.advise("write a cache or VTK")));
    }
    let names: Vec<&str> = particles.channels.iter().map(name).collect();
    let clash = |at: usize| names[at] == NUMBER || names[..at].contains(&names[at]);
    if let Some(at) = (0..names.len()).find(|at| clash(*at)) {
        return Err(named(Error::unsupported(format!("two attributes would be {:?}", names[at])).advise("rename one")));
    }
    let whole = [(TIME, particles.time.map(|time| time as f32)), (RADIUS, particles.spacing.map(|it| 0.5 * it))];
    let whole: Vec<(&str, f32)> = whole.into_iter().filter_map(|(name, value)| Some((name, value?))).collect();
    file::store(path, |out| encode(particles, &names, &whole, out))
}

/// The name of a channel in the file.
fn name(channel: &Channel) -> &str {
    let known = KNOWN.iter().find(|(_, ours, width)| channel.name == *ours && channel.width == *width);
    known.map_or(channel.name.as_str(), |(theirs, ..)| theirs)
}

fn encode(particles: &Particles, names: &[&str], whole: &[(&str, f32)], out: &mut impl Write) -> std::io::Result<()> {
    let numbers = particles.numbers.as_deref();
    let attributes = names.len() + usize::from(numbers.is_some());
    out.write_all(MAGIC)?;
    out.write_all(b"V")?;
    let counts = [particles.points.len(), 0, 0, 0, attributes, 0, 0, whole.len()].map(|count| count as i32);
    [VERSION].iter().chain(&counts).try_for_each(|count| out.write_all(&count.to_be_bytes()))?;
    if numbers.is_some() {
        describe(out, NUMBER, 1, INTEGER)?;
    }
    for (channel, name) in particles.channels.iter().zip(names) {
        let kind = if matches!(*name, "v" | "N") { VECTOR } else { FLOAT };
        describe(out, name, channel.width as u16, kind)?;
    }
    for (particle, point) in particles.points.iter().enumerate() {
        point.iter().chain(&[1.0]).try_for_each(|value| out.write_all(&value.to_be_bytes()))?;
        if let Some(numbers) = numbers {
            out.write_all(&numbers[particle].to_be_bytes())?;
        }
        for channel in &particles.channels {
            let first = particle * channel.width as usize;
            let values = &channel.values[first..first + channel.width as usize];
            values.iter().try_for_each(|value| out.write_all(&value.to_be_bytes()))?;
        }
    }
    whole.iter().try_for_each(|(name, _)| describe(out, name, 1, FLOAT))?;
    whole.iter().try_for_each(|(_, value)| out.write_all(&value.to_be_bytes()))?;
    out.write_all(&END)
}

/// Writes what an attribute is, with zeros for what it is where nothing is said.
fn describe(out: &mut impl Write, name: &str, width: u16, kind: i32) -> std::io::Result<()> {
    out.write_all(&(name.len() as u16).to_be_bytes())?;
    out.write_all(name.as_bytes())?;
    out.write_all(&width.to_be_bytes())?;
    out.write_all(&kind.to_be_bytes())?;
    (0..width).try_for_each(|_| out.write_all(&[0; 4]))
}
