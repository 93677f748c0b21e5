//! Smoothing of meshes.

use glam::Vec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_fluid::{Smoothing, Surface, SurfaceFunction, mesh, smooth};

use crate::shapes::{floats, lattice, volume};

fn block() -> Mesh {
    let context = Context::serial();
    let points: Vec<[f32; 3]> =
        lattice(14, 0.02).iter().enumerate().map(|(at, [x, y, z])| [*x, *y, z + 0.004 * (at as f32).sin()]).collect();
    let surface = Surface::new(&context, &points, SurfaceFunction::density(0.01)).unwrap();
    mesh(&context, &surface, 0.01, &[], &mut Silent).unwrap()
}

/// The mean of squared sines between the normals of vertices and those of their neighbours.
fn roughness(mesh: &Mesh) -> f32 {
    let normals: Vec<Vec3> = floats(mesh, "normal").chunks(3).map(Vec3::from_slice).collect();
    let edges = mesh.corners.chunks(3).map(|triangle| (triangle[0] as usize, triangle[1] as usize));
    let sum: f32 = edges.map(|(a, b)| normals[a].cross(normals[b]).length_squared()).sum();
    sum / (mesh.corners.len() / 3) as f32
}

#[test]
fn steps_back_keep_the_volume_and_steps_forwards_shrink() {
    let context = Context::serial();
    let rough = block();
    let smoothed = |backwards| {
        let mut mesh = rough.clone();
        smooth(&context, &mut mesh, Smoothing { backwards, ..Smoothing::default() }, &mut Silent).unwrap();
        mesh.check().unwrap();
        assert_eq!(mesh.corners, rough.corners);
        for normal in floats(&mesh, "normal").chunks(3) {
            assert!((Vec3::from_slice(normal).length() - 1.0).abs() < 1e-5);
        }
        mesh
    };
    let (taubin, laplace) = (smoothed(0.53), smoothed(0.0));
    assert!((volume(&taubin) / volume(&rough) - 1.0).abs() < 0.005, "{}", volume(&taubin) / volume(&rough));
    assert!(volume(&laplace) < 0.98 * volume(&rough), "{}", volume(&laplace) / volume(&rough));
    assert!(roughness(&taubin) < 0.9 * roughness(&rough), "{} {}", roughness(&taubin), roughness(&rough));
}

#[test]
fn smoothing_does_not_depend_on_the_number_of_threads() {
    let meshes = [1, 2, 5].map(|threads| {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let mut mesh = block();
        smooth(&context, &mut mesh, Smoothing::default(), &mut Silent).unwrap();
        mesh
    });
    assert!(meshes[0] == meshes[1] && meshes[0] == meshes[2]);
}

#[test]
fn what_cannot_be_smoothed_is_refused_and_stays() {
    let context = Context::serial();
    let quad = Mesh::new(vec![[0.0; 3]; 4], vec![4], vec![0, 1, 2, 3]);
    let lost = Mesh::new(vec![[0.0; 3]; 3], vec![3], vec![0, 1, 7]);
    let short = Mesh::new(vec![[0.0; 3]; 3], vec![3], vec![0, 1]);
    for bad in [quad, lost, short] {
        assert!(smooth(&context, &mut bad.clone(), Smoothing::default(), &mut Silent).is_err());
    }
    let mut mesh = block();
    for (forwards, iterations) in [(f32::NAN, 1), (2.0, 1), (0.5, u32::MAX)] {
        let smoothing = Smoothing { iterations, forwards, ..Smoothing::default() };
        assert!(smooth(&context, &mut mesh, smoothing, &mut Silent).is_err());
    }
    let stop = &mut |done: f32, _: &str| done < 0.5;
    assert!(smooth(&context, &mut mesh, Smoothing::default(), stop).is_err());
    assert!(mesh == block());
    let mut none = Mesh::default();
    smooth(&context, &mut none, Smoothing::default(), &mut Silent).unwrap();
}
