//! Skinning: vertices in a pose, by blended matrices (Equation 1) or by blended dual quaternions (Kavan, Collins, Zara,
//! O'Sullivan 2008), which keep the volume of twisted joints.

use glam::{DMat3, DQuat, DVec3, Mat3, Quat, Vec3};
use relievo_core::{Context, Error, Result};

use crate::character::{Character, Influence};
use crate::clip::{BoneMatrix, Pose};

/// How the maps of several bones are blended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blend {
    /// Weighted sums of matrices.
    #[default]
    Linear,
    /// Weighted sums of dual quaternions; scale and shear are blended linearly before the rigid part.
    DualQuaternion,
}

/// Steps of the polar decomposition; each doubles the digits.
const POLAR_STEPS: usize = 24;

/// The map of a bone as scale and shear, then rotation and translation.
#[derive(Clone, Copy)]
struct RigidBone {
    stretch: Mat3,
    real: Quat,
    dual: Quat,
}

/// Bones of a pose, ready to blend.
enum Bones<'a> {
    Linear(&'a [BoneMatrix]),
    Dual(Vec<RigidBone>),
}

/// A character in a pose.
pub(crate) struct Posing<'a> {
    bones: Bones<'a>,
    weights: &'a [f32],
}

impl<'a> Posing<'a> {
    /// Prepares the bones of a pose.
    ///
    /// # Errors
    /// As [`skin`].
    pub fn new(character: &Character, pose: &'a Pose, blend: Blend) -> Result<Self> {
        Ok(Self { bones: prepare(character, pose, blend)?, weights: &pose.weights })
    }

    /// Returns the position of a vertex.
    pub fn place(&self, character: &Character, vertex: usize) -> [f32; 3] {
        let (linear, translation) = blended(&self.bones, &character.influences[vertex]);
        (linear * Vec3::from(character.morphed(vertex, self.weights)) + translation).to_array()
    }
}

/// Returns the positions of all vertices of a character in a pose.
///
/// # Errors
/// The pose has another number of bones or morph targets than the character.
pub fn skin(context: &Context, character: &Character, pose: &Pose, blend: Blend) -> Result<Vec<[f32; 3]>> {
    let posing = Posing::new(character, pose, blend)?;
    Ok(context.map(character.points.len(), |index| posing.place(character, index)))
}

/// Returns the positions of some vertices of a character in a pose, in the order of `vertices`.
///
/// # Errors
/// As [`skin`], or a vertex does not exist.
pub fn skin_some(
    context: &Context,
    character: &Character,
    pose: &Pose,
    blend: Blend,
    vertices: &[u32],
) -> Result<Vec<[f32; 3]>> {
    let count = character.points.len();
    if let Some(vertex) = vertices.iter().find(|vertex| **vertex as usize >= count) {
        return Err(Error::invalid(format!("vertex {vertex} does not exist; the character has {count}")));
    }
    let posing = Posing::new(character, pose, blend)?;
    Ok(context.map(vertices.len(), |index| posing.place(character, vertices[index] as usize)))
}

/// Returns unit normals of all vertices in a pose, from the attribute `normal`; none if the character lacks it.
///
/// # Errors
/// The pose has another number of bones or morph targets than the character.
pub fn skin_normals(context: &Context, character: &Character, pose: &Pose, blend: Blend) -> Result<Vec<[f32; 3]>> {
    let bones = prepare(character, pose, blend)?;
    let Some(normals) = character.values("normal").map(|values| values.as_chunks::<3>().0) else {
        return Ok(Vec::new());
    };
    Ok(context.map(normals.len(), |index| {
        let (linear, _) = blended(&bones, &character.influences[index]);
        // The inverse transpose up to a factor; cross products exist where the inverse does not.
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        let turned = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * Vec3::from(normals[index]);
        let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
        (turned * sign).normalize_or_zero().to_array()
    }))
}

fn prepare<'a>(character: &Character, pose: &'a Pose, blend: Blend) -> Result<Bones<'a>> {
    if pose.bones.len() != character.bones.len() {
        let counts = (pose.bones.len(), character.bones.len());
        return Err(Error::invalid(format!("the pose has {} bones and the character {}", counts.0, counts.1)));
    }
    if pose.weights.len() != character.morphs.count as usize {
        let counts = (pose.weights.len(), character.morphs.count);
        return Err(Error::invalid(format!(
            "the pose has {} weights and the character {} morph targets",
            counts.0, counts.1
        )));
    }
    Ok(match blend {
        Blend::Linear => Bones::Linear(&pose.bones),
        Blend::DualQuaternion => Bones::Dual(pose.bones.iter().map(rigid).collect()),
    })
}

/// Returns the rows of a bone as graphics devices blend dual quaternions (`shaders/crowd/crowd_pose.wgsl`): those of its stretch,
/// then its rotation and dual part as quaternions with the real part last.
pub fn dual_rows(bone: &BoneMatrix) -> [[f32; 4]; 5] {
    let RigidBone { stretch, real, dual } = rigid(bone);
    let row = |at: usize| stretch.row(at).extend(0.0).to_array();
    [row(0), row(1), row(2), real.to_array(), dual.to_array()]
}

/// Returns the blended map of a vertex.
fn blended(bones: &Bones, influence: &Influence) -> (Mat3, Vec3) {
    let parts = influence.bones.iter().zip(influence.weights).filter(|(_, weight)| *weight > 0.0);
    match bones {
        Bones::Linear(bones) => {
            let mut sum = [[0.0f32; 4]; 3];
            for (bone, weight) in parts {
                for (row, from) in sum.iter_mut().zip(&bones[usize::from(*bone)]) {
                    for (value, from) in row.iter_mut().zip(from) {
                        *value += weight * from;
                    }
                }
            }
            let column = |at: usize| Vec3::new(sum[0][at], sum[1][at], sum[2][at]);
            (Mat3::from_cols(column(0), column(1), column(2)), column(3))
        }
        Bones::Dual(bones) => {
            let mut stretch = Mat3::ZERO;
            let (mut real, mut dual) = (glam::Vec4::ZERO, glam::Vec4::ZERO);
            // Quaternions of opposite sign are one rotation: all are taken on the side of the strongest bone.
            let strongest =
                parts.clone().fold(
                    (0, -1.0),
                    |most, (bone, weight)| {
                        if weight > most.1 { (usize::from(*bone), weight) } else { most }
                    },
                );
            let pivot = bones[strongest.0].real;
            for (bone, weight) in parts {
                let bone = &bones[usize::from(*bone)];
                let signed = if pivot.dot(bone.real) < 0.0 { -weight } else { weight };
                stretch += bone.stretch * weight;
                real += glam::Vec4::from(bone.real) * signed;
                dual += glam::Vec4::from(bone.dual) * signed;
            }
            let length = real.length().max(f32::MIN_POSITIVE);
            let real = Quat::from_vec4(real / length);
            let dual = Quat::from_vec4(dual / length);
            let translation = 2.0 * (dual * real.conjugate()).xyz();
            (Mat3::from_quat(real) * stretch, translation)
        }
    }
}

/// Splits the map of a bone into stretch, rotation and translation by polar decomposition (Higham 1986).
fn rigid(matrix: &BoneMatrix) -> RigidBone {
    let column = |at: usize| DVec3::new(f64::from(matrix[0][at]), f64::from(matrix[1][at]), f64::from(matrix[2][at]));
    let linear = DMat3::from_cols(column(0), column(1), column(2));
    let determinant = linear.determinant();
    let mut turn = if determinant < 0.0 { -linear } else { linear };
    if determinant.abs() > 1e-30 {
        for _ in 0..POLAR_STEPS {
            let next = (turn + turn.inverse().transpose()) * 0.5;
            if next == turn {
                break;
            }
            turn = next;
        }
    } else {
        turn = DMat3::IDENTITY;
    }
    let real = DQuat::from_mat3(&turn).normalize();
    let translation = column(3);
    let dual = DQuat::from_xyzw(translation.x, translation.y, translation.z, 0.0) * real * 0.5;
    RigidBone {
        stretch: (turn.transpose() * linear).as_mat3(),
        real: real.as_quat(),
        dual: Quat::from_xyzw(dual.x as f32, dual.y as f32, dual.z as f32, dual.w as f32),
    }
}
