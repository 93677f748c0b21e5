//! Distances of meshes that share their points, pose after pose, beside single measurements.

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions};
use relievo_lod::{PosedDistance, distance};

/// A strip of squares along x, bent about y by an angle a unit of length, with bumps.
fn bent(angle: f32) -> Vec<[f32; 3]> {
    let point = |x: f32, y: f32| {
        let height = 1.0 / angle.max(1e-3) + 0.005 * (9.0 * x).sin() * (7.0 * y).cos();
        let turn = angle.max(1e-3) * x;
        [height * turn.sin(), y, height * turn.cos() - 1.0 / angle.max(1e-3)]
    };
    (0..=10).flat_map(|row| (0..=40).map(move |column| point(column as f32 * 0.1, row as f32 * 0.1))).collect()
}

/// Triangles of every `step`-th point of the strip.
fn triangles(step: u32) -> Vec<[u32; 3]> {
    let corners = (0..10 / step).flat_map(|row| (0..40 / step).map(move |column| step * (41 * row + column)));
    corners.flat_map(|a| [[a, a + step, a + 42 * step], [a, a + 42 * step, a + 41 * step]]).collect()
}

#[test]
fn bounds_in_all_poses_are_those_of_single_measurements() {
    let context = Context::serial();
    let (fine, coarse) = (triangles(1), triangles(5));
    let single =
        |points: &[[f32; 3]]| distance(&context, [(points, &fine), (points, &coarse)], &mut Silent).unwrap().at_most;
    let first = bent(0.0);
    let (mut posed, found) = PosedDistance::new(&context, &first, [&fine, &coarse], 0.0).unwrap();
    assert!((found / single(&first) - 1.0).abs() < 0.015, "{found}");
    let angles = [0.1, 0.3, 0.6, 0.9, 0.2, 1.2, 0.05, 0.0, 1.1, 0.7];
    let poses = angles.map(bent);
    let alone = angles.map(|angle| single(&bent(angle)));
    let bounds = posed.at_most(&context, &poses, 0.0).unwrap();
    for ((alone, bounded), angle) in alone.iter().zip(&bounds).zip(angles) {
        assert!(*bounded >= alone / 1.011 && *bounded <= alone * 1.011, "{bounded}, {alone} at {angle}");
    }
    let floor = 1.5 * found;
    for ((alone, bounded), angle) in alone.iter().zip(posed.at_most(&context, &poses, floor).unwrap()).zip(angles) {
        let right = bounded >= floor && bounded >= alone / 1.011 && bounded <= alone.max(floor) * 1.011;
        assert!(right, "{bounded}, {alone} at {angle}");
    }
    let most = alone.into_iter().fold(0.0, f32::max);
    let largest = posed.largest(&context, &poses, floor).unwrap();
    assert!((largest / most - 1.0).abs() < 0.011, "{largest}, {most}");
    assert!(most > 2.0 * found, "the strip bends beyond its bumps");
    let threads = Context::new(&ContextOptions { threads: 3, memory_limit: 0 }).unwrap();
    let (mut other, _) = PosedDistance::new(&threads, &first, [&fine, &coarse], 0.0).unwrap();
    assert_eq!(other.at_most(&threads, &poses, 0.0).unwrap(), bounds);
}

#[test]
fn triangles_that_gain_area_count_and_bad_points_are_refused() {
    let context = Context::serial();
    let coarse = [[0, 1, 2]];
    let fine = [[0, 1, 2], [0, 2, 3]];
    let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.5, 0.0]];
    let (mut posed, found) = PosedDistance::new(&context, &flat, [&coarse, &fine], 0.0).unwrap();
    assert!(found < 1e-6, "{found}");
    let mut raised = flat;
    raised[3] = [0.0, 0.5, 2.0];
    // Both lose their area in the first pose, the coarse one alone in the second.
    let none = vec![[0.0; 3]; 4];
    let mut one = vec![[0.0; 3]; 4];
    one[3] = [0.0, 1.0, 0.0];
    one[2] = [1.0, 1.0, 0.0];
    let found = posed.at_most(&context, &[none, one, raised.to_vec()], 0.1).unwrap();
    assert_eq!(found[..2], [0.1, f32::INFINITY]);
    assert!((2.0..2.03).contains(&found[2]), "{found:?}");
    raised[3][0] = f32::NAN;
    assert!(posed.at_most(&context, &[raised.to_vec()], 0.1).is_err());
    assert!(PosedDistance::new(&context, &flat, [&coarse, &[[0, 0, 1]]], 0.0).is_err());
}
