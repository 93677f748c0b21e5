//! Fans: the corners of a point that one reaches from each other across edges of two faces.

use relievo_core::Context;

use crate::corners::Corners;
use crate::edges::Edges;
use crate::report::{Element, Finding};

/// Walks from a corner around its point, across edges of two faces whichever way these face, and returns all corners that
/// it reaches, the first one included.
pub fn fan(corners: &Corners, edges: &Edges, first: u32) -> Vec<u32> {
    let mut reached = vec![first];
    if !walk(corners, edges, first, true, &mut |corner| reached.push(corner)) {
        walk(corners, edges, first, false, &mut |corner| reached.push(corner));
    }
    reached
}

/// Walks in one direction; returns whether it came back to the first corner.
fn walk(corners: &Corners, edges: &Edges, first: u32, forward: bool, visit: &mut dyn FnMut(u32)) -> bool {
    // The half-edge at the point that is crossed next: the one that leaves it or the one that arrives.
    let (mut corner, mut leaves) = (first, forward);
    loop {
        let half = if leaves { corner } else { corners.previous(corner) };
        let Some(mate) = edges.mate(half) else { return false };
        let begins_here = corners.from(mate) == corners.from(corner);
        corner = if begins_here { mate } else { corners.next(mate) };
        if corner == first {
            return true;
        }
        visit(corner);
        // Having come across one half-edge of the face, it leaves by the other.
        leaves = !begins_here;
    }
}

/// Returns the points that have more than one fan, in order.
pub fn split_points(context: &Context, corners: &Corners, edges: &Edges) -> Vec<u32> {
    let mut firsts = vec![NONE; corners.places.len()];
    let mut valences = vec![0u32; corners.places.len()];
    for (corner, point) in (0..).zip(&corners.points) {
        firsts[*point as usize] = corner;
        valences[*point as usize] += 1;
    }
    let is_split = context.map(firsts.len(), |point| {
        if firsts[point] == NONE {
            return false;
        }
        let (first, mut reached) = (firsts[point], 1);
        if !walk(corners, edges, first, true, &mut |_| reached += 1) {
            walk(corners, edges, first, false, &mut |_| reached += 1);
        }
        reached != valences[point]
    });
    (0..).zip(is_split).filter(|(_, split)| *split).map(|(point, _)| point).collect()
}

const NONE: u32 = u32::MAX;

/// Returns the points with more than one fan that lie on no edge of more than two faces.
pub fn pinched(corners: &Corners, edges: &Edges, split: &[u32], listed: u32) -> Finding {
    let mut is_branching = vec![false; corners.places.len()];
    for half in edges.branching.iter().flatten() {
        is_branching[corners.from(*half) as usize] = true;
        is_branching[corners.to(*half) as usize] = true;
    }
    let pinched = split.iter().filter(|point| !is_branching[**point as usize]);
    Finding::of(pinched.map(|point| Element::Point(corners.place_origins[*point as usize])), listed)
}

/// Gives every fan of these points but the first a copy of the point. Returns the number of copies.
pub fn split(corners: &mut Corners, edges: &Edges, points: &[u32]) -> usize {
    let before = corners.places.len();
    let mut at = vec![NONE; before];
    (0..).zip(points).for_each(|(index, point)| at[*point as usize] = index);
    let mut corners_of: Vec<Vec<u32>> = vec![Vec::new(); points.len()];
    for (corner, point) in (0..).zip(&corners.points) {
        if at[*point as usize] != NONE {
            corners_of[at[*point as usize] as usize].push(corner);
        }
    }
    for (point, mut left) in points.iter().zip(corners_of) {
        let mut is_first = true;
        while let Some(corner) = left.first() {
            let mut reached = fan(corners, edges, *corner);
            reached.sort_unstable();
            left.retain(|corner| reached.binary_search(corner).is_err());
            if !is_first {
                let copy = corners.copy_point(*point);
                reached.iter().for_each(|corner| corners.points[*corner as usize] = copy);
            }
            is_first = false;
        }
    }
    corners.places.len() - before
}
