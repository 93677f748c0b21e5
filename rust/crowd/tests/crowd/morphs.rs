//! Morph targets that clips move.

use glam::Vec3;
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_crowd::{Blend, BuildSettings, CrowdModel, skin};
use relievo_meshio::Property;

use crate::arm::swelling_arm;
use crate::errors::check;

fn settings() -> BuildSettings {
    BuildSettings { cluster_triangles: 40, pose_rate: 8.0, ..BuildSettings::default() }
}

#[test]
fn poses_are_those_of_the_file_and_errors_hold_in_them() {
    let (context, source) = (Context::serial(), swelling_arm(30, 16));
    let model = CrowdModel::build(&context, &source, &[0], &settings(), &mut Silent).unwrap();
    assert_eq!(model.character.morphs.count, 1);
    let mut widest = 0.0f32;
    for (frame, pose) in model.clips[0].poses.iter().enumerate() {
        let ours = skin(&context, &model.character, pose, Blend::Linear).unwrap();
        let theirs = source.pose(&context, 0, frame as f64 / 8.0).unwrap();
        for (ours, theirs) in ours.iter().zip(&theirs.shapes[0].points) {
            assert!(Vec3::from(*ours).distance(Vec3::from(*theirs)) < 1e-5, "pose {frame}: {ours:?}, {theirs:?}");
            widest = widest.max(ours[2]);
        }
    }
    // The arm is 0.32 wide at rest and swells by half as much again where a pose is next to the key.
    assert!(widest > 0.6, "{widest}");
    check(&model, [0.02, 0.04, 0.08], 0.2);
}

#[test]
fn a_clip_that_moves_only_morph_targets_has_several_representative_poses() {
    let mut source = swelling_arm(20, 12);
    source.animations[0].channels.retain(|channel| channel.property == Property::Weights);
    // The target moves vertices by 0.45, 0.14 diagonals.
    let near = BuildSettings { pose_distance: 0.05, ..settings() };
    let model = CrowdModel::build(&Context::serial(), &source, &[0], &near, &mut Silent).unwrap();
    assert!(model.report.representatives > 1, "{:?}", model.report);
    check(&model, [0.02, 0.04, 0.08], 0.2);
    // Without the clip nothing moves, and the target is at its weight at rest.
    source.meshes[0].weights = vec![0.5];
    source.animations.clear();
    let still = CrowdModel::build(&Context::serial(), &source, &[], &settings(), &mut Silent).unwrap();
    assert_eq!((still.character.morphs.count, still.clips[0].poses[0].weights.len()), (0, 0));
    let at_rest = &source.rest(&Context::serial()).shapes[0].points;
    assert_eq!(&still.character.points, at_rest);
}

#[test]
fn files_keep_morph_targets() {
    let model = CrowdModel::build(&Context::serial(), &swelling_arm(8, 8), &[0], &settings(), &mut Silent).unwrap();
    let mut bytes = Vec::new();
    model.write(&mut bytes).unwrap();
    assert_eq!(bytes[8], 4);
    assert_eq!(CrowdModel::from_bytes(&bytes, u64::MAX).unwrap(), model);
    for length in 0..bytes.len() {
        assert!(CrowdModel::from_bytes(&bytes[..length], 1 << 30).is_err(), "cut at {length}");
    }
    // Weights that do not fit are refused.
    let mut wrong = model.clone();
    wrong.clips[0].poses[1].weights.push(1.0);
    assert!(wrong.check().is_err());
    assert!(skin(&Context::serial(), &model.character, &wrong.clips[0].poses[1], Blend::Linear).is_err());
    let mut wrong = model;
    wrong.character.morphs.offsets[0].morph = 1;
    assert!(wrong.check().is_err());
}
