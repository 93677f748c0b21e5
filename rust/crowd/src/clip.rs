//! Clips: animations sampled as poses at a fixed rate.
//!
//! An agent is always shown in one of the sampled poses, so that errors and bounds hold in every pose that can be seen,
//! and agents in equal poses can share them.

use glam::{DAffine3, DVec3, Vec3};
use relievo_core::{Context, Error, Result};
use relievo_meshio::Model;

use crate::character::{Character, MorphNode};

/// Poses of all clips of a character at most.
pub const MAX_POSES: usize = 1 << 14;

/// The affine map of a bone from the space of the vertices at binding to the model's: three rows of four numbers.
pub type BoneMatrix = [[f32; 4]; 3];

/// A pose: the maps of all bones, and the weights of all morph targets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// One map for each of [`Character::bones`].
    pub bones: Vec<BoneMatrix>,
    /// One weight for each of [`Character::morphs`].
    pub weights: Vec<f32>,
}

/// An animation as a loop of poses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clip {
    /// Name of the animation.
    pub name: String,
    /// Poses for each second.
    pub rate: f32,
    /// Poses, at least one, from the start of the animation to just before its end.
    pub poses: Vec<Pose>,
}

impl Clip {
    /// Returns the index of the pose shown at `time` seconds; the clip repeats.
    pub fn pose_at(&self, time: f64) -> usize {
        let count = self.poses.len().max(1) as f64;
        let frame = (time * f64::from(self.rate)).round().rem_euclid(count);
        (frame as usize).min(self.poses.len().saturating_sub(1))
    }
}

/// The skeleton in a pose while a hierarchy is built: the maps of all nodes and of all bones, in f64, and the weights of
/// morph targets.
#[derive(Clone, Debug)]
pub(crate) struct Skeleton {
    pub nodes: Vec<DAffine3>,
    pub bones: Vec<DAffine3>,
    pub weights: Vec<f32>,
}

impl Skeleton {
    fn of(character: &Character, nodes: Vec<DAffine3>, weights: Vec<f32>) -> Self {
        let bones = character.bones.iter().map(|bone| nodes[bone.node as usize] * bone.inverse_bind).collect();
        Self { nodes, bones, weights }
    }

    /// Returns the position of a vertex in this pose.
    pub fn place(&self, character: &Character, vertex: usize) -> DVec3 {
        let influence = &character.influences[vertex];
        let point = DVec3::from(character.morphed(vertex, &self.weights).map(f64::from));
        let parts = influence.bones.iter().zip(influence.weights).filter(|(_, weight)| *weight > 0.0);
        parts.map(|(bone, weight)| self.bones[usize::from(*bone)].transform_point3(point) * f64::from(weight)).sum()
    }

    /// Returns the maps of the bones in single precision.
    pub fn pose(&self) -> Pose {
        let rows = |map: &DAffine3| {
            let [x, y, z] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis];
            std::array::from_fn(|row| [x[row], y[row], z[row], map.translation[row]].map(|value| value as f32))
        };
        Pose { bones: self.bones.iter().map(rows).collect(), weights: self.weights.clone() }
    }
}

/// A clip with the skeletons of its poses.
pub(crate) struct Sampled {
    pub name: String,
    pub rate: f32,
    pub skeletons: Vec<Skeleton>,
}

/// Samples the animations of a model that `wanted` gives by index at `rate` poses a second, with the weights of the morph
/// targets of some nodes. Without any animation, the only pose is that at rest.
///
/// # Errors
/// An animation does not exist, there are more than [`MAX_POSES`] poses, or a matrix is not finite.
pub(crate) fn sample(
    context: &Context,
    model: &Model,
    (character, morphs): (&Character, &[MorphNode]),
    wanted: &[usize],
    rate: f32,
) -> Result<Vec<Sampled>> {
    // Only nodes are posed: their meshes would be deformed at every time for nothing.
    let mut bare = Model { nodes: model.nodes.clone(), animations: model.animations.clone(), ..Model::default() };
    for node in &mut bare.nodes {
        (node.mesh, node.skin) = (None, None);
    }
    if wanted.is_empty() {
        let rest = Skeleton::of(character, bare.rest(context).matrices, vec![0.0; character.morphs.count as usize]);
        return checked(vec![Sampled { name: "rest".into(), rate, skeletons: vec![rest] }]);
    }
    let mut clips = Vec::new();
    let mut count = 0;
    for &index in wanted {
        let animation = model.animations.get(index).ok_or_else(|| {
            Error::invalid(format!("animation {index} does not exist"))
                .advise(format!("the model has {} animations", model.animations.len()))
        })?;
        let (start, end) = animation.range();
        let poses = ((end - start) * f64::from(rate)).round().max(1.0);
        count += poses as usize;
        if !(poses <= MAX_POSES as f64) || count > MAX_POSES {
            return Err(Error::unsupported(format!("the clips have more than {MAX_POSES} poses"))
                .at(format!("animation `{}`", animation.name))
                .advise("lower the rate, or build from fewer clips"));
        }
        let skeletons = (0..poses as usize).map(|frame| {
            let time = start + frame as f64 / f64::from(rate);
            let pose = bare.pose(context, index, time)?;
            let mut weights = vec![0.0; character.morphs.count as usize];
            if !morphs.is_empty() {
                let of_nodes = model.morph_weights(index, time)?;
                for MorphNode { node, first, count } in morphs {
                    let own = weights[*first..first + count].iter_mut();
                    own.zip(&of_nodes[*node]).for_each(|(weight, from)| *weight = *from as f32);
                }
            }
            Ok(Skeleton::of(character, pose.matrices, weights))
        });
        let skeletons = skeletons.collect::<Result<Vec<_>>>()?;
        let name = if animation.name.is_empty() { index.to_string() } else { animation.name.clone() };
        clips.push(Sampled { name, rate, skeletons });
    }
    checked(clips)
}

fn checked(clips: Vec<Sampled>) -> Result<Vec<Sampled>> {
    for clip in &clips {
        let finite = |skeleton: &Skeleton| {
            let has_bones =
                skeleton.bones.iter().all(|bone| Vec3::is_finite(bone.translation.as_vec3()) && bone.is_finite());
            has_bones && skeleton.weights.iter().all(|weight| weight.is_finite())
        };
        if let Some(frame) = clip.skeletons.iter().position(|skeleton| !finite(skeleton)) {
            return Err(Error::invalid("a bone or a weight is not finite")
                .at(format!("clip `{}`, pose {frame}", clip.name))
                .advise("repair the animation and export it again"));
        }
    }
    Ok(clips)
}
