//! Points at the same place as one.

use std::collections::HashMap;

/// Points and triangles where every place has one point, in the order of the first points there. Triangles of which two
/// corners were at one place are left as they are: they have no area.
pub fn weld(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut places = HashMap::with_capacity(points.len());
    let mut welded = Vec::new();
    let numbers: Vec<u32> = points
        .iter()
        .map(|point| {
            // 0 and -0 are one place.
            let place = point.map(|value| (value + 0.0).to_bits());
            *places.entry(place).or_insert_with(|| {
                welded.push(*point);
                welded.len() as u32 - 1
            })
        })
        .collect();
    let number = |vertex: u32| numbers.get(vertex as usize).copied().unwrap_or(vertex);
    (welded, triangles.iter().map(|triangle| triangle.map(number)).collect())
}
