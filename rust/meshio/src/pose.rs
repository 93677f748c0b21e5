//! Poses: what an animation makes of a model at one time. Curves (glTF 2.0, Appendix C), then morph targets, then
//! linear blend skinning or the node's placement; all in f64, results in f32.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use relievo_core::error::nearest;
use relievo_core::{Context, Domain, Error, ErrorKind, Mesh, Result, Values};

use crate::model::{Animation, Channel, Interpolation, Model, Node, Part, Placement, Property, ShapeKeys, Skin};
use crate::transform;

/// A model at one time, in its own space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// The shape of every instance (see [`Model::instances`]).
    pub shapes: Vec<Shape>,
    /// The map from every node's space to the model's.
    pub matrices: Vec<DAffine3>,
}

/// The shape of an instance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Points.
    pub points: Vec<[f32; 3]>,
    /// Unit normals, if the mesh has the point attribute `normal`. Morph targets do not bend them.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Velocities per second, if the mesh has the point attribute `velocity`: those at rest, turned and scaled.
    pub velocities: Option<Vec<[f32; 3]>>,
    /// Whether the placement mirrors, so that faces must be read backwards to keep their front.
    pub mirrored: bool,
}

impl Pose {
    /// The points of all instances, in the order of the points of [`Model::merged_mesh`].
    pub fn merged_points(&self) -> Vec<[f32; 3]> {
        self.shapes.iter().flat_map(|shape| &shape.points).copied().collect()
    }
}

impl Model {
    /// The animation that `name` means: its name, or its number counted from 0.
    ///
    /// # Errors
    /// Fails with `NotFound`, and the nearest name, if the model has no such animation.
    pub fn animation(&self, name: &str) -> Result<usize> {
        if let Some(index) = self.animations.iter().position(|animation| animation.name == name) {
            return Ok(index);
        }
        if let Some(index) = name.parse().ok().filter(|index| *index < self.animations.len()) {
            return Ok(index);
        }
        let error = Error::new(ErrorKind::NotFound, format!("there is no animation `{name}`"));
        let names = || self.animations.iter().map(|animation| animation.name.as_str());
        Err(match nearest(name, names()) {
            Some(near) => error.advise(format!("did you mean `{near}`?")),
            None if self.animations.is_empty() => error.advise("the file has no animations"),
            None => error.advise(format!("use one of {:?}", names().take(32).collect::<Vec<_>>())),
        })
    }

    /// The model without an animation.
    pub fn rest(&self, context: &Context) -> Pose {
        self.assemble(context, &Curves::at_rest(self))
    }

    /// The model at `time` seconds of an animation. Before its first and behind its last key it stands still.
    ///
    /// # Errors
    /// Fails with `NotFound` if there is no such animation, and with `Invalid` if the time is not finite.
    pub fn pose(&self, context: &Context, animation: usize, time: f64) -> Result<Pose> {
        let animation = self.animation_at(animation, time)?;
        let mut curves = Curves::at_rest(self);
        for channel in &animation.channels {
            curves.apply(channel, time);
        }
        for (node, operations) in &animation.transforms {
            if let Some(local) = curves.locals.get_mut(*node) {
                *local = Placement::Matrix(transform::map(operations, Some(time)));
            }
        }
        for keys in &animation.shapes {
            if let Some(shape) = curves.shapes.get_mut(keys.node) {
                *shape = between(keys, time);
            }
        }
        Ok(self.assemble(context, &curves))
    }

    /// Returns the weights of the morph targets of every node at `time` seconds of an animation.
    ///
    /// # Errors
    /// There is no such animation, or the time is not finite.
    pub fn morph_weights(&self, animation: usize, time: f64) -> Result<Vec<Vec<f64>>> {
        let animation = self.animation_at(animation, time)?;
        let mut curves = Curves::at_rest(self);
        let weights = animation.channels.iter().filter(|channel| channel.property == Property::Weights);
        weights.for_each(|channel| curves.apply(channel, time));
        Ok(curves.weights)
    }

    fn animation_at(&self, animation: usize, time: f64) -> Result<&Animation> {
        let found = self.animations.get(animation).ok_or_else(|| {
            Error::new(ErrorKind::NotFound, format!("there is no animation {animation}"))
                .advise(format!("the file has {} animations counted from 0", self.animations.len()))
        })?;
        if !time.is_finite() {
            return Err(Error::invalid(format!("the time {time} is not finite")).advise("use seconds"));
        }
        Ok(found)
    }

    /// One mesh of all instances at rest, in the model's space. Attributes are united by name, where one part lacks
    /// them with zeros (colours with white); `joints` and `weights` are left out, because poses have applied them.
    ///
    /// # Errors
    /// Fails with `Memory` above the memory limit, and with `Unsupported` at 2³² points or corners.
    pub fn merged_mesh(&self, context: &Context) -> Result<Mesh> {
        crate::merge::model(context, self, &self.rest(context))
    }

    /// As [`Model::merged_mesh`], without a copy where there is a single mesh that nothing places or deforms.
    ///
    /// # Errors
    /// Fails as [`Model::merged_mesh`] does.
    pub fn into_merged_mesh(mut self, context: &Context) -> Result<Mesh> {
        let plain = match (self.meshes.as_slice(), self.nodes.as_slice()) {
            ([part], [node]) => {
                let still = part.targets.is_empty() && node.local == Placement::IDENTITY;
                still && node.mesh.is_some() && part.mesh.attribute("joints").is_none()
            }
            _ => false,
        };
        if plain {
            return Ok(self.meshes.remove(0).mesh);
        }
        self.merged_mesh(context)
    }

    fn assemble(&self, context: &Context, curves: &Curves) -> Pose {
        let mut matrices: Vec<DAffine3> = Vec::with_capacity(self.nodes.len());
        for (node, local) in self.nodes.iter().zip(&curves.locals) {
            let above = node.parent.and_then(|parent| matrices.get(parent)).copied().unwrap_or_default();
            matrices.push(above * local.matrix());
        }
        let mut shapes = Vec::new();
        for (index, node) in self.nodes.iter().enumerate() {
            let Some(part) = node.mesh.and_then(|mesh| self.meshes.get(mesh)) else { continue };
            let points = match &curves.shapes[index] {
                Some(points) => points.clone(),
                None => morphed(context, part, &curves.weights[index]),
            };
            let maps = match node.skin.and_then(|skin| self.skins.get(skin)) {
                Some(skin) => Maps::Skin { joints: joint_matrices(skin, &matrices), influences: influences(part) },
                None => Maps::One(matrices[index]),
            };
            shapes.push(shape(context, part, points, &maps));
        }
        Pose { shapes, matrices }
    }
}

/// Placements, morph weights and points of all nodes at one time.
struct Curves {
    locals: Vec<Placement>,
    weights: Vec<Vec<f64>>,
    /// Points that replace those of the mesh.
    shapes: Vec<Option<Vec<[f32; 3]>>>,
}

impl Curves {
    fn at_rest(model: &Model) -> Self {
        let weights = |node: &Node| {
            let part = node.mesh.and_then(|mesh| model.meshes.get(mesh));
            let weights = node.weights.as_ref().or(part.map(|part| &part.weights));
            weights.map_or_else(Vec::new, |weights| weights.iter().copied().map(f64::from).collect())
        };
        Self {
            locals: model.nodes.iter().map(|node| node.local).collect(),
            weights: model.nodes.iter().map(weights).collect(),
            shapes: vec![None; model.nodes.len()],
        }
    }

    fn apply(&mut self, channel: &Channel, time: f64) {
        if channel.property == Property::Weights {
            if let Some(weights) = self.weights.get_mut(channel.node) {
                *weights = sample(channel, time);
            }
            return;
        }
        let Some(local) = self.locals.get_mut(channel.node) else { return };
        if let Placement::Matrix(matrix) = local {
            let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
            *local = Placement::Parts { translation, rotation, scale };
        }
        let Placement::Parts { translation, rotation, scale } = local else { return };
        match (channel.property, sample(channel, time).as_slice()) {
            (Property::Translation, [x, y, z]) => *translation = DVec3::new(*x, *y, *z),
            (Property::Scale, [x, y, z]) => *scale = DVec3::new(*x, *y, *z),
            (Property::Rotation, [x, y, z, w]) => *rotation = unit(DQuat::from_xyzw(*x, *y, *z, *w)),
            _ => {}
        }
    }
}

fn unit(rotation: DQuat) -> DQuat {
    let length = rotation.length();
    if length > 1e-12 { rotation * (1.0 / length) } else { DQuat::IDENTITY }
}

/// The value of a channel at `time`.
fn sample(channel: &Channel, time: f64) -> Vec<f64> {
    let keys = channel.times.len();
    if keys == 0 {
        return Vec::new();
    }
    let cubic = channel.interpolation == Interpolation::Cubic;
    let width = channel.values.len() / (keys * if cubic { 3 } else { 1 });
    // Numbers of key `key`: its in-tangent (0), value (1) and out-tangent (2) for cubic curves.
    let numbers = |key: usize, part: usize| {
        let start = if cubic { (3 * key + part) * width } else { key * width };
        channel.values[start..start + width].iter().copied().map(f64::from)
    };
    let after = channel.times.partition_point(|key| f64::from(*key) <= time);
    if after == 0 || after == keys {
        return numbers(after.saturating_sub(1), 1).collect();
    }
    let before = after - 1;
    let start = f64::from(channel.times[before]);
    let length = f64::from(channel.times[after]) - start;
    let t = (time - start) / length;
    match channel.interpolation {
        Interpolation::Step => numbers(before, 1).collect(),
        Interpolation::Linear if channel.property == Property::Rotation => {
            let quaternion = |key: usize| {
                let mut parts = [0.0; 4];
                numbers(key, 1).zip(&mut parts).for_each(|(number, part)| *part = number);
                unit(DQuat::from_array(parts))
            };
            quaternion(before).slerp(quaternion(after), t).to_array().to_vec()
        }
        Interpolation::Linear => numbers(before, 1).zip(numbers(after, 1)).map(|(a, b)| a + (b - a) * t).collect(),
        Interpolation::Cubic => {
            let (t2, t3) = (t * t, t * t * t);
            let values = numbers(before, 1).zip(numbers(before, 2)).zip(numbers(after, 0)).zip(numbers(after, 1));
            values
                .map(|(((a, leaving), arriving), b)| {
                    (2.0 * t3 - 3.0 * t2 + 1.0) * a
                        + length * (t3 - 2.0 * t2 + t) * leaving
                        + (3.0 * t2 - 2.0 * t3) * b
                        + length * (t3 - t2) * arriving
                })
                .collect()
        }
    }
}

/// The points of keys at `time` seconds.
fn between(keys: &ShapeKeys, time: f64) -> Option<Vec<[f32; 3]>> {
    let after = keys.times.partition_point(|key| *key <= time);
    let (a, b) = (after.saturating_sub(1), after.min(keys.times.len().saturating_sub(1)));
    let (from, to) = (keys.points.get(a)?, keys.points.get(b)?);
    let length = keys.times[b] - keys.times[a];
    let share = if length > 0.0 { (time - keys.times[a]) / length } else { 0.0 };
    if share == 0.0 {
        return Some(from.clone());
    }
    let blend = |from: f32, to: f32| (f64::from(from) + (f64::from(to) - f64::from(from)) * share) as f32;
    Some(from.iter().zip(to).map(|(from, to)| std::array::from_fn(|axis| blend(from[axis], to[axis]))).collect())
}

/// The points of a mesh with its morph targets added.
fn morphed(context: &Context, part: &Part, weights: &[f64]) -> Vec<[f32; 3]> {
    let mut points = part.mesh.points.clone();
    let active: Vec<_> = part.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0).collect();
    if !active.is_empty() {
        context.for_each_mut(&mut points, |index, point| {
            let mut sum = DVec3::from(point.map(f64::from));
            for (target, weight) in &active {
                let offset = target.get(index).copied().unwrap_or_default();
                sum += DVec3::from(offset.map(f64::from)) * **weight;
            }
            *point = sum.as_vec3().to_array();
        });
    }
    points
}

/// Joints and weights of every point.
struct Influences<'a> {
    joints: &'a [[u32; 4]],
    weights: &'a [[f32; 4]],
}

fn influences(part: &Part) -> Influences<'_> {
    let values = |name: &str| part.mesh.attribute(name).map(|attribute| &attribute.values);
    match (values("joints"), values("weights")) {
        (Some(Values::U32(joints)), Some(Values::F32(weights))) => {
            Influences { joints: joints.as_chunks().0, weights: weights.as_chunks().0 }
        }
        _ => Influences { joints: &[], weights: &[] },
    }
}

/// The map from the mesh's space at binding to the model's, by every joint.
fn joint_matrices(skin: &Skin, matrices: &[DAffine3]) -> Vec<DAffine3> {
    let joints = skin.joints.iter().zip(&skin.inverse_bind);
    joints.map(|(joint, inverse)| matrices.get(*joint).copied().unwrap_or_default() * *inverse).collect()
}

/// The map of every point.
enum Maps<'a> {
    One(DAffine3),
    Skin { joints: Vec<DAffine3>, influences: Influences<'a> },
}

impl Maps<'_> {
    fn of(&self, point: usize) -> DAffine3 {
        match self {
            Self::One(matrix) => *matrix,
            Self::Skin { joints, influences } => {
                let (Some(used), Some(weights)) = (influences.joints.get(point), influences.weights.get(point)) else {
                    return DAffine3::IDENTITY;
                };
                let mut linear = DMat3::ZERO;
                let mut translation = DVec3::ZERO;
                for (joint, weight) in used.iter().zip(weights).filter(|(_, weight)| **weight > 0.0) {
                    let matrix = joints.get(*joint as usize).copied().unwrap_or_default();
                    linear += matrix.matrix3 * f64::from(*weight);
                    translation += matrix.translation * f64::from(*weight);
                }
                DAffine3::from_mat3_translation(linear, translation)
            }
        }
    }

    /// Whether most of it mirrors.
    fn mirrors(&self) -> bool {
        match self {
            Self::One(matrix) => matrix.matrix3.determinant() < 0.0,
            Self::Skin { joints, .. } => {
                2 * joints.iter().filter(|matrix| matrix.matrix3.determinant() < 0.0).count() > joints.len()
            }
        }
    }
}

/// The shape of morphed points under their maps.
fn shape(context: &Context, part: &Part, mut points: Vec<[f32; 3]>, maps: &Maps) -> Shape {
    let mirrored = maps.mirrors();
    let vectors = |name: &str| -> Option<Vec<[f32; 3]>> {
        let found = part.mesh.attribute(name).filter(|found| found.domain == Domain::Point && found.width == 3)?;
        match &found.values {
            Values::F32(values) => Some(values.as_chunks().0.to_vec()),
            Values::U32(_) => None,
        }
    };
    let (mut normals, mut velocities) = (vectors("normal"), vectors("velocity"));
    if matches!(maps, Maps::One(matrix) if *matrix == DAffine3::IDENTITY) {
        return Shape { points, normals, velocities, mirrored };
    }
    if let Some(velocities) = &mut velocities {
        context.for_each_mut(velocities, |index, velocity| {
            let velocity3 = maps.of(index).transform_vector3(DVec3::from(velocity.map(f64::from)));
            *velocity = velocity3.as_vec3().to_array();
        });
    }
    context.for_each_mut(&mut points, |index, point| {
        *point = maps.of(index).transform_point3(DVec3::from(point.map(f64::from))).as_vec3().to_array();
    });
    if let Some(normals) = &mut normals {
        context.for_each_mut(normals, |index, normal| {
            let DMat3 { x_axis: x, y_axis: y, z_axis: z } = maps.of(index).matrix3;
            // The inverse transpose up to scale, which exists where the inverse does not.
            let bent = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * DVec3::from(normal.map(f64::from));
            let turned = if x.dot(y.cross(z)) < 0.0 { -bent } else { bent };
            *normal = turned.normalize_or_zero().as_vec3().to_array();
        });
    }
    Shape { points, normals, velocities, mirrored }
}
