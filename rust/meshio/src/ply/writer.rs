//! Writes binary little-endian PLY: polygons with all attributes of points and faces, and `uv` of corners.

use std::io::Write;
use std::path::Path;

use relievo_core::{Attribute, Domain, Error, Mesh, Result, Values};

use crate::color::srgb_from_linear;
use crate::file;

/// Writes `mesh` as binary PLY. Colours become sRGB-encoded bytes, as other programs expect them, or linear floats if
/// some are brighter than 1.
///
/// # Errors
/// Fails, and leaves no file: with `Invalid` if the mesh cannot be used (see [`Mesh::check`]), with `Unsupported` if
/// its indices do not fit the format's signed numbers, and with `NotFound` or `Io` if the system refuses.
pub fn write_ply(path: &Path, mesh: &Mesh) -> Result<()> {
    check(mesh).map_err(|error| error.at(path.display().to_string()))?;
    file::store(path, |out| encode(mesh, out))
}

/// The bytes of the file that [`write_ply`] writes. Fails as that does.
pub(crate) fn ply_bytes(mesh: &Mesh) -> Result<Vec<u8>> {
    check(mesh)?;
    let mut bytes = Vec::new();
    encode(mesh, &mut bytes).map_err(|error| Error::internal(error.to_string()))?;
    Ok(bytes)
}

fn check(mesh: &Mesh) -> Result<()> {
    mesh.check()?;
    match i32::try_from(mesh.points.len()) {
        Ok(_) => Ok(()),
        Err(_) => Err(Error::unsupported("PLY holds at most 2^31 points").advise("write GLB or split the mesh")),
    }
}

/// Writes points without faces, such as particles, as binary PLY, with values of theirs.
///
/// # Errors
/// Fails, and leaves no file: with `Invalid` if an attribute has not a value for each point, with `Unsupported` for 2³¹
/// points or more, and with `NotFound` or `Io` if the system refuses.
pub fn write_points_ply(path: &Path, points: Vec<[f32; 3]>, attributes: Vec<Attribute>) -> Result<()> {
    let named = |error: Error| error.at(path.display().to_string());
    let fits = |attribute: &Attribute| {
        let count = attribute.values.len() as u64;
        attribute.domain == Domain::Point && count == u64::from(attribute.width) * points.len() as u64
    };
    if let Some(other) = attributes.iter().find(|attribute| !fits(attribute)) {
        return Err(named(Error::invalid("it has not a value for each point").at(format!("attribute {}", other.name))));
    }
    if i32::try_from(points.len()).is_err() {
        return Err(named(Error::unsupported("PLY holds at most 2^31 points").advise("write fewer")));
    }
    let mesh = Mesh { attributes, ..Mesh::new(points, Vec::new(), Vec::new()) };
    file::store(path, |out| encode(&mesh, out))
}

/// Columns that an attribute becomes.
struct Columns<'a> {
    attribute: &'a Attribute,
    names: Vec<String>,
    kind: &'static str,
}

/// The columns of all attributes on `domain`. Columns of one name are written once.
fn columns(mesh: &Mesh, domain: Domain) -> Vec<Columns<'_>> {
    let mut list: Vec<Columns> = Vec::new();
    for attribute in mesh.attributes.iter().filter(|attribute| attribute.domain == domain) {
        let own = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
        let names = match (attribute.name.as_str(), attribute.width, &attribute.values) {
            ("normal", 3, Values::F32(_)) => own(&["nx", "ny", "nz"]),
            ("color", 3, Values::F32(_)) => own(&["red", "green", "blue"]),
            ("color", 4, Values::F32(_)) => own(&["red", "green", "blue", "alpha"]),
            ("uv", 2, Values::F32(_)) => own(&["s", "t"]),
            ("velocity", 3, Values::F32(_)) => own(&["vx", "vy", "vz"]),
            // A name of several words would break the header.
            (name, 1, _) => vec![name.split_whitespace().collect::<Vec<_>>().join("_")],
            (name, width, _) => {
                let name = name.split_whitespace().collect::<Vec<_>>().join("_");
                (0..width).map(|number| format!("{name}_{number}")).collect()
            }
        };
        let kind = match &attribute.values {
            Values::F32(values)
                if attribute.name == "color" && attribute.width >= 3 && values.iter().all(|value| *value <= 1.0) =>
            {
                "uchar"
            }
            Values::F32(_) => "float",
            Values::U32(_) => "uint",
        };
        let clash = |name: &String| {
            name.is_empty()
                || matches!(name.as_str(), "x" | "y" | "z" | "vertex_indices" | "texcoord")
                || list.iter().any(|columns| columns.names.contains(name))
        };
        if !names.iter().any(clash) {
            list.push(Columns { attribute, names, kind });
        }
    }
    list
}

/// Writes the value of element `index`.
fn put(columns: &Columns, index: usize, out: &mut impl Write) -> std::io::Result<()> {
    let width = columns.attribute.width as usize;
    let range = index * width..(index + 1) * width;
    match &columns.attribute.values {
        Values::U32(values) => values[range].iter().try_for_each(|value| out.write_all(&value.to_le_bytes())),
        Values::F32(values) if columns.kind == "uchar" => {
            values[range].iter().enumerate().try_for_each(|(component, value)| {
                let value = if component < 3 { srgb_from_linear(value.clamp(0.0, 1.0)) } else { *value };
                out.write_all(&[(value.clamp(0.0, 1.0) * 255.0).round() as u8])
            })
        }
        Values::F32(values) => values[range].iter().try_for_each(|value| out.write_all(&value.to_le_bytes())),
    }
}

/// Writes points and their values.
fn put_points(mesh: &Mesh, columns: &[Columns], out: &mut impl Write) -> std::io::Result<()> {
    mesh.points.iter().enumerate().try_for_each(|(index, point)| {
        point.iter().try_for_each(|value| out.write_all(&value.to_le_bytes()))?;
        columns.iter().try_for_each(|columns| put(columns, index, out))
    })
}

fn encode(mesh: &Mesh, out: &mut impl Write) -> std::io::Result<()> {
    let points = columns(mesh, Domain::Point);
    let faces = columns(mesh, Domain::Face);
    let uvs = mesh.attribute("uv").filter(|uv| uv.domain == Domain::Corner && uv.width == 2);
    let uvs = uvs.and_then(|uv| match &uv.values {
        Values::F32(values) => Some((values.as_chunks::<2>().0, uv.indices.as_deref())),
        Values::U32(_) => None,
    });
    writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment Relievo\nelement vertex {}", mesh.points.len())?;
    writeln!(out, "property float x\nproperty float y\nproperty float z")?;
    let header = |out: &mut dyn Write, list: &[Columns]| {
        list.iter().try_for_each(|columns| {
            columns.names.iter().try_for_each(|name| writeln!(out, "property {} {name}", columns.kind))
        })
    };
    header(out, &points)?;
    if mesh.face_count() == 0 {
        writeln!(out, "end_header")?;
        return put_points(mesh, &points, out);
    }
    writeln!(out, "element face {}", mesh.face_count())?;
    // Lengths of lists are bytes where they fit, which every reader takes.
    let largest = mesh.face_sizes.iter().max().copied().unwrap_or_default();
    let wide = largest > if uvs.is_some() { 127 } else { 255 };
    let length = if wide { "uint" } else { "uchar" };
    writeln!(out, "property list {length} int vertex_indices")?;
    if uvs.is_some() {
        writeln!(out, "property list {length} float texcoord")?;
    }
    header(out, &faces)?;
    writeln!(out, "end_header")?;
    put_points(mesh, &points, out)?;
    let count = |out: &mut dyn Write, count: usize| match wide {
        true => out.write_all(&(count as u32).to_le_bytes()),
        false => out.write_all(&[count as u8]),
    };
    let mut corner = 0;
    for (index, face) in mesh.faces().enumerate() {
        count(out, face.len())?;
        face.iter().try_for_each(|point| out.write_all(&point.to_le_bytes()))?;
        if let Some((values, indices)) = uvs {
            count(out, 2 * face.len())?;
            for corner in corner..corner + face.len() {
                let value = values[indices.map_or(corner, |indices| indices[corner] as usize)];
                value.iter().try_for_each(|value| out.write_all(&value.to_le_bytes()))?;
            }
        }
        corner += face.len();
        faces.iter().try_for_each(|columns| put(columns, index, out))?;
    }
    Ok(())
}
