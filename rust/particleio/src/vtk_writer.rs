//! Writes particles as VTK's legacy form, binary: see [`crate::read_vtk`].

use std::io::Write;
use std::path::Path;

use relievo_core::{Result, file};

use crate::particles::Particles;
use crate::vtk::{NUMBER, SPACING, TIME};

/// Writes particles as POLYDATA of a vertex each, version 3.0, which all of VTK's readers know.
///
/// # Errors
/// Fails, and leaves no file, as [`Particles::check`] does, and with `NotFound` or `Io` if the system refuses.
pub fn write_vtk(path: &Path, particles: &Particles) -> Result<()> {
    particles.check().map_err(|error| error.at(path.display().to_string()))?;
    file::store(path, |out| encode(particles, out))
}

fn encode(particles: &Particles, out: &mut impl Write) -> std::io::Result<()> {
    let count = particles.points.len();
    write!(out, "# vtk DataFile Version 3.0\nRelievo\nBINARY\nDATASET POLYDATA\n")?;
    let whole = usize::from(particles.time.is_some()) + usize::from(particles.spacing.is_some());
    if whole > 0 {
        writeln!(out, "FIELD FieldData {whole}")?;
        if let Some(time) = particles.time {
            writeln!(out, "{TIME} 1 1 double")?;
            out.write_all(&time.to_be_bytes())?;
            writeln!(out)?;
        }
        if let Some(spacing) = particles.spacing {
            writeln!(out, "{SPACING} 1 1 float")?;
            out.write_all(&spacing.to_be_bytes())?;
            writeln!(out)?;
        }
    }
    writeln!(out, "POINTS {count} float")?;
    floats(out, particles.points.as_flattened())?;
    if count > 0 {
        writeln!(out, "VERTICES {count} {}", 2 * count as u64)?;
        (0..count as u32).flat_map(|at| [1, at]).try_for_each(|number| out.write_all(&number.to_be_bytes()))?;
        writeln!(out)?;
    }
    let arrays = particles.channels.len() + usize::from(particles.numbers.is_some());
    if arrays == 0 {
        return Ok(());
    }
    writeln!(out, "POINT_DATA {count}\nFIELD FieldData {arrays}")?;
    if let Some(numbers) = &particles.numbers {
        writeln!(out, "{NUMBER} 1 {count} unsigned_int")?;
        numbers.iter().try_for_each(|number| out.write_all(&number.to_be_bytes()))?;
        writeln!(out)?;
    }
    for channel in &particles.channels {
        writeln!(out, "{} {} {count} float", encoded(&channel.name), channel.width)?;
        floats(out, &channel.values)?;
    }
    Ok(())
}

fn floats(out: &mut impl Write, values: &[f32]) -> std::io::Result<()> {
    values.iter().try_for_each(|value| out.write_all(&value.to_be_bytes()))?;
    writeln!(out)
}

/// A name as one word: bytes that are no visible characters, quotes and `%` are written as `%20`.
fn encoded(name: &str) -> String {
    let byte = |byte: u8| match byte {
        b'!'..=b'~' if !matches!(byte, b'"' | b'%') => char::from(byte).to_string(),
        _ => format!("%{byte:02X}"),
    };
    name.bytes().map(byte).collect()
}
