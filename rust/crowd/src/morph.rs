//! Morph targets that clips move: offsets of vertices, weighted anew in every pose before bones move them.

use glam::DVec3;

use crate::character::Character;

/// Morph targets of a character at most.
pub const MAX_MORPHS: usize = 1 << 16;

/// What a morph target adds to a vertex at weight one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MorphOffset {
    /// The morph target, from 0.
    pub morph: u32,
    /// Units of the model, at binding.
    pub offset: [f32; 3],
}

/// The morph targets that move in some clip. Others are part of the vertices at binding.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Morphs {
    /// How many there are. Poses have a weight for each.
    pub count: u32,
    /// Where the offsets of each vertex begin, and their end; empty without morph targets.
    pub starts: Vec<u32>,
    /// Offsets other than zero, one vertex after the other.
    pub offsets: Vec<MorphOffset>,
}

impl Morphs {
    /// Returns the offsets of a vertex.
    pub fn of(&self, vertex: usize) -> &[MorphOffset] {
        match (self.starts.get(vertex), self.starts.get(vertex + 1)) {
            (Some(from), Some(to)) => &self.offsets[*from as usize..*to as usize],
            _ => &[],
        }
    }

    /// Returns the length of the longest offset of every morph target.
    pub(crate) fn extents(&self) -> Vec<f64> {
        let mut longest = vec![0.0f64; self.count as usize];
        for found in &self.offsets {
            let length = DVec3::from(found.offset.map(f64::from)).length();
            let known = &mut longest[found.morph as usize];
            *known = known.max(length);
        }
        longest
    }

    /// Whether the lists fit together and `vertices`.
    pub(crate) fn fits(&self, vertices: usize) -> bool {
        if self.count == 0 {
            return self.starts.is_empty() && self.offsets.is_empty();
        }
        self.count as usize <= MAX_MORPHS
            && self.starts.len() == vertices + 1
            && self.starts.is_sorted()
            && self.starts[0] == 0
            && self.starts[vertices] as usize == self.offsets.len()
            && self.offsets.iter().all(|it| it.morph < self.count && it.offset.iter().all(|value| value.is_finite()))
    }
}

impl Character {
    /// Returns the place of a vertex at binding with its morph targets at some weights.
    pub(crate) fn morphed(&self, vertex: usize, weights: &[f32]) -> [f32; 3] {
        let mut point = self.points[vertex];
        for MorphOffset { morph, offset } in self.morphs.of(vertex) {
            let weight = weights[*morph as usize];
            point.iter_mut().zip(offset).for_each(|(value, offset)| *value += weight * offset);
        }
        point
    }
}
