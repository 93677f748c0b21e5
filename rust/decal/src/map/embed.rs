//! Positions of inner vertices as means of their neighbours, with mean-value weights (Floater 2003).
//!
//! Weights are positive, so that no triangle flips where each part's boundary is convex (Floater 2003, Theorem 1).

use std::collections::HashMap;

use faer::prelude::*;
use faer::sparse::{SparseColMat, Triplet};
use relievo_core::{Error, Result};

use crate::map::energy::Vec2;
use crate::surface::{Surface, cross, dot, length, minus};

/// Places the vertices that are not fixed. Faces are those of triangles of the surface.
///
/// # Errors
/// The system has no solution: a part without fixed vertices.
pub fn embed(
    surface: &Surface,
    faces: &[[u32; 3]],
    triangles: &[u32],
    is_fixed: &[bool],
    positions: &mut [Vec2],
) -> Result<()> {
    let mut row_of = HashMap::new();
    for (vertex, _) in is_fixed.iter().enumerate().filter(|(_, fixed)| !**fixed) {
        row_of.insert(vertex as u32, row_of.len() as u32);
    }
    if row_of.is_empty() {
        return Ok(());
    }
    let count = row_of.len();
    let mut entries = Vec::with_capacity(12 * faces.len());
    let mut side = Mat::<f64>::zeros(count, 2);
    for (face, triangle) in faces.iter().zip(triangles) {
        let points = surface.corners(*triangle);
        for corner in 0..3 {
            let Some(row) = row_of.get(&face[corner]) else {
                continue;
            };
            let (next, last) = ((corner + 1) % 3, (corner + 2) % 3);
            let (u, v) = (minus(points[next], points[corner]), minus(points[last], points[corner]));
            let angle = length(cross(u, v)).atan2(dot(u, v));
            // Angles of degenerate faces are bounded, so that the weights stay positive and finite.
            let tangent = (0.5 * angle).tan().clamp(1e-4, 1e4);
            for (other, edge) in [(next, u), (last, v)] {
                let weight = tangent / length(edge).max(f64::MIN_POSITIVE.sqrt());
                entries.push(Triplet::new(*row, *row, weight));
                match row_of.get(&face[other]) {
                    Some(column) => entries.push(Triplet::new(*row, *column, -weight)),
                    None => {
                        let position = positions[face[other] as usize];
                        side[(*row as usize, 0)] += weight * position[0];
                        side[(*row as usize, 1)] += weight * position[1];
                    }
                }
            }
        }
    }
    let failed = || {
        Error::invalid("the vertices between the pins cannot be placed")
            .at("seed of the decal")
            .advise("repair the mesh, or move the pins apart")
    };
    let matrix = SparseColMat::<u32, f64>::try_new_from_triplets(count, count, &entries).map_err(|_| failed())?;
    let factor = matrix.sp_lu().map_err(|_| failed())?;
    factor.solve_in_place(&mut side);
    for (vertex, row) in row_of {
        let row = row as usize;
        positions[vertex as usize] = [side[(row, 0)], side[(row, 1)]];
        if !positions[vertex as usize].iter().all(|value| value.is_finite()) {
            return Err(failed());
        }
    }
    Ok(())
}
