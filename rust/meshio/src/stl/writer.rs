//! Writes binary STL: loose triangles with their normals.

use std::io::Write;
use std::path::Path;

use relievo_core::{Error, Mesh, Result};

use crate::file;

/// Writes `mesh` as binary STL. Polygons become fans of triangles; attributes and tags of subdivision are not written.
///
/// # Errors
/// Fails, and leaves no file: with `Invalid` if the mesh cannot be used (see [`Mesh::check`]), with `Unsupported` for
/// 2³² triangles or more, and with `NotFound` or `Io` if the system refuses.
pub fn write_stl(path: &Path, mesh: &Mesh) -> Result<()> {
    let named = |error: Error| error.at(path.display().to_string());
    mesh.check().map_err(named)?;
    let count: usize = mesh.face_sizes.iter().map(|size| *size as usize - 2).sum();
    let count = u32::try_from(count).map_err(|_| {
        named(Error::unsupported("STL holds fewer than 2^32 triangles").advise("write GLB or split the mesh"))
    })?;
    file::store(path, |out| encode(mesh, count, out))
}

fn encode(mesh: &Mesh, count: u32, out: &mut impl Write) -> std::io::Result<()> {
    // Readers take a file that begins with `solid` for text.
    let mut head = [b' '; 80];
    head[..12].copy_from_slice(b"Relievo mesh");
    out.write_all(&head)?;
    out.write_all(&count.to_le_bytes())?;
    for face in mesh.faces() {
        for pair in face[1..].windows(2) {
            let corners = [face[0], pair[0], pair[1]].map(|point| glam::Vec3::from(mesh.points[point as usize]));
            let [a, b, c] = corners.map(|corner| corner.as_dvec3());
            let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
            for value in [normal].iter().chain(&corners).flat_map(|vector| vector.to_array()) {
                out.write_all(&value.to_le_bytes())?;
            }
            out.write_all(&[0, 0])?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_become_triangles_with_normals() {
        let points = vec![[0.0; 3], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 3.0]];
        let mesh = Mesh::new(points, vec![4, 3], vec![0, 1, 2, 3, 0, 1, 4]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.stl");
        write_stl(&path, &mesh).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(bytes.len(), 84 + 3 * 50);
        let normal: Vec<f32> = bytes[84..96].as_chunks::<4>().0.iter().map(|word| f32::from_le_bytes(*word)).collect();
        assert_eq!(normal, [0.0, 0.0, 1.0]);
        let read = crate::read_stl(&bytes, 1 << 20).unwrap().meshes.remove(0).mesh;
        assert_eq!((read.points, read.corners), (mesh.points, vec![0, 1, 2, 0, 2, 3, 0, 1, 4]));
    }
}
