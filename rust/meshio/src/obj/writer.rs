//! Writes Wavefront OBJ: polygons with texture coordinates, normals, colours, materials and subdivision tags.

use std::fmt;
use std::io::Write;
use std::path::Path;

use relievo_core::{Error, Mesh, Result, Values};

use crate::corners::CornerValues;
use crate::file;

/// Writes `mesh` as OBJ. The attribute `material` becomes `usemtl` with the names in `materials`, or its numbers.
///
/// # Errors
/// Fails, and leaves no file: with `Invalid` if the mesh cannot be used (see [`Mesh::check`]), and with `NotFound` or
/// `Io` if the system refuses.
pub fn write_obj(path: &Path, mesh: &Mesh, materials: &[String]) -> Result<()> {
    mesh.check().map_err(|error| error.at(path.display().to_string()))?;
    file::store(path, |out| encode(mesh, materials, out))
}

/// The bytes of the file that [`write_obj`] writes without materials. Fails as that does.
pub(crate) fn obj_bytes(mesh: &Mesh) -> Result<Vec<u8>> {
    mesh.check()?;
    let mut bytes = Vec::new();
    encode(mesh, &[], &mut bytes).map_err(|error| Error::internal(error.to_string()))?;
    Ok(bytes)
}

/// A float in the fewest digits that read back as the same one.
pub(crate) struct Shortest(pub f32);

impl fmt::Display for Shortest {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        let plain = self.0 == 0.0 || (1e-5..1e9).contains(&self.0.abs());
        if plain { write!(out, "{}", self.0) } else { write!(out, "{:e}", self.0) }
    }
}

fn encode(mesh: &Mesh, materials: &[String], out: &mut impl Write) -> std::io::Result<()> {
    writeln!(out, "# Relievo: {} points, {} faces", mesh.points.len(), mesh.face_count())?;
    let line = |out: &mut dyn Write, keyword: &str, values: &[f32]| {
        out.write_all(keyword.as_bytes())?;
        values.iter().try_for_each(|value| write!(out, " {}", Shortest(*value)))?;
        out.write_all(b"\n")
    };
    let colors = CornerValues::find(mesh, "color", 3).filter(|colors| colors.indices.is_none());
    for (index, point) in mesh.points.iter().enumerate() {
        match &colors {
            Some(colors) => {
                let [r, g, b] = colors.value(index as u32);
                line(out, "v", &[point[0], point[1], point[2], r, g, b])?;
            }
            None => line(out, "v", point)?,
        }
    }
    let uvs = CornerValues::find(mesh, "uv", 2);
    if let Some(uvs) = &uvs {
        (0..uvs.count()).try_for_each(|index| line(out, "vt", &uvs.value::<2>(index as u32)))?;
    }
    let normals = CornerValues::find(mesh, "normal", 3);
    if let Some(normals) = &normals {
        (0..normals.count()).try_for_each(|index| line(out, "vn", &normals.value::<3>(index as u32)))?;
    }
    let slots = match mesh.attribute("material").map(|attribute| &attribute.values) {
        Some(Values::U32(slots)) => Some(slots),
        _ => None,
    };
    let mut current = None;
    let mut corner = 0;
    for (index, face) in mesh.faces().enumerate() {
        let slot = slots.and_then(|slots| slots.get(index));
        if let Some(slot) = slot.filter(|slot| current != Some(**slot)) {
            match materials.get(*slot as usize) {
                // A line end in a name would begin another statement.
                Some(name) => writeln!(out, "usemtl {}", name.replace(['\r', '\n'], " "))?,
                None => writeln!(out, "usemtl {slot}")?,
            }
            current = Some(*slot);
        }
        out.write_all(b"f")?;
        for point in face {
            write!(out, " {}", point + 1)?;
            let index = |values: &CornerValues| values.index(corner, *point) + 1;
            match (&uvs, &normals) {
                (Some(uvs), Some(normals)) => write!(out, "/{}/{}", index(uvs), index(normals))?,
                (Some(uvs), None) => write!(out, "/{}", index(uvs))?,
                (None, Some(normals)) => write!(out, "//{}", index(normals))?,
                (None, None) => {}
            }
            corner += 1;
        }
        out.write_all(b"\n")?;
    }
    for crease in &mesh.creases {
        let [a, b] = crease.points;
        writeln!(out, "t crease 2/1/0 {a} {b} {}", Shortest(crease.sharpness))?;
    }
    for (point, sharpness) in &mesh.sharp_points {
        writeln!(out, "t corner 1/1/0 {point} {}", Shortest(*sharpness))?;
    }
    mesh.holes.iter().try_for_each(|face| writeln!(out, "t hole 1/0/0 {face}"))
}
