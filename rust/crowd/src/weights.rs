//! Weights of morph targets that a host gives an agent, and what they add to its errors and boxes.
//!
//! Errors are measured at the weights of the clips. A weight that differs from that of the pose by d moves a vertex by at most
//! d s |o|, where o is the offset of the vertex and s the largest factor of lengths of the bones. So the distance between the
//! surfaces of a group grows by at most twice the sum of these terms over all targets, with the longest offsets in the group
//! and below it, and its box by the sum. Both grow upwards, so that cuts stay free of cracks.

use relievo_core::{Error, Result};

use crate::clip::{Clip, Pose};
use crate::hierarchy::CrowdModel;
use crate::norm::norm;

/// The longest offsets of a model, which all its agents share.
#[derive(Clone, Debug, Default)]
pub(crate) struct Offsets {
    /// For each group the morph targets that move its vertices or those below it, with the length of the longest offset.
    of_groups: Vec<Vec<(u32, f64)>>,
    /// The length of the longest offset of every morph target.
    longest: Vec<f64>,
}

/// What an agent shows in place of the weights of its clip.
#[derive(Clone, Debug, Default)]
pub(crate) struct OwnWeights {
    /// A weight for each morph target.
    pub weights: Vec<f32>,
    /// What is added to the error of every group, in units of the model.
    pub added: Vec<f32>,
    /// How far a vertex may be outside the box of its group, in units of the model.
    pub moved: f32,
}

impl Offsets {
    pub fn of(model: &CrowdModel) -> Self {
        let character = &model.character;
        let longest = character.morphs.extents();
        if character.morphs.count == 0 {
            return Self { of_groups: vec![Vec::new(); model.groups.len()], longest };
        }
        let all: Vec<(u32, f64)> = (0..).zip(longest.iter().copied()).collect();
        // The triangles of a model that is read cluster by cluster are not known: each may have any vertex.
        if character.triangles.iter().all(|triangle| *triangle == [0; 3]) {
            return Self { of_groups: vec![all; model.groups.len()], longest };
        }
        let mut of_groups: Vec<Vec<(u32, f64)>> = vec![Vec::new(); model.groups.len()];
        // Clusters come after those that they are made of, so that the group below is complete.
        for (index, cluster) in (0..).zip(&model.clusters) {
            let mut found = of_groups.get(cluster.made_by as usize).cloned().unwrap_or_default();
            for vertex in model.triangles(index).iter().flatten() {
                for offset in character.morphs.of(*vertex as usize) {
                    let length = glam::DVec3::from(offset.offset.map(f64::from)).length();
                    raise(&mut found, (offset.morph, length));
                }
            }
            if let Some(group) = of_groups.get_mut(cluster.used_by as usize) {
                found.into_iter().for_each(|entry| raise(group, entry));
            }
        }
        Self { of_groups, longest }
    }

    /// Returns what weights add to errors and boxes of an agent that plays `clip`.
    ///
    /// # Errors
    /// There is another number of weights than of morph targets, or one is not finite or so large that places are not.
    pub fn own(&self, clip: &Clip, weights: &[f32]) -> Result<OwnWeights> {
        let count = self.longest.len();
        if weights.len() != count {
            return Err(Error::invalid(format!("there are {} weights for {count} morph targets", weights.len()))
                .advise("give one for each morph target that the clips of the model move"));
        }
        let difference = |at: usize| {
            let away = |pose: &Pose| f64::from(weights[at] - pose.weights[at]).abs();
            clip.poses.iter().map(away).fold(0.0, f64::max)
        };
        let differences: Vec<f64> = (0..count).map(difference).collect();
        let stretch = |pose: &Pose| pose.bones.iter().map(|rows| norm(&linear(rows))).fold(0.0, f64::max);
        let stretch = clip.poses.iter().map(stretch).fold(0.0, f64::max);
        let sum =
            |of: &[(u32, f64)]| of.iter().map(|(morph, length)| differences[*morph as usize] * length).sum::<f64>();
        let all: Vec<(u32, f64)> = (0..).zip(self.longest.iter().copied()).collect();
        let moved = (stretch * sum(&all)) as f32;
        let is_finite = weights.iter().all(|weight| weight.is_finite());
        if !(is_finite && (4.0 * moved).is_finite()) {
            return Err(Error::invalid("a weight is not finite or too large").advise("give weights near 0 to 1"));
        }
        let added = self.of_groups.iter().map(|of| ((2.0 * stretch * sum(of)) as f32).next_up());
        Ok(OwnWeights { weights: weights.to_vec(), added: added.collect(), moved: moved.next_up() })
    }
}

/// Raises the length of a morph target in a list.
fn raise(list: &mut Vec<(u32, f64)>, (morph, length): (u32, f64)) {
    match list.iter_mut().find(|known| known.0 == morph) {
        Some(known) => known.1 = known.1.max(length),
        None => list.push((morph, length)),
    }
}

/// Returns the linear part of the map of a bone.
fn linear(rows: &crate::clip::BoneMatrix) -> glam::DMat3 {
    let column = |at: usize| glam::DVec3::new(f64::from(rows[0][at]), f64::from(rows[1][at]), f64::from(rows[2][at]));
    glam::DMat3::from_cols(column(0), column(1), column(2))
}
