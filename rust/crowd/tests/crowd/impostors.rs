//! Impostors are within the error that may be seen, of their model in its pose.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec2, Vec3};
use relievo_core::Context;
use relievo_crowd::{Agent, Blend, Crowd, CrowdView, Drawn, Frame, Impostors, skin};
use relievo_testing::Random;

use crate::arm::built;

/// Returns where a camera at `eye` that looks at `target` sees a place, in pixels from the middle of its picture.
fn project(eye: DVec3, target: DVec3, pixels: f64, place: DVec3) -> DVec2 {
    let forward = (target - eye).normalize();
    let right = forward.any_orthonormal_vector();
    let (up, from) = (right.cross(forward), place - eye);
    DVec2::new(from.dot(right), from.dot(up)) * (pixels / from.dot(forward))
}

/// Returns the largest distance of a place of one list from the nearest of the other.
fn furthest(from: &[DVec2], to: &[DVec2]) -> f64 {
    let nearest = |place: &DVec2| to.iter().map(|other| other.distance_squared(*place)).fold(f64::INFINITY, f64::min);
    from.iter().map(nearest).fold(0.0, f64::max).sqrt()
}

#[test]
fn what_is_seen_of_an_impostor_is_what_is_seen_of_its_model() {
    let (context, model) = (Context::serial(), Arc::new(built(24, 12)));
    let mut random = Random(5);
    let (mut impostors, mut largest) = (Impostors::default(), 0.0f64);
    for round in 0..24 {
        let mut spread = |from: f64, to: f64| from + (to - from) * f64::from(random.unit());
        let mut crowd = Crowd::new(vec![Arc::clone(&model)]);
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, spread(0.0, 6.0), spread(-1.5, 1.5), spread(0.0, 6.0));
        let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(1.5), turn, DVec3::new(3.0, 1.0, -2.0));
        crowd.add(Agent { model: 0, clip: 0, phase: spread(0.0, 1.0), transform }).unwrap();
        let middle = 0.5 * (Vec3::from(model.low) + Vec3::from(model.high));
        let target = transform.transform_point3(middle.as_dvec3());
        // The nearest place from where it is one.
        let direction = DVec3::new(spread(-1.0, 1.0), spread(-1.0, 1.0), spread(-1.0, 1.0)).normalize();
        let mut away = 20.0;
        let (pixels, tolerance) = (300.0, 0.5);
        let (eye, frame) = loop {
            let eye = target + away * direction;
            let view = CrowdView {
                eye: eye.as_vec3().to_array(),
                pixels: pixels as f32,
                tolerance,
                impostors: true,
                ..CrowdView::default()
            };
            let mut frame = Frame::default();
            crowd.cut(&context, &view, &mut frame).unwrap();
            if frame.drawn[0].1 == Drawn::Impostor {
                break (eye, frame);
            }
            away *= 1.01;
            assert!(away < 1e5);
        };
        assert_eq!((frame.triangles, frame.clusters), (2, 0));
        // A few pixels: the box of all poses has 3 to 12.
        let size = 1.5 * f64::from(model.size()) * pixels / away;
        assert!((3.0..12.0).contains(&size), "{size} pixels");
        let found = impostors.of_frame(&context, (&crowd, &frame, 0.0), eye).unwrap();
        let (agent, impostor) = &found[0];
        assert!(*agent == 0 && found.len() == 1);
        let see =
            |place: [f32; 3]| project(eye, target, pixels, transform.transform_point3(Vec3::from(place).as_dvec3()));
        let texels: Vec<DVec2> = impostor.covered().flat_map(|(at, _)| impostor.corners(at).map(see)).collect();
        let pose = crowd.posed(&crowd.pose_key(0, 0.0)).into_owned();
        let points = skin(&context, &model.character, &pose, Blend::Linear).unwrap();
        // Corners, middles of edges and of triangles: they leave gaps of a tenth of a pixel.
        let mut surface = Vec::new();
        for triangle in model.input_clusters().iter().flat_map(|cluster| model.triangles(*cluster)) {
            let [a, b, c] = triangle.map(|vertex| Vec3::from(points[vertex as usize]));
            let places = [a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (a + b + c) / 3.0];
            surface.extend(places.map(|place| see(place.to_array())));
        }
        let (missing, more) = (furthest(&surface, &texels), furthest(&texels, &surface));
        assert!(missing < 0.5 && more < 0.6, "round {round}: {missing} and {more} pixels");
        largest = largest.max(missing.max(more));
    }
    // The bound is of use.
    assert!(largest > 0.1, "{largest}");
}

#[test]
fn covered_texels_have_the_area_of_what_is_seen() {
    let (context, model) = (Context::serial(), Arc::new(built(24, 12)));
    let (mut impostors, mut random, mut ratios) = (Impostors::default(), Random(11), Vec::new());
    for _ in 0..16 {
        let mut crowd = Crowd::new(vec![Arc::clone(&model)]);
        let phase = f64::from(random.unit());
        crowd.add(Agent { model: 0, clip: 0, phase, transform: DAffine3::IDENTITY }).unwrap();
        let direction = [0; 3].map(|_| 2.0 * random.unit() - 1.0);
        let eye = 1000.0 * Vec3::from(direction).normalize();
        let view = CrowdView { eye: eye.to_array(), pixels: 300.0, impostors: true, ..CrowdView::default() };
        let mut frame = Frame::default();
        crowd.cut(&context, &view, &mut frame).unwrap();
        let found = impostors.of_frame(&context, (&crowd, &frame, 0.0), eye.as_dvec3()).unwrap();
        let impostor = &found[0].1;
        let pose = crowd.posed(&crowd.pose_key(0, 0.0)).into_owned();
        let points = skin(&context, &model.character, &pose, Blend::Linear).unwrap();
        let side = impostor.texels.len().isqrt();
        const FINER: usize = 16;
        let scale = 0.5 * (side * FINER) as f32 / impostor.radius;
        let see = |vertex: u32| {
            let from = Vec3::from(points[vertex as usize]) - impostor.center;
            Vec2::new(impostor.axes[0].dot(from), impostor.axes[1].dot(from)) * scale
                + 0.5 * Vec2::splat((side * FINER) as f32)
        };
        let mut seen = vec![false; (side * FINER).pow(2)];
        for triangle in model.input_clusters().iter().flat_map(|cluster| model.triangles(*cluster)) {
            let [a, b, c] = triangle.map(see);
            let (low, high) = (a.min(b).min(c).floor(), a.max(b).max(c).ceil());
            for y in low.y as usize..high.y as usize {
                for x in low.x as usize..high.x as usize {
                    let place = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                    let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| (to - from).perp_dot(place - from));
                    let is_in = sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0);
                    seen[y * side * FINER + x] |= is_in;
                }
            }
        }
        let area = seen.iter().filter(|seen| **seen).count() as f32 / (FINER * FINER) as f32;
        ratios.push(impostor.covered().count() as f32 / area);
    }
    let mean = ratios.iter().sum::<f32>() / ratios.len() as f32;
    assert!((0.95..1.05).contains(&mean), "{mean}");
    assert!(ratios.iter().all(|ratio| (0.8..1.2).contains(ratio)), "{ratios:?}");
}

#[test]
fn agents_that_are_near_or_have_weights_are_none_and_pictures_are_shared() {
    let (context, model) = (Context::serial(), Arc::new(built(12, 8)));
    let mut crowd = Crowd::new(vec![model]);
    for z in [0.0, -400.0, -400.0, -401.0] {
        let transform = DAffine3::from_translation(DVec3::Z * z);
        crowd.add(Agent { model: 0, clip: 0, phase: 0.0, transform }).unwrap();
    }
    let view = CrowdView { eye: [0.0, 1.0, 8.0], pixels: 300.0, impostors: true, ..CrowdView::default() };
    let mut frame = Frame::default();
    let mut drawn = |view: &CrowdView| {
        crowd.cut(&context, view, &mut frame).unwrap();
        frame.drawn.iter().map(|drawn| drawn.1 == Drawn::Impostor).collect::<Vec<_>>()
    };
    assert_eq!(drawn(&view), [false, true, true, true]);
    assert_eq!(drawn(&CrowdView { geomorph: true, ..view.clone() }), [false, true, true, true]);
    assert_eq!(drawn(&CrowdView { impostors: false, ..view.clone() }), [false; 4]);
    drawn(&view);
    let eye = Vec3::from(view.eye).as_dvec3();
    let found = Impostors::default().of_frame(&context, (&crowd, &frame, 0.0), eye).unwrap();
    assert_eq!(found.iter().map(|(agent, _)| *agent).collect::<Vec<_>>(), [1, 2, 3]);
    assert!(Arc::ptr_eq(&found[0].1, &found[1].1));
}
