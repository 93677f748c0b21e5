//! Culling by occlusion hides agents and changes no pixel of a picture, along a path through a crowd.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};
use relievo_core::{Context, ContextOptions};
use relievo_crowd::{Agent, Crowd, CrowdModel, CrowdView, Frame, Occlusion, PixelView, skin};

use crate::arm::{built, wrung};

const SIZE: [u32; 2] = [96, 64];
const FOV: f64 = 0.9;

/// A dense field of arms.
fn field(model: CrowdModel) -> Crowd {
    let mut crowd = Crowd::new(vec![Arc::new(model)]);
    for index in 0..150 {
        let place = DVec3::new(f64::from(index % 15) * 0.5 - 3.5, 0.0, -1.5 * f64::from(index / 15));
        let turn = glam::DQuat::from_rotation_y(0.7 * f64::from(index));
        let transform = DAffine3::from_scale_rotation_translation(DVec3::ONE, turn, place);
        crowd.add(Agent { model: 0, clip: 0, phase: 0.13 * f64::from(index), transform }).unwrap();
    }
    crowd
}

fn view_at(number: u32) -> (PixelView, CrowdView) {
    let share = f64::from(number) / 200.0;
    let eye = DVec3::new(4.0 * (6.0 * share).sin(), 1.2 + 0.4 * (9.0 * share).cos(), 5.0 - 3.0 * share);
    let axes = DMat3::from_rotation_y(0.3 * (5.0 * share).sin());
    let view = CrowdView::perspective(eye, axes, FOV, SIZE, 0.25).unwrap();
    (PixelView { eye, axes, fov: FOV, size: SIZE }, view)
}

/// Agent and depth at every pixel by rays through the middle of pixels.
fn picture(crowd: &Crowd, frame: &Frame, view: &PixelView, time: f64) -> Vec<(u32, f64)> {
    let context = Context::serial();
    let [width, height] = SIZE;
    let half = (0.5 * FOV).tan();
    let mut pixels = vec![(u32::MAX, f64::INFINITY); (width * height) as usize];
    for drawn in &frame.drawn {
        let agent = &crowd.agents()[drawn.0 as usize];
        let model = &crowd.models()[0];
        let posed =
            skin(&context, &model.character, &model.clips[0].poses[crowd.pose(agent, time)], model.blend).unwrap();
        let seen = |vertex: u32| {
            let place = agent.transform.transform_point3(Vec3::from(posed[vertex as usize]).as_dvec3());
            view.axes.transpose() * (place - view.eye)
        };
        for triangle in crowd.clusters(frame, *drawn).iter().flat_map(|cluster| model.triangles(*cluster)) {
            let [a, b, c] = triangle.map(seen);
            let normal = (b - a).cross(c - a);
            // The pixels of a box around the triangle; all of them if it reaches behind the camera.
            let column = |p: DVec3| 0.5 * f64::from(width) - 0.5 * f64::from(height) / half * p.x / p.z;
            let row = |p: DVec3| 0.5 * f64::from(height) + 0.5 * f64::from(height) / half * p.y / p.z;
            let is_before = [a, b, c].iter().all(|p| p.z < -0.01);
            let range = |at: &dyn Fn(DVec3) -> f64, most: u32| {
                let [p, q, r] = [a, b, c].map(at);
                let (low, high) = (p.min(q).min(r) - 1.0, p.max(q).max(r) + 1.0);
                if is_before { low.max(0.0) as u32..(high.max(0.0) as u32).min(most) } else { 0..most }
            };
            for y in range(&row, height) {
                for x in range(&column, width) {
                    let across = (f64::from(x) + 0.5 - 0.5 * f64::from(width)) * 2.0 * half / f64::from(height);
                    let up = (0.5 * f64::from(height) - f64::from(y) - 0.5) * 2.0 * half / f64::from(height);
                    let ray = DVec3::new(across, up, -1.0);
                    let depth = normal.dot(a) / normal.dot(ray);
                    let hit = ray * depth;
                    let inside =
                        [(a, b), (b, c), (c, a)].iter().all(|(p, q)| (*q - *p).cross(hit - *p).dot(normal) >= 0.0);
                    let known = &mut pixels[(y * width + x) as usize];
                    if inside && depth > 0.0 && depth < known.1 {
                        *known = (drawn.0, depth);
                    }
                }
            }
        }
    }
    pixels
}

#[test]
fn no_pixel_of_a_path_changes() {
    check_path(field(built(30, 16)), 1, 0.1);
}

#[test]
fn no_pixel_changes_by_dual_quaternions() {
    check_path(field(wrung(24, 12)), 4, 0.05);
}

/// Checks pictures of some of 200 frames, in which at least a share of all agents is hidden.
fn check_path(mut crowd: Crowd, step: usize, share: f64) {
    let contexts = [Context::serial(), Context::new(&ContextOptions { threads: 3, memory_limit: 0 }).unwrap()];
    let mut cullings = [Occlusion::default(), Occlusion::default()];
    let mut full = Frame::default();
    let (mut hidden, mut agents) = (0, 0);
    for number in (0..200).step_by(step) {
        let (pixels, view) = view_at(number);
        let time = f64::from(number) / 30.0;
        crowd.cut(&contexts[0], &view, &mut full).unwrap();
        let mut frame = full.clone();
        let found = cullings[0].cull(&contexts[0], &crowd, (&pixels, time), &mut frame).unwrap();
        let mut other = full.clone();
        assert_eq!(cullings[1].cull(&contexts[1], &crowd, (&pixels, time), &mut other).unwrap(), found);
        assert_eq!((&other.drawn, &other.mixed), (&frame.drawn, &frame.mixed));
        assert_eq!(frame.drawn.len() + found.hidden as usize, full.drawn.len());
        let count: u64 =
            frame.drawn.iter().map(|drawn| crowd.models()[0].triangle_count(crowd.clusters(&frame, *drawn))).sum();
        assert_eq!((frame.triangles, frame.triangles + found.hidden_triangles), (count, full.triangles));
        // Pictures of all frames of a whole path, and of some of others.
        if step == 1 || number % 20 == 0 {
            assert_eq!(picture(&crowd, &frame, &pixels, time), picture(&crowd, &full, &pixels, time), "frame {number}");
        }
        hidden += found.hidden;
        agents += full.drawn.len();
    }
    assert!(f64::from(hidden) > share * agents as f64, "{hidden} of {agents} agents were hidden");
}

/// A tall arm behind a row of small ones, which hide its lower part.
pub fn row() -> Crowd {
    let mut crowd = Crowd::new(vec![Arc::new(built(60, 24))]);
    for index in 0..17 {
        let (scale, place) = match index {
            0 => (6.0, DVec3::new(0.0, 0.0, -14.0)),
            _ => (1.0, DVec3::new(0.4 * f64::from(index) - 3.4, 0.0, -4.0)),
        };
        let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), glam::DQuat::IDENTITY, place);
        crowd.add(Agent { model: 0, clip: 0, phase: 0.0, transform }).unwrap();
    }
    crowd
}

#[test]
fn parts_of_an_agent_that_others_hide_are_not_drawn() {
    let context = Context::serial();
    for geomorph in [false, true] {
        let (mut crowd, mut culling, mut full) = (row(), Occlusion::default(), Frame::default());
        let mut hidden = 0;
        for number in 0..4 {
            let eye = DVec3::new(0.1 * f64::from(number), 1.2, 5.0);
            let axes = DMat3::IDENTITY;
            let pixels = PixelView { eye, axes, fov: FOV, size: SIZE };
            let mut view = CrowdView::perspective(eye, axes, FOV, SIZE, 0.02).unwrap();
            view.geomorph = geomorph;
            crowd.cut(&context, &view, &mut full).unwrap();
            let mut frame = full.clone();
            let found = culling.cull(&context, &crowd, (&pixels, 0.0), &mut frame).unwrap();
            assert!(found.hidden_clusters > 0 && found.hidden == 0, "{found:?}");
            assert_eq!(frame.triangles + found.hidden_triangles, full.triangles);
            assert_eq!(frame.clusters + found.hidden_clusters, full.clusters);
            assert_eq!(frame.blends.len(), if geomorph { frame.mixed.len() } else { 0 });
            // What was hidden is no occluder in the next frame.
            assert!(number == 0 || found.occluder_triangles < full.triangles);
            if !geomorph {
                assert_eq!(picture(&crowd, &frame, &pixels, 0.0), picture(&crowd, &full, &pixels, 0.0));
            }
            hidden += found.hidden_triangles;
        }
        assert!(hidden > full.triangles / 40, "{hidden} of four times {}", full.triangles);
    }
}

#[test]
fn culling_rests_where_nothing_is_hidden_and_refuses_bad_views() {
    let context = Context::serial();
    let mut crowd = Crowd::new(vec![Arc::new(built(12, 8))]);
    for place in [-6.0, 0.0, 6.0] {
        let transform = DAffine3::from_translation(DVec3::new(place, 0.0, -8.0));
        crowd.add(Agent { model: 0, clip: 0, phase: 0.0, transform }).unwrap();
    }
    let (pixels, view) = view_at(0);
    let mut culling = Occlusion::default();
    let mut frame = Frame::default();
    let mut rested = 0;
    for _ in 0..60 {
        crowd.cut(&context, &view, &mut frame).unwrap();
        let before = frame.drawn.len();
        let found = culling.cull(&context, &crowd, (&pixels, 0.0), &mut frame).unwrap();
        assert_eq!((found.hidden, frame.drawn.len()), (0, before));
        rested += u32::from(found.is_resting);
    }
    assert!((30..60).contains(&rested), "{rested}");
    for wrong in [PixelView { fov: f64::NAN, ..pixels }, PixelView { size: [0, 5], ..pixels }] {
        assert!(culling.cull(&context, &crowd, (&wrong, 0.0), &mut frame).is_err());
    }
}
