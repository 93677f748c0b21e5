//! Meshes and spheres to level sets, and back.

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, ErrorKind};
use relievo_openvdb::peer::is_available;
use relievo_openvdb::{Class, Grid, Transform};

use crate::shapes::{cuboid, inside, level_set, volume};

#[test]
fn a_box_becomes_a_level_set_and_a_mesh_again() {
    if !is_available() {
        return;
    }
    let context = Context::serial();
    let grid = level_set([0.1, 0.2, 0.3], [1.1, 2.2, 0.8], 0.04);
    let info = grid.info().unwrap();
    assert_eq!((info.class, info.transform), (Class::LevelSet, Transform::uniform(0.04)));
    // Distances: at the middle of a face, beside it, and where the band ends.
    let values = grid.sample(&[[0.6, 1.0, 0.3], [0.6, 1.0, 0.35], [0.6, 1.0, 0.55], [0.6, 1.0, 0.1]], true).unwrap();
    let expected = [0.0, -0.05, -0.12, 0.12];
    assert!(values.iter().zip(expected).all(|(value, near)| (value - near).abs() < 1e-6), "{values:?}");
    let polygons = grid.polygons(&context, 0.0, 0.0, &mut Silent).unwrap();
    assert!(polygons.triangles.is_empty() && (volume(&polygons) - 1.0).abs() < 0.01, "{}", volume(&polygons));
    let coarse = grid.polygons(&context, 0.0, 0.5, &mut Silent).unwrap();
    let count = coarse.triangles.len() + coarse.quads.len();
    assert!(count * 4 < polygons.quads.len() && (volume(&coarse) - 1.0).abs() < 0.06, "{count} {}", volume(&coarse));
}

#[test]
fn results_do_not_depend_on_threads() {
    if !is_available() {
        return;
    }
    let (points, triangles) = cuboid([-1.0, -0.3, 0.0], [1.0, 0.7, 0.9]);
    let of = |threads| {
        let context = Context::new(&ContextOptions { threads, ..Default::default() }).unwrap();
        let transform = Transform::uniform(0.03);
        Grid::of_mesh(&context, &points, &triangles, &transform, [3.0; 2], &mut Silent).unwrap()
    };
    let block = |grid: &Grid| grid.block(&Context::serial(), [-40, -20, -8], [80, 60, 50]).unwrap();
    assert_eq!(block(&of(1)), block(&of(4)));
}

#[test]
fn spheres_have_their_volume() {
    if !is_available() {
        return;
    }
    let ball = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let of = |points: &[[f32; 3]], radii: &[f32]| {
        Grid::of_spheres(&Context::serial(), points, radii, 0.02, 3.0, &mut Silent)
    };
    let grid = of(&[[0.0; 3], [2.0, 0.0, 0.0]], &[0.5, 0.25]).unwrap();
    let expected = ball(0.5) + ball(0.25);
    assert!((inside(&grid, 0.0) / expected - 1.0).abs() < 0.01, "{}", inside(&grid, 0.0));
    for (points, radii) in [
        (&[[0.0; 3]][..], &[0.1, 0.2][..]),
        (&[[f32::NAN, 0.0, 0.0]], &[0.1]),
        (&[[0.0; 3]], &[-0.1]),
        (&[[1e30, 0.0, 0.0]], &[0.1]),
    ] {
        assert_eq!(of(points, radii).unwrap_err().kind, ErrorKind::Invalid);
    }
}

#[test]
fn what_cannot_be_or_is_too_large_is_refused_and_calls_can_be_cancelled() {
    if !is_available() {
        return;
    }
    let context = Context::serial();
    let (points, triangles) = cuboid([0.0; 3], [1.0; 3]);
    let of = |points: &[[f32; 3]], triangles: &[[u32; 3]], voxel: f64, band: f32| {
        Grid::of_mesh(&context, points, triangles, &Transform::uniform(voxel), [band; 2], &mut Silent)
            .map_err(|error| error.kind)
            .err()
    };
    assert_eq!(of(&points, &[[0, 1, 8]], 0.1, 3.0), Some(ErrorKind::Invalid));
    assert_eq!(of(&[[f32::INFINITY; 3]; 8], &triangles, 0.1, 3.0), Some(ErrorKind::Invalid));
    assert_eq!(of(&points, &triangles, 0.0, 3.0), Some(ErrorKind::Invalid));
    assert_eq!(of(&points, &triangles, f64::NAN, 3.0), Some(ErrorKind::Invalid));
    assert_eq!(of(&points, &triangles, 0.1, 0.0), Some(ErrorKind::Invalid));
    let small = Context::new(&ContextOptions { threads: 1, memory_limit: 1 << 20 }).unwrap();
    let transform = Transform::uniform(0.001);
    let error = Grid::of_mesh(&small, &points, &triangles, &transform, [3.0; 2], &mut Silent).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Memory);
    let mut reports = 0;
    let mut stop = |_: f32, _: &str| {
        reports += 1;
        false
    };
    let transform = Transform::uniform(0.02);
    let error = Grid::of_mesh(&context, &points, &triangles, &transform, [3.0; 2], &mut stop).unwrap_err();
    assert_eq!((error.kind, reports), (ErrorKind::Cancelled, 1));
    // Nothing but points, and no triangle.
    let empty = Grid::of_mesh(&context, &points, &[], &transform, [3.0; 2], &mut Silent).unwrap();
    assert_eq!(empty.info().unwrap().active_voxels, 0);
}
