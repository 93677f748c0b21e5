//! Deformation levels: how much a vertex moves against the bones that it follows (Section 4.2).

use glam::DVec3;
use relievo_core::Context;

use crate::character::{Character, Influence};
use crate::clip::Skeleton;

/// Returns the level of every vertex: the diagonal of the box of its path over all poses, in the frame of the least common
/// ancestor of its bones, in units of the model.
pub(crate) fn levels(context: &Context, character: &Character, skeletons: &[&Skeleton]) -> Vec<f32> {
    let ancestors: Vec<usize> = character.influences.iter().map(|influence| ancestor(character, influence)).collect();
    let inverses: Vec<Vec<_>> =
        skeletons.iter().map(|skeleton| skeleton.nodes.iter().map(|node| node.inverse()).collect()).collect();
    context.map(character.points.len(), |vertex| {
        let influence = &character.influences[vertex];
        let is_still = character.morphs.of(vertex).is_empty();
        if is_still && influence.weights.iter().filter(|weight| **weight > 0.0).count() == 1 {
            return 0.0;
        }
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (skeleton, inverses) in skeletons.iter().zip(&inverses) {
            let place = inverses[ancestors[vertex]].transform_point3(skeleton.place(character, vertex));
            if place.is_finite() {
                (low, high) = (low.min(place), high.max(place));
            }
        }
        if low.is_finite() { (high - low).length() as f32 } else { 0.0 }
    })
}

/// Returns the node that is above all bones of a vertex, or the first node where they are in different trees.
fn ancestor(character: &Character, influence: &Influence) -> usize {
    let mut nodes = influence
        .bones
        .iter()
        .zip(influence.weights)
        .filter(|(_, weight)| *weight > 0.0)
        .map(|(bone, _)| character.bones[usize::from(*bone)].node);
    let Some(first) = nodes.next() else { return 0 };
    nodes.fold(first, |one, other| common(&character.parents, one, other)) as usize
}

/// Parents have lower numbers than their children, so the higher of two nodes steps up until both meet.
fn common(parents: &[Option<u32>], mut one: u32, mut other: u32) -> u32 {
    while one != other {
        let higher = if one > other { &mut one } else { &mut other };
        match parents[*higher as usize] {
            Some(parent) => *higher = parent,
            None => return 0,
        }
    }
    one
}
