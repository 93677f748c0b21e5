//! The values of an attribute seen from the corners of faces, wherever it sits: what formats with corner data write.

use std::collections::HashMap;

use relievo_core::{Attribute, Domain, Mesh, Values};

/// Floats of an attribute and which of them every corner has.
pub(crate) struct CornerValues<'a> {
    pub values: &'a [f32],
    pub width: usize,
    /// The value of every corner, `None` if it is that of its point.
    pub indices: Option<Vec<u32>>,
}

impl<'a> CornerValues<'a> {
    /// The attribute called `name` with at least `width` floats on points or corners.
    pub fn find(mesh: &'a Mesh, name: &str, width: u32) -> Option<Self> {
        let Attribute { domain, width: found, values, indices, .. } = mesh.attribute(name)?;
        let Values::F32(values) = values else { return None };
        if *found < width {
            return None;
        }
        let width = *found as usize;
        let indices = match (domain, indices) {
            (Domain::Face, _) => return None,
            (Domain::Point, _) => None,
            (Domain::Corner, Some(indices)) => Some(indices.clone()),
            (Domain::Corner, None) => Some(equal_values(values, width)),
        };
        Some(Self { values, width, indices })
    }

    /// How many values there are.
    pub fn count(&self) -> usize {
        self.values.len() / self.width
    }

    /// The value of a corner of a face at `point`.
    pub fn index(&self, corner: usize, point: u32) -> u32 {
        self.indices.as_ref().map_or(point, |indices| indices[corner])
    }

    /// The first `N` floats of a value; missing ones are 1, as opacity is.
    pub fn value<const N: usize>(&self, index: u32) -> [f32; N] {
        let start = index as usize * self.width;
        std::array::from_fn(|axis| if axis < self.width { self.values[start + axis] } else { 1.0 })
    }
}

/// For every value the first that has the same bits.
fn equal_values(values: &[f32], width: usize) -> Vec<u32> {
    let mut first = HashMap::new();
    let key = |value: &[f32]| -> [u32; 4] { std::array::from_fn(|axis| value.get(axis).map_or(0, |v| v.to_bits())) };
    values
        .chunks_exact(width)
        .enumerate()
        .map(|(index, value)| *first.entry(key(value)).or_insert(index as u32))
        .collect()
}
