//! Welds points that coincide or lie within a tolerance of each other.
//!
//! Only points on the boundary, or on edges of more than two faces, are welded. Points that faces surround would become
//! non-manifold, and what a repair has split would come together again at the next one.

use std::collections::HashMap;

use glam::DVec3;
use relievo_core::Context;

use crate::corners::Corners;
use crate::edges::{BRANCHING, Edges};
use crate::equal::{add, first_equal};
use crate::report::{Element, Finding};

/// Finds the first point at the same place as each, or within `tolerance` of it. A point is joined to the first point within reach that was not joined itself, so that chains of close points do
/// not collapse. Returns the point each one was joined to.
pub fn weld(context: &Context, corners: &Corners, tolerance: f32) -> Vec<u32> {
    let is_open = open_points(context, corners);
    let places = &corners.places;
    // Adding zero makes a positive zero of a negative one.
    let bits = |index: usize| places[index].map(|value| (value + 0.0).to_bits());
    let mut joined = first_equal(
        context,
        places.len(),
        |index| bits(index).into_iter().fold(0, add),
        |a, b| is_open[a] && is_open[b] && bits(a) == bits(b),
    );
    if tolerance > 0.0 {
        join_near(corners, &is_open, &mut joined, f64::from(tolerance));
    }
    joined
}

/// Makes corners use the points that theirs were joined to.
pub fn apply(context: &Context, corners: &mut Corners, joined: &[u32]) {
    context.for_each_mut(&mut corners.points, |_, point| *point = joined[*point as usize]);
}

/// Returns which points lie on edges of one face or of more than two.
fn open_points(context: &Context, corners: &Corners) -> Vec<bool> {
    let mut is_open = vec![false; corners.places.len()];
    // In a soup no corner shares its point, and all points are open.
    if !corners.points.iter().any(|point| std::mem::replace(&mut is_open[*point as usize], true)) {
        return is_open;
    }
    is_open.fill(false);
    let edges = Edges::of(context, corners);
    for (half, mate) in (0..).zip(&edges.mates) {
        if *mate >= BRANCHING {
            is_open[corners.from(half) as usize] = true;
            is_open[corners.to(half) as usize] = true;
        }
    }
    is_open
}

/// Points that were joined to another one.
pub fn joined_points(joined: &[u32], listed: u32) -> Finding {
    let moved = (0..).zip(joined).filter(|(point, to)| point != *to);
    Finding::of(moved.map(|(point, _)| Element::Point(point)), listed)
}

/// Joins points in order to the first one within reach, by a grid of cells twice as wide as the tolerance: a point
/// reaches eight cells at most.
fn join_near(corners: &Corners, is_open: &[bool], joined: &mut [u32], tolerance: f64) {
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let cell = |place: DVec3| place.to_array().map(|value| (value / (2.0 * tolerance)).floor() as i64);
    for point in 0..joined.len() {
        let target = joined[point] as usize;
        if target != point {
            joined[point] = joined[target];
            continue;
        }
        let place = corners.place(point as u32);
        if !is_open[point] {
            continue;
        }
        let (low, high) = (cell(place - tolerance), cell(place + tolerance));
        let mut nearest: Option<u32> = None;
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let near = cells.get(&[x, y, z]).into_iter().flatten().copied();
                    let near = near.filter(|other| corners.place(*other).distance(place) <= tolerance);
                    nearest = near.chain(nearest).min();
                }
            }
        }
        match nearest {
            Some(other) => joined[point] = other,
            None => cells.entry(cell(place)).or_default().push(point as u32),
        }
    }
}
