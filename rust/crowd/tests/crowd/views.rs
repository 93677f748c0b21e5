//! Cuts for views: errors in pixels, culling, and independence of threads and of earlier frames.

use std::collections::HashSet;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions};
use relievo_crowd::{Agent, BuildSettings, Crowd, CrowdModel, CrowdView, DrawList, Drawn, Frame, ShadowSun};
use relievo_testing::Random;

use crate::arm::{built, character};
use crate::cuts::{borders, places};

const SIZE: [u32; 2] = [1280, 720];

fn crowd(model: &Arc<CrowdModel>, count: usize) -> Crowd {
    let mut crowd = Crowd::new(vec![model.clone()]);
    let mut random = Random(11);
    for _ in 0..count {
        let mut number = |range: f64| range * f64::from(random.unit() - 0.5);
        let place = DVec3::new(number(400.0), number(4.0), number(400.0));
        let turn = DQuat::from_rotation_y(number(6.0));
        let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(1.0 + number(1.0)), turn, place);
        crowd.add(Agent { model: 0, clip: 0, phase: number(1.0).abs(), transform }).unwrap();
    }
    crowd
}

fn view(eye: DVec3, heading: f64) -> CrowdView {
    CrowdView::perspective(eye, DMat3::from_rotation_y(heading), 0.9, SIZE, 0.5).unwrap()
}

#[test]
fn drawn_clusters_are_within_half_a_pixel_and_no_finer_than_needed() {
    let model = Arc::new(built(40, 20));
    let mut crowd = crowd(&model, 400);
    let view = view(DVec3::new(0.0, 2.0, 0.0), 0.3);
    let near = DMat3::from_rotation_y(0.3) * DVec3::new(0.0, 0.0, -4.0);
    crowd.add(Agent { transform: DAffine3::from_translation(near), ..crowd.agents()[0] }).unwrap();
    let mut frame = Frame::default();
    crowd.cut(&Context::serial(), &view, &mut frame).unwrap();
    let ladder = crowd.ladder(0).unwrap();
    let (low, high) = (Vec3::from(model.low), Vec3::from(model.high));
    let (mut steps, mut mixed, mut triangles) = (0, 0, 0);
    for (agent, drawn) in &frame.drawn {
        let transform = crowd.agents()[*agent as usize].transform;
        let scale = transform.matrix3.x_axis.length() as f32;
        let center = transform.transform_point3((0.5 * (low + high)).as_dvec3()).as_vec3();
        let radius = 0.5 * scale * low.distance(high);
        let near = (center.distance(Vec3::from(view.eye)) - radius).max(1e-3);
        let pixels = |error: f32| error * scale * view.pixels / near;
        triangles += model.triangle_count(crowd.clusters(&frame, (*agent, *drawn)));
        match drawn {
            Drawn::Step(step) => {
                steps += 1;
                assert!(pixels(ladder.error(*step)) <= 0.5 * (1.0 + 1e-4));
                let next = step + 1;
                assert!(next as usize == ladder.len() || pixels(ladder.error(next)) > 0.5 * (1.0 - 1e-4));
            }
            Drawn::Mixed { .. } => mixed += 1,
            Drawn::Impostor => panic!("agent {agent} is an impostor, which the view does not ask for"),
        }
    }
    assert!(steps > 50 && mixed > 0, "{steps}, {mixed}");
    assert_eq!(frame.triangles, triangles);
    assert!(frame.triangles * 2 < frame.drawn.len() as u64 * u64::from(model.input_triangles));
}

#[test]
fn agents_that_are_left_out_are_out_of_view() {
    let model = Arc::new(built(8, 8));
    let mut crowd = crowd(&model, 500);
    let mut frame = Frame::default();
    for turn in 0..20 {
        let (eye, heading) = (DVec3::new(3.0 * f64::from(turn), 3.0, -40.0), 0.31 * f64::from(turn));
        crowd.cut(&Context::serial(), &view(eye, heading), &mut frame).unwrap();
        let seen: Vec<u32> = frame.drawn.iter().map(|drawn| drawn.0).collect();
        let axes = DMat3::from_rotation_y(heading);
        let half = (0.45f64).tan();
        for (index, agent) in crowd.agents().iter().enumerate().filter(|(index, _)| !seen.contains(&(*index as u32))) {
            // No corner of the box, and no point between corners, is in the picture.
            for corner in 0..27u32 {
                let part = |axis: u32| f64::from(corner / 3u32.pow(axis) % 3) * 0.5;
                let mix = |at: usize, axis: u32| {
                    f64::from(model.low[at]) + part(axis) * f64::from(model.high[at] - model.low[at])
                };
                let place = agent.transform.transform_point3(DVec3::new(mix(0, 0), mix(1, 1), mix(2, 2))) - eye;
                let (x, y, depth) = (axes.x_axis.dot(place), axes.y_axis.dot(place), -axes.z_axis.dot(place));
                let wide = half * f64::from(SIZE[0]) / f64::from(SIZE[1]);
                let is_in = depth > 0.0 && x.abs() <= wide * depth && y.abs() <= half * depth;
                assert!(!is_in, "agent {index}, turn {turn}");
            }
        }
    }
}

#[test]
fn near_agents_are_cut_without_cracks_and_finer_where_they_are_nearer() {
    let model = Arc::new(built(60, 24));
    let mut crowd = Crowd::new(vec![model.clone()]);
    crowd.add(Agent { model: 0, clip: 0, phase: 0.0, transform: DAffine3::IDENTITY }).unwrap();
    let mut frame = Frame::default();
    let mut view = view(DVec3::new(0.0, 0.2, 1.0), 0.0);
    view.planes.clear();
    view.tolerance = 4.0;
    crowd.cut(&Context::serial(), &view, &mut frame).unwrap();
    let [(agent, drawn @ Drawn::Mixed { .. })] = frame.drawn[..] else { panic!("{:?}", frame.drawn) };
    let clusters = crowd.clusters(&frame, (agent, drawn));
    let depths: std::collections::BTreeSet<u32> =
        clusters.iter().map(|cluster| model.clusters[*cluster as usize].depth).collect();
    assert!(depths.len() > 1, "{depths:?}");
    let mut edges = std::collections::HashMap::new();
    let place = |vertex: u32| model.character.points[vertex as usize].map(|value| (value + 0.0).to_bits());
    for triangle in clusters.iter().flat_map(|cluster| model.triangles(*cluster)) {
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (place(triangle[from]), place(triangle[to]));
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
        }
    }
    assert!(edges.values().all(|count| *count == 0));
}

#[test]
fn a_million_agents_are_cut_and_drawn() {
    let mut crowd = Crowd::new(vec![Arc::new(built(12, 8))]);
    for index in 0..1_000_000_u32 {
        let place = DVec3::new(f64::from(index % 1000) - 500.0, 0.0, -f64::from(index / 1000));
        crowd.add(Agent { model: 0, clip: 0, phase: 0.0, transform: DAffine3::from_translation(place) }).unwrap();
    }
    let context = Context::new(&ContextOptions::default()).unwrap();
    let mut frame = Frame::default();
    crowd.cut(&context, &view(DVec3::new(0.0, 60.0, 40.0), 0.0), &mut frame).unwrap();
    let mut draws = DrawList::default();
    draws.update(&crowd, &frame, 0.0).unwrap();
    assert!(frame.drawn.len() > 100_000 && draws.instances.len() == frame.drawn.len());
    // Nearly all share a step's draws, and a pose.
    assert!(draws.draws.len() < 10_000 && draws.matrices.len() < 100_000, "{}", draws.draws.len());
}

#[test]
fn cuts_along_a_path_of_the_camera_have_no_cracks() {
    // Small clusters, because few triangles become one group, whose levels are never mixed.
    let robot = character("robot").map(|source| {
        let clip = source.animation("Robot_Walking").unwrap();
        let settings = BuildSettings { pose_rate: 6.0, cluster_triangles: 8, ..BuildSettings::default() };
        let context = Context::new(&ContextOptions::default()).unwrap();
        CrowdModel::build(&context, &source, &[clip], &settings, &mut Silent).unwrap()
    });
    for model in std::iter::once(built(60, 24)).chain(robot).map(Arc::new) {
        let places = places(&model.character);
        let triangles = |clusters: &[u32]| -> Vec<[u32; 3]> {
            clusters.iter().flat_map(|cluster| model.triangles(*cluster)).copied().collect()
        };
        let input = borders(&places, triangles(&model.input_clusters()).iter());
        let open: HashSet<u32> = input.keys().flat_map(|(a, b)| [*a, *b]).collect();
        let mut crowd = Crowd::new(vec![model.clone()]);
        crowd.add(Agent { model: 0, clip: 0, phase: 0.0, transform: DAffine3::IDENTITY }).unwrap();
        let (size, mut random) = (f64::from(model.size()), Random(5));
        let center = (0.5 * (Vec3::from(model.low) + Vec3::from(model.high))).as_dvec3();
        let (mut place, mut mixed, mut frame) = (DVec3::new(0.0, 0.2, 1.2) * size, HashSet::new(), Frame::default());
        for step in 0..200 {
            place += 0.06 * size * DVec3::from_array(std::array::from_fn(|_| f64::from(random.unit() - 0.5)));
            place = place.clamp_length_max(1.6 * size);
            let mut view = view(center + place, 0.0);
            // All of it, at errors between a fraction of a pixel and many.
            view.planes.clear();
            view.tolerance = 0.5 * 1.03f32.powi(step);
            crowd.cut(&Context::serial(), &view, &mut frame).unwrap();
            let clusters = crowd.clusters(&frame, frame.drawn[0]);
            let cut = borders(&places, triangles(clusters).iter());
            let cracks = cut.keys().filter(|(a, b)| !open.contains(a) || !open.contains(b)).count();
            assert_eq!(cracks, 0, "step {step}");
            let depths: HashSet<u32> = clusters.iter().map(|cluster| model.clusters[*cluster as usize].depth).collect();
            if depths.len() > 1 {
                mixed.insert(clusters.to_vec());
            }
        }
        assert!(mixed.len() > 5, "{} cuts of several levels", mixed.len());
    }
}

#[test]
fn frames_depend_neither_on_threads_nor_on_frames_before() {
    let model = Arc::new(built(30, 16));
    let path = |frame: usize| view(DVec3::new(0.4 * frame as f64, 2.0, 60.0 - frame as f64), 0.02 * frame as f64);
    let run = |threads: usize, skip: usize| {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let (mut crowd, mut frame) = (crowd(&model, 700), Frame::default());
        (0..40).step_by(skip).for_each(|at| crowd.cut(&context, &path(at), &mut frame).unwrap());
        crowd.cut(&context, &path(40), &mut frame).unwrap();
        (frame.drawn.clone(), frame.mixed.clone(), frame.triangles, frame.clusters)
    };
    let one = run(1, 1);
    assert_eq!(run(3, 1), one);
    assert_eq!(run(2, 40), one);
    let (mut crowd, mut frame) = (crowd(&model, 700), Frame::default());
    crowd.cut(&Context::serial(), &path(0), &mut frame).unwrap();
    assert_eq!(frame.changed, 700);
    crowd.cut(&Context::serial(), &path(0), &mut frame).unwrap();
    let near = frame.drawn.iter().filter(|(_, drawn)| matches!(drawn, Drawn::Mixed { .. })).count();
    assert_eq!(frame.changed as usize, near);
}

#[test]
fn agents_and_views_that_make_no_sense_are_refused() {
    let model = Arc::new(built(8, 8));
    let mut crowd = crowd(&model, 3);
    let agent = crowd.agents()[0];
    let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    let lost = DAffine3::from_translation(DVec3::NAN);
    for wrong in [
        Agent { model: 1, ..agent },
        Agent { clip: 1, ..agent },
        Agent { transform: flat, ..agent },
        Agent { transform: lost, ..agent },
        Agent { phase: f64::INFINITY, ..agent },
    ] {
        assert!(crowd.add(wrong).is_err(), "{wrong:?}");
    }
    assert!(crowd.set(3, agent).is_err());
    // Mirrors are transforms like others.
    crowd.add(Agent { transform: DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)), ..agent }).unwrap();
    let mut frame = Frame::default();
    let view = view(DVec3::Z, 0.0);
    for wrong in [
        CrowdView { tolerance: 0.0, ..view.clone() },
        CrowdView { tolerance: f32::NAN, ..view.clone() },
        CrowdView { pixels: -1.0, ..view.clone() },
        CrowdView { eye: [f32::NAN; 3], ..view.clone() },
        CrowdView { planes: vec![[f32::INFINITY; 4]], ..view },
    ] {
        assert!(crowd.cut(&Context::serial(), &wrong, &mut frame).is_err(), "{wrong:?}");
    }
}

#[test]
fn views_with_shadows_see_what_lies_towards_suns() {
    let mut random = Random(3);
    let (mut dropped, mut all) = (0, 0);
    for number in 0..40 {
        let mut unit = || 2.0 * f64::from(random.unit()) - 1.0;
        let eye = DVec3::new(unit(), unit(), unit()) * 20.0;
        let view = view(eye, 3.0 * unit());
        let suns: Vec<(DVec3, f64)> = (0..1 + number % 3)
            .map(|_| (DVec3::new(unit(), unit(), unit()).normalize(), (0.2 * unit()).max(0.0)))
            .collect();
        let given = suns.iter().map(|(towards, radius)| ShadowSun {
            towards: towards.as_vec3().to_array(),
            angular_radius: *radius as f32,
        });
        let seen = view.with_shadows(&given.collect::<Vec<_>>(), 0.5);
        assert!(seen.planes.len() <= 48);
        let is_seen = |planes: &[[f32; 4]], place: DVec3| {
            planes.iter().all(|[x, y, z, d]| place.as_vec3().dot(Vec3::new(*x, *y, *z)) + d >= -1e-3)
        };
        for _ in 0..200 {
            let place = eye + DVec3::new(unit(), unit(), unit()) * 30.0;
            if is_seen(&view.planes, place) {
                for (towards, radius) in &suns {
                    // A direction at the rim of the sun.
                    let side = towards.cross(DVec3::new(unit(), unit(), unit())).normalize_or_zero();
                    let towards = *towards * radius.cos() + side * radius.sin();
                    let thrower = place + towards * (50.0 * unit()).abs() + DVec3::new(unit(), unit(), unit()) * 0.25;
                    assert!(is_seen(&seen.planes, thrower), "{place} from {towards}");
                }
            }
            if suns.len() == 1 {
                all += 1;
                dropped += usize::from(!is_seen(&seen.planes, place));
            }
        }
    }
    println!("{dropped} of {all} places are left out");
    assert!(dropped > all / 2, "{dropped} of {all} places are left out");
    let everywhere = ShadowSun { towards: [0.0, 1.0, 0.0], angular_radius: 1.5 };
    assert!(view(DVec3::ZERO, 0.0).with_shadows(&[everywhere], 0.0).planes.is_empty());
    let same = view(DVec3::ZERO, 0.0);
    assert_eq!(same.with_shadows(&[], 0.0), same);
}
