//! Boundary loops as the polygons that would close them.

use std::collections::HashMap;

use glam::DVec3;

use crate::corners::Corners;
use crate::edges::{BOUNDARY, Edges};
use crate::fans::fan;

/// A boundary loop, in the direction in which a filling runs along it: against the half-edges of the faces there.
pub struct Loop {
    /// Half-edges of the boundary; the one of number i leads from vertex i + 1 to vertex i.
    pub halves: Vec<u32>,
    /// Points, in order.
    pub points: Vec<u32>,
}

impl Loop {
    /// Finds all loops, in the order of their first half-edges. Parts of the boundary that meet in a point form no loop,
    /// and are returned by their first half-edges.
    pub fn all(corners: &Corners, edges: &Edges) -> (Vec<Loop>, Vec<u32>) {
        let boundary: Vec<u32> = (0..edges.mates.len() as u32)
            .filter(|half| edges.mates[*half as usize] == BOUNDARY && corners.from(*half) != corners.to(*half))
            .collect();
        let mut leaving: HashMap<u32, Option<u32>> = HashMap::with_capacity(boundary.len());
        for half in &boundary {
            let entry = leaving.entry(corners.from(*half));
            entry.and_modify(|it| *it = None).or_insert(Some(*half));
        }
        let mut is_seen: HashMap<u32, bool> = boundary.iter().map(|half| (*half, false)).collect();
        let (mut loops, mut tangled) = (Vec::new(), Vec::new());
        for first in &boundary {
            if is_seen[first] {
                continue;
            }
            let mut halves = Vec::new();
            let mut half = Some(*first);
            while let Some(at) = half.filter(|at| !is_seen[at]) {
                is_seen.insert(at, true);
                halves.push(at);
                half = leaving.get(&corners.to(at)).copied().flatten();
            }
            if half == Some(*first) && halves.len() >= 3 {
                halves.reverse();
                let points = halves.iter().map(|half| corners.to(*half)).collect();
                loops.push(Loop { halves, points });
            } else {
                tangled.push(*first);
            }
        }
        (loops, tangled)
    }

    /// The origin of the corner that a filling has at each vertex: a corner of the face beside the loop there.
    pub fn origins(&self, corners: &Corners) -> Vec<u32> {
        self.halves.iter().map(|half| corners.origins[corners.next(*half) as usize]).collect()
    }

    /// The normals of the faces beside the edges.
    pub fn normals(&self, corners: &Corners) -> Vec<DVec3> {
        self.halves.iter().map(|half| corners.area_vector(corners.face(*half)).normalize_or_zero()).collect()
    }

    /// The points that share an edge with each vertex of the loop.
    pub fn neighbours(&self, corners: &Corners, edges: &Edges) -> Vec<Vec<u32>> {
        self.halves
            .iter()
            .map(|half| {
                let around = fan(corners, edges, corners.next(*half));
                let mut near: Vec<u32> = around
                    .iter()
                    .flat_map(|corner| [corners.to(*corner), corners.from(corners.previous(*corner))])
                    .collect();
                near.sort_unstable();
                near.dedup();
                near
            })
            .collect()
    }
}
