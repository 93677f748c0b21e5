//! What a device poses is what the processor does, and agents that it hides change no pixel.

use std::collections::HashSet;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use relievo_core::Context;
use relievo_core::parameter::Switch;
use relievo_core::progress::Silent;
use relievo_crowd::{
    Agent, Blend, BuildSettings, Crowd, CrowdModel, CrowdView, DeviceCounted, DeviceCrowd, DeviceOcclusion,
    DevicePoser, DeviceQuads, DeviceUnhidden, DrawList, Frame, Look, Occlusion, PixelView, skin,
};
use relievo_gpu::Device;
use relievo_render::virtual_vertex::{Placed, PosedMesh, Rasterizer, Shape};
use relievo_render::{Camera, Frame as Pixels, Material, View};
use relievo_testing::{Random, device};

use crate::arm::{built, swelling_arm, wrung};
use crate::occlusion::row;

/// A crowd on a device, posed, culled and with its quads.
struct On {
    crowd: DeviceCrowd,
    poser: DevicePoser,
    quads: DeviceQuads,
    occlusion: DeviceOcclusion,
}

impl On {
    fn new(device: &Device, crowd: &Crowd) -> Self {
        let look = Look { tag: None, lines: false };
        Self {
            crowd: DeviceCrowd::new(device, crowd, 3).unwrap(),
            poser: DevicePoser::new(device, crowd, look).unwrap(),
            quads: DeviceQuads::new(device, crowd, look).unwrap(),
            occlusion: DeviceOcclusion::new(device).unwrap(),
        }
    }

    fn update(&mut self, crowd: &Crowd, (seen, time): (&CrowdView, f64), pixels: Option<&PixelView>) -> DeviceUnhidden {
        let context = Context::serial();
        let found = match pixels {
            None => {
                let (listed, posed) = self.poser.update(&context, (crowd, &mut self.crowd), (seen, time)).unwrap();
                DeviceUnhidden { listed, drawn: listed, posed, ..DeviceUnhidden::default() }
            }
            Some(pixels) => {
                let on = (crowd, &mut self.crowd, &mut self.poser);
                self.occlusion.pose(&context, on, (seen, time), pixels).unwrap()
            }
        };
        let eye = Vec3::from(seen.eye).as_dvec3();
        self.quads.update(&context, (crowd, &self.crowd, found.listed), (eye, time), &found.hidden_quads).unwrap();
        found
    }

    fn picture(&self, rasterizer: &mut Rasterizer, view: &View) -> Pixels {
        let shapes = [Shape::Posed(self.poser.mesh(&self.crowd)), Shape::Quads(self.quads.mesh(&self.crowd))];
        rasterizer.render(&shapes.map(|shape| Placed::new(shape, Material::default())), view).unwrap()
    }
}

/// Returns the instance and the place in its model of every corner that a device drew.
fn corners(device: &Device, mesh: &PosedMesh) -> Vec<(u32, [f32; 3])> {
    let mut frame = device.frame().unwrap();
    let arguments = frame.read(mesh.arguments, 0..1).unwrap();
    let corners = frame.read(mesh.corners, 0..mesh.corners.len()).unwrap();
    let vertices = frame.read(mesh.vertices, 0..mesh.vertices.len()).unwrap();
    let _ = frame.submit().unwrap();
    let (count, vertices) = (arguments.get(device).unwrap()[0] as usize, vertices.get(device).unwrap());
    let corners = corners.get(device).unwrap();
    corners[..count].iter().map(|[vertex, instance]| (*instance, vertices[*vertex as usize].p)).collect()
}

/// Returns the same as the processor has it.
fn expected_corners(crowd: &Crowd, frame: &Frame, time: f64) -> Vec<(u32, [f32; 3])> {
    let (mut list, mut found) = (DrawList::default(), Vec::new());
    list.update(crowd, frame, time).unwrap();
    for ((draw, [model, cluster]), moved) in list.draws.iter().zip(&list.clusters).zip(&list.blends) {
        let model = &crowd.models()[*model as usize];
        for at in draw.first_instance..draw.first_instance + draw.instance_count {
            let agent = list.instances[at as usize].agent;
            let pose = crowd.posed(&crowd.pose_key(agent, time)).into_owned();
            let points = skin(&Context::serial(), &model.character, &pose, model.blend).unwrap();
            let is_mirror = crowd.agents()[agent as usize].transform.matrix3.determinant() < 0.0;
            for triangle in model.triangles(*cluster) {
                let turned = if is_mirror { [0, 2, 1] } else { [0, 1, 2] };
                let place = |corner: usize| model.blended((*cluster, *moved), triangle[corner], &points);
                found.extend(turned.map(|corner| (at, place(corner))));
            }
        }
    }
    found
}

#[test]
fn vertices_on_a_device_are_where_the_processor_has_them() {
    let Some(device) = device() else { return };
    for blend in [Blend::Linear, Blend::DualQuaternion] {
        check_vertices(&device, blend);
    }
}

fn check_vertices(device: &Device, blend: Blend) {
    let context = Context::serial();
    let settings = BuildSettings { cluster_triangles: 20, pose_rate: 8.0, ..BuildSettings::default() };
    let swelling = CrowdModel::build(&context, &swelling_arm(24, 12), &[0], &settings, &mut Silent).unwrap();
    let models = [built(16, 10), swelling];
    let mut crowd = Crowd::new(models.map(|model| Arc::new(model.with_blend(&context, blend).unwrap())).to_vec());
    let mut random = Random(5);
    for index in 0..40 {
        let mut spread = |from: f64, to: f64| from + (to - from) * f64::from(random.unit());
        let place = DVec3::new(spread(-14.0, 14.0), 0.0, spread(-50.0, 4.0));
        let mirror = if index % 3 == 0 { -1.0 } else { 1.0 };
        let scale = DVec3::new(spread(0.7, 1.3), spread(0.7, 1.3), mirror * spread(0.7, 1.3));
        let turn = DQuat::from_rotation_y(spread(0.0, 6.0));
        let transform = DAffine3::from_scale_rotation_translation(scale, turn, place);
        crowd.add(Agent { model: index % 2, clip: 0, phase: spread(0.0, 1.0), transform }).unwrap();
    }
    for (agent, weight) in [(1, 1.4), (3, -0.5), (7, 0.2), (25, 1.0), (27, 1.0)] {
        crowd.set_weights(agent, Some(&[weight])).unwrap();
    }
    let (time, eye) = (0.3, [3.0, 2.0, 14.0]);
    let mut on = On::new(device, &crowd);
    for (tolerance, geomorph) in [(0.5, false), (2.0, true)] {
        let (mut frame, mut seen) = (Frame::default(), CrowdView { eye, pixels: 190.0, ..CrowdView::default() });
        (seen.tolerance, seen.geomorph) = (tolerance, geomorph);
        crowd.cut(&context, &seen, &mut frame).unwrap();
        let posed = on.update(&crowd, (&seen, time), None).posed;
        let found = corners(device, &on.poser.mesh(&on.crowd));
        let expected = expected_corners(&crowd, &frame, time);
        assert!(found.len() == expected.len() && found.len() > 1000, "{} corners", found.len());
        assert_eq!(posed.corners as usize, found.len());
        let moving = frame.blends.iter().filter(|blend| (0.01..0.99).contains(*blend)).count();
        assert!(!geomorph || moving > 30, "{moving} clusters move");
        for (found, expected) in found.iter().zip(&expected) {
            let away = Vec3::from(found.1).distance(Vec3::from(expected.1));
            assert!(found.0 == expected.0 && away < 1e-5, "{found:?} and {expected:?} with {blend:?}");
        }
    }
}

/// Returns a dense field of arms, one row behind the other.
fn field(model: CrowdModel) -> Crowd {
    let mut crowd = Crowd::new(vec![Arc::new(model)]);
    for index in 0..150 {
        let place = DVec3::new(f64::from(index % 15) * 0.5 - 3.5, 0.0, -1.5 * f64::from(index / 15));
        let transform = DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.7 * f64::from(index)), place);
        crowd.add(Agent { model: 0, clip: 0, phase: 0.13 * f64::from(index), transform }).unwrap();
    }
    crowd
}

/// Returns how many vertices some agents have to be posed at: those of each cluster once for all agents that share its draw and
/// their pose.
fn posed_of(crowd: &Crowd, frame: &Frame, time: f64, is_posed: &dyn Fn(u32) -> bool) -> u32 {
    let mut list = DrawList::default();
    list.update(crowd, frame, time).unwrap();
    let parts = list.draws.iter().zip(&list.clusters).map(|(draw, [model, cluster])| {
        let instances = &list.instances[draw.first_instance as usize..][..draw.instance_count as usize];
        let posed = instances.iter().filter(|instance| is_posed(instance.agent));
        let poses: HashSet<u32> = posed.map(|instance| instance.first_matrix).collect();
        let triangles = crowd.models()[*model as usize].triangles(*cluster);
        let vertices: HashSet<u32> = triangles.as_flattened().iter().copied().collect();
        poses.len() * vertices.len()
    });
    parts.sum::<usize>() as u32
}

#[test]
fn culling_on_a_device_changes_no_pixel_of_a_path() {
    let Some(device) = device() else { return };
    check_path(&device, field(built(16, 10)), 8);
    check_path(&device, field(wrung(24, 12)), 4);
}

/// Checks pictures of the first frames of a path.
fn check_path(device: &Device, mut crowd: Crowd, frames: u32) {
    let context = Context::serial();
    let [mut all, mut fewer] = [(), ()].map(|()| On::new(device, &crowd));
    let mut rasterizer = Rasterizer::new(device).unwrap();
    let (mut culling, mut hidden, mut on_processor) = (Occlusion::default(), 0, 0);
    let (mut seen_before, mut sums) = (Vec::<u32>::new(), [0; 2]);
    let size = [240, 160];
    for step in 0..frames {
        let (share, time) = (0.1 * f64::from(step), 0.3 * f64::from(step));
        let eye = DVec3::new(4.0 * (6.0 * share).sin(), 1.2 + 0.4 * (9.0 * share).cos(), 5.0 - 3.0 * share);
        let camera = Camera { eye, axes: DMat3::from_rotation_y(0.3 * (5.0 * share).sin()), fov: 0.9 };
        let mut view = View::new(camera);
        [view.settings.width, view.settings.height] = size;
        (view.settings.samples, view.settings.shadows) = (1, Switch::OFF);
        let pixels = PixelView { eye, axes: camera.axes, fov: camera.fov, size };
        let seen = CrowdView::perspective(eye, camera.axes, camera.fov, size, 2.0).unwrap();
        let seen = CrowdView { geomorph: step % 4 == 1, impostors: step % 4 == 3, ..seen };
        let shown: HashSet<u32> = seen_before.iter().copied().collect();
        let DeviceUnhidden { drawn: plain, posed: all_posed, .. } = all.update(&crowd, (&seen, time), None);
        let unhidden = fewer.update(&crowd, (&seen, time), Some(&pixels));
        let (culled, found) = (unhidden.drawn, unhidden.culled);
        assert_eq!(unhidden.listed, plain, "step {step}");
        assert_eq!(culled.agents + culled.impostors + found.hidden, plain.agents + plain.impostors, "step {step}");
        let triangles = |counted: DeviceCounted| u64::from(counted.triangles) + 2 * u64::from(counted.impostors);
        assert_eq!(triangles(culled) + found.hidden_triangles, triangles(plain), "step {step}");
        let behind = fewer.crowd.hidden().unwrap();
        assert_eq!(behind.len(), found.hidden as usize, "step {step}");
        let [expected, made] = [&all, &fewer].map(|on| on.picture(&mut rasterizer, &view));
        assert_eq!(expected.object, made.object, "step {step}");
        assert_eq!(expected.depth.data(), made.depth.data(), "step {step}");
        assert_eq!(expected.color.data(), made.color.data(), "step {step}");
        let mut cut = Frame::default();
        crowd.cut(&context, &seen, &mut cut).unwrap();
        // What was seen in the last frame and what is seen now is posed, once, and nothing else.
        seen_before =
            cut.drawn.iter().map(|drawn| drawn.0).filter(|agent| behind.binary_search(agent).is_err()).collect();
        let is_posed = |agent: u32| step == 0 || shown.contains(&agent) || seen_before.contains(&agent);
        // The first frame is made again when there is room, with what was seen then.
        let posed = posed_of(&crowd, &cut, time, &is_posed);
        assert!(unhidden.posed.vertices == posed || step == 0 && unhidden.posed.vertices < posed, "step {step}");
        assert_eq!(all_posed.vertices, posed_of(&crowd, &cut, time, &|_| true), "step {step}");
        sums = [sums[0] + unhidden.posed.vertices, sums[1] + all_posed.vertices];
        on_processor += culling.cull(&context, &crowd, (&pixels, time), &mut cut).unwrap().hidden;
        hidden += found.hidden;
    }
    println!("{hidden} and {on_processor} agents were hidden, {} of {} vertices posed", sums[0], sums[1]);
    assert!(sums[0] < sums[1], "{sums:?}");
    // Levels of the pyramid are coarser than pixels.
    assert!(2 * hidden > on_processor && on_processor > 12 * frames, "{hidden} and {on_processor} agents were hidden");
}

#[test]
fn clusters_of_near_agents_are_culled_on_a_device() {
    let Some(device) = device() else { return };
    let crowd = row();
    let context = Context::serial();
    let [mut all, mut fewer] = [(), ()].map(|()| On::new(&device, &crowd));
    let mut rasterizer = Rasterizer::new(&device).unwrap();
    let size = [240, 160];
    for number in 0..3 {
        let eye = DVec3::new(0.1 * f64::from(number), 1.2, 5.0);
        let camera = Camera { eye, axes: DMat3::IDENTITY, fov: 0.9 };
        let mut view = View::new(camera);
        [view.settings.width, view.settings.height] = size;
        (view.settings.samples, view.settings.shadows) = (1, Switch::OFF);
        let pixels = PixelView { eye, axes: camera.axes, fov: camera.fov, size };
        let seen = CrowdView::perspective(eye, camera.axes, camera.fov, size, 0.05).unwrap();
        let seen = CrowdView { geomorph: number == 2, ..seen };
        let plain = all.update(&crowd, (&seen, 0.0), None).drawn;
        let unhidden = fewer.update(&crowd, (&seen, 0.0), Some(&pixels));
        let (drawn, found) = (unhidden.drawn, unhidden.culled);
        assert!(found.hidden_clusters > 0 && found.hidden == 0, "{found:?}");
        assert_eq!(u64::from(drawn.triangles) + found.hidden_triangles, u64::from(plain.triangles));
        let [expected, made] = [&all, &fewer].map(|on| on.picture(&mut rasterizer, &view));
        assert_eq!(expected.object, made.object);
        assert_eq!(expected.depth.data(), made.depth.data());
        assert_eq!(expected.color.data(), made.color.data());
        // Lists of hosts have the same draws without instances.
        let mut on = On::new(&device, &crowd);
        let parts = (&crowd, &mut on.crowd, &mut on.poser);
        let (counted, listed) = on.occlusion.update(&context, parts, (&seen, 0.0), &pixels).unwrap();
        let draws = on.crowd.read(counted).unwrap().draws;
        let empty = draws.iter().filter(|draw| draw.instance_count == 0).count() as u64;
        let shown: u32 = draws.iter().map(|draw| draw.index_count / 3 * draw.instance_count).sum();
        assert_eq!((empty, shown), (listed.hidden_clusters, counted.triangles));
        assert!(empty > 0 && listed.hidden_triangles + u64::from(shown) == u64::from(plain.triangles));
    }
}

#[test]
fn culling_on_a_device_rests_where_nothing_is_hidden() {
    let Some(device) = device() else { return };
    let mut crowd = Crowd::new(vec![Arc::new(built(16, 10))]);
    for place in [-6.0, 0.0, 6.0] {
        let transform = DAffine3::from_translation(DVec3::new(place, 0.0, -8.0));
        crowd.add(Agent { model: 0, clip: 0, phase: 0.0, transform }).unwrap();
    }
    let camera = Camera::look_at(DVec3::new(0.0, 1.0, 6.0), DVec3::new(0.0, 1.0, 0.0), DVec3::Y, 0.9).unwrap();
    let pixels = PixelView { eye: camera.eye, axes: camera.axes, fov: camera.fov, size: [64, 48] };
    let seen = CrowdView::perspective(camera.eye, camera.axes, camera.fov, pixels.size, 0.5).unwrap();
    let (context, mut on) = (Context::serial(), On::new(&device, &crowd));
    let mut update = |pixels: &PixelView| {
        let parts = (&crowd, &mut on.crowd, &mut on.poser);
        on.occlusion.update(&context, parts, (&seen, 0.0), pixels)
    };
    let mut rested = Vec::new();
    for _ in 0..100 {
        let (counted, found) = update(&pixels).unwrap();
        assert_eq!(counted.agents, 3);
        rested.push(found.is_resting);
    }
    // Four frames with a loss, then a rest of 32; after it two suffice.
    let changes: Vec<usize> = (1..rested.len()).filter(|at| rested[*at] != rested[*at - 1]).collect();
    assert!(!rested[0] && changes == [4, 36, 38, 70, 72], "{changes:?}");
    let wrong = PixelView { size: [0, 5], ..pixels };
    assert!(update(&wrong).is_err());
}

#[test]
fn culling_on_a_device_rests_where_it_costs_more_than_it_saves() {
    let Some(device) = device() else { return };
    let mut crowd = Crowd::new(vec![Arc::new(built(16, 10))]);
    // A wall before many agents.
    for index in 0..120 {
        let (scale, place) = match index {
            0 => (DVec3::new(10.0, 2.0, 1.0), DVec3::ZERO),
            _ => (DVec3::ONE, DVec3::new(0.2 * f64::from(index % 10) - 0.9, 0.0, -6.0 - f64::from(index / 10))),
        };
        let transform = DAffine3::from_scale_rotation_translation(scale, DQuat::IDENTITY, place);
        crowd.add(Agent { model: 0, clip: 0, phase: 0.13 * f64::from(index), transform }).unwrap();
    }
    let camera = Camera::look_at(DVec3::new(0.0, 1.5, 8.0), DVec3::new(0.0, 1.5, 0.0), DVec3::Y, 0.9).unwrap();
    let rests = |size: [u32; 2]| {
        let mut on = On::new(&device, &crowd);
        let pixels = PixelView { eye: camera.eye, axes: camera.axes, fov: camera.fov, size };
        // The same cuts whatever the size.
        let tolerance = size[1] as f32 / 128.0;
        let seen = CrowdView::perspective(camera.eye, camera.axes, camera.fov, size, tolerance).unwrap();
        let mut update = || on.update(&crowd, (&seen, 0.0), Some(&pixels)).culled;
        // In the first frame all agents count as occluders.
        update();
        let found = update();
        println!("{size:?}: {found:?}");
        assert!(found.hidden > 100 && found.hidden_triangles > 3 * found.occluder_triangles, "{found:?}");
        (0..6).any(|_| update().is_resting)
    };
    // Of a small picture it pays; a large one has more pixels of depths than the hidden agents have vertices and triangles.
    assert!(!rests([96, 64]));
    assert!(rests([2304, 1536]));
}
