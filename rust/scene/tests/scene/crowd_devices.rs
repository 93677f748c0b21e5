//! Crowds that a graphics device draws, against the ray caster on the same cuts.

use std::collections::HashSet;
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec3};
use relievo_core::parameter::Switch;
use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, Domain, Values};
use relievo_crowd::{Agent, Blend, BuildSettings, Cluster, Crowd, CrowdModel, CrowdView, DrawList, Frame};
use relievo_gpu::Device;
use relievo_render::virtual_vertex::{DeviceMesh, Placed, Rasterizer, Shape};
use relievo_render::{
    Camera, FalseColor, Frame as Pixels, Material, Mesh, NO_OBJECT, Picture, Scene, View, compare_geometry,
};
use relievo_scene::walking::{DeviceStandIns, Look, StandIns, with_shadows};
use relievo_testing::{Random, device};

#[expect(dead_code, reason = "the tests of crowds use more of it")]
#[path = "../../../crowd/tests/crowd/arm.rs"]
pub mod arm;

const MATERIAL: Material = Material { base_color: [0.6, 0.5, 0.4], specular: 0.04, roughness: 0.5 };
const GROUND: Material = Material { base_color: [0.4; 3], specular: 0.0, roughness: 1.0 };

/// Returns 120 agents of two models, one with normals and a morph target; some are mirrored or stretched.
fn crowd(blend: Blend) -> Crowd {
    let context = Context::serial();
    let mut swelling = arm::swelling_arm(24, 12);
    let mesh = &mut swelling.meshes[0].mesh;
    let normal =
        |point: &[f32; 3]| Vec3::new(point[0], (0.3 * point[1] - 0.45).powi(5), point[2]).normalize().to_array();
    let values = Values::F32(mesh.points.iter().flat_map(normal).collect());
    mesh.attributes.push(Attribute { name: "normal".into(), domain: Domain::Point, width: 3, values, indices: None });
    let settings = BuildSettings { cluster_triangles: 20, pose_rate: 8.0, ..BuildSettings::default() };
    let swelling = CrowdModel::build(&context, &swelling, &[0], &settings, &mut Silent).unwrap();
    let models = [arm::built(16, 10), swelling];
    let mut crowd = Crowd::new(models.map(|model| Arc::new(model.with_blend(&context, blend).unwrap())).to_vec());
    let mut random = Random(5);
    for index in 0..120 {
        let mut spread = |from: f64, to: f64| from + (to - from) * f64::from(random.unit());
        let place = DVec3::new(spread(-14.0, 14.0), 0.0, spread(-50.0, 4.0));
        let mirror = if index % 3 == 0 { -1.0 } else { 1.0 };
        let scale = DVec3::new(spread(0.7, 1.3), spread(0.7, 1.3), mirror * spread(0.7, 1.3));
        let transform =
            DAffine3::from_scale_rotation_translation(scale, DQuat::from_rotation_y(spread(0.0, 6.0)), place);
        crowd.add(Agent { model: index % 2, clip: 0, phase: spread(0.0, 1.0), transform }).unwrap();
    }
    crowd
}

fn view() -> View {
    let camera = Camera::look_at(DVec3::new(3.0, 5.0, 14.0), DVec3::new(0.0, 1.0, -6.0), DVec3::Y, 0.8).unwrap();
    let mut view = View::new(camera);
    [view.settings.width, view.settings.height] = [240, 160];
    view.settings.samples = 1;
    view.settings.sky_rays = 0;
    view.settings.shadows = Switch::OFF;
    view.lights.sky.up = [0.0, 1.0, 0.0];
    view.lights.suns[0].angular_radius = 0.0;
    view.lights.suns[0].direction = [-0.5, 0.8, 0.6];
    view.settings.false_color = 1.0;
    view.false_color = Some(FalseColor { palette: vec![[0.8, 0.2, 0.1], [0.1, 0.6, 0.3], [0.2, 0.3, 0.8]] });
    view
}

/// How a crowd is cut and posed.
#[derive(Clone, Copy)]
struct Way {
    pixels: f32,
    geomorph: bool,
    impostors: bool,
}

const PLAIN: Way = Way { pixels: 0.5, geomorph: false, impostors: false };

/// Returns what a view sees of a crowd.
fn seen_by(view: &View, way: Way) -> CrowdView {
    let (camera, settings) = (&view.camera, &view.settings);
    let size = [settings.width, settings.height];
    let seen = CrowdView::perspective(camera.eye, camera.axes, camera.fov, size, way.pixels).unwrap();
    CrowdView { geomorph: way.geomorph, impostors: way.impostors, ..seen }
}

/// What the caster and the device draw of a crowd at a time, with what they count.
struct Both {
    expected: Pixels,
    found: Pixels,
}

impl Both {
    /// Asserts that depths, normals, colours and agents are equal up to rounding.
    fn assert_alike(&self) {
        let picture = |frame: &Pixels| {
            let (depth, normal) = (Some(frame.depth.clone()), Some(frame.normal.clone()));
            Picture { color: frame.color.clone(), alpha: None, depth, normal }
        };
        let geometry = compare_geometry(&picture(&self.expected), &picture(&self.found), None).unwrap().unwrap();
        let far = share(&self.expected, &self.found, 2.0 / 255.0);
        let objects = self.expected.object.iter().zip(&self.found.object);
        let others = objects.filter(|(a, b)| a != b).count() as f64 / self.found.object.len() as f64;
        println!("{geometry:?}; {far} of colours, {others} of numbers");
        assert!(geometry.covered > 4000 && geometry.silhouette() < 0.003, "{geometry:?}");
        assert!(geometry.depth.unwrap().p999 < 1e-4, "{geometry:?}");
        assert!(geometry.normal.unwrap().median < 0.1f64.to_radians(), "{geometry:?}");
        assert!(far < 0.003 && others < 0.003, "{far} of colours, {others} of numbers");
    }
}

fn ground() -> Mesh {
    let points = vec![[-60.0, 0.0, -90.0], [-60.0, 0.0, 30.0], [60.0, 0.0, 30.0], [60.0, 0.0, -90.0]];
    Mesh { points, triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() }
}

/// Draws a crowd both ways at a time, with a ground where there are shadows.
fn draw(device: &Device, crowd: &mut Crowd, on: &mut DeviceStandIns, (view, time, way): (&View, f64, Way)) -> Both {
    let seen = with_shadows(crowd, &seen_by(view, way), view);
    draw_seen(device, crowd, on, (view, time, &seen))
}

/// Draws what a view sees of a crowd both ways at a time.
fn draw_seen(
    device: &Device,
    crowd: &mut Crowd,
    on: &mut DeviceStandIns,
    (view, time, seen): (&View, f64, &CrowdView),
) -> Both {
    let (camera, settings) = (&view.camera, &view.settings);
    let context = Context::serial();
    let mut frame = Frame::default();
    crowd.cut(&context, seen, &mut frame).unwrap();
    let mut scene = Scene::new().unwrap();
    let shown = (&*crowd, &frame, time, camera.eye);
    let tag = |_: u32, _: &Cluster, number: u32, _: u32| number;
    StandIns::default().show(&context, &mut scene, shown, MATERIAL, &tag).unwrap();
    let on_ground = DeviceMesh::new(device, &ground(), &GROUND).unwrap();
    let mut placed = Vec::new();
    if settings.shadows.is_on() {
        let object = scene.add_object(DAffine3::IDENTITY, GROUND).unwrap();
        scene.set_mesh(object, 0, ground()).unwrap();
        let number = Some(u32::MAX - 2);
        placed.push(Placed { throws_shadows: false, number, ..Placed::new(Shape::Mesh(&on_ground), GROUND) });
    }
    let mut expected = scene.render(&context, view).unwrap();
    for object in expected.object.iter_mut().filter(|object| **object != NO_OBJECT) {
        // The caster's objects are the agents in view, one after the other.
        *object = frame.drawn.get(*object as usize).map_or(u32::MAX - 2, |drawn| drawn.0);
    }
    let counts = on.update(&context, crowd, (seen, time), None).unwrap();
    assert_eq!(u64::from(counts.triangles), frame.triangles);
    assert_eq!((counts.agents + counts.impostors) as usize, frame.drawn.len());
    assert_eq!(counts.impostors as usize, frame.impostors().len());
    assert_eq!(counts.posed, posed(crowd, &frame, time));
    placed.extend(on.placed(MATERIAL));
    let found = Rasterizer::new(device).unwrap().render(&placed, view).unwrap();
    Both { expected, found }
}

/// Returns how many vertices there are to pose: those of each cluster once for all agents that share its draw and their pose.
fn posed(crowd: &Crowd, frame: &Frame, time: f64) -> u32 {
    let mut list = DrawList::default();
    list.update(crowd, frame, time).unwrap();
    let parts = list.draws.iter().zip(&list.clusters).map(|(draw, [model, cluster])| {
        let instances = &list.instances[draw.first_instance as usize..][..draw.instance_count as usize];
        let poses: HashSet<u32> = instances.iter().map(|instance| instance.first_matrix).collect();
        let vertices: HashSet<u32> =
            crowd.models()[*model as usize].triangles(*cluster).as_flattened().iter().copied().collect();
        poses.len() * vertices.len()
    });
    parts.sum::<usize>() as u32
}

/// Returns the share of pixels of which some colour differs by more than `tolerance`.
fn share(a: &Pixels, b: &Pixels, tolerance: f32) -> f64 {
    let pixels = a.color.data().as_chunks::<3>().0.iter().zip(b.color.data().as_chunks::<3>().0);
    let far = pixels.filter(|(a, b)| (Vec3::from(**a) - Vec3::from(**b)).abs().max_element() > tolerance);
    far.count() as f64 / a.object.len() as f64
}

fn write(name: &str, both: &Both) {
    if let Ok(folder) = std::env::var("RELIEVO_PICTURES") {
        let folder = std::path::Path::new(&folder);
        for (kind, pixels) in [("caster", &both.expected), ("device", &both.found)] {
            relievo_render::write_png(&folder.join(format!("crowd_{name}_{kind}.png")), &pixels.color).unwrap();
        }
    }
}

#[test]
fn a_crowd_on_a_device_is_that_of_the_ray_caster() {
    let Some(device) = device() else { return };
    let mut crowd = crowd(Blend::Linear);
    let tag = |_: &CrowdModel, cluster: u32, _: u32| cluster;
    let mut on = DeviceStandIns::new(&device, &crowd, Look { tag: Some(&tag), lines: false }).unwrap();
    let mut view = view();
    for time in [0.0, 0.4] {
        let both = draw(&device, &mut crowd, &mut on, (&view, time, PLAIN));
        write(&format!("{time}"), &both);
        both.assert_alike();
        // One agent moves.
        let moved = Agent { transform: DAffine3::from_translation(DVec3::Z * 6.0), ..crowd.agents()[2] };
        crowd.set(2, moved).unwrap();
    }
    view.settings.shadows = Switch::ON;
    let both = draw(&device, &mut crowd, &mut on, (&view, 0.4, PLAIN));
    write("shadows", &both);
    // Maps have texels: the rims of shadows differ.
    let far = share(&both.expected, &both.found, 4.0 / 255.0);
    println!("{far} of colours with shadows");
    assert!(far < 0.03, "{far} of colours with shadows");
}

#[test]
fn agents_have_colours_and_lines_of_their_own_and_may_all_go() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut crowd = crowd(Blend::Linear);
    let mut on = DeviceStandIns::new(&device, &crowd, Look { tag: None, lines: true }).unwrap();
    let mut view = view();
    let mut drawn = |view: &View, seen: &CrowdView| {
        let counts = on.update(&context, &crowd, (seen, 0.0), None).unwrap();
        (counts, Rasterizer::new(&device).unwrap().render(&on.placed(MATERIAL), view).unwrap())
    };
    let camera = &view.camera;
    let seen = CrowdView::perspective(camera.eye, camera.axes, camera.fov, [240, 160], 0.5).unwrap();
    let (counts, plain) = drawn(&view, &seen);
    view.settings.wireframe = Switch::ON;
    let (_, lines) = drawn(&view, &seen);
    let far = share(&plain, &lines, 0.05);
    assert!(far > 0.01 && far < 0.5, "{far} of pixels have lines");
    assert!(plain.object.iter().any(|object| *object != NO_OBJECT) && plain.object == lines.object);
    // Nothing is left where all agents are behind a plane, or no agent is there.
    let away = CrowdView { planes: vec![[0.0, 0.0, 1.0, -1e4]], ..seen.clone() };
    let (none, empty) = drawn(&view, &away);
    assert!(none.agents == 0 && none.triangles == 0 && counts.agents > 50);
    assert!(empty.object.iter().all(|object| *object == NO_OBJECT));
    crowd.cut(&context, &seen, &mut Frame::default()).unwrap();
    let nobody = Crowd::new(crowd.models().to_vec());
    let counts = on.update(&context, &nobody, (&seen, 0.0), None).unwrap();
    assert_eq!(counts, Default::default());
}

#[test]
fn moving_vertices_weights_and_dual_quaternions_are_in_pictures() {
    let Some(device) = device() else { return };
    let (mut crowd, view) = (crowd(Blend::DualQuaternion), view());
    for agent in (1..120).step_by(6) {
        crowd.set_weights(agent, Some(&[1.5])).unwrap();
    }
    let tag = |_: &CrowdModel, cluster: u32, _: u32| cluster;
    let way = Way { pixels: 2.0, geomorph: true, ..PLAIN };
    let look = Look { tag: Some(&tag), lines: false };
    let mut on = DeviceStandIns::new(&device, &crowd, look).unwrap();
    let both = draw(&device, &mut crowd, &mut on, (&view, 0.4, way));
    write("moving", &both);
    both.assert_alike();
}

#[test]
fn impostors_on_a_device_are_those_of_the_ray_caster() {
    let Some(device) = device() else { return };
    let (mut crowd, mut view) = (crowd(Blend::Linear), view());
    let tag = |_: &CrowdModel, cluster: u32, _: u32| cluster;
    let look = Look { tag: Some(&tag), lines: false };
    let mut on = DeviceStandIns::new(&device, &crowd, look).unwrap();
    for (pixels, shadows) in [(3.0, Switch::OFF), (8.0, Switch::OFF), (8.0, Switch::ON)] {
        view.settings.shadows = shadows;
        let both = draw(&device, &mut crowd, &mut on, (&view, 0.4, Way { pixels, impostors: true, ..PLAIN }));
        write(&format!("impostors_{pixels}_{}", shadows.is_on()), &both);
        if shadows.is_on() {
            let far = share(&both.expected, &both.found, 4.0 / 255.0);
            println!("{far} of colours with shadows");
            assert!(far < 0.04, "{far} of colours with shadows");
        } else {
            both.assert_alike();
        }
    }
}

#[test]
fn agents_beside_a_picture_throw_their_shadows_into_it() {
    let Some(device) = device() else { return };
    let mut crowd = Crowd::new(vec![Arc::new(arm::built(16, 10))]);
    // To the left of the picture, behind the camera, far to the right, and in the middle.
    for place in [[-12.0, -6.0], [-2.0, 20.0], [60.0, -20.0], [1.0, -4.0]] {
        let transform = DAffine3::from_translation(DVec3::new(place[0], 0.0, place[1]));
        crowd.add(Agent { model: 0, clip: 0, phase: 0.0, transform }).unwrap();
    }
    let mut view = view();
    view.camera = Camera::look_at(DVec3::new(0.0, 5.0, 14.0), DVec3::new(0.0, 0.0, -6.0), DVec3::Y, 0.5).unwrap();
    view.settings.shadows = Switch::ON;
    // The second sun shines along the view, so that all agents may throw shadows into it.
    for (direction, thrower) in [([-0.9, 0.25, 0.0], 0), ([0.0, 0.12, 0.9], 1)] {
        view.lights.suns[0].direction = direction;
        let plain = seen_by(&view, PLAIN);
        let all = CrowdView { planes: Vec::new(), ..plain.clone() };
        let some = with_shadows(&crowd, &plain, &view);
        let mut frame = Frame::default();
        crowd.cut(&Context::serial(), &some, &mut frame).unwrap();
        let kept: Vec<u32> = frame.drawn.iter().map(|drawn| drawn.0).collect();
        assert!(kept.contains(&thrower) && kept.contains(&3) && kept.contains(&2) == (thrower == 1), "{kept:?}");
        let look = Look { tag: None, lines: false };
        let mut on = DeviceStandIns::new(&device, &crowd, look).unwrap();
        let [none, some, all] =
            [plain, some, all].map(|seen| draw_seen(&device, &mut crowd, &mut on, (&view, 0.0, &seen)));
        write(&format!("thrown_{thrower}"), &some);
        for (none, some, all) in
            [(&none.expected, &some.expected, &all.expected), (&none.found, &some.found, &all.found)]
        {
            // Nothing but the shadow is missing without it.
            assert_eq!(some.color.data(), all.color.data());
            let thrown = share(none, some, 0.02);
            assert!(thrown > 0.004 && thrown < 0.2, "{thrown} of pixels are in the shadow");
            assert!(some.object.iter().all(|object| *object != thrower), "{thrower} is in the picture");
        }
        let far = share(&some.expected, &some.found, 4.0 / 255.0);
        println!("{far} of colours differ");
        assert!(far < 0.03, "{far} of colours differ");
    }
}
