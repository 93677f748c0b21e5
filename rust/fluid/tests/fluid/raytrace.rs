//! Rays against surfaces without a mesh: closed forms, meshes, blind particles, motion.

use std::sync::Arc;

use glam::Vec3;
use proptest::prelude::*;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_fluid::{Hit, March, Motion, Ray, RayCaster, Surface, SurfaceFunction, Trail, classify, mesh};

use crate::shapes::{FUNCTIONS, lattice};

fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin: origin.to_array(), direction: direction.to_array(), near: 0.0, far: f32::INFINITY, time: 0.0 }
}

fn still(surface: &Arc<Surface>) -> RayCaster {
    RayCaster::new(&Context::serial(), surface, Motion::default(), &[], March::default()).unwrap()
}

/// The distances at which a ray of a unit direction enters and leaves a sphere.
fn sphere(origin: Vec3, direction: Vec3, centre: Vec3, radius: f32) -> Option<[f32; 2]> {
    let middle = (centre - origin).dot(direction);
    let half = radius * radius - (origin + middle * direction - centre).length_squared();
    (half > 0.0).then(|| [middle - half.sqrt(), middle + half.sqrt()])
}

/// The first triangle that a ray meets: the distance, and the cosine between the ray and the normal.
fn first_triangle(mesh: &Mesh, triangles: &[[u32; 3]], origin: Vec3, direction: Vec3) -> Option<(f32, f32)> {
    let point = |at: u32| Vec3::from(mesh.points[at as usize]);
    let hits = triangles.iter().filter_map(|[a, b, c]| {
        let (a, u, v) = (point(*a), point(*b) - point(*a), point(*c) - point(*a));
        let normal = u.cross(v);
        let slope = normal.dot(direction);
        let distance = normal.dot(a - origin) / slope;
        let d = origin + distance * direction - a;
        let (s, t) = (d.cross(v).dot(normal), u.cross(d).dot(normal));
        let area = normal.length_squared();
        let inside = s >= 0.0 && t >= 0.0 && s + t <= area && distance > 0.0 && area > 0.0;
        inside.then(|| (distance, slope / area.sqrt()))
    });
    hits.min_by(|a, b| a.0.total_cmp(&b.0))
}

fn unit(angles: [f32; 2]) -> Vec3 {
    let (sine, cosine) = angles[0].sin_cos();
    let z = angles[1];
    Vec3::new((1.0 - z * z).sqrt() * cosine, (1.0 - z * z).sqrt() * sine, z)
}

proptest! {
    #[test]
    fn a_particle_alone_is_a_sphere(
        angles in (0.0f32..6.3, -1.0f32..1.0), aside in prop::array::uniform3(-0.12f32..0.12),
        far in 0.0f32..50.0, moved in prop::array::uniform3(-3.0f32..3.0), time in 0.0f32..0.1,
    ) {
        let (context, centre) = (Context::serial(), Vec3::new(1.0, -2.0, 0.5));
        let direction = unit([angles.0, angles.1]);
        for function in [SurfaceFunction::blobs(0.1), SurfaceFunction::zhu_bridson(0.1)] {
            let surface = Arc::new(Surface::new(&context, &[centre.to_array()], function).unwrap());
            let motion = Motion { velocities: &[moved], shutter: [0.0, 0.1] };
            let caster = RayCaster::new(&context, &surface, motion, &[], March::default()).unwrap();
            let now = centre + time * Vec3::from(moved);
            // From afar, or from inside.
            let origin = now + Vec3::from(aside) - far * direction;
            let found = caster.tracer(&mut Trail::default()).intersect(&Ray { time, ..ray(origin, 2.5 * direction) });
            match sphere(origin, direction, now, 0.1) {
                Some([enter, leave]) if leave - enter > 0.05 && leave > 1e-4 && enter.abs() > 1e-4 => {
                    let Some(hit) = found else { return Err(TestCaseError::fail("no hit")) };
                    let expected = if enter > 0.0 { enter } else { leave };
                    prop_assert!((hit.distance - expected).abs() < 3e-4, "{} {}", hit.distance, expected);
                    prop_assert_eq!(hit.enters, enter > 0.0);
                    let normal = (Vec3::from(hit.point) - now).normalize();
                    prop_assert!(Vec3::from(hit.normal).dot(normal) > 0.9999);
                    prop_assert!((Vec3::from(hit.velocity) - Vec3::from(moved)).length() < 1e-5);
                }
                // Thinner than a step.
                Some(_) => {}
                None => {
                    let close = found.is_none_or(|hit| Vec3::from(hit.point).distance(now) < 0.1003);
                    prop_assert!(close);
                }
            }
        }
    }
}

#[test]
fn two_blobs_are_met_where_their_sum_is_the_iso_value() {
    let function = SurfaceFunction::Blobs { support: 1.0, radius: 0.25, sharpness: 6.0 };
    let weight = |r: f32| if r < 1.0 { (-6.0 * r * r).exp() - (-6.0f32).exp() } else { 0.0 };
    let surface = Arc::new(Surface::new(&Context::serial(), &[[-0.3, 0.0, 0.0], [0.3, 0.0, 0.0]], function).unwrap());
    let caster = still(&surface);
    let value = |x: f32, y: f32| weight((x + 0.3).hypot(y)) + weight((x - 0.3).hypot(y)) - weight(0.25);
    for at in -10..=10 {
        let y = at as f32 * 0.02;
        let hit = caster.tracer(&mut Trail::default()).intersect(&ray(Vec3::new(-2.0, y, 0.0), Vec3::X)).unwrap();
        // The closed form by halving between outside and the first centre.
        let (mut from, mut to) = (-1.3f32, -0.3f32);
        for _ in 0..40 {
            let middle = 0.5 * (from + to);
            if value(middle, y) > 0.0 { to = middle } else { from = middle }
        }
        assert!((hit.distance - 2.0 - to).abs() < 1e-5, "{y} {} {to}", hit.distance);
    }
}

#[test]
fn places_of_hits_are_no_coarser_from_far_away() {
    for function in [SurfaceFunction::blobs(0.1), SurfaceFunction::zhu_bridson(0.1)] {
        let surface = Arc::new(Surface::new(&Context::serial(), &[[0.0; 3]], function).unwrap());
        for far in [1.0, 1e3, 1e6] {
            let hit =
                still(&surface).tracer(&mut Trail::default()).intersect(&ray(Vec3::new(-far, 0.06, 0.0), Vec3::X));
            assert!((hit.unwrap().point[0] + 0.08).abs() < 1e-5, "{far} {}", hit.unwrap().point[0]);
        }
    }
}

fn hits(caster: &RayCaster, rays: &[Ray]) -> Vec<Option<Hit>> {
    let mut trail = Trail::default();
    let mut tracer = caster.tracer(&mut trail);
    rays.iter().map(|ray| tracer.intersect(ray)).collect()
}

/// Rays from all around towards the middle of a box of this size at 0, and somewhat beside it.
fn rays(count: usize, size: f32) -> Vec<Ray> {
    let middle = Vec3::splat(0.5 * size);
    let ray_of = |at: usize| {
        let at = at as f32;
        let direction = unit([at * 2.399, (at * 0.618).fract() * 1.98 - 0.99]);
        let aside = Vec3::new((at * 0.37).sin(), (at * 0.73).sin(), (at * 1.13).sin()) * 0.4 * size;
        ray(middle + aside - 3.0 * size * direction, direction)
    };
    (0..count).map(ray_of).collect()
}

#[test]
fn hits_are_those_of_a_fine_mesh() {
    let context = Context::serial();
    let mut points = lattice(5, 0.2);
    points.extend((0..40).map(|at| [0.9, 0.5, 0.4].map(|step: f32| (at as f32 * step).sin() * 0.6 + 0.4)));
    for function in FUNCTIONS {
        let surface = Arc::new(Surface::new(&context, &points, function(0.1)).unwrap());
        let mesh = mesh(&context, &surface, 0.02, &[], &mut Silent).unwrap();
        let (triangles, rays) = (mesh.triangles(), rays(150, 0.8));
        let caster = still(&surface);
        let found = hits(&caster, &rays);
        for threads in [1, 2, 5] {
            let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
            assert_eq!(caster.intersect_all(&context, &rays), found);
        }
        let (mut same, mut compared) = (0, 0);
        for (ray, hit) in rays.iter().zip(found) {
            let Some((distance, slope)) = first_triangle(&mesh, &triangles, ray.origin.into(), ray.direction.into())
            else {
                continue;
            };
            if slope.abs() > 0.2 {
                compared += 1;
                // Half a step of a twelfth of the support radius.
                same += usize::from(hit.is_some_and(|hit| (hit.distance - distance).abs() < 0.5 * 0.4 / 12.0));
            }
        }
        // Drops and rims that a step leaps over are few.
        assert!(
            compared > 80 && same * 100 >= compared * 97,
            "{function:?} {same} of {compared}",
            function = surface.function()
        );
    }
}

#[test]
fn leaps_through_the_fluid_change_no_hit() {
    let context = Context::serial();
    let middle = Vec3::splat(11.5 * 0.02);
    let shaken = |point: [f32; 3]| Vec3::from(point) + 0.003 * (Vec3::from(point) * 9e3).map(f32::sin);
    let points = lattice(24, 0.02).into_iter().map(shaken);
    // With a hollow within.
    let points: Vec<[f32; 3]> = points.filter(|at| at.distance(middle) > 0.07).map(Vec3::into).collect();
    for function in FUNCTIONS {
        let surface = Arc::new(Surface::new(&context, &points, function(0.01)).unwrap());
        // Where particles have velocities there are no leaps.
        let motion = Motion { velocities: &vec![[0.0; 3]; points.len()], shutter: [0.0; 2] };
        let steps = RayCaster::new(&context, &surface, motion, &[], March::default()).unwrap();
        let leaps = still(&surface);
        let near_middle = |given: Ray| {
            ray(Vec3::from(given.origin).lerp(middle - 1.38 * Vec3::from(given.direction), 0.6), given.direction.into())
        };
        let outside: Vec<Ray> = rays(300, 23.0 * 0.02).into_iter().map(near_middle).collect();
        let entered = hits(&leaps, &outside);
        let inside = outside
            .iter()
            .zip(&entered)
            .filter_map(|(ray, hit)| hit.map(|hit| Ray { origin: hit.point, near: 1e-3, ..*ray }));
        let inside: Vec<Ray> = inside.collect();
        let (expected, found) = (hits(&steps, &inside), hits(&leaps, &inside));
        let same = |(expected, found): &(&Option<Hit>, &Option<Hit>)| match (expected, found) {
            (Some(expected), Some(found)) => {
                (expected.distance - found.distance).abs() < 1e-5 && expected.enters == found.enters
            }
            (expected, found) => expected.is_none() && found.is_none(),
        };
        // Places where the march only grazes the surface are few.
        let same = expected.iter().zip(&found).filter(same).count();
        assert!(same * 100 >= inside.len() * 99, "{same} of {}", inside.len());
        let close = |hit: &&Hit| Vec3::from(hit.point).distance(middle) < 0.08 && !hit.enters;
        let met = found.iter().flatten().filter(close).count();
        assert!(met >= 5, "{met} rays meet the hollow");
        // What one ray finds of the cubes is of use to the next and changes nothing.
        assert_eq!(hits(&leaps, &inside), found);
    }
}

#[test]
fn blind_particles_hide_what_was_left_out() {
    let context = Context::serial();
    let points = lattice(24, 0.02);
    let size = 23.0 * 0.02;
    for function in [SurfaceFunction::blobs(0.01), SurfaceFunction::zhu_bridson(0.01), SurfaceFunction::density(0.01)] {
        let surface = Arc::new(Surface::new(&context, &points, function).unwrap());
        let classes = classify(&context, &points, &surface, None, &mut Silent).unwrap();
        let kept: Vec<usize> = classes.indices().collect();
        assert!(kept.len() < points.len());
        let few: Vec<[f32; 3]> = kept.iter().map(|at| points[*at]).collect();
        let blind: Vec<bool> = kept.iter().map(|at| classes.of[*at] == relievo_fluid::Visibility::Blind).collect();
        let reduced = Arc::new(Surface::new(&context, &few, function).unwrap());
        let caster = RayCaster::new(&context, &reduced, Motion::default(), &blind, March::default()).unwrap();
        let all = still(&surface);
        let outside = rays(300, size);
        // From the middle, where nothing is left, and on from behind the first hit.
        let inside: Vec<Ray> = outside.iter().map(|ray| Ray { origin: [0.5 * size; 3], ..*ray }).collect();
        for rays in [&outside, &inside] {
            let (expected, found) = (hits(&all, rays), hits(&caster, rays));
            for (expected, found) in expected.iter().zip(&found) {
                assert_eq!(expected.is_some(), found.is_some(), "{function:?}");
                if let (Some(expected), Some(found)) = (expected, found) {
                    let far = (expected.distance - found.distance).abs();
                    assert!(far < 1e-5 && expected.enters == found.enters, "{function:?} {far}");
                }
            }
        }
        // Without the flags the inner side of the layer shows.
        let bare = hits(&still(&reduced), &inside);
        assert!(
            bare.iter()
                .zip(hits(&all, &inside))
                .all(|(bare, all)| bare.unwrap().distance < all.unwrap().distance - 0.02)
        );
    }
}

#[test]
fn bad_rays_meet_nothing_and_bad_input_is_refused() {
    let context = Context::serial();
    let surface = Arc::new(Surface::new(&context, &[[0.0; 3]; 2], SurfaceFunction::blobs(0.1)).unwrap());
    let caster = still(&surface);
    let good = ray(Vec3::new(-1.0, 0.0, 0.0), Vec3::X);
    assert!(caster.tracer(&mut Trail::default()).intersect(&good).is_some());
    let nan = [f32::NAN, 0.0, 0.0];
    for bad in [
        Ray { origin: nan, ..good },
        Ray { direction: nan, ..good },
        Ray { direction: [0.0; 3], ..good },
        Ray { near: f32::INFINITY, ..good },
        Ray { far: 0.5, ..good },
        Ray { far: f32::NAN, ..good },
        Ray { time: f32::NAN, ..good },
        Ray { near: 1.5, ..good },
        Ray { origin: [f32::MAX, 0.0, 0.0], ..good },
    ] {
        assert_eq!(caster.tracer(&mut Trail::default()).intersect(&bad), None);
    }
    let make = |velocities: &[[f32; 3]], shutter, blind: &[bool], steps| {
        RayCaster::new(&context, &surface, Motion { velocities, shutter }, blind, March { steps }).is_err()
    };
    assert!(make(&[[0.0; 3]], [0.0; 2], &[], 8.0) && make(&[nan; 2], [0.0; 2], &[], 8.0));
    assert!(make(&[], [1.0, 0.0], &[], 8.0) && make(&[], [0.0, f32::NAN], &[], 8.0));
    assert!(make(&[], [0.0; 2], &[true], 8.0) && make(&[], [0.0; 2], &[], 0.0) && make(&[], [0.0; 2], &[], f32::NAN));
    let none = Arc::new(Surface::new(&context, &[], SurfaceFunction::blobs(0.1)).unwrap());
    assert_eq!(still(&none).tracer(&mut Trail::default()).intersect(&good), None);
}
