//! Writes Object File Format (OFF) as text: polygons, with colours and normals of points.

use std::io::Write;
use std::path::Path;

use relievo_core::{Attribute, Domain, Mesh, Result, Values};

use crate::color::srgb_from_linear;
use crate::file;
use crate::obj::writer::Shortest;

/// Writes `mesh` as OFF, NOFF, COFF or CNOFF, as its points have normals and colours. Colours become sRGB-encoded bytes,
/// as other programs expect them; brighter ones than 1 are 1. Other attributes and tags of subdivision are not written.
///
/// # Errors
/// Fails, and leaves no file: with `Invalid` if the mesh cannot be used (see [`Mesh::check`]), and with `NotFound` or
/// `Io` if the system refuses.
pub fn write_off(path: &Path, mesh: &Mesh) -> Result<()> {
    mesh.check().map_err(|error| error.at(path.display().to_string()))?;
    file::store(path, |out| encode(mesh, out))
}

/// Returns the numbers of an attribute of points with one of the `widths`, and its width.
fn of_points<'a>(mesh: &'a Mesh, name: &str, widths: &[u32]) -> Option<(&'a [f32], usize)> {
    let Attribute { domain, width, values, indices, .. } = mesh.attribute(name)?;
    match values {
        Values::F32(values) if *domain == Domain::Point && widths.contains(width) && indices.is_none() => {
            Some((values, *width as usize))
        }
        _ => None,
    }
}

fn encode(mesh: &Mesh, out: &mut impl Write) -> std::io::Result<()> {
    let normals = of_points(mesh, "normal", &[3]);
    let colors = of_points(mesh, "color", &[3, 4]);
    let [c, n] =
        [(colors.is_some(), "C"), (normals.is_some(), "N")].map(|(there, letter)| if there { letter } else { "" });
    writeln!(out, "{c}{n}OFF\n{} {} 0", mesh.points.len(), mesh.face_count())?;
    for (index, point) in mesh.points.iter().enumerate() {
        write!(out, "{} {} {}", Shortest(point[0]), Shortest(point[1]), Shortest(point[2]))?;
        if let Some((values, _)) = normals {
            values[3 * index..3 * index + 3].iter().try_for_each(|value| write!(out, " {}", Shortest(*value)))?;
        }
        if let Some((values, width)) = colors {
            let color = &values[width * index..width * (index + 1)];
            for value in &color[..3] {
                write!(out, " {}", (srgb_from_linear(value.clamp(0.0, 1.0)) * 255.0).round())?;
            }
            write!(out, " {}", (color.get(3).unwrap_or(&1.0).clamp(0.0, 1.0) * 255.0).round())?;
        }
        out.write_all(b"\n")?;
    }
    for face in mesh.faces() {
        write!(out, "{}", face.len())?;
        face.iter().try_for_each(|point| write!(out, " {point}"))?;
        out.write_all(b"\n")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_attributes_and_polygons_read_back() {
        let points = vec![[0.0; 3], [1.5, 0.0, 0.0], [1.0, 1.0, 1e-20], [0.0, 1.0, 0.1]];
        let mut mesh = Mesh::new(points, vec![4], vec![0, 1, 2, 3]);
        let mut add = |name: &str, width: u32, values: Vec<f32>| {
            let values = Values::F32(values);
            mesh.attributes.push(Attribute { name: name.into(), domain: Domain::Point, width, values, indices: None });
        };
        add("normal", 3, [0.0, 0.0, 1.0].repeat(4));
        add("color", 4, [1.0, 0.0, 0.0, 0.2].repeat(4));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.off");
        write_off(&path, &mesh).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert!(bytes.starts_with(b"CNOFF\n4 1 0\n"));
        assert_eq!(crate::read_off(&bytes, 1 << 20).unwrap().meshes.remove(0).mesh, mesh);
    }
}
