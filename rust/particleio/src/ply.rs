//! Particles of PLY files: points, `vx vy vz`, `id`, and other columns. Time and spacing have no place there.

use std::path::Path;

use relievo_core::{Attribute, Domain, Error, Mesh, Result, Values};

use crate::particles::{Channel, Particles};
use crate::read::Read;

/// The column of the particles' numbers.
const NUMBER: &str = "id";

/// Reads the points of a PLY file as particles. `memory_limit` bounds in bytes what is allocated for it. Columns called
/// `NAME_0`, `NAME_1` and so on up to four are one channel, as [`write_ply`] writes them.
///
/// # Errors
/// Fails as [`relievo_meshio::read_ply`] does, and with `Invalid` if there is no element `vertex`.
pub fn read_ply(bytes: &[u8], memory_limit: u64) -> Result<Read> {
    let model = relievo_meshio::read_ply(bytes, memory_limit)?;
    let mut read = Read { notes: model.notes, ..Read::default() };
    let mesh = model.meshes.into_iter().next().map(|part| part.mesh);
    let mesh = mesh.ok_or_else(|| Error::invalid("there are no points").advise("give an element `vertex`"))?;
    read.particles = from_mesh(mesh, &mut read.notes)?;
    Ok(read)
}

/// Points of a mesh, with their attributes.
pub(crate) fn from_mesh(mesh: Mesh, notes: &mut Vec<String>) -> Result<Particles> {
    let mut particles = Particles { points: mesh.points, ..Particles::default() };
    for attribute in mesh.attributes.into_iter().filter(|attribute| attribute.domain == Domain::Point) {
        let values = match attribute.values {
            Values::U32(values) if attribute.name == NUMBER && attribute.width == 1 => {
                particles.numbers = Some(values);
                continue;
            }
            Values::U32(values) => values.into_iter().map(|value| value as f32).collect(),
            Values::F32(values) => values,
        };
        if attribute.name == NUMBER && attribute.width == 1 {
            // Signed numbers are floats there, which hold all up to 2²⁴.
            let whole = |value: &f32| (*value >= 0.0 && *value <= 16_777_216.0).then_some(*value as u32);
            match values.iter().map(whole).collect() {
                Some(numbers) => particles.numbers = Some(numbers),
                None => notes.push("`id` is left out because some of it is negative or above 2^24".into()),
            }
            continue;
        }
        particles.channels.push(Channel { name: attribute.name, width: attribute.width, values });
    }
    gather(&mut particles.channels);
    particles.check()?;
    Ok(particles)
}

/// Makes one channel of those called `NAME_0`, `NAME_1` and so on.
fn gather(channels: &mut Vec<Channel>) {
    let mut first = 0;
    while first < channels.len() {
        let name = channels[first].name.strip_suffix("_0").unwrap_or_default().to_owned();
        let is_next = |(at, channel): &(usize, &Channel)| {
            channel.width == 1 && channel.name == format!("{name}_{at}") && !name.is_empty()
        };
        let width = channels[first..].iter().take(4).enumerate().take_while(is_next).count();
        let is_free = channels.iter().all(|channel| channel.name != name);
        if width > 1 && is_free {
            let parts: Vec<Channel> = channels.splice(first..first + width, []).collect();
            let count = parts[0].values.len();
            let values = (0..count).flat_map(|at| parts.iter().map(move |part| part.values[at])).collect();
            channels.insert(first, Channel { name, width: width as u32, values });
        }
        first += 1;
    }
}

/// Writes particles as binary PLY, without their time and spacing. Channels of several numbers but `velocity`, `color`,
/// `normal` and `uv` become columns `NAME_0`, `NAME_1` and so on.
///
/// # Errors
/// Fails, and leaves no file, as [`Particles::check`] does, and with `NotFound` or `Io` if the system refuses.
pub fn write_ply(path: &Path, particles: &Particles) -> Result<()> {
    particles.check().map_err(|error| error.at(path.display().to_string()))?;
    let attribute = |name: &str, width: u32, values: Values| Attribute {
        name: name.into(),
        domain: Domain::Point,
        width,
        values,
        indices: None,
    };
    let numbers = particles.numbers.iter().map(|numbers| attribute(NUMBER, 1, Values::U32(numbers.clone())));
    let channels = particles.channels.iter();
    let channels = channels.map(|it| attribute(&it.name, it.width, Values::F32(it.values.clone())));
    relievo_meshio::write_points_ply(path, particles.points.clone(), channels.chain(numbers).collect())
}
