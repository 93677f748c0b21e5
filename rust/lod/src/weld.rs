//! Points at the same place as one.

use std::collections::HashMap;

/// Points and triangles of a mesh where every place has one point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Welded {
    /// In the order of the first points there.
    pub points: Vec<[f32; 3]>,
    /// Triangles of which two corners were at one place are left as they are: they have no area.
    pub triangles: Vec<[u32; 3]>,
    /// Of every point of the mesh its number here.
    pub numbers: Vec<u32>,
}

/// Takes points at the same place as one.
pub fn weld(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Welded {
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
    let triangles = triangles.iter().map(|triangle| triangle.map(number)).collect();
    Welded { points: welded, triangles, numbers }
}
