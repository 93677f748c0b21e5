//! Numbers about the connectivity of a mesh.

use crate::corners::Corners;
use crate::edges::{BOUNDARY, Edges};
use crate::orient::Components;
use crate::sets::Sets;

/// Numbers about the connectivity of a mesh, and its measures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    /// Points that a face uses.
    pub points: usize,
    /// Faces.
    pub faces: usize,
    /// Edges.
    pub edges: usize,
    /// Edges of one face.
    pub boundary_edges: usize,
    /// Parts of the boundary that share no point.
    pub boundary_loops: usize,
    /// Edges of more than two faces.
    pub non_manifold_edges: usize,
    /// Parts of the mesh that share no edge.
    pub components: usize,
    /// Parts of the mesh all of whose edges have two faces.
    pub closed_components: usize,
    /// Points less edges plus faces.
    pub euler: i64,
    /// Area in square units.
    pub area: f64,
    /// Signed volume of the closed components in cubic units.
    pub volume: f64,
}

impl Topology {
    /// Counts and measures.
    pub(crate) fn of(corners: &Corners, edges: &Edges, components: &Components) -> Self {
        let mut is_used = vec![false; corners.places.len()];
        corners.points.iter().for_each(|point| is_used[*point as usize] = true);
        let points = is_used.iter().filter(|used| **used).count();
        let boundary = |half: &u32| edges.mates[*half as usize] == BOUNDARY && corners.from(*half) != corners.to(*half);
        let boundary: Vec<u32> = (0..edges.mates.len() as u32).filter(boundary).collect();
        let closed = || (0..components.count()).filter(|component| components.is_closed[*component]);
        Self {
            points,
            faces: corners.face_count(),
            edges: edges.count,
            boundary_edges: boundary.len(),
            boundary_loops: loops(corners, &boundary).len(),
            non_manifold_edges: edges.branching.len(),
            components: components.count(),
            closed_components: closed().count(),
            euler: points as i64 - edges.count as i64 + corners.face_count() as i64,
            area: components.areas.iter().sum(),
            volume: closed().map(|component| components.volumes[component]).sum::<f64>() / 6.0,
        }
    }
}

/// Returns the first half-edge of every part of the boundary.
pub fn loops(corners: &Corners, boundary: &[u32]) -> Vec<u32> {
    let mut points: Vec<u32> = boundary.iter().flat_map(|half| [corners.from(*half), corners.to(*half)]).collect();
    points.sort_unstable();
    points.dedup();
    let number = |point: u32| points.partition_point(|other| *other < point) as u32;
    let mut sets = Sets::new(points.len());
    for half in boundary {
        sets.join(number(corners.from(*half)), number(corners.to(*half)), false);
    }
    let mut is_seen = vec![false; points.len()];
    let is_first = |half: &&u32| {
        let (root, _) = sets.root(number(corners.from(**half)));
        !std::mem::replace(&mut is_seen[root as usize], true)
    };
    boundary.iter().filter(is_first).copied().collect()
}
