//! Agents with weights of morph targets of their own.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_crowd::{
    Agent, Blend, BuildSettings, Crowd, CrowdModel, CrowdView, DeviceCrowd, DrawList, Frame, NONE, skin,
};
use relievo_lod::distance;

use crate::arm::{built, swelling_arm};

fn swelling() -> CrowdModel {
    let settings = BuildSettings { cluster_triangles: 20, pose_rate: 8.0, ..BuildSettings::default() };
    CrowdModel::build(&Context::serial(), &swelling_arm(30, 16), &[0], &settings, &mut Silent).unwrap()
}

fn agent_at(x: f64, z: f64) -> Agent {
    Agent { model: 0, clip: 0, phase: 0.0, transform: DAffine3::from_translation(DVec3::new(x, 0.0, z)) }
}

#[test]
fn cuts_hold_the_error_with_weights_that_no_clip_has() {
    let (context, model) = (Context::serial(), Arc::new(swelling()));
    let mut crowd = Crowd::new(vec![Arc::clone(&model)]);
    crowd.add(agent_at(0.0, -30.0)).unwrap();
    crowd.add(agent_at(0.0, -30.0)).unwrap();
    let triangles = |clusters: &[u32]| -> Vec<[u32; 3]> {
        clusters.iter().flat_map(|cluster| model.triangles(*cluster)).copied().collect()
    };
    let input = triangles(&model.input_clusters());
    let mut frame = Frame::default();
    let mut sizes = Vec::new();
    for (weight, tolerance) in [(2.5f32, 0.5f32), (-1.0, 1.0), (1.2, 8.0), (0.4, 0.25)] {
        crowd.set_weights(1, Some(&[weight])).unwrap();
        let view =
            CrowdView { eye: [0.0, 1.5, 0.0], pixels: 100.0, tolerance, planes: Vec::new(), ..CrowdView::default() };
        crowd.cut(&context, &view, &mut frame).unwrap();
        let counts: Vec<usize> =
            frame.drawn.iter().map(|drawn| triangles(crowd.clusters(&frame, *drawn)).len()).collect();
        sizes.push(counts);
        let coarse = triangles(crowd.clusters(&frame, frame.drawn[1]));
        for step in 0..8 {
            let time = f64::from(step) / 8.0;
            let pose = crowd.posed(&crowd.pose_key(1, time)).into_owned();
            assert_eq!(pose.weights, [weight]);
            let points = skin(&context, &model.character, &pose, Blend::Linear).unwrap();
            let found = distance(&context, [(&points, &input), (&points, &coarse)], &mut Silent).unwrap();
            let allowed = tolerance / view.pixels * 32.0;
            assert!(found.at_least <= allowed, "weight {weight}, pose {step}: {found:?}, {allowed}");
        }
    }
    // The bound costs triangles, but does not ask for the input where more may be seen than it adds.
    assert!(sizes.iter().all(|counts| counts[1] >= counts[0]), "{sizes:?}");
    assert!(sizes[2][1] < input.len() / 4, "{sizes:?}");
}

#[test]
fn weights_are_drawn_follow_clips_and_go_with_another_model() {
    let context = Context::serial();
    let mut crowd = Crowd::new(vec![Arc::new(swelling()), Arc::new(built(12, 8))]);
    for at in 0..3 {
        crowd.add(agent_at(f64::from(at), -20.0)).unwrap();
    }
    crowd.set_weights(1, Some(&[0.75])).unwrap();
    assert_eq!((crowd.pose_key(0, 0.0).own, crowd.pose_key(1, 0.0).own), (NONE, 1));
    let view = CrowdView { eye: [0.0; 3], pixels: 200.0, tolerance: 0.5, planes: Vec::new(), ..CrowdView::default() };
    let (mut frame, mut list) = (Frame::default(), DrawList::default());
    crowd.cut(&context, &view, &mut frame).unwrap();
    list.update(&crowd, &frame, 0.5).unwrap();
    let weight = |list: &DrawList, agent: u32| {
        let at = list.instances.iter().position(|instance| instance.agent == agent).unwrap();
        list.weights[list.first_weights[at] as usize]
    };
    let of_clip = crowd.models()[0].clips[0].poses[4].weights[0];
    assert_eq!([weight(&list, 0), weight(&list, 1), weight(&list, 2)], [of_clip, 0.75, of_clip]);
    // A move keeps them, another model or an empty list takes them away.
    crowd.set(1, agent_at(0.0, -21.0)).unwrap();
    assert_eq!(crowd.weights(1), Some(&[0.75][..]));
    crowd.set(1, Agent { model: 1, ..agent_at(0.0, -21.0) }).unwrap();
    assert_eq!(crowd.weights(1), None);
    crowd.set_weights(0, Some(&[0.1])).unwrap();
    crowd.set_weights(0, None).unwrap();
    assert_eq!(crowd.weights(0), None);
    assert!(crowd.set_weights(3, None).is_err());
    assert!(crowd.set_weights(0, Some(&[0.1, 0.2])).unwrap_err().to_string().contains("2 weights for 1"));
    assert!(crowd.set_weights(1, Some(&[0.1])).is_err());
    for wrong in [f32::NAN, f32::INFINITY, 3e38] {
        assert!(crowd.set_weights(0, Some(&[wrong])).is_err());
    }
    assert_eq!(crowd.weights(0), None);
}

#[test]
fn an_agent_that_swells_into_view_is_seen() {
    let (context, model) = (Context::serial(), Arc::new(swelling()));
    let mut crowd = Crowd::new(vec![Arc::clone(&model)]);
    crowd.add(agent_at(0.0, 0.0)).unwrap();
    // The plane begins beyond the box of all poses; the target at weight 40 reaches there.
    let mut frame = Frame::default();
    let plane = [0.0, 0.0, 1.0, -model.high[2] - model.size()];
    let view =
        CrowdView { eye: [0.0, 1.5, 40.0], pixels: 500.0, tolerance: 0.5, planes: vec![plane], ..CrowdView::default() };
    crowd.cut(&context, &view, &mut frame).unwrap();
    assert!(frame.drawn.is_empty());
    crowd.set_weights(0, Some(&[40.0])).unwrap();
    let points = skin(&context, &model.character, &crowd.posed(&crowd.pose_key(0, 0.0)), Blend::Linear).unwrap();
    assert!(points.iter().any(|point| point[2] + plane[3] > 0.0));
    crowd.cut(&context, &view, &mut frame).unwrap();
    assert!(frame.drawn.len() == 1 && frame.triangles > 0);
    if let Some(device) = relievo_testing::device() {
        let mut on = DeviceCrowd::new(&device, &crowd, 100).unwrap();
        let draws = on.cut(&context, &crowd, &view, 0.0).unwrap();
        assert_eq!((draws.instances.len(), draws.frame().triangles), (1, frame.triangles));
        crowd.set_weights(0, None).unwrap();
        assert!(on.cut(&context, &crowd, &view, 0.0).unwrap().instances.is_empty());
    }
}
