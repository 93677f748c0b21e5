//! Meshes of surface functions: closed forms, watertightness, volumes, and what is refused.

use std::collections::HashMap;

use glam::Vec3;
use proptest::prelude::*;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, ErrorKind, Mesh, Result};
use relievo_fluid::{Channel, Surface, SurfaceFunction, mesh};

use crate::shapes::{FUNCTIONS, floats, lattice, volume};

fn make(points: &[[f32; 3]], function: SurfaceFunction, cell: f32) -> Result<Mesh> {
    let context = Context::serial();
    mesh(&context, &Surface::new(&context, points, function)?, cell, &[], &mut Silent)
}

/// Panics unless every edge is in two triangles of opposite directions, and the triangles of each vertex are one fan.
fn assert_manifold(mesh: &Mesh) {
    mesh.check().unwrap();
    let mut edges = HashMap::new();
    let mut fans = vec![HashMap::new(); mesh.points.len()];
    for [a, b, c] in mesh.triangles() {
        for [from, to, apex] in [[a, b, c], [b, c, a], [c, a, b]] {
            assert!(edges.insert((from, to), ()).is_none(), "edge {from} {to} is in two triangles of one direction");
            fans[apex as usize].insert(from, to);
        }
    }
    for (from, to) in edges.keys() {
        assert!(edges.contains_key(&(*to, *from)), "edge {from} {to} is open");
    }
    for (vertex, fan) in fans.iter().enumerate() {
        let start = *fan.keys().next().unwrap_or_else(|| panic!("vertex {vertex} has no triangle"));
        let mut at = fan[&start];
        let mut steps = 1;
        while at != start {
            at = fan[&at];
            steps += 1;
        }
        assert_eq!(steps, fan.len(), "vertex {vertex} has two fans");
    }
}

#[test]
fn a_particle_alone_is_a_sphere() {
    let centre = Vec3::new(0.31, -0.72, 1.13);
    for function in [SurfaceFunction::blobs(0.1), SurfaceFunction::zhu_bridson(0.1)] {
        for cell in [0.04f32, 0.02, 0.01] {
            let mesh = make(&[centre.to_array()], function, cell).unwrap();
            assert_manifold(&mesh);
            // A chord of the weights is off by their second derivative times the square of the cell.
            let bound = 12.0 * cell * cell;
            for (point, normal) in mesh.points.iter().zip(floats(&mesh, "normal").chunks(3)) {
                let from = Vec3::from(*point) - centre;
                assert!((from.length() - 0.1).abs() < bound, "{function:?} {cell} {}", from.length());
                assert!(from.normalize().dot(Vec3::from_slice(normal)) > 0.99999);
            }
            let sphere = 4.0 / 3.0 * std::f64::consts::PI * 1e-3;
            assert!((volume(&mesh) / sphere - 1.0).abs() < 40.0 * f64::from(cell), "{}", volume(&mesh) / sphere);
        }
    }
}

#[test]
fn two_blobs_melt_together_where_their_sum_is_the_iso_value() {
    let function = SurfaceFunction::Blobs { support: 1.0, radius: 0.25, sharpness: 6.0 };
    let weight = |r: f32| (-6.0 * r * r).exp() - (-6.0f32).exp();
    // Half way between two centres at ±x the sum is 2 w(x).
    let touching = {
        let half = 0.5 * (weight(0.25) + 2.0 * (-6.0f32).exp());
        (-half.ln() / 6.0).sqrt()
    };
    for (half, parts) in [(touching - 0.01, 1), (touching + 0.01, 2)] {
        let mesh = make(&[[-half, 0.0, 0.0], [half, 0.0, 0.0]], function, 0.01).unwrap();
        assert_manifold(&mesh);
        // The Euler characteristic of a sphere is 2.
        let characteristic = mesh.points.len() as i64 - mesh.face_count() as i64 / 2;
        assert_eq!(characteristic, 2 * parts, "{half}");
        for point in &mesh.points {
            let distances = [-half, half].map(|x| Vec3::from(*point).distance(Vec3::new(x, 0.0, 0.0)));
            let value = distances.map(|r| weight(r.min(1.0))).iter().sum::<f32>() - weight(0.25);
            assert!(value.abs() < 2e-3, "{value}");
        }
    }
}

#[test]
fn a_block_has_the_volume_of_its_particles() {
    // Of blobs, whose particles are spheres of their radius, blocks are larger; of means, smaller by their round edges.
    for (function, count, bound) in [
        (SurfaceFunction::density(0.01), 40, 0.005),
        (SurfaceFunction::zhu_bridson(0.01), 40, 0.015),
        (SurfaceFunction::blobs(0.01), 40, 0.04),
    ] {
        let mesh = make(&lattice(count, 0.02), function, 0.01).unwrap();
        let ratio = volume(&mesh) / (count as f64 * 0.02).powi(3);
        assert!((ratio - 1.0).abs() < bound, "{function:?} {ratio}");
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let mut points = lattice(12, 0.02);
    points
        .extend((0..200).map(|at| [(at % 17) as f32 * 0.071, (at % 23) as f32 * 0.053, 0.3 + (at % 7) as f32 * 0.04]));
    let velocities: Vec<f32> = points.iter().flatten().map(|value| value.sin()).collect();
    let channel = [Channel { name: "velocity", width: 3, values: &velocities }];
    for function in FUNCTIONS {
        let meshes = [1, 2, 5].map(|threads| {
            let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
            let surface = Surface::new(&context, &points, function(0.01)).unwrap();
            mesh(&context, &surface, 0.01, &channel, &mut Silent).unwrap()
        });
        assert!(meshes[0] == meshes[1] && meshes[0] == meshes[2]);
        assert_manifold(&meshes[0]);
    }
}

#[test]
fn channels_are_means_of_what_is_near() {
    let points = lattice(8, 0.02);
    let constant = vec![7.5; points.len()];
    let linear: Vec<f32> = points.iter().flat_map(|[x, y, _]| [*x, *y]).collect();
    let context = Context::serial();
    for function in FUNCTIONS {
        let surface = Surface::new(&context, &points, function(0.01)).unwrap();
        let channels = [
            Channel { name: "age", width: 1, values: &constant },
            Channel { name: "place", width: 2, values: &linear },
        ];
        let mesh = mesh(&context, &surface, 0.01, &channels, &mut Silent).unwrap();
        assert!(floats(&mesh, "age").iter().all(|value| (value - 7.5).abs() < 1e-5));
        for (point, place) in mesh.points.iter().zip(floats(&mesh, "place").chunks(2)) {
            assert!((point[0] - place[0]).abs() < 0.045 && (point[1] - place[1]).abs() < 0.045);
        }
    }
}

#[test]
fn no_particles_are_no_faces_and_one_point_is_one_blob() {
    for function in FUNCTIONS {
        let none = make(&[], function(0.1), 0.1).unwrap();
        assert!(none.points.is_empty() && none.corners.is_empty());
        let mesh = make(&[[1.0; 3]; 5000], function(0.1), 0.1).unwrap();
        assert_manifold(&mesh);
        assert!(volume(&mesh) > 0.0 && volume(&mesh) < 0.5, "{}", volume(&mesh));
    }
}

#[test]
fn what_cannot_be_meshed_is_refused() {
    let error = make(&[[0.0; 3], [0.0, f32::NAN, 0.0]], SurfaceFunction::density(0.1), 0.1).unwrap_err();
    assert!(error.to_string().contains("particle 1"), "{error}");
    for cell in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-6, 0.41] {
        let error = make(&[[0.0; 3]], SurfaceFunction::density(0.1), cell).unwrap_err();
        assert!(error.to_string().contains("cell size"), "{error}");
    }
    for far in [3e5, -3e5, f32::MAX, f32::MIN] {
        let error = make(&[[far, 0.0, 0.0]], SurfaceFunction::density(0.1), 0.1).unwrap_err();
        assert!(error.to_string().contains("from 0"), "{error}");
    }
    let context = Context::serial();
    let surface = Surface::new(&context, &[[0.0; 3]], SurfaceFunction::density(0.1)).unwrap();
    for (values, expected) in [(&[1.0][..], "numbers"), (&[1.0, f32::NAN][..], "finite")] {
        let channels = [Channel { name: "age", width: 2, values }];
        let error = mesh(&context, &surface, 0.1, &channels, &mut Silent).unwrap_err();
        assert!(error.to_string().contains("`age`") && error.to_string().contains(expected), "{error}");
    }
    let stop = &mut |_: f32, _: &str| false;
    assert_eq!(mesh(&context, &surface, 0.1, &[], stop).unwrap_err().kind, ErrorKind::Cancelled);
}

#[test]
fn a_memory_limit_holds() {
    // Far apart, so that the mesh is much larger than the particles.
    let points = lattice(10, 1.0);
    for limit in [1000, 100_000] {
        let context = Context::new(&ContextOptions { threads: 1, memory_limit: limit }).unwrap();
        let surface = Surface::new(&context, &points, SurfaceFunction::blobs(0.1)).unwrap();
        let error = mesh(&context, &surface, 0.02, &[], &mut Silent).unwrap_err();
        assert_eq!(error.kind, ErrorKind::Memory);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn sprays_are_watertight(
        points in prop::collection::vec(prop::array::uniform3(-1.0f32..1.0), 1..120),
        radius in 0.05f32..0.2, fineness in 1.0f32..5.0, far in prop::sample::select(vec![0.0f32, 1000.0]),
    ) {
        let points: Vec<[f32; 3]> = points.iter().map(|point| point.map(|value| value + far)).collect();
        let context = Context::serial();
        for function in FUNCTIONS {
            let surface = Surface::new(&context, &points, function(radius)).unwrap();
            let cell = 4.0 * radius / fineness;
            let mesh = mesh(&context, &surface, cell, &[], &mut Silent).unwrap();
            if !mesh.points.is_empty() {
                assert_manifold(&mesh);
            }
        }
    }
}
