//! Errors hold in every pose of the clips; poses are chosen as the paper does; results do not depend on threads.

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, ErrorKind};
use relievo_crowd::{Blend, BuildSettings, Cluster, CrowdModel, NONE, Pose, Variant, skin};
use relievo_lod::distance;

use crate::arm::{arm, built, twisting_arm, walking, wrung};

/// Returns the distance of a cut from the input, both ways, in every pose.
fn deviations(model: &CrowdModel, cut: &[u32], blend: Blend) -> Vec<f32> {
    let context = Context::serial();
    let triangles = |clusters: &[u32]| -> Vec<[u32; 3]> {
        clusters.iter().flat_map(|cluster| model.triangles(*cluster)).copied().collect()
    };
    let (input, coarse) = (triangles(&model.input_clusters()), triangles(cut));
    assert!(coarse.len() < input.len());
    let deviation = |pose: &Pose| {
        let points = skin(&context, &model.character, pose, blend).unwrap();
        distance(&context, [(&points, &input), (&points, &coarse)], &mut Silent).unwrap().at_least
    };
    model.clips[0].poses.iter().map(deviation).collect()
}

/// Checks that the surface of some cuts is within their error of the input's in every pose, and comes within a share of it.
pub fn check(model: &CrowdModel, shares: [f32; 3], near: f32) {
    let context = Context::serial();
    let mut coarsest = 0.0f32;
    for share in shares {
        let allowed = share * model.size();
        let deviations = deviations(model, &model.cut(allowed), model.blend);
        for (frame, (pose, found)) in model.clips[0].poses.iter().zip(deviations).enumerate() {
            let points = skin(&context, &model.character, pose, model.blend).unwrap();
            assert!(found <= allowed * (1.0 + 1e-4) + 1e-5 * model.size(), "pose {frame}: {found:?}, {allowed}");
            coarsest = coarsest.max(found / allowed);
            let inside = points.iter().flatten().enumerate().all(|(at, value)| {
                let axis = at % 3;
                model.low[axis] <= *value && *value <= model.high[axis]
            });
            assert!(inside, "pose {frame} leaves the box");
        }
    }
    // The bound is of use: some cut comes near it.
    assert!(coarsest > near, "{coarsest}");
}

#[test]
fn cuts_are_within_their_error_in_every_pose() {
    let model = built(40, 20);
    check(&model, [0.02, 0.05, 0.1], 0.2);
    assert_eq!(model.report.measured, (model.groups.len() * model.clips[0].poses.len()) as u64);
    assert!(model.report.exceeded < model.report.measured / 2, "{:?}", model.report);
    if let Some((_, model)) = walking("girl", "RunTrack") {
        check(&model, [0.06, 0.12, 0.2], 0.2);
    }
}

/// Checks that the vertices of all clusters are in the boxes of their groups in every pose.
fn check_boxes(model: &CrowdModel) {
    for pose in &model.clips[0].poses {
        let points = skin(&Context::serial(), &model.character, pose, model.blend).unwrap();
        for (cluster, number) in model.clusters.iter().zip(0..).filter(|(cluster, _)| cluster.used_by != NONE) {
            let group = &model.groups[cluster.used_by as usize];
            for vertex in model.triangles(number).as_flattened() {
                let point = points[*vertex as usize];
                let is_in = (0..3).all(|axis| group.low[axis] <= point[axis] && point[axis] <= group.high[axis]);
                assert!(is_in, "cluster {number} leaves its box");
            }
        }
    }
}

#[test]
fn cuts_are_within_their_error_by_dual_quaternions() {
    let model = wrung(40, 20);
    model.check().unwrap();
    check(&model, [0.02, 0.05, 0.1], 0.1);
    check_boxes(&model);
    // The arm is so wrung that the errors and the boxes of blended matrices do not hold.
    let context = Context::serial();
    let settings =
        BuildSettings { cluster_triangles: 40, group_clusters: 4, pose_rate: 12.0, ..BuildSettings::default() };
    let linear = CrowdModel::build(&context, &twisting_arm(40, 20), &[0], &settings, &mut Silent).unwrap();
    let exceeds = |share: f32| {
        let allowed = share * linear.size();
        let found = deviations(&linear, &linear.cut(allowed), Blend::DualQuaternion).into_iter().fold(0.0, f32::max);
        println!("{found} of {allowed}");
        found > allowed
    };
    assert!([0.01, 0.02, 0.05, 0.1].into_iter().any(exceeds));
    assert!(
        linear.groups.iter().zip(&model.groups).any(|(a, b)| b.error > a.error + 0.01 && b.low[0] < a.low[0] - 0.01)
    );
    // Those of dual quaternions hold for matrices too.
    check(&model.with_blend(&context, Blend::Linear).unwrap(), [0.02, 0.05, 0.1], 0.1);
    if let Some((_, model)) = walking("girl", "RunTrack") {
        let dual = model.with_blend(&context, Blend::DualQuaternion).unwrap();
        check(&dual, [0.06, 0.12, 0.2], 0.1);
        check_boxes(&dual);
        let triangles = |model: &CrowdModel| model.triangle_count(&model.cut(0.06 * model.size()));
        println!("{} triangles, {} by dual quaternions", triangles(&model), triangles(&dual));
        assert!(triangles(&dual) < 2 * triangles(&model));
    }
}

#[test]
fn blends_report_progress_and_stop() {
    let (context, model) = (Context::serial(), built(8, 8));
    let mut fractions = Vec::new();
    let mut watch = |fraction: f32, stage: &str| {
        assert_eq!(stage, "measure");
        fractions.push(fraction);
        true
    };
    let dual = model.with_blend_watched(&context, Blend::DualQuaternion, &mut watch).unwrap();
    assert_eq!(dual, model.with_blend(&context, Blend::DualQuaternion).unwrap());
    assert!(fractions.len() > 2 && fractions.is_sorted() && fractions[0] == 0.0 && fractions.last() == Some(&1.0));
    let mut patience = 2;
    let mut stop = |_: f32, _: &str| {
        patience -= 1;
        patience > 0
    };
    let stopped = model.with_blend_watched(&context, Blend::DualQuaternion, &mut stop);
    assert_eq!(stopped.unwrap_err().kind, ErrorKind::Cancelled);
}

#[test]
fn errors_boxes_and_depths_grow_upwards() {
    let model = built(40, 20);
    model.check().unwrap();
    assert!(model.groups.iter().any(|group| group.depth >= 4));
    let roots: Vec<_> = model.clusters.iter().filter(|cluster| cluster.used_by == relievo_crowd::NONE).collect();
    assert_eq!(roots.len(), 1, "{roots:?}");
    assert!(model.clusters.iter().all(|cluster| cluster.count <= 40));
}

#[test]
fn a_walk_of_35_poses_has_about_eight_representative_ones() {
    let Some(path) = relievo_testing::file("characters/robot.glb") else { return };
    let context = Context::new(&ContextOptions::default()).unwrap();
    let source = relievo_meshio::read_model(&context, &path).unwrap();
    let walk = source.animation("Robot_Walking").unwrap();
    let (start, end) = source.animations[walk].range();
    let rate = (35.0 / (end - start)) as f32;
    let report = |pose_distance: f32| {
        // Large clusters make few groups to measure.
        let settings =
            BuildSettings { pose_rate: rate, pose_distance, cluster_triangles: 4096, ..BuildSettings::default() };
        CrowdModel::build(&context, &source, &[walk], &settings, &mut Silent).unwrap().report
    };
    let usual = report(BuildSettings::default().pose_distance);
    assert_eq!(usual.poses, 35);
    assert!((5..=13).contains(&usual.representatives), "{usual:?}");
    assert_eq!(report(10.0).representatives, 1);
}

#[test]
fn distances_of_groups_are_those_of_single_measurements() {
    let context = Context::serial();
    let settings = BuildSettings { cluster_triangles: 30, pose_rate: 6.0, ..BuildSettings::default() };
    let variant = Variant { clusters: None, is_whole: false };
    let model = CrowdModel::build_variant(&context, (&arm(30, 16), &[0]), &variant, &settings, &mut Silent).unwrap();
    let poses = model.clips[0].poses.iter().map(|pose| skin(&context, &model.character, pose, Blend::Linear).unwrap());
    let poses: Vec<_> = poses.collect();
    for (group, distances) in (0..).zip(&model.distances) {
        let of = |is_own: &dyn Fn(&Cluster) -> bool| -> Vec<[u32; 3]> {
            let own = model.clusters.iter().zip(0..).filter(|(cluster, _)| is_own(cluster));
            own.flat_map(|(_, number)| model.triangles(number)).copied().collect()
        };
        let (before, after) = (of(&|it| it.used_by == group), of(&|it| it.made_by == group));
        let single = |points: &Vec<[f32; 3]>| {
            distance(&context, [(points, &before), (points, &after)], &mut Silent).unwrap().at_most
        };
        let most = poses.iter().map(single).fold(0.0, f32::max);
        let tolerance = 0.011 * most + 1e-5 * model.size();
        assert!((distances.all - most).abs() <= tolerance, "group {group}: {distances:?}, {most}");
        assert!(model.groups[group as usize].error >= distances.all);
    }
}

#[test]
fn builds_do_not_depend_on_threads() {
    let bytes = |threads: usize| {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let settings = BuildSettings { cluster_triangles: 30, pose_rate: 6.0, ..BuildSettings::default() };
        let mut out = Vec::new();
        let model = CrowdModel::build(&context, &arm(30, 16), &[0], &settings, &mut Silent).unwrap();
        model.write(&mut out).unwrap();
        out
    };
    let one = bytes(1);
    assert_eq!(one, bytes(2));
    assert_eq!(one, bytes(5));
}
