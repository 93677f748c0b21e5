//! Draw lists have the clusters of the frame, once for each agent, and poses that give the agents' triangles.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_crowd::{Agent, Blend, BuildSettings, Crowd, CrowdModel, CrowdView, DrawList, Frame, skin};

use crate::arm::{built, swelling_arm};

#[test]
fn instanced_draws_show_what_the_frame_has() {
    let context = Context::serial();
    let settings = BuildSettings { cluster_triangles: 40, pose_rate: 12.0, ..BuildSettings::default() };
    let swelling = CrowdModel::build(&context, &swelling_arm(12, 8), &[0], &settings, &mut Silent).unwrap();
    let models = [Arc::new(built(30, 16)), Arc::new(swelling)];
    let mut crowd = Crowd::new(models.to_vec());
    for index in 0..60 {
        let place = DVec3::new(f64::from(index % 6) - 3.0, 0.0, -12.0 * f64::from(index / 6));
        let transform = DAffine3::from_scale_rotation_translation(
            DVec3::splat(1.0 + 0.01 * f64::from(index)),
            glam::DQuat::from_rotation_y(f64::from(index)),
            place,
        );
        crowd.add(Agent { model: index % 2, clip: 0, phase: f64::from(index % 5) / 7.0, transform }).unwrap();
    }
    let view = CrowdView {
        eye: [0.0, 2.0, 6.0],
        pixels: 400.0,
        tolerance: 0.5,
        planes: vec![[0.0, 0.0, -1.0, 1.0]],
        ..CrowdView::default()
    };
    let (mut frame, mut list) = (Frame::default(), DrawList::default());
    crowd.cut(&context, &view, &mut frame).unwrap();
    list.update(&crowd, &frame, 0.25).unwrap();
    assert_eq!(list.instances.len(), frame.drawn.len());
    assert!(list.draws.len() < frame.clusters as usize, "agents of one step share draws");
    let mut shown: Vec<(u32, u32)> = Vec::new();
    for (draw, [model, cluster]) in list.draws.iter().zip(&list.clusters) {
        let found = &models[*model as usize].clusters[*cluster as usize];
        let before =
            if *model == 0 { (0, 0) } else { (models[0].character.triangles.len(), models[0].character.points.len()) };
        assert_eq!(draw.index_count, 3 * found.count);
        assert_eq!(draw.first_index as usize, 3 * (before.0 + found.first as usize));
        assert_eq!(draw.base_vertex as usize, before.1);
        for instance in draw.first_instance..draw.first_instance + draw.instance_count {
            shown.push((list.instances[instance as usize].agent, *cluster));
        }
    }
    let mut expected: Vec<(u32, u32)> = Vec::new();
    for drawn in &frame.drawn {
        expected.extend(crowd.clusters(&frame, *drawn).iter().map(|cluster| (drawn.0, *cluster)));
    }
    shown.sort_unstable();
    expected.sort_unstable();
    assert_eq!(shown, expected);
    // A vertex by the weights and matrices of its instance is where skinning puts it.
    assert_eq!(list.first_weights.len(), list.instances.len());
    let mut moved = 0;
    for (instance, first_weight) in list.instances.iter().zip(&list.first_weights) {
        let agent = &crowd.agents()[instance.agent as usize];
        let model = &models[agent.model as usize];
        let pose = &model.clips[0].poses[crowd.pose_key(instance.agent, 0.25).pose as usize];
        let points = skin(&context, &model.character, pose, Blend::Linear).unwrap();
        let vertex = model.character.points.len() / 2;
        let influence = model.character.influences[vertex];
        let mut point = Vec3::from(model.character.points[vertex]);
        for found in model.character.morphs.of(vertex) {
            let weight = list.weights[(first_weight + found.morph) as usize];
            point += weight * Vec3::from(found.offset);
            moved += u32::from(weight > 0.0);
        }
        let mapped = |rows: &[[f32; 4]; 3], point: Vec3| {
            Vec3::from_array(rows.map(|[x, y, z, w]| x * point.x + y * point.y + z * point.z + w))
        };
        let bones = influence.bones.iter().zip(influence.weights);
        let posed: Vec3 = bones
            .map(|(bone, weight)| {
                weight * mapped(&list.matrices[instance.first_matrix as usize + usize::from(*bone)], point)
            })
            .sum();
        let expected = agent.transform.transform_point3(Vec3::from(points[vertex]).as_dvec3()).as_vec3();
        assert!(mapped(&instance.transform, posed).distance(expected) < 1e-4);
    }
    assert!(moved > 0);
}
