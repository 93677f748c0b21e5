//! What is in a file, in numbers: what `relievo info` prints.

use std::collections::BTreeMap;
use std::fmt;

use relievo_core::{Context, Domain, Mesh, Result, Values};

use crate::model::Model;

/// Numbers about a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Points.
    pub points: usize,
    /// Points that no face uses.
    pub unused_points: usize,
    /// Faces.
    pub faces: usize,
    /// Number of faces of every number of corners.
    pub faces_by_size: BTreeMap<u32, usize>,
    /// Edges.
    pub edges: usize,
    /// Edges of one face.
    pub boundary_edges: usize,
    /// Edges of three or more faces.
    pub non_manifold_edges: usize,
    /// Edges that two faces run through in the same direction: one of them is turned over.
    pub turned_edges: usize,
    /// Parts that share no point.
    pub components: usize,
    /// Points with other than four edges inside the mesh, where a Catmull-Clark surface is extraordinary.
    pub extraordinary_points: usize,
    /// The most edges that meet in a point.
    pub largest_valence: usize,
    /// Sharp edges.
    pub creases: usize,
    /// Sharp points.
    pub sharp_points: usize,
    /// Holes.
    pub holes: usize,
    /// Name, domain, width and number of values of every attribute.
    pub attributes: Vec<(String, Domain, u32, usize)>,
    /// Smallest and largest coordinates.
    pub bounds: Option<([f32; 3], [f32; 3])>,
    /// Why the mesh cannot be used, if it cannot.
    pub problem: Option<String>,
    /// Name, triangles or polygons, and points of every mesh of the file before they are merged.
    pub parts: Vec<(String, usize, usize)>,
    /// Name and number of joints of every skin.
    pub skins: Vec<(String, usize)>,
    /// Name, first and last time in seconds of every animation.
    pub animations: Vec<(String, f64, f64)>,
    /// Names of materials.
    pub materials: Vec<String>,
    /// What was left out while reading.
    pub notes: Vec<String>,
}

impl Summary {
    /// Numbers about a mesh.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let mut summary = Self {
            points: mesh.points.len(),
            faces: mesh.face_count(),
            creases: mesh.creases.len(),
            sharp_points: mesh.sharp_points.len(),
            holes: mesh.holes.len(),
            bounds: mesh.bounds(),
            problem: mesh.check().err().map(|error| error.to_string()),
            ..Self::default()
        };
        for size in &mesh.face_sizes {
            *summary.faces_by_size.entry(*size).or_default() += 1;
        }
        for attribute in &mesh.attributes {
            let count = match &attribute.values {
                Values::F32(values) => values.len(),
                Values::U32(values) => values.len(),
            };
            let values = count / attribute.width.max(1) as usize;
            summary.attributes.push((attribute.name.clone(), attribute.domain, attribute.width, values));
        }
        summary.connect(mesh);
        summary
    }

    /// Numbers about everything in a file, merged into one mesh at rest.
    ///
    /// # Errors
    /// Fails as [`Model::merged_mesh`] does.
    pub fn of_model(context: &Context, model: &Model) -> Result<Self> {
        let part = |part: &crate::Part| (part.name.clone(), part.mesh.face_count(), part.mesh.points.len());
        Ok(Self {
            parts: model.meshes.iter().map(part).collect(),
            skins: model.skins.iter().map(|skin| (skin.name.clone(), skin.joints.len())).collect(),
            animations: model
                .animations
                .iter()
                .map(|animation| (animation.name.clone(), animation.range().0, animation.range().1))
                .collect(),
            materials: model.materials.clone(),
            notes: model.notes.clone(),
            ..Self::of_mesh(&model.merged_mesh(context)?)
        })
    }

    /// Counts what depends on edges. Indices of corners must exist, which readers see to.
    fn connect(&mut self, mesh: &Mesh) {
        let count = mesh.points.len();
        let mut edges: Vec<(u32, u32, bool)> = Vec::with_capacity(mesh.corners.len());
        let mut used = vec![false; count];
        let mut sets = Sets::new(count);
        for face in mesh.faces() {
            for (corner, from) in face.iter().enumerate() {
                let to = face[(corner + 1) % face.len()];
                used[*from as usize] = true;
                sets.join(*from, face[0]);
                edges.push((*from.min(&to), *from.max(&to), from < &to));
            }
        }
        edges.sort_unstable();
        let mut valences = vec![0u32; count];
        let mut border = vec![false; count];
        for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (a, b) = (edge[0].0 as usize, edge[0].1 as usize);
            self.edges += 1;
            valences[a] += 1;
            valences[b] += 1;
            match edge.len() {
                1 => self.boundary_edges += 1,
                2 => self.turned_edges += usize::from(edge[0].2 == edge[1].2),
                _ => self.non_manifold_edges += 1,
            }
            if edge.len() != 2 {
                (border[a], border[b]) = (true, true);
            }
        }
        for point in 0..count {
            if !used[point] {
                self.unused_points += 1;
                continue;
            }
            self.components += usize::from(sets.root(point as u32) == point as u32);
            self.largest_valence = self.largest_valence.max(valences[point] as usize);
            self.extraordinary_points += usize::from(!border[point] && valences[point] != 4);
        }
    }
}

/// Disjoint sets of points (Tarjan 1975), with halved paths.
struct Sets {
    above: Vec<u32>,
}

impl Sets {
    fn new(count: usize) -> Self {
        Self { above: (0..count as u32).collect() }
    }

    fn root(&mut self, mut point: u32) -> u32 {
        while self.above[point as usize] != point {
            let above = self.above[point as usize];
            self.above[point as usize] = self.above[above as usize];
            point = above;
        }
        point
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.above[a.max(b) as usize] = a.min(b);
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut line = |name: &str, value: String| writeln!(out, "{name:<14}{value}");
        let some = |count: usize, what: &str| if count > 0 { format!(", {count} {what}") } else { String::new() };
        line("points", format!("{}{}", self.points, some(self.unused_points, "unused")))?;
        let sizes: Vec<String> = self
            .faces_by_size
            .iter()
            .map(|(size, count)| match size {
                3 => format!("{count} triangles"),
                4 => format!("{count} quads"),
                _ => format!("{count} of {size} corners"),
            })
            .collect();
        line("faces", format!("{} ({})", self.faces, sizes.join(", ")))?;
        let mut edges = self.edges.to_string();
        edges += &some(self.boundary_edges, "on the boundary");
        edges += &some(self.non_manifold_edges, "non-manifold");
        edges += &some(self.turned_edges, "between faces of opposite sense");
        line("edges", edges)?;
        line("components", self.components.to_string())?;
        line(
            "extraordinary",
            format!("{} points, largest valence {}", self.extraordinary_points, self.largest_valence),
        )?;
        if self.creases + self.sharp_points + self.holes > 0 {
            let tags = format!("{} creases, {} sharp points, {} holes", self.creases, self.sharp_points, self.holes);
            line("tags", tags)?;
        }
        for (name, domain, width, values) in &self.attributes {
            let domain = match domain {
                Domain::Point => "points",
                Domain::Corner => "corners",
                Domain::Face => "faces",
            };
            line("attribute", format!("{name}: {width} numbers on {domain}, {values} values"))?;
        }
        if let Some((low, high)) = self.bounds {
            line("bounds", format!("{low:?} to {high:?}"))?;
        }
        if self.parts.len() > 1 {
            for (name, faces, points) in &self.parts {
                line("mesh", format!("{name}: {points} points, {faces} faces"))?;
            }
        }
        for (name, joints) in &self.skins {
            line("skin", format!("{name}: {joints} joints"))?;
        }
        for (name, start, end) in &self.animations {
            line("animation", format!("{name}: {start:.3} to {end:.3} s"))?;
        }
        if !self.materials.is_empty() {
            line("materials", self.materials.join(", "))?;
        }
        for note in &self.notes {
            line("note", note.clone())?;
        }
        match &self.problem {
            Some(problem) => line("problem", problem.clone()),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_of_quads_a_fin_and_a_loose_point_are_counted() {
        // Two quads, a triangle on their common edge, a turned triangle elsewhere, one unused point.
        let mesh = Mesh::new(
            (0..11).map(|index| [index as f32, 0.0, 0.0]).collect(),
            vec![4, 4, 3, 3, 3],
            vec![0, 1, 2, 3, 3, 2, 4, 5, 2, 3, 6, 7, 8, 9, 7, 8, 6],
        );
        let summary = Summary::of_mesh(&mesh);
        assert_eq!((summary.points, summary.unused_points, summary.faces), (11, 1, 5));
        assert_eq!(summary.faces_by_size, BTreeMap::from([(3, 3), (4, 2)]));
        assert_eq!(summary.non_manifold_edges, 1);
        assert_eq!(summary.turned_edges, 1);
        assert_eq!(summary.components, 1);
        assert_eq!(summary.edges, 4 + 3 + 2 + 3 + 2);
        assert_eq!(summary.boundary_edges, 3 + 3 + 2 + 2 + 2);
        assert_eq!(summary.problem, None);
        assert!(summary.to_string().contains("2 quads"));
        let empty = Summary::of_mesh(&Mesh::default());
        assert!(empty.problem.is_some() && empty.bounds.is_none());
    }
}
