//! Triangle meshes as squares of cells. The pattern of a triangle with T segments a side (Schäfer, Keinert, Nießner and
//! Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6) is three squares of T/2 by T/2 cells
//! around its corners, whose diagonals all go from the corner to the centroid, as those of blocks do. A triangle without
//! displacement is half a square of 4 by 4 cells.

use relievo_core::{Context, Error, Result};
use relievo_surface::TriangleTopology;
use relievo_tiles::triangle::{Node, Pattern, TriangleDisplaced, foot_at};

use crate::Procedural;
use crate::block::MIN_RATE;
use crate::square::{Chart, Square, rate};

/// The largest number of segments along the side of a triangle.
pub const MAX_SEGMENTS: u32 = 64;

impl Procedural {
    /// The primitives of a triangle mesh, as fine as its displacement but with at most `segments` along a side, of which
    /// there are at least 8; if `end` is given, of one that moves from the first to the second.
    ///
    /// # Errors
    /// Fails with `Invalid` if the meshes have other faces, and with `Memory` if it does not fit the context's memory
    /// limit.
    pub fn of_triangles(
        context: &Context,
        begin: &TriangleDisplaced<'_>,
        end: Option<&TriangleDisplaced<'_>>,
        segments: u32,
    ) -> Result<Self> {
        let topology = begin.field().topology();
        if end.is_some_and(|end| end.field().topology().faces() != topology.faces()) {
            return Err(Error::invalid("the mesh at the end has other faces than at the beginning")
                .advise("use the same mesh in another pose"));
        }
        let wanted = |displaced: &TriangleDisplaced<'_>, face: u32| {
            let rates = displaced.rates(face);
            let sides = rates.sides.into_iter().fold(1, u32::max);
            rates.inside.map_or(sides, |pattern| sides.max(pattern.segments()))
        };
        let rates: Vec<u32> = (0..topology.face_count() as u32)
            .map(|face| match end.map_or(1, |end| wanted(end, face)).max(wanted(begin, face)) {
                1 => MIN_RATE,
                wanted => 2 * rate(wanted.min(segments) / 2, MAX_SEGMENTS / 2),
            })
            .collect();
        let squares: Vec<Square> = (0..rates.len() as u32).flat_map(|face| squares(topology, &rates, face)).collect();
        Self::of_squares(context, &squares, end.is_some(), |square, at_end| {
            lattice(end.filter(|_| at_end).unwrap_or(begin), square)
        })
    }
}

/// The squares of a face, where faces have `segments` along their sides: 4 where there is no displacement.
fn squares(topology: &TriangleTopology, segments: &[u32], face: u32) -> Vec<Square> {
    let own = segments[face as usize];
    if own == MIN_RATE {
        return vec![Square { tile: face, chart: Chart::Triangle, rate: own, ruled: [[0; 2]; 4] }];
    }
    // Cells of the coarsest face along half of the half of a side that a square has.
    let ruled = topology.edges_of(face).map(|edge| {
        let coarsest = topology.faces_along(edge).map(|(face, _)| segments[face as usize]).fold(own, u32::min);
        if coarsest < own { coarsest / 4 } else { 0 }
    });
    let third = |corner: usize| Square {
        tile: face,
        chart: Chart::Third(corner as u8),
        rate: own / 2,
        ruled: [[ruled[corner]; 2], [0; 2], [0; 2], [ruled[(corner + 2) % 3]; 2]],
    };
    vec![third(0), third(1), third(2)]
}

/// The corners of a square.
fn lattice(displaced: &TriangleDisplaced<'_>, square: &Square) -> Result<Vec<[f32; 3]>> {
    let n = square.rate;
    let mut points = Vec::with_capacity((n as usize + 1).pow(2));
    let whole = if square.chart == Chart::Triangle { n } else { 2 * n };
    let pattern = Pattern::new(whole)?;
    for row in 0..=n {
        for column in 0..=n {
            points.push(match square.chart {
                Chart::Third(corner) => {
                    let node = node_of_third(pattern, u32::from(corner), column, row);
                    displaced.point(square.tile, pattern, node).to_array()
                }
                _ => point_of_triangle(displaced, pattern, square.tile, column, row.min(column)),
            });
        }
    }
    Ok(points)
}

/// The vertex of a pattern that is a corner of a cell of the third around a corner of the triangle.
fn node_of_third(pattern: Pattern, corner: u32, column: u32, row: u32) -> Node {
    if row <= column {
        pattern.node(row, corner, column - row)
    } else {
        let ring = column;
        pattern.node(ring, (corner + 2) % 3, pattern.ring_segments(ring) - (row - column))
    }
}

/// A point of a triangle whose sides have as many segments as its square has cells; `row` is at most `column`.
fn point_of_triangle(
    displaced: &TriangleDisplaced<'_>,
    pattern: Pattern,
    face: u32,
    column: u32,
    row: u32,
) -> [f32; 3] {
    let n = pattern.segments();
    // What lies on a side is computed as its neighbour has it.
    let node = match (column, row) {
        (step, 0) => pattern.node(0, 0, step),
        (column, step) if column == n => pattern.node(0, 1, step),
        (column, row) if column == row => pattern.node(0, 2, n - row),
        _ => {
            let share = |steps: u32| steps as f32 / n as f32;
            let at = [share(n - column), share(column - row), share(row)];
            let foot = foot_at(displaced.surface(), face, at);
            return (foot.point + displaced.offset(face, at, foot.normal)).to_array();
        }
    };
    displaced.point(face, pattern, node).to_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thirds_are_where_the_pattern_has_their_corners() {
        let pattern = Pattern::new(16).unwrap();
        for (corner, column, row) in (0..3_u32).flat_map(|c| (0..81_u32).map(move |k| (c, k % 9, k / 9))) {
            let weights = pattern.weights(node_of_third(pattern, corner, column, row));
            let [u, v] = Chart::Third(corner as u8).place([column, row].map(|step| step as f32 / 8.0));
            let wanted = weights.map(|weight| weight as f32 / 48.0);
            assert!((u - wanted[1]).abs() < 1e-6 && (v - wanted[2]).abs() < 1e-6, "{corner} {column} {row}");
        }
        // Cells are cut as the pattern is.
        let triangles: std::collections::BTreeSet<[Node; 3]> = pattern
            .triangles()
            .map(|mut nodes| {
                nodes.sort_unstable();
                nodes
            })
            .collect();
        for (corner, column, row) in (0..3_u32).flat_map(|c| (0..64_u32).map(move |k| (c, k % 8, k / 8))) {
            let at = |i: u32, j: u32| node_of_third(pattern, corner, column + i, row + j);
            for mut triangle in [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]] {
                triangle.sort_unstable();
                assert!(triangles.contains(&triangle), "{triangle:?}");
            }
        }
    }
}
