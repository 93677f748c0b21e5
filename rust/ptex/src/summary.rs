//! What is in a Ptex file, in numbers: what `relievo info` prints.

use std::collections::BTreeMap;
use std::fmt;

use crate::format::{Borders, Format, MeshType, Resolution};
use crate::reader::Reader;

/// Numbers about a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// What all texels have in common.
    pub format: Format,
    /// What filters do at edges.
    pub borders: Borders,
    /// Faces.
    pub faces: u32,
    /// Number of faces of every resolution.
    pub faces_by_resolution: BTreeMap<Resolution, usize>,
    /// Faces whose texels all have one value.
    pub constant_faces: usize,
    /// Faces that are corners of polygons.
    pub subfaces: usize,
    /// Edges without a neighbour.
    pub boundary_edges: usize,
    /// Levels: the full one and its reductions.
    pub levels: usize,
    /// Edits that were applied.
    pub edits: usize,
    /// Faces that an edit gave their texels.
    pub edited_faces: usize,
    /// Texels of all faces.
    pub texels: u64,
    /// Bytes of the file.
    pub file_bytes: u64,
    /// Bytes of its texels when they are decompressed, without reductions.
    pub texel_bytes: u64,
    /// Key, type and length of all meta data.
    pub meta: Vec<(String, &'static str, usize)>,
    /// Why texels cannot be read, if they cannot.
    pub problem: Option<String>,
}

impl Summary {
    /// Numbers about a file, whose texels are all decompressed once.
    pub fn of<B: AsRef<[u8]>>(reader: &Reader<B>) -> Self {
        let mut summary = Self {
            format: *reader.format(),
            borders: reader.borders(),
            faces: reader.face_count(),
            faces_by_resolution: BTreeMap::new(),
            constant_faces: 0,
            subfaces: 0,
            boundary_edges: 0,
            levels: reader.level_count(),
            edits: reader.edit_count(),
            edited_faces: 0,
            texels: 0,
            file_bytes: reader.file_length() as u64,
            texel_bytes: 0,
            meta: reader.meta().iter().map(|(key, value)| (key.clone(), value.type_name(), value.len())).collect(),
            problem: reader.check().err().map(|error| error.to_string()),
        };
        let edges = if summary.format.mesh == MeshType::Triangle { 3 } else { 4 };
        for index in 0..summary.faces {
            let Ok(face) = reader.face(index) else { continue };
            *summary.faces_by_resolution.entry(face.resolution).or_default() += 1;
            summary.constant_faces += usize::from(reader.constant(index).is_some());
            summary.edited_faces += usize::from(reader.is_edited(index));
            summary.subfaces += usize::from(face.subface);
            summary.boundary_edges += face.neighbors[..edges].iter().filter(|neighbor| neighbor.is_none()).count();
            summary.texels = summary.texels.saturating_add(face.resolution.texels());
        }
        summary.texel_bytes = summary.texels.saturating_mul(summary.format.texel_size() as u64);
        summary
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut line = |name: &str, value: String| writeln!(out, "{name:<14}{value}");
        let some = |count: usize, what: &str| if count > 0 { format!(", {count} {what}") } else { String::new() };
        let Format { mesh, data_type, channels, alpha } = self.format;
        let alpha = alpha.map_or(String::new(), |alpha| format!(", alpha is {alpha}"));
        line("texels", format!("{} of {channels} channels, {}{alpha}", self.texels, data_type.name()))?;
        let shape = if mesh == MeshType::Triangle { "triangles" } else { "quads" };
        let mut faces = format!("{} {shape}", self.faces);
        faces += &some(self.subfaces, "of them corners of polygons");
        faces += &some(self.constant_faces, "constant");
        faces += &some(self.edited_faces, "edited");
        line("faces", faces)?;
        for (resolution, count) in &self.faces_by_resolution {
            line("resolution", format!("{} x {}: {count} faces", resolution.width(), resolution.height()))?;
        }
        line("levels", self.levels.to_string())?;
        line("boundary", format!("{} edges", self.boundary_edges))?;
        let Borders { u, v, edge_filter } = self.borders;
        line("borders", format!("u {u:?}, v {v:?}, edge filter {edge_filter:?}").to_lowercase())?;
        if self.edits > 0 {
            line("edits", self.edits.to_string())?;
        }
        for (key, kind, length) in &self.meta {
            line("meta data", format!("{key}: {length} {kind}"))?;
        }
        line("bytes", format!("{}, texels {}", self.file_bytes, self.texel_bytes))?;
        match &self.problem {
            Some(problem) => line("problem", problem.clone()),
            None => Ok(()),
        }
    }
}
