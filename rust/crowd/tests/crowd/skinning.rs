//! Skinning, held against an evaluation of glTF files that shares no code with the library, and closed forms.

use glam::{DMat4, DQuat, DVec3, DVec4};
use gltf::animation::util::ReadOutputs;
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_crowd::{Blend, BuildSettings, Character, CrowdModel, Pose, dual_rows, skin, skin_some};

use crate::arm::{arm, character};

/// Returns the value of a curve of keys at a time, between keys by `mix`.
fn sampled<T: Copy>(times: &[f32], values: &[T], time: f64, mix: impl Fn(T, T, f64) -> T) -> T {
    let after = times.iter().position(|key| f64::from(*key) > time);
    match after {
        None => values[values.len() - 1],
        Some(0) => values[0],
        Some(after) => {
            let (from, to) = (f64::from(times[after - 1]), f64::from(times[after]));
            mix(values[after - 1], values[after], (time - from) / (to - from))
        }
    }
}

/// Returns the places of all vertices of a glTF file at a time of an animation, by the formulas of its specification.
pub fn evaluated(bytes: &[u8], animation: usize, time: f64) -> Vec<DVec3> {
    let file = gltf::Gltf::from_slice(bytes).unwrap();
    let blob = file.blob.clone().unwrap();
    let count = file.nodes().count();
    let mut parts: Vec<(DVec3, DQuat, DVec3)> = vec![(DVec3::ZERO, DQuat::IDENTITY, DVec3::ONE); count];
    for node in file.nodes() {
        let (translation, rotation, scale) = node.transform().decomposed();
        let [x, y, z, w] = rotation.map(f64::from);
        let vector = |values: [f32; 3]| DVec3::from(values.map(f64::from));
        parts[node.index()] = (vector(translation), DQuat::from_xyzw(x, y, z, w), vector(scale));
    }
    for channel in file.animations().nth(animation).unwrap().channels() {
        assert_eq!(channel.sampler().interpolation(), gltf::animation::Interpolation::Linear);
        let reader = channel.reader(|_| Some(&blob));
        let times: Vec<f32> = reader.read_inputs().unwrap().collect();
        let part = &mut parts[channel.target().node().index()];
        let lerp = |a: [f32; 3], b: [f32; 3], t: f64| {
            std::array::from_fn(|axis| (f64::from(a[axis]) * (1.0 - t) + f64::from(b[axis]) * t) as f32)
        };
        match reader.read_outputs().unwrap() {
            ReadOutputs::Translations(values) => {
                let values: Vec<[f32; 3]> = values.collect();
                part.0 = DVec3::from(sampled(&times, &values, time, lerp).map(f64::from));
            }
            ReadOutputs::Scales(values) => {
                let values: Vec<[f32; 3]> = values.collect();
                part.2 = DVec3::from(sampled(&times, &values, time, lerp).map(f64::from));
            }
            ReadOutputs::Rotations(values) => {
                let values: Vec<DVec4> =
                    values.into_f32().map(|value| DVec4::from(value.map(f64::from)).normalize()).collect();
                let slerp = |a: DVec4, b: DVec4, t: f64| {
                    let b = if a.dot(b) < 0.0 { -b } else { b };
                    let angle = a.dot(b).min(1.0).acos();
                    if angle < 1e-6 {
                        return (a * (1.0 - t) + b * t).normalize();
                    }
                    (a * ((1.0 - t) * angle).sin() + b * (t * angle).sin()) / angle.sin()
                };
                part.1 = DQuat::from_vec4(sampled(&times, &values, time, slerp));
            }
            ReadOutputs::MorphTargetWeights(_) => {}
        }
    }
    let mut parents = vec![None; count];
    for node in file.nodes() {
        node.children().for_each(|child| parents[child.index()] = Some(node.index()));
    }
    let world = |mut node: usize| {
        let local = |node: usize| {
            let (translation, rotation, scale) = parts[node];
            DMat4::from_translation(translation) * DMat4::from_quat(rotation) * DMat4::from_scale(scale)
        };
        let mut matrix = local(node);
        while let Some(parent) = parents[node] {
            matrix = local(parent) * matrix;
            node = parent;
        }
        matrix
    };
    // Level by level from the roots, as the reader lists nodes.
    let mut order: Vec<usize> = (0..count).filter(|node| parents[*node].is_none()).collect();
    let mut at = 0;
    while at < order.len() {
        let node = file.nodes().nth(order[at]).unwrap();
        order.extend(node.children().map(|child| child.index()));
        at += 1;
    }
    let mut places = Vec::new();
    for index in order {
        let node = file.nodes().nth(index).unwrap();
        let (Some(mesh), Some(skin)) = (node.mesh(), node.skin()) else { continue };
        let inverse: Vec<DMat4> = skin
            .reader(|_| Some(&blob))
            .read_inverse_bind_matrices()
            .unwrap()
            .map(|matrix| {
                DMat4::from_cols_array(
                    &matrix.as_flattened().iter().map(|v| f64::from(*v)).collect::<Vec<_>>().try_into().unwrap(),
                )
            })
            .collect();
        let palette: Vec<DMat4> =
            skin.joints().zip(&inverse).map(|(joint, inverse)| world(joint.index()) * *inverse).collect();
        for primitive in mesh.primitives() {
            let reader = primitive.reader(|_| Some(&blob));
            let joints = reader.read_joints(0).unwrap().into_u16();
            let weights = reader.read_weights(0).unwrap().into_f32();
            for ((point, joints), weights) in reader.read_positions().unwrap().zip(joints).zip(weights) {
                let point = DVec3::from(point.map(f64::from)).extend(1.0);
                let sum: f64 = weights.iter().map(|weight| f64::from(*weight)).sum();
                let parts = joints.iter().zip(weights);
                let blended: DVec4 =
                    parts.map(|(joint, weight)| palette[usize::from(*joint)] * point * (f64::from(weight) / sum)).sum();
                places.push(blended.truncate());
            }
        }
    }
    places
}

#[test]
fn linear_skinning_is_that_of_the_specification() {
    for (name, clips) in [("girl", 2), ("greenman", 4), ("rigged_figure", 1), ("robot", 4)] {
        let (Some(path), Some(source)) = (relievo_testing::file(&format!("characters/{name}.glb")), character(name))
        else {
            continue;
        };
        let bytes = std::fs::read(path).unwrap();
        for clip in 0..clips {
            // Poses alone, without a hierarchy worth its name.
            let settings = BuildSettings { cluster_triangles: 4096, pose_rate: 3.0, ..BuildSettings::default() };
            let model = CrowdModel::build(&Context::serial(), &source, &[clip], &settings, &mut Silent).unwrap();
            let start = source.animations[clip].range().0;
            for (frame, pose) in model.clips[0].poses.iter().enumerate() {
                let ours = skin(&Context::serial(), &model.character, pose, Blend::Linear).unwrap();
                let theirs = evaluated(&bytes, clip, start + frame as f64 / 3.0);
                assert_eq!(ours.len(), theirs.len());
                let size = f64::from(model.size());
                for (ours, theirs) in ours.iter().zip(theirs) {
                    let off = DVec3::from(ours.map(f64::from)).distance(theirs);
                    assert!(off <= 1e-5 * size, "{name}, clip {clip}, pose {frame}: {off}");
                }
            }
        }
    }
}

/// Returns the map that turns by `angle` about the y axis and scales by `scale`, as a bone.
fn turned(angle: f32, scale: f32) -> [[f32; 4]; 3] {
    let (sin, cos) = angle.sin_cos();
    [[scale * cos, 0.0, scale * sin, 0.0], [0.0, scale, 0.0, 0.5], [-scale * sin, 0.0, scale * cos, 0.0]]
}

#[test]
fn dual_rows_are_the_map_of_their_bone() {
    let sheared = [[1.5, 0.2, -0.3, 4.0], [0.1, 0.7, 0.4, -2.0], [0.0, -0.6, 1.1, 0.5]];
    let mirrored = [[-1.0, 0.0, 0.0, 1.0], [0.0, 0.8, -0.6, 0.0], [0.0, 0.6, 0.8, 2.0]];
    for bone in [turned(0.0, 1.0), turned(2.4, 1.5), turned(-3.1, 0.01), sheared, mirrored] {
        let rows = dual_rows(&bone).map(|row| row.map(f64::from));
        let [real, dual] = [rows[3], rows[4]].map(DQuat::from_array);
        assert!((real.length() - 1.0).abs() < 1e-6 && real.dot(dual).abs() < 1e-6);
        for place in [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z] {
            let stretched = DVec3::from_array(std::array::from_fn(|row| place.extend(0.0).dot(DVec4::from(rows[row]))));
            let moved = real * stretched + 2.0 * (dual * real.conjugate()).xyz();
            let expected = std::array::from_fn(|row| place.extend(1.0).dot(DVec4::from(bone[row].map(f64::from))));
            assert!(moved.distance(DVec3::from_array(expected)) < 1e-5, "{bone:?}: {moved}");
        }
        // The stretch is symmetric, and so no part of it turns.
        assert!((rows[0][1] - rows[1][0]).abs() < 1e-6 && (rows[1][2] - rows[2][1]).abs() < 1e-6);
    }
}

#[test]
fn dual_quaternions_keep_the_volume_of_a_twist_and_agree_where_one_bone_rules() {
    let context = Context::serial();
    let character = Character::from_model(&context, &arm(40, 16)).unwrap();
    let (angle, scale) = (2.4f32, 1.5f32);
    let pose =
        Pose { bones: vec![turned(0.0, scale), turned(angle, scale), turned(angle, scale)], weights: Vec::new() };
    let linear = skin(&context, &character, &pose, Blend::Linear).unwrap();
    let dual = skin(&context, &character, &pose, Blend::DualQuaternion).unwrap();
    let mut blends = 0;
    for (index, influence) in character.influences.iter().enumerate() {
        let [a, b] = [influence.weights[0], influence.weights[1]];
        let point = character.points[index];
        let radius = |point: [f32; 3]| point[0].hypot(point[2]);
        assert!((radius(dual[index]) - scale * radius(point)).abs() < 1e-5, "{point:?}");
        assert!((dual[index][1] - (scale * point[1] + 0.5)).abs() < 1e-5);
        let is_first = influence.bones[0] == 0;
        if a == 0.0 || b == 0.0 {
            assert!((0..3).all(|axis| (dual[index][axis] - linear[index][axis]).abs() < 1e-5));
        } else if is_first && (a - 0.5).abs() < 0.2 {
            // The chord of the blended turn is shorter than its radius.
            assert!(radius(linear[index]) < 0.6 * radius(dual[index]) || radius(point) < 0.1);
            blends += 1;
        }
    }
    assert!(blends > 16);
}

#[test]
fn some_vertices_are_where_all_have_them() {
    let context = Context::serial();
    let model = CrowdModel::build(&context, &arm(9, 8), &[0], &BuildSettings::default(), &mut Silent).unwrap();
    let pose = &model.clips[0].poses[7];
    let vertices = [40, 3, 3, 71];
    for blend in [Blend::Linear, Blend::DualQuaternion] {
        let all = skin(&context, &model.character, pose, blend).unwrap();
        let some = skin_some(&context, &model.character, pose, blend, &vertices).unwrap();
        assert_eq!(some, vertices.map(|vertex| all[vertex as usize]));
        let error = skin_some(&context, &model.character, pose, blend, &[all.len() as u32]).unwrap_err();
        assert!(error.to_string().contains("does not exist"), "{error}");
    }
}
