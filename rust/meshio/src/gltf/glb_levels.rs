//! Writes binary glTF 2.0 of one model at several levels of detail, by the extension MSFT_lod: skinned, with clips, if it has
//! joints.
//!
//! The scene shows the finest level; its node names those of the coarser ones, and the coverage of the screen down to
//! which each is shown. Readers that do not know the extension show the finest level.

use std::path::Path;

use glam::{DAffine3, DMat4, DQuat, DVec3};
use relievo_core::{Error, Mesh, Result};
use serde_json::{Value, json};

use crate::gltf::glb_writer::{FLOAT, Instance, Writer, store};

/// Relative difference between a map and its scale, rotation and translation from which it counts as sheared.
const SHEAR: f64 = 1e-3;

/// A joint of a skin. Joints are not below one another: each has its place in the space of the model.
#[derive(Clone, Copy, Debug)]
pub struct Joint<'a> {
    /// Name of its node.
    pub name: &'a str,
    /// The map from the vertices at binding to the joint.
    pub inverse_bind: DAffine3,
}

/// A clip: the place of every joint at some times.
#[derive(Clone, Debug)]
pub struct JointClip<'a> {
    /// Name of the animation.
    pub name: &'a str,
    /// Seconds, increasing.
    pub times: Vec<f32>,
    /// For each time the maps from all joints to the model.
    pub places: Vec<Vec<DAffine3>>,
}

/// A model at several levels of detail.
#[derive(Clone, Copy, Debug)]
pub struct Levels<'a> {
    /// Name of the model.
    pub name: &'a str,
    /// Meshes, the finest first. With joints they have the point attributes `joints` and `weights`.
    pub meshes: &'a [Mesh],
    /// Down to which share of the screen's area each mesh is shown, by the disc of the bounding sphere: 0 to 1.
    pub coverages: &'a [f64],
    /// Names of the slots of the face attribute `material`.
    pub materials: &'a [String],
    /// Joints; none for a model that does not move.
    pub joints: &'a [Joint<'a>],
    /// Clips of the joints.
    pub clips: &'a [JointClip<'a>],
}

/// Writes levels of detail as GLB. Returns how many joints are sheared in some clip, which glTF cannot say: they get the
/// nearest scale and rotation.
///
/// # Errors
/// A mesh cannot be used, no mesh is given, lists differ in length, a number is not finite, the file would be larger
/// than the format's 4 GiB, or the system refuses. No file is left then.
pub fn write_glb_levels(path: &Path, levels: &Levels) -> Result<u32> {
    let named = |error: Error| error.at(path.display().to_string());
    levels.check().map_err(named)?;
    let mut writer = Writer::default();
    let is_skinned = !levels.joints.is_empty();
    for (level, mesh) in levels.meshes.iter().enumerate() {
        let name = format!("{}_{level}", levels.name);
        let instance = Instance { materials: levels.materials, ..Instance::new(&name, mesh) };
        let mesh = writer.mesh(&instance, is_skinned).map_err(|error| named(error.at(format!("level {level}"))))?;
        let mut node = json!({ "name": name, "mesh": mesh });
        if is_skinned {
            node["skin"] = json!(0);
        }
        writer.nodes.push(node);
    }
    let count = levels.meshes.len();
    if count > 1 {
        writer.nodes[0]["extensions"] = json!({ "MSFT_lod": { "ids": (1..count).collect::<Vec<_>>() } });
        writer.nodes[0]["extras"] = json!({ "MSFT_screencoverage": levels.coverages });
    }
    let mut roots = vec![0];
    let (skin, animations, sheared) = joints(&mut writer, levels);
    roots.extend(count..writer.nodes.len());
    let (mut json, buffer) = writer.finish();
    json["scenes"] = json!([{ "nodes": roots }]);
    if count > 1 {
        json["extensionsUsed"] = json!(["MSFT_lod"]);
    }
    if let Some(skin) = skin {
        json["skins"] = json!([skin]);
    }
    if !animations.is_empty() {
        json["animations"] = json!(animations);
    }
    store(path, &json, &buffer)?;
    Ok(sheared)
}

impl Levels<'_> {
    fn check(&self) -> Result<()> {
        if self.meshes.is_empty() || self.coverages.len() != self.meshes.len() {
            return Err(Error::invalid("there is no mesh to write, or not one coverage for each"));
        }
        let is_joint = |map: &DAffine3| map.is_finite();
        let fits = |clip: &JointClip| {
            !clip.times.is_empty()
                && clip.times.len() == clip.places.len()
                && clip.times.is_sorted_by(|a, b| a < b)
                && clip.places.iter().all(|places| places.len() == self.joints.len() && places.iter().all(is_joint))
        };
        if !self.joints.iter().all(|joint| is_joint(&joint.inverse_bind)) || !self.clips.iter().all(fits) {
            return Err(Error::invalid("a clip does not fit the joints, or is not finite"));
        }
        Ok(())
    }
}

/// Adds the nodes of all joints, and the accessors of the skin and the clips. Returns the skin, the animations, and how many
/// joints are sheared.
fn joints(writer: &mut Writer, levels: &Levels) -> (Option<Value>, Vec<Value>, u32) {
    if levels.joints.is_empty() {
        return (None, Vec::new(), 0);
    }
    let first = writer.nodes.len();
    let start = levels.clips.first().map(|clip| &clip.places[0]);
    let mut is_sheared = vec![false; levels.joints.len()];
    for (index, joint) in levels.joints.iter().enumerate() {
        let place = start.map_or_else(|| joint.inverse_bind.inverse(), |places| places[index]);
        let (scale, rotation, translation) = parts(&place).0;
        writer.nodes.push(json!({
            "name": joint.name,
            "translation": translation.to_array(), "rotation": rotation.to_array(), "scale": scale.to_array(),
        }));
    }
    let bind = |joint: &Joint| DMat4::from(joint.inverse_bind).to_cols_array().map(|value| value as f32);
    let binds: Vec<f32> = levels.joints.iter().flat_map(bind).collect();
    let binds = accessor(writer, &binds, 16, "MAT4");
    let nodes: Vec<usize> = (first..first + levels.joints.len()).collect();
    let skin = json!({ "inverseBindMatrices": binds, "joints": nodes });
    let mut animations = Vec::new();
    for clip in levels.clips {
        let times = accessor(writer, &clip.times, 1, "SCALAR");
        (writer.accessors[times]["min"], writer.accessors[times]["max"]) =
            (json!([clip.times[0]]), json!([clip.times[clip.times.len() - 1]]));
        let (mut samplers, mut channels) = (Vec::new(), Vec::new());
        for (joint, node) in nodes.iter().enumerate() {
            let (mut scales, mut rotations, mut translations) = (Vec::new(), Vec::new(), Vec::new());
            let mut before = DQuat::IDENTITY;
            for places in &clip.places {
                let ((scale, rotation, translation), shear) = parts(&places[joint]);
                is_sheared[joint] |= shear;
                // Both signs are one rotation; readers go the way that the signs say.
                before = if before.dot(rotation) < 0.0 { -rotation } else { rotation };
                scales.extend(scale.to_array().map(|value| value as f32));
                rotations.extend(before.to_array().map(|value| value as f32));
                translations.extend(translation.to_array().map(|value| value as f32));
            }
            let curves = [
                ("scale", scales, 3, "VEC3"),
                ("rotation", rotations, 4, "VEC4"),
                ("translation", translations, 3, "VEC3"),
            ];
            for (path, values, width, kind) in curves {
                let output = accessor(writer, &values, width, kind);
                channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
                samplers.push(json!({ "input": times, "output": output, "interpolation": "LINEAR" }));
            }
        }
        animations.push(json!({ "name": clip.name, "samplers": samplers, "channels": channels }));
    }
    (Some(skin), animations, is_sheared.iter().filter(|is_sheared| **is_sheared).count() as u32)
}

/// Adds an array of floats that is no vertex attribute, and returns its accessor.
fn accessor(writer: &mut Writer, values: &[f32], width: usize, kind: &str) -> usize {
    let view = writer.view(bytemuck::cast_slice(values), None);
    writer.accessors.push(json!({
        "bufferView": view, "componentType": FLOAT, "count": values.len() / width, "type": kind,
    }));
    writer.accessors.len() - 1
}

/// Returns scale, rotation and translation of a map, and whether it is sheared.
fn parts(map: &DAffine3) -> ((DVec3, DQuat, DVec3), bool) {
    let (scale, rotation, translation) = map.to_scale_rotation_translation();
    if !(scale.is_finite() && rotation.is_finite()) {
        return ((DVec3::ZERO, DQuat::IDENTITY, map.translation), map.matrix3 != glam::DMat3::ZERO);
    }
    let rotation = rotation.normalize();
    let again = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
    let size = map.matrix3.to_cols_array().iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let is_sheared = !again.matrix3.abs_diff_eq(map.matrix3, SHEAR * size);
    ((scale, rotation, translation), is_sheared)
}
