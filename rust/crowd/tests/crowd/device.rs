//! Draws of a device are those of the processor.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_crowd::{
    Agent, BuildSettings, Crowd, CrowdModel, CrowdView, DeviceCrowd, DeviceDraws, DrawList, Frame, Instance,
};
use relievo_testing::{Random, device};

use crate::arm::{built, swelling_arm};

/// Returns what the processor draws, with the matrices of instances counted in those of all poses.
fn expected(crowd: &mut Crowd, context: &Context, view: &CrowdView, time: f64) -> (DeviceDraws, Frame) {
    let (mut frame, mut list) = (Frame::default(), DrawList::default());
    crowd.cut(context, view, &mut frame).unwrap();
    list.update(crowd, &frame, time).unwrap();
    let mut firsts = vec![[0, 0]];
    for model in crowd.models() {
        let poses: usize = model.clips.iter().map(|clip| clip.poses.len()).sum();
        let [matrix, weight] = firsts[firsts.len() - 1];
        let (bones, morphs) = (model.character.bones.len(), model.character.morphs.count as usize);
        firsts.push([matrix + poses * bones, weight + poses * morphs]);
    }
    let pose = |instance: &Instance| crowd.pose_key(instance.agent, time).pose as usize;
    let instance = |instance: &Instance| {
        let agent = &crowd.agents()[instance.agent as usize];
        let bones = crowd.models()[agent.model as usize].character.bones.len();
        let first_matrix = (firsts[agent.model as usize][0] + pose(instance) * bones) as u32;
        Instance { first_matrix, ..*instance }
    };
    let own: Vec<u32> = (0..crowd.agents().len() as u32).filter(|agent| crowd.weights(*agent).is_some()).collect();
    let first_weight = |instance: &Instance| {
        let agent = &crowd.agents()[instance.agent as usize];
        let before = own.iter().take_while(|agent| **agent < instance.agent);
        if own.contains(&instance.agent) {
            // After those of all poses.
            let count = |agent: &u32| crowd.weights(*agent).unwrap_or_default().len();
            return (firsts[crowd.models().len()][1] + before.map(count).sum::<usize>()) as u32;
        }
        let morphs = crowd.models()[agent.model as usize].character.morphs.count as usize;
        (firsts[agent.model as usize][1] + pose(instance) * morphs) as u32
    };
    let first_weights = list.instances.iter().map(first_weight).collect();
    let instances = list.instances.iter().map(instance).collect();
    let DrawList { draws, clusters, blends, .. } = list;
    (DeviceDraws { draws, clusters, blends, instances, first_weights, impostors: frame.impostors() }, frame)
}

#[test]
fn draws_of_a_device_are_those_of_the_processor_along_a_path() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let settings = BuildSettings { cluster_triangles: 20, pose_rate: 12.0, ..BuildSettings::default() };
    let swelling = CrowdModel::build(&context, &swelling_arm(12, 8), &[0], &settings, &mut Silent).unwrap();
    let mut crowd = Crowd::new(vec![Arc::new(built(40, 16)), Arc::new(swelling)]);
    let mut random = Random(11);
    for index in 0..700 {
        let mut spread = |from: f64, to: f64| from + (to - from) * f64::from(random.unit());
        let place = DVec3::new(spread(-60.0, 60.0), spread(-2.0, 2.0), spread(-90.0, 10.0));
        let scale = DVec3::new(spread(0.5, 1.5), spread(0.5, 1.5), -spread(0.5, 1.5));
        let turn = DQuat::from_rotation_y(spread(0.0, 6.0));
        let transform = DAffine3::from_scale_rotation_translation(scale, turn, place);
        crowd.add(Agent { model: index % 2, clip: 0, phase: spread(0.0, 3.0), transform }).unwrap();
    }
    for agent in (1..700).step_by(14) {
        crowd.set_weights(agent, Some(&[2.0 * random.unit()])).unwrap();
    }
    let mut on = DeviceCrowd::new(&device, &crowd, 20_000).unwrap();
    let (mut near, mut whole, mut moving, mut quads, mut sizes) = (0, 0, 0, 0, Vec::new());
    for step in 0..8 {
        let time = 0.21 * f64::from(step);
        let eye = DVec3::new(0.5 * f64::from(step), 1.0, 12.0 - 9.0 * f64::from(step));
        let axes = DMat3::from_rotation_y(0.2 * f64::from(step));
        let mut view = CrowdView::perspective(eye, axes, 0.9, [320, 200], 0.5).unwrap();
        if step == 7 {
            // All agents, seen from among them.
            view.planes.clear();
        }
        view.geomorph = step % 3 == 1;
        if step % 4 == 2 {
            (view.impostors, view.tolerance) = (true, 3.0);
        }
        let (expected, frame) = expected(&mut crowd, &context, &view, time);
        let found = on.cut(&context, &crowd, &view, time).unwrap();
        assert_eq!(found.instances, expected.instances, "step {step}");
        assert_eq!(found.first_weights, expected.first_weights, "step {step}");
        assert_eq!(found.clusters, expected.clusters, "step {step}");
        assert_eq!(found.draws, expected.draws, "step {step}");
        assert_eq!(found.impostors, expected.impostors, "step {step}");
        // Devices may round quotients otherwise.
        assert_eq!(found.blends.len(), expected.blends.len());
        let pairs = found.blends.iter().zip(&expected.blends);
        assert!(pairs.clone().all(|(found, expected)| (found - expected).abs() < 1e-5), "step {step}");
        moving += pairs.filter(|(found, _)| (0.01..0.99).contains(*found)).count();
        quads += found.impostors.len();
        let shown = found.frame();
        assert_eq!((shown.clusters, shown.triangles), (frame.clusters, frame.triangles));
        let clusters = |shown: &Frame| -> Vec<(u32, Vec<u32>)> {
            shown.drawn.iter().map(|it| (it.0, crowd.clusters(shown, *it).to_vec())).collect()
        };
        assert_eq!(clusters(&shown), clusters(&frame), "step {step}");
        let mixed = frame.drawn.iter().filter(|it| matches!(it.1, relievo_crowd::Drawn::Mixed { .. })).count();
        near += mixed;
        whole += frame.drawn.len() - mixed;
        sizes.push(found.draws.len());
        // One agent moves, and is sent again.
        let moved = Agent { transform: DAffine3::from_translation(DVec3::Z * time), ..crowd.agents()[5] };
        crowd.set(5, moved).unwrap();
        // More agents get weights of their own, one has none any more.
        crowd.set_weights(29, (step % 2 == 0).then_some(&[0.5][..])).unwrap();
        for agent in (3..700).step_by(20).filter(|_| step == 4) {
            crowd.set_weights(agent, Some(&[-0.5])).unwrap();
        }
    }
    assert!(near > 20 && whole > 300, "{near} agents cut group by group and {whole} as a whole");
    assert!(moving > 100 && quads > 50, "{moving} clusters on their way and {quads} impostors");
    assert!(sizes.iter().all(|size| *size > 20), "{sizes:?}");
}

#[test]
fn agents_come_late_are_absent_or_have_more_draws_than_there_is_room_for() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut crowd = Crowd::new(vec![Arc::new(built(12, 8))]);
    let mut on = DeviceCrowd::new(&device, &crowd, 3).unwrap();
    let view = CrowdView {
        eye: [0.0, 1.5, 30.0],
        pixels: 4.0,
        tolerance: 0.5,
        planes: vec![[0.0, 0.0, -1.0, 20.0]],
        ..CrowdView::default()
    };
    assert_eq!(on.cut(&context, &crowd, &view, 0.0).unwrap(), DeviceDraws::default());
    crowd.add(Agent { model: 0, clip: 0, phase: 0.0, transform: DAffine3::IDENTITY }).unwrap();
    let (expected, _) = expected(&mut crowd, &context, &view, 0.0);
    assert_eq!(on.cut(&context, &crowd, &view, 0.0).unwrap(), expected);
    let away = CrowdView { planes: vec![[0.0, 0.0, -1.0, -20.0]], ..view.clone() };
    assert_eq!(on.cut(&context, &crowd, &away, 0.0).unwrap(), DeviceDraws::default());
    // More draws than there is room for: a frame counts them and leaves the rest out, and a cut makes room.
    let close = CrowdView { pixels: 1e6, ..view.clone() };
    let mut frame = device.frame().unwrap();
    on.record(&context, &crowd, (&close, 0.0), &mut frame).unwrap();
    let (counts, draws) = (frame.read(on.counts(), 0..2).unwrap(), frame.read(on.draws(), 0..15).unwrap());
    let _ = frame.submit().unwrap();
    let (counts, draws) = (counts.get(&device).unwrap(), draws.get(&device).unwrap());
    let (expected, _) = self::expected(&mut crowd, &context, &close, 0.0);
    assert!(counts[..2] == [1, expected.draws.len() as u32] && counts[1] > 3, "{counts:?}");
    let words = expected.draws[..3].iter().map(|it| [it.index_count, 1, it.first_index, 0, 0]);
    assert_eq!(draws, words.collect::<Vec<_>>().concat());
    assert_eq!(on.cut(&context, &crowd, &close, 0.0).unwrap(), expected);
    let many = CrowdView { planes: vec![[0.0, 0.0, -1.0, 20.0]; 64], ..view };
    assert!(on.cut(&context, &crowd, &many, 0.0).unwrap_err().to_string().contains("63 planes"));
    let other = Crowd::new(Vec::new());
    assert!(on.cut(&context, &other, &close, 0.0).unwrap_err().to_string().contains("other models"));
}
