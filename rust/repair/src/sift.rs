//! Drops degenerate and doubled faces.

use relievo_core::Context;

use crate::corners::Corners;
use crate::equal::{add, finish, first_equal};
use crate::report::{Element, Finding};

/// Removes repeated points from faces. A face that touches itself in a point becomes several; what has fewer than three
/// corners left is dropped. Returns the faces of the input that were changed.
pub fn degenerate(context: &Context, corners: &mut Corners, drop: bool, listed: u32) -> Finding {
    let is_bad = context.map(corners.face_count(), |face| repeats(corners.face_points(face as u32)));
    let bad = (0..).zip(&is_bad).filter(|(_, bad)| **bad);
    let finding = Finding::of(bad.map(|(face, _)| corners.named(face)), listed);
    if drop && finding.count > 0 {
        corners.replace(|points| repeats(points).then(|| simple_loops(points)));
    }
    finding
}

/// Returns whether a face has fewer than three corners or a point twice.
fn repeats(points: &[u32]) -> bool {
    match points {
        [a, b, c] => a == b || b == c || c == a,
        _ if points.len() <= 16 => points.len() < 3 || (1..points.len()).any(|at| points[..at].contains(&points[at])),
        _ => {
            let mut sorted = points.to_vec();
            sorted.sort_unstable();
            sorted.windows(2).any(|pair| pair[0] == pair[1])
        }
    }
}

/// Splits a closed walk at points that it visits more than once. Returns the loops of three corners or more, as positions
/// in the walk.
fn simple_loops(points: &[u32]) -> Vec<Vec<u32>> {
    let (mut open, mut loops): (Vec<u32>, Vec<Vec<u32>>) = (Vec::new(), Vec::new());
    for (position, point) in (0..).zip(points) {
        if let Some(at) = open.iter().position(|other| points[*other as usize] == *point) {
            loops.push(open.split_off(at));
        }
        open.push(position);
    }
    loops.push(open);
    loops.retain(|face| face.len() >= 3);
    loops
}

/// Finds faces that have the same points as an earlier one, in the same or the opposite order, and drops them.
pub fn duplicates(context: &Context, corners: &mut Corners, drop: bool, listed: u32) -> Finding {
    // Neither the first corner nor the direction matters to a sum.
    let hash = |face: usize| {
        let points = corners.face_points(face as u32).iter();
        points.fold(0u64, |sum, point| sum.wrapping_add(finish(add(1, *point))))
    };
    let same = |a: usize, b: usize| same_walk(corners.face_points(a as u32), corners.face_points(b as u32));
    let first = first_equal(context, corners.face_count(), hash, same);
    let keep: Vec<bool> = (0..).zip(&first).map(|(face, first)| face == *first).collect();
    let doubled = (0..).zip(&keep).filter(|(_, keep)| !**keep);
    let finding = Finding::of(doubled.map(|(face, _)| corners.named(face)), listed);
    if drop && finding.count > 0 {
        corners.retain(&keep);
    }
    finding
}

/// Returns whether two closed walks are the same in either direction.
fn same_walk(a: &[u32], b: &[u32]) -> bool {
    let size = a.len();
    let Some(shift) = b.iter().position(|point| a.first() == Some(point)).filter(|_| b.len() == size) else {
        return size == 0 && b.is_empty();
    };
    (0..size).all(|at| a[at] == b[(shift + at) % size]) || (0..size).all(|at| a[at] == b[(shift + size - at) % size])
}

/// Finds faces whose points differ and whose area vanishes beside their longest edge.
pub fn flat(context: &Context, corners: &Corners, listed: u32) -> Finding {
    let is_flat = context.map(corners.face_count(), |face| {
        let points = corners.face_points(face as u32);
        if repeats(points) {
            return false;
        }
        let sides = (0..points.len())
            .map(|at| corners.place(points[at]).distance_squared(corners.place(points[(at + 1) % points.len()])));
        let longest = sides.fold(0.0, f64::max);
        corners.area_vector(face as u32).length() <= 1e-7 * longest
    });
    let flat = (0..).zip(is_flat).filter(|(_, flat)| *flat);
    Finding::of(flat.map(|(face, _)| corners.named(face)), listed)
}

/// Finds points of the input that no face uses, beside points that were joined to others.
pub fn unused(corners: &Corners, joined: &[u32], listed: u32) -> Finding {
    let mut is_used = vec![false; corners.places.len()];
    corners.points.iter().for_each(|point| is_used[*point as usize] = true);
    let unused = (0..).zip(joined).zip(is_used).filter(|((point, to), used)| point == *to && !used);
    Finding::of(unused.map(|((point, _), _)| Element::Point(point)), listed)
}
