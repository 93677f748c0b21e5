//! Agents that share poses stay within the error that a view allows.

use std::collections::HashSet;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_crowd::{Agent, Blend, BuildSettings, Crowd, CrowdModel, CrowdView, Drawn, Frame, skin};

use crate::arm::{arm, swelling_arm};

#[test]
fn shared_poses_and_coarse_clusters_together_hold_the_budget_of_pixels() {
    let context = Context::serial();
    let settings = BuildSettings { cluster_triangles: 20, pose_rate: 60.0, ..BuildSettings::default() };
    for source in [arm(12, 8), swelling_arm(12, 8)] {
        let model = Arc::new(CrowdModel::build(&context, &source, &[0], &settings, &mut Silent).unwrap());
        let poses: Vec<Vec<[f32; 3]>> = model.clips[0]
            .poses
            .iter()
            .map(|pose| skin(&context, &model.character, pose, Blend::Linear).unwrap())
            .collect();
        let mut crowd = Crowd::new(vec![model.clone()]);
        for index in 0..600 {
            let place = DVec3::new(f64::from(index % 20), 0.0, -3.0 - 0.002 * f64::from(index * index));
            let phase = f64::from(index) / 60.0;
            crowd.add(Agent { model: 0, clip: 0, phase, transform: DAffine3::from_translation(place) }).unwrap();
        }
        let view = CrowdView::perspective(DVec3::Y, DMat3::IDENTITY, 1.2, [320, 200], 0.5).unwrap();
        let view = CrowdView { planes: Vec::new(), ..view };
        let mut frame = Frame::default();
        crowd.cut(&context, &view, &mut frame).unwrap();
        let center = 0.5 * (Vec3::from(model.low) + Vec3::from(model.high));
        let (mut shown, mut own, mut shared) = (HashSet::new(), HashSet::new(), 0);
        for (agent, drawn) in &frame.drawn {
            let (key, clip) = (crowd.pose_key(*agent, 0.0), crowd.clip_key(*agent, 0.0));
            let Drawn::Step(step) = drawn else {
                assert_eq!(key, clip, "agent {agent} is near");
                continue;
            };
            let place = crowd.agents()[*agent as usize].transform.translation.as_vec3() + center;
            let near = place.distance(view.eye.into()) - 0.5 * model.size();
            let allowed = near * view.tolerance / view.pixels;
            let pairs = poses[key.pose as usize].iter().zip(&poses[clip.pose as usize]);
            let apart = pairs.map(|(a, b)| Vec3::from(*a).distance((*b).into())).fold(0.0, f32::max);
            let error = crowd.ladder(0).unwrap().error(*step) + apart;
            assert!(error <= allowed * (1.0 + 1e-4), "agent {agent}: {error} of {allowed}");
            shared += u32::from(key != clip);
            if *agent >= 400 {
                shown.insert(key);
                own.insert(clip);
            }
        }
        assert!(shared > 50 && shown.len() * 3 < own.len() * 2, "{shared} share, {} of {}", shown.len(), own.len());
        // Seen without error, all are where their clips have them.
        let fine = CrowdView { tolerance: 1e-6, ..view };
        crowd.cut(&context, &fine, &mut frame).unwrap();
        for agent in 0..600 {
            let [one, other] = [crowd.pose_key(agent, 0.0), crowd.clip_key(agent, 0.0)].map(|key| key.pose as usize);
            let mut pairs = poses[one].iter().zip(&poses[other]);
            assert!(pairs.all(|(a, b)| Vec3::from(*a).distance((*b).into()) < 1e-5), "agent {agent}");
        }
    }
}
