//! Places: vertices that are at one point and follow the same bones and morph targets, whatever their attributes are.
//!
//! Edges, borders and collapses are those of places. A place with a seam has several charts: groups of vertices that
//! agree in everything but their normal.

use std::collections::HashMap;

use crate::character::{Character, Influence};

/// The places of a character.
pub(crate) struct Places {
    /// The place of every vertex.
    pub of: Vec<u32>,
    /// A vertex of every place.
    pub vertices: Vec<u32>,
    /// The chart of every vertex. Vertices of one chart are at one place.
    pub charts: Vec<u32>,
    /// Vertices sorted by charts, and where each chart begins.
    pub by_chart: Vec<u32>,
    pub starts: Vec<u32>,
    /// Vertices sorted by places, and where each place begins.
    by_place: Vec<u32>,
    place_starts: Vec<u32>,
}

impl Places {
    pub fn of(character: &Character) -> Self {
        let mut places = HashMap::with_capacity(character.points.len());
        let mut vertices = Vec::new();
        let of: Vec<u32> = character
            .points
            .iter()
            .zip(&character.influences)
            .zip(0u32..)
            .map(|((point, influence), vertex)| {
                // 0 and -0 are one place.
                let offsets = character.morphs.of(vertex as usize).iter();
                let offsets: Vec<u32> = offsets
                    .flat_map(|it| std::iter::once(it.morph).chain(it.offset.map(|value| (value + 0.0).to_bits())))
                    .collect();
                let key = (point.map(|value| (value + 0.0).to_bits()), ordered(influence), offsets);
                *places.entry(key).or_insert_with(|| {
                    vertices.push(vertex);
                    vertices.len() as u32 - 1
                })
            })
            .collect();
        let columns: Vec<(usize, &[f32])> = character
            .attributes
            .iter()
            .filter(|attribute| !is_direction(&attribute.name))
            .filter_map(|attribute| Some((attribute.width as usize, character.values(&attribute.name)?)))
            .collect();
        let mut known = HashMap::with_capacity(of.len());
        let mut key = Vec::new();
        let mut charts = Vec::with_capacity(of.len());
        for (vertex, place) in of.iter().enumerate() {
            key.clear();
            key.push(*place);
            for (width, values) in &columns {
                key.extend(values[vertex * width..][..*width].iter().map(|value| (value + 0.0).to_bits()));
            }
            let next = known.len() as u32;
            charts.push(match known.get(&key) {
                Some(chart) => *chart,
                None => {
                    known.insert(key.clone(), next);
                    next
                }
            });
        }
        let (by_chart, starts) = sorted(&charts, known.len());
        let (by_place, place_starts) = sorted(&of, vertices.len());
        Self { of, vertices, charts, by_chart, starts, by_place, place_starts }
    }

    /// Returns the number of places.
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Returns the vertices of a place.
    pub fn at(&self, place: u32) -> &[u32] {
        &self.by_place[self.place_starts[place as usize] as usize..self.place_starts[place as usize + 1] as usize]
    }

    /// Returns the vertices of a chart.
    pub fn of_chart(&self, chart: u32) -> &[u32] {
        &self.by_chart[self.starts[chart as usize] as usize..self.starts[chart as usize + 1] as usize]
    }
}

/// Returns vertices sorted by keys below `count`, and where those of each key begin, and their end.
fn sorted(keys: &[u32], count: usize) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; count + 1];
    keys.iter().for_each(|key| starts[*key as usize + 1] += 1);
    for key in 1..starts.len() {
        starts[key] += starts[key - 1];
    }
    let mut vertices: Vec<u32> = (0..keys.len() as u32).collect();
    vertices.sort_by_key(|vertex| keys[*vertex as usize]);
    (vertices, starts)
}

/// Returns the bones of a vertex with their weights in an order that does not depend on that of the file.
fn ordered(influence: &Influence) -> [(u16, u32); 4] {
    let mut pairs = [(0, 0); 4];
    for (pair, (bone, weight)) in pairs.iter_mut().zip(influence.bones.iter().zip(influence.weights)) {
        if weight > 0.0 {
            *pair = (*bone, weight.to_bits());
        }
    }
    pairs.sort_unstable();
    pairs
}

/// Whether values of an attribute are directions, which differ at creases that are no seams.
fn is_direction(name: &str) -> bool {
    name == "normal" || name == "tangent"
}
