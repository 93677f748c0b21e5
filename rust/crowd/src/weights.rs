//! Weights of morph targets that a host gives an agent, and what they add to its errors and boxes.
//!
//! Errors are measured at the weights of the clips. A weight that differs from that of the pose by d moves a place of a surface by
//! d times a mean of A o over vertices, where o is the offset of a vertex and A the blended map of its bones. Let the offsets in
//! a group and below it lie within r of their middle c, s be the largest factor of lengths of the bones, and t the largest norm
//! of the difference of two bones that move the group. Two places then move apart by at most d (2 s r + t |c|), because |c| moves
//! both but for their bones; with 0 in place of c that is twice d s times the longest offset, which holds for bones that are
//! blended as dual quaternions too. The distance between the surfaces of a
//! group grows by at most the sum of the smaller of both over all targets, and its box by the sum of d s |o|. What
//! is added to a group is at least what is added to those below it, so that cuts stay free of cracks.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use glam::{DMat3, DVec3};
use relievo_core::{Error, Result};

use crate::build::norm::norm;
use crate::clip::{BoneMatrix, Clip, Pose};
use crate::hierarchy::{CrowdModel, NONE};
use crate::skinning::Blend;

/// Bones of a group at most whose differences are looked at.
const MAX_GROUP_BONES: usize = 12;

/// The offsets of a model, which all its agents share.
#[derive(Clone, Debug, Default)]
pub(crate) struct Offsets {
    groups: Vec<GroupOffsets>,
    /// The length of the longest offset of every morph target.
    longest: Vec<f64>,
    /// For every clip the norms of the differences of bones of each group; made when first needed.
    turns: Vec<OnceLock<Vec<f64>>>,
}

/// What moves the vertices of a group and of those below it.
#[derive(Clone, Debug, Default)]
struct GroupOffsets {
    /// The bones, in order; none where there are more than [`MAX_GROUP_BONES`].
    bones: Vec<u16>,
    has_many: bool,
    /// The groups below.
    below: Vec<u32>,
    /// For each morph target that moves some of the vertices where the offsets of all are.
    morphs: BTreeMap<u32, Reach>,
}

/// Where offsets are.
#[derive(Clone, Copy, Debug)]
struct Reach {
    low: DVec3,
    high: DVec3,
    /// The length of the longest.
    longest: f64,
}

impl Reach {
    const ZERO: Self = Self { low: DVec3::ZERO, high: DVec3::ZERO, longest: 0.0 };

    fn of(offset: [f32; 3]) -> Self {
        let offset = DVec3::from(offset.map(f64::from));
        Self { low: offset, high: offset, longest: offset.length() }
    }

    fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high), longest: self.longest.max(other.longest) }
    }
}

impl GroupOffsets {
    /// Returns that of the vertices of some triangles.
    fn of(model: &CrowdModel, triangles: &[[u32; 3]]) -> Self {
        let character = &model.character;
        let mut made = Self::default();
        let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
        for vertex in triangles.as_flattened() {
            let influence = &character.influences[*vertex as usize];
            made.add_bones(influence.bones.iter().zip(influence.weights).filter(|it| it.1 > 0.0).map(|it| *it.0));
            for found in character.morphs.of(*vertex as usize) {
                let own = Reach::of(found.offset);
                made.morphs.entry(found.morph).and_modify(|known| *known = known.with(own)).or_insert(own);
                *counts.entry(found.morph).or_default() += 1;
            }
        }
        for (morph, reach) in &mut made.morphs {
            // Vertices without an offset stay.
            if counts[morph] < 3 * triangles.len() {
                *reach = reach.with(Reach::ZERO);
            }
        }
        made
    }

    fn add_bones(&mut self, bones: impl Iterator<Item = u16>) {
        for bone in bones {
            if let Err(place) = self.bones.binary_search(&bone)
                && !self.has_many
            {
                self.bones.insert(place, bone);
            }
        }
        if self.bones.len() > MAX_GROUP_BONES {
            self.has_many = true;
            self.bones.clear();
        }
    }

    /// Adds the vertices of another part; vertices of one that a morph target does not move have offsets of zero.
    fn join(&mut self, other: &Self) {
        self.has_many |= other.has_many;
        self.below.extend(&other.below);
        self.add_bones(other.bones.iter().copied());
        for (morph, reach) in &mut self.morphs {
            *reach = reach.with(other.morphs.get(morph).copied().unwrap_or(Reach::ZERO));
        }
        for (morph, reach) in &other.morphs {
            self.morphs.entry(*morph).or_insert(reach.with(Reach::ZERO));
        }
    }

    /// Returns the largest norm of the difference of two of the bones in the poses of a clip.
    fn turn(&self, clip: &Clip) -> f64 {
        if self.has_many {
            return f64::INFINITY;
        }
        let largest = |pose: &Pose| {
            let maps: Vec<DMat3> = self.bones.iter().map(|bone| linear(&pose.bones[usize::from(*bone)])).collect();
            let pairs = maps.iter().enumerate().flat_map(|(at, one)| maps[..at].iter().map(move |other| *one - *other));
            pairs.map(|difference| norm(&difference)).fold(0.0, f64::max)
        };
        clip.poses.iter().map(largest).fold(0.0, f64::max)
    }
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
        let turns = vec![OnceLock::new(); model.clips.len()];
        if character.morphs.count == 0 {
            return Self { groups: vec![GroupOffsets::default(); model.groups.len()], longest, turns };
        }
        // The triangles of a model that is read cluster by cluster are not known: each may have any vertex.
        if !model.has_triangles() {
            let all = (0..).zip(&longest).map(|(morph, length)| {
                let corner = DVec3::splat(*length);
                (morph, Reach { low: -corner, high: corner, longest: *length })
            });
            let any = GroupOffsets { has_many: true, morphs: all.collect(), ..GroupOffsets::default() };
            return Self { groups: vec![any; model.groups.len()], longest, turns };
        }
        let mut groups: Vec<Option<GroupOffsets>> = vec![None; model.groups.len()];
        // Clusters come after the clusters that they are made of, so that the group below is complete.
        for (index, cluster) in (0..).zip(&model.clusters) {
            if cluster.used_by == NONE {
                continue;
            }
            let mut own = GroupOffsets::of(model, model.triangles(index));
            if let Some(below) = groups.get(cluster.made_by as usize).and_then(Option::as_ref) {
                own.join(below);
                own.below = vec![cluster.made_by];
            }
            match &mut groups[cluster.used_by as usize] {
                Some(known) => known.join(&own),
                empty => *empty = Some(own),
            }
        }
        let mut groups: Vec<GroupOffsets> = groups.into_iter().map(Option::unwrap_or_default).collect();
        // Dual quaternions do not blend the differences of bones.
        groups.iter_mut().for_each(|group| group.has_many |= model.blend == Blend::DualQuaternion);
        Self { groups, longest, turns }
    }

    /// Returns what weights add to errors and boxes of an agent that plays a clip of the model, which has a number.
    ///
    /// # Errors
    /// There is another number of weights than of morph targets, or one is not finite or so large that places are not.
    pub fn own(&self, (number, clip): (u32, &Clip), weights: &[f32]) -> Result<OwnWeights> {
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
        let all = self.longest.iter().zip(&differences).map(|(length, difference)| length * difference);
        let moved = (stretch * all.sum::<f64>()) as f32;
        let is_finite = weights.iter().all(|weight| weight.is_finite());
        if !(is_finite && (4.0 * moved).is_finite()) {
            return Err(Error::invalid("a weight is not finite or too large").advise("give weights near 0 to 1"));
        }
        let turns = self.turns[number as usize].get_or_init(|| self.groups.iter().map(|it| it.turn(clip)).collect());
        let mut added: Vec<f32> = Vec::with_capacity(self.groups.len());
        for (group, turn) in self.groups.iter().zip(turns) {
            let apart = group.morphs.iter().map(|(morph, reach)| {
                let (middle, half) = (0.5 * (reach.low + reach.high), 0.5 * (reach.high - reach.low));
                let about_middle = 2.0 * stretch * half.length() + turn * middle.length();
                // No number where bones differ without bound and the middle is 0.
                differences[*morph as usize] * about_middle.min(2.0 * stretch * reach.longest)
            });
            // A larger box may have a smaller middle.
            let below = group.below.iter().map(|it| added[*it as usize]).fold(0.0, f32::max);
            added.push((apart.sum::<f64>() as f32).next_up().max(below));
        }
        Ok(OwnWeights { weights: weights.to_vec(), added, moved: moved.next_up() })
    }
}

/// Returns the linear part of the map of a bone.
pub(crate) fn linear(rows: &BoneMatrix) -> DMat3 {
    let column = |at: usize| DVec3::new(f64::from(rows[0][at]), f64::from(rows[1][at]), f64::from(rows[2][at]));
    DMat3::from_cols(column(0), column(1), column(2))
}
