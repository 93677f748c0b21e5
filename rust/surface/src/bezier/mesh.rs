//! Meshes of tessellated Bézier patches, whose patches share the points of common edges.

use relievo_core::{Attribute, Domain, Mesh, Values};

use super::BezierTessellation;

impl BezierTessellation {
    /// A mesh of the triangles, with the attributes `normal` at corners and `patch` of faces. Points on the borders of
    /// patches that are equal to the bit become one; triangles that lose their area by that are left out.
    pub fn mesh(&self) -> Mesh {
        let border = |patch: usize| {
            let (first, last) = (self.first[patch], self.first[patch + 1]);
            let side = (last - first).isqrt().max(1);
            (first..last).filter(move |point| {
                let (i, j) = ((point - first) % side, (point - first) / side);
                i == 0 || j == 0 || i + 1 == side || j + 1 == side
            })
        };
        let mut borders: Vec<u32> = (0..self.first.len().saturating_sub(1)).flat_map(border).collect();
        // After the grids come points of finer edges.
        borders.extend(self.first.last().copied().unwrap_or(0)..self.points.len() as u32);
        // Zeros have either sign here.
        let key = |point: u32| self.points[point as usize].map(|value| (value + 0.0).to_bits());
        borders.sort_unstable_by_key(|point| (key(*point), *point));
        let mut welded: Vec<u32> = (0..self.points.len() as u32).collect();
        for run in borders.chunk_by(|a, b| key(*a) == key(*b)) {
            for point in run {
                welded[*point as usize] = run[0];
            }
        }
        let mut number = vec![u32::MAX; self.points.len()];
        let (mut points, mut corners, mut indices, mut patches) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for patch in 0..self.first_triangle.len().saturating_sub(1) {
            let range = self.first_triangle[patch] as usize..self.first_triangle[patch + 1] as usize;
            for triangle in &self.triangles[range] {
                let [a, b, c] = triangle.map(|point| welded[point as usize]);
                if a == b || b == c || a == c {
                    continue;
                }
                for (point, corner) in [a, b, c].into_iter().zip(triangle) {
                    let number = &mut number[point as usize];
                    if *number == u32::MAX {
                        *number = points.len() as u32;
                        points.push(self.points[point as usize]);
                    }
                    corners.push(*number);
                    indices.push(*corner);
                }
                patches.push(patch as u32);
            }
        }
        let mut mesh = Mesh::new(points, vec![3; patches.len()], corners);
        let normals = Values::F32(self.normals.as_flattened().to_vec());
        mesh.attributes.push(Attribute {
            name: "normal".into(),
            domain: Domain::Corner,
            width: 3,
            values: normals,
            indices: Some(indices),
        });
        mesh.attributes.push(Attribute {
            name: "patch".into(),
            domain: Domain::Face,
            width: 1,
            values: Values::U32(patches),
            indices: None,
        });
        mesh
    }
}
