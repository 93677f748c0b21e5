//! Pairs the faces around edges of more than two, so that faces that enclose material stay together.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::corners::Corners;
use crate::edges::{BOUNDARY, Edges};
use crate::sets::Sets;

/// Pairs the half-edges of edges of more than two faces; half-edges without a partner become boundary. Of the faces of
/// one component, which are consistently oriented, exactly two that fit are paired first; then each face with the next
/// one around the edge on the side of its back, if that runs the other way.
pub fn pair(corners: &Corners, edges: &mut Edges) {
    if edges.branching.is_empty() {
        return;
    }
    let mut sets = Sets::new(corners.face_count());
    for half in 0..edges.mates.len() as u32 {
        if let Some(mate) = edges.mate(half) {
            sets.join(corners.face(half), corners.face(mate), false);
        }
    }
    for group in std::mem::take(&mut edges.branching) {
        let mut left: Vec<u32> = Vec::new();
        let roots: Vec<u32> = group.iter().map(|half| sets.root(corners.face(*half)).0).collect();
        for (half, root) in group.iter().zip(&roots) {
            let mut same = group.iter().zip(&roots).filter(|(_, other)| *other == root).map(|(half, _)| *half);
            match (same.next(), same.next(), same.next()) {
                (Some(a), Some(b), None) if corners.from(a) != corners.from(b) => edges.join(a, b),
                _ => left.push(*half),
            }
        }
        left.iter().for_each(|half| edges.mates[*half as usize] = BOUNDARY);
        pair_around(corners, edges, &left);
    }
}

/// Cuts all faces around edges of more than two apart.
pub fn cut(edges: &mut Edges) {
    for half in std::mem::take(&mut edges.branching).into_iter().flatten() {
        edges.mates[half as usize] = BOUNDARY;
    }
}

/// Pairs half-edges of one edge by their angles around it, as parentheses are matched.
fn pair_around(corners: &Corners, edges: &mut Edges, halves: &[u32]) {
    let Some(first) = halves.first() else { return };
    let [from, to] = [corners.from(*first), corners.to(*first)].map(|point| corners.place(point));
    let axis = (to - from).normalize_or(DVec3::Z);
    let side = axis.any_orthonormal_vector();
    let up = axis.cross(side);
    let mut around: Vec<(f64, bool, u32)> = halves
        .iter()
        .map(|half| {
            let forward = corners.from(*half) == corners.from(*first);
            // Into the face, at a right angle to the edge.
            let along = if forward { axis } else { -axis };
            let inward = corners.area_vector(corners.face(*half)).cross(along);
            (inward.dot(up).atan2(inward.dot(side)).rem_euclid(TAU), forward, *half)
        })
        .collect();
    // Downwards in angle, which is the side of the back of half-edges that run along the axis.
    around.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)));
    let mut open: Vec<u32> = Vec::new();
    let mut is_paired = vec![false; around.len()];
    // Twice around, for pairs across the angle zero.
    for at in 0..2 * around.len() {
        let at = at % around.len();
        let (_, forward, half) = around[at];
        if is_paired[at] {
            continue;
        }
        if forward {
            if !open.contains(&(at as u32)) {
                open.push(at as u32);
            }
        } else if let Some(partner) = open.pop() {
            edges.join(around[partner as usize].2, half);
            is_paired[partner as usize] = true;
            is_paired[at] = true;
        }
    }
}
