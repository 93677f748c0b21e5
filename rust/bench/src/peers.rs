//! Programs of peers: each in a process of its own, told the file of a mesh, that of the result and how many triangles
//! are to be left; it tells how many seconds the simplification itself took. `cargo xtask bench lod` makes them.

use std::path::{Path, PathBuf};
use std::process::Command;

use relievo_core::{Error, Result};

use crate::lod::Triangles;

/// A program of a folder, called as the peer is.
pub struct Peer {
    pub name: String,
    program: PathBuf,
}

impl Peer {
    /// The programs of a folder, by their names.
    pub fn of_folder(folder: &Path) -> Result<Vec<Self>> {
        let fault = |error: std::io::Error| Error::io(folder, &error);
        let mut peers = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(fault)? {
            let entry = entry.map_err(fault)?;
            peers.push(Self { name: entry.file_name().to_string_lossy().into_owned(), program: entry.path() });
        }
        peers.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(peers)
    }

    /// The mesh that the peer makes, and its seconds.
    pub fn simplify(&self, mesh: &Triangles, faces: usize) -> Result<(Triangles, f64)> {
        self.run(mesh, &[&faces.to_string()])
    }

    /// The mesh that the peer makes, called with more arguments after the files, and its seconds.
    pub fn run(&self, mesh: &Triangles, more: &[&str]) -> Result<(Triangles, f64)> {
        let fault = |error: std::io::Error| Error::io(&self.program, &error);
        let folder = tempfile::tempdir().map_err(fault)?;
        let [given, made] = ["given", "made"].map(|name| folder.path().join(name));
        std::fs::write(&given, bytes(mesh)).map_err(fault)?;
        let output = Command::new(&self.program).arg(&given).arg(&made).args(more).output().map_err(fault)?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let said = said.lines().last().unwrap_or("nothing was said");
            return Err(Error::internal(format!("it ended with {}: {said}", output.status)).at(self.name.clone()));
        }
        let said = String::from_utf8_lossy(&output.stdout);
        // Some print things of their own before.
        let seconds = said.lines().last().and_then(|line| line.trim().parse().ok());
        let mesh = triangles(&std::fs::read(&made).map_err(fault)?);
        mesh.zip(seconds).ok_or_else(|| Error::internal("what it made cannot be read").at(self.name.clone()))
    }
}

/// Numbers of points and triangles, coordinates and corners.
fn bytes((points, triangles): &Triangles) -> Vec<u8> {
    let counts = [points.len() as u32, triangles.len() as u32];
    let places = points.as_flattened().iter().map(|value| value.to_bits());
    let words = counts.into_iter().chain(places).chain(triangles.as_flattened().iter().copied());
    words.flat_map(u32::to_le_bytes).collect()
}

fn triangles(bytes: &[u8]) -> Option<Triangles> {
    let words: Vec<u32> = bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let ([points, faces], rest) = words.split_first_chunk()?;
    let (places, corners) = rest.split_at_checked(3 * *points as usize)?;
    let points: Vec<[f32; 3]> = places.as_chunks().0.iter().map(|place: &[u32; 3]| place.map(f32::from_bits)).collect();
    let triangles: Vec<[u32; 3]> = corners.as_chunks().0.to_vec();
    let is_whole = triangles.len() == *faces as usize && corners.iter().all(|corner| (*corner as usize) < points.len());
    is_whole.then_some((points, triangles))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_come_back_as_they_were_handed_out() {
        let mesh: Triangles = (vec![[0.5, -1.0, 2.0], [1.0; 3], [0.0; 3]], vec![[0, 1, 2], [2, 1, 0]]);
        assert_eq!(triangles(&bytes(&mesh)), Some(mesh.clone()));
        assert_eq!(triangles(&bytes(&mesh)[..40]), None);
        assert_eq!(triangles(&bytes(&(mesh.0, vec![[0, 1, 3]]))), None);
    }
}
